//! The simple construction of section 4.5.1: lines of two frames are paired by votes in the picture.
//!
//! It asks nothing of the mesh but its lines in each frame, so it serves meshes that are made anew
//! in every frame. Every sample votes for the nearest stroke of its kind in the other frame; where it
//! is known whither material points move, the earlier frame's have moved.

use crate::path::Kind;
use crate::stroke::{Sample, Stroke};
use crate::view::View;
use chiaro_basis::math::DVec2;
use std::collections::BTreeMap;

/// A vote reaches this far, in parts of the picture's height.
const REACH: f64 = 0.05;

/// Pairs of strokes of two frames with the length that voted for them, both ways; of those kinds
/// alone that `counts` admits.
pub(crate) fn votes(
    [before, after]: [&Vec<Stroke>; 2],
    counts: impl Fn(Kind) -> bool,
    view: &View,
) -> Vec<(usize, usize, f64)> {
    let reach = REACH * view.size.1 as f64;
    let mut pairs = BTreeMap::new();
    let moved = |s: &Sample| s.next_at.unwrap_or(s.at);
    for (a, b, weight) in one_way([before, after], [&moved, &|s| s.at], &counts, reach) {
        *pairs.entry((a, b)).or_insert(0.0) += weight;
    }
    for (b, a, weight) in one_way([after, before], [&|s| s.at, &moved], &counts, reach) {
        *pairs.entry((a, b)).or_insert(0.0) += weight;
    }
    pairs.into_iter().map(|((a, b), w)| (a, b, w)).collect()
}

/// Where a sample counts as being.
type Where<'a> = &'a dyn Fn(&Sample) -> DVec2;

fn one_way(
    [from, to]: [&[Stroke]; 2],
    [here, there]: [Where<'_>; 2],
    counts: &impl Fn(Kind) -> bool,
    reach: f64,
) -> Vec<(usize, usize, f64)> {
    let mut votes = Vec::new();
    for (i, stroke) in from.iter().enumerate().filter(|(_, s)| counts(s.kind)) {
        let weight = stroke.total() / stroke.samples.len() as f64;
        let ends: Vec<(usize, DVec2)> = to
            .iter()
            .enumerate()
            .filter(|(_, s)| s.kind == stroke.kind)
            .flat_map(|(j, s)| s.samples.iter().map(move |p| (j, there(p))))
            .collect();
        for sample in &stroke.samples {
            if let Some(j) = nearest(here(sample), &ends, reach) {
                votes.push((i, j, weight));
            }
        }
    }
    votes
}

fn nearest(at: DVec2, ends: &[(usize, DVec2)], reach: f64) -> Option<usize> {
    let distances = ends.iter().map(|(j, p)| (p.distance(at), *j));
    let best = distances.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
    (best.0 < reach).then_some(best.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::DVec3;

    /// An upright line at some x, which moves to the right by `by`.
    fn upright(x: f64, by: Option<f64>) -> Stroke {
        let sample = |k: u32| {
            let at = DVec2::new(x, 3.0 * f64::from(k));
            Sample {
                at,
                depth: 1.0,
                world: DVec3::ZERO,
                next_world: None,
                next_at: by.map(|by| at + DVec2::new(by, 0.0)),
                chain: 0,
                on_chain: 0.0,
                normal: DVec3::Z,
                faces: [0; 2],
            }
        };
        Stroke::through(Kind::Intersection, false, (0..10).map(sample).collect())
    }

    #[test]
    fn lines_that_move_fast_vote_for_themselves() {
        let pose = chiaro_scene::Pose::look_at(
            chiaro_basis::math::vec3(0.0, 0.0, 1.0),
            chiaro_basis::math::Vec3::ZERO,
            chiaro_basis::math::Vec3::Y,
            chiaro_scene::Projection::Perspective { fov_y: 1.0 },
        );
        let view = View::new(pose, (640, 480));
        // Two lines ten pixels apart move by ten: where one was, the other is.
        let after = vec![upright(110.0, None), upright(120.0, None)];
        let pairs = |by| {
            let before = vec![upright(100.0, by), upright(110.0, by)];
            let pairs = votes([&before, &after], |_| true, &view);
            pairs.into_iter().map(|(a, b, _)| (a, b)).collect::<Vec<_>>()
        };
        assert_eq!(pairs(Some(10.0)), [(0, 0), (1, 1)]);
        assert!(pairs(None).contains(&(1, 0)), "without motion the picture alone decides");
    }
}
