//! Films of graphs whose right labels are known: what must hold along the motion.
#![allow(clippy::unwrap_used, reason = "a test may panic, also in its own functions")]

use chiaro_basis::{Run, random};
use chiaro_binary::{BLOCK, BinaryKnobs, Cel, Film, Flicker, Graph, Plan, Shown, toned};
use chiaro_image::Plane;
use chiaro_trace::UNLINKED;

const SIZE: (usize, usize) = (40, 30);

/// A tone with a slow large shape and noise that changes from frame to frame, moving one pixel to
/// the right every second frame.
fn cel(frame: usize, knobs: &BinaryKnobs) -> Cel {
    let (w, h) = SIZE;
    let covered = Plane::from_fn(w, h, |x, y| (x + y) % 23 != 0);
    let difference = Plane::from_fn(w, h, |x, y| {
        let (u, v) = ((x as f32 - 0.5 * frame as f32) * 0.3, y as f32 * 0.25);
        let noise = random::unit(7, ((frame * h + y) * w + x) as u64) - 0.5;
        0.25 * u.sin() * v.cos() + 0.25 * noise
    });
    let factors = Plane::filled(w, h, [1.0; 4]);
    let shift = usize::from(frame.is_multiple_of(2));
    let links = Plane::from_fn(w, h, |x, y| {
        let seen = frame > 0 && covered[(x, y)] && x >= shift && covered[(x - shift, y)];
        if seen { (y * w + x - shift) as u32 } else { UNLINKED }
    });
    Cel::new(Graph::new(&covered, &difference, &factors, knobs), links).unwrap()
}

struct Made(Cel);
impl AsRef<Cel> for Made {
    fn as_ref(&self) -> &Cel {
        &self.0
    }
}

/// The labels of the frames of blocks for which `chosen` holds.
fn labelled(
    plan: Plan,
    knobs: &BinaryKnobs,
    chosen: impl Fn(usize) -> bool,
) -> Vec<(usize, Plane<bool>)> {
    let mut film: Film<'_, Made> = Film::new(plan, knobs);
    let mut out = Vec::new();
    for start in (0..plan.frames).step_by(BLOCK).filter(|s| chosen(s / BLOCK)) {
        let block = plan.block(start);
        let needed = plan.needed(&block);
        let mut fetch = |i: usize| {
            assert!(needed.contains(&i), "frame {i} is not among {needed:?}");
            Ok(Made(cel(i, knobs)))
        };
        let mut done = |i: usize, _: &Made, labels: &[Plane<bool>]| {
            out.push((i, labels[0].clone()));
            Ok(())
        };
        film.label(&block, &mut fetch, &mut done, &Run::default()).unwrap();
    }
    out
}

#[test]
fn a_part_of_a_film_has_the_labels_of_the_whole() {
    for (frames, window) in [(3 * BLOCK - 5, 5), (2 * BLOCK + 1, 3), (2 * BLOCK + 2, 2), (3, 9)] {
        let knobs = BinaryKnobs::default();
        let plan = Plan { frames, window };
        let whole = labelled(plan, &knobs, |_| true);
        assert_eq!(whole.len(), frames);
        assert!(whole.iter().enumerate().all(|(i, (n, _))| i == *n));
        for part in 0..frames.div_ceil(BLOCK) {
            for (i, labels) in labelled(plan, &knobs, |b| b == part) {
                assert_eq!(labels, whole[i].1, "frame {i} of {frames}, window {window}");
            }
        }
        let gaps = labelled(plan, &knobs, |b| b != 1);
        assert!(gaps.iter().all(|(i, labels)| *labels == whole[*i].1));
    }
}

/// The flicker of a film, and of the same film frame by frame.
fn flicker(knobs: &BinaryKnobs) -> [Flicker; 2] {
    let plan = Plan { frames: 2 * BLOCK, window: knobs.window as usize };
    let mut sums = [Flicker::default(), Flicker::default()];
    for (i, white) in labelled(plan, knobs, |_| true) {
        let cel = cel(i, knobs);
        let alone = &cel.alone;
        for (sum, white) in sums.iter_mut().zip([&white, &alone.white]) {
            let shown = Shown {
                white,
                covered: &cel.graph.mask,
                links: &cel.links,
                alone: &alone.white,
                tone: &alone.white,
                energy: [cel.graph.energy(white), alone.cut],
            };
            sum.add(i, &shown);
        }
    }
    sums
}

#[test]
fn frames_that_hold_on_to_each_other_reverse_less() {
    let knobs = BinaryKnobs { island: 0.0, ..BinaryKnobs::default() };
    let [film, alone] = flicker(&knobs);
    assert!(alone.reversals > 100, "{}", alone.reversals);
    assert!(3 * film.reversals < alone.reversals, "{} {}", film.reversals, alone.reversals);
    assert!(film.energy_excess() > 0.0 && 2 * film.flips < alone.flips);
    assert_eq!(alone.energy_excess(), 0.0);
}

#[test]
fn islands_are_gone_from_every_frame() {
    let knobs = BinaryKnobs { island: 480.0 * 480.0 / 900.0 * 12.0, ..BinaryKnobs::default() };
    let area = knobs.island_area(SIZE.1);
    let plan = Plan { frames: BLOCK + 3, window: 5 };
    for (i, white) in labelled(plan, &knobs, |_| true) {
        let mask = cel(i, &knobs).graph.mask;
        let pieces = chiaro_image::labels::components(&white, &mask).pieces;
        assert!(pieces.iter().all(|p| !p.touches_other || p.area as f32 >= area), "frame {i}");
    }
}

/// A frame in three tones whose last column is painted white.
fn toned_cel(frame: usize, knobs: &BinaryKnobs) -> Cel {
    let plain = cel(frame, knobs);
    let shifted = |step: i32| {
        plain.graph.terminal.map(|[w, b]| {
            let pull = w - b - step;
            [pull.max(0), (-pull).max(0)]
        })
    };
    let terminals = vec![shifted(-600), shifted(600)];
    let painted = Plane::from_fn(SIZE.0, SIZE.1, |x, _| (x + 1 == SIZE.0).then_some(true));
    let mut toned = plain.in_tones(terminals).unwrap();
    toned.painted = Some(painted);
    toned
}

#[test]
fn tones_are_nested_and_paint_stays() {
    let knobs = BinaryKnobs::default();
    let plan = Plan { frames: BLOCK + 4, window: 5 };
    let mut film: Film<'_, Made> = Film::new(plan, &knobs);
    let mut levels = [0; 3];
    for block in [plan.block(0), plan.block(BLOCK)] {
        let mut done = |_: usize, made: &Made, steps: &[Plane<bool>]| {
            let mask = &made.0.graph.mask;
            let tones = toned(steps, &made.0, &knobs).labels;
            for (i, tone) in tones.pixels().iter().enumerate().filter(|(i, _)| mask.pixels()[*i]) {
                levels[usize::from(*tone)] += 1;
                let [dark, light] = [0, 1].map(|step| steps[step].pixels()[i]);
                assert!(dark || !light, "lighter than light, not lighter than dark");
                assert!((i + 1) % SIZE.0 != 0 || (dark && light), "paint is gone");
            }
            Ok(())
        };
        let mut fetch = |i| Ok(Made(toned_cel(i, &knobs)));
        film.label(&block, &mut fetch, &mut done, &Run::default()).unwrap();
    }
    assert!(levels.iter().all(|n| *n > 100), "{levels:?}");
}
