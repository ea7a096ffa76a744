//! Terminal weights W and B, (3.1) to (3.5).
//!
//! `W` is paid where a pixel ends black, `B` where it ends white; what is stored is their
//! difference, since adding the same to both changes no cut.

use crate::appearance::{Channel, Channels};
use crate::exposure::{Exposure, local_contrast, local_mean, mixed_tone};
use crate::flat::Flats;
use crate::knob::{BinaryKnobs, Model};
use crate::patch;
use crate::shade::View;
use chiaro_image::{Plane, Runs};
use chiaro_trace::GBuffer;

/// W - B per covered pixel; positive pulls to white.
pub fn terminal(view: &View, exposure: &Exposure, knobs: &BinaryKnobs) -> Plane<f32> {
    let (channels, covered) = (&view.channels, &view.buffer.covered);
    match knobs.model {
        Model::Tone => {
            from_tone(mixed_tone(channels, covered, knobs), &view.buffer, exposure, knobs)
        }
        Model::Thesis => {
            let shift = exposure.threshold - Exposure::default().threshold;
            let sum = from_channels(channels, covered, knobs);
            if shift == 0.0 { sum } else { sum.map(|d| d - shift) }
        }
    }
}

/// g (T - t) + (1 - g) clamp(A' / (4 rms A'), -1/2, 1/2) of the mixed tone, with T after levels.
fn from_tone(
    mut tone: Plane<f32>,
    buffer: &GBuffer,
    exposure: &Exposure,
    knobs: &BinaryKnobs,
) -> Plane<f32> {
    let covered = &buffer.covered;
    let (runs, g, threshold) = (Runs::of(covered), knobs.global, exposure.threshold);
    runs.change(&mut tone, |_, _, tone| tone.iter_mut().for_each(|t| *t = exposure.stretch(*t)));
    let flats = Flats::of(buffer);
    let mut difference = tone.clone();
    if g >= 1.0 {
        runs.change(&mut difference, |_, _, d| d.iter_mut().for_each(|d| *d -= threshold));
    } else {
        let mean = local_mean(&tone, covered, knobs.local_radius);
        let scale = 0.25 / exposure.contrast;
        runs.change(&mut difference, |y, run, d| {
            for (d, mean) in d.iter_mut().zip(&mean.row(y)[run]) {
                let local = (scale * (*d - mean)).clamp(-0.5, 0.5);
                *d = g * (*d - threshold) + (1.0 - g) * local;
            }
        });
    }
    flats.even(&mut difference, &tone);
    patch::decide(&flats, &mut difference, &tone, g);
    difference
}

/// The thesis's sum: sum of w_i W_i - b_i B_i with W_i and B_i of (3.5). Its small constant that
/// keeps both positive cancels here.
fn from_channels(channels: &Channels, covered: &Plane<bool>, knobs: &BinaryKnobs) -> Plane<f32> {
    let (w, h) = covered.size();
    let mut sum = Plane::filled(w, h, 0.0);
    for channel in Channel::ALL {
        let (Some(weights), Some(plane)) = (channel.thesis(knobs), channels.get(channel)) else {
            continue;
        };
        let part = channel_difference(plane, covered, weights);
        sum = sum.zip(&part, |a, b| a + b).expect("channels have the picture's size");
    }
    sum
}

fn channel_difference(
    plane: &Plane<f32>,
    covered: &Plane<bool>,
    [w, b, g, h]: [f32; 4],
) -> Plane<f32> {
    let (white, black) = (|a: f32| g * a, |a: f32| g * (1.0 - a));
    if g >= 1.0 {
        return plane.map(|&a| w * white(a) - b * black(a));
    }
    let local = local_contrast(plane, covered, h);
    plane
        .zip(&local, |&a, &d| {
            let to_white = white(a) + (1.0 - g) * d.max(0.0);
            let to_black = black(a) + (1.0 - g) * (-d).max(0.0);
            w * to_white - b * to_black
        })
        .expect("a filter keeps the size")
}
