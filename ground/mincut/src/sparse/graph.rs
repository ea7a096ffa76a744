//! [`Graph`]: the problem as the caller states it, its limits, and the cost of a labelling.

use std::fmt;

/// The most nodes a graph may have: 2^29.
pub const MAX_NODES: usize = 1 << 29;
/// The most edges a graph may have: 2^30.
pub const MAX_EDGES: usize = 1 << 30;
/// What the terminals of one side at least must not sum beyond: 2^61. Single capacities may be as
/// large as an `i64`.
pub const MAX_FLOW: i64 = 1 << 61;

/// Nodes with two terminals each, and edges between them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Graph {
    /// Of each node `[white, black]`, both 0 or more: `white` is paid when the node ends black,
    /// `black` when it ends white.
    pub terminal: Vec<[i64; 2]>,
    /// Edges; several may join the same nodes, and one that joins a node to itself costs nothing.
    pub edges: Vec<Edge>,
}

/// Two nodes, and what it costs to part them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Indices of the nodes.
    pub ends: [u32; 2],
    /// Paid when the first end is white and the second black.
    pub forth: i64,
    /// Paid when the first end is black and the second white.
    pub back: i64,
}

/// Why a [`Graph`] has no cut.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GraphError {
    /// More than [`MAX_NODES`] nodes or [`MAX_EDGES`] edges.
    TooLarge {
        /// Nodes.
        nodes: usize,
        /// Edges.
        edges: usize,
    },
    /// An edge that ends at no node.
    NoNode {
        /// The index of the edge.
        edge: usize,
        /// The index that is no node's.
        got: u32,
    },
    /// A capacity below zero.
    Negative {
        /// The edge, or the node whose terminal it is.
        place: String,
        /// The capacity.
        got: i64,
    },
    /// The terminals of both sides sum to more than [`MAX_FLOW`].
    TooMuchFlow,
}

impl fmt::Display for GraphError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::TooLarge { nodes, edges } => write!(
                f,
                "a graph of {nodes} nodes and {edges} edges is beyond the limit of {MAX_NODES} nodes and \
                 {MAX_EDGES} edges; cut it in parts"
            ),
            Self::NoNode { edge, got } => {
                write!(f, "edge {edge} ends at node {got}, which the graph does not have")
            }
            Self::Negative { place, got } => {
                write!(f, "a capacity of {place} is {got}; capacities are zero or more")
            }
            Self::TooMuchFlow => write!(
                f,
                "the terminals of both sides sum to more than 2^61; scale all capacities down"
            ),
        }
    }
}

impl std::error::Error for GraphError {}

impl Graph {
    /// A graph of nodes without terminals and edges.
    pub fn new(nodes: usize) -> Self {
        Self { terminal: vec![[0; 2]; nodes], edges: Vec::new() }
    }

    /// The cost of `labels` (`true` is white): the terminals and edges they cut.
    ///
    /// # Panics
    /// When there is not one label a node.
    pub fn energy(&self, labels: &[bool]) -> i128 {
        assert_eq!(labels.len(), self.terminal.len(), "one label a node");
        let terminals = self.terminal.iter().zip(labels);
        let terminals = terminals.map(|(&[white, black], &l)| if l { black } else { white });
        let edges = self.edges.iter().map(|e| match e.ends.map(|v| labels[v as usize]) {
            [true, false] => e.forth,
            [false, true] => e.back,
            _ => 0,
        });
        terminals.chain(edges).map(i128::from).sum()
    }

    /// Holds the graph to its limits; a bound that is above every flow, and so above every capacity
    /// that a minimal cut could pay.
    pub(crate) fn check(&self) -> Result<i64, GraphError> {
        let (nodes, edges) = (self.terminal.len(), self.edges.len());
        if nodes > MAX_NODES || edges > MAX_EDGES {
            return Err(GraphError::TooLarge { nodes, edges });
        }
        let mut sums = [0i128; 2];
        for (node, terminal) in self.terminal.iter().enumerate() {
            not_negative(*terminal, || format!("node {node}"))?;
            sums = [0, 1].map(|side| sums[side] + i128::from(terminal[side]));
        }
        for (index, edge) in self.edges.iter().enumerate() {
            not_negative([edge.forth, edge.back], || format!("edge {index}"))?;
            if let Some(&got) = edge.ends.iter().find(|&&v| v as usize >= nodes) {
                return Err(GraphError::NoNode { edge: index, got });
            }
        }
        match i64::try_from(sums[0].min(sums[1])) {
            Ok(flow) if flow < MAX_FLOW => Ok(flow + 1),
            _ => Err(GraphError::TooMuchFlow),
        }
    }
}

fn not_negative(capacities: [i64; 2], place: impl Fn() -> String) -> Result<(), GraphError> {
    match capacities.into_iter().find(|&c| c < 0) {
        Some(got) => Err(GraphError::Negative { place: place(), got }),
        None => Ok(()),
    }
}
