//! What the ink of a ribbon looks like from near: how much of it is there, by u and by the distance
//! from the middle.

use super::knob::{Brush, Grain};
use super::noise::{Axis, cloud_on};
use super::texture::Texture;

/// Places in a pixel at which grain is looked at, along and across the stroke: no two in one column
/// or row.
const WITHIN: [[f32; 2]; 4] = [[-0.375, -0.125], [-0.125, 0.375], [0.125, -0.375], [0.375, 0.125]];

/// A place on a ribbon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Pixels along.
    pub(super) u: f64,
    /// Pixels from the ribbon's start, by its share of u, and of the whole.
    pub(super) length: [f32; 2],
    /// Pixels across, left negative.
    pub(super) across: f32,
    /// Half the width.
    pub(super) half: f32,
}

/// The grain of a brush.
pub(super) struct Inking<'a> {
    pub(super) brush: &'a Brush,
    pub(super) texture: Option<&'a Texture>,
}

impl Inking<'_> {
    /// Whether every place has all of its ink.
    pub(super) fn is_even(&self) -> bool {
        let missing =
            matches!(self.brush.grain, Grain::Stretch | Grain::Repeat) && self.texture.is_none();
        self.brush.grain == Grain::Solid || missing
    }

    /// How far the edge is torn at u, on a side.
    pub(super) fn tear(&self, axis: &Axis, u: f64, right: bool) -> f32 {
        let b = self.brush;
        if b.rough <= 0.0 {
            return 0.0;
        }
        let channel = if right { 81 } else { 83 };
        let length = f64::from(b.rough_length);
        let (coarse, fine) =
            (axis.wave(u, 3.0 * length, channel), axis.wave(u, length, channel + 1));
        -b.rough * (0.5 + 0.3 * coarse + 0.4 * fine).max(0.0)
    }

    /// The share of the ink that is there in the pixel around a place, as far as the stroke reaches into it.
    /// Streaks and specks are as fine as pixels, so that one look would make stairs of them, which
    /// flicker as the stroke moves; pictures are read as wide as the pixel already.
    pub(super) fn over_a_pixel(&self, axis: &Axis, place: &Place) -> f32 {
        if !matches!(self.brush.grain, Grain::Bristle | Grain::Charcoal | Grain::Pencil) {
            return self.ink(axis, place);
        }
        let [from, to] =
            [-0.5, 0.5].map(|side| (place.across + side).clamp(-place.half, place.half));
        let look = |[along, across]: [f32; 2]| {
            let u = place.u + f64::from(along);
            let across = from + (to - from) * (across + 0.5);
            self.ink(axis, &Place { u, across, ..*place })
        };
        0.25 * WITHIN.map(look).iter().sum::<f32>()
    }

    /// The share of the ink that is there.
    pub(super) fn ink(&self, axis: &Axis, place: &Place) -> f32 {
        let b = self.brush;
        let size = f64::from(b.grain_size.max(0.05));
        let missing = match b.grain {
            Grain::Solid => 0.0,
            Grain::Bristle => self.dry(axis, place, size),
            Grain::Charcoal => self.specks(axis, place, size, 0.6),
            Grain::Pencil => self.specks(axis, place, size, 0.66),
            Grain::Wash => {
                let rim = (place.across.abs() / place.half.max(1e-3)).clamp(0.0, 1.0);
                let pool = cloud_on(axis, 95, place.u, 9.0 * size, 0.0);
                (1.0 - rim.powi(4)) * (0.55 + 0.45 * pool)
            }
            Grain::Stretch | Grain::Repeat => return self.picture(axis, place),
        };
        1.0 - b.grain_strength * missing.clamp(0.0, 1.0)
    }

    /// Streaks: where a bristle has run dry, which it does for a while.
    fn dry(&self, axis: &Axis, place: &Place, size: f64) -> f32 {
        let y = f64::from(place.across) / size;
        let long = f64::from(self.brush.pressure_length.max(20.0));
        let streak = cloud_on(axis, 91, place.u, 0.5 * long, 7.3 * y.floor())
            .mul_add(0.5, 0.5 * cloud_on(axis, 92, place.u, 0.12 * long, 1.0 * y));
        let wet = 0.5 + 0.5 * axis.wave(place.u, 1.6 * long, 93);
        // The middle holds more ink than the edges.
        let rim = (place.across / place.half.max(1e-3)).powi(2);
        step(0.62 + 0.25 * wet - 0.22 * rim, 0.12, streak)
    }

    /// Specks of paper that the stroke leaves free: more of them towards its edges, and where the
    /// hand is light for a while.
    fn specks(&self, axis: &Axis, place: &Place, size: f64, held: f32) -> f32 {
        let y = f64::from(place.across) / size;
        let coarse = cloud_on(axis, 97, place.u, 2.4 * size, 0.5 * y);
        let fine = cloud_on(axis, 98, place.u, size, y);
        let light = axis.wave(place.u, 0.7 * f64::from(self.brush.pressure_length), 99);
        let rim = (place.across / place.half.max(1e-3)).powi(2).min(1.0);
        step(held - 0.06 * light - 0.3 * rim, 0.22, 0.35 * coarse + 0.65 * fine)
    }

    fn picture(&self, axis: &Axis, place: &Place) -> f32 {
        let Some(texture) = self.texture else { return 1.0 };
        let b = self.brush;
        let v = 0.5 + 0.5 * place.across / place.half.max(1e-3);
        let natural = b.width * texture.aspect();
        let x = match b.grain {
            Grain::Stretch => stretched(place.length, b.picture_cap, natural),
            _ => {
                let lattice = axis.lattice(f64::from(natural));
                (place.u / lattice.cell).rem_euclid(1.0) as f32
            }
        };
        texture.sample([x, v], 2.0 * place.half.max(0.25), b.grain == Grain::Repeat)
    }
}

/// Where a place lies in a picture that is laid along a whole stroke once: its ends, a share `cap`
/// of the picture each, keep their `natural` length, and its middle is stretched.
fn stretched([along, total]: [f32; 2], cap: f32, natural: f32) -> f32 {
    let end = (cap * natural).min(0.5 * total);
    let rest = total - along;
    if along < end {
        cap * along / end
    } else if rest < end {
        1.0 - cap * rest / end
    } else {
        cap + (1.0 - 2.0 * cap) * (along - end) / (total - 2.0 * end).max(1e-6)
    }
}

/// 0 under `edge`, 1 over it, softly over `width`.
fn step(edge: f32, width: f32, x: f32) -> f32 {
    let t = ((x - edge + 0.5 * width) / width).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_a_stretched_picture_keep_their_length() {
        let at = |along| stretched([along, 200.0], 0.2, 50.0);
        assert!((at(5.0) - 0.1).abs() < 1e-6 && (at(195.0) - 0.9).abs() < 1e-6);
        assert!((at(100.0) - 0.5).abs() < 1e-6);
        assert_eq!([at(0.0), at(200.0)], [0.0, 1.0]);
    }

    #[test]
    fn a_pixel_that_moves_by_a_tenth_changes_little() {
        let axis = Axis { seed: 3, period: None };
        let brush = Brush { grain: Grain::Bristle, grain_size: 1.1, ..Brush::default() };
        let inking = Inking { brush: &brush, texture: None };
        let at = |across: f32, u: f64| Place { u, length: [0.0, 1.0], across, half: 4.0 };
        let steps = |ink: &dyn Fn(&Place) -> f32| {
            let step = |i: u32| {
                let (across, u) = (0.1 * (i % 70) as f32 - 3.5, 9.0 * f64::from(i / 70));
                (ink(&at(across + 0.1, u)) - ink(&at(across, u))).abs()
            };
            (0..3500).map(step).fold(0.0, f32::max)
        };
        let once = steps(&|place| inking.ink(&axis, place));
        let whole = steps(&|place| inking.over_a_pixel(&axis, place));
        assert!(once > 0.4, "{once}");
        assert!(whole < 0.3, "{whole}");
    }

    #[test]
    fn grain_depends_on_u_and_closes() {
        let axis = Axis { seed: 3, period: Some(140.0) };
        for grain in [Grain::Bristle, Grain::Charcoal, Grain::Pencil, Grain::Wash] {
            let brush = Brush { grain, ..Brush::default() };
            let inking = Inking { brush: &brush, texture: None };
            let ink = |u: f64| {
                inking.ink(&axis, &Place { u, length: [0.0, 1.0], across: 1.3, half: 3.0 })
            };
            let values: Vec<f32> = (0..300).map(|i| ink(0.7 * f64::from(i))).collect();
            assert!(values.iter().all(|v| (0.0..=1.0).contains(v)));
            assert!(values.iter().any(|v| (v - values[0]).abs() > 0.05), "{grain:?} is even");
            assert!((ink(11.0) - ink(151.0)).abs() < 1e-4, "{grain:?} does not close");
        }
    }
}
