//! A frame's strokes, each with its brush and its colour, in the order in which they are drawn.

use super::Shot;
use super::owners;
use super::picture::id_colour;
use super::style::{LineStyle, Subject};
use crate::colours::Colours;
use chiaro_ink::brush::{Axis, Brush, Grain, Knot, Mark, Spine, Stroke as Inked};
use chiaro_lines::parameter::drawn as drawn_lines;
use chiaro_lines::{FilmFrame, Kind, LinesKnobs, Owner, Stroke, Texture, View};
use chiaro_scene::Projection;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The light that a darkened base colour keeps.
const DARKENED: f32 = 0.55;

/// Half the octaves over which one size of a pattern fades into the next.
const FADE: f64 = 0.12;

/// A stroke ready to be drawn.
pub(crate) struct Drawn<'a> {
    pub(crate) stroke: Cow<'a, Stroke>,
    pub(crate) spine: Spine,
    pub(crate) brush: Arc<Brush>,
    pub(crate) colour: [f32; 4],
}

impl Drawn<'_> {
    /// As the painter wants it.
    pub(crate) fn inked<'s>(&'s self, style: &'s LineStyle) -> Inked<'s> {
        Inked {
            spine: &self.spine,
            brush: &self.brush,
            texture: style.texture(&self.brush),
            colour: self.colour,
            hides: self.stroke.visible && self.stroke.kind.occludes(),
            right: self.stroke.kind == Kind::Silhouette,
        }
    }
}

/// The names by which rules find objects, and their colours.
#[derive(Clone, Debug, Default)]
pub(crate) struct Names {
    /// Of each object of the frames: its node's and its mesh's.
    pub(crate) objects: Vec<String>,
    /// Of each material.
    pub(crate) materials: Vec<String>,
    /// Base colours of the materials, sRGB-encoded.
    pub(crate) colours: Vec<[f32; 3]>,
}

/// All strokes of a frame: hidden ones first, then kind after kind.
pub(crate) fn ready<'a>(
    shot: &'a Shot,
    frame: &'a FilmFrame,
    style: &LineStyle,
    colours: &Colours,
) -> Vec<Drawn<'a>> {
    let mut brushes: BTreeMap<(Kind, bool, Option<Owner>), Arc<Brush>> = BTreeMap::new();
    let mut brush_of = |stroke: &Stroke, owner: Option<Owner>| {
        let new = || Arc::new(style.brush_for(&subject(stroke, owner, &shot.names)));
        Arc::clone(brushes.entry((stroke.kind, stroke.visible, owner)).or_insert_with(new))
    };
    let surface = shot.film.surface.as_ref().map(|g| &g.surface);
    let mut drawn: Vec<Drawn<'a>> = Vec::new();
    let lines = drawn_lines(&frame.hidden).into_iter().chain(drawn_lines(&frame.strokes));
    let pieces: Vec<Cow<'a, Stroke>> = lines
        .flat_map(|stroke| match surface.filter(|_| style.minds_owners()) {
            Some(surface) => owners::pieces(stroke, surface, |s, owner| {
                let brush = brush_of(s, owner);
                let own = (brush.colour == "object").then(|| owner.map(|o| o.material)).flatten();
                (brush, own)
            }),
            None => vec![stroke],
        })
        .collect();
    for stroke in pieces {
        let brush = brush_of(&stroke, stroke.owner);
        let colour = colour(&brush, &stroke, &shot.names, colours);
        for (scale, ink) in scales(&stroke, &brush, &style.knobs) {
            let spine = spine(&stroke, &frame.view, scale);
            let [r, g, b, a] = colour;
            drawn.push(Drawn {
                stroke: stroke.clone(),
                spine,
                brush: Arc::clone(&brush),
                colour: [r, g, b, a * ink],
            });
        }
    }
    let place = |kind: Kind| Kind::ALL.iter().position(|k| *k == kind);
    let key = |d: &Drawn<'_>| (d.stroke.visible, place(d.stroke.kind), d.stroke.id);
    let first = |d: &Drawn<'_>| d.stroke.u.first().copied().unwrap_or(0.0);
    // Parts of one line keep their order from frame to frame.
    drawn.sort_by(|a, b| key(a).cmp(&key(b)).then(first(a).total_cmp(&first(b))));
    drawn
}

pub(super) fn subject<'a>(stroke: &Stroke, owner: Option<Owner>, names: &'a Names) -> Subject<'a> {
    let name = |list: &'a [String], index: Option<usize>| {
        index.and_then(|i| list.get(i)).map_or("", String::as_str)
    };
    Subject {
        kind: stroke.kind,
        visible: stroke.visible,
        object: name(&names.objects, owner.map(|o| o.object as usize)),
        material: name(&names.materials, owner.map(|o| o.material.index())),
    }
}

fn colour(brush: &Brush, stroke: &Stroke, names: &Names, colours: &Colours) -> [f32; 4] {
    match brush.colour.as_str() {
        "ink" => colours.ink,
        "paper" => colours.paper,
        "id" => {
            let [r, g, b] = id_colour(stroke.id);
            [r, g, b, 1.0]
        }
        "object" => {
            let own = stroke.owner.and_then(|o| names.colours.get(o.material.index()));
            own.map_or(colours.ink, |c| [c[0] * DARKENED, c[1] * DARKENED, c[2] * DARKENED, 1.0])
        }
        other => chiaro_image::colour::parse_colour(other).unwrap_or(colours.ink),
    }
}

/// Pixels for a unit of u, by which marks are spaced, and how much of the ink they have. Where
/// patterns grow with the zoom, they are redrawn at twice or half their size before they are half as
/// large again; around that, single marks fade from one size into the other. Solid lines have no marks
/// to redraw: what their noise does grows on, so that nothing ever changes at once.
fn scales(stroke: &Stroke, brush: &Brush, knobs: &LinesKnobs) -> Vec<(f64, f32)> {
    let pattern = f64::from(knobs.pattern_length);
    if !knobs.octaves || knobs.texture != Texture::Periodic {
        return vec![(stroke.pixels_per_u, 1.0)];
    }
    let solid = brush.grain == Grain::Solid && brush.picture.is_empty();
    if solid && matches!(brush.mark, Mark::Line | Mark::Double) {
        return vec![(stroke.pixels_per_u, 1.0)];
    }
    let grown = (stroke.pixels_per_u / pattern).max(1e-9).log2();
    let octave = grown.round();
    let beside = grown - octave;
    let other = ((beside.abs() - 0.5 + FADE) / (2.0 * FADE)).max(0.0) as f32;
    let at = |octave: f64, ink: f32| (pattern * octave.exp2(), ink);
    if other > 0.0 && matches!(brush.mark, Mark::Dashes | Mark::Dots) {
        vec![at(octave, 1.0 - other), at(octave + beside.signum(), other)]
    } else {
        vec![at(octave, 1.0)]
    }
}

/// A stroke's middle, u in pixels, with depths in pixels of their distance.
fn spine(stroke: &Stroke, view: &View, scale: f64) -> Spine {
    let depth = |depth: f64| match view.pose.projection {
        Projection::Perspective { .. } => {
            let focal = depth / view.pixel(depth).max(1e-12);
            focal * depth.max(1e-9).ln()
        }
        Projection::Orthographic { .. } => depth / view.pixel(depth).max(1e-12),
    };
    let knot = |(sample, u): (&chiaro_lines::Sample, &f64)| Knot {
        at: sample.at.as_vec2(),
        u: u * scale,
        depth: depth(sample.depth) as f32,
    };
    let mut knots: Vec<Knot> = stroke.samples.iter().zip(&stroke.u).map(knot).collect();
    let period = stroke.u_period.map(|p| p * scale).filter(|p| *p > 0.0);
    if let (true, Some(first)) = (stroke.closed, knots.first().copied()) {
        let around = period.or_else(|| Some(stroke.u.last()? * scale - first.u)).unwrap_or(0.0);
        knots.push(Knot { u: first.u + around, ..first });
    }
    // A part of a loop has the loop's noise and marks.
    let repeats = stroke.repeats.map(|p| p * scale).filter(|p| *p > 0.0);
    let period = if stroke.closed { period } else { repeats };
    let axis = Axis { seed: u64::from(stroke.texture()), period };
    Spine { goes_on: stroke.goes_on, ..Spine::new(knots, stroke.closed, axis) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lines::style::LineStyle;

    #[test]
    fn sizes_of_patterns_fade_into_each_other() {
        let knobs = LinesKnobs { octaves: true, pattern_length: 20.0, ..LinesKnobs::default() };
        let brush = Brush { mark: Mark::Dashes, ..LineStyle::default().brush };
        let stroke = |grown: f64| Stroke {
            id: 0,
            kind: Kind::Silhouette,
            chain: 0,
            owner: None,
            closed: false,
            visible: true,
            samples: Vec::new(),
            length: Vec::new(),
            u: Vec::new(),
            u_period: None,
            pixels_per_u: 20.0 * grown,
            component: None,
            repeats: None,
            body: None,
            goes_on: [false; 2],
            part: None,
        };
        let at = |grown: f64| scales(&stroke(grown), &brush, &knobs);
        assert_eq!(at(1.0), [(20.0, 1.0)]);
        assert_eq!(at(2.1), [(40.0, 1.0)]);
        // Just before and just after the change both sizes have half of the ink.
        let root = 2f64.sqrt();
        for (grown, own, next) in [(root - 1e-6, 20.0, 40.0), (root + 1e-6, 40.0, 20.0)] {
            let both = at(grown);
            assert_eq!([both[0].0, both[1].0], [own, next]);
            assert!(both.iter().all(|b| (b.1 - 0.5).abs() < 1e-3), "{both:?}");
        }
        let line = Brush { mark: Mark::Line, ..brush.clone() };
        assert_eq!(scales(&stroke(root), &line, &knobs), [(20.0 * root, 1.0)]);
    }
}
