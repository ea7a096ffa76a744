//! The flow behind a cut of a grid or lattice, as a certificate that [`verify`] accepts.
//!
//! A solver hands out what each link carries. What the terminals send follows, since a node gives
//! away what it takes in; whether their capacities allow that is what the check finds out.

use crate::capacity::Capacity;
use crate::certificate::{Flaw, verify, verify_bound};
use crate::grid::{Grid, GridError, MAX_NEIGHBOUR};
use crate::lattice::Lattice;
use crate::sparse::{Edge, Graph, GraphCut};
use crate::{Cut, solved};

/// What a fixed pixel pays for the wrong label: more than all its links.
const FIXED: i64 = 64 * MAX_NEIGHBOUR as i64;

impl From<&Lattice<'_>> for Graph {
    /// A node a pixel, those outside the mask without capacities; an edge for each link between two
    /// nodes, pixel by pixel. A fixed pixel pays its terminal, and very much for the wrong label.
    fn from(lattice: &Lattice) -> Self {
        let mut graph = Self::new(lattice.pixels());
        for pixel in (0..lattice.pixels()).filter(|&p| lattice.mask[p]) {
            graph.terminal[pixel] = lattice.terminal[pixel].map(i64::from);
            if let Some(Some(white)) = lattice.fixed.get(pixel) {
                let [paid, unpaid] = if *white { [1, 0] } else { [0, 1] };
                graph.terminal[pixel][unpaid] = FIXED + graph.terminal[pixel][paid];
            }
        }
        let edge = |(pixel, link, end)| {
            let [forth, back] = lattice.capacity(pixel, link).map(i64::from);
            Edge { ends: [pixel as u32, end as u32], forth, back }
        };
        graph.edges = edges(lattice).map(edge).collect();
        graph
    }
}

/// The links between nodes: pixel, link, and the pixel it leads to.
fn edges<'a>(lattice: &'a Lattice) -> impl Iterator<Item = (usize, usize, usize)> + 'a {
    (0..lattice.pixels()).flat_map(move |pixel| {
        (0..lattice.links()).filter_map(move |link| Some((pixel, link, lattice.end(pixel, link)?)))
    })
}

/// The canonical minimal cut of `grid` as [`solve`](crate::solve) finds it, and the flow to the
/// east, south-east, south and south-west of each pixel, negative if it comes from there.
///
/// # Errors
/// As [`solve`](crate::solve).
pub fn solve_flow(grid: &Grid) -> Result<(Cut, Vec<[i32; 4]>), GridError> {
    grid.check()?;
    if grid.mask.is_empty() {
        return Ok((Cut { labels: Vec::new(), flow: 0, cut: 0 }, Vec::new()));
    }
    let found = flow::<i16>(grid).or_else(|| flow::<i32>(grid));
    Ok(found.expect("a checked grid fits 32 bits"))
}

fn flow<C: Capacity>(grid: &Grid) -> Option<(Cut, Vec<[i32; 4]>)> {
    let (search, constant) = solved::<C>(grid, 1)?;
    let mut links = vec![[0; 4]; grid.mask.len()];
    for (pixel, link, _) in edges(&grid.into()) {
        let node = search.network.row(pixel / grid.width).start + pixel % grid.width;
        links[pixel][link] = grid.neighbour[pixel][link] - search.network.link(node, link);
    }
    Some((crate::read(grid, search, constant, 1), links))
}

/// Checks that `cut` is the canonical minimal cut of `grid`, with the flow of [`solve_flow`] as the
/// proof: capacities, conservation at every pixel, flow equal to cut.
///
/// # Errors
/// The first [`Flaw`] found.
///
/// # Panics
/// When `grid` is not one that can be solved.
pub fn verify_grid(grid: &Grid, cut: &Cut, links: &[[i32; 4]]) -> Result<(), Flaw> {
    if links.len() != grid.mask.len() {
        return Err(Flaw::Length);
    }
    let (graph, edge_flow) = stated(&grid.into(), |p, link| i64::from(links[p][link]));
    let mut given = vec![0; graph.terminal.len()];
    for (edge, flow) in graph.edges.iter().zip(&edge_flow) {
        given[edge.ends[0] as usize] += flow;
        given[edge.ends[1] as usize] -= flow;
    }
    let terminal_flow = graph.terminal.iter().zip(given);
    let terminal_flow = terminal_flow.map(|(&[white, black], given): (_, i64)| {
        let direct = white.min(black);
        [direct + given.max(0), direct + (-given).max(0)]
    });
    let terminal_flow = terminal_flow.collect();
    let Cut { labels, flow, cut } = cut.clone();
    verify(&graph, &GraphCut { labels, flow, cut, edge_flow, terminal_flow })
}

/// Checks that `labels` are the canonical minimal cut of `lattice`, with `link(pixel, link)` as what
/// each link carries, such as [`Solver::link_flow`](crate::Solver::link_flow).
///
/// After changes, what the links of a solver carry need not come from terminals, but it bounds every
/// cut from below; the check is that `flow` is this bound and the labels cost as much.
///
/// # Errors
/// The first [`Flaw`] found.
///
/// # Panics
/// When `lattice` does not pass [`Lattice::check`].
pub fn verify_lattice(
    lattice: &Lattice,
    labels: &[bool],
    flow: i64,
    link: impl Fn(usize, usize) -> i64,
) -> Result<(), Flaw> {
    let (graph, edge_flow) = stated(lattice, link);
    verify_bound(&graph, labels, flow, &edge_flow)
}

/// A lattice as a graph, and what its edges carry.
fn stated(lattice: &Lattice, link: impl Fn(usize, usize) -> i64) -> (Graph, Vec<i64>) {
    let edge_flow = edges(lattice).map(|(pixel, l, _)| link(pixel, l)).collect();
    (Graph::from(lattice), edge_flow)
}
