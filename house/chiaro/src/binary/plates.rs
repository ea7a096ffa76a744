//! A finished picture as the bytes of a file: PNG, PBM, TIFF or SVG.

use super::{Look, Picture};
use crate::colours::Colours;
use crate::film::Target;
use crate::vector::{self, Plate};
use chiaro_basis::{Error, Result};
use chiaro_binary::one_bit;
use chiaro_image::colour::to_byte;
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
            _ if target.is_animation() => Ok(Self::Png),
            "png" => Ok(Self::Png),
            "pbm" => Ok(Self::Pbm),
            "tif" | "tiff" => Ok(Self::Tiff),
            "svg" => Ok(Self::Svg),
            other => Err(Error::setting(
                "-o",
                format!(".{other}"),
                "a file name that ends in .png, .apng, .gif, .mp4, .webm, .svg, .pbm or .tif",
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
            Encoding::Tiff => self.tiff(&self.bits(picture, counts)?),
            Encoding::Pbm => Ok(codec::write_pbm(&self.bits(picture, counts)?)),
            Encoding::Png => self.png(picture, counts),
        }
    }

    /// The picture, or its stencil, as a screen shows it.
    pub(crate) fn shown(
        &self,
        picture: &Picture,
        counts: &mut Map<String, Value>,
    ) -> Result<Plane<[u8; 4]>> {
        let colours = &self.look.colours;
        if self.look.stencil.is_none() {
            return Ok(picture.coloured(colours));
        }
        let [ink, sheet] = [colours.ink, colours.paper].map(|c| c.map(to_byte));
        Ok(self.bits(picture, counts)?.map(|s| if *s { sheet } else { ink }))
    }

    fn png(&self, picture: &Picture, counts: &mut Map<String, Value>) -> Result<Vec<u8>> {
        let rgba = self.shown(picture, counts)?;
        if self.look.colours.are_grey() && picture.tint.is_none() {
            return codec::write_png_grey(&rgba.map(|p| p[0]), Some(self.recipe));
        }
        codec::write_png_rgba(&rgba, Some(self.recipe))
    }

    /// The picture, or its stencil, in one bit.
    fn bits(&self, picture: &Picture, counts: &mut Map<String, Value>) -> Result<Plane<bool>> {
        let colours = &self.look.colours;
        match &self.look.stencil {
            Some(stencil) => {
                let place = self.look.print.sheet.place(picture.covered.size())?;
                stencil.sheet(picture, colours, &place, counts)
            }
            None => Ok(one_bit(&picture.marks, &picture.lines, colours.paper_is_white())),
        }
    }

    fn tiff(&self, bits: &Plane<bool>) -> Result<Vec<u8>> {
        let dpi = self.look.print.sheet.place(bits.size())?.dpi();
        Ok(codec::write_tiff_bits(bits, dpi, Some(self.recipe)))
    }

    fn svg(&self, picture: &Picture, counts: &mut Map<String, Value>) -> Result<Vec<u8>> {
        let (colours, print) = (&self.look.colours, &self.look.print);
        if let Some(stencil) = &self.look.stencil {
            let place = print.sheet.place(picture.covered.size())?;
            let how = (colours, self.look.knobs);
            let sheets = stencil.sheets(picture, how, &place, counts)?;
            let text = (self.title, self.recipe);
            return vector::stencil(&sheets, stencil, self.look, text).map(String::into_bytes);
        }
        let two = [colours.ink, colours.paper];
        let plate = plate(picture, &two, colours);
        let (svg, travel) = vector::draw(&plate, self.look.knobs, print, self.title, self.recipe)?;
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
        map: picture.map.as_ref(),
        labels: &picture.labels,
        covered: &picture.covered,
        colours: if picture.palette.is_empty() { two } else { &picture.palette },
        lines: &picture.lines,
        scheme,
    }
}
