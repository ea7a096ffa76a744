//! Strokes with grain, torn edges or a picture, and double lines, as filled outlines, for vector files.
//!
//! Ink is looked at on a grid of thirds of a pixel, with haloes; where there is more of it than a
//! level is one tone, filled over those before it. Specks and streaks are there or not: two tones.
//! Washes and pictures are tones of a quarter each, which is all that outlines can say of them.

use super::contour::{Node, contours};
use super::grain::Inking;
use super::halo::Halos;
use super::knob::{Brush, Grain, Mark};
use super::marks::ribbons;
use super::paint::{Strip, Stroke, place};
use crate::Point;
use crate::fit::simplified;
use chiaro_basis::math::Vec2;
use std::collections::BTreeMap;

/// Nodes on a pixel's side.
const FINE: f32 = 3.0;
/// How far outlines may be from where they were found, pixels.
const TOLERANCE: f64 = 0.04;
/// The least area of a speck, square pixels.
const SPECK: f64 = 0.08;
/// How much of a pixel of distance a change of all the ink counts.
const STEEP: f32 = 0.5;

/// What is filled with one share of the ink.
#[derive(Clone, Debug, PartialEq)]
pub struct Tone {
    /// Outlines and holes, pixels, to be filled by the nonzero rule.
    pub outlines: Vec<Vec<Point>>,
    /// The share of the ink that is there when it lies over the tones before it.
    pub ink: f32,
}

/// The ink at a node: how far inside the border it is, pixels, and how much there is.
#[derive(Clone, Copy, Debug)]
struct Found {
    inside: f32,
    ink: f32,
}

impl Found {
    /// How far inside a tone it is, which begins over a level of ink.
    fn over(&self, level: f32) -> f32 {
        match level > 0.0 {
            true => self.inside.min((self.ink - level) * STEEP),
            false => self.inside,
        }
    }
}

/// How far inside each of up to four tones a node is, pixels.
type Tones = [f32; 4];

/// The tones of a stroke, the palest first; `None` for one that is even in its outlines.
pub fn tones(stroke: &Stroke<'_>, halos: &Halos) -> Option<Vec<Tone>> {
    let inking = Inking { brush: stroke.brush, texture: stroke.texture };
    // Of a double line the outlines of what is covered and of what is left out run into each other at turns.
    let is_double = stroke.brush.mark == Mark::Double;
    if inking.is_even() && stroke.brush.rough <= 0.0 && !is_double {
        return None;
    }
    let levels = levels(stroke.brush, inking.is_even());
    let nodes = nodes(stroke, &inking, halos, &levels);
    let tone = |(k, (_, ink)): (usize, &(f32, f32))| {
        let values = nodes.iter().map(|(n, tones)| (*n, tones[k])).collect();
        let outlines: Vec<_> = contours(&values).iter().filter_map(|p| outline(p)).collect();
        (!outlines.is_empty()).then_some(Tone { outlines, ink: *ink })
    };
    Some(levels.iter().enumerate().filter_map(tone).collect())
}

/// Over how much ink a tone begins, and how much it shows; four at most.
fn levels(brush: &Brush, even: bool) -> Vec<(f32, f32)> {
    let least = 1.0 - brush.grain_strength;
    match brush.grain {
        _ if even => vec![(0.0, 1.0)],
        Grain::Bristle | Grain::Charcoal | Grain::Pencil => {
            let pale = (least > 0.03).then_some((0.0, least));
            pale.into_iter().chain([(0.5 + 0.5 * least, 1.0)]).collect()
        }
        _ => (1..=4).map(|k| (k as f32 / 4.0 - 0.125, k as f32 / 4.0)).collect(),
    }
}

fn nodes(
    stroke: &Stroke<'_>,
    inking: &Inking<'_>,
    halos: &Halos,
    levels: &[(f32, f32)],
) -> BTreeMap<Node, Tones> {
    let mut all: BTreeMap<Node, Tones> = BTreeMap::new();
    for strip in ribbons(stroke.brush, stroke.spine).iter().map(Strip::of) {
        let mut nodes: BTreeMap<Node, Found> = BTreeMap::new();
        for piece in &strip.pieces {
            for (node, at) in around(piece.bounds(0.0)) {
                let Some(hit) = piece.hit(at, 0.5) else { continue };
                if strip.erases {
                    let taken = -hit.inside(0.0);
                    all.entry(node).and_modify(|tones| *tones = tones.map(|t| t.min(taken)));
                    continue;
                }
                let tear = inking.tear(&strip.axis, hit.u, hit.across > 0.0);
                let mut inside = hit.inside(tear.max(-0.8 * hit.half));
                if nodes.get(&node).is_some_and(|f| f.inside >= inside) {
                    continue;
                }
                if inside > 0.0 && halos.is_behind(at, hit.depth) {
                    inside = -0.25;
                }
                let seen = inside > -0.5;
                let ink = if seen { inking.ink(&strip.axis, &place(&hit, &strip)) } else { 0.0 };
                nodes.insert(node, Found { inside, ink });
            }
        }
        for (node, found) in nodes {
            let tones = all.entry(node).or_insert([f32::NEG_INFINITY; 4]);
            for (tone, (level, _)) in tones.iter_mut().zip(levels) {
                *tone = tone.max(found.over(*level));
            }
        }
    }
    all
}

/// The nodes between two corners, and their places.
fn around([low, high]: [Vec2; 2]) -> impl Iterator<Item = (Node, Vec2)> {
    let (low, high) = ((low * FINE).floor().as_ivec2(), (high * FINE).ceil().as_ivec2());
    (low.y..=high.y).flat_map(move |y| {
        (low.x..=high.x).map(move |x| ([y, x], Vec2::new(x as f32, y as f32) / FINE))
    })
}

fn outline(polygon: &[Vec2]) -> Option<Vec<Point>> {
    let mut points: Vec<Point> =
        polygon.iter().map(|p| [f64::from(p.x / FINE), f64::from(p.y / FINE)]).collect();
    let next = points.iter().cycle().skip(1);
    let area: f64 = points.iter().zip(next).map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum();
    if area.abs() < SPECK {
        return None;
    }
    // Two halves, so that both ends of each stay.
    let back = points.split_off(points.len() / 2);
    let closing = [points[0]];
    let joined: Vec<Point> = [points.as_slice(), &back[..1]].concat();
    let mut kept = simplified(&joined, TOLERANCE);
    kept.pop();
    kept.extend(simplified(&[back.as_slice(), &closing].concat(), TOLERANCE));
    kept.pop();
    Some(kept)
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, Knot, Spine, paint};
    use super::*;
    use chiaro_image::Plane;

    fn area(tone: &Tone) -> f64 {
        let one = |p: &Vec<Point>| -> f64 {
            let next = p.iter().cycle().skip(1);
            p.iter().zip(next).map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum()
        };
        tone.outlines.iter().map(one).sum::<f64>().abs()
    }

    #[test]
    fn tones_have_the_ink_of_the_pixels() {
        let knot = |i: usize| Knot {
            at: Vec2::new(20.0 + 2.0 * i as f32, 40.0 + 9.0 * (0.06 * i as f32).sin()),
            u: 2.0 * i as f64,
            depth: 0.0,
        };
        let spine = Spine::new((0..130).map(knot).collect(), false, Axis { seed: 4, period: None });
        let grains = [Grain::Bristle, Grain::Charcoal, Grain::Pencil, Grain::Wash, Grain::Solid];
        let wide = grains.map(|grain| (grain, 9.0, 1.0, 1));
        let thin = [(Grain::Pencil, 1.8, 0.3, 1), (Grain::Pencil, 1.8, 0.3, 2)];
        for (grain, width, rough, repeat) in wide.into_iter().chain(thin) {
            let brush = Brush { grain, width, rough, repeat, wobble: 1.3, ..Brush::default() };
            let (texture, colour) = (None, [0.0, 0.0, 0.0, 1.0]);
            let (brush, spine) = (&brush, &spine);
            let stroke = Stroke { spine, brush, texture, colour, hides: true, right: false };
            let picture = paint(&[stroke], &Plane::filled(300, 80, [1.0; 4]), [1.0; 4]);
            let wanted: f64 = picture.pixels().iter().map(|p| 1.0 - f64::from(p[0])).sum();
            let mut before = 0.0;
            let mut found = 0.0;
            for tone in tones(&stroke, &Halos::default()).unwrap() {
                found += area(&tone) * f64::from(tone.ink - before);
                before = tone.ink;
            }
            let off = found / wanted - 1.0;
            let most = if width < 2.0 { 0.1 } else { 0.06 };
            assert!(off.abs() < most, "{grain:?}, {width} px: {found} for {wanted}");
        }
        let brush = Brush::default();
        let plain = Stroke {
            spine: &spine,
            brush: &brush,
            texture: None,
            colour: [0.0, 0.0, 0.0, 1.0],
            hides: true,
            right: false,
        };
        assert_eq!(tones(&plain, &Halos::default()), None);
    }

    #[test]
    fn double_lines_turn_without_a_mess() {
        // Teeth that the line is nearly too wide for: its pieces lie over each other where it turns.
        let knot = |i: usize| {
            let tooth = (i % 12) as f32 / 6.0 - 1.0;
            let at = Vec2::new(20.0 + 1.5 * i as f32, 50.0 + 12.0 * tooth.abs());
            Knot { at, u: 2.0 * i as f64, depth: 0.0 }
        };
        let spine = Spine::new((0..130).map(knot).collect(), false, Axis { seed: 4, period: None });
        let brush = Brush { mark: Mark::Double, width: 1.5, gap: 9.0, ..Brush::default() };
        let (texture, colour) = (None, [0.0, 0.0, 0.0, 1.0]);
        let stroke =
            Stroke { spine: &spine, brush: &brush, texture, colour, hides: true, right: false };
        let picture = paint(&[stroke], &Plane::filled(250, 100, [1.0; 4]), [1.0; 4]);
        let wanted: f64 = picture.pixels().iter().map(|p| 1.0 - f64::from(p[0])).sum();
        let tones = tones(&stroke, &Halos::default()).unwrap();
        let found: f64 = tones.iter().map(area).sum();
        assert!(tones.len() == 1 && (found / wanted - 1.0).abs() < 0.06, "{found} for {wanted}");
        assert!(tones[0].outlines.len() < 5, "{} outlines", tones[0].outlines.len());
    }
}
