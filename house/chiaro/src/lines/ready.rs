//! A frame's strokes, each with its brush and its colour, in the order in which they are drawn.

use super::Shot;
use super::picture::id_colour;
use super::style::{LineStyle, Subject};
use crate::colours::Colours;
use chiaro_ink::brush::{Axis, Brush, Knot, Spine, Stroke as Inked};
use chiaro_lines::{FilmFrame, Kind, LinesKnobs, Owner, Stroke, Texture, View};
use chiaro_scene::Projection;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The light that a darkened base colour keeps.
const DARKENED: f32 = 0.55;

/// A stroke ready to be drawn.
pub(crate) struct Drawn<'a> {
    pub(crate) stroke: &'a Stroke,
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
    let mut drawn: Vec<Drawn<'a>> = Vec::new();
    for stroke in frame.hidden.iter().chain(&frame.strokes) {
        let key = (stroke.kind, stroke.visible, stroke.owner);
        let brush = brushes
            .entry(key)
            .or_insert_with(|| Arc::new(style.brush_for(&subject(stroke, &shot.names))));
        let colour = colour(brush, stroke, &shot.names, colours);
        let spine = spine(stroke, &frame.view, &style.knobs);
        drawn.push(Drawn { stroke, spine, brush: Arc::clone(brush), colour });
    }
    let place = |kind: Kind| Kind::ALL.iter().position(|k| *k == kind);
    drawn.sort_by_key(|d| (d.stroke.visible, place(d.stroke.kind), d.stroke.id));
    drawn
}

fn subject<'a>(stroke: &Stroke, names: &'a Names) -> Subject<'a> {
    let name = |list: &'a [String], index: Option<usize>| {
        index.and_then(|i| list.get(i)).map_or("", String::as_str)
    };
    Subject {
        kind: stroke.kind,
        visible: stroke.visible,
        object: name(&names.objects, stroke.owner.map(|o| o.object as usize)),
        material: name(&names.materials, stroke.owner.map(|o| o.material.index())),
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

/// Pixels for a unit of u, by which marks are spaced. Where patterns grow with the zoom, they are
/// redrawn at twice or half their size before they are half as large again.
fn scale(stroke: &Stroke, knobs: &LinesKnobs) -> f64 {
    let pattern = f64::from(knobs.pattern_length);
    match knobs.octaves && knobs.texture == Texture::Periodic {
        true => pattern * (stroke.pixels_per_u / pattern).max(1e-9).log2().round().exp2(),
        false => stroke.pixels_per_u,
    }
}

/// A stroke's middle, u in pixels, with depths in pixels of their distance.
fn spine(stroke: &Stroke, view: &View, knobs: &LinesKnobs) -> Spine {
    let scale = scale(stroke, knobs);
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
    let axis = Axis { seed: u64::from(stroke.id), period: period.filter(|_| stroke.closed) };
    Spine::new(knots, stroke.closed, axis)
}
