//! Figures 4.6 to 4.9: textures on lines through time, drawn plainly as dashes at whole multiples of u.

use super::Figure;
use super::chapter4::{BLACK, Canvas, GREY, RED, shot};
use crate::lines::{Shot, picture};
use chiaro_basis::math::DVec2;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_image::sheet::Sheet;
use chiaro_ink::Polyline;
use chiaro_lines::{Cuts, FilmFrame, LinesKnobs, Method, Stroke, Texture, quality};

const SIZE: (usize, usize) = (440, 330);

pub(super) const FIGURES: [Figure; 4] = [
    Figure {
        name: "4.6",
        title: "two kinds of texture",
        message: "A line of a turning torus in five frames. Above, a texture that stretches to cover its \
                  line, in ten parts; below, one that repeats.",
        columns: 5,
        draw: kinds,
    },
    Figure {
        name: "4.7",
        title: "from spatial to temporal coherence",
        message: "Coherence 0, 0.5 and 1 in four frames. Red: where the dashes' ends of the first frame \
                  have been carried by the surface.",
        columns: 4,
        draw: control,
    },
    Figure {
        name: "4.8",
        title: "cuts",
        message: "The outlines of a film stacked in time, a colour a chart. Cut at every merger and split \
                  to the end of the line's life; paired within the sliding limit; cut where links \
                  contradict each other; and split from frame to frame.",
        columns: 2,
        draw: cuts,
    },
    Figure {
        name: "4.9",
        title: "peanut, multipod, torus",
        message: "Every fourth frame of three films, dashes at whole multiples of u.",
        columns: 6,
        draw: solids,
    },
];

/// The parts of a stroke on which u, counted in units of `unit`, is less than `share` past a whole
/// number.
pub(super) fn dashes(stroke: &Stroke, unit: f64, share: f64) -> Vec<Polyline> {
    let n = stroke.samples.len();
    let mut dashes: Vec<Vec<DVec2>> = Vec::new();
    for (k, u) in stroke.u.windows(2).enumerate() {
        let (a, b) = (stroke.samples[k].at, stroke.samples[(k + 1) % n].at);
        let (u0, u1) = (u[0] / unit, u[1] / unit);
        if u1 <= u0 || u1 - u0 > 50.0 {
            continue;
        }
        let mut whole = u0.floor();
        while whole < u1 {
            let (from, to) = (whole.max(u0), (whole + share).min(u1));
            if from < to {
                let at = |u: f64| a.lerp(b, (u - u0) / (u1 - u0));
                let (p, q) = (at(from), at(to));
                match dashes.last_mut() {
                    Some(dash) if from == u0 && dash[dash.len() - 1].distance(p) < 1e-3 => {
                        dash.push(q);
                    }
                    _ => dashes.push(vec![p, q]),
                }
            }
            whole += 1.0;
        }
    }
    let line = |points: Vec<DVec2>| Polyline {
        points: points.iter().map(|p| p.as_vec2().to_array()).collect(),
        closed: false,
    };
    dashes.into_iter().map(line).collect()
}

/// A frame: dashes of the seen lines over a thin line.
pub(super) fn dashed(frame: &FilmFrame, size: (usize, usize)) -> Canvas {
    let mut canvas = Canvas::new(size);
    let thin: Vec<Polyline> = frame.strokes.iter().map(picture::polyline).collect();
    canvas.lines(&thin, 0.8, GREY);
    let marks: Vec<Polyline> = frame.strokes.iter().flat_map(|s| dashes(s, 1.0, 0.55)).collect();
    canvas.lines(&marks, 2.6, BLACK);
    canvas
}

fn kinds(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for (texture, unit) in [(Texture::Stretched, 0.1), (Texture::Periodic, 1.0)] {
        let knobs = LinesKnobs { texture, ..LinesKnobs::default() };
        let shot = shot("bumpy-torus", 25, SIZE, &knobs, run)?;
        for (i, frame) in shot.film.frames.iter().enumerate().step_by(6) {
            let mut canvas = Canvas::new(SIZE);
            for stroke in &frame.strokes {
                canvas.lines(&dashes(stroke, unit, 0.5), 3.0, picture::id_colour(stroke.id));
                canvas.lines(&[picture::polyline(stroke)], 0.8, BLACK);
            }
            let word = if texture == Texture::Stretched { "stretched" } else { "repeated" };
            sheet.add(canvas.done(), format!("{word}, frame {}", i + 1));
        }
    }
    Ok(())
}

fn control(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for coherence in [0.0, 0.5, 1.0] {
        let knobs = LinesKnobs { coherence, ..LinesKnobs::default() };
        let shot = shot("bumpy-torus", 13, SIZE, &knobs, run)?;
        let q = quality(&shot.film);
        for (i, frame) in shot.film.frames.iter().enumerate().step_by(4) {
            let mut canvas = dashed(frame, SIZE);
            if let Some(before) = i.checked_sub(1).map(|i| &shot.film.frames[i]) {
                canvas.lines(&carried(before), 1.2, RED);
            }
            let caption = format!(
                "coherence {coherence}, frame {}: slide {:.2} px, stretch {:.2} octaves",
                i + 1,
                q.slide_p95,
                q.stretch_p95
            );
            sheet.add(canvas.done(), caption);
        }
    }
    Ok(())
}

/// Short bars where whole multiples of u of a frame are one frame later.
fn carried(frame: &FilmFrame) -> Vec<Polyline> {
    let mut bars = Vec::new();
    for s in &frame.strokes {
        for (k, u) in s.u.windows(2).enumerate().take(s.samples.len().saturating_sub(1)) {
            let whole = u[1].floor();
            if whole <= u[0] {
                continue;
            }
            let t = (whole - u[0]) / (u[1] - u[0]);
            let (a, b) = (&s.samples[k], &s.samples[k + 1]);
            let Some((p, q)) = a.next_at.zip(b.next_at) else { continue };
            let (at, side) = (p.lerp(q, t), (q - p).perp().normalize_or_zero() * 5.0);
            let points = [at - side, at + side].map(|p| p.as_vec2().to_array()).to_vec();
            bars.push(Polyline { points, closed: false });
        }
    }
    bars
}

fn cuts(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let ways = [
        (Cuts::Unpaired, Method::Global, "at every event"),
        (Cuts::Events, Method::Global, "paired"),
        (Cuts::Charts, Method::Global, "at contradictions"),
        (Cuts::Charts, Method::Propagate, "from frame to frame"),
    ];
    for (cuts, method, name) in ways {
        let knobs = LinesKnobs { cuts, method, ..LinesKnobs::default() };
        let shot = shot("multipod", 48, (360, 270), &knobs, run)?;
        let m = chiaro_lines::measure(&shot.film);
        let solved = &shot.solved;
        let caption = match solved.saved {
            Some(saved) => format!(
                "{name}: {} charts of {:.1} strokes, {:.1} strokes a frame; {} events, {} pairs, {} places cut",
                solved.charts,
                solved.lines as f64 / solved.charts.max(1) as f64,
                m.strokes_per_frame,
                saved.events[0] + saved.events[1],
                saved.paired,
                saved.cut_places
            ),
            None => format!(
                "{name}: {} ids of {:.1} frames, {:.1} strokes a frame",
                m.strokes, m.mean_life_frames, m.strokes_per_frame
            ),
        };
        sheet.add(stacked(&shot), caption);
    }
    Ok(())
}

/// The seen lines of a film, later frames further up and right, a colour an id.
fn stacked(shot: &Shot) -> Plane<[u8; 3]> {
    let mut canvas = Canvas::new((720, 480));
    let last = (shot.film.frames.len().max(2) - 1) as f64;
    for (i, frame) in shot.film.frames.iter().enumerate().rev() {
        let t = i as f64 / last;
        for stroke in &frame.strokes {
            let place = |s: &chiaro_lines::Sample| {
                let at =
                    DVec2::new(10.0 + 0.95 * s.at.x + 340.0 * t, 215.0 + 0.95 * s.at.y - 200.0 * t);
                at.as_vec2().to_array()
            };
            let points = stroke.samples.iter().map(place).collect();
            let line = Polyline { points, closed: stroke.closed };
            canvas.lines(&[line], 1.2, picture::id_colour(stroke.id));
        }
    }
    canvas.done()
}

fn solids(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for name in ["peanut", "multipod", "torus"] {
        let shot = shot(name, 24, (360, 300), &LinesKnobs::default(), run)?;
        let q = quality(&shot.film);
        for (i, frame) in shot.film.frames.iter().enumerate().step_by(4) {
            let caption = match i {
                0 => format!(
                    "{name}: slide {:.2} px, stretch {:.2} octaves",
                    q.slide_p95, q.stretch_p95
                ),
                _ => format!("frame {}", i + 1),
            };
            sheet.add(dashed(frame, (360, 300)).done(), caption);
        }
    }
    Ok(())
}
