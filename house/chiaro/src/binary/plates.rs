//! A finished picture as the bytes of a file: PNG, PBM, TIFF or SVG.

use super::stencil::{sheet_count, stacked};
use super::{Look, Picture};
use crate::colours::Colours;
use crate::film::Target;
use crate::vector::{self, Plate, Print};
use chiaro_basis::{Error, Result};
use chiaro_binary::{Palette, one_bit};
use chiaro_image::colour::to_byte;
use chiaro_image::{Plane, codec};
use chiaro_ink::{Colour, Sheet};
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

    /// The paper that a picture without a size is to fill.
    pub(crate) fn fills(self, print: &Print) -> Option<Sheet> {
        let sheet = print.sheet;
        (self == Self::Tiff && sheet.paper.is_some() && sheet.fits).then_some(sheet)
    }

    /// Whether paper and pen change what a file holds.
    pub(crate) fn uses_paper(self) -> bool {
        matches!(self, Self::Svg | Self::Tiff)
    }
}

/// A stencil's sheet with its ink.
type Inked = (Colour, Plane<bool>);

/// What a file shows beside the picture itself.
pub(crate) struct Plates<'a> {
    pub(crate) look: &'a Look<'a>,
    pub(crate) title: &'a str,
    pub(crate) recipe: &'a str,
}

impl Look<'_> {
    /// How many files a picture becomes: a stencil of several colours is one a sheet where a file holds
    /// pixels.
    pub(crate) fn parts(&self, encoding: Encoding) -> Result<usize> {
        if self.stencil.is_none() || encoding == Encoding::Svg {
            return Ok(1);
        }
        let palette = Palette::parse(&self.knobs.palette, self.colours.ink, self.colours.paper)?;
        Ok(sheet_count(palette.colours().len()))
    }
}

impl Plates<'_> {
    /// The bytes of the files, as many as [`Look::parts`]; how far a pen has to go is added to `counts`.
    pub(crate) fn files(
        &self,
        encoding: Encoding,
        picture: &Picture,
        counts: &mut Map<String, Value>,
    ) -> Result<Vec<Vec<u8>>> {
        if encoding == Encoding::Svg {
            return Ok(vec![self.svg(picture, counts)?]);
        }
        let dpi = self.look.print.sheet.place(picture.covered.size())?.dpi();
        let bits = |bits: &Plane<bool>| match encoding {
            Encoding::Tiff => codec::write_tiff_bits(bits, dpi, Some(self.recipe)),
            _ => codec::write_pbm(bits),
        };
        let Some(sheets) = self.sheets(picture, counts)? else {
            if encoding == Encoding::Png {
                return Ok(vec![self.png(&picture.coloured(&self.look.colours), picture)?]);
            }
            let paper = self.look.colours.paper_is_white();
            return Ok(vec![bits(&one_bit(&picture.marks, &picture.lines, paper))]);
        };
        let file = |(ink, sheet): &Inked| match encoding {
            Encoding::Png => self.png(&self.coloured(*ink, sheet), picture),
            _ => Ok(bits(sheet)),
        };
        sheets.iter().map(file).collect()
    }

    /// The picture, or its stencils one below the other, as a screen shows it.
    pub(crate) fn shown(
        &self,
        picture: &Picture,
        counts: &mut Map<String, Value>,
    ) -> Result<Plane<[u8; 4]>> {
        let Some(sheets) = self.sheets(picture, counts)? else {
            return Ok(picture.coloured(&self.look.colours));
        };
        let sheets = sheets.iter().map(|(ink, sheet)| self.coloured(*ink, sheet));
        Ok(stacked(&sheets.collect::<Vec<_>>()))
    }

    /// The picture's stencils with their inks; none where it is to be a picture.
    fn sheets(
        &self,
        picture: &Picture,
        counts: &mut Map<String, Value>,
    ) -> Result<Option<Vec<Inked>>> {
        let Some(stencil) = &self.look.stencil else { return Ok(None) };
        let place = self.look.print.sheet.place(picture.covered.size())?;
        let how = (&self.look.colours, self.look.knobs);
        stencil.sheets(picture, how, &place, counts).map(Some)
    }

    /// A sheet in its ink on paper.
    fn coloured(&self, ink: Colour, sheet: &Plane<bool>) -> Plane<[u8; 4]> {
        let [ink, paper] = [ink, self.look.colours.paper].map(|c| c.map(to_byte));
        sheet.map(|s| if *s { paper } else { ink })
    }

    fn png(&self, rgba: &Plane<[u8; 4]>, picture: &Picture) -> Result<Vec<u8>> {
        if self.look.colours.are_grey() && picture.tint.is_none() {
            return codec::write_png_grey(&rgba.map(|p| p[0]), Some(self.recipe));
        }
        codec::write_png_rgba(rgba, Some(self.recipe))
    }

    fn svg(&self, picture: &Picture, counts: &mut Map<String, Value>) -> Result<Vec<u8>> {
        let (colours, print) = (&self.look.colours, &self.look.print);
        if let Some(sheets) = self.sheets(picture, counts)? {
            let text = (self.title, self.recipe);
            return vector::stencil(&sheets, self.look, text).map(String::into_bytes);
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
