//! Surfaces that face different ways, told apart within a cell of a curve.
//!
//! A node that holds both sides of a thin wall cannot keep their light apart: straight behind a disc its short
//! series is 6 % of what it is ahead, so that a sunny roof shines into the room below. Where surfels along a
//! curve fall into few flat groups, they are therefore sorted by the axis that their normal is nearest to
//! before they are sorted by place, in the largest cells where that makes every group flat. Curved and ragged surfaces
//! stay as they are.
//!
//! The three bits of the axis go into the key where the cell's own bits begin; what lies deeper moves down, and the three
//! lowest bits are lost. Trees over keys need not know.

use crate::cube::face_of;
use crate::curve;
use crate::surfel::Surfel;
use chiaro_basis::math::Vec3;

/// Surfels of a cell that is parted, at most; nodes over more are opened by every receiver.
const LARGEST: usize = 8192;
/// Length of a group's mean normal from which on it is flat.
const FLAT: f32 = 0.99;

/// Surfels along a curve with their keys, sorted by them.
pub(crate) type Keyed = [(u64, Surfel)];

/// Parts the surfels by where they face; keys stay sorted.
pub(crate) fn part(keyed: &mut Keyed) {
    if keyed.len() > LARGEST {
        let (left, right) = keyed.split_at_mut(middle(keyed));
        rayon::join(|| part(left), || part(right));
        return;
    }
    let mut found = Vec::new();
    sums(keyed, 0, &mut found);
    for range in found {
        by_facing(&mut keyed[range]);
    }
}

/// Whether surfels face different ways, but are flat where they face the same.
pub(crate) fn mixed(surfels: &[Surfel]) -> bool {
    surfels.len() > 1 && surfels.iter().fold(Groups::default(), Groups::with).mixed()
}

/// Normals by the axis that they are nearest to.
#[derive(Clone, Copy, Default)]
struct Groups {
    count: usize,
    area: f32,
    normals: [Vec3; 6],
}

impl Groups {
    fn with(mut self, surfel: &Surfel) -> Self {
        self.count += 1;
        self.area += surfel.area;
        self.normals[face_of(surfel.normal).0] += surfel.area * surfel.normal;
        self
    }

    fn plus(&self, other: &Self) -> Self {
        Self {
            count: self.count + other.count,
            area: self.area + other.area,
            normals: std::array::from_fn(|k| self.normals[k] + other.normals[k]),
        }
    }

    fn mixed(&self) -> bool {
        let groups = self.normals.iter().filter(|n| **n != Vec3::ZERO).count();
        // Of a few surfels, each is flat by itself.
        if self.count < 2 * groups {
            return false;
        }
        let apart: f32 = self.normals.iter().map(|n| n.length()).sum();
        let together = self.normals.iter().sum::<Vec3>().length();
        apart >= FLAT * self.area && together < FLAT * self.area
    }
}

/// The sums over surfels of which the first has a number; the largest mixed cells among them are added to `found`.
fn sums(keyed: &Keyed, first: usize, found: &mut Vec<std::ops::Range<usize>>) -> Groups {
    if keyed.len() < 2 {
        return keyed.iter().fold(Groups::default(), |groups, (_, s)| groups.with(s));
    }
    let (before, middle) = (found.len(), middle(keyed));
    let (left, right) = keyed.split_at(middle);
    let all = sums(left, first, found).plus(&sums(right, first + middle, found));
    if all.mixed() {
        found.truncate(before);
        found.push(first..first + keyed.len());
    }
    all
}

/// Sorts the surfels of a cell by where they face.
fn by_facing(keyed: &mut Keyed) {
    let differ = keyed[0].0 ^ keyed[keyed.len() - 1].0;
    // Places that are all but equal have no room for the axis.
    let Some(shift) = differ.checked_ilog2().and_then(|highest| highest.checked_sub(2)) else {
        return;
    };
    let own = (8u64 << shift) - 1;
    for (key, surfel) in keyed.iter_mut() {
        *key = (*key & !own) | (face_of(surfel.normal).0 as u64) << shift | (*key & own) >> 3;
    }
    keyed.sort_by_key(|(key, _)| *key);
}

fn middle(keyed: &Keyed) -> usize {
    curve::half(keyed, |(key, _)| *key)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut::Chooser;
    use crate::tree::Tree;

    /// A slab of 1 x 1 x thickness: its upper side sends `above`, its lower side 1.
    fn slab(thickness: f32, above: f32) -> Vec<Surfel> {
        let at = |i: usize, z: f32| Vec3::new((i % 64) as f32 / 64.0, (i / 64) as f32 / 64.0, z);
        let side = |z: f32, normal: Vec3, light: f32| {
            (0..64 * 64).map(move |i| Surfel {
                position: at(i, z),
                normal,
                area: 1.0 / 4096.0,
                alive: [true, false],
                albedo: [0.5; 3],
                radiance: [[light; 3], [0.0; 3]],
            })
        };
        side(0.0, Vec3::NEG_Z, 1.0).chain(side(thickness, Vec3::Z, above)).collect()
    }

    /// Radiance times solid angle that nodes send to a place.
    fn seen(tree: &Tree, from: Vec3) -> f32 {
        let mut splats = Vec::new();
        let chooser =
            Chooser { from, threshold: 0.02, near: 0.0, mark: 0.0, above: None, flat: true };
        chooser.cut(tree, &mut splats);
        splats.iter().map(|s| s.radiance[0] * s.solid_angle).sum()
    }

    #[test]
    fn a_thin_slab_s_sunny_side_does_not_shine_through() {
        for thickness in [0.003, 0.02, 0.1] {
            let [dark, sunny] = [0.0, 1000.0].map(|l| Tree::build(&slab(thickness, l)));
            for from in [Vec3::new(0.5, 0.5, -1.0), Vec3::new(-1.0, 0.2, -0.5)] {
                let (without, with) = (seen(&dark, from), seen(&sunny, from));
                assert!((with - without).abs() < 0.01 * without, "{thickness}: {with} {without}");
            }
        }
    }

    #[test]
    fn keys_stay_sorted_and_surfels_stay_themselves() {
        let mut keyed: Vec<(u64, Surfel)> = slab(0.02, 5.0)
            .into_iter()
            .map(|s| {
                let [x, y, z] = (s.position * 1000.0).to_array().map(|c| c as u64);
                ((x / 8) << 20 | (y / 8) << 10 | z, s)
            })
            .collect();
        keyed.sort_by_key(|(key, _)| *key);
        let places = |k: &Keyed| {
            let mut all: Vec<_> =
                k.iter().map(|(_, s)| s.position.to_array().map(f32::to_bits)).collect();
            all.sort_unstable();
            all
        };
        let before = places(&keyed);
        part(&mut keyed);
        assert!(keyed.is_sorted_by_key(|(key, _)| *key));
        assert_eq!(places(&keyed), before);
        let turns = keyed.windows(2).filter(|w| w[0].1.normal != w[1].1.normal).count();
        assert!(turns < 64, "{turns} turns between sides");
    }

    #[test]
    fn round_things_stay_as_they_are() {
        let mut keyed: Vec<(u64, Surfel)> = (0..4096u64)
            .map(|i| {
                let unit = |k| chiaro_basis::random::unit(k, i) - 0.5;
                let normal = Vec3::new(unit(1), unit(2), unit(3)).normalize();
                (i << 20, Surfel { position: normal, normal, area: 1.0, ..Surfel::default() })
            })
            .collect();
        let before: Vec<u64> = keyed.iter().map(|(key, _)| *key).collect();
        part(&mut keyed);
        let moved = keyed.iter().zip(&before).filter(|((key, _), own)| key != *own).count();
        assert!(moved < 1024, "{moved}");
    }
}
