//! [`Identity`]: which strokes of different frames are one.
//!
//! 1. Every element of a line (a crossing of the slice, an edge of a feature chain), hidden or not,
//!    remembers the stroke that it was last a part of. Along S that memory goes on to the next
//!    frame; where it meets a visible stroke, the two strokes are linked by the element's length.
//!    So a line that was hidden for a while finds its old stroke again.
//! 2. With the whole film known, strokes are joined by their heaviest links first; never two of one
//!    frame unless they are parts of one line, with a hidden part of it between them. The joined
//!    strokes share an id: so what passes in front of a line does not change its id.

use crate::surface::NONE;
use chiaro_basis::Sets;
use std::collections::BTreeMap;

/// Share of a link's weight that counts when the line was hidden in between.
const ACROSS_GAP: f64 = 0.5;

/// Elements of one family of chains in one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strands {
    /// For each element, the stroke of the frame that shows it, or [`NONE`].
    pub stroke: Vec<u32>,
    /// For each element, its picture length in pixels.
    pub weight: Vec<f32>,
    /// Where chains begin, and the end of the last: memory is not handed from one chain to another.
    pub starts: Vec<u32>,
}

impl Strands {
    /// Elements that nothing shows yet; `starts` as in the field.
    pub fn empty(starts: Vec<u32>) -> Self {
        let count = starts.last().copied().unwrap_or(0) as usize;
        Self { stroke: vec![NONE; count], weight: vec![0.0; count], starts }
    }
}

/// Links between the strokes of a film.
#[derive(Clone, Debug, Default)]
pub struct Identity {
    /// The frame of each stroke of the film.
    frames: Vec<u32>,
    /// Where each frame's strokes begin.
    first: Vec<u32>,
    /// The last stroke of each element, by family.
    memory: Vec<Vec<u32>>,
    links: BTreeMap<(u32, u32), f64>,
}

impl Identity {
    /// Goes on to a frame of so many strokes; `families`: elements of this frame with, for each
    /// element of the frame before, the one that it becomes; without it nothing is remembered.
    pub fn advance(&mut self, strokes: usize, families: &[(&Strands, Option<&[u32]>)]) {
        let frame = self.first.len() as u32;
        let base = self.frames.len() as u32;
        self.first.push(base);
        self.frames.extend(std::iter::repeat_n(frame, strokes));
        let old = std::mem::take(&mut self.memory);
        let mut old = old.into_iter().chain(std::iter::repeat(Vec::new()));
        for (strands, forward) in families {
            let before = old.next().unwrap_or_default();
            let memory = self.remember(strands, &before, forward.unwrap_or(&[]), base);
            self.memory.push(memory);
        }
    }

    fn remember(
        &mut self,
        strands: &Strands,
        before: &[u32],
        forward: &[u32],
        base: u32,
    ) -> Vec<u32> {
        let mut memory = vec![NONE; strands.stroke.len()];
        for (&node, &to) in before.iter().zip(forward) {
            if node == NONE || to == NONE {
                continue;
            }
            let j = to as usize;
            if strands.stroke[j] != NONE {
                self.link(node, base + strands.stroke[j], f64::from(strands.weight[j]));
            } else if memory[j] == NONE {
                memory[j] = node;
            }
        }
        for (m, stroke) in memory.iter_mut().zip(&strands.stroke) {
            if *stroke != NONE {
                *m = base + stroke;
            }
        }
        spread(&mut memory, strands);
        memory
    }

    /// Links two strokes of the film by some length.
    pub fn link(&mut self, from: u32, to: u32, weight: f64) {
        let near = self.frames[from as usize] + 1 == self.frames[to as usize];
        let weight = if near { weight } else { ACROSS_GAP * weight };
        *self.links.entry((from, to)).or_insert(0.0) += weight;
    }

    /// The number in the film of a stroke of a frame.
    pub fn node(&self, frame: usize, stroke: usize) -> u32 {
        self.first[frame] + stroke as u32
    }

    /// An id for every stroke of every frame, numbered as they appear. `lines`: for each stroke of the
    /// film a number that it shares with those of its frame that may have the same id.
    pub fn ids(self, lines: &[u32]) -> Vec<Vec<u32>> {
        let mut groups = Groups::of(&self.frames, lines);
        let mut links: Vec<((u32, u32), f64)> = self.links.into_iter().collect();
        links.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        for ((a, b), _) in links {
            groups.join(a, b);
        }
        let mut id = vec![NONE; self.frames.len()];
        let mut count = 0;
        let mut ids = vec![Vec::new(); self.first.len()];
        for (node, &frame) in self.frames.iter().enumerate() {
            let root = groups.root(node as u32) as usize;
            if id[root] == NONE {
                id[root] = count;
                count += 1;
            }
            ids[frame as usize].push(id[root]);
        }
        ids
    }
}

/// Elements that remember nothing take over from the hidden element before or after them.
fn spread(memory: &mut [u32], strands: &Strands) {
    for pair in strands.starts.windows(2) {
        let (start, end) = (pair[0] as usize, pair[1] as usize);
        let hidden = |k: usize| strands.stroke[k] == NONE;
        for k in start + 1..end {
            if memory[k] == NONE && hidden(k - 1) {
                memory[k] = memory[k - 1];
            }
        }
        for k in (start..end.saturating_sub(1)).rev() {
            if memory[k] == NONE && hidden(k + 1) {
                memory[k] = memory[k + 1];
            }
        }
    }
}

/// Groups of strokes with those of one chain in each frame.
struct Groups {
    sets: Sets,
    /// Frames of each root's group with the chain there, rising.
    frames: Vec<Vec<(u32, u32)>>,
}

impl Groups {
    fn of(frames: &[u32], chains: &[u32]) -> Self {
        Self {
            sets: Sets::new(frames.len()),
            frames: frames.iter().zip(chains).map(|(f, c)| vec![(*f, *c)]).collect(),
        }
    }

    fn root(&mut self, x: u32) -> u32 {
        self.sets.root(x as usize) as u32
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        if a == b {
            return;
        }
        let (fa, fb) = (&self.frames[a as usize], &self.frames[b as usize]);
        let (few, many) = if fa.len() < fb.len() { (fa, fb) } else { (fb, fa) };
        let clashes = |(frame, chain): &(u32, u32)| {
            let there = many.binary_search_by_key(frame, |f| f.0);
            there.is_ok_and(|i| many[i].1 != *chain)
        };
        if few.iter().any(clashes) {
            return;
        }
        let (root, other) = (a.min(b), a.max(b));
        self.sets.join(a as usize, b as usize);
        let moved = std::mem::take(&mut self.frames[other as usize]);
        let all = &mut self.frames[root as usize];
        all.extend(moved);
        all.sort_unstable();
        all.dedup();
    }
}
