//! Certificates: whether a solution is what it claims to be, checked from the problem alone.
//!
//! A flow that keeps to the capacities and is conserved at every node is no larger than any cut
//! (Ford and Fulkerson 1956). A flow and a cut of the same value therefore prove each other, and
//! whoever checks need not trust the solver. It takes one look at each edge, and a walk for the
//! canonical labels.

use crate::sparse::{Graph, GraphCut};
use std::fmt;

/// What is wrong with a solution.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Flaw {
    /// Not one label and flow a node, or not one flow an edge.
    Length,
    /// A flow below zero or beyond its capacity.
    Capacity {
        /// The edge, or the node whose terminal it is.
        place: String,
        /// The flow.
        flow: i64,
    },
    /// More flow into a node than out of it, or less.
    Conservation {
        /// The node.
        node: usize,
        /// What flows in less what flows out.
        surplus: i128,
    },
    /// The claimed flow is not what leaves the white terminal.
    Value {
        /// As claimed.
        flow: i64,
        /// As counted.
        counted: i128,
    },
    /// The cut's cost is not the flow: one of them is not optimal.
    Cut {
        /// The flow.
        flow: i64,
        /// The cost of the labels.
        cost: i128,
    },
    /// Minimal, but not the canonical cut.
    Canonical {
        /// A node that is white although white does not reach it, or the other way round.
        node: usize,
    },
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Length => write!(f, "there is not one label and flow for each node and edge"),
            Self::Capacity { place, flow } => {
                write!(f, "the flow of {place} is {flow}, which its capacity does not allow")
            }
            Self::Conservation { node, surplus } => {
                write!(f, "node {node} takes in {surplus} more than it gives away")
            }
            Self::Value { flow, counted } => {
                write!(f, "the flow claims to be {flow}, but {counted} leaves the white terminal")
            }
            Self::Cut { flow, cost } => write!(f, "the flow is {flow}, but the cut costs {cost}"),
            Self::Canonical { node } => {
                write!(f, "node {node} does not have the label of the canonical cut")
            }
        }
    }
}

impl std::error::Error for Flaw {}

/// Checks that `cut` is the canonical minimal cut of `graph`, and its flow a maximal one.
///
/// # Errors
/// The first [`Flaw`] found.
///
/// # Panics
/// When an edge of `graph` ends at no node.
pub fn verify(graph: &Graph, cut: &GraphCut) -> Result<(), Flaw> {
    let (nodes, edges) = (graph.terminal.len(), graph.edges.len());
    if [cut.labels.len(), cut.terminal_flow.len(), cut.edge_flow.len()] != [nodes, nodes, edges] {
        return Err(Flaw::Length);
    }
    verify_bounds(graph, cut)?;
    verify_conservation(graph, cut)?;
    let counted = cut.terminal_flow.iter().map(|t| i128::from(t[0])).sum();
    if counted != i128::from(cut.flow) {
        return Err(Flaw::Value { flow: cut.flow, counted });
    }
    let cost = graph.energy(&cut.labels);
    if cost != counted || cut.cut != cut.flow {
        return Err(Flaw::Cut { flow: cut.flow, cost });
    }
    let roots = |v: usize| cut.terminal_flow[v][0] < graph.terminal[v][0];
    verify_canonical(graph, &cut.labels, &cut.edge_flow, roots)
}

/// Checks that `labels` are the canonical minimal cut of `graph` by a lower bound, for flows that
/// need not be conserved: such as those of a solution that was changed and solved again.
///
/// Whatever the edges carry within their capacities, a cut pays each node's `white` where it is
/// black, its `black` and what its edges give away where it is white, and what the edges have left
/// (Kohli and Torr 2007, "reparametrization"). So the sum of the smaller of the two is no more than
/// any cut, and labels that cost as much are minimal.
pub(crate) fn verify_bound(
    graph: &Graph,
    labels: &[bool],
    flow: i64,
    edge_flow: &[i64],
) -> Result<(), Flaw> {
    if [labels.len(), edge_flow.len()] != [graph.terminal.len(), graph.edges.len()] {
        return Err(Flaw::Length);
    }
    verify_edges(graph, edge_flow)?;
    let mut paid: Vec<i128> = graph.terminal.iter().map(|t| i128::from(t[1])).collect();
    for (edge, &flow) in graph.edges.iter().zip(edge_flow) {
        paid[edge.ends[0] as usize] += i128::from(flow);
        paid[edge.ends[1] as usize] -= i128::from(flow);
    }
    let white = |v: usize| i128::from(graph.terminal[v][0]);
    let counted = (0..paid.len()).map(|v| paid[v].min(white(v))).sum();
    if counted != i128::from(flow) {
        return Err(Flaw::Value { flow, counted });
    }
    let cost = graph.energy(labels);
    if cost != counted {
        return Err(Flaw::Cut { flow, cost });
    }
    verify_canonical(graph, labels, edge_flow, |v| paid[v] < white(v))
}

/// Every flow is within its capacity.
fn verify_bounds(graph: &Graph, cut: &GraphCut) -> Result<(), Flaw> {
    verify_edges(graph, &cut.edge_flow)?;
    for (node, (flow, capacity)) in cut.terminal_flow.iter().zip(&graph.terminal).enumerate() {
        if let Some(side) = (0..2).find(|&side| !(0..=capacity[side]).contains(&flow[side])) {
            return Err(Flaw::Capacity { place: format!("node {node}"), flow: flow[side] });
        }
    }
    Ok(())
}

fn verify_edges(graph: &Graph, edge_flow: &[i64]) -> Result<(), Flaw> {
    for (index, (&flow, edge)) in edge_flow.iter().zip(&graph.edges).enumerate() {
        if !(-edge.back..=edge.forth).contains(&flow) {
            return Err(Flaw::Capacity { place: format!("edge {index}"), flow });
        }
    }
    Ok(())
}

/// What flows into a node flows out of it.
fn verify_conservation(graph: &Graph, cut: &GraphCut) -> Result<(), Flaw> {
    let surplus = |&[white, black]: &[i64; 2]| i128::from(white) - i128::from(black);
    let mut surplus: Vec<i128> = cut.terminal_flow.iter().map(surplus).collect();
    for (edge, &flow) in graph.edges.iter().zip(&cut.edge_flow) {
        surplus[edge.ends[0] as usize] -= i128::from(flow);
        surplus[edge.ends[1] as usize] += i128::from(flow);
    }
    match surplus.iter().position(|&s| s != 0) {
        Some(node) => Err(Flaw::Conservation { node, surplus: surplus[node] }),
        None => Ok(()),
    }
}

/// White is exactly what is reached from the roots over what the flow leaves.
fn verify_canonical(
    graph: &Graph,
    labels: &[bool],
    edge_flow: &[i64],
    is_root: impl Fn(usize) -> bool,
) -> Result<(), Flaw> {
    let reached = reached(graph, edge_flow, is_root);
    match (0..labels.len()).find(|&v| reached[v] != labels[v]) {
        Some(node) => Err(Flaw::Canonical { node }),
        None => Ok(()),
    }
}

fn reached(graph: &Graph, edge_flow: &[i64], is_root: impl Fn(usize) -> bool) -> Vec<bool> {
    // The edges of each node, one after the other.
    let mut first = vec![0usize; graph.terminal.len() + 1];
    for v in graph.edges.iter().flat_map(|e| e.ends) {
        first[v as usize + 1] += 1;
    }
    for v in 0..graph.terminal.len() {
        first[v + 1] += first[v];
    }
    let mut next = first.clone();
    let mut sorted = vec![0u32; 2 * graph.edges.len()];
    for (index, edge) in graph.edges.iter().enumerate() {
        for v in edge.ends.map(|v| v as usize) {
            sorted[next[v]] = index as u32;
            next[v] += 1;
        }
    }
    let mut queue: Vec<usize> = (0..graph.terminal.len()).filter(|&v| is_root(v)).collect();
    let mut reached = vec![false; graph.terminal.len()];
    queue.iter().for_each(|&v| reached[v] = true);
    while let Some(v) = queue.pop() {
        for &index in &sorted[first[v]..first[v + 1]] {
            let (edge, flow) = (graph.edges[index as usize], edge_flow[index as usize]);
            let [a, b] = edge.ends.map(|v| v as usize);
            let open = |from: usize| if from == a { flow < edge.forth } else { -flow < edge.back };
            let w = if v == a { b } else { a };
            if !reached[w] && open(v) {
                reached[w] = true;
                queue.push(w);
            }
        }
    }
    reached
}
