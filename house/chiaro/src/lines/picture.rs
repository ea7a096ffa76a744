//! Lines as pixels.

use super::Shot;
use crate::colours::Colours;
use chiaro_image::Plane;
use chiaro_image::colour::to_byte;
use chiaro_ink::{Polyline, draw};
use chiaro_lines::{FilmFrame, LineColour, LinesKnobs, Stroke};

/// A frame of a shot in ink over its background, sRGB-encoded.
pub(super) fn picture(
    shot: &Shot,
    number: u32,
    knobs: &LinesKnobs,
    colours: &Colours,
) -> Plane<[u8; 4]> {
    let frame = frame(shot, number);
    if knobs.colour == LineColour::Id {
        return by_id(frame, shot.camera.size, knobs, colours);
    }
    let mut lines: Vec<Polyline> = frame.strokes.iter().map(polyline).collect();
    lines.extend(frame.hidden.iter().flat_map(|s| dashes(s, knobs.dash)));
    let cover = draw(&lines, shot.camera.size, knobs.width);
    cover.map(|c| over(colours, *c))
}

/// Every stroke in the colour of its id, over the background.
fn by_id(
    frame: &FilmFrame,
    size: (usize, usize),
    knobs: &LinesKnobs,
    colours: &Colours,
) -> Plane<[u8; 4]> {
    let mut plane = Plane::filled(size.0, size.1, over(colours, 0.0));
    let hidden =
        frame.hidden.iter().flat_map(|s| dashes(s, knobs.dash).into_iter().map(|d| (s.id, d)));
    for (id, line) in hidden.chain(frame.strokes.iter().map(|s| (s.id, polyline(s)))) {
        let [r, g, b] = id_colour(id);
        let ink = [r, g, b, 1.0];
        let cover = draw(&[line], size, knobs.width);
        let put = |p: &[u8; 4], c: &f32| {
            let back = p.map(|v| f32::from(v) / 255.0);
            if *c > 0.0 { over(&Colours { ink, background: back, ..*colours }, *c) } else { *p }
        };
        plane = plane.zip(&cover, put).expect("both have the picture's size");
    }
    plane
}

/// A colour of its own for an id: hues a golden angle apart.
pub(crate) fn id_colour(id: u32) -> [f32; 3] {
    let hue = 6.0 * (0.618_034 * id as f32 + 0.6).fract();
    let value = [0.82, 0.62, 0.48][id as usize % 3];
    let ramp = |shift: f32| ((hue + shift).rem_euclid(6.0) - 3.0).abs() - 1.0;
    [ramp(0.0), ramp(4.0), ramp(2.0)].map(|x| value * x.clamp(0.0, 1.0))
}

/// The frame with a number.
pub(super) fn frame(shot: &Shot, number: u32) -> &FilmFrame {
    let index = shot.numbers.iter().position(|n| *n == number);
    &shot.film.frames[index.expect("frames are part of the shot")]
}

/// A stroke's line in the picture.
pub(crate) fn polyline(stroke: &Stroke) -> Polyline {
    let points = stroke.samples.iter().map(|s| s.at.as_vec2().to_array()).collect();
    Polyline { points, closed: stroke.closed }
}

/// A stroke's dashes: as long as the gaps between them.
pub(super) fn dashes(stroke: &Stroke, dash: f32) -> Vec<Polyline> {
    let dash = f64::from(dash);
    let mut points: Vec<[f32; 2]> = polyline(stroke).points;
    if let (true, Some(first)) = (stroke.closed, points.first().copied()) {
        points.push(first);
    }
    let mut dashes = Vec::new();
    let mut start = 0.0;
    while start < stroke.total() {
        let end = (start + dash).min(stroke.total());
        let inner =
            (0..points.len()).filter(|&i| stroke.length[i] > start && stroke.length[i] < end);
        let mut line = vec![along(stroke, &points, start)];
        line.extend(inner.map(|i| points[i]));
        line.push(along(stroke, &points, end));
        dashes.push(Polyline { points: line, closed: false });
        start += 2.0 * dash;
    }
    dashes
}

/// The point at a length along a stroke.
fn along(stroke: &Stroke, points: &[[f32; 2]], length: f64) -> [f32; 2] {
    let i = stroke.length.partition_point(|l| *l <= length).clamp(1, points.len() - 1);
    let (from, to) = (stroke.length[i - 1], stroke.length[i]);
    let t = if to > from { ((length - from) / (to - from)).clamp(0.0, 1.0) as f32 } else { 0.0 };
    std::array::from_fn(|k| points[i - 1][k] + (points[i][k] - points[i - 1][k]) * t)
}

fn over(colours: &Colours, cover: f32) -> [u8; 4] {
    let (ink, back) = (colours.ink, colours.background);
    let share = cover * ink[3];
    let alpha = share + back[3] * (1.0 - share);
    let channel =
        |i: usize| to_byte((ink[i] * share + back[i] * back[3] * (1.0 - share)) / alpha.max(1e-6));
    [channel(0), channel(1), channel(2), to_byte(alpha)]
}
