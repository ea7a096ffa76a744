//! Figures 4.13 to 4.15: parameters that diffuse from frame to frame.

use super::Figure;
use super::chapter4::{BLACK, Canvas, Colour, GREY, RED, shot};
use super::chart::{Axis, Chart, Scale, Series};
use super::strokes::dashed;
use crate::lines::{Shot, picture};
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_image::sheet::Sheet;
use chiaro_ink::Polyline;
use chiaro_lines::parameter::{Diffused, Diffuser};
use chiaro_lines::{LinesKnobs, Method, Stroke};

const SIZE: (usize, usize) = (440, 330);
const BLUE: Colour = [0.1, 0.3, 0.8];
const GREEN: Colour = [0.1, 0.55, 0.2];
const PATTERN: f64 = 24.0;

pub(super) const FIGURES: [Figure; 3] = [
    Figure {
        name: "4.13",
        title: "diffusion",
        message: "Samples of a line in grey, of the frame after it in black. Red: the samples that speak \
                  for six of the new ones, as thick as they count.",
        columns: 1,
        draw: weights,
    },
    Figure {
        name: "4.14",
        title: "variance",
        message: "Along the longest line of a frame: u as it is made of what is diffused and of an even spread, how far it \
                  is from what is diffused, the standard deviation of that, and how much an even spread counts; each as a \
                  share of its range.",
        columns: 2,
        draw: variance,
    },
    Figure {
        name: "4.15",
        title: "an event",
        message: "u along the longest line in four frames around a change of its course, and the frames. \
                  Where it falls, a texture would run backwards.",
        columns: 4,
        draw: event,
    },
];

fn still(frames: u32, run: &Run) -> Result<Shot> {
    let knobs = LinesKnobs { method: Method::Arclength, ..LinesKnobs::default() };
    shot("bumpy-torus", frames, SIZE, &knobs, run)
}

fn weights(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let shot = still(4, run)?;
    let mut diffuser = Diffuser::default();
    let [before, after] = [&shot.film.frames[0], &shot.film.frames[3]];
    diffuser.advance(&mut before.strokes.clone(), &before.view, PATTERN);
    let Some(stroke) = longest(&after.strokes) else { return Ok(()) };
    // A close look at the middle of the line.
    let middle = stroke.samples[stroke.samples.len() / 2].at;
    let zoom = |p: chiaro_basis::math::DVec2| ((p - middle) * 9.0 + 350.0).as_vec2().to_array();
    let dot = |p: [f32; 2]| Polyline { points: vec![p, [p[0] + 0.01, p[1]]], closed: false };
    let mut canvas = Canvas::new((700, 700));
    let all = |strokes: &[Stroke]| -> Vec<Polyline> {
        strokes.iter().flat_map(|s| &s.samples).map(|p| dot(zoom(p.at))).collect()
    };
    let moved =
        before.strokes.iter().flat_map(|s| &s.samples).filter_map(|s| {
            after.view.see(s.next_world.unwrap_or(s.world)).map(|p| dot(zoom(p.at)))
        });
    canvas.lines(&moved.collect::<Vec<_>>(), 5.0, GREY);
    for j in (0..stroke.samples.len()).skip(stroke.samples.len() / 2 - 9).step_by(3).take(6) {
        for (at, weight) in diffuser.weights(stroke, j, &after.view) {
            let line = vec![zoom(stroke.samples[j].at), zoom(at)];
            let width = 5.0 * weight as f32;
            if width > 0.2 {
                canvas.lines(&[Polyline { points: line, closed: false }], width, RED);
            }
        }
    }
    canvas.lines(&all(&after.strokes), 5.0, BLACK);
    sheet.add(canvas.done(), "nine times enlarged");
    Ok(())
}

fn longest(strokes: &[Stroke]) -> Option<&Stroke> {
    strokes.iter().max_by(|a, b| a.total().total_cmp(&b.total()))
}

/// The frames of a film, diffused, with what was diffused to the longest line of each.
fn diffused(shot: &mut Shot) -> Vec<(Stroke, Vec<Diffused>)> {
    let mut diffuser = Diffuser::default();
    let mut all = Vec::new();
    for frame in &mut shot.film.frames {
        let told = diffuser.advance(&mut frame.strokes, &frame.view, PATTERN);
        let pairs = frame.strokes.iter().zip(told);
        if let Some((s, t)) = pairs.max_by(|a, b| a.0.total().total_cmp(&b.0.total())) {
            all.push((s.clone(), t));
        }
    }
    all
}

fn variance(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let mut shot = still(24, run)?;
    let all = diffused(&mut shot);
    let spread = |told: &[Diffused]| told.iter().map(|d| d.variance).fold(0.0, f64::max);
    let mut order: Vec<usize> = (1..all.len()).collect();
    order.sort_by(|a, b| spread(&all[*b].1).total_cmp(&spread(&all[*a].1)).then(a.cmp(b)));
    for i in order.into_iter().take(2) {
        let (stroke, told) = &all[i];
        let u: Vec<f64> = stroke.u.iter().map(|u| u * stroke.pixels_per_u).collect();
        let deviation: Vec<f64> = told.iter().map(|d| d.variance.sqrt()).collect();
        let trust: Vec<f64> = told.iter().map(Diffused::trust).collect();
        let moved = |(u, d): (&f64, &Diffused)| {
            let off = u - d.mean;
            (off - d.period.map_or(0.0, |p| p * (off / p).round())).abs()
        };
        let moved: Vec<f64> = u.iter().zip(told).map(moved).collect();
        let (own, worst) = (range(&u), spread(told).sqrt());
        let ([low, high], most) = (own, range(&moved)[1]);
        let series = vec![
            curve(
                stroke,
                &moved,
                [0.0, most],
                (GREEN, format!("from the diffused: to {most:.0} px")),
            ),
            curve(stroke, &u, own, (BLACK, format!("u: {low:.0} to {high:.0} px"))),
            curve(stroke, &deviation, [0.0, worst], (BLUE, format!("deviation: to {worst:.0} px"))),
            curve(stroke, &trust, [0.0, 1.0], (RED, "weight of an even spread".into())),
        ];
        sheet.add(chart("share of its range", series), format!("frame {}", i + 1));
    }
    Ok(())
}

fn range(values: &[f64]) -> [f64; 2] {
    let all = || values.iter().copied();
    [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)]
}

/// Values at the samples of a stroke, as shares of a range.
fn curve(
    stroke: &Stroke,
    values: &[f64],
    [low, high]: [f64; 2],
    (colour, name): (Colour, String),
) -> Series {
    let share = |v: &f64| (v - low) / (high - low).max(1e-9);
    let points = stroke.length.iter().zip(values).map(|(l, v)| [*l, share(v)]).collect();
    Series { name, colour, points, joined: true }
}

fn chart(y: &'static str, series: Vec<Series>) -> Plane<[u8; 3]> {
    let axis = |name| Axis { name, scale: Scale::Linear };
    Chart { x: axis("along the line, pixels"), y: axis(y), series }.draw((640, 420))
}

fn event(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let mut shot = still(48, run)?;
    let all = diffused(&mut shot);
    // The longest line's length changes most where its course does.
    let change = |i: &usize| (all[*i].0.total() - all[i - 1].0.total()).abs();
    let Some(at) = (2..all.len() - 1).max_by(|a, b| change(a).total_cmp(&change(b))) else {
        return Ok(());
    };
    let shown = [at - 2, at - 1, at, at + 1];
    for i in shown {
        let stroke = &all[i].0;
        let folds = stroke.u.windows(2).filter(|u| u[1] <= u[0]).count();
        let u: Vec<f64> = stroke.u.iter().map(|u| u * stroke.pixels_per_u).collect();
        let series = vec![curve(stroke, &u, [0.0, 1.0], (BLACK, "u".into()))];
        sheet.add(chart("u, pixels", series), format!("frame {}: u, {folds} folds", i + 1));
    }
    for i in shown {
        let mut canvas = dashed(&shot.film.frames[i], SIZE);
        canvas.lines(&[picture::polyline(&all[i].0)], 0.8, RED);
        sheet.add(canvas.done(), format!("frame {}", i + 1));
    }
    Ok(())
}
