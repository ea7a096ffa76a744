//! Figures 4.3, 4.events and 4.ids: the surface that lines sweep, the lives of its lines, and their ids.

use super::Figure;
use super::chapter4::{BLACK, Canvas, GREY, OBJECT, RED, mark, shot};
use crate::lines::picture;
use chiaro_basis::math::DVec2;
use chiaro_basis::{Result, Run};
use chiaro_image::sheet::Sheet;
use chiaro_ink::Polyline;
use chiaro_lines::track::EventKind;
use chiaro_lines::{Film, LinesKnobs};
use std::collections::BTreeMap;

pub(super) const FIGURES: [Figure; 3] = [
    Figure {
        name: "4.3",
        title: "principle",
        message: "The lines of a film sweep a surface; red: points of it that belong together in time, \
                  each the partner of the one before.",
        columns: 2,
        draw: principle,
    },
    Figure {
        name: "4.events",
        title: "lives of lines",
        message: "A bar is a chain of silhouettes from its first frame to its last, the thicker the \
                  longer; rings: births, dots: deaths, crosses: saddles, where bars meet and part.",
        columns: 2,
        draw: lives,
    },
    Figure {
        name: "4.ids",
        title: "one colour an id",
        message: "Every fourth frame of a film: a line has its colour for as long as it is followed, \
                  also where it merges with another or is hidden for a while. The film: chiaro lines \
                  demo:bumpy-torus --frames 1-48 --set colour=id -o ids.gif.",
        columns: 4,
        draw: ids,
    },
];

const FRAMES: u32 = 36;
const CANVAS: (usize, usize) = (720, 480);

/// A picture position at a time, seen askew: later is further to the upper right.
fn askew(p: DVec2, time: f64) -> [f32; 2] {
    let t = time / f64::from(FRAMES - 1);
    let at = DVec2::new(10.0 + 0.9 * p.x + 370.0 * t, 215.0 + 0.9 * p.y - 200.0 * t);
    at.as_vec2().to_array()
}

fn principle(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for scene in [OBJECT, "peanut"] {
        let shot = shot(scene, FRAMES, (360, 270), &LinesKnobs::default(), run)?;
        let film = &shot.film;
        let mut canvas = Canvas::new(CANVAS);
        canvas.lines(&trails(film), 0.8, RED);
        for (i, frame) in film.frames.iter().enumerate().rev().filter(|(i, _)| i % 7 == 0) {
            let slice: Vec<Polyline> = frame
                .strokes
                .iter()
                .map(|s| Polyline {
                    points: s.samples.iter().map(|p| askew(p.at, i as f64)).collect(),
                    closed: s.closed,
                })
                .collect();
            canvas.lines(&slice, 1.6, if i == 0 { BLACK } else { GREY });
        }
        sheet.add(canvas.done(), format!("{scene}, every seventh of {FRAMES} frames"));
    }
    Ok(())
}

fn ids(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let size = (300, 225);
    let shot = shot(OBJECT, 48, size, &LinesKnobs::default(), run)?;
    for (i, frame) in shot.film.frames.iter().enumerate().step_by(4) {
        let mut canvas = Canvas::new(size);
        for stroke in &frame.strokes {
            canvas.lines(&[picture::polyline(stroke)], 2.0, picture::id_colour(stroke.id));
        }
        sheet.add(canvas.done(), format!("{OBJECT}, frame {}", i + 1));
    }
    Ok(())
}

/// Lines through time: from every few samples of the first frame from partner to partner, as long as
/// there is one; begun anew every twelfth frame.
fn trails(film: &Film) -> Vec<Polyline> {
    let partners: Vec<_> = (0..film.frames.len()).map(|i| film.partners(i)).collect();
    let mut trails = Vec::new();
    for start in (0..film.frames.len()).step_by(12) {
        for (s, stroke) in film.frames[start].strokes.iter().enumerate() {
            for k in (0..stroke.samples.len()).step_by(6) {
                let points = trail(film, &partners, (start, s, k));
                if points.len() > 1 {
                    trails.push(Polyline { points, closed: false });
                }
            }
        }
    }
    trails
}

fn trail(
    film: &Film,
    partners: &[Vec<Vec<Option<chiaro_lines::Partner>>>],
    (start, mut stroke, mut sample): (usize, usize, usize),
) -> Vec<[f32; 2]> {
    let mut points =
        vec![askew(film.frames[start].strokes[stroke].samples[sample].at, start as f64)];
    let later = partners.iter().zip(&film.frames[1..]).enumerate();
    for (frame, (partners, next)) in later.skip(start).take(12) {
        let Some(p) = partners[stroke][sample] else { break };
        let next = &next.strokes[p.stroke as usize].samples;
        let (a, b) = (p.segment as usize, (p.segment as usize + 1) % next.len());
        points.push(askew(next[a].at.lerp(next[b].at, p.share), (frame + 1) as f64));
        (stroke, sample) = (p.stroke as usize, if p.share < 0.5 { a } else { b });
    }
    points
}

fn lives(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for scene in [OBJECT, "multipod"] {
        let shot = shot(scene, FRAMES, (360, 270), &LinesKnobs::default(), run)?;
        let mut canvas = Canvas::new(CANVAS);
        let rows = rows(&shot.film);
        let place = |label: u32, time: f64| {
            let step = (CANVAS.1 as f64 - 40.0) / rows.len().max(1) as f64;
            let row = rows.keys().position(|l| *l == label).unwrap_or(0) as f64;
            let x = 20.0 + (CANVAS.0 as f64 - 40.0) * time / f64::from(FRAMES - 1);
            DVec2::new(x, 20.0 + (row + 0.5) * step)
        };
        let line = |a: DVec2, b: DVec2| Polyline {
            points: vec![a.as_vec2().to_array(), b.as_vec2().to_array()],
            closed: false,
        };
        for (label, life) in &rows {
            let width = (life.longest.max(1.0).log2() * 0.8).clamp(0.8, 7.0) as f32;
            let bar = line(place(*label, life.first), place(*label, life.last));
            canvas.lines(&[bar], width, picture::id_colour(*label));
        }
        for event in &shot.film.events {
            let known = |l: &&u32| rows.contains_key(l);
            let met: Vec<u32> = event.labels.iter().flatten().filter(known).copied().collect();
            let Some(first) = met.first() else { continue };
            let to_others =
                met[1..].iter().map(|l| line(place(*first, event.time), place(*l, event.time)));
            canvas.lines(&to_others.collect::<Vec<_>>(), 0.8, GREY);
            canvas.lines(&mark(event.kind, place(*first, event.time), 3.5), 1.2, BLACK);
        }
        let saddles = shot.film.events.iter().filter(|e| e.kind == EventKind::Saddle).count();
        sheet.add(canvas.done(), format!("{scene}: {} chains, {saddles} saddles", rows.len()));
    }
    Ok(())
}

/// The life of a chain.
struct Life {
    first: f64,
    last: f64,
    /// Crossings when it is longest.
    longest: f64,
}

/// Chains that live for at least two frames, by label.
fn rows(film: &Film) -> BTreeMap<u32, Life> {
    let mut rows: BTreeMap<u32, Life> = BTreeMap::new();
    for (i, frame) in film.frames.iter().enumerate() {
        for (label, chain) in frame.labels.iter().zip(&frame.slice.chains) {
            let time = i as f64;
            let life = rows.entry(*label).or_insert(Life { first: time, last: time, longest: 0.0 });
            life.last = time;
            life.longest = life.longest.max(f64::from(chain.count));
        }
    }
    rows.retain(|_, life| life.last > life.first);
    rows
}
