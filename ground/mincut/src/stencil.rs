//! The residual graph of any [`Lattice`]: `N` directions to a node, and links in time.
//!
//! Nodes lie row by row in a stack of frames; around and between the frames run margins as wide as
//! the longest step, of nodes without arcs, so that no arc is ever tested for the border. The
//! second half of the directions is opposite to the first.
//!
//! A link in time is kept by the node of the later frame. The earlier node chains the links that
//! lead to it, any number of them: `first` names the latest, `next` the one chained before it.

use crate::lattice::{LINK_STEPS, Lattice};
use crate::network::{Network, Side};
use crate::repair::Mutable;

/// The arc to the previous frame; above it, those of links from the next frame, by their nodes.
const EARLIER: u32 = 16;
const LATER: u32 = 17;
/// No node.
const NOBODY: u32 = u32::MAX;

/// Links to the previous frame.
#[derive(Default)]
struct TimeLinks {
    /// The node to which the link of a node leads, or [`NOBODY`].
    to: Vec<u32>,
    /// What is left on that link and on the way back.
    residual: Vec<[i32; 2]>,
    /// The last node whose link leads to a node, or [`NOBODY`].
    first: Vec<u32>,
    /// For a node, another one whose link leads to the same node.
    next: Vec<u32>,
}

/// Residuals and excess of every node.
pub(crate) struct Stencil<const N: usize> {
    width: usize,
    height: usize,
    margin: usize,
    residual: Vec<[i32; N]>,
    excess: Vec<i64>,
    offset: [isize; N],
    time: TimeLinks,
}

/// An arc as a walk around a node meets it.
struct Spoke {
    arc: u32,
    head: usize,
    /// What is left on the arc, and on the one back.
    residual: [i32; 2],
}

impl<const N: usize> Stencil<N> {
    /// The nodes of `lattice` and its links in time, without any capacity.
    pub(crate) fn empty(lattice: &Lattice) -> Self {
        let steps = lattice.neighbours.steps();
        let margin = if N == 16 { 2 } else { 1 };
        let stride = lattice.width + margin;
        let len = stride * (margin + lattice.frames * (lattice.height + margin)) + margin;
        let offset = std::array::from_fn(|d| {
            let (x, y) = steps[d % (N / 2)];
            (x + y * stride as isize) * if d < N / 2 { 1 } else { -1 }
        });
        let mut stencil = Self {
            width: lattice.width,
            height: lattice.height,
            margin,
            residual: vec![[0; N]; len],
            excess: vec![0; len],
            offset,
            time: TimeLinks::default(),
        };
        stencil.chain(lattice);
        stencil
    }

    fn chain(&mut self, lattice: &Lattice) {
        if lattice.time.is_empty() {
            return;
        }
        let len = self.excess.len();
        let nobody = || vec![NOBODY; len];
        self.time = TimeLinks {
            to: nobody(),
            residual: vec![[0; 2]; len],
            first: nobody(),
            next: nobody(),
        };
        let link = lattice.neighbours.steps().len();
        for pixel in 0..lattice.pixels() {
            if let Some(end) = lattice.end(pixel, link) {
                let (v, w) = (self.node(pixel), self.node(end));
                self.time.to[v] = w as u32;
                self.time.next[v] = std::mem::replace(&mut self.time.first[w], v as u32);
            }
        }
    }

    /// Walks the arcs of `v`.
    #[inline(always)]
    fn each_spoke(&self, v: usize, mut visit: impl FnMut(Spoke)) {
        for (d, &out) in self.residual[v].iter().enumerate() {
            let head = v.wrapping_add_signed(self.offset[d]);
            let residual = [out, self.residual[head][d ^ (N / 2)]];
            visit(Spoke { arc: d as u32, head, residual });
        }
        if !self.time.to.is_empty() {
            self.each_time_spoke(v, visit);
        }
    }

    fn each_time_spoke(&self, v: usize, mut visit: impl FnMut(Spoke)) {
        let time = &self.time;
        if time.to[v] != NOBODY {
            let head = time.to[v] as usize;
            visit(Spoke { arc: EARLIER, head, residual: time.residual[v] });
        }
        let mut owner = time.first[v];
        while owner != NOBODY {
            let head = owner as usize;
            let [forth, back] = time.residual[head];
            visit(Spoke { arc: LATER + owner, head, residual: [back, forth] });
            owner = time.next[head];
        }
    }

    /// Walks the arcs of `v` over which the tree grows from it.
    #[inline(always)]
    fn each_away<T: Side>(&self, v: usize, mut visit: impl FnMut(Spoke)) {
        self.each_spoke(v, |spoke| {
            if spoke.residual[usize::from(!T::WHITE)] > 0 {
                visit(spoke);
            }
        });
    }

    /// The two residuals of an arc: its own and that of the way back.
    #[inline(always)]
    fn pair(&mut self, v: usize, arc: u32) -> (&mut i32, &mut i32) {
        match arc {
            ..EARLIER => {
                let (d, w) = (arc as usize, self.head(v, arc));
                let [from, to] = self
                    .residual
                    .get_disjoint_mut([v, w])
                    .expect("an arc joins two nodes of the lattice");
                (&mut from[d], &mut to[d ^ (N / 2)])
            }
            EARLIER => {
                let [forth, back] = &mut self.time.residual[v];
                (forth, back)
            }
            LATER.. => {
                let [forth, back] = &mut self.time.residual[(arc - LATER) as usize];
                (back, forth)
            }
        }
    }
}

impl<const N: usize> Network for Stencil<N> {
    type Arc = u32;
    type Label = i32;
    const ROOT: u32 = u32::MAX;
    const NONE: u32 = u32::MAX - 1;
    const LOST: u32 = u32::MAX - 2;

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
    fn head(&self, v: usize, arc: u32) -> usize {
        match arc {
            ..EARLIER => v.wrapping_add_signed(self.offset[arc as usize]),
            EARLIER => self.time.to[v] as usize,
            LATER.. => (arc - LATER) as usize,
        }
    }

    #[inline(always)]
    fn back(&self, v: usize, arc: u32) -> u32 {
        match arc {
            ..EARLIER => arc ^ (N as u32 / 2),
            EARLIER => LATER + v as u32,
            LATER.. => EARLIER,
        }
    }

    #[inline(always)]
    fn residual(&self, v: usize, arc: u32) -> i64 {
        i64::from(match arc {
            ..EARLIER => self.residual[v][arc as usize],
            EARLIER => self.time.residual[v][0],
            LATER.. => self.time.residual[(arc - LATER) as usize][1],
        })
    }

    #[inline(always)]
    fn push(&mut self, v: usize, arc: u32, amount: i64) -> bool {
        let (forth, back) = self.pair(v, arc);
        *forth -= amount as i32;
        *back += amount as i32;
        *forth == 0
    }

    #[inline(always)]
    fn lowest<T: Side>(&self, label: &[i32], v: usize) -> Option<(i32, u32)> {
        let mut least = (i32::MAX, Self::NONE);
        self.each_away::<T::Other>(v, |spoke| {
            let distance = T::distance(label[spoke.head]);
            if distance > 0 && distance < least.0 {
                least = (distance, spoke.arc);
            }
        });
        (least.1 != Self::NONE).then_some(least)
    }

    #[inline(always)]
    fn contact<T: Side>(&self, label: &[i32], v: usize) -> Option<u32> {
        let mut least = (i32::MAX, Self::NONE);
        self.each_away::<T>(v, |spoke| {
            let distance = T::Other::distance(label[spoke.head]);
            if distance > 0 && distance < least.0 {
                least = (distance, spoke.arc);
            }
        });
        (least.1 != Self::NONE).then_some(least.1)
    }

    #[inline(always)]
    fn each_free<T: Side>(
        &self,
        label: &mut [i32],
        v: usize,
        mut take: impl FnMut(&mut [i32], usize, u32),
    ) {
        self.each_away::<T>(v, |spoke| {
            if label[spoke.head] == 0 {
                take(label, spoke.head, self.back(v, spoke.arc));
            }
        });
    }

    #[inline(always)]
    fn each_lost<T: Side>(&self, parent: &[u32], v: usize, mut visit: impl FnMut(usize)) {
        self.each_away::<T>(v, |spoke| {
            if parent[spoke.head] == Self::LOST {
                visit(spoke.head);
            }
        });
    }

    #[inline(always)]
    fn each_child(&self, parent: &mut [u32], v: usize, mut visit: impl FnMut(&mut [u32], usize)) {
        self.each_spoke(v, |spoke| {
            if parent[spoke.head] == self.back(v, spoke.arc) {
                visit(parent, spoke.head);
            }
        });
    }
}

impl<const N: usize> Mutable for Stencil<N> {
    const BOUND: i64 = 1 << 40;

    fn node(&self, pixel: usize) -> usize {
        let (row, x) = (pixel / self.width, pixel % self.width);
        let margins = (row / self.height + 1) * self.margin;
        (row + margins) * (self.width + self.margin) + self.margin + x
    }

    fn arc(&self, v: usize, link: usize) -> Option<u32> {
        let in_time = self.time.to.get(v).is_some_and(|&to| to != NOBODY);
        match link.cmp(&(N / 2)) {
            std::cmp::Ordering::Less => Some(link as u32),
            std::cmp::Ordering::Equal if in_time => Some(EARLIER),
            _ => None,
        }
    }

    fn add_excess(&mut self, v: usize, amount: i64) {
        self.excess[v] += amount;
    }

    fn set_residuals(&mut self, v: usize, arc: u32, residuals: [i64; 2]) {
        let (forth, back) = self.pair(v, arc);
        (*forth, *back) = (residuals[0] as i32, residuals[1] as i32);
    }

    fn each_neighbour(&self, v: usize, mut visit: impl FnMut(usize)) {
        self.each_spoke(v, |spoke| visit(spoke.head));
    }
}

const _: () = assert!(LINK_STEPS.len() == EARLIER as usize / 2, "sixteen directions at most");
