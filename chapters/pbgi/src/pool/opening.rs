//! What near hits take away from the openings of a block's receivers.

use super::{Group, LANES, groups, looked_up, weight_at};
use crate::opening::{Dome, Opening};
use crate::receiver::Receiver;
use chiaro_basis::math::Vec3;

/// What near hits add to the opening of each pixel of a block, with the block's weight there; hits count as they
/// do for light.
pub(crate) fn open(receivers: &[Option<&Receiver>; LANES], dome: &Dome) -> [(f32, Opening); LANES] {
    let mut pooled = [(0.0, [0.0; 6]); LANES];
    pooled.iter_mut().enumerate().for_each(|(i, p)| p.0 = weight_at(i));
    groups(receivers, |some| {
        let mut group = Group::new();
        let members = || some.iter().filter_map(|&i| receivers[i].map(|r| (i, r)));
        members().for_each(|(_, r)| group.add(r));
        let share = looked_up(members().map(|(_, r)| r));
        for hit in members().flat_map(|(_, r)| &r.hits) {
            let open = hit.light(&share)[3];
            let Some(weights) = group.weights(hit.position).filter(|_| open != 0.0) else {
                continue;
            };
            for (k, place) in some.iter().enumerate().filter(|(k, _)| weights[*k] > 0.0) {
                let from = Vec3::from([0, 1, 2].map(|c| group.position[c][k]));
                let towards = (hit.position - from).normalize_or_zero();
                let open = open * weights[k];
                let sum = &mut pooled[*place].1;
                let light = dome.radiance(towards);
                (0..3).for_each(|c| sum[c] += open * towards[c]);
                (0..3).for_each(|c| sum[3 + c] += open * light[c]);
            }
        }
    });
    pooled
}
