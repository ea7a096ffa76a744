//! Pools: near hits are shared by the pixels of 4 x 4 blocks.
//!
//! Each hit counts for every receiver of its block with the receiver's own geometry term over the
//! sum of the terms with which all of them look for it, times their rays (the balance heuristic):
//! blocks stay sharp at creases and contacts, and only visibility is shared. Blocks overlap by half
//! and fade into each other, so that they do not show. Receivers of a block that are far apart do
//! not share. What is bright (`bright`) is each receiver's own.

mod opening;

use crate::field::{Ball, Light};
use crate::receiver::Receiver;
use chiaro_basis::math::Vec3;
pub(crate) use opening::open;
use std::f32::consts::PI;

/// Pixels along a block's side; blocks begin every half of it.
pub(crate) const SIDE: usize = 4;
pub(crate) const STEP: usize = SIDE / 2;
/// Receivers share within so many footprints, as long as they are on the surface.
const NEAR: f32 = 9.0;
/// The most by which sums of far fields may be over what rays look up.
const MOST_SHARE: f32 = 2.0;
/// The weight of a block at each of its columns or rows; those of all blocks sum to 1.
const FADE: [f32; SIDE] = [0.25, 0.75, 0.75, 0.25];

/// Near irradiance of each pixel of a block, by row and column, and the weight of the block there.
pub(crate) type Pooled = [(f32, Light); SIDE * SIDE];

const LANES: usize = SIDE * SIDE;
type Lanes = [f32; LANES];

/// Receivers that share, side by side; unused lanes have no rays.
struct Group {
    lanes: usize,
    position: [Lanes; 3],
    normal: [Lanes; 3],
    side: [Lanes; 3],
    rays: Lanes,
    /// The balls in which they look, and each one's share of each.
    parts: Vec<(Ball, Lanes)>,
}

impl Group {
    fn new() -> Self {
        let zero = [0.0; LANES];
        Self {
            lanes: 0,
            position: [[f32::MAX.sqrt() * 1e-3; LANES]; 3],
            normal: [zero; 3],
            side: [zero; 3],
            rays: zero,
            parts: Vec::with_capacity(4),
        }
    }

    fn add(&mut self, receiver: &Receiver) {
        let k = self.lanes;
        self.lanes += 1;
        for c in 0..3 {
            self.position[c][k] = receiver.at.position[c];
            self.normal[c][k] = receiver.at.normal[c];
            self.side[c][k] = receiver.at.side[c];
        }
        self.rays[k] = receiver.rays as f32;
        for (share, ball) in receiver.parts.iter().filter(|(share, _)| *share > 0.0) {
            let known = self.parts.iter().position(|(b, _)| b == ball);
            let i = known.unwrap_or_else(|| {
                self.parts.push((*ball, [0.0; LANES]));
                self.parts.len() - 1
            });
            self.parts[i].1[k] += share;
        }
    }

    /// By how much light that was met at a place counts for each receiver: its own term, as far as its balls hold
    /// the place, over the terms of all who look there.
    fn weights(&self, place: Vec3) -> Option<Lanes> {
        let mut terms = self.terms(place.to_array());
        let mut found: f32 = terms.iter().zip(&self.rays).map(|(t, n)| t * n).sum();
        if self.parts.iter().any(|(ball, _)| !ball.holds(place)) {
            let mut within = [0.0; LANES];
            for (_, shares) in self.parts.iter().filter(|(ball, _)| ball.holds(place)) {
                (0..LANES).for_each(|k| within[k] += shares[k]);
            }
            let looks = |k: usize| if within[k] > 0.0 { terms[k] * self.rays[k] } else { 0.0 };
            found = (0..LANES).map(looks).sum();
            (0..LANES).for_each(|k| terms[k] *= within[k]);
        }
        (found > 0.0 && found.is_finite()).then(|| terms.map(|t| t * (PI / found)))
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

/// How much of the far light that rays of some receivers look up is among the sums of their far fields, by
/// which near light replaces it (a ratio estimator): seen from beside the centre, texels overlap and part.
fn looked_up<'a>(receivers: impl Iterator<Item = &'a Receiver>) -> Light {
    let (mut summed, mut looked) = ([0.0; 4], [0.0; 4]);
    for r in receivers.filter(|r| r.looked > 0) {
        (0..4).for_each(|c| {
            summed[c] += r.looked as f32 * r.far[c];
            looked[c] += PI * r.looked_up[c];
        });
    }
    std::array::from_fn(|c| match looked[c] > 0.0 {
        true => (summed[c] / looked[c]).min(MOST_SHARE),
        false => 1.0,
    })
}

/// Shares the hits of some receivers among them.
fn share(receivers: &[Option<&Receiver>; LANES], some: &[usize], pooled: &mut Pooled) {
    let mut group = Group::new();
    let members = || some.iter().filter_map(|&i| receivers[i].map(|r| (i, r)));
    members().for_each(|(_, r)| group.add(r));
    let share = looked_up(members().map(|(_, r)| r));
    let mut sum = [[0.0; LANES]; 4];
    for hit in members().flat_map(|(_, r)| &r.hits) {
        let Some(weights) = group.weights(hit.position) else { continue };
        for (sum, light) in sum.iter_mut().zip(hit.light(&share)) {
            (0..LANES).for_each(|k| sum[k] += weights[k] * light);
        }
    }
    for (k, (place, r)) in members().enumerate() {
        pooled[place].1 = std::array::from_fn(|c| sum[c][k] + r.bright.get(c).unwrap_or(&0.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::receiver::Residual;
    use chiaro_trace::{Sequence, Vertex};

    const RAYS: u32 = 256;

    /// A receiver on a floor, facing up.
    fn receiver(x: f32, ball: Ball) -> Receiver {
        let position = Vec3::new(x, 0.0, 0.0);
        let at = Vertex {
            position,
            lifted: position,
            side: Vec3::Y,
            smooth: Vec3::Y,
            normal: Vec3::Y,
            albedo: [1.0; 3],
            emission: [0.0; 3],
            offset: 0.0,
        };
        let mut receiver = Receiver::of(at, (0, 0), (1.0, 1.0));
        receiver.parts[0] = (1.0, ball);
        receiver.rays = RAYS;
        receiver
    }

    /// Rays to a ceiling of this light, as far as the ball goes; far light in all directions.
    fn look(receiver: &mut Receiver, own: Light, far: Light) {
        let sequence = Sequence::new(receiver.at.position.x.to_bits().into());
        for k in 0..RAYS {
            let direction = receiver.at.cosine_direction(sequence.point(k, 0));
            let position = receiver.at.position + direction / direction.y;
            (0..4).for_each(|c| receiver.looked_up[c] += far[c]);
            receiver.looked += 1;
            if receiver.parts[0].1.holds(position) {
                receiver.hits.push(Residual { position, own, far });
            }
        }
    }

    fn pooled(receivers: &[Receiver]) -> Vec<Light> {
        let all = pool(&std::array::from_fn(|i| receivers.get(i)));
        all.iter().take(receivers.len()).map(|p| p.1).collect()
    }

    /// One looks within a ball around it, the other everywhere: each receives what its own ball holds.
    #[test]
    fn receivers_have_the_light_of_their_own_balls() {
        let balls = [1.5, f32::INFINITY].map(|radius| Ball { centre: Vec3::ZERO, radius });
        let mut both = [receiver(0.0, balls[0]), receiver(0.5, balls[1])];
        both.iter_mut().for_each(|r| look(r, [1.0; 4], [0.0; 4]));
        let light = pooled(&both);
        let within = PI * (1.0 - 1.0 / (1.5 * 1.5));
        assert!((light[0][0] / within - 1.0).abs() < 0.03, "{light:?}");
        assert!((light[1][0] / PI - 1.0).abs() < 0.03, "{light:?}");
    }

    /// What is bright is each receiver's own.
    #[test]
    fn receivers_keep_what_they_have_of_bright_things() {
        let everywhere = Ball { centre: Vec3::ZERO, radius: f32::INFINITY };
        let mut both = [receiver(0.0, everywhere), receiver(0.5, everywhere)];
        both[1].bright = [1.0, 2.0, 3.0];
        let light = pooled(&both);
        assert_eq!([light[0], light[1]].map(|l| [l[0], l[1], l[2]]), [[0.0; 3], [1.0, 2.0, 3.0]]);
    }

    /// Rays look up twice what the sums of the far fields hold.
    #[test]
    fn what_hides_all_takes_back_what_the_far_fields_gave() {
        let everywhere = Ball { centre: Vec3::ZERO, radius: f32::INFINITY };
        let mut one = receiver(0.0, everywhere);
        one.far = [1.0, 2.0, 3.0, 1.5];
        let far = one.far.map(|f| 2.0 * f / PI);
        look(&mut one, [0.0; 4], far);
        let given = one.far;
        let light = pooled(&[one])[0];
        assert!((0..4).all(|c| (light[c] + given[c]).abs() < 1e-3), "{light:?}");
    }
}
