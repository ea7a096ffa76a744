//! Quarters of the parts of what shines, each as strong as the whole part.
//!
//! Pixels side by side look at different quarters: together they see four times as many lamps, at the price of one
//! each. Few lamps stand in rows, whose shadows fall together in bands.

use super::spot::{self, Spot};
use super::{Cluster, Glow};
use chiaro_basis::math::Vec3;

/// Quarters of a cluster.
pub(crate) const QUARTERS: usize = 4;

impl Glow {
    /// At most `count` clusters, each as its quarters: parts of equal power, each with the power of the whole.
    pub(crate) fn quartered(&self, count: usize) -> Vec<[Cluster; QUARTERS]> {
        let (points, share) = self.spots(spot::MOST);
        let quarter = |members: &Vec<usize>| {
            quarters(&points, members).map(|quarter| {
                let share = share * members.len() as f32 / quarter.len() as f32;
                self.cluster(&points, &quarter, share)
            })
        };
        super::parted(&points, count).iter().map(quarter).collect()
    }
}

/// Four parts of equal size, as compact as halving twice makes them; of fewer than four points, all of them each time.
fn quarters(points: &[Spot], members: &[usize]) -> [Vec<usize>; QUARTERS] {
    if members.len() < QUARTERS {
        return std::array::from_fn(|_| members.to_vec());
    }
    let [a, b] = halves(points, members);
    let ([a, b], [c, d]) = (halves(points, &a), halves(points, &b));
    [a, b, c, d]
}

/// The members on either side of their median along the axis of their largest extent.
fn halves(points: &[Spot], members: &[usize]) -> [Vec<usize>; 2] {
    let positions = || members.iter().map(|i| points[*i].position);
    let low = positions().fold(Vec3::INFINITY, Vec3::min);
    let high = positions().fold(Vec3::NEG_INFINITY, Vec3::max);
    let axis = (high - low).max_position();
    let mut sorted = members.to_vec();
    let along = |i: &usize| points[*i].position[axis];
    sorted.sort_by(|a, b| along(a).total_cmp(&along(b)).then(a.cmp(b)));
    let upper = sorted.split_off(sorted.len() / 2);
    [sorted, upper]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glow::tests::square;

    #[test]
    fn quarters_have_the_power_of_the_whole_and_lie_apart() {
        let glow = square(5.0);
        let parts = glow.quartered(16);
        assert_eq!(parts.len(), 16);
        for quarter in 0..QUARTERS {
            let power: f32 = parts.iter().map(|q| q[quarter].lamp.strength).sum();
            assert!((power - 20.0).abs() < 1e-2, "{power}");
        }
        for part in &parts {
            let at = |i: usize| part[i].lamp.position;
            let apart = (0..QUARTERS).flat_map(|i| (0..i).map(move |k| (i, k)));
            assert!(apart.into_iter().all(|(i, k)| (at(i) - at(k)).length() > 0.1));
        }
    }

    #[test]
    fn one_point_is_four_quarters() {
        let (points, _) = square(1.0).spots(3);
        assert_eq!(quarters(&points, &[1]), [vec![1], vec![1], vec![1], vec![1]]);
    }
}
