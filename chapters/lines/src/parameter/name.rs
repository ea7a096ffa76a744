//! Names: ids of strokes after they were cut and linked.
//!
//! Lines join where links that are trusted lead from one to the other: first where these take in nearly
//! all of both, then heaviest first, or where two are each other's best, whichever keeps more of the links
//! within an id. Lines of one frame share an id
//! where they are parts of one line of the surface, and where their stretches of u lie beside each other,
//! as when a line is parted by what passes before it or by a saddle; last, whatever their u, where they
//! were one line before it was hidden. Where two ids run into each other for good one of them ends.

use super::cut::Kept;
use super::net::{Line, Net, strokes};
use crate::film::Film;
use chiaro_basis::Sets;
use std::collections::BTreeMap;

/// Stretches of u may overlap by this share of the shorter, and by these pixels at least: a sliver that
/// comes off a line for some frames is still that line.
const OVERLAP: f64 = 0.1;
const LEAST: f64 = 20.0;
/// Lines are one where links lead from one to the other along this share of the shorter.
pub(super) const LED: f64 = 0.15;
/// Nothing merges and nothing parts where links take in this share of the longer.
const PURE: f64 = 0.8;
/// Links that were cut count against a line's going on where they are this share of all.
const CUT: f64 = 0.5;

/// Links from one line to another.
struct Bundle {
    lines: [u32; 2],
    weight: f64,
    mutual: bool,
    /// Whether the lines are the same from end to end.
    pure: bool,
}

/// What a line covers in its frame.
#[derive(Clone, Copy)]
struct Span {
    frame: u32,
    /// Stretch of u in pixels; all of it where the line is closed.
    from: f64,
    to: f64,
    /// A number that it shares with lines of its frame that may have one id.
    chain: u32,
}

/// Gives the strokes of a film ids that follow the links that are trusted. `scale`: pixels a unit of
/// u for each line.
pub(crate) fn rename(film: &mut Film, net: &Net, kept: &Kept, scale: &[f64]) {
    let (mut spans, mut old) = (Vec::new(), Vec::new());
    for (frame, s) in film.frames.iter().flat_map(|f| strokes(f).map(move |s| (f, s))) {
        let line = spans.len();
        let chain = film.line_of(frame, s);
        spans.push(span(&net.lines[line], &kept.u, scale[line], chain));
        old.push(s.id);
    }
    let bundles = bundles(net, &kept.trust);
    let [mut groups, mut other] =
        [true, false].map(|mutual| Groups::joined(&spans, &bundles, mutual));
    if other.kept(&bundles) > groups.kept(&bundles) {
        groups = other;
    }
    let apart = kept_apart(net, &kept.trust);
    let mut seen: BTreeMap<u32, u32> = BTreeMap::new();
    for (line, id) in old.iter().enumerate() {
        let lines = seen.insert(*id, line as u32).map(|before| [before, line as u32]);
        if let Some(lines) = lines.filter(|l| !apart.contains_key(l)) {
            groups.join(lines, |a, b| a.chain != b.chain);
        }
    }
    let mut names: BTreeMap<u32, u32> = BTreeMap::new();
    let mut line = 0;
    for frame in &mut film.frames {
        for stroke in frame.strokes.iter_mut().chain(&mut frame.hidden) {
            let count = names.len() as u32;
            stroke.id = *names.entry(groups.root(line)).or_insert(count);
            line += 1;
        }
    }
    film.settle_events();
}

fn span(line: &Line, u: &[f64], scale: f64, chain: u32) -> Span {
    let ends = [line.first, line.first + line.count - 1].map(|k| scale * u[k as usize]);
    let [from, to] = if line.closed { [f64::NEG_INFINITY, f64::INFINITY] } else { ends };
    Span { frame: line.frame, from, to, chain }
}

/// Whether two lines of one frame can have no id in common.
fn clash(a: &Span, b: &Span) -> bool {
    a.chain != b.chain && overlaps(a, b)
}

fn overlaps(a: &Span, b: &Span) -> bool {
    let shared = a.to.min(b.to) - a.from.max(b.from);
    let shorter = (a.to - a.from).min(b.to - b.from);
    shared > LEAST.max(OVERLAP * shorter)
}

/// Weight of the links from line to line: those that are trusted, and all.
pub(super) fn weights(net: &Net, trust: &[f64]) -> BTreeMap<[u32; 2], [f64; 2]> {
    let mut weights: BTreeMap<[u32; 2], [f64; 2]> = BTreeMap::new();
    for (link, trust) in net.links.iter().zip(trust) {
        let sums = weights.entry(link.lines).or_insert([0.0; 2]);
        sums[0] += trust * link.weight;
        sums[1] += link.weight;
    }
    weights
}

/// Lines whose links were mostly cut.
fn kept_apart(net: &Net, trust: &[f64]) -> BTreeMap<[u32; 2], [f64; 2]> {
    weights(net, trust).into_iter().filter(|(_, w)| w[0] < CUT * w[1]).collect()
}

/// Bundles of trusted links, the heaviest first.
fn bundles(net: &Net, trust: &[f64]) -> Vec<Bundle> {
    let weights = weights(net, trust);
    let mut best: [BTreeMap<u32, (f64, u32)>; 2] = [BTreeMap::new(), BTreeMap::new()];
    for (lines, [weight, _]) in &weights {
        for side in [0, 1] {
            let entry = best[side].entry(lines[side]).or_insert((0.0, u32::MAX));
            if *weight > entry.0 {
                *entry = (*weight, lines[1 - side]);
            }
        }
    }
    let of = |line: u32| net.lines[line as usize].total();
    let is_best = |lines: &[u32; 2], side: usize| best[side][&lines[side]].1 == lines[1 - side];
    let mut bundles: Vec<Bundle> = weights
        .iter()
        .filter(|(lines, [weight, _])| *weight > LED * of(lines[0]).min(of(lines[1])))
        .map(|(lines, [weight, _])| Bundle {
            lines: *lines,
            weight: *weight,
            mutual: is_best(lines, 0) && is_best(lines, 1),
            pure: *weight > PURE * of(lines[0]).max(of(lines[1])),
        })
        .collect();
    bundles.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.lines.cmp(&b.lines)));
    bundles
}

/// Groups of lines with what they cover in each frame.
struct Groups {
    sets: Sets,
    /// Spans of each root's group, frames rising.
    spans: Vec<Vec<Span>>,
}

impl Groups {
    fn of(spans: &[Span]) -> Self {
        let sets = Sets::new(spans.len());
        Self { sets, spans: spans.iter().map(|s| vec![*s]).collect() }
    }

    /// Lines joined along pure bundles and then all in their order, or along mutual ones before all others.
    fn joined(spans: &[Span], bundles: &[Bundle], mutual: bool) -> Self {
        let mut groups = Self::of(spans);
        let pure = bundles.iter().filter(|b| b.pure);
        let first = bundles.iter().filter(|b| mutual && b.mutual);
        pure.chain(first).chain(bundles).for_each(|b| groups.join(b.lines, clash));
        groups
    }

    /// The weight of the bundles within groups.
    fn kept(&mut self, bundles: &[Bundle]) -> f64 {
        let within = bundles.iter().filter(|b| self.root(b.lines[0]) == self.root(b.lines[1]));
        within.map(|b| b.weight).sum()
    }

    fn root(&mut self, x: u32) -> u32 {
        self.sets.root(x as usize) as u32
    }

    /// Joins the groups of two lines unless two of their lines in one frame clash.
    fn join(&mut self, lines: [u32; 2], clash: impl Fn(&Span, &Span) -> bool) {
        let [a, b] = lines.map(|l| self.root(l));
        if a == b || self.clashes(a, b, clash) {
            return;
        }
        let (root, other) = (a.min(b), a.max(b));
        self.sets.join(a as usize, b as usize);
        let moved = std::mem::take(&mut self.spans[other as usize]);
        let all = &mut self.spans[root as usize];
        all.extend(moved);
        all.sort_by_key(|s| s.frame);
    }

    fn clashes(&self, a: u32, b: u32, clash: impl Fn(&Span, &Span) -> bool) -> bool {
        let (a, b) = (&self.spans[a as usize], &self.spans[b as usize]);
        let (few, many) = if a.len() < b.len() { (a, b) } else { (b, a) };
        few.iter().any(|s| {
            let start = many.partition_point(|m| m.frame < s.frame);
            many[start..].iter().take_while(|m| m.frame == s.frame).any(|m| clash(s, m))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(frame: u32, from: f64, to: f64) -> Span {
        Span { frame, from, to, chain: 0 }
    }

    #[test]
    fn parts_that_lie_beside_each_other_share_a_name() {
        // One line, then its two halves, then a third that lies over the second.
        let spans = vec![
            span(0, 0.0, 100.0),
            span(1, 0.0, 40.0),
            span(1, 42.0, 100.0),
            span(1, 50.0, 90.0),
        ];
        let mut groups = Groups::of(&spans);
        for b in 1..4 {
            groups.join([0, b], overlaps);
        }
        let roots: Vec<u32> = (0..4).map(|i| groups.root(i)).collect();
        assert_eq!(roots, [0, 0, 0, 3]);
    }

    #[test]
    fn names_keep_what_weighs_most() {
        // A long line (0) and a short one (1) become one (2), which the short one alone likes best.
        let spans = [span(0, 0.0, 100.0), span(0, 0.0, 30.0), span(1, 0.0, 100.0)]
            .map(|s| Span { chain: s.to as u32, ..s });
        let bundle = |lines, weight, mutual| Bundle { lines, weight, mutual, pure: false };
        let bundles = [bundle([0, 2], 90.0, false), bundle([1, 2], 30.0, true)];
        let kept =
            [true, false].map(|mutual| Groups::joined(&spans, &bundles, mutual).kept(&bundles));
        assert_eq!(kept, [30.0, 90.0]);
    }

    #[test]
    fn a_line_that_goes_on_as_one_keeps_its_name() {
        // A head (0, 1) and a body (2, 3) that become one line (4): the body weighs more in every frame,
        // and the head's last step weighs more than its first.
        let spans = [span(0, 0.0, 100.0), span(1, 0.0, 100.0), span(0, 0.0, 300.0)]
            .into_iter()
            .chain([span(1, 0.0, 300.0), span(2, 0.0, 400.0)])
            .zip([0, 0, 1, 1, 1])
            .map(|(s, chain)| Span { chain, ..s })
            .collect::<Vec<_>>();
        let bundle = |lines, weight, pure| Bundle { lines, weight, mutual: pure, pure };
        let bundles = [
            bundle([2, 3], 300.0, true),
            bundle([3, 4], 299.0, false),
            bundle([1, 4], 100.0, false),
            bundle([0, 1], 99.0, true),
        ];
        let mut groups = Groups::joined(&spans, &bundles, false);
        let roots: Vec<u32> = (0..5).map(|i| groups.root(i)).collect();
        assert_eq!(roots, [0, 0, 2, 2, 2]);
    }

    #[test]
    fn nothing_lies_beside_a_closed_line() {
        let whole = span(0, f64::NEG_INFINITY, f64::INFINITY);
        assert!(overlaps(&whole, &span(0, 0.0, 30.0)));
        assert!(!overlaps(&span(0, 0.0, 30.0), &span(0, 25.0, 60.0)));
    }
}
