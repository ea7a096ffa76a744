//! The residual graph: arcs in pairs, sorted by their tail.
//!
//! Capacities above the bound of [`Graph::check`] are cut down to it. No flow reaches the bound, so
//! such an arc is never saturated and no minimal cut pays for it, before as after.

use super::graph::Graph;
use crate::network::{Network, Side};
use std::cell::Cell;
use std::ops::Range;

/// No arc.
const NO_ARC: u32 = u32::MAX;

/// One direction of an edge.
#[derive(Clone, Copy, Debug, Default)]
struct Arc {
    /// Where it leads.
    head: u32,
    /// The other direction.
    sister: u32,
    /// What can still flow.
    residual: i64,
}

/// Where a look at the arcs of a node goes on, as long as it keeps its label.
///
/// While a node keeps its label, an arc that led to no parent, or to no contact, leads to none
/// later: labels only rise, and a node set free comes back above all that has grown. So each label
/// costs a fixed number of looks at an arc (Goldberg and Tarjan 1988, "current arc").
#[derive(Clone, Debug, Default)]
struct Current(Cell<(i32, u32)>);

impl Current {
    /// The arcs of `range` that are still to be looked at under `label`.
    #[inline(always)]
    fn rest(&self, label: i32, range: &Range<u32>) -> Range<u32> {
        let (at, arc) = self.0.get();
        if at == label { arc..range.end } else { range.clone() }
    }
}

/// The arcs of all nodes, and what each node holds.
pub(super) struct Residual {
    /// Where the arcs of a node begin; one more for the end of the last.
    first: Vec<u32>,
    arcs: Vec<Arc>,
    /// From the white terminal if positive, to the black one if negative.
    excess: Vec<i64>,
    /// The looks for a parent and for a contact.
    current: [Vec<Current>; 2],
    /// The arc of each edge, from its first end to its second.
    place: Vec<u32>,
}

impl Residual {
    /// Lays out a checked graph with the bound of its check.
    pub(super) fn new(graph: &Graph, bound: i64) -> Self {
        let nodes = graph.terminal.len();
        let mut first = vec![0; nodes + 1];
        let joins = |e: &&super::Edge| e.ends[0] != e.ends[1];
        for v in graph.edges.iter().filter(joins).flat_map(|e| e.ends) {
            first[v as usize + 1] += 1;
        }
        for v in 0..nodes {
            first[v + 1] += first[v];
        }
        let mut arcs = vec![Arc::default(); first[nodes] as usize];
        let mut next = first.clone();
        let mut place = vec![NO_ARC; graph.edges.len()];
        for (edge, place) in graph.edges.iter().zip(&mut place).filter(|(e, _)| joins(e)) {
            let [tail, head] = edge.ends;
            let mut take = |v: u32| {
                next[v as usize] += 1;
                next[v as usize] - 1
            };
            let (forth, back) = (take(tail), take(head));
            arcs[forth as usize] = Arc { head, sister: back, residual: edge.forth.min(bound) };
            arcs[back as usize] = Arc { head: tail, sister: forth, residual: edge.back.min(bound) };
            *place = forth;
        }
        let excess = graph.terminal.iter().map(|&t| excess(t, bound)).collect();
        let current = [(); 2].map(|()| vec![Current::default(); nodes]);
        Self { first, arcs, excess, current, place }
    }

    /// The arcs that leave `v`.
    #[inline(always)]
    fn arcs_of(&self, v: usize) -> Range<u32> {
        self.first[v]..self.first[v + 1]
    }

    /// Whether the tree grows over arc `a`.
    #[inline(always)]
    fn is_open<T: Side>(&self, a: u32) -> bool {
        let arc = self.arcs[a as usize];
        let arc = if T::WHITE { arc } else { self.arcs[arc.sister as usize] };
        arc.residual > 0
    }

    #[inline(always)]
    fn head_of(&self, a: u32) -> usize {
        self.arcs[a as usize].head as usize
    }

    /// The flow of each edge.
    pub(super) fn edge_flow(&self, graph: &Graph, bound: i64) -> Vec<i64> {
        let flow = |(edge, &place): (&super::Edge, &u32)| match place {
            NO_ARC => 0,
            a => edge.forth.min(bound) - self.arcs[a as usize].residual,
        };
        graph.edges.iter().zip(&self.place).map(flow).collect()
    }

    /// The flow of each node from the white terminal and to the black one.
    pub(super) fn terminal_flow(&self, graph: &Graph, bound: i64) -> Vec<[i64; 2]> {
        let flow = |(&terminal, &left): (&[i64; 2], &i64)| {
            let direct = terminal[0].min(terminal[1]);
            let sent = excess(terminal, bound) - left;
            [direct + sent.max(0), direct + (-sent).max(0)]
        };
        graph.terminal.iter().zip(&self.excess).map(flow).collect()
    }
}

impl Network for Residual {
    type Arc = u32;
    type Label = i32;
    const ROOT: u32 = NO_ARC - 1;
    const NONE: u32 = NO_ARC;
    const LOST: u32 = NO_ARC - 2;

    fn len(&self) -> usize {
        self.excess.len()
    }

    #[inline(always)]
    fn excess(&self, v: usize) -> i64 {
        self.excess[v]
    }

    #[inline(always)]
    fn drain(&mut self, v: usize, amount: i64) -> bool {
        self.excess[v] -= self.excess[v].signum() * amount;
        self.excess[v] == 0
    }

    #[inline(always)]
    fn head(&self, _: usize, a: u32) -> usize {
        self.head_of(a)
    }

    #[inline(always)]
    fn back(&self, _: usize, a: u32) -> u32 {
        self.arcs[a as usize].sister
    }

    #[inline(always)]
    fn residual(&self, _: usize, a: u32) -> i64 {
        self.arcs[a as usize].residual
    }

    #[inline(always)]
    fn push(&mut self, _: usize, a: u32, amount: i64) -> bool {
        let arc = &mut self.arcs[a as usize];
        arc.residual -= amount;
        let (closed, sister) = (arc.residual == 0, arc.sister);
        self.arcs[sister as usize].residual += amount;
        closed
    }

    /// Any parent below the label of `v` does: it is as good to the search as the lowest.
    fn lowest<T: Side>(&self, label: &[i32], v: usize) -> Option<(i32, u32)> {
        let (old, arcs) = (label[v], self.arcs_of(v));
        let mut least = (i32::MAX, NO_ARC);
        let offer = |a: u32, below: i32| {
            let distance = T::distance(label[self.head_of(a)]);
            let leads = (1..below).contains(&distance);
            (leads && self.is_open::<T>(self.arcs[a as usize].sister)).then_some(distance)
        };
        let current = &self.current[0][v].0;
        for a in self.current[0][v].rest(old, &arcs) {
            if let Some(distance) = offer(a, T::distance(old)) {
                current.set((old, a));
                return Some((distance, a));
            }
        }
        for a in arcs {
            if let Some(distance) = offer(a, least.0) {
                least = (distance, a);
            }
        }
        (least.1 != NO_ARC).then_some(least)
    }

    fn contact<T: Side>(&self, label: &[i32], v: usize) -> Option<u32> {
        let (mine, arcs) = (label[v], self.arcs_of(v));
        let meets = |a: u32| T::distance(label[self.head_of(a)]) < 0 && self.is_open::<T>(a);
        let found = self.current[1][v].rest(mine, &arcs).find(|&a| meets(a));
        self.current[1][v].0.set((mine, found.unwrap_or(arcs.end)));
        found
    }

    fn each_free<T: Side>(
        &self,
        label: &mut [i32],
        v: usize,
        mut take: impl FnMut(&mut [i32], usize, u32),
    ) {
        for a in self.arcs_of(v) {
            let w = self.head_of(a);
            if label[w] == 0 && self.is_open::<T>(a) {
                take(label, w, self.arcs[a as usize].sister);
            }
        }
    }

    fn each_lost<T: Side>(&self, parent: &[u32], v: usize, mut visit: impl FnMut(usize)) {
        for a in self.arcs_of(v) {
            let w = self.head_of(a);
            if parent[w] == Self::LOST && self.is_open::<T>(a) {
                visit(w);
            }
        }
    }

    fn each_child(&self, parent: &mut [u32], v: usize, mut visit: impl FnMut(&mut [u32], usize)) {
        for a in self.arcs_of(v) {
            let w = self.head_of(a);
            if parent[w] == self.arcs[a as usize].sister {
                visit(parent, w);
            }
        }
    }
}

/// What one terminal has over the other.
fn excess(terminal: [i64; 2], bound: i64) -> i64 {
    terminal[0].min(bound) - terminal[1].min(bound)
}
