//! The search: two breadth-first trees with distances, grown until no path is left.
//!
//! After Goldberg, Hed, Kaplan, Tarjan and Werneck, "Maximum flows by incremental breadth-first
//! search" (ESA 2011), on any [`Network`].
//!
//! 1. Every node with excess is a root: of the white tree if it is positive, of the black one if
//!    it is negative. The label is the distance from the terminal, positive in the white tree,
//!    negative in the black one, zero for a free node.
//! 2. The trees grow in turn, one level each: a node takes its free neighbours over open arcs.
//! 3. Where an open arc leads from the white tree to the black one, the path through it is
//!    saturated. Nodes cut from their parent are orphans.
//! 4. Orphans, lowest label first, adopt a parent of a lower label; else they move to the lowest
//!    label they can reach plus one, and their children at or below it become orphans; a node
//!    that only reaches levels which have not grown yet is set free, for these will take it back.
//! 5. When the black tree cannot grow, the flow is maximal; the white tree grows on, and its
//!    nodes are the canonical cut.
//!
//! A parent's label is lower than its child's, and lower orphans come first, so an adopting parent
//! is always rooted: no walk to the root is needed. Growth adds [`GAP`] to the label, so that an
//! orphan may move up by one and still keep its children.
//!
//! What the rest leans on: **no open arc leads from a grown white node out of the white tree**,
//! grown meaning at or below the level that grew last. It holds after every step, so that when no
//! white node is left to grow, no path is left either. [`crate::repair`] restores it after changes.

use crate::capacity::Capacity;
use crate::level::{Level, Pool};
use crate::network::{Black, Network, Side, White};
use crate::orphans::Orphans;
use std::ops::Range;

/// How much farther than its parent a node is put when a tree grows.
pub(crate) const GAP: i32 = 2;

/// How many orphans of one path settle one by one; the rest of a large subtree settles as a whole.
pub(crate) const PATIENCE: usize = 8192;

/// How many nodes ahead of growth memory is fetched.
const AHEAD: usize = 8;

/// One of the two trees: what is to grow and who lost its parent, by distance.
pub(crate) struct Tree<A> {
    /// The level that has grown last; all below have.
    pub(crate) grown: i32,
    /// Nodes to grow, by distance modulo 2: at most two levels wait.
    pub(crate) active: [Level; GAP as usize],
    pool: Pool,
    /// Nodes whose roots the first level still grows from, without a list of them.
    pub(crate) seeded: Range<usize>,
    /// Grown nodes whose surroundings changed: to grow again before the next level.
    pub(crate) again: Vec<u32>,
    pub(crate) orphans: Orphans,
    /// Nodes that wait to come back.
    pub(crate) lost: Vec<u32>,
    /// The way from a node to its root: nodes, each with its arc to the next one.
    path: Vec<(u32, A)>,
}

impl<A> Default for Tree<A> {
    fn default() -> Self {
        Self {
            grown: 0,
            active: Default::default(),
            pool: Pool::new(),
            seeded: 0..0,
            again: Vec::new(),
            orphans: Orphans::default(),
            lost: Vec::new(),
            path: Vec::new(),
        }
    }
}

impl<A> Tree<A> {
    fn waits(&self) -> bool {
        !self.seeded.is_empty()
            || !self.again.is_empty()
            || self.active.iter().any(|level| !level.is_empty())
    }

    /// Lets `v`, at `distance` above the grown levels, grow with its level.
    #[inline(always)]
    pub(crate) fn activate(&mut self, v: usize, distance: i32) {
        self.active[distance as usize % GAP as usize].push(v, &mut self.pool);
    }
}

/// A network and the two trees on it.
pub(crate) struct Search<N: Network> {
    pub(crate) network: N,
    pub(crate) label: Vec<N::Label>,
    pub(crate) parent: Vec<N::Arc>,
    /// The white tree, the black tree.
    pub(crate) trees: [Tree<N::Arc>; 2],
    /// All positive excess.
    pub(crate) left: i64,
    /// How many orphans settle one by one before the rest is [lost](crate::lost).
    pub(crate) patience: usize,
}

impl<N: Network> Search<N> {
    /// Makes every node with excess a root.
    pub(crate) fn new(network: N) -> Self {
        let mut search = Self::unrooted(network);
        search.restart();
        search
    }

    /// Leaves every node free.
    pub(crate) fn unrooted(network: N) -> Self {
        let nodes = network.len();
        let (label, parent) = (vec![N::Label::default(); nodes], vec![N::NONE; nodes]);
        Self { network, label, parent, trees: Default::default(), left: 0, patience: PATIENCE }
    }

    /// Forgets the trees, not the flow.
    pub(crate) fn restart(&mut self) {
        let excess = (0..self.network.len()).map(|v| self.network.excess(v));
        // Only networks that bound their sum of excess rely on it.
        self.left = excess.clone().fold(0, |sum, e| sum.saturating_add(e.max(0)));
        self.label.clear();
        self.label.extend(excess.map(|e| N::Label::of(e.signum() as i32)));
        self.parent.clear();
        let root = |l: &N::Label| if l.get() == 0 { N::NONE } else { N::ROOT };
        self.parent.extend(self.label.iter().map(root));
        self.trees = Default::default();
        self.seed(0..self.label.len());
    }

    /// Lets both trees begin, with the roots among `nodes`.
    pub(crate) fn seed(&mut self, nodes: Range<usize>) {
        for tree in &mut self.trees {
            (tree.grown, tree.seeded) = (0, nodes.clone());
        }
    }

    /// Takes the nodes that wait to grow.
    pub(crate) fn take_waiting<T: Side>(&mut self) -> Vec<u32> {
        let tree = &mut self.trees[T::INDEX];
        let mut waiting = std::mem::take(&mut tree.again);
        waiting
            .extend(std::mem::take(&mut tree.active).into_iter().flat_map(Level::blocks).flatten());
        let label = &self.label;
        let is_root = |&v: &usize| T::distance(label[v].get()) == 1;
        let roots = std::mem::take(&mut tree.seeded).filter(is_root);
        waiting.extend(roots.map(|v| v as u32));
        waiting
    }

    /// Grows the trees until the flow is maximal and the white tree complete; `None` when a
    /// distance is too large for a label.
    pub(crate) fn run(&mut self) -> Option<()> {
        self.run_up_to(i32::MAX)
    }

    /// Grows the trees to `level` at most.
    pub(crate) fn run_up_to(&mut self, level: i32) -> Option<()> {
        while self.trees[White::INDEX].waits() && self.trees[White::INDEX].grown < level {
            self.grow_level::<White>()?;
            if self.trees[Black::INDEX].waits() {
                self.grow_level::<Black>()?;
            }
        }
        Some(())
    }

    /// The labels alone; all else is let go.
    pub(crate) fn into_labels(self) -> Vec<N::Label> {
        self.label
    }

    /// Whether the white terminal reaches `v`, once the search has run.
    #[inline(always)]
    pub(crate) fn is_white(&self, v: usize) -> bool {
        self.label[v].get() > 0
    }

    /// The distance of `v` in the tree, zero or less outside.
    #[inline(always)]
    pub(crate) fn distance<T: Side>(&self, v: usize) -> i32 {
        T::distance(self.label[v].get())
    }

    #[inline(always)]
    pub(crate) fn set_distance<T: Side>(&mut self, v: usize, distance: i32) {
        self.label[v] = N::Label::of(T::distance(distance));
    }

    fn grow_level<T: Side>(&mut self) -> Option<()> {
        self.grow_again::<T>();
        let tree = &mut self.trees[T::INDEX];
        tree.grown += 1;
        let (level, slot) = (tree.grown, tree.grown as usize % GAP as usize);
        if level + GAP + 1 >= N::Label::MAX {
            return None;
        }
        let active = std::mem::take(&mut tree.active[slot]);
        let seeded = std::mem::take(&mut tree.seeded);
        self.grow_roots::<T>(seeded);
        for mut block in active.blocks() {
            self.grow_block::<T>(&block, level);
            block.clear();
            self.trees[T::INDEX].pool.push(block);
        }
        Some(())
    }

    /// Grows the roots among `nodes`.
    fn grow_roots<T: Side>(&mut self, nodes: Range<usize>) {
        for v in nodes {
            if self.distance::<T>(v) == 1 {
                self.grow::<T>(v);
            }
        }
    }

    /// Grows those of some nodes that are still at `level`.
    fn grow_block<T: Side>(&mut self, nodes: &[u32], level: i32) {
        for (n, &v) in nodes.iter().enumerate() {
            if let Some(&soon) = nodes.get(n + AHEAD) {
                self.network.prefetch(&self.label, soon as usize);
            }
            if self.distance::<T>(v as usize) == level {
                self.grow::<T>(v as usize);
            }
        }
    }

    fn grow_again<T: Side>(&mut self) {
        let mut again = std::mem::take(&mut self.trees[T::INDEX].again);
        for v in again.drain(..) {
            self.grow::<T>(v as usize);
        }
        self.trees[T::INDEX].again = again;
    }

    /// Saturates every path from `v` to the other tree, then takes the free neighbours. A node that
    /// is not in the tree any more, or has moved above the grown levels, is left alone.
    #[inline(always)]
    fn grow<T: Side>(&mut self, v: usize) {
        while (1..=self.trees[T::INDEX].grown).contains(&self.distance::<T>(v)) {
            match self.network.contact::<T>(&self.label, v) {
                Some(a) => self.connect::<T>(v, a),
                None => return self.take::<T>(v),
            }
        }
    }

    /// Saturates the paths through `v`, first the one over its arc `a`: the way from `v` to its
    /// root is walked once for all of them.
    fn connect<T: Side>(&mut self, v: usize, a: N::Arc) {
        let room = self.climb::<T>(v);
        let mut sent = 0;
        let mut contact = Some(a);
        while let Some(a) = contact
            && sent < room
        {
            let w = self.network.head(v, a);
            let (tail, arc) = if T::WHITE { (v, a) } else { (w, self.network.back(v, a)) };
            let amount =
                self.climb::<T::Other>(w).min(self.network.residual(tail, arc)).min(room - sent);
            self.network.push(tail, arc, amount);
            self.drain::<T::Other>(amount);
            self.adopt::<T::Other>();
            sent += amount;
            contact = self.network.contact::<T>(&self.label, v);
        }
        self.drain::<T>(sent);
        self.adopt::<T>();
        self.left -= sent;
    }

    #[inline(always)]
    fn take<T: Side>(&mut self, v: usize) {
        let distance = self.trees[T::INDEX].grown + GAP;
        let (tree, parent) = (&mut self.trees[T::INDEX], &mut self.parent);
        self.network.each_free::<T>(&mut self.label, v, |label, w, back| {
            label[w] = N::Label::of(T::distance(distance));
            parent[w] = back;
            tree.activate(w, distance);
        });
    }

    /// Notes the way from `v` to its root; what it carries.
    #[inline(always)]
    fn climb<T: Side>(&mut self, mut v: usize) -> i64 {
        let path = &mut self.trees[T::INDEX].path;
        path.clear();
        let mut least = i64::MAX;
        loop {
            let a = self.parent[v];
            path.push((v as u32, a));
            if a == N::ROOT {
                return least.min(self.network.excess(v).abs());
            }
            let u = self.network.head(v, a);
            let (tail, arc) = if T::WHITE { (u, self.network.back(v, a)) } else { (v, a) };
            least = least.min(self.network.residual(tail, arc));
            v = u;
        }
    }

    /// Pushes `amount` over the way noted last; whoever hangs from a saturated arc is an orphan.
    #[inline(always)]
    fn drain<T: Side>(&mut self, amount: i64) {
        let path = std::mem::take(&mut self.trees[T::INDEX].path);
        let (&(root, _), steps) = path.split_last().expect("a path ends at its root");
        for &(v, a) in steps {
            let v = v as usize;
            let closed = if T::WHITE {
                let (u, back) = (self.network.head(v, a), self.network.back(v, a));
                self.network.push(u, back, amount)
            } else {
                self.network.push(v, a, amount)
            };
            if closed {
                self.orphan::<T>(v);
            }
        }
        if self.network.drain(root as usize, amount) {
            self.orphan::<T>(root as usize);
        }
        self.trees[T::INDEX].path = path;
    }

    #[inline(always)]
    pub(crate) fn orphan<T: Side>(&mut self, v: usize) {
        self.parent[v] = N::NONE;
        let distance = self.distance::<T>(v) as usize;
        self.trees[T::INDEX].orphans.push(v, distance);
    }

    pub(crate) fn adopt<T: Side>(&mut self) {
        let mut patience = self.patience;
        while let Some(v) = self.trees[T::INDEX].orphans.pop() {
            // A change may have made a root of it meanwhile.
            if self.parent[v] == N::NONE {
                if patience > 0 {
                    patience -= 1;
                    self.settle::<T>(v);
                } else {
                    self.lose::<T>(v);
                }
            }
        }
        if !self.trees[T::INDEX].lost.is_empty() {
            self.recover::<T>();
        }
    }

    /// Finds orphan `v` a new parent or sets it free.
    #[inline(always)]
    fn settle<T: Side>(&mut self, v: usize) {
        let (old, grown) = (self.distance::<T>(v), self.trees[T::INDEX].grown);
        let (lowest, a) = self.network.lowest::<T>(&self.label, v).unwrap_or((i32::MAX, N::NONE));
        if lowest < old {
            self.parent[v] = a;
            return;
        }
        let free = lowest > grown;
        let distance = if free { 0 } else { lowest + 1 };
        self.set_distance::<T>(v, distance);
        self.parent[v] = if free { N::NONE } else { a };
        self.release::<T>(v, if free { i32::MAX } else { distance });
        if distance > grown {
            self.trees[T::INDEX].activate(v, distance);
        }
    }

    /// Makes orphans of the children of `v` up to `distance`.
    #[inline(always)]
    pub(crate) fn release<T: Side>(&mut self, v: usize, distance: i32) {
        let (label, orphans) = (&self.label, &mut self.trees[T::INDEX].orphans);
        self.network.each_child(&mut self.parent, v, |parent, w| {
            let at = T::distance(label[w].get());
            if at <= distance {
                parent[w] = N::NONE;
                orphans.push(w, at as usize);
            }
        });
    }
}
