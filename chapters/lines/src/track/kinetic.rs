//! [`Kinetic`]: the zero set as a structure that changes flip by flip.
//!
//! 1. The state is one side a vertex. It implies the crossed edges and their chains.
//! 2. A flip edits its vertex's ring alone: spokes that were crossed are no more, the others are.
//!    A run of crossed spokes is an arc of the line that passes the vertex.
//! 3. One run that gives way to one: the line slides over the vertex. None before: birth; none
//!    after: death. Else a saddle: arcs meet and part in another way.
//! 4. Crossings of the earlier frame ride along: from a spoke to its counterpart across the vertex.
//!    Where they are at the end is their correspondence in the next frame, along S.
//! 5. Chains have labels that last: after a saddle a chain keeps the label that most of it had.

use super::order::{Order, in_order, pending};
use crate::slice::{Slice, exit, positive};
use crate::surface::{NONE, Ring, Surface};
use std::collections::BTreeMap;

/// What a flip does to the zero set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// A chain appears.
    Birth,
    /// A chain vanishes.
    Death,
    /// Arcs meet and part in another way: chains merge, split, or one changes its course.
    Saddle,
}

impl EventKind {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Birth => "birth",
            Self::Death => "death",
            Self::Saddle => "saddle",
        }
    }
}

/// A critical point of S.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// When, in parts of the interval.
    pub time: f64,
    /// At which vertex.
    pub vertex: u32,
    /// What.
    pub kind: EventKind,
    /// Arcs that meet, for saddles: 2 or more; a k-fold saddle counts as k - 1.
    pub arcs: u32,
    /// Labels of the chains before.
    pub before: Vec<u32>,
    /// Labels of the chains after.
    pub after: Vec<u32>,
}

/// What happens between two frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Interval {
    /// Births, deaths and saddles, in their order.
    pub events: Vec<Event>,
    /// How many vertices changed side.
    pub flips: u32,
    /// For each crossing of the earlier slice, the crossing of the later one that it becomes along
    /// S, or [`NONE`].
    pub forward: Vec<u32>,
    /// The sum of 1 - a over the flips, a = arcs in the flipped vertex's star just before (0 at a
    /// loop's death): what the interval adds to the Euler characteristic of S.
    pub euler: i64,
}

/// Sides and labels at one instant.
pub(super) struct State<'a> {
    surface: &'a Surface,
    side: Vec<bool>,
    /// The label of the chain through each crossed edge.
    label: Vec<u32>,
    next_label: u32,
    ring: Ring,
    /// First of the riders on each edge, then a linked list through `after`.
    rider: Vec<u32>,
    after: Vec<u32>,
}

/// A zero set on its way through a film.
pub struct Kinetic<'a> {
    state: State<'a>,
}

/// Maximal runs of equal spokes of a ring: first index, count, and whether they are crossed.
type Runs = Vec<(usize, usize, bool)>;

impl<'a> Kinetic<'a> {
    /// Begins at a frame with these values; chains get labels from `first_label` on, in the
    /// slice's order.
    pub fn new(surface: &'a Surface, values: &[f64], slice: &Slice, first_label: u32) -> Self {
        let mut state = State {
            surface,
            side: values.iter().map(|v| positive(*v)).collect(),
            label: vec![NONE; surface.half.len()],
            next_label: first_label,
            ring: Ring::default(),
            rider: vec![NONE; surface.half.len()],
            after: Vec::new(),
        };
        for chain in &slice.chains {
            let label = state.new_label();
            chain.of(slice).iter().for_each(|c| state.label[c.edge as usize] = label);
        }
        Self { state }
    }

    /// The label of the chain through a crossed edge.
    pub fn label(&self, edge: u32) -> u32 {
        self.state.label[edge as usize]
    }

    /// The first label that is not in use.
    pub fn next_label(&self) -> u32 {
        self.state.next_label
    }

    /// Whether each vertex is positive.
    pub fn sides(&self) -> &[bool] {
        &self.state.side
    }

    /// Goes on to the next frame.
    pub fn step(
        &mut self,
        before: &[f64],
        after: &[f64],
        slices: [&Slice; 2],
        order: Order,
    ) -> Interval {
        let flips = pending(before, after, order);
        let state = &mut self.state;
        state.after = vec![NONE; slices[0].crossings.len()];
        for (k, c) in slices[0].crossings.iter().enumerate() {
            state.rider[c.edge as usize] = k as u32;
        }
        let mut interval = Interval {
            flips: flips.len() as u32,
            forward: vec![NONE; slices[0].crossings.len()],
            ..Interval::default()
        };
        in_order(state, &flips, order, |state, (time, vertex)| {
            interval.euler += state.flip(time, vertex, &mut interval.events);
        });
        for (j, c) in slices[1].crossings.iter().enumerate() {
            let mut rider = std::mem::replace(&mut state.rider[c.edge as usize], NONE);
            while rider != NONE {
                interval.forward[rider as usize] = j as u32;
                rider = state.after[rider as usize];
            }
        }
        interval
    }
}

impl State<'_> {
    fn new_label(&mut self) -> u32 {
        self.next_label += 1;
        self.next_label - 1
    }

    /// The place of a flip among simultaneous ones.
    pub(super) fn rank(&mut self, vertex: u32) -> u8 {
        let runs = self.runs(vertex);
        let crossed = runs.iter().filter(|r| r.2).count();
        match (crossed, runs.len() - crossed) {
            (1, 1) => 0,
            (_, 0) => 1,
            (0, _) => 3,
            _ => 2,
        }
    }

    pub(super) fn neighbours(&mut self, vertex: u32) -> Vec<u32> {
        self.ring.walk(self.surface, vertex);
        self.ring.around.clone()
    }

    /// The runs of a vertex's ring, which stays in `self.ring`; in a closed ring a run that goes
    /// past the last spoke is one.
    fn runs(&mut self, vertex: u32) -> Runs {
        self.ring.walk(self.surface, vertex);
        let n = self.ring.around.len();
        let crossed =
            |i: usize| self.side[self.ring.around[i % n] as usize] != self.side[vertex as usize];
        let start = if self.ring.closed {
            (0..n).find(|&i| crossed(i) != crossed(i + n - 1)).unwrap_or(0)
        } else {
            0
        };
        let mut runs: Runs = Vec::new();
        for i in start..start + n {
            match runs.last_mut() {
                Some(run) if run.2 == crossed(i) => run.1 += 1,
                _ => runs.push((i, 1, crossed(i))),
            }
        }
        runs
    }

    /// Flips a vertex; answers 1 - a.
    fn flip(&mut self, time: f64, vertex: u32, events: &mut Vec<Event>) -> i64 {
        let runs = self.runs(vertex);
        let crossed = runs.iter().filter(|r| r.2).count();
        let free = runs.len() - crossed;
        let around = self.ring.closed && free == 0;
        let labels_before = self.labels(&runs);
        self.move_riders(&runs);
        self.side[vertex as usize] ^= true;
        let event = |kind, before, after| Event {
            time,
            vertex,
            kind,
            arcs: crossed.max(free) as u32,
            before,
            after,
        };
        match (crossed, free) {
            (1, 1) => {
                let label = labels_before[0];
                self.put_labels(&runs, label);
            }
            (0, _) => {
                let label = self.new_label();
                self.put_labels(&runs, label);
                events.push(event(EventKind::Birth, Vec::new(), vec![label]));
            }
            (_, 0) => events.push(event(EventKind::Death, labels_before, Vec::new())),
            _ => {
                let after = self.relabel(&runs, &labels_before);
                events.push(event(EventKind::Saddle, labels_before, after));
            }
        }
        1 - if around { 0 } else { crossed as i64 }
    }

    fn spoke(&self, index: usize) -> usize {
        self.ring.spokes[index % self.ring.spokes.len()] as usize
    }

    /// The labels of the arcs, rising, each once.
    fn labels(&self, runs: &Runs) -> Vec<u32> {
        let crossed = runs.iter().filter(|r| r.2);
        let mut labels: Vec<u32> = crossed.map(|r| self.label[self.spoke(r.0)]).collect();
        labels.sort_unstable();
        labels.dedup();
        labels
    }

    fn put_labels(&mut self, runs: &Runs, label: u32) {
        for &(start, count, _) in runs.iter().filter(|r| !r.2) {
            for i in start..start + count {
                let spoke = self.spoke(i);
                self.label[spoke] = label;
            }
        }
    }

    /// Takes riders from crossed spokes to those that will be, across the vertex.
    fn move_riders(&mut self, runs: &Runs) {
        let n = runs.len();
        let cyclic = self.ring.closed;
        for r in (0..n).filter(|&r| runs[r].2) {
            let before = (r > 0 || cyclic && n > 1).then(|| runs[(r + n - 1) % n]);
            let after = (r + 1 < n || cyclic && n > 1).then(|| runs[(r + 1) % n]);
            let (start, count, _) = runs[r];
            for i in 0..count {
                let share = (i as f64 + 0.5) / count as f64;
                let target = counterpart(share, before, after);
                let from = self.spoke(start + i);
                let to = target.map(|t| self.spoke(t));
                self.ride(from, to);
            }
        }
    }

    fn ride(&mut self, from: usize, to: Option<usize>) {
        let first = std::mem::replace(&mut self.rider[from], NONE);
        let Some(to) = to.filter(|_| first != NONE) else { return };
        let mut last = first;
        while self.after[last as usize] != NONE {
            last = self.after[last as usize];
        }
        self.after[last as usize] = self.rider[to];
        self.rider[to] = first;
    }

    /// Labels the chains that a saddle leaves: each keeps the label that most of it had, unless a
    /// longer one does.
    fn relabel(&mut self, runs: &Runs, before: &[u32]) -> Vec<u32> {
        let spokes: Vec<usize> = runs.iter().filter(|r| !r.2).map(|r| self.spoke(r.0)).collect();
        // New spokes take part without a vote.
        self.put_labels(runs, NONE);
        let mut chains: Vec<Vec<u32>> = Vec::new();
        for spoke in spokes {
            if !chains.iter().any(|c| c.contains(&(spoke as u32))) {
                chains.push(self.chain_through(spoke as u32));
            }
        }
        let mut votes: Vec<(usize, usize, u32)> = Vec::new();
        for (c, chain) in chains.iter().enumerate() {
            let mut count = BTreeMap::new();
            for edge in chain {
                *count.entry(self.label[*edge as usize]).or_insert(0) += 1;
            }
            votes.extend(count.into_iter().map(|(label, n)| (n, c, label)));
        }
        votes.retain(|v| before.contains(&v.2));
        votes.sort_by(|a, b| b.0.cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut given = vec![NONE; chains.len()];
        for (_, chain, label) in votes {
            if given[chain] == NONE && !given.contains(&label) {
                given[chain] = label;
            }
        }
        for (chain, label) in chains.iter().zip(&mut given) {
            if *label == NONE {
                *label = self.new_label();
            }
            chain.iter().for_each(|e| self.label[*e as usize] = *label);
        }
        given
    }

    /// The edges of the chain through a crossed edge.
    fn chain_through(&self, edge: u32) -> Vec<u32> {
        let (_, ahead) = self.sides_of(edge);
        let mut edges = vec![edge];
        // Backwards too if the chain has an end.
        if !self.follow(ahead, edge, &mut edges) {
            self.follow_back(edge, &mut edges);
        }
        edges
    }

    /// The half-edge by which the chain leaves the face behind an edge, and the one by which it
    /// enters the face ahead; [`NONE`] on borders.
    fn sides_of(&self, edge: u32) -> (u32, u32) {
        let half = self.surface.half[edge as usize];
        let mate = self.surface.mate[half as usize];
        if self.side[self.surface.from(half) as usize] { (mate, half) } else { (half, mate) }
    }

    /// Follows a chain forwards; whether it came back to `start`.
    fn follow(&self, mut half: u32, start: u32, edges: &mut Vec<u32>) -> bool {
        while half != NONE {
            let leave = exit(self.surface, &self.side, half);
            let edge = self.surface.edge[leave as usize];
            if edge == start {
                return true;
            }
            edges.push(edge);
            half = self.surface.mate[leave as usize];
        }
        false
    }

    fn follow_back(&self, mut edge: u32, edges: &mut Vec<u32>) {
        loop {
            let (behind, _) = self.sides_of(edge);
            if behind == NONE {
                return;
            }
            // The other crossed side of the face behind: the one whose start is positive.
            let face = behind / 3;
            let entry = (3 * face..3 * face + 3).find(|&h| {
                self.side[self.surface.from(h) as usize] && !self.side[self.surface.to(h) as usize]
            });
            edge = self.surface.edge
                [entry.expect("a chain enters every face that it leaves") as usize];
            edges.push(edge);
        }
    }
}

/// The spoke across the vertex from a share of a run of crossed spokes, between the free runs
/// `before` and `after` it in the ring.
fn counterpart(
    share: f64,
    before: Option<(usize, usize, bool)>,
    after: Option<(usize, usize, bool)>,
) -> Option<usize> {
    let pick = |(start, count, _): (usize, usize, bool), s: f64| {
        start + ((s * count as f64) as usize).min(count - 1)
    };
    match (before, after) {
        // One run on the other side: the same order, seen from across.
        (Some(b), Some(a)) if b.0 == a.0 => Some(pick(a, 1.0 - share)),
        (Some(b), Some(_)) if share < 0.5 => Some(pick(b, 1.0 - share)),
        (Some(_), Some(a)) => Some(pick(a, 1.0 - share)),
        (Some(b), None) => Some(pick(b, 1.0 - share)),
        (None, Some(a)) => Some(pick(a, 1.0 - share)),
        (None, None) => None,
    }
}
