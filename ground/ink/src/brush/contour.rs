//! Lines of equal value through scattered nodes of a grid, as closed polygons (marching squares).
//!
//! Positive is inside and on the right of the way around, y down, so that holes run against the
//! outlines around them and the nonzero rule fills what is inside. Nodes that are missing are outside.

use chiaro_basis::math::Vec2;
use std::collections::BTreeMap;

/// A node's row and column.
pub(super) type Node = [i32; 2];
/// An edge from a node, down or to the right.
type Edge = (Node, bool);

/// The border of where `nodes` are positive, in units of the grid.
pub(super) fn contours(nodes: &BTreeMap<Node, f32>) -> Vec<Vec<Vec2>> {
    let mut steps: BTreeMap<Edge, (Edge, Vec2)> = BTreeMap::new();
    for &[y, x] in nodes.keys() {
        // The cell belongs to the first of its nodes that there is.
        for corner in [[y, x], [y, x - 1], [y - 1, x], [y - 1, x - 1]] {
            let around = |[y, x]: Node| [[y, x], [y, x + 1], [y + 1, x], [y + 1, x + 1]];
            if around(corner).into_iter().find(|n| nodes.contains_key(n)) == Some([y, x]) {
                cross(nodes, corner, &mut steps);
            }
        }
    }
    let mut found = Vec::new();
    while let Some((first, (mut next, at))) = steps.pop_first() {
        let mut polygon = vec![at];
        while next != first {
            let Some((after, at)) = steps.remove(&next) else { break };
            polygon.push(at);
            next = after;
        }
        found.push(polygon);
    }
    found
}

/// The pieces of the border in a cell: from each edge by which it comes in to that by which it leaves.
fn cross(nodes: &BTreeMap<Node, f32>, [y, x]: Node, steps: &mut BTreeMap<Edge, (Edge, Vec2)>) {
    let corners = [[y, x], [y, x + 1], [y + 1, x + 1], [y + 1, x]];
    let edges = [([y, x], false), ([y, x + 1], true), ([y + 1, x], false), ([y, x], true)];
    let value = corners.map(|n| nodes.get(&n).copied().unwrap_or(-1.0));
    let inside = value.map(|v| v > 0.0);
    // Clockwise as seen: the border comes in where inside ends and leaves where it begins again.
    let comes: Vec<usize> = (0..4).filter(|&k| inside[k] && !inside[(k + 1) % 4]).collect();
    let joined = value.iter().sum::<f32>() > 0.0;
    for &k in &comes {
        // Over a saddle it goes to the near side of what is outside, or around what is inside.
        let leaves = |k: usize| !inside[k] && inside[(k + 1) % 4];
        let forward = (1..4).map(|i| (k + i) % 4).find(|&k| leaves(k));
        let backward = (1..4).map(|i| (k + 4 - i) % 4).find(|&k| leaves(k));
        let Some(out) = (if joined { forward } else { backward }) else { continue };
        let (a, b) = (value[k], value[(k + 1) % 4]);
        let place = |n: Node| Vec2::new(n[1] as f32, n[0] as f32);
        let at = place(corners[k]).lerp(place(corners[(k + 1) % 4]), a / (a - b));
        steps.insert(edges[k], (edges[out], at));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(p: &[Vec2]) -> f32 {
        (0..p.len()).map(|i| 0.5 * p[i].perp_dot(p[(i + 1) % p.len()])).sum()
    }

    #[test]
    fn a_ring_has_an_outline_and_a_hole() {
        let mut nodes = BTreeMap::new();
        for y in -30..30 {
            for x in -30..30 {
                let far = (x as f32).hypot(y as f32);
                nodes.insert([y, x], 4.0 - (far - 15.3).abs());
            }
        }
        let found = contours(&nodes);
        let mut areas: Vec<f32> = found.iter().map(|p| area(p)).collect();
        areas.sort_by(f32::total_cmp);
        let of = |r: f32| std::f32::consts::PI * r * r;
        assert_eq!(areas.len(), 2);
        assert!(areas[0] * areas[1] < 0.0);
        assert!((areas.iter().sum::<f32>().abs() - (of(19.3) - of(11.3))).abs() < 4.0);
    }

    #[test]
    fn saddles_and_lone_nodes_close() {
        let value = |i: i32| ((i as u32).wrapping_mul(2_654_435_761) >> 16) as f32 / 32768.0 - 1.0;
        let nodes: BTreeMap<Node, f32> =
            (0..400).filter(|i| i % 3 > 0).map(|i| ([i / 20, i % 20], value(i))).collect();
        let found = contours(&nodes);
        assert!(found.len() > 20 && found.iter().all(|p| p.len() > 2));
        let total: f32 = found.iter().map(|p| area(p)).sum();
        assert!(total.abs() > 20.0);
        assert!(contours(&BTreeMap::new()).is_empty());
    }
}
