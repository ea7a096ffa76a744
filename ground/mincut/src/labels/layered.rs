//! The layered graph: any prices, convex distances, one cut (Ishikawa 2003).
//!
//! A pixel has a node for each level `j` from 1 on, white where its label is `j` or more. Between
//! levels lies the price of the label between them. An edge from level `i` of a pixel to level `j`
//! of its neighbour is cut where the first label reaches `i` and the second does not reach `j`; with
//! the second difference of the distance at `i - j` as its capacity, a pair that is `d` apart pays
//! the distance of `d`, since the differences add up to it.

use super::{Distance, LabelError, LabelGrid};
use crate::sparse::{Edge, Graph, GraphError, MAX_NODES, solve_graph};

/// The labels of least energy, the lowest of several.
pub(super) fn labels(grid: &LabelGrid) -> Result<Vec<u8>, LabelError> {
    let levels = grid.labels - 1;
    if levels == 0 {
        return Ok(vec![0; grid.mask.len()]);
    }
    let nodes = grid.mask.len() * levels;
    if nodes > MAX_NODES {
        return Err(GraphError::TooLarge { nodes, edges: 0 }.into());
    }
    let mut graph = Graph::new(nodes);
    for pixel in (0..grid.mask.len()).filter(|&p| grid.mask[p]) {
        stack(grid, pixel, &mut graph);
    }
    let bonds = bonds(grid);
    for (p, link, q) in grid.edges() {
        for &(i, j, bond) in &bonds {
            let capacity = i64::from(grid.neighbour[p][link]) * bond;
            let ends = |p: usize, q: usize| [(p * levels + i) as u32, (q * levels + j) as u32];
            if i == j {
                graph.edges.push(Edge { ends: ends(p, q), forth: capacity, back: capacity });
            } else {
                graph.edges.push(Edge { ends: ends(p, q), forth: capacity, back: 0 });
                graph.edges.push(Edge { ends: ends(q, p), forth: capacity, back: 0 });
            }
        }
    }
    let white = solve_graph(&graph)?.labels;
    let height = |stack: &[bool]| stack.iter().filter(|w| **w).count() as u8;
    Ok(white.chunks_exact(levels).map(height).collect())
}

/// The nodes of a pixel: a higher level is never white above a black one.
fn stack(grid: &LabelGrid, pixel: usize, graph: &mut Graph) {
    let levels = grid.labels - 1;
    let first = pixel * levels;
    graph.terminal[first][0] = grid.price(pixel, 0);
    graph.terminal[first + levels - 1][1] = grid.price(pixel, levels);
    for level in 1..levels {
        let ends = [first + level - 1, first + level].map(|v| v as u32);
        graph.edges.push(Edge { ends, forth: grid.price(pixel, level), back: i64::MAX });
    }
}

/// Pairs of levels that are joined between neighbours, counted from 0, with their capacity for a
/// neighbour of 1.
fn bonds(grid: &LabelGrid) -> Vec<(usize, usize, i64)> {
    let levels = grid.labels - 1;
    let distance = |a: usize, b: usize| grid.distance.between(grid.labels, a, b);
    let bond = |i: usize, j: usize| match grid.distance {
        Distance::Tones(_) if i == j => distance(i, i + 1),
        Distance::Tones(_) => 0,
        _ if i == j => distance(0, 1),
        _ => distance(0, i - j + 1) - 2 * distance(0, i - j) + distance(0, i - j - 1),
    };
    let pairs = (0..levels).flat_map(|i| (0..=i).map(move |j| (i, j)));
    pairs.map(|(i, j)| (i, j, bond(i, j))).filter(|b| b.2 > 0).collect()
}
