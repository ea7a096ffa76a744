//! Films of graphs whose right labels are known: what must hold along the motion.
#![allow(clippy::unwrap_used, reason = "a test may panic, also in its own functions")]

use chiaro_basis::{Run, random};
use chiaro_binary::{
    BLOCK, BinaryKnobs, Cel, Film, Flicker, Graph, Layer, Palette, Plan, Shown,
    labelled as coloured,
};
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
) -> Vec<(usize, Plane<u8>)> {
    let mut film: Film<'_, Made> = Film::new(plan, knobs);
    let mut out = Vec::new();
    for start in (0..plan.frames).step_by(BLOCK).filter(|s| chosen(s / BLOCK)) {
        let block = plan.block(start);
        let needed = plan.needed(&block);
        let mut fetch = |i: usize| {
            assert!(needed.contains(&i), "frame {i} is not among {needed:?}");
            Ok(Made(cel(i, knobs)))
        };
        let mut done = |i: usize, _: &Made, labels: &[Plane<u8>]| {
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
    for (i, labels) in labelled(plan, knobs, |_| true) {
        let cel = cel(i, knobs);
        let (alone, cut) = cel.own(0);
        for (sum, labels) in sums.iter_mut().zip([&labels, alone]) {
            let shown = Shown {
                labels,
                covered: &cel.graph.mask,
                links: &cel.links,
                alone,
                tone: &cel.wanted(0),
                energy: [cel.energy(0, labels), cut],
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

/// A still film in black of which a square wants a little to be white on one frame.
fn glimpse(frames: usize, at: usize) -> Vec<(usize, Plane<u8>)> {
    let (w, h) = SIZE;
    let knobs = BinaryKnobs { island: 0.0, ..BinaryKnobs::default() };
    let mut film: Film<'_, Made> = Film::new(Plan { frames, window: 5 }, &knobs);
    let mut fetch = |i: usize| {
        let is_in = |x, y| i == at && (14..26).contains(&x) && (9..21).contains(&y);
        let difference = Plane::from_fn(w, h, |x, y| if is_in(x, y) { 0.04 } else { -0.3 });
        let covered = Plane::filled(w, h, true);
        let graph = Graph::new(&covered, &difference, &Plane::filled(w, h, [1.0; 4]), &knobs);
        Ok(Made(Cel::new(graph, staying(i, SIZE))?))
    };
    let mut out = Vec::new();
    let mut done = |i: usize, _: &Made, labels: &[Plane<u8>]| {
        out.push((i, labels[0].clone()));
        Ok(())
    };
    film.label(&(0..frames), &mut fetch, &mut done, &Run::default()).unwrap();
    out
}

/// Links of frames that show all where it was.
fn staying(i: usize, (w, h): (usize, usize)) -> Plane<u32> {
    Plane::from_fn(w, h, |x, y| if i == 0 { UNLINKED } else { (y * w + x) as u32 })
}

/// The most pixels by which a frame of a still film differs from its first; the tone is noise about
/// as coarse as the smallest island, and the picture so large that borders are rounded in parts.
fn stir(seed: u64, plan: Plan) -> usize {
    let (w, h) = (1024, 520);
    let knobs = BinaryKnobs::default();
    let difference = Plane::from_fn(w, h, |x, y| {
        let (u, v) = (x as f32 * 0.07, y as f32 * 0.05);
        let coarse = random::unit(seed, (y / 6 * w + x / 6) as u64) - 0.5;
        0.02 * u.sin() * v.cos() + 0.3 * coarse
    });
    let factors = Plane::from_fn(w, h, |x, y| [if (x + 2 * y) % 17 == 0 { 0.1 } else { 1.0 }; 4]);
    let graph = Graph::new(&Plane::filled(w, h, true), &difference, &factors, &knobs);
    let mut fetch = |i: usize| Ok(Made(Cel::new(graph.clone(), staying(i, (w, h)))?));
    let (mut first, mut most): (Option<Plane<u8>>, usize) = (None, 0);
    let mut done = |_: usize, _: &Made, labels: &[Plane<u8>]| {
        let first = first.get_or_insert_with(|| labels[0].clone());
        let differ = first.pixels().iter().zip(labels[0].pixels()).filter(|(a, b)| a != b);
        most = most.max(differ.count());
        Ok(())
    };
    let mut film: Film<'_, Made> = Film::new(plan, &knobs);
    for start in (0..plan.frames).step_by(BLOCK) {
        film.label(&plan.block(start), &mut fetch, &mut done, &Run::default()).unwrap();
    }
    most
}

#[test]
fn a_film_of_what_stands_still_is_still() {
    assert_eq!(stir(7, Plan { frames: BLOCK + 2, window: 3 }), 0);
}

#[test]
fn the_last_frames_hold_on_less_than_what_is_undone() {
    let middle = (20, 15);
    let undone = glimpse(BLOCK, 11);
    assert!(undone.iter().all(|(_, labels)| labels[middle] == 0));
    let last = glimpse(12, 11);
    assert!(last.iter().all(|(i, labels)| labels[middle] == u8::from(*i == 11)));
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
    let mut toned = cel(frame, knobs);
    let painted = |x: usize| x + 1 == SIZE.0;
    let layer = |step: i32| {
        let graph = &toned.graph;
        let terminal = Plane::from_fn(SIZE.0, SIZE.1, |x, y| {
            let [w, b] = graph.terminal[(x, y)];
            let pull = w - b - step;
            if painted(x) { [60_000, 0] } else { [pull.max(0), (-pull).max(0)] }
        });
        Layer::step(graph, terminal).unwrap()
    };
    toned.layers = vec![layer(-600), layer(600)];
    toned.painted = Some(Plane::from_fn(SIZE.0, SIZE.1, |x, _| painted(x).then_some(true)));
    toned
}

/// A frame in three spot colours whose first column is painted black, the second colour.
fn spotted_cel(frame: usize, knobs: &BinaryKnobs) -> Cel {
    let mut spotted = cel(frame, knobs);
    let graph = &spotted.graph;
    let painted = |i: usize| i.is_multiple_of(SIZE.0);
    let prices = graph.terminal.pixels().iter().enumerate().flat_map(|(i, [white, black])| {
        let pull = white - black;
        let own = [(pull + 900).abs(), pull.abs(), (pull - 900).abs()];
        if painted(i) { [60_000, 0, 60_000] } else { own }
    });
    let layer = Layer::unordered(graph, prices.collect(), 3, [1, 2]).unwrap();
    spotted.layers = vec![layer];
    spotted.painted = Some(Plane::from_fn(SIZE.0, SIZE.1, |x, _| (x == 0).then_some(false)));
    spotted
}

#[test]
fn spots_follow_the_motion_and_paint_stays() {
    let knobs = BinaryKnobs { island: 300.0, ..BinaryKnobs::default() };
    let plan = Plan { frames: BLOCK + 4, window: 5 };
    let mut film: Film<'_, Made> = Film::new(plan, &knobs);
    let mut sums = [Flicker::default(), Flicker::default()];
    let mut seen = [0; 3];
    for block in [plan.block(0), plan.block(BLOCK)] {
        let mut done = |i: usize, made: &Made, layers: &[Plane<u8>]| {
            let (cel, labels) = (&made.0, &layers[0]);
            let (alone, energy) = cel.own(0);
            assert_eq!(cel.energy(0, alone), energy);
            for (sum, labels) in sums.iter_mut().zip([labels, alone]) {
                sum.add(
                    i,
                    &Shown {
                        labels,
                        covered: &cel.graph.mask,
                        links: &cel.links,
                        alone,
                        tone: &cel.wanted(0),
                        energy: [cel.energy(0, labels), energy],
                    },
                );
            }
            for (p, label) in labels.pixels().iter().enumerate() {
                if cel.graph.mask.pixels()[p] {
                    seen[usize::from(*label)] += 1;
                    assert!(!p.is_multiple_of(SIZE.0) || *label == 1, "paint is gone");
                }
            }
            Ok(())
        };
        let mut fetch = |i| Ok(Made(spotted_cel(i, &knobs)));
        film.label(&block, &mut fetch, &mut done, &Run::default()).unwrap();
    }
    assert!(seen.iter().all(|n| *n > 100), "{seen:?}");
    let [film, alone] = sums;
    assert!(2 * film.reversals < alone.reversals, "{} {}", film.reversals, alone.reversals);
}

#[test]
fn tones_are_nested_and_paint_stays() {
    let knobs = BinaryKnobs::default();
    let plan = Plan { frames: BLOCK + 4, window: 5 };
    let mut film: Film<'_, Made> = Film::new(plan, &knobs);
    let palette = Palette::Tones(vec![[0.0; 3], [0.5; 3], [1.0; 3]]);
    let mut levels = [0; 3];
    for block in [plan.block(0), plan.block(BLOCK)] {
        let mut done = |_: usize, made: &Made, steps: &[Plane<u8>]| {
            let mask = &made.0.graph.mask;
            let tones = coloured(steps, &made.0, &palette, &knobs).labels;
            for (i, tone) in tones.pixels().iter().enumerate().filter(|(i, _)| mask.pixels()[*i]) {
                levels[usize::from(*tone)] += 1;
                let [dark, light] = [0, 1].map(|step| steps[step].pixels()[i] == 1);
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
