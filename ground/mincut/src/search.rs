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

use crate::around::{around, children, lowest, opposite, zero};
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

pub(crate) trait Side {
    const WHITE: bool;
    const INDEX: usize;
    type Other: Side;
}
pub(crate) struct White;
pub(crate) struct Black;
impl Side for White {
    const WHITE: bool = true;
    const INDEX: usize = 0;
    type Other = Black;
}
impl Side for Black {
    const WHITE: bool = false;
    const INDEX: usize = 1;
    type Other = White;
}

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
        self.grow_roots::<White>();
        self.grow_roots::<Black>();
        while waits(&self.trees[White::INDEX]) {
            self.grow_level::<White>()?;
            if waits(&self.trees[Black::INDEX]) {
                self.grow_level::<Black>()?;
            }
        }
        Some(())
    }

    /// The distance of `v` in the tree, zero or less outside.
    #[inline(always)]
    fn distance<T: Side>(&self, v: usize) -> i32 {
        let label = self.label[v].get();
        if T::WHITE { label } else { -label }
    }

    #[inline(always)]
    fn set_distance<T: Side>(&mut self, v: usize, distance: i32) {
        self.label[v] = C::of(if T::WHITE { distance } else { -distance });
    }

    #[inline(always)]
    fn distances<T: Side>(&self, v: usize) -> [i32; 8] {
        let labels = around(&self.label, v, self.graph.stride());
        if T::WHITE { labels } else { labels.map(|l| -l) }
    }

    fn grow_roots<T: Side>(&mut self) {
        self.trees[T::INDEX].grown = 1;
        for v in 0..self.label.len() {
            if self.distance::<T>(v) == 1 {
                self.grow::<T>(v, 1);
            }
        }
    }

    fn grow_level<T: Side>(&mut self) -> Option<()> {
        let tree = &mut self.trees[T::INDEX];
        tree.grown += 1;
        let (level, slot) = (tree.grown, tree.grown as usize % GAP as usize);
        if level + GAP + 1 >= C::MAX {
            return None;
        }
        let spare = std::mem::take(&mut tree.spare);
        let mut active = std::mem::replace(&mut tree.active[slot], spare);
        for &v in &active {
            if self.distance::<T>(v as usize) == level {
                self.grow::<T>(v as usize, level);
            }
        }
        active.clear();
        self.trees[T::INDEX].spare = active;
        Some(())
    }

    /// Saturates every path from `v` to the other tree, then takes the free neighbours.
    #[inline(always)]
    fn grow<T: Side>(&mut self, v: usize, level: i32) {
        while self.distance::<T>(v) == level {
            let (open, around) = (self.open::<T>(v), self.distances::<T>(v));
            if open == 0 {
                return;
            }
            match lowest(around.map(|l| -l), open) {
                Some((_, d)) => self.connect::<T>(v, d),
                None => return self.take::<T>(v, level, open & zero(around)),
            }
        }
    }

    /// The directions of the arcs over which the tree grows from `v`.
    #[inline(always)]
    fn open<T: Side>(&self, v: usize) -> u8 {
        if T::WHITE { self.graph.outgoing(v) } else { self.graph.incoming(v) }
    }

    fn connect<T: Side>(&mut self, v: usize, d: usize) {
        let room = self.climb::<T>(v);
        let mut sent = 0;
        let mut contact = Some((0, d));
        while let Some((_, d)) = contact
            && sent < room
        {
            let w = self.graph.neighbour(v, d);
            let (tail, e) = if T::WHITE { (v, d) } else { (w, opposite(d)) };
            let amount =
                self.climb::<T::Other>(w).min(self.graph.capacity(tail, e)).min(room - sent);
            self.graph.push(tail, e, amount);
            self.drain::<T::Other>(amount);
            self.adopt::<T::Other>();
            sent += amount;
            contact = lowest(self.distances::<T>(v).map(|l| -l), self.open::<T>(v));
        }
        self.drain::<T>(sent);
        self.adopt::<T>();
    }

    #[inline(always)]
    fn take<T: Side>(&mut self, v: usize, level: i32, mut free: u8) {
        while free != 0 {
            let d = free.trailing_zeros() as usize;
            free &= free - 1;
            let w = self.graph.neighbour(v, d);
            self.set_distance::<T>(w, level + GAP);
            self.parent[w] = opposite(d) as u8;
            self.trees[T::INDEX].active[level as usize % GAP as usize].push(w as u32);
        }
    }

    /// The least capacity from `v` to its root.
    #[inline(always)]
    fn climb<T: Side>(&mut self, mut v: usize) -> i32 {
        let mut path = std::mem::take(&mut self.trees[T::INDEX].path);
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
            least = least.min(if T::WHITE {
                self.graph.capacity(u, opposite(d))
            } else {
                self.graph.capacity(v, d)
            });
            v = u;
        }
        self.trees[T::INDEX].path = path;
        least.min(self.graph.excess(v).abs())
    }

    /// Pushes `amount` between `v` and its root; whoever hangs from a saturated arc is an orphan.
    #[inline(always)]
    fn drain<T: Side>(&mut self, amount: i32) {
        let path = std::mem::take(&mut self.trees[T::INDEX].path);
        let (&root, steps) = path.split_last().expect("a path ends at its root");
        for &step in steps {
            let (v, d) = ((step >> 3) as usize, (step & 7) as usize);
            let closed = if T::WHITE {
                self.graph.push(self.graph.neighbour(v, d), opposite(d), amount)
            } else {
                self.graph.push(v, d, amount)
            };
            if closed {
                self.orphan::<T>(v);
            }
        }
        let root = (root >> 3) as usize;
        if self.graph.drain(root, amount) {
            self.orphan::<T>(root);
        }
        self.trees[T::INDEX].path = path;
    }

    #[inline(always)]
    fn orphan<T: Side>(&mut self, v: usize) {
        self.parent[v] = NONE;
        let distance = self.distance::<T>(v) as usize;
        self.trees[T::INDEX].orphans.push(v, distance);
    }

    fn adopt<T: Side>(&mut self) {
        while let Some(v) = self.trees[T::INDEX].orphans.pop() {
            self.settle::<T>(v);
        }
    }

    /// Finds orphan `v` a new parent or sets it free.
    #[inline(always)]
    fn settle<T: Side>(&mut self, v: usize) {
        let (old, grown) = (self.distance::<T>(v), self.trees[T::INDEX].grown);
        let open = if T::WHITE { self.graph.incoming(v) } else { self.graph.outgoing(v) };
        let around = self.distances::<T>(v);
        let (lowest, d) = lowest(around, open).unwrap_or((i32::MAX, 0));
        if lowest < old {
            self.parent[v] = d as u8;
            return;
        }
        let free = lowest > grown;
        let distance = if free { 0 } else { lowest + 1 };
        self.set_distance::<T>(v, distance);
        self.parent[v] = if free { NONE } else { d as u8 };
        let mut kin = children(&self.parent, v, self.graph.stride());
        while kin != 0 {
            let d = kin.trailing_zeros() as usize;
            kin &= kin - 1;
            let w = self.graph.neighbour(v, d);
            if free || self.distance::<T>(w) <= distance {
                self.orphan::<T>(w);
            }
        }
        if distance > grown {
            self.trees[T::INDEX].active[distance as usize % GAP as usize].push(v as u32);
        }
    }
}
