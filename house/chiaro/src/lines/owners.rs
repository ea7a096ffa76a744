//! Strokes in pieces: where rules or colours change from object to object along a line.
//!
//! An outline may run on from a hat to a head. Where what draws it is different there, it is drawn in
//! pieces that share the sample between them; u runs through. Pieces too short to be meant go with
//! their neighbours.

use chiaro_lines::{Owner, Stroke, Surface};
use std::borrow::Cow;

/// A piece shorter than this goes with the longer of its neighbours, pixels.
const SHORTEST: f64 = 12.0;

/// A run of samples that are drawn alike.
struct Run<L> {
    look: L,
    owner: Option<Owner>,
    /// Its first sample.
    from: usize,
    length: f64,
}

/// The pieces of a stroke, each with what it belongs to; `look` says how what belongs to an owner is
/// drawn.
pub(super) fn pieces<'a, L: PartialEq>(
    stroke: Cow<'a, Stroke>,
    surface: &Surface,
    mut look: impl FnMut(&Stroke, Option<Owner>) -> L,
) -> Vec<Cow<'a, Stroke>> {
    let owners: Vec<Option<Owner>> =
        stroke.samples.iter().map(|s| surface.owner(s.faces).or(stroke.owner)).collect();
    if owners.iter().all(|o| *o == stroke.owner) {
        return vec![stroke];
    }
    let mut looks = |stroke: &Stroke, owners: &[Option<Owner>]| {
        let looks = owners.iter().map(|o| look(stroke, *o));
        settled(runs(stroke, owners, looks))
    };
    let mut found = looks(&stroke, &owners);
    if let [only] = found.as_slice() {
        let owner = only.owner;
        return vec![if owner == stroke.owner {
            stroke
        } else {
            Cow::Owned(Stroke { owner, ..stroke.into_owned() })
        }];
    }
    let mut stroke = stroke;
    if stroke.closed {
        // It is opened where a piece begins.
        let start = found[1].from;
        let mut owners = owners;
        owners.rotate_left(start);
        stroke = Cow::Owned(opened(&stroke, start));
        owners.push(owners[0]);
        found = looks(&stroke, &owners);
    }
    let ends = found.iter().skip(1).map(|r| r.from).chain([stroke.samples.len() - 1]);
    let last = found.len() - 1;
    let own = |(k, (r, end)): (usize, (&Run<L>, usize))| {
        let [before, after] = stroke.goes_on;
        let goes_on = [before && k == 0, after && k == last];
        Cow::Owned(Stroke { goes_on, ..piece(&stroke, (r.from, end), r.owner) })
    };
    found.iter().zip(ends).enumerate().map(own).collect()
}

fn runs<L: PartialEq>(
    stroke: &Stroke,
    owners: &[Option<Owner>],
    looks: impl Iterator<Item = L>,
) -> Vec<Run<L>> {
    let mut runs: Vec<Run<L>> = Vec::new();
    for (k, (look, owner)) in looks.zip(owners).enumerate() {
        let length = stroke.length.get(k + 1).map_or(0.0, |l| l - stroke.length[k]);
        match runs.last_mut() {
            Some(run) if run.look == look => run.length += length,
            _ => runs.push(Run { look, owner: *owner, from: k, length }),
        }
    }
    runs
}

/// Runs without those that are too short.
fn settled<L: PartialEq>(mut runs: Vec<Run<L>>) -> Vec<Run<L>> {
    while runs.len() > 1 {
        let order = |a: &usize, b: &usize| runs[*a].length.total_cmp(&runs[*b].length);
        let Some(k) = (0..runs.len()).min_by(order).filter(|k| runs[*k].length < SHORTEST) else {
            break;
        };
        let short = runs.remove(k);
        let length = |k: Option<usize>| k.and_then(|k| runs.get(k)).map_or(-1.0, |r| r.length);
        let into_before = length(k.checked_sub(1)) >= length(Some(k));
        let into = if into_before { k - 1 } else { k };
        runs[into].length += short.length;
        if !into_before {
            runs[into].from = short.from;
        }
        if k > 0 && k < runs.len() && runs[k].look == runs[k - 1].look {
            let next = runs.remove(k);
            runs[k - 1].length += next.length;
        }
    }
    runs
}

/// A closed stroke as an open one that begins and ends at a sample.
fn opened(stroke: &Stroke, start: usize) -> Stroke {
    let n = stroke.samples.len();
    let once = stroke.u[n] - stroke.u[0];
    let mut u: Vec<f64> = stroke.u[start..n].to_vec();
    u.extend(stroke.u[..=start].iter().map(|u| u + once));
    let mut open = stroke.clone();
    open.samples.rotate_left(start);
    open.samples.push(open.samples[0]);
    open.closed = false;
    open.measure();
    open.set_u(u, stroke.pixels_per_u);
    open
}

/// The samples from one to another, both included.
fn piece(stroke: &Stroke, (from, to): (usize, usize), owner: Option<Owner>) -> Stroke {
    let samples = stroke.samples[from..=to].to_vec();
    let mut piece = Stroke { samples, owner, ..stroke.clone() };
    piece.measure();
    piece.set_u(stroke.u[from..=to].to_vec(), stroke.pixels_per_u);
    piece
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::{DVec2, DVec3};
    use chiaro_lines::{Kind, Sample, Source};
    use chiaro_scene::MaterialId;

    fn run(look: u32, from: usize, length: f64) -> Run<u32> {
        Run { look, owner: None, from, length }
    }

    /// A ring of 40 samples 3 pixels apart, one object's from `from` on, another's before.
    fn ring(from: usize) -> Stroke {
        let sample = |k: usize| Sample {
            at: 19.1 * DVec2::from_angle(std::f64::consts::TAU * k as f64 / 40.0),
            depth: 1.0,
            world: DVec3::ZERO,
            next_world: None,
            next_at: None,
            chain: 0,
            on_chain: k as f64,
            normal: DVec3::Z,
            faces: [u32::from(k >= from), u32::MAX],
        };
        let samples = (0..40).map(sample).collect();
        let ring = Stroke::through(Kind::Silhouette, true, samples);
        Stroke { id: 3, owner: Some(owner(0)), ..ring }
    }

    fn owner(object: u32) -> Owner {
        Owner { object, material: MaterialId::new(0) }
    }

    fn surface() -> Surface {
        let source = |object| Source {
            object,
            face: 0,
            part: 0,
            turned: false,
            mirrored: false,
            material: MaterialId::new(0),
            two_sided: false,
            opaque: true,
        };
        Surface { sources: vec![source(0), source(1)], ..Surface::default() }
    }

    #[test]
    fn a_ring_of_two_objects_is_two_pieces_whose_u_runs_on() {
        let ring = ring(25);
        let found = pieces(Cow::Borrowed(&ring), &surface(), |_, o| o);
        assert_eq!(
            found.iter().map(|p| p.owner).collect::<Vec<_>>(),
            [Some(owner(1)), Some(owner(0))]
        );
        let total: f64 = found.iter().map(|p| p.total()).sum();
        assert!((total - ring.total()).abs() < 1e-9);
        assert_eq!(found[0].u.last(), found[1].u.first());
        assert_eq!(found[0].samples.last(), found[1].samples.first());
        let once = found[1].u.last().unwrap() - found[0].u[0];
        assert!((once - ring.u_period.unwrap()).abs() < 1e-9);
        // Where both are drawn alike it stays whole, and so does one that a sliver of another touches.
        for (ring, alike) in [(ring, true), (self::ring(38), false)] {
            let found = pieces(Cow::Borrowed(&ring), &surface(), |_, o| o.filter(|_| !alike));
            assert!(found.len() == 1 && found[0].closed);
        }
    }

    #[test]
    fn short_pieces_go_with_their_longer_neighbours() {
        let found =
            settled(vec![run(0, 0, 40.0), run(1, 10, 5.0), run(0, 12, 60.0), run(2, 30, 20.0)]);
        let of: Vec<(u32, usize)> = found.iter().map(|r| (r.look, r.from)).collect();
        assert_eq!(of, [(0, 0), (2, 30)]);
        assert_eq!(found[0].length, 105.0);
        let found = settled(vec![run(1, 0, 5.0), run(0, 2, 60.0)]);
        assert_eq!((found.len(), found[0].look, found[0].from), (1, 0, 0));
    }
}
