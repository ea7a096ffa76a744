//! Lines as pixels.

use super::Shot;
use crate::binary::Colours;
use chiaro_image::Plane;
use chiaro_image::colour::to_byte;
use chiaro_ink::{Polyline, draw};
use chiaro_lines::{FilmFrame, LinesKnobs, Stroke};

/// A frame of a shot in ink over its background, sRGB-encoded.
pub(super) fn picture(
    shot: &Shot,
    number: u32,
    knobs: &LinesKnobs,
    colours: &Colours,
) -> Plane<[u8; 4]> {
    let frame = frame(shot, number);
    let lines: Vec<Polyline> = frame.strokes.iter().map(polyline).collect();
    let cover = draw(&lines, shot.camera.size, knobs.width);
    cover.map(|c| over(colours, *c))
}

/// The frame with a number.
pub(super) fn frame(shot: &Shot, number: u32) -> &FilmFrame {
    let index = shot.numbers.iter().position(|n| *n == number);
    &shot.film.frames[index.expect("frames are part of the shot")]
}

/// A stroke's line in the picture.
pub(super) fn polyline(stroke: &Stroke) -> Polyline {
    let points = stroke.samples.iter().map(|s| s.at.as_vec2().to_array()).collect();
    Polyline { points, closed: stroke.closed }
}

fn over(colours: &Colours, cover: f32) -> [u8; 4] {
    let (ink, back) = (colours.ink, colours.background);
    let share = cover * ink[3];
    let alpha = share + back[3] * (1.0 - share);
    let channel =
        |i: usize| to_byte((ink[i] * share + back[i] * back[3] * (1.0 - share)) / alpha.max(1e-6));
    [channel(0), channel(1), channel(2), to_byte(alpha)]
}
