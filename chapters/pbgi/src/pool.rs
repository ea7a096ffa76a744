//! Pools: near hits are shared by the pixels of 4 x 4 blocks.
//!
//! Each hit counts for every receiver of its block with the receiver's own geometry term over the
//! sum of the terms with which all of them look for it, times their rays (the balance heuristic):
//! blocks stay sharp at creases and contacts, and only visibility is shared. Blocks overlap by half
//! and fade into each other, so that they do not show. Receivers of a block that are far apart do
//! not share.

mod opening;

use crate::field::Light;
use crate::receiver::Receiver;
pub(crate) use opening::open;
use std::f32::consts::PI;

/// Pixels along a block's side; blocks begin every half of it.
pub(crate) const SIDE: usize = 4;
pub(crate) const STEP: usize = SIDE / 2;
/// Receivers share within so many footprints, as long as they are on the surface.
const NEAR: f32 = 9.0;
/// The weight of a block at each of its columns or rows; those of all blocks sum to 1.
const FADE: [f32; SIDE] = [0.25, 0.75, 0.75, 0.25];

/// Near irradiance of each pixel of a block, by row and column, and the weight of the block there.
pub(crate) type Pooled = [(f32, Light); SIDE * SIDE];

const LANES: usize = SIDE * SIDE;
type Lanes = [f32; LANES];

/// Receivers that share, side by side; unused lanes have no rays.
struct Group {
    lanes: usize,
    place: [usize; LANES],
    position: [Lanes; 3],
    normal: [Lanes; 3],
    side: [Lanes; 3],
    rays: Lanes,
}

impl Group {
    fn new() -> Self {
        let zero = [0.0; LANES];
        Self {
            lanes: 0,
            place: [0; LANES],
            position: [[f32::MAX.sqrt() * 1e-3; LANES]; 3],
            normal: [zero; 3],
            side: [zero; 3],
            rays: zero,
        }
    }

    fn add(&mut self, place: usize, receiver: &Receiver) {
        let k = self.lanes;
        self.lanes += 1;
        self.place[k] = place;
        for c in 0..3 {
            self.position[c][k] = receiver.at.position[c];
            self.normal[c][k] = receiver.at.normal[c];
            self.side[c][k] = receiver.at.side[c];
        }
        self.rays[k] = receiver.rays as f32;
    }

    /// The terms of cosine density per area at a place, for all receivers.
    #[allow(clippy::needless_range_loop, reason = "lanes are vectors of the processor")]
    fn terms(&self, [x, y, z]: [f32; 3]) -> Lanes {
        let mut terms = [0.0; LANES];
        for k in 0..LANES {
            let (dx, dy, dz) =
                (x - self.position[0][k], y - self.position[1][k], z - self.position[2][k]);
            let square = (dx * dx + dy * dy + dz * dz).max(1e-30);
            let cosine = dx * self.normal[0][k] + dy * self.normal[1][k] + dz * self.normal[2][k];
            let above = dx * self.side[0][k] + dy * self.side[1][k] + dz * self.side[2][k] > 0.0;
            let cosine = if above { cosine.max(0.0) } else { 0.0 };
            terms[k] = cosine / (square * square.sqrt());
        }
        terms
    }
}

/// The near irradiance that a block's receivers, by row and column, have from all their hits.
pub(crate) fn pool(receivers: &[Option<&Receiver>; LANES]) -> Pooled {
    let mut pooled = [(0.0, [0.0; 4]); LANES];
    for (i, (weight, _)) in pooled.iter_mut().enumerate() {
        *weight = weight_at(i);
    }
    groups(receivers, |some| share(receivers, some, &mut pooled));
    pooled
}

/// The weight of a block at one of its pixels.
pub(crate) fn weight_at(place: usize) -> f32 {
    FADE[place % SIDE] * FADE[place / SIDE]
}

/// Calls for every group of receivers that share.
fn groups(receivers: &[Option<&Receiver>; LANES], mut call: impl FnMut(&[usize])) {
    let mut left: Vec<usize> = (0..LANES).filter(|&i| receivers[i].is_some()).collect();
    while let Some(first) = left.first().and_then(|&i| receivers[i]) {
        let near = |i: &usize| receivers[*i].is_some_and(|r| are_near(first, r));
        let (some, rest): (Vec<usize>, Vec<usize>) = left.iter().partition(|i| near(i));
        call(&some);
        left = rest;
    }
}

/// Whether two receivers share: on one plane, however slanted it is; else only if they are close.
fn are_near(a: &Receiver, b: &Receiver) -> bool {
    let offset = b.at.position - a.at.position;
    let footprint = a.footprint.max(b.footprint);
    let flat = a.at.side.dot(b.at.side) > 0.99
        && offset.dot(a.at.side).abs() <= footprint
        && offset.dot(b.at.side).abs() <= footprint;
    let stretch = if flat { a.stretch.max(b.stretch) } else { 1.0 };
    offset.length() <= NEAR * stretch * footprint
}

/// Shares the hits of some receivers among them.
fn share(receivers: &[Option<&Receiver>; LANES], some: &[usize], pooled: &mut Pooled) {
    let mut group = Group::new();
    let members = || some.iter().filter_map(|&i| receivers[i].map(|r| (i, r)));
    members().for_each(|(i, r)| group.add(i, r));
    let mut sum = [[0.0; LANES]; 4];
    for hit in members().flat_map(|(_, r)| &r.hits) {
        let terms = group.terms(hit.position.to_array());
        let found: f32 = terms.iter().zip(&group.rays).map(|(t, n)| t * n).sum();
        if found <= 0.0 || !found.is_finite() {
            continue;
        }
        let scale = PI / found;
        for (sum, light) in sum.iter_mut().zip(hit.light) {
            (0..LANES).for_each(|k| sum[k] += terms[k] * (light * scale));
        }
    }
    for k in 0..group.lanes {
        pooled[group.place[k]].1 = std::array::from_fn(|c| sum[c][k]);
    }
}
