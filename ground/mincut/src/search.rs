//! The search: two breadth-first trees with distances, grown until no path is left.
//!
//! After Goldberg, Hed, Kaplan, Tarjan and Werneck, "Maximum flows by incremental breadth-first
//! search" (ESA 2011).
//!
//! 1. Every pixel with excess is a root: of the white tree if it is positive, of the black one if
//!    it is negative. The label is the distance from the terminal, positive in the white tree,
//!    negative in the black one, zero for a free pixel.
//! 2. The trees grow in turn, one level each: a pixel takes its free neighbours over open arcs.
//! 3. Where an open arc leads from the white tree to the black one, the path through it is
//!    saturated. Pixels cut from their parent are orphans.
//! 4. Orphans, lowest label first, adopt a parent of a lower label; else they move to the lowest
//!    label they can reach plus one, and their children at or below it become orphans; a pixel
//!    that only reaches levels which have not grown yet is set free, for these will take it back.
//! 5. When the black tree cannot grow, the flow is maximal; the white tree grows on, and its
//!    pixels are the canonical cut.
//!
//! A parent's label is lower than its child's, and lower orphans come first, so an adopting parent
//! is always rooted: no walk to the root is needed. Growth adds [`GAP`] to the label, so that an
//! orphan may move up by one and still keep its children.

use crate::around::{around, between, lowest, opposite, zero};
use crate::capacity::Capacity;
use crate::residual::Residual;

/// The parent of a pixel that hangs from its terminal.
const ROOT: u8 = 8;
/// The parent of a free pixel or an orphan.
const NONE: u8 = 9;
/// How much farther than its parent a pixel is put when a tree grows.
const GAP: i32 = 2;

/// One of the two trees: what is to grow and who lost its parent, by distance.
#[derive(Default)]
struct Tree {
    /// The level that has grown last; all below have.
    grown: i32,
    /// Pixels to grow, by distance modulo 2: at most two levels wait.
    active: [Vec<u32>; GAP as usize],
    spare: Vec<u32>,
    orphans: Orphans,
    path: Vec<u32>,
}

#[derive(Default)]
struct Orphans {
    first: Vec<u32>,
    links: Vec<(u32, u32)>,
    lowest: usize,
    waiting: usize,
}

impl Orphans {
    #[inline(always)]
    fn push(&mut self, v: usize, distance: usize) {
        if self.first.len() <= distance {
            self.first.resize(distance + 64, 0);
        }
        self.links.push((v as u32, self.first[distance]));
        self.first[distance] = self.links.len() as u32;
        self.waiting += 1;
        self.lowest = self.lowest.min(distance);
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<usize> {
        if self.waiting == 0 {
            self.links.clear();
            self.lowest = usize::MAX;
            return None;
        }
        while self.first[self.lowest] == 0 {
            self.lowest += 1;
        }
        let (v, next) = self.links[self.first[self.lowest] as usize - 1];
        self.first[self.lowest] = next;
        self.waiting -= 1;
        Some(v as usize)
    }
}

pub(crate) struct Search<C> {
    graph: Residual<C>,
    label: Vec<C>,
    parent: Vec<u8>,
    /// The white tree, the black tree.
    trees: [Tree; 2],
}

const WHITE: usize = 0;
const BLACK: usize = 1;

impl<C: Capacity> Search<C> {
    pub(crate) fn new(graph: Residual<C>) -> Self {
        let label: Vec<C> = (0..graph.len()).map(|v| C::of(graph.excess(v).signum())).collect();
        let parent = label.iter().map(|l| if l.get() == 0 { NONE } else { ROOT }).collect();
        Self { graph, label, parent, trees: Default::default() }
    }

    pub(crate) fn left(&self) -> i64 {
        (0..self.graph.len()).map(|v| i64::from(self.graph.excess(v).max(0))).sum()
    }

    pub(crate) fn labels(&self) -> Vec<bool> {
        let mut labels = Vec::with_capacity(self.graph.width * self.graph.height);
        for y in 0..self.graph.height {
            let row = &self.label[self.graph.row(y)..][..self.graph.width];
            labels.extend(row.iter().map(|label| label.get() > 0));
        }
        labels
    }

    /// None when labels overflow
    pub(crate) fn run(&mut self) -> Option<()> {
        let waits = |tree: &Tree| tree.active.iter().any(|level| !level.is_empty());
        self.grow_roots::<WHITE>();
        self.grow_roots::<BLACK>();
        while waits(&self.trees[WHITE]) {
            self.grow_level::<WHITE>()?;
            if waits(&self.trees[BLACK]) {
                self.grow_level::<BLACK>()?;
            }
        }
        Some(())
    }

    /// The distance of `v` in the tree, zero or less outside.
    #[inline(always)]
    fn distance<const TREE: usize>(&self, v: usize) -> i32 {
        let label = self.label[v].get();
        if TREE == WHITE { label } else { -label }
    }

    #[inline(always)]
    fn set_distance<const TREE: usize>(&mut self, v: usize, distance: i32) {
        self.label[v] = C::of(if TREE == WHITE { distance } else { -distance });
    }

    #[inline(always)]
    fn distances<const TREE: usize>(&self, v: usize) -> [i32; 8] {
        let labels = around(&self.label, v, self.graph.stride());
        if TREE == WHITE { labels } else { labels.map(|l| -l) }
    }

    fn grow_roots<const TREE: usize>(&mut self) {
        self.trees[TREE].grown = 1;
        for v in 0..self.label.len() {
            if self.distance::<TREE>(v) == 1 {
                self.grow::<TREE>(v, 1);
            }
        }
    }

    fn grow_level<const TREE: usize>(&mut self) -> Option<()> {
        let tree = &mut self.trees[TREE];
        tree.grown += 1;
        let (level, slot) = (tree.grown, tree.grown as usize % GAP as usize);
        if level + GAP + 1 >= C::MAX {
            return None;
        }
        let spare = std::mem::take(&mut tree.spare);
        let mut active = std::mem::replace(&mut tree.active[slot], spare);
        for &v in &active {
            if self.distance::<TREE>(v as usize) == level {
                self.grow::<TREE>(v as usize, level);
            }
        }
        active.clear();
        self.trees[TREE].spare = active;
        Some(())
    }

    /// Saturates every path from `v` to the other tree, then takes the free neighbours.
    #[inline(always)]
    fn grow<const TREE: usize>(&mut self, v: usize, level: i32) {
        loop {
            let open = if TREE == WHITE { self.graph.outgoing(v) } else { self.graph.incoming(v) };
            if open == 0 {
                return;
            }
            let around = self.distances::<TREE>(v);
            let others = around.map(|l| -l);
            let Some((_, d)) = lowest(others, open) else {
                return self.take::<TREE>(v, level, open & zero(around));
            };
            let (white, d) =
                if TREE == WHITE { (v, d) } else { (self.graph.neighbour(v, d), opposite(d)) };
            self.augment(white, d);
            self.adopt::<WHITE>();
            self.adopt::<BLACK>();
            if self.distance::<TREE>(v) != level {
                return;
            }
        }
    }

    #[inline(always)]
    fn take<const TREE: usize>(&mut self, v: usize, level: i32, mut free: u8) {
        while free != 0 {
            let d = free.trailing_zeros() as usize;
            free &= free - 1;
            let w = self.graph.neighbour(v, d);
            self.set_distance::<TREE>(w, level + GAP);
            self.parent[w] = opposite(d) as u8;
            self.trees[TREE].active[level as usize % GAP as usize].push(w as u32);
        }
    }

    /// Saturates the path from the white root over the arc `d` of `white` to the black root.
    fn augment(&mut self, white: usize, d: usize) {
        let black = self.graph.neighbour(white, d);
        let amount = self
            .graph
            .capacity(white, d)
            .min(self.slack::<WHITE>(white))
            .min(self.slack::<BLACK>(black));
        self.graph.push(white, d, amount);
        self.drain::<WHITE>(amount);
        self.drain::<BLACK>(amount);
    }

    /// The least capacity from `v` to its root.
    #[inline(always)]
    fn slack<const TREE: usize>(&mut self, mut v: usize) -> i32 {
        let mut path = std::mem::take(&mut self.trees[TREE].path);
        path.clear();
        let mut least = i32::MAX;
        loop {
            let d = self.parent[v];
            path.push((v as u32) << 3 | u32::from(d & 7));
            if d == ROOT {
                break;
            }
            let d = usize::from(d);
            let u = self.graph.neighbour(v, d);
            least = least.min(if TREE == WHITE {
                self.graph.capacity(u, opposite(d))
            } else {
                self.graph.capacity(v, d)
            });
            v = u;
        }
        self.trees[TREE].path = path;
        least.min(self.graph.excess(v).abs())
    }

    /// Pushes `amount` between `v` and its root; whoever hangs from a saturated arc is an orphan.
    #[inline(always)]
    fn drain<const TREE: usize>(&mut self, amount: i32) {
        let path = std::mem::take(&mut self.trees[TREE].path);
        let (&root, steps) = path.split_last().expect("a path ends at its root");
        for &step in steps {
            let (v, d) = ((step >> 3) as usize, (step & 7) as usize);
            let closed = if TREE == WHITE {
                self.graph.push(self.graph.neighbour(v, d), opposite(d), amount)
            } else {
                self.graph.push(v, d, amount)
            };
            if closed {
                self.orphan::<TREE>(v);
            }
        }
        let root = (root >> 3) as usize;
        if self.graph.drain(root, amount) {
            self.orphan::<TREE>(root);
        }
        self.trees[TREE].path = path;
    }

    #[inline(always)]
    fn orphan<const TREE: usize>(&mut self, v: usize) {
        self.parent[v] = NONE;
        let distance = self.distance::<TREE>(v) as usize;
        self.trees[TREE].orphans.push(v, distance);
    }

    fn adopt<const TREE: usize>(&mut self) {
        while let Some(v) = self.trees[TREE].orphans.pop() {
            self.settle::<TREE>(v);
        }
    }

    /// Finds orphan `v` a new parent or sets it free.
    #[inline(always)]
    fn settle<const TREE: usize>(&mut self, v: usize) {
        let (old, grown) = (self.distance::<TREE>(v), self.trees[TREE].grown);
        let open = if TREE == WHITE { self.graph.incoming(v) } else { self.graph.outgoing(v) };
        let around = self.distances::<TREE>(v);
        let (lowest, d) = lowest(around, open).unwrap_or((i32::MAX, 0));
        if lowest < old {
            self.parent[v] = d as u8;
            return;
        }
        let free = lowest > grown;
        let distance = if free { 0 } else { lowest + 1 };
        self.set_distance::<TREE>(v, distance);
        self.parent[v] = if free { NONE } else { d as u8 };
        let mut kin = between(around, old, if free { i32::MAX } else { distance });
        while kin != 0 {
            let d = kin.trailing_zeros() as usize;
            kin &= kin - 1;
            let w = self.graph.neighbour(v, d);
            if usize::from(self.parent[w]) == opposite(d) {
                self.orphan::<TREE>(w);
            }
        }
        if distance > grown {
            self.trees[TREE].active[distance as usize % GAP as usize].push(v as u32);
        }
    }
}
