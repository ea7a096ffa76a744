//! General sparse graphs: the problem, its solution, and the search.
//!
//! [`Graph`] states it, [`residual`] lays it out as arcs sorted by tail, on which the search is the
//! same as on grids. Everything is an `i64`; what could not fit is refused or, where no cut can tell
//! the difference, cut down first.

mod graph;
mod residual;

pub use graph::{Edge, Graph, GraphError, MAX_EDGES, MAX_FLOW, MAX_NODES};

use crate::search::Search;
use residual::Residual;

/// The canonical minimal cut of a [`Graph`], and a maximal flow as its proof.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GraphCut {
    /// One label a node: `true` is white, what the white terminal still reaches.
    pub labels: Vec<bool>,
    /// The maximal flow.
    pub flow: i64,
    /// The cost of `labels`, counted anew from the graph; equal to `flow`.
    pub cut: i64,
    /// The flow of each edge, from its first end to its second, negative if it goes back.
    pub edge_flow: Vec<i64>,
    /// The flow of each node from the white terminal, and to the black one.
    pub terminal_flow: Vec<[i64; 2]>,
}

/// Finds the canonical minimal cut of `graph` and a maximal flow.
///
/// # Errors
/// A [`GraphError`] when the graph is beyond its limits.
///
/// ```
/// use chiaro_mincut::{Edge, Graph, solve_graph};
///
/// // white -7-> 0 -4-> 1 -9-> black
/// let graph = Graph {
///     terminal: vec![[7, 0], [0, 9]],
///     edges: vec![Edge { ends: [0, 1], forth: 4, back: 0 }],
/// };
/// let cut = solve_graph(&graph)?;
/// assert_eq!((cut.flow, cut.cut), (4, 4));
/// assert_eq!(cut.labels, [true, false]);
/// assert_eq!(cut.edge_flow, [4]);
/// # Ok::<(), chiaro_mincut::GraphError>(())
/// ```
pub fn solve_graph(graph: &Graph) -> Result<GraphCut, GraphError> {
    let bound = graph.check()?;
    let mut search = Search::new(Residual::new(graph, bound));
    search.run().expect("distances are at most twice the number of nodes");
    let labels: Vec<bool> = (0..graph.terminal.len()).map(|v| search.is_white(v)).collect();
    let residual = &search.network;
    let terminal_flow = residual.terminal_flow(graph, bound);
    let edge_flow = residual.edge_flow(graph, bound);
    let flow = terminal_flow.iter().map(|&[white, _]| white).sum();
    // The flow is below the bound, and so is its cut.
    let cut = i64::try_from(graph.energy(&labels)).unwrap_or(i64::MAX);
    debug_assert_eq!(flow, cut, "a maximal flow equals its cut");
    Ok(GraphCut { labels, flow, cut, edge_flow, terminal_flow })
}
