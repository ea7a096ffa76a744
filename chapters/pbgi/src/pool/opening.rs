//! What near hits take away from the openings of a block's receivers.

use super::{Group, LANES, groups, weight_at};
use crate::opening::{Dome, Opening};
use crate::receiver::Receiver;
use chiaro_basis::math::Vec3;
use std::f32::consts::PI;

/// What near hits add to the opening of each pixel of a block, with the block's weight there; hits count as they
/// do for light.
pub(crate) fn open(receivers: &[Option<&Receiver>; LANES], dome: &Dome) -> [(f32, Opening); LANES] {
    let mut pooled = [(0.0, [0.0; 6]); LANES];
    pooled.iter_mut().enumerate().for_each(|(i, p)| p.0 = weight_at(i));
    groups(receivers, |some| {
        let mut group = Group::new();
        let members = || some.iter().filter_map(|&i| receivers[i].map(|r| (i, r)));
        members().for_each(|(i, r)| group.add(i, r));
        for hit in members().flat_map(|(_, r)| &r.hits) {
            let terms = group.terms(hit.position.to_array());
            let found: f32 = terms.iter().zip(&group.rays).map(|(t, n)| t * n).sum();
            if found <= 0.0 || !found.is_finite() || hit.light[3] == 0.0 {
                continue;
            }
            for (k, term) in terms.iter().enumerate().take(group.lanes).filter(|(_, t)| **t > 0.0) {
                let from = Vec3::from([0, 1, 2].map(|c| group.position[c][k]));
                let towards = (hit.position - from).normalize_or_zero();
                let open = hit.light[3] * term * PI / found;
                let sum = &mut pooled[group.place[k]].1;
                let light = dome.radiance(towards);
                (0..3).for_each(|c| sum[c] += open * towards[c]);
                (0..3).for_each(|c| sum[3 + c] += open * light[c]);
            }
        }
    });
    pooled
}
