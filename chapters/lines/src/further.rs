//! [`Further`]: zero sets other than silhouettes, followed from frame to frame.
//!
//! Terminators and suggestive contours are zeros of functions at the vertices: they have a space-time
//! surface of their own, and crossings ride along it as those of silhouettes do. Ridges, valleys and
//! apparent ridges are found edge by edge, since directions have no sign: there a crossing becomes the
//! one nearest to where its material point has moved.

use crate::path::Kind;
use crate::slice::Slice;
use crate::surface::{NONE, Surface};
use crate::track::{Kinetic, Order};
use crate::view::View;
use chiaro_basis::math::{DVec2, DVec3};
use std::collections::HashMap;

/// A crossing may be so far from where its material point has moved, pixels.
const REACH: f64 = 8.0;

/// A zero set of one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Further {
    /// Its kind; silhouettes are none of these.
    pub kind: Kind,
    /// The whole of it, hidden and trimmed parts too.
    pub slice: Slice,
    /// For each crossing, the crossing of the next frame that it becomes, or `u32::MAX`; empty at the
    /// last frame and before a cut.
    pub forward: Vec<u32>,
    /// The function at the vertices, if it is the zero set of one; forgotten once it is followed.
    pub(crate) values: Vec<f64>,
}

/// Follows the further zero sets of a film, each in its place.
#[derive(Default)]
pub(crate) struct Follower<'a> {
    sets: Vec<(Vec<f64>, Option<Kinetic<'a>>)>,
}

impl<'a> Follower<'a> {
    /// Goes on to a frame; `before`: the zero sets of the frame before, unless the frame begins anew.
    /// Answers what their crossings become, and forgets the values.
    pub(crate) fn advance(
        &mut self,
        surface: &'a Surface,
        before: Option<&[Further]>,
        now: &mut [Further],
        (positions, view): (&[DVec3], &View),
    ) -> Vec<Option<Vec<u32>>> {
        self.sets.resize_with(now.len(), Default::default);
        let mut forward = Vec::with_capacity(now.len());
        for (i, (set, known)) in now.iter_mut().zip(&mut self.sets).enumerate() {
            let values = std::mem::take(&mut set.values);
            let old = before.and_then(|b| b.get(i));
            if values.is_empty() {
                let nearest =
                    |old: &Further| nearest(surface, [&old.slice, &set.slice], positions, view);
                forward.push(old.map(nearest));
                continue;
            }
            forward.push(match (old, &mut known.1) {
                (Some(old), Some(kinetic)) => {
                    let slices = [&old.slice, &set.slice];
                    Some(kinetic.step(&known.0, &values, slices, Order::Time).forward)
                }
                _ => {
                    known.1 = Some(Kinetic::new(surface, &values, &set.slice, 0));
                    None
                }
            });
            known.0 = values;
        }
        forward
    }
}

/// For each crossing of a slice, the crossing of the next nearest to where its material point is
/// then.
fn nearest(
    surface: &Surface,
    [before, after]: [&Slice; 2],
    positions: &[DVec3],
    view: &View,
) -> Vec<u32> {
    let place = |edge: u32, at: f64| {
        let [a, b] = surface.ends(edge).map(|v| positions[v as usize]);
        let world = a.lerp(b, at);
        view.see(world).map(|seen| (world, seen))
    };
    let cell = |p: DVec2| [p.x, p.y].map(|x| (x / REACH).floor() as i32);
    let mut cells: HashMap<[i32; 2], Vec<(u32, DVec3)>> = HashMap::new();
    for (j, c) in after.crossings.iter().enumerate() {
        if let Some((world, seen)) = place(c.edge, c.at) {
            cells.entry(cell(seen.at)).or_default().push((j as u32, world));
        }
    }
    let find = |edge: u32, at: f64| {
        let (world, seen) = place(edge, at)?;
        let [x, y] = cell(seen.at);
        let near = (0..9).filter_map(|k| cells.get(&[x + k % 3 - 1, y + k / 3 - 1])).flatten();
        let measured = near.map(|(j, p)| (p.distance(world), *j));
        let best = measured.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
        (best.0 <= REACH * view.pixel(seen.depth)).then_some(best.1)
    };
    before.crossings.iter().map(|c| find(c.edge, c.at).unwrap_or(NONE)).collect()
}
