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
//! is always rooted: no walk to the root is needed.

use crate::around::opposite;
use crate::grid::Grid;
use crate::residual::Residual;

/// The parent of a pixel that hangs from its terminal.
const ROOT: u8 = 8;
/// The parent of a free pixel or an orphan.
const NONE: u8 = 9;

/// One of the two trees: what is to grow and who lost its parent, by distance.
#[derive(Default)]
struct Tree {
    /// The level that has grown last; all below have.
    grown: i32,
    /// Pixels to grow, by distance modulo 2: at most two levels wait.
    active: [Vec<u32>; 2],
    /// Orphans by distance.
    orphans: Vec<Vec<u32>>,
}

struct Search {
    graph: Residual,
    label: Vec<i32>,
    parent: Vec<u8>,
    /// The white tree, the black tree.
    trees: [Tree; 2],
}

const WHITE: usize = 0;
const BLACK: usize = 1;

/// The labels of the canonical cut and the flow.
pub(crate) fn cut(grid: &Grid) -> (Vec<bool>, i64) {
    let graph = Residual::new(grid);
    let supply: i64 = graph.records.iter().map(|r| i64::from(r.excess.max(0))).sum();
    let mut search = Search::new(graph);
    search.run();
    let left: i64 = search.graph.records.iter().map(|r| i64::from(r.excess.max(0))).sum();
    let direct = |i: usize| i64::from(grid.terminal[i][0].min(grid.terminal[i][1]));
    let masked = (0..grid.mask.len()).filter(|&i| grid.mask[i]);
    (search.labels(), masked.map(direct).sum::<i64>() + supply - left)
}

impl Search {
    fn new(graph: Residual) -> Self {
        let pixels = graph.records.len();
        let (label, parent) = (vec![0; pixels], vec![NONE; pixels]);
        let mut search = Self { graph, label, parent, trees: Default::default() };
        for v in 0..pixels {
            let excess = search.graph.records[v].excess;
            if excess != 0 {
                search.label[v] = excess.signum();
                search.parent[v] = ROOT;
                search.trees[usize::from(excess < 0)].active[1].push(v as u32);
            }
        }
        search
    }

    fn labels(&self) -> Vec<bool> {
        let (width, height) = (self.graph.width, self.graph.height);
        let rows = (0..height).map(|y| self.graph.index(0, y));
        rows.flat_map(|start| self.label[start..start + width].iter().map(|&l| l > 0)).collect()
    }

    fn run(&mut self) {
        let waits = |tree: &Tree| tree.active.iter().any(|level| !level.is_empty());
        while waits(&self.trees[WHITE]) {
            self.grow_level::<WHITE>();
            if waits(&self.trees[BLACK]) {
                self.grow_level::<BLACK>();
            }
        }
    }

    /// The distance of `v` in the tree, zero or less outside.
    fn distance<const TREE: usize>(&self, v: usize) -> i32 {
        if TREE == WHITE { self.label[v] } else { -self.label[v] }
    }

    fn set_distance<const TREE: usize>(&mut self, v: usize, distance: i32) {
        self.label[v] = if TREE == WHITE { distance } else { -distance };
    }

    /// What can flow between `v` and its neighbour in direction `d`, away from the root of the
    /// tree in white, towards it in black.
    fn outward<const TREE: usize>(&self, v: usize, d: usize) -> i32 {
        if TREE == WHITE {
            self.graph.records[v].residual[d]
        } else {
            self.graph.records[self.graph.neighbour(v, d)].residual[opposite(d)]
        }
    }

    fn grow_level<const TREE: usize>(&mut self) {
        let tree = &mut self.trees[TREE];
        tree.grown += 1;
        let (level, slot) = (tree.grown, tree.grown as usize % 2);
        let active = std::mem::take(&mut tree.active[slot]);
        for v in active {
            self.grow::<TREE>(v as usize, level);
        }
    }

    /// Saturates every path from `v` to the other tree, then takes the free neighbours.
    fn grow<const TREE: usize>(&mut self, v: usize, level: i32) {
        for d in 0..8 {
            let w = self.graph.neighbour(v, d);
            while self.distance::<TREE>(v) == level
                && self.distance::<TREE>(w) < 0
                && self.outward::<TREE>(v, d) > 0
            {
                let (white, d) = if TREE == WHITE { (v, d) } else { (w, opposite(d)) };
                self.augment(white, d);
                self.adopt::<WHITE>();
                self.adopt::<BLACK>();
            }
        }
        if self.distance::<TREE>(v) != level {
            return;
        }
        for d in 0..8 {
            let w = self.graph.neighbour(v, d);
            if self.label[w] == 0 && self.outward::<TREE>(v, d) > 0 {
                self.set_distance::<TREE>(w, level + 1);
                self.parent[w] = opposite(d) as u8;
                self.trees[TREE].active[(level as usize + 1) % 2].push(w as u32);
            }
        }
    }

    /// Saturates the path from the white root over the arc `d` of `white` to the black root.
    fn augment(&mut self, white: usize, d: usize) {
        let black = self.graph.neighbour(white, d);
        let amount = self.graph.records[white].residual[d]
            .min(self.slack::<WHITE>(white))
            .min(self.slack::<BLACK>(black));
        self.graph.push(white, d, amount);
        self.drain::<WHITE>(white, amount);
        self.drain::<BLACK>(black, amount);
    }

    /// The least capacity from `v` to its root.
    fn slack<const TREE: usize>(&self, mut v: usize) -> i32 {
        let mut least = i32::MAX;
        while self.parent[v] != ROOT {
            let d = usize::from(self.parent[v]);
            v = self.graph.neighbour(v, d);
            least = least.min(self.outward::<TREE>(v, opposite(d)));
        }
        least.min(self.graph.records[v].excess.abs())
    }

    /// Pushes `amount` between `v` and its root; whoever hangs from a saturated arc is an orphan.
    fn drain<const TREE: usize>(&mut self, mut v: usize, amount: i32) {
        while self.parent[v] != ROOT {
            let (child, d) = (v, usize::from(self.parent[v]));
            v = self.graph.neighbour(v, d);
            if TREE == WHITE {
                self.graph.push(v, opposite(d), amount);
            } else {
                self.graph.push(child, d, amount);
            }
            if self.outward::<TREE>(v, opposite(d)) == 0 {
                self.orphan::<TREE>(child);
            }
        }
        let excess = &mut self.graph.records[v].excess;
        *excess -= excess.signum() * amount;
        if *excess == 0 {
            self.orphan::<TREE>(v);
        }
    }

    fn orphan<const TREE: usize>(&mut self, v: usize) {
        self.parent[v] = NONE;
        let distance = self.distance::<TREE>(v) as usize;
        let orphans = &mut self.trees[TREE].orphans;
        if orphans.len() <= distance {
            orphans.resize_with(distance + 1, Vec::new);
        }
        orphans[distance].push(v as u32);
    }

    fn adopt<const TREE: usize>(&mut self) {
        let mut distance = 0;
        while distance < self.trees[TREE].orphans.len() {
            match self.trees[TREE].orphans[distance].pop() {
                Some(v) => self.settle::<TREE>(v as usize),
                None => distance += 1,
            }
        }
        self.trees[TREE].orphans.clear();
    }

    /// Finds orphan `v` a new parent or sets it free.
    fn settle<const TREE: usize>(&mut self, v: usize) {
        let (old, grown) = (self.distance::<TREE>(v), self.trees[TREE].grown);
        let (lowest, d) = self.lowest_parent::<TREE>(v);
        if lowest < old {
            self.parent[v] = d;
            return;
        }
        let free = lowest > grown;
        let distance = if free { 0 } else { lowest + 1 };
        self.set_distance::<TREE>(v, distance);
        self.parent[v] = if free { NONE } else { d };
        for d in 0..8 {
            let w = self.graph.neighbour(v, d);
            if usize::from(self.parent[w]) == opposite(d)
                && (free || self.distance::<TREE>(w) <= distance)
            {
                self.orphan::<TREE>(w);
            }
        }
        if distance > grown {
            self.trees[TREE].active[distance as usize % 2].push(v as u32);
        }
    }

    /// The least distance among the pixels of the tree with an open arc to `v`, and its direction.
    fn lowest_parent<const TREE: usize>(&self, v: usize) -> (i32, u8) {
        let open = |d: usize| {
            let w = self.graph.neighbour(v, d);
            let distance = self.distance::<TREE>(w);
            let reached = distance > 0 && self.outward::<TREE>(w, opposite(d)) > 0;
            reached.then_some((distance, d as u8))
        };
        (0..8).filter_map(open).min().unwrap_or((i32::MAX, NONE))
    }
}
