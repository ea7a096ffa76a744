//! A finished picture as the bytes of a file: PNG, PBM, TIFF or SVG.

use super::{Look, Picture};
use crate::colours::Colours;
use crate::film::Target;
use crate::vector::{self, Plate};
use chiaro_basis::{Error, Result};
use chiaro_binary::one_bit;
use chiaro_image::{Plane, codec};
use chiaro_ink::Colour;
use serde_json::{Map, Value, json};

/// How a frame becomes bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Encoding {
    Png,
    Pbm,
    Tiff,
    Svg,
}

impl Encoding {
    pub(crate) fn of(target: &Target) -> Result<Self> {
        match target.extension().as_str() {
            "png" | "apng" => Ok(Self::Png),
            "pbm" => Ok(Self::Pbm),
            "tif" | "tiff" => Ok(Self::Tiff),
            "svg" => Ok(Self::Svg),
            other => Err(Error::setting(
                "-o",
                format!(".{other}"),
                "a file name that ends in .png, .apng, .svg, .pbm or .tif",
            )),
        }
    }

    /// Whether paper and pen change what a file holds.
    pub(crate) fn uses_paper(self) -> bool {
        matches!(self, Self::Svg | Self::Tiff)
    }
}

/// What a file shows beside the picture itself.
pub(crate) struct Plates<'a> {
    pub(crate) look: &'a Look<'a>,
    pub(crate) title: &'a str,
    pub(crate) recipe: &'a str,
}

impl Plates<'_> {
    /// The bytes of a file; how far a pen has to go is added to `counts`.
    pub(crate) fn bytes(
        &self,
        encoding: Encoding,
        picture: &Picture,
        counts: &mut Map<String, Value>,
    ) -> Result<Vec<u8>> {
        match encoding {
            Encoding::Svg => self.svg(picture, counts),
            Encoding::Tiff => self.tiff(picture),
            Encoding::Pbm => Ok(codec::write_pbm(&self.one_bit(picture))),
            Encoding::Png => self.png(picture),
        }
    }

    fn png(&self, picture: &Picture) -> Result<Vec<u8>> {
        let rgba = picture.coloured(&self.look.colours);
        if self.look.colours.are_grey() && picture.tint.is_none() {
            return codec::write_png_grey(&rgba.map(|p| p[0]), Some(self.recipe));
        }
        codec::write_png_rgba(&rgba, Some(self.recipe))
    }

    fn one_bit(&self, picture: &Picture) -> Plane<bool> {
        one_bit(&picture.marks, self.look.colours.paper_is_white())
    }

    fn tiff(&self, picture: &Picture) -> Result<Vec<u8>> {
        let dpi = self.look.print.sheet.place(picture.covered.size())?.dpi();
        Ok(codec::write_tiff_bits(&self.one_bit(picture), dpi, Some(self.recipe)))
    }

    fn svg(&self, picture: &Picture, counts: &mut Map<String, Value>) -> Result<Vec<u8>> {
        let colours = &self.look.colours;
        let two = [colours.ink, colours.paper];
        let plate = plate(picture, &two, colours);
        let (svg, travel) =
            vector::draw(&plate, self.look.knobs, &self.look.print, self.title, self.recipe)?;
        counts.insert("pen_down_mm".into(), json!(travel.down));
        counts.insert("pen_up_mm".into(), json!(travel.up));
        Ok(svg.into_bytes())
    }
}

/// A picture as vectors want it; `two` are ink and paper, where it has no palette of its own.
pub(crate) fn plate<'a>(
    picture: &'a Picture,
    two: &'a [Colour; 2],
    scheme: &'a Colours,
) -> Plate<'a> {
    Plate {
        labels: &picture.labels,
        covered: &picture.covered,
        colours: if picture.palette.is_empty() { two } else { &picture.palette },
        lines: &picture.lines,
        scheme,
    }
}
