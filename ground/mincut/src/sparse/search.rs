//! The search: two breadth-first trees with distances, grown until no path is left.
//!
//! After Goldberg, Hed, Kaplan, Tarjan and Werneck, "Maximum flows by incremental breadth-first
//! search" (ESA 2011), and Goldberg, Hed, Kaplan, Kohli, Tarjan and Werneck, "Faster and more
//! dynamic maximum flow by incremental breadth-first search" (ESA 2015).
//!
//! 1. Every node with excess is a root: of the white tree if it is positive, of the black one if it
//!    is negative. Labels are distances from the terminal, positive in the white tree, negative in
//!    the black one, zero for a free node.
//! 2. The trees grow in turn, one level each: a node takes its free neighbours over open arcs.
//! 3. Where an open arc joins the white tree to the black one, the path through it is saturated.
//!    Nodes cut from their parent are orphans.
//! 4. Orphans, lowest first, adopt a parent of a lower label; else they move to the lowest label
//!    they can reach plus one, and their children at or below it become orphans; a node that only
//!    reaches levels which have not grown yet is set free.
//! 5. When the white tree cannot grow, the flow is maximal, and the white tree is what white still reaches.
//!
//! While a node keeps its label, an arc that led to no parent leads to none later: labels only
//! rise, and a node set free comes back above all that has grown. So the search for a parent goes
//! on at the node's current arc, and a label costs two looks at each of its arcs.

use super::residual::{NO_ARC, Residual};

/// The parent of a node that hangs from its terminal.
const ROOT: u32 = NO_ARC - 1;
/// How much farther than its parent a node is put when a tree grows: an orphan may then move up by
/// one and still keep its children.
const GAP: i32 = 2;

/// A node's place in a tree.
#[derive(Clone, Copy)]
struct Node {
    /// The distance, negative in the black tree, zero outside both.
    label: i32,
    /// The arc to the parent, [`ROOT`] or [`NO_ARC`].
    parent: u32,
    /// Where the search for a parent goes on.
    current: u32,
}

/// What is to grow in a tree and who lost its parent.
#[derive(Default)]
struct Tree {
    /// The level that has grown last; all below have.
    grown: i32,
    /// Nodes to grow, by distance modulo 2: at most two levels wait.
    active: [Vec<u32>; GAP as usize],
    orphans: Orphans,
}

/// Orphans by distance, lowest first.
#[derive(Default)]
struct Orphans {
    levels: Vec<Vec<u32>>,
    lowest: usize,
    waiting: usize,
}

impl Orphans {
    fn push(&mut self, v: u32, distance: usize) {
        if self.levels.len() <= distance {
            self.levels.resize_with(distance + 1, Vec::new);
        }
        self.lowest = if self.waiting == 0 { distance } else { self.lowest.min(distance) };
        self.levels[distance].push(v);
        self.waiting += 1;
    }

    fn pop(&mut self) -> Option<u32> {
        if self.waiting == 0 {
            return None;
        }
        loop {
            if let Some(v) = self.levels[self.lowest].pop() {
                self.waiting -= 1;
                return Some(v);
            }
            self.lowest += 1;
        }
    }
}

/// A tree, so that the code for both is written once.
trait Side {
    const WHITE: bool;
    type Other: Side;
}
struct White;
struct Black;
impl Side for White {
    const WHITE: bool = true;
    type Other = Black;
}
impl Side for Black {
    const WHITE: bool = false;
    type Other = White;
}

/// The search on a residual graph.
pub(super) struct Search {
    graph: Residual,
    nodes: Vec<Node>,
    /// The white tree, the black tree.
    trees: [Tree; 2],
}

impl Search {
    pub(super) fn new(graph: Residual) -> Self {
        let node = |v: usize| Node {
            label: graph.excess[v].signum() as i32,
            parent: if graph.excess[v] == 0 { NO_ARC } else { ROOT },
            current: graph.arcs_of(v as u32).start,
        };
        let nodes = (0..graph.len()).map(node).collect();
        Self { graph, nodes, trees: Default::default() }
    }

    pub(super) fn labels(&self) -> Vec<bool> {
        self.nodes.iter().map(|node| node.label > 0).collect()
    }

    pub(super) fn residual(&self) -> &Residual {
        &self.graph
    }

    /// Grows both trees, one level each in turn, until the white one cannot.
    pub(super) fn run(&mut self) {
        for v in 0..self.graph.len() as u32 {
            match self.nodes[v as usize].label {
                1 => self.tree::<White>().active[1].push(v),
                -1 => self.tree::<Black>().active[1].push(v),
                _ => {}
            }
        }
        while self.trees[0].active.iter().any(|level| !level.is_empty()) {
            self.grow_level::<White>();
            self.grow_level::<Black>();
        }
    }

    fn tree<T: Side>(&mut self) -> &mut Tree {
        &mut self.trees[usize::from(!T::WHITE)]
    }

    /// The distance of `v` in the tree, zero or less outside.
    #[inline(always)]
    fn distance<T: Side>(&self, v: u32) -> i32 {
        let label = self.nodes[v as usize].label;
        if T::WHITE { label } else { -label }
    }

    /// What can flow along arc `a` away from the tree's terminal, the arc's tail being nearer to it.
    #[inline(always)]
    fn outward<T: Side>(&self, a: u32) -> i64 {
        let arc = self.graph.arcs[a as usize];
        if T::WHITE { arc.residual } else { self.graph.arcs[arc.sister as usize].residual }
    }

    /// Moves `amount` along `a` away from the tree's terminal; whether that closes the arc.
    #[inline(always)]
    fn push_outward<T: Side>(&mut self, a: u32, amount: i64) -> bool {
        let arc = if T::WHITE { a } else { self.graph.arcs[a as usize].sister };
        self.graph.push(arc, amount)
    }

    fn grow_level<T: Side>(&mut self) {
        let tree = self.tree::<T>();
        if tree.active.iter().all(Vec::is_empty) {
            return;
        }
        tree.grown += 1;
        let (level, slot) = (tree.grown, tree.grown as usize % GAP as usize);
        for v in std::mem::take(&mut tree.active[slot]) {
            self.grow::<T>(v, level);
        }
    }

    /// Saturates every path from `v` to the other tree and takes the free neighbours, as long as
    /// `v` stays on its level.
    fn grow<T: Side>(&mut self, v: u32, level: i32) {
        for a in self.graph.arcs_of(v) {
            let w = self.graph.arcs[a as usize].head;
            while self.distance::<T>(v) == level
                && self.distance::<T>(w) < 0
                && self.outward::<T>(a) > 0
            {
                self.connect::<T>(v, a);
            }
            if self.distance::<T>(v) != level {
                return;
            }
            if self.nodes[w as usize].label == 0 && self.outward::<T>(a) > 0 {
                self.take::<T>(a, level);
            }
        }
    }

    /// Takes the free head of arc `a` into the tree.
    fn take<T: Side>(&mut self, a: u32, level: i32) {
        let arc = self.graph.arcs[a as usize];
        let distance = level + GAP;
        let label = if T::WHITE { distance } else { -distance };
        let current = self.graph.arcs_of(arc.head).start;
        self.nodes[arc.head as usize] = Node { label, parent: arc.sister, current };
        self.tree::<T>().active[distance as usize % GAP as usize].push(arc.head);
    }

    /// Saturates the path that leads from the root of `v` over arc `a` to the root of its head.
    fn connect<T: Side>(&mut self, v: u32, a: u32) {
        let w = self.graph.arcs[a as usize].head;
        let room = self.room::<T>(v).min(self.room::<T::Other>(w));
        let amount = room.min(self.outward::<T>(a));
        self.push_outward::<T>(a, amount);
        self.drain::<T>(v, amount);
        self.drain::<T::Other>(w, amount);
        while let Some(v) = self.tree::<T>().orphans.pop() {
            self.settle::<T>(v);
        }
        while let Some(w) = self.tree::<T::Other>().orphans.pop() {
            self.settle::<T::Other>(w);
        }
    }

    /// What can flow between `v` and its root's terminal.
    fn room<T: Side>(&self, mut v: u32) -> i64 {
        let mut least = i64::MAX;
        loop {
            let parent = self.nodes[v as usize].parent;
            if parent == ROOT {
                return least.min(self.graph.excess[v as usize].abs());
            }
            let arc = self.graph.arcs[parent as usize];
            least = least.min(self.outward::<T>(arc.sister));
            v = arc.head;
        }
    }

    /// Moves `amount` between `v` and its root's terminal; whoever hangs from a closed arc is an
    /// orphan.
    fn drain<T: Side>(&mut self, mut v: u32, amount: i64) {
        loop {
            let parent = self.nodes[v as usize].parent;
            if parent == ROOT {
                let excess = &mut self.graph.excess[v as usize];
                *excess -= if T::WHITE { amount } else { -amount };
                if *excess == 0 {
                    self.orphan::<T>(v);
                }
                return;
            }
            let arc = self.graph.arcs[parent as usize];
            if self.push_outward::<T>(arc.sister, amount) {
                self.orphan::<T>(v);
            }
            v = arc.head;
        }
    }

    fn orphan<T: Side>(&mut self, v: u32) {
        self.nodes[v as usize].parent = NO_ARC;
        let distance = self.distance::<T>(v) as usize;
        self.tree::<T>().orphans.push(v, distance);
    }

    /// Finds orphan `v` a new parent or sets it free.
    fn settle<T: Side>(&mut self, v: u32) {
        let old = self.distance::<T>(v);
        if let Some(a) = self.parent_below::<T>(v, old) {
            let node = &mut self.nodes[v as usize];
            (node.parent, node.current) = (a, a);
            return;
        }
        let (lowest, a) = self.lowest_parent::<T>(v);
        let grown = self.tree::<T>().grown;
        let free = lowest > grown;
        let distance = if free { 0 } else { lowest + 1 };
        self.nodes[v as usize] = Node {
            label: if T::WHITE { distance } else { -distance },
            parent: if free { NO_ARC } else { a },
            current: if free { self.graph.arcs_of(v).start } else { a },
        };
        for a in self.graph.arcs_of(v) {
            let arc = self.graph.arcs[a as usize];
            let is_child = self.nodes[arc.head as usize].parent == arc.sister;
            if is_child && (free || self.distance::<T>(arc.head) <= distance) {
                self.orphan::<T>(arc.head);
            }
        }
        if distance > grown {
            self.tree::<T>().active[distance as usize % GAP as usize].push(v);
        }
    }

    /// The next arc, from the current one on, to a possible parent with a label below `old`.
    fn parent_below<T: Side>(&self, v: u32, old: i32) -> Option<u32> {
        let current = self.nodes[v as usize].current;
        (current..self.graph.arcs_of(v).end).find(|&a| {
            let arc = self.graph.arcs[a as usize];
            (1..old).contains(&self.distance::<T>(arc.head)) && self.outward::<T>(arc.sister) > 0
        })
    }

    /// The lowest label among possible parents, and the first arc to it.
    fn lowest_parent<T: Side>(&self, v: u32) -> (i32, u32) {
        let mut best = (i32::MAX, NO_ARC);
        for a in self.graph.arcs_of(v) {
            let arc = self.graph.arcs[a as usize];
            let distance = self.distance::<T>(arc.head);
            if distance > 0 && distance < best.0 && self.outward::<T>(arc.sister) > 0 {
                best = (distance, a);
            }
        }
        best
    }
}
