//! [`Slice`]: the zero set of a function on a surface, as chains of crossed edges.
//!
//! A vertex is positive where the function is >= 0, so that every vertex has a side. An edge is
//! crossed when its ends differ; a face with both signs joins two crossed edges. Chains run with
//! the positive side on the left, seen from the front. On a closed surface every chain is a loop.

use crate::surface::{NONE, Surface, next, previous};
use rayon::prelude::*;

/// A point of a zero set on an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The edge.
    pub edge: u32,
    /// Where on it: 0 at its first end, 1 at its second.
    pub at: f64,
    /// The face that the chain enters here, or [`NONE`] at the end of an open chain.
    pub face: u32,
}

/// A chain: a range of crossings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chain {
    /// Index of its first crossing.
    pub start: u32,
    /// Number of crossings.
    pub count: u32,
    /// Whether the last is joined to the first.
    pub closed: bool,
}

/// A zero set at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slice {
    /// Crossings, chain by chain.
    pub crossings: Vec<Crossing>,
    /// The chains.
    pub chains: Vec<Chain>,
}

impl Chain {
    /// Its crossings in a slice.
    pub fn of<'a>(&self, slice: &'a Slice) -> &'a [Crossing] {
        &slice.crossings[self.start as usize..(self.start + self.count) as usize]
    }
}

/// Whether a value counts as positive.
pub(crate) fn positive(value: f64) -> bool {
    value >= 0.0
}

impl Slice {
    /// The zero set of the function with these values at the vertices.
    pub fn of(surface: &Surface, values: &[f64]) -> Self {
        let side: Vec<bool> = values.iter().map(|v| positive(*v)).collect();
        let mut slice = Self::default();
        let entries = entries(surface, &side);
        let mut done = vec![false; surface.half.len()];
        // Open chains first, from where they enter; what is left is closed.
        for border in [true, false] {
            for &half in &entries {
                let edge = surface.edge[half as usize] as usize;
                if !done[edge] && (!border || surface.mate[half as usize] == NONE) {
                    slice.chain(surface, &side, values, half, &mut done);
                }
            }
        }
        slice
    }

    /// The chains of crossings that `at` finds on single edges, joined through faces with exactly
    /// two of them.
    pub fn of_edges(surface: &Surface, at: impl Fn(u32) -> Option<f64>) -> Self {
        let found: Vec<Option<f64>> = (0..surface.half.len() as u32).map(at).collect();
        let mut slice = Self::default();
        let mut done = vec![false; found.len()];
        for ends in [true, false] {
            for edge in 0..found.len() as u32 {
                let faces = joining(surface, &found, edge);
                if found[edge as usize].is_some()
                    && !done[edge as usize]
                    && (!ends || faces.len() < 2)
                {
                    slice.loose_chain(surface, &found, edge, &mut done);
                }
            }
        }
        slice
    }

    fn loose_chain(
        &mut self,
        surface: &Surface,
        found: &[Option<f64>],
        first: u32,
        done: &mut [bool],
    ) {
        let start = self.crossings.len() as u32;
        let (mut edge, mut behind) = (first, NONE);
        let closed = loop {
            done[edge as usize] = true;
            let at = found[edge as usize].unwrap_or(0.5);
            let ahead = joining(surface, found, edge).into_iter().find(|f| *f != behind);
            self.crossings.push(Crossing { edge, at, face: ahead.unwrap_or(NONE) });
            let Some(face) = ahead else { break false };
            let others = (3 * face..3 * face + 3).map(|h| surface.edge[h as usize]);
            let next = others.filter(|e| *e != edge).find(|e| found[*e as usize].is_some());
            match next {
                Some(next) if !done[next as usize] => (edge, behind) = (next, face),
                Some(next) => break next == first,
                None => break false,
            }
        };
        if !closed && let Some(last) = self.crossings.last_mut() {
            last.face = NONE;
        }
        self.chains.push(Chain { start, count: self.crossings.len() as u32 - start, closed });
    }

    fn chain(
        &mut self,
        surface: &Surface,
        side: &[bool],
        values: &[f64],
        entry: u32,
        done: &mut [bool],
    ) {
        let start = self.crossings.len() as u32;
        let mut half = entry;
        let closed = loop {
            let edge = surface.edge[half as usize];
            if std::mem::replace(&mut done[edge as usize], true) {
                break true;
            }
            self.crossings.push(Crossing {
                edge,
                at: crossing(surface, values, edge),
                face: half / 3,
            });
            let leave = exit(surface, side, half);
            half = surface.mate[leave as usize];
            if half == NONE {
                let edge = surface.edge[leave as usize];
                done[edge as usize] = true;
                self.crossings.push(Crossing {
                    edge,
                    at: crossing(surface, values, edge),
                    face: NONE,
                });
                break false;
            }
        };
        let count = self.crossings.len() as u32 - start;
        self.chains.push(Chain { start, count, closed });
    }
}

/// The faces beside an edge with exactly two crossings.
fn joining(surface: &Surface, found: &[Option<f64>], edge: u32) -> Vec<u32> {
    let half = surface.half[edge as usize];
    let faces = [half, surface.mate[half as usize]].into_iter().filter(|h| *h != NONE);
    let crossings = |face: u32| {
        let edges = (3 * face..3 * face + 3).map(|h| surface.edge[h as usize]);
        edges.filter(|e| found[*e as usize].is_some()).count()
    };
    faces.map(|h| h / 3).filter(|f| crossings(*f) == 2).collect()
}

/// Half-edges by which a chain enters a face: from positive to negative; rising.
fn entries(surface: &Surface, side: &[bool]) -> Vec<u32> {
    let entry = |(f, face): (usize, &[u32; 3])| {
        let s = face.map(|v| side[v as usize]);
        let mixed = s[0] != s[1] || s[1] != s[2];
        let corner = (0..3).filter(|_| mixed).find(|&c| s[c] && !s[(c + 1) % 3]);
        corner.map(|c| (3 * f + c) as u32)
    };
    surface.faces.par_iter().enumerate().with_min_len(1 << 14).filter_map(entry).collect()
}

/// The half-edge by which a chain leaves the face that it enters by `half`.
pub(crate) fn exit(surface: &Surface, side: &[bool], half: u32) -> u32 {
    let ahead = next(half);
    // The face's third vertex decides which of the other two sides is crossed.
    if side[surface.from(previous(half)) as usize] { ahead } else { previous(half) }
}

/// Where the function is zero on a crossed edge.
pub(crate) fn crossing(surface: &Surface, values: &[f64], edge: u32) -> f64 {
    let [a, b] = surface.ends(edge).map(|v| values[v as usize]);
    let t = a / (a - b);
    if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.5 }
}
