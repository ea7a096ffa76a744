//! [`Tree`]: the nearest of many points, by a balanced k-d tree without pointers (Bentley 1975).

use chiaro_basis::math::Vec3;
use std::collections::BinaryHeap;

/// Points of a leaf.
const LEAF: usize = 8;

/// A k-d tree: points in an order in which the middle of every range parts it along the range's
/// longest axis.
pub(super) struct Tree {
    order: Vec<u32>,
    /// The axis along which a range with this middle is parted.
    axes: Vec<u8>,
}

/// A squared distance and a point; greater when farther, or as far with a higher index.
#[derive(Clone, Copy, PartialEq)]
struct Far(f32, u32);

impl Eq for Far {}

impl Ord for Far {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

impl PartialOrd for Far {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Tree {
    /// The tree of some points, which must be finite.
    pub(super) fn new(points: &[Vec3]) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        let mut axes = vec![0; points.len()];
        part(points, &mut order, &mut axes);
        Self { order, axes }
    }

    /// The `count` points nearest to a place with their squared distances, nearest first.
    pub(super) fn nearest(&self, points: &[Vec3], place: Vec3, count: usize) -> Vec<(f32, u32)> {
        let mut best = BinaryHeap::with_capacity(count + 1);
        self.look(points, place, count, 0..self.order.len(), &mut best);
        best.into_sorted_vec().into_iter().map(|f| (f.0, f.1)).collect()
    }

    fn look(
        &self,
        points: &[Vec3],
        place: Vec3,
        count: usize,
        range: std::ops::Range<usize>,
        best: &mut BinaryHeap<Far>,
    ) {
        let mut offer = |index: u32| {
            best.push(Far((points[index as usize] - place).length_squared(), index));
            if best.len() > count {
                best.pop();
            }
        };
        if range.len() <= LEAF {
            self.order[range].iter().for_each(|i| offer(*i));
            return;
        }
        let middle = range.start + range.len() / 2;
        offer(self.order[middle]);
        let axis = self.axes[middle] as usize;
        let across = place[axis] - points[self.order[middle] as usize][axis];
        let sides = [range.start..middle, middle + 1..range.end];
        let [near, far] = if across < 0.0 { [0, 1] } else { [1, 0] };
        self.look(points, place, count, sides[near].clone(), best);
        let worst = best.peek().map_or(f32::INFINITY, |f| f.0);
        if best.len() < count || across * across <= worst {
            self.look(points, place, count, sides[far].clone(), best);
        }
    }
}

/// Orders a range around its middle, and its halves in turn.
fn part(points: &[Vec3], order: &mut [u32], axes: &mut [u8]) {
    if order.len() <= LEAF {
        return;
    }
    let at = |i: &u32| points[*i as usize];
    let low = order.iter().map(at).fold(Vec3::INFINITY, Vec3::min);
    let high = order.iter().map(at).fold(Vec3::NEG_INFINITY, Vec3::max);
    let size = (high - low).to_array();
    let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |a, b| at(a)[axis].total_cmp(&at(b)[axis]).then(a.cmp(b)));
    axes[middle] = axis as u8;
    let (left, right) = order.split_at_mut(middle);
    let (left_axes, right_axes) = axes.split_at_mut(middle);
    rayon::join(
        || part(points, left, left_axes),
        || part(points, &mut right[1..], &mut right_axes[1..]),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random::unit;

    #[test]
    fn the_nearest_are_those_that_a_plain_search_finds() {
        let at = |i: u64| Vec3::new(unit(1, i), unit(2, i), (4.0 * unit(3, i)).floor());
        let points: Vec<Vec3> = (0..2000).map(at).collect();
        let tree = Tree::new(&points);
        for place in (5000..5050).map(at) {
            let mut all: Vec<(f32, u32)> = (0..2000)
                .map(|i: u32| ((points[i as usize] - place).length_squared(), i))
                .collect();
            all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            assert_eq!(tree.nearest(&points, place, 9), all[..9]);
        }
        assert_eq!(Tree::new(&points[..3]).nearest(&points[..3], Vec3::ZERO, 9).len(), 3);
    }
}
