//! Stencils of pictures: holes where the ink is, in a sheet of one piece.
//!
//! The picture in one bit, lines and all, becomes a sheet; what bridges cost is what the cut's weights
//! say of the pixels that they change. A palette has a sheet for each colour but the lightest, which is
//! the paper; lines are the darkest one's, and every pixel costs the same to a bridge. What bridges add
//! to the energy is said of all sheets together: a bridge is paper, a part left out is ink.

use super::Picture;
use crate::colours::Colours;
use chiaro_basis::{Error, Result};
use chiaro_binary::{BinaryKnobs, compose, one_bit};
use chiaro_image::Plane;
use chiaro_ink::{Colour, Placement, Stencil, StencilForm, stencil};
use serde_json::{Map, Value, json};

/// What a pixel beside the objects costs, where those of the objects cost 1.
const BESIDE: f32 = 0.3;

/// Bridges are at least so many pixels wide, or their borders are steps alone.
const LEAST_BRIDGE: f64 = 3.0;

/// What a stencil must hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cutting {
    /// Width of a bridge in millimetres.
    pub bridge: f64,
    /// Holes and loose parts smaller than a disc of this diameter, in millimetres, are left out.
    pub part: f64,
}

impl Cutting {
    /// For recipes.
    pub(crate) fn settings(&self) -> Value {
        json!({ "bridge": self.bridge, "smallest_part": self.part })
    }

    /// The sheet of a picture in ink and paper that lies on paper as `place` says; its measures go into
    /// `counts`.
    fn sheet(
        &self,
        picture: &Picture,
        colours: &Colours,
        place: &Placement,
        counts: &mut Map<String, Value>,
    ) -> Result<Plane<bool>> {
        let form = self.form(place)?;
        let given = one_bit(&picture.marks, &picture.lines, colours.paper_is_white());
        let prices = picture.graph.prices(&given, form.bridge);
        let made = stencil(&given, &prices, &form);
        report(&made, &given, picture, place, counts);
        Ok(made.sheet)
    }

    /// The sheets of a picture, one a colour: its ink's, or those of a palette's colours.
    ///
    /// # Errors
    /// [`Error::Setting`] for bridges too thin for the pixels.
    pub(crate) fn sheets(
        &self,
        picture: &Picture,
        (colours, knobs): (&Colours, &BinaryKnobs),
        place: &Placement,
        counts: &mut Map<String, Value>,
    ) -> Result<Vec<(Colour, Plane<bool>)>> {
        let Some(tariff) = &picture.tariff else {
            return Ok(vec![(colours.ink, self.sheet(picture, colours, place, counts)?)]);
        };
        let form = self.form(place)?;
        let (w, h) = picture.labels.size();
        let prices = picture.covered.map(|c| if *c { 1.0 } else { BESIDE });
        let blank = compose(&Plane::filled(w, h, 1.0), &picture.covered, &picture.lines, knobs);
        let no_line = one_bit(&blank, &picture.lines, true);
        let paper = lightest(&picture.palette);
        let (mut sheets, mut spans, mut added) = (Vec::new(), Vec::new(), 0);
        let uncut = tariff.energy(&picture.labels, &picture.graph);
        for (label, colour) in inks(&picture.palette) {
            let given = Plane::from_fn(w, h, |x, y| {
                let at = (x, y);
                let hole = picture.covered[at] && usize::from(picture.labels[at]) == label;
                !hole && (!sheets.is_empty() || no_line[at])
            });
            let made = stencil(&given, &prices, &form);
            spans.extend(made.bridges.iter().map(|b| f64::from(b.span) * place.scale));
            let changed = Plane::from_fn(w, h, |x, y| {
                let (at, own) = ((x, y), picture.labels[(x, y)]);
                match (given[at], made.sheet[at]) {
                    (false, true) if usize::from(own) == label => paper,
                    (true, false) => label as u8,
                    _ => own,
                }
            });
            added += tariff.energy(&changed, &picture.graph) - uncut;
            sheets.push((colour, made.sheet));
        }
        let mut put = |name: &str, value: Value| counts.insert(name.into(), value);
        put("stencils", json!(sheets.len()));
        put("bridges", json!(spans.len()));
        put("bridges_mm", json!(spans.iter().fold(0.0, |sum, span| sum + span)));
        put("longest_bridge_mm", json!(spans.into_iter().fold(0.0, f64::max)));
        put("stencil_energy", json!(added as f64 / f64::from(picture.graph.scale)));
        Ok(sheets)
    }

    /// Its measures in pixels.
    fn form(&self, place: &Placement) -> Result<StencilForm> {
        let bridge = self.bridge / place.scale;
        if bridge < LEAST_BRIDGE {
            let least = LEAST_BRIDGE * place.scale;
            let range = format!(
                "{least:.2}mm or more on this paper, three pixels of the picture; or a larger --size"
            );
            return Err(Error::setting("--stencil", format!("{}mm", self.bridge), range));
        }
        Ok(StencilForm { bridge: bridge as f32, part: (self.part / place.scale) as f32 })
    }
}

/// The colours of a palette with their places, from the darkest on.
fn by_lightness(palette: &[Colour]) -> Vec<(usize, Colour)> {
    let lightness = |c: &Colour| 0.299 * c[0] + 0.587 * c[1] + 0.114 * c[2];
    let mut all: Vec<(usize, Colour)> = palette.iter().copied().enumerate().collect();
    all.sort_by(|a, b| lightness(&a.1).total_cmp(&lightness(&b.1)));
    all
}

/// Those that are inks: all but the lightest. A palette of one colour is that ink's.
fn inks(palette: &[Colour]) -> Vec<(usize, Colour)> {
    let mut all = by_lightness(palette);
    all.truncate(sheet_count(palette.len()));
    all
}

/// How many sheets a palette of so many colours has; one without any.
pub(super) fn sheet_count(colours: usize) -> usize {
    colours.saturating_sub(1).max(1)
}

/// The place of the lightest colour of a palette: the paper.
fn lightest(palette: &[Colour]) -> u8 {
    by_lightness(palette).last().map_or(0, |(label, _)| *label as u8)
}

/// Sheets as one picture, one below the other.
pub(super) fn stacked<T: Clone>(sheets: &[Plane<T>]) -> Plane<T> {
    let width = sheets.first().map_or(0, Plane::width);
    let height = sheets.iter().map(Plane::height).sum();
    Plane::from_pixels(width, height, sheets.iter().flat_map(|s| s.pixels()).cloned().collect())
}

/// What was changed, and what that adds to the energy of the cut.
fn report(
    made: &Stencil,
    given: &Plane<bool>,
    picture: &Picture,
    place: &Placement,
    counts: &mut Map<String, Value>,
) {
    let (w, h) = given.size();
    let changed = |x: usize, y: usize| made.sheet[(x, y)] != given[(x, y)];
    let labels = Plane::from_fn(w, h, |x, y| {
        let at = (x, y);
        picture.covered[at] && if changed(x, y) { made.sheet[at] } else { picture.white[at] }
    });
    let graph = &picture.graph;
    let added = graph.energy(&labels) - graph.energy(&picture.white);
    let spans = made.bridges.iter().map(|b| f64::from(b.span));
    let mut put = |name: &str, value: Value| counts.insert(name.into(), value);
    put("bridges", json!(made.bridges.len()));
    put("bridges_mm", json!(spans.clone().fold(0.0, |sum, span| sum + span) * place.scale));
    put("longest_bridge_mm", json!(spans.fold(0.0, f64::max) * place.scale));
    put("parts_dropped", json!(made.dropped));
    put("holes_closed", json!(made.closed));
    put("stencil_energy", json!(added as f64 / f64::from(graph.scale)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::binary::Shot;
    use crate::project::{Options, Project};
    use chiaro_basis::Run;
    use chiaro_image::labels::components_by_sides;
    use chiaro_ink::Sheet;

    #[test]
    fn each_ink_of_a_palette_has_a_sheet_of_one_piece() {
        let run = Run::default();
        let options = Options { size: Some((160, 120)), ..Options::default() };
        let project = Project::open("demo:torus", options, &run).unwrap();
        let palette = "spot:#fff,#a33,#111".to_owned();
        let knobs = BinaryKnobs { palette, ..BinaryKnobs::default() };
        let shot = Shot::survey(&project, &knobs, &run).unwrap();
        let colours = Colours::default();
        let frame = project.pose(&project.poser(), 1, &run);
        let picture = shot.picture(&frame, 1, &colours, &run).unwrap();
        let place = Sheet::default().place((160, 120)).unwrap();
        let cutting = Cutting { bridge: 4.0 * place.scale, part: 0.0 };
        let mut counts = Map::new();
        let sheets = cutting.sheets(&picture, (&colours, &knobs), &place, &mut counts).unwrap();
        assert_eq!(sheets.len(), 2);
        assert!(sheets[0].0[0] < sheets[1].0[0], "the darkest comes first");
        for (_, sheet) in &sheets {
            let pieces = components_by_sides(sheet, &sheet.map(|_| true)).pieces;
            assert_eq!(pieces.iter().filter(|p| p.label).count(), 1);
            assert!(pieces.iter().any(|p| !p.label), "there are holes");
        }
        let added = counts["stencil_energy"].as_f64().unwrap();
        assert!(counts["bridges"].as_u64().unwrap() > 0 && added > 0.0, "bridges cost {added}");
        let all = stacked(&sheets.into_iter().map(|(_, sheet)| sheet).collect::<Vec<_>>());
        assert_eq!(all.size(), (160, 240));
    }
}
