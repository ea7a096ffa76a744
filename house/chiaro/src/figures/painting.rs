//! Figure 3.9: what strokes do to a picture.

use super::Figure;
use super::plate::Plate;
use chiaro_basis::{Result, Run};
use chiaro_binary::{BinaryKnobs, Strokes};
use chiaro_image::sheet::Sheet;

pub(super) const FIGURES: [Figure; 1] = [Figure {
    name: "3.9",
    title: "painting",
    message: "Strokes (green makes white, blue black) and what is learned from them alone; then a \
              picture by the sliders, strokes on it, and the two blended: strokes reach far beyond \
              the pixels they touch.",
    columns: 5,
    draw: strokes,
}];

/// Paint that makes a whole picture of the head.
const ALONE: &str = include_str!("alone.strokes");

/// Paint that mends the picture of the sliders: light in the shade of the face, black hair and neck.
const MENDING: &str = include_str!("mending.strokes");

fn strokes(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let plate = Plate::of("head", 480, &BinaryKnobs::default(), run)?;
    let alone = Strokes::parse("alone.strokes", ALONE)?;
    let mending = Strokes::parse("mending.strokes", MENDING)?;
    let knobs = BinaryKnobs::default();
    let tone = plate.tone(&knobs, run)?;
    sheet.add(plate.under_strokes(&tone, &alone)?, "strokes on the tone");
    sheet.add(plate.painted(&alone, 1.0, &knobs, run)?, "learned from them alone");
    let sliders = plate.ink(&knobs, run)?;
    sheet.add(sliders.clone(), "sliders alone");
    sheet.add(plate.under_strokes(&sliders, &mending)?, "strokes on it");
    sheet.add(plate.painted(&mending, 0.5, &knobs, run)?, "both, half and half");
    Ok(())
}
