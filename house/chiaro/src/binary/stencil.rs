//! Stencils of pictures: holes where the ink is, in a sheet of one piece.
//!
//! The picture in one bit, lines and all, becomes a sheet; what bridges cost is what the cut's weights
//! say of the pixels that they change.

use super::Picture;
use crate::colours::Colours;
use chiaro_basis::{Error, Result};
use chiaro_binary::one_bit;
use chiaro_image::Plane;
use chiaro_ink::{Placement, Stencil, StencilForm, stencil};
use serde_json::{Map, Value, json};

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

    /// The sheet of a picture that lies on paper as `place` says; its measures go into `counts`.
    ///
    /// # Errors
    /// [`Error::Setting`] for more colours than two, and for bridges too thin for the pixels.
    pub(crate) fn sheet(
        &self,
        picture: &Picture,
        colours: &Colours,
        place: &Placement,
        counts: &mut Map<String, Value>,
    ) -> Result<Plane<bool>> {
        if picture.tint.is_some() {
            let range = "no palette beside --stencil: a stencil has one ink";
            return Err(Error::setting("palette", "more colours than two", range));
        }
        let bridge = self.bridge / place.scale;
        if bridge < LEAST_BRIDGE {
            let least = LEAST_BRIDGE * place.scale;
            let range = format!(
                "{least:.2}mm or more on this paper, three pixels of the picture; or a larger --size"
            );
            return Err(Error::setting("--stencil", format!("{}mm", self.bridge), range));
        }
        let form = StencilForm { bridge: bridge as f32, part: (self.part / place.scale) as f32 };
        let given = one_bit(&picture.marks, &picture.lines, colours.paper_is_white());
        let prices = picture.graph.prices(&given, form.bridge);
        let made = stencil(&given, &prices, &form);
        report(&made, &given, picture, place, counts);
        Ok(made.sheet)
    }
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
    put("bridges_mm", json!(spans.clone().sum::<f64>() * place.scale));
    put("longest_bridge_mm", json!(spans.fold(0.0, f64::max) * place.scale));
    put("parts_dropped", json!(made.dropped));
    put("holes_closed", json!(made.closed));
    put("stencil_energy", json!(added as f64 / f64::from(graph.scale)));
}
