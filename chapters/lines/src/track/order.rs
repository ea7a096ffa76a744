//! The order of flips: by time, and by a rule where times are equal.
//!
//! Symmetric and flat parts flip whole fans at once. Flips closer than [`TIE`] of an interval form a
//! batch; within it a vertex over which the line only slides goes first, then deaths, then saddles,
//! births last; then the lower id. Order by id alone would invent saddles by the hundred on a cube.

use super::kinetic::State;
use crate::slice::positive;
use std::collections::BTreeSet;

/// Flips closer than this, in parts of an interval, are simultaneous.
const TIE: f64 = 1e-6;

/// How simultaneous flips are ordered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// By time, then by what they do.
    Time,
    /// By vertex, whatever their time.
    Vertex,
}

/// A vertex that changes side, and when, in parts of the interval.
pub(super) type Pending = (f64, u32);

/// The vertices that change side between two frames.
pub(super) fn pending(before: &[f64], after: &[f64], order: Order) -> Vec<Pending> {
    let changes = |(a, b): (&f64, &f64)| positive(*a) != positive(*b);
    let time = |a: f64, b: f64| {
        let t = a / (a - b);
        if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.5 }
    };
    let mut flips: Vec<Pending> = before
        .iter()
        .zip(after)
        .enumerate()
        .filter(|(_, pair)| changes(*pair))
        .map(|(v, (a, b))| (time(*a, *b), v as u32))
        .collect();
    if order == Order::Time {
        flips.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }
    flips
}

/// Applies flips batch by batch; `apply` is told each in its turn.
pub(super) fn in_order(
    state: &mut State<'_>,
    flips: &[Pending],
    order: Order,
    mut apply: impl FnMut(&mut State<'_>, Pending),
) {
    let mut rest = flips;
    while let Some(first) = rest.first() {
        let tied = |f: &Pending| order == Order::Time && f.0 - first.0 < TIE;
        let count = rest.iter().take_while(|f| tied(f)).count().max(1);
        let (batch, later) = rest.split_at(count);
        match batch {
            [one] => apply(state, *one),
            _ => batched(state, batch, &mut apply),
        }
        rest = later;
    }
}

fn batched(
    state: &mut State<'_>,
    batch: &[Pending],
    apply: &mut impl FnMut(&mut State<'_>, Pending),
) {
    let mut time: std::collections::BTreeMap<u32, f64> = batch.iter().map(|f| (f.1, f.0)).collect();
    let mut queue: BTreeSet<(u8, u32)> = batch.iter().map(|f| (state.rank(f.1), f.1)).collect();
    let mut rank: std::collections::BTreeMap<u32, u8> = queue.iter().map(|q| (q.1, q.0)).collect();
    while let Some((_, vertex)) = queue.pop_first() {
        rank.remove(&vertex);
        let at = time.remove(&vertex).expect("each vertex flips once");
        apply(state, (at, vertex));
        for neighbour in state.neighbours(vertex) {
            if let Some(old) = rank.get_mut(&neighbour) {
                let new = state.rank(neighbour);
                queue.remove(&(*old, neighbour));
                queue.insert((new, neighbour));
                *old = new;
            }
        }
    }
}
