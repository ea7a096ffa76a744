//! Films (section 3.8, which the thesis leaves open): labels that agree along the motion.
//!
//! The graph of a frame is joined to the one before by edges along the exact motion of each
//! material point ([`links`](chiaro_trace::links)), each worth about `coherence` times N~ (see
//! `hold.rs`: less where much changes, and where it costs much), and the volume is cut. A film is cut in windows of a few frames, so that memory is bounded:
//!
//! 1. The shot is divided into blocks of [`BLOCK`] frames. The first frame of a block is a *key*:
//!    it is labelled by the cut of the window centred on it, and so depends on those frames alone.
//! 2. Within a block each frame is labelled by the cut of the window that begins with it, the frame
//!    before being settled. Where the window reaches the next key, that is settled too.
//! 3. What was cut is settled: pieces under the smallest island grow or take the colour around them,
//!    whichever costs less in space and time, and new pieces that would be gone within two frames go
//!    at once. The next window starts from that, so that what was removed does not come back by
//!    itself, nor what has grown shrink. Where the frame weighs as the one before, labels stay
//!    (`still.rs`).
//! 4. Before the shot and after it all stands still: where a window reaches past the end, copies of
//!    the last frame fill it, so that what a change gains there counts on as many frames as elsewhere.
//!
//! Palettes have layers (see [`Cel`]): each is labelled as a film of its own. What is painted keeps its
//! label.
//!
//! Guaranteed: a frame's labels depend on its block, its keys and their windows alone, so that any
//! part of a film has the bytes of the whole; a film of what stands still is still. Not guaranteed: the least energy over the whole
//! volume; the past is settled when the future is cut.

use crate::cel::Cel;
use crate::hold::{Hold, Pace, holds, usual_hold};
use crate::island::{recoloured, without_islands};
use crate::knob::BinaryKnobs;
use crate::mend::{Costs, pixels_of};
use crate::still::{kept_still, still};
use crate::window::{Bond, Known, cut_window, pull};
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_image::labels::{UNCOVERED, components};
use chiaro_trace::UNLINKED;
use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;

/// Frames from one key to the next.
pub const BLOCK: usize = 16;

/// Frames that a new piece must outlast.
const LIFE: usize = 2;

/// Which frames are cut together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Frames of the shot.
    pub frames: usize,
    /// Frames of a window.
    pub window: usize,
}

impl Plan {
    /// The block that holds a frame.
    pub fn block(&self, frame: usize) -> Range<usize> {
        let key = frame / BLOCK * BLOCK;
        key..(key + BLOCK).min(self.frames)
    }

    /// The frames that a key is cut with.
    fn around(&self, key: usize) -> Range<usize> {
        let reach = self.window / 2;
        key.saturating_sub(reach)..(key + self.window - reach).min(self.frames)
    }

    /// The frames without which a block cannot be labelled.
    pub fn needed(&self, block: &Range<usize>) -> Range<usize> {
        let last = if block.end < self.frames { self.around(block.end).end } else { block.end };
        self.around(block.start).start..last
    }
}

/// What takes a labelled frame: its place in the shot, its cel, the labels of its layers.
pub type Done<'a, C> = dyn FnMut(usize, &C, &[Plane<u8>]) -> Result<()> + 'a;

/// A film being labelled, block after block.
pub struct Film<'a, C> {
    plan: Plan,
    knobs: &'a BinaryKnobs,
    /// Frames at hand, from `first` on.
    cels: VecDeque<C>,
    /// How strongly each holds on to the frame before it, by layer, and how much more or less the
    /// frame in work does.
    holds: VecDeque<Vec<Plane<i32>>>,
    /// What is still in each since the frame before it, by layer.
    stills: VecDeque<Vec<Plane<bool>>>,
    /// The last frame of the shot as it stands still after its end.
    stays: Option<Cel>,
    pace: Pace,
    first: usize,
    /// Labels of keys that were cut already, by layer.
    keys: BTreeMap<usize, Vec<Plane<u8>>>,
}

impl<'a, C: AsRef<Cel>> Film<'a, C> {
    /// A film of which nothing is labelled yet.
    pub fn new(plan: Plan, knobs: &'a BinaryKnobs) -> Self {
        Self {
            plan,
            knobs,
            cels: VecDeque::new(),
            holds: VecDeque::new(),
            stills: VecDeque::new(),
            stays: None,
            pace: Pace::default(),
            first: 0,
            keys: BTreeMap::new(),
        }
    }

    /// Labels the frames of a block in order and hands each to `done` with its cel. `fetch` makes
    /// the cel of a frame; it is asked for consecutive frames, or for the first one needed when
    /// blocks were left out. Blocks come in order.
    pub fn label(
        &mut self,
        block: &Range<usize>,
        fetch: &mut dyn FnMut(usize) -> Result<C>,
        done: &mut Done<'_, C>,
        run: &Run,
    ) -> Result<()> {
        let needed = self.plan.needed(block);
        if self.first + self.cels.len() < needed.start {
            self.cels.clear();
            self.holds.clear();
            self.stills.clear();
            self.first = needed.start;
        }
        let mut before = self.key(block.start, fetch, run)?;
        self.forget(block.start);
        self.pace.reset();
        done(block.start, self.cel(block.start), &before)?;
        for t in block.start + 1..block.end {
            let end = (t + self.plan.window).min(block.end);
            let reaches_key = t + self.plan.window > block.end && block.end < self.plan.frames;
            let key = match reaches_key {
                true => Some(self.key(block.end, fetch, run)?),
                false => None,
            };
            self.gather(end, fetch)?;
            self.forget(t);
            if end == self.plan.frames && self.stays.is_none() {
                self.stays = Some(self.cel(end - 1).as_ref().stayed());
            }
            let mut labels = Vec::with_capacity(before.len());
            for (layer, before) in before.iter().enumerate() {
                let key = key.as_ref().map(|labels| &labels[layer]);
                let (next, cost) = self.next(t..end, layer, (before, key), run)?;
                self.pace.learn(layer, cost, self.knobs);
                labels.push(next);
            }
            done(t, self.cel(t), &labels)?;
            before = labels;
        }
        self.keys.retain(|k, _| *k >= block.end);
        Ok(())
    }

    /// The labels of a key, by layer.
    fn key(
        &mut self,
        key: usize,
        fetch: &mut dyn FnMut(usize) -> Result<C>,
        run: &Run,
    ) -> Result<Vec<Plane<u8>>> {
        if let Some(labels) = self.keys.get(&key) {
            return Ok(labels.clone());
        }
        let around = self.plan.around(key);
        self.gather(around.end, fetch)?;
        let mut settled = Vec::new();
        for layer in 0..self.cel(key).as_ref().depth() {
            let labels = self.cut(around.clone(), (layer, 1.0), &Known::default(), run)?;
            let at = key - around.start;
            let clean = self.settled(key, layer, &labels, at)?;
            settled.push(self.cel(key).as_ref().kept(layer, clean));
        }
        self.keys.insert(key, settled.clone());
        Ok(settled)
    }

    /// The labels of a key, which is frame `at` of its window, settled. Links are worth as much
    /// everywhere here, and before the shot and after it all stands still, so that the keys of what
    /// is still are the same.
    fn settled(
        &self,
        key: usize,
        layer: usize,
        labels: &[Plane<u8>],
        at: usize,
    ) -> Result<Plane<u8>> {
        let cel = self.cel(key).as_ref();
        let even = usual_hold(&cel.graph, self.knobs);
        let hold = Hold::new(&even, 1.0);
        let stays = cel.staying();
        let bond = |links, labels| Bond { links, labels, hold };
        let before = match at.checked_sub(1) {
            Some(i) => bond(&cel.links, &labels[i]),
            None => bond(&stays, &labels[at]),
        };
        let after = match labels.get(at + 1) {
            Some(after) => bond(&self.cel(key + 1).as_ref().links, after),
            None => bond(&stays, &labels[at]),
        };
        let held = held((cel, layer), before, Some(after));
        cel.costs(&held, layer).finished(&labels[at], self.knobs)
    }

    /// The labels of the first frame of a window, the one before it being settled, and what its links
    /// have cost, as a share of the energy of its own cut.
    fn next(
        &self,
        window: Range<usize>,
        layer: usize,
        (before, key): (&Plane<u8>, Option<&Plane<u8>>),
        run: &Run,
    ) -> Result<(Plane<u8>, f32)> {
        let paced = (layer, self.pace.of(layer));
        let after = key.map(|labels| self.bond(window.end, paced, labels));
        let known = Known { before: Some(before), after };
        let labels = self.cut(window.clone(), paced, &known, run)?;
        let first = window.start;
        let hold = self.hold(first, paced);
        let cels: Vec<&Cel> = window.map(|i| self.cel(i).as_ref()).collect();
        let after = labels.get(1).map(|after| match (&self.stays, cels.len()) {
            (Some(stays), 1) => Bond { links: &stays.links, labels: after, hold },
            _ => self.bond(first + 1, paced, after),
        });
        let held =
            held((cels[0], layer), Bond { links: &cels[0].links, labels: before, hold }, after);
        let clean = cels[0].costs(&held, layer).finished(&labels[0], self.knobs)?;
        let costs = cels[0].costs(&held, layer);
        let clean = lasting((clean, &costs, hold), &labels, &cels, before, self.knobs);
        let stills = &self.stills[first - self.first][layer];
        let clean = kept_still(clean, before, &cels[0].links, stills);
        let own = cels[0].own(layer).1.max(1);
        let cost = (cels[0].energy(layer, &labels[0]) - own) as f32 / own as f32;
        Ok((cels[0].kept(layer, clean), cost))
    }

    /// How strongly a frame holds on to the one before.
    fn hold(&self, frame: usize, (layer, pace): (usize, f32)) -> Hold<'_> {
        Hold::new(&self.holds[frame - self.first][layer], pace)
    }

    /// The links to a frame of known labels after.
    fn bond<'b>(&'b self, frame: usize, paced: (usize, f32), labels: &'b Plane<u8>) -> Bond<'b> {
        let links = &self.cel(frame).as_ref().links;
        Bond { links, labels, hold: self.hold(frame, paced) }
    }

    fn cut(
        &self,
        window: Range<usize>,
        paced: (usize, f32),
        known: &Known,
        run: &Run,
    ) -> Result<Vec<Plane<u8>>> {
        let mut cels: Vec<&Cel> = window.clone().map(|i| self.cel(i).as_ref()).collect();
        let mut holds: Vec<Hold> = window.clone().map(|i| self.hold(i, paced)).collect();
        if let (Some(stays), Some(last)) = (self.stays_after(&window, known), holds.last().copied())
        {
            let missing = self.plan.window - window.len();
            cels.extend(std::iter::repeat_n(stays, missing));
            holds.extend(std::iter::repeat_n(last, missing));
        }
        run.check()?;
        let pixels = cels.iter().map(|c| c.graph.mask.len() as u64).sum();
        run.stage("cut", pixels, || cut_window((&cels, paced.0), &holds, known))
    }

    /// What follows a window that the shot ends with.
    fn stays_after(&self, window: &Range<usize>, known: &Known) -> Option<&Cel> {
        let ends = window.end == self.plan.frames && known.before.is_some();
        self.stays.as_ref().filter(|_| ends)
    }

    fn cel(&self, frame: usize) -> &C {
        &self.cels[frame - self.first]
    }

    fn gather(&mut self, end: usize, fetch: &mut dyn FnMut(usize) -> Result<C>) -> Result<()> {
        while self.first + self.cels.len() < end {
            let next = fetch(self.first + self.cels.len())?;
            let before = self.cels.back().map(AsRef::as_ref);
            let layers = 0..next.as_ref().depth();
            let stills = layers.map(|layer| still(next.as_ref(), before, layer)).collect();
            self.stills.push_back(stills);
            self.holds.push_back(holds(next.as_ref(), before, self.knobs));
            self.cels.push_back(next);
        }
        Ok(())
    }

    /// Lets go of the frames before one, but for those that the next key needs.
    fn forget(&mut self, frame: usize) {
        while self.first < frame {
            self.cels.pop_front();
            self.holds.pop_front();
            self.stills.pop_front();
            self.first += 1;
        }
    }
}

/// Labels of the first frame of a window without those of a short life: a piece that is new and of
/// which less than half is left in one of the next [`LIFE`] frames is taken away at once, if that
/// costs no more than its links are worth.
fn lasting(
    (clean, costs, hold): (Plane<u8>, &Costs<'_>, Hold<'_>),
    labels: &[Plane<u8>],
    cels: &[&Cel],
    before: &Plane<u8>,
    knobs: &BinaryKnobs,
) -> Plane<u8> {
    let mask = &cels[0].graph.mask;
    let area = knobs.island_area(mask.height());
    if area <= 0.0 {
        return clean;
    }
    let pieces = components(&clean, mask);
    let count = pieces.pieces.len();
    let is_new = mostly_new(&pieces.ids, &clean, cels[0], before, count);
    if !is_new.contains(&true) {
        return clean;
    }
    let mut lasts = vec![true; count];
    let mut owner = pieces.ids.clone();
    for (cel, labels) in cels.iter().zip(labels).skip(1).take(LIFE) {
        let (mut kept, mut seen) = (vec![0u32; count], vec![0u32; count]);
        let from = owner;
        owner =
            cel.links.map(|&l| if l == UNLINKED { UNCOVERED } else { from.pixels()[l as usize] });
        for (id, label) in owner.pixels().iter().zip(labels.pixels()) {
            if *id != UNCOVERED {
                seen[*id as usize] += 1;
                kept[*id as usize] += u32::from(*label == pieces.pieces[*id as usize].label);
            }
        }
        for id in 0..count {
            lasts[id] &= 2 * kept[id] >= seen[id];
        }
    }
    let is_cheap = |id: usize| {
        let piece = &pieces.pieces[id];
        let pixels = pixels_of(piece, &pieces.ids, id as u32);
        let links: i64 = pixels.iter().map(|(x, y)| i64::from(hold.at(y * mask.width() + x))).sum();
        costs.removal(&clean, &pixels, piece.label) <= links
    };
    let goes =
        |id: usize| is_new[id] && !lasts[id] && pieces.pieces[id].touches_other && is_cheap(id);
    without_islands(&recoloured(&clean, &pieces, mask, &goes), mask, area)
}

/// The prices of a frame's layer with the pull of its links to the labels before and after it.
fn held((cel, layer): (&Cel, usize), before: Bond<'_>, after: Option<Bond<'_>>) -> Vec<i32> {
    let count = cel.count(layer);
    let mut prices = cel.prices(layer).to_vec();
    let Bond { links, labels, hold } = before;
    for (p, to) in links.pixels().iter().enumerate().filter(|(_, to)| **to != UNLINKED) {
        pull(&mut prices[p * count..][..count], labels.pixels()[*to as usize], hold.at(p));
    }
    if let Some(Bond { links, labels, hold }) = after {
        for (p, (to, label)) in links.pixels().iter().zip(labels.pixels()).enumerate() {
            if *to != UNLINKED {
                pull(&mut prices[*to as usize * count..][..count], *label, hold.at(p));
            }
        }
    }
    prices
}

/// For each piece whether most of its pixels that were seen before had the other label.
fn mostly_new(
    ids: &Plane<u32>,
    labels: &Plane<u8>,
    cel: &Cel,
    before: &Plane<u8>,
    count: usize,
) -> Vec<bool> {
    let (mut new, mut seen) = (vec![0u32; count], vec![0u32; count]);
    for ((id, link), label) in ids.pixels().iter().zip(cel.links.pixels()).zip(labels.pixels()) {
        if *id != UNCOVERED && *link != UNLINKED {
            seen[*id as usize] += 1;
            new[*id as usize] += u32::from(before.pixels()[*link as usize] != *label);
        }
    }
    new.iter().zip(&seen).map(|(n, s)| *s > 0 && 4 * n > 3 * s).collect()
}
