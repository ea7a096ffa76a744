//! A finished picture as the bytes of a file: PNG, PBM, TIFF or SVG.

use crate::binary::{Colours, Encoding, Picture};
use crate::film::Target;
use crate::vector::{self, Plate, Print};
use chiaro_basis::Result;
use chiaro_binary::{BinaryKnobs, one_bit};
use chiaro_image::codec;
use serde_json::{Map, Value, json};

/// What a file shows beside the picture itself.
pub(crate) struct Plates<'a> {
    pub(crate) colours: &'a Colours,
    pub(crate) knobs: &'a BinaryKnobs,
    pub(crate) print: &'a Print,
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
            other => other.encode(picture, self.colours, self.recipe),
        }
    }

    fn tiff(&self, picture: &Picture) -> Result<Vec<u8>> {
        let marks = &picture.marks;
        let dpi = self.print.sheet.place(marks.white.size())?.dpi();
        let white = one_bit(marks, self.colours.paper_is_white());
        Ok(codec::write_tiff_bits(&white, dpi, Some(self.recipe)))
    }

    fn svg(&self, picture: &Picture, counts: &mut Map<String, Value>) -> Result<Vec<u8>> {
        let two = [self.colours.ink, self.colours.paper];
        let plate = Plate {
            labels: &picture.labels,
            covered: &picture.covered,
            colours: if picture.palette.is_empty() { &two } else { &picture.palette },
            lines: &picture.lines,
            scheme: self.colours,
        };
        let (svg, travel) = vector::draw(&plate, self.knobs, self.print, self.title, self.recipe)?;
        counts.insert("pen_down_mm".into(), json!(travel.down));
        counts.insert("pen_up_mm".into(), json!(travel.up));
        Ok(svg.into_bytes())
    }
}

/// Whether paper and pen change what a target's files hold.
pub(crate) fn uses_paper(target: &Target) -> bool {
    matches!(target.extension().as_str(), "svg" | "tif" | "tiff")
}
