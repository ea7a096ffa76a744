//! The search: two trees that grow towards each other (Boykov and Kolmogorov 2004).
//!
//! 1. Every pixel keeps the surplus of one terminal over the other; their common part is flow.
//! 2. A white tree grows from pixels with a surplus to white, a black tree from the others, along
//!    arcs with residual capacity.
//! 3. Where they touch, a path is found; flow is pushed along it until an arc is full.
//! 4. Pixels below a full arc look for another parent in their tree that still leads to the
//!    terminal, preferring a near one, or are set free, their children after them.
//! 5. When neither tree can grow, the flow is maximal.
//!
//! Guaranteed: exact, deterministic, no recursion. 49 bytes a pixel beside the queues.

use crate::Grid;
use std::collections::VecDeque;

/// Offsets of the eight arcs; opposite arcs are four apart.
const ARCS: [(isize, isize); 8] =
    [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];

const FREE: u8 = 0;
const WHITE: u8 = 1;
const BLACK: u8 = 2;

/// Parents: an arc (0 to 7), the terminal, or none.
const TERMINAL: u8 = 8;
const ORPHAN: u8 = 9;

pub(crate) struct Search {
    stride: isize,
    width: usize,
    /// Residual capacities of the eight arcs, in a grid with a frame of one pixel.
    residual: Vec<[i32; 8]>,
    /// Surplus to white, or to black where negative.
    surplus: Vec<i32>,
    tree: Vec<u8>,
    parent: Vec<u8>,
    distance: Vec<u32>,
    stamp: Vec<u32>,
    time: u32,
    active: VecDeque<u32>,
    is_active: Vec<bool>,
    orphans: VecDeque<u32>,
    pub(crate) flow: i64,
}

impl Search {
    pub(crate) fn new(grid: &Grid) -> Self {
        let stride = grid.width + 2;
        let n = stride * (grid.height + 2);
        let mut search = Self {
            stride: stride as isize,
            width: grid.width,
            residual: vec![[0; 8]; n],
            surplus: vec![0; n],
            tree: vec![FREE; n],
            parent: vec![ORPHAN; n],
            distance: vec![0; n],
            stamp: vec![0; n],
            time: 0,
            active: VecDeque::new(),
            is_active: vec![false; n],
            orphans: VecDeque::new(),
            flow: 0,
        };
        for pixel in (0..grid.mask.len()).filter(|&p| grid.mask[p]) {
            search.load(grid, pixel);
        }
        search
    }

    fn framed(&self, pixel: usize) -> usize {
        let (x, y) = (pixel % self.width, pixel / self.width);
        (y + 1) * self.stride as usize + x + 1
    }

    fn load(&mut self, grid: &Grid, pixel: usize) {
        let p = self.framed(pixel);
        let [white, black] = grid.terminal[pixel];
        self.surplus[p] = white - black;
        self.flow += i64::from(white.min(black));
        for e in 0..4 {
            if grid.neighbour_of(pixel, e).is_some() {
                let capacity = grid.neighbour[pixel][e];
                let q = self.step(p, e);
                self.residual[p][e] = capacity;
                self.residual[q][e + 4] = capacity;
            }
        }
        if self.surplus[p] != 0 {
            self.tree[p] = if self.surplus[p] > 0 { WHITE } else { BLACK };
            self.parent[p] = TERMINAL;
            self.distance[p] = 1;
            self.activate(p);
        }
    }

    fn step(&self, p: usize, arc: usize) -> usize {
        let (dx, dy) = ARCS[arc];
        p.wrapping_add_signed(dy * self.stride + dx)
    }

    fn activate(&mut self, p: usize) {
        if !std::mem::replace(&mut self.is_active[p], true) {
            self.active.push_back(p as u32);
        }
    }

    pub(crate) fn run(&mut self) {
        while let Some(p) = self.active.pop_front() {
            let p = p as usize;
            self.is_active[p] = false;
            // A pixel stays active until its growth finds no contact.
            while self.tree[p] != FREE {
                let Some((from, arc)) = self.grow(p) else { break };
                self.time += 1;
                self.augment(from, arc);
                while let Some(orphan) = self.orphans.pop_front() {
                    self.adopt(orphan as usize);
                }
            }
        }
    }

    /// Takes free neighbours into the tree; the first contact with the other tree as an arc from
    /// white to black.
    fn grow(&mut self, p: usize) -> Option<(usize, usize)> {
        let own = self.tree[p];
        for arc in 0..8 {
            let q = self.step(p, arc);
            let open = match own {
                WHITE => self.residual[p][arc],
                _ => self.residual[q][arc ^ 4],
            };
            if open == 0 {
                continue;
            }
            if self.tree[q] == FREE {
                self.tree[q] = own;
                self.parent[q] = (arc ^ 4) as u8;
                self.distance[q] = self.distance[p] + 1;
                self.stamp[q] = self.stamp[p];
                self.activate(q);
            } else if self.tree[q] != own {
                return Some(if own == WHITE { (p, arc) } else { (q, arc ^ 4) });
            } else if self.stamp[q] <= self.stamp[p] && self.distance[q] > self.distance[p] + 1 {
                // A shorter way to the terminal.
                self.parent[q] = (arc ^ 4) as u8;
                self.distance[q] = self.distance[p] + 1;
                self.stamp[q] = self.stamp[p];
            }
        }
        None
    }

    /// Residual of the arc between a pixel and its parent, in the direction of flow.
    fn open_to_parent(&self, p: usize) -> i32 {
        let arc = usize::from(self.parent[p]);
        match self.tree[p] {
            WHITE => self.residual[self.step(p, arc)][arc ^ 4],
            _ => self.residual[p][arc],
        }
    }

    /// Pushes what fits along white root, arc, black root; pixels under full arcs become orphans.
    fn augment(&mut self, from: usize, arc: usize) {
        let to = self.step(from, arc);
        let amount = self.residual[from][arc].min(self.bottleneck(from)).min(self.bottleneck(to));
        self.residual[from][arc] -= amount;
        self.residual[to][arc ^ 4] += amount;
        self.push_to_root(from, amount);
        self.push_to_root(to, amount);
        self.flow += i64::from(amount);
    }

    fn bottleneck(&self, mut p: usize) -> i32 {
        let mut least = i32::MAX;
        while self.parent[p] != TERMINAL {
            least = least.min(self.open_to_parent(p));
            p = self.step(p, usize::from(self.parent[p]));
        }
        least.min(self.surplus[p].abs())
    }

    fn push_to_root(&mut self, mut p: usize, amount: i32) {
        while self.parent[p] != TERMINAL {
            let arc = usize::from(self.parent[p]);
            let q = self.step(p, arc);
            let signed = if self.tree[p] == WHITE { -amount } else { amount };
            self.residual[q][arc ^ 4] += signed;
            self.residual[p][arc] -= signed;
            if self.open_to_parent(p) == 0 {
                self.orphan(p);
            }
            p = q;
        }
        self.surplus[p] -= amount * self.surplus[p].signum();
        if self.surplus[p] == 0 {
            self.orphan(p);
        }
    }

    fn orphan(&mut self, p: usize) {
        self.parent[p] = ORPHAN;
        self.orphans.push_back(p as u32);
    }

    /// Finds an orphan a parent, or sets it free and its children after it.
    fn adopt(&mut self, p: usize) {
        let mut best: Option<(u32, usize)> = None;
        for arc in 0..8 {
            let q = self.step(p, arc);
            if self.tree[q] != self.tree[p] || self.open_from(q, arc ^ 4) == 0 {
                continue;
            }
            if let Some(distance) = self.distance_to_root(q)
                && best.is_none_or(|(d, _)| distance < d)
            {
                best = Some((distance, arc));
            }
        }
        match best {
            Some((distance, arc)) => {
                self.parent[p] = arc as u8;
                self.stamp[p] = self.time;
                self.distance[p] = distance + 1;
            }
            None => self.set_free(p),
        }
    }

    /// Residual from a tree pixel along `arc` to a child, in the direction of flow.
    fn open_from(&self, q: usize, arc: usize) -> i32 {
        match self.tree[q] {
            WHITE => self.residual[q][arc],
            _ => self.residual[self.step(q, arc)][arc ^ 4],
        }
    }

    fn set_free(&mut self, p: usize) {
        for arc in 0..8 {
            let q = self.step(p, arc);
            if self.tree[q] != self.tree[p] {
                continue;
            }
            if self.open_from(q, arc ^ 4) > 0 {
                self.activate(q);
            }
            if usize::from(self.parent[q]) == arc ^ 4 {
                self.orphan(q);
            }
        }
        self.tree[p] = FREE;
    }

    /// Steps to the terminal, or `None` when the way ends at an orphan. Marks the way walked.
    fn distance_to_root(&mut self, q: usize) -> Option<u32> {
        let (mut at, mut steps) = (q, 0);
        let total = loop {
            if self.stamp[at] == self.time {
                break steps + self.distance[at];
            }
            match self.parent[at] {
                TERMINAL => {
                    self.stamp[at] = self.time;
                    self.distance[at] = 1;
                    break steps + 1;
                }
                ORPHAN => return None,
                arc => {
                    at = self.step(at, usize::from(arc));
                    steps += 1;
                }
            }
        };
        let (mut at, mut distance) = (q, total);
        while self.stamp[at] != self.time {
            self.stamp[at] = self.time;
            self.distance[at] = distance;
            at = self.step(at, usize::from(self.parent[at]));
            distance -= 1;
        }
        Some(total)
    }

    /// The pixels that the white terminal reaches in the residual graph.
    pub(crate) fn reachable_from_white(&self) -> Vec<bool> {
        let mut seen = vec![false; self.surplus.len()];
        let mut queue: Vec<usize> =
            (0..self.surplus.len()).filter(|&p| self.surplus[p] > 0).collect();
        for &p in &queue {
            seen[p] = true;
        }
        while let Some(p) = queue.pop() {
            for arc in 0..8 {
                let q = self.step(p, arc);
                if self.residual[p][arc] > 0 && !std::mem::replace(&mut seen[q], true) {
                    queue.push(q);
                }
            }
        }
        let rows = self.surplus.len() / self.stride as usize;
        let inner = (1..rows.saturating_sub(1)).flat_map(|y| {
            let start = y * self.stride as usize + 1;
            start..start + self.width
        });
        inner.map(|p| seen[p]).collect()
    }
}
