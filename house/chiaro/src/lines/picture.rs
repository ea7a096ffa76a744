//! Lines as pixels.

use super::Shot;
use super::beneath::Beneath;
use super::ready::{Drawn, ready};
use super::style::LineStyle;
use crate::colours::Colours;
use chiaro_image::Plane;
use chiaro_image::colour::to_byte;
use chiaro_ink::Polyline;
use chiaro_ink::brush::{Stroke as Inked, paint};
use chiaro_lines::{FilmFrame, Stroke};

/// A frame of a shot in ink over its background, or over a picture, sRGB-encoded.
pub(crate) fn picture(
    shot: &Shot,
    number: u32,
    style: &LineStyle,
    colours: &Colours,
    beneath: Option<Beneath>,
) -> Plane<[u8; 4]> {
    let (w, h) = shot.camera.size;
    let beneath = match beneath {
        Some(Beneath::Pixels(pixels)) => pixels,
        _ => Plane::filled(w, h, colours.background),
    };
    let drawn = ready(shot, frame(shot, number), style, colours);
    let strokes: Vec<Inked<'_>> = drawn.iter().map(|d: &Drawn<'_>| d.inked(style)).collect();
    paint(&strokes, &beneath, colours.paper).map(|p| p.map(to_byte))
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
