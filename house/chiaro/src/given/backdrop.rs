//! The plain backdrop of a photograph that brings no mask: things on a white table, a bust before black.
//!
//! 1. The backdrop's colour is the median of the picture's frame, if most of the frame is like it.
//! 2. The backdrop is what is like it and connected to the frame. It must be a good part of the
//!    picture, and not all of it.
//!
//! Left out, it is paper, and light and shade are divided over the things themselves. Where nothing
//! but colours is known, dark backdrops stay: they may be the night.

use chiaro_image::Plane;
use chiaro_image::colour::srgb_encode;

/// Difference of displayed colour, at most, of what is like the backdrop.
const ALIKE: f32 = 0.12;
/// Share of the frame that is like the backdrop, at least.
const OF_FRAME: f32 = 0.7;
/// Share of the picture that the backdrop takes, at least and at most.
const OF_PICTURE: [f32; 2] = [0.15, 0.98];
/// Displayed brightness from which a backdrop is paper.
const LIGHT: f32 = 0.6;

/// Where a picture in linear colour, opaque throughout, shows a plain backdrop.
pub(super) fn backdrop(colour: &Plane<[f32; 4]>, dark_too: bool) -> Option<Plane<bool>> {
    if colour.is_empty() || colour.pixels().iter().any(|p| p[3] < 1.0) {
        return None;
    }
    let shown = colour.map(|p| [p[0], p[1], p[2]].map(srgb_encode));
    let frame = frame(shown.size());
    let median = median(frame.iter().map(|p| shown[*p]));
    let brightness = median.iter().sum::<f32>() / 3.0;
    let alike = shown.map(|p| p.iter().zip(median).all(|(value, m)| (value - m).abs() <= ALIKE));
    let share = |count: usize, of: usize| count as f32 / of.max(1) as f32;
    let of_frame = share(frame.iter().filter(|p| alike[**p]).count(), frame.len());
    if of_frame < OF_FRAME || !(dark_too || brightness >= LIGHT) {
        return None;
    }
    let reached = reached(&alike, frame);
    let of_picture = share(reached.pixels().iter().filter(|r| **r).count(), reached.len());
    (OF_PICTURE[0]..=OF_PICTURE[1]).contains(&of_picture).then_some(reached)
}

/// The outermost pixels.
fn frame((w, h): (usize, usize)) -> Vec<(usize, usize)> {
    let rows = (0..w).flat_map(|x| [(x, 0), (x, h - 1)]);
    rows.chain((0..h).flat_map(|y| [(0, y), (w - 1, y)])).collect()
}

/// The median of each channel.
fn median(colours: impl Iterator<Item = [f32; 3]>) -> [f32; 3] {
    let all: Vec<[f32; 3]> = colours.collect();
    std::array::from_fn(|c| {
        let mut values: Vec<f32> = all.iter().map(|p| p[c]).collect();
        values.sort_by(f32::total_cmp);
        values[values.len() / 2]
    })
}

/// The marked pixels that are connected to some by their sides.
fn reached(marks: &Plane<bool>, from: Vec<(usize, usize)>) -> Plane<bool> {
    let mut reached = marks.map(|_| false);
    let mut open = from;
    while let Some((x, y)) = open.pop() {
        if !marks[(x, y)] || std::mem::replace(&mut reached[(x, y)], true) {
            continue;
        }
        let beside = [(x + 1, y), (x, y + 1), (x.wrapping_sub(1), y), (x, y.wrapping_sub(1))];
        open.extend(beside.into_iter().filter(|q| q.0 < marks.width() && q.1 < marks.height()));
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disc of a tone on a ground of another, with a hole in it.
    fn disc(ground: f32, tone: f32) -> Plane<[f32; 4]> {
        Plane::from_fn(40, 30, |x, y| {
            let r = (x as f32 - 20.0).hypot(y as f32 - 15.0);
            let v = if (3.0..10.0).contains(&r) { tone } else { ground };
            [v, v, v, 1.0]
        })
    }

    #[test]
    fn plain_backdrops_are_found_and_holes_stay() {
        let found = backdrop(&disc(0.95, 0.2), false).unwrap();
        assert!(found[(0, 0)] && !found[(25, 15)] && !found[(20, 15)]);
        assert!(backdrop(&disc(0.0, 0.5), false).is_none(), "night");
        assert!(backdrop(&disc(0.0, 0.5), true).is_some());
    }

    #[test]
    fn full_pictures_and_masks_are_left_alone() {
        let ramp = Plane::from_fn(40, 30, |x, y| [x as f32 / 40.0, y as f32 / 30.0, 0.5, 1.0]);
        assert!(backdrop(&ramp, true).is_none());
        assert!(backdrop(&disc(0.9, 0.9), true).is_none(), "nothing but backdrop");
        let masked = disc(0.95, 0.2).map(|p| [p[0], p[1], p[2], 0.5]);
        assert!(backdrop(&masked, true).is_none());
        assert!(backdrop(&Plane::default(), true).is_none());
        assert!(backdrop(&Plane::filled(1, 1, [1.0; 4]), true).is_none());
    }
}
