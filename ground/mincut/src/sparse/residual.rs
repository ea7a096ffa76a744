//! The residual graph: arcs in pairs, sorted by their tail.
//!
//! Capacities above the bound of [`Graph::check`] are cut down to it. No flow reaches the bound, so
//! such an arc is never saturated and no minimal cut pays for it, before as after.

use super::graph::Graph;

/// No arc.
pub(super) const NO_ARC: u32 = u32::MAX;

/// One direction of an edge.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Arc {
    /// Where it leads.
    pub(super) head: u32,
    /// The other direction.
    pub(super) sister: u32,
    /// What can still flow.
    pub(super) residual: i64,
}

/// The arcs of all nodes, and what each node holds.
pub(super) struct Residual {
    /// Where the arcs of a node begin; one more for the end of the last.
    first: Vec<u32>,
    pub(super) arcs: Vec<Arc>,
    /// From the white terminal if positive, to the black one if negative.
    pub(super) excess: Vec<i64>,
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
        Self { first, arcs, excess, place }
    }

    /// Nodes.
    pub(super) fn len(&self) -> usize {
        self.excess.len()
    }

    /// The arcs that leave `v`.
    #[inline(always)]
    pub(super) fn arcs_of(&self, v: u32) -> std::ops::Range<u32> {
        self.first[v as usize]..self.first[v as usize + 1]
    }

    /// Moves `amount` along arc `a`; whether that closes it.
    #[inline(always)]
    pub(super) fn push(&mut self, a: u32, amount: i64) -> bool {
        let arc = &mut self.arcs[a as usize];
        arc.residual -= amount;
        let (closed, sister) = (arc.residual == 0, arc.sister);
        self.arcs[sister as usize].residual += amount;
        closed
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

/// What one terminal has over the other.
fn excess(terminal: [i64; 2], bound: i64) -> i64 {
    terminal[0].min(bound) - terminal[1].min(bound)
}
