//! [`Texture`]: a picture of a stroke, from left to right, as how much ink is there.

use chiaro_image::Plane;

/// A stroke's picture with its halves, quarters and so on, so that small ones do not flicker.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    levels: Vec<Plane<f32>>,
}

impl Texture {
    /// A picture, sRGB-encoded RGBA: where it is see-through there is no ink; where nothing is,
    /// darkness is ink.
    pub fn of(picture: &Plane<[u8; 4]>) -> Self {
        let clear = picture.pixels().iter().any(|p| p[3] < 255);
        let ink = picture.map(|&[r, g, b, a]| match clear {
            true => f32::from(a) / 255.0,
            false => {
                1.0 - (0.299 * f32::from(r) + 0.587 * f32::from(g) + 0.114 * f32::from(b)) / 255.0
            }
        });
        let mut levels = vec![ink];
        while let Some(half) = levels.last().filter(|p| p.height() > 1 && p.width() > 1).map(halved)
        {
            levels.push(half);
        }
        Self { levels }
    }

    /// Width over height.
    pub(super) fn aspect(&self) -> f32 {
        self.levels[0].width() as f32 / self.levels[0].height().max(1) as f32
    }

    /// The ink at (`x`, `y`) in [0, 1], drawn `height` pixels high; x comes again, y ends.
    pub(super) fn sample(&self, x: f32, y: f32, height: f32) -> f32 {
        let coarse = (self.levels[0].height() as f32 / height).log2().max(0.0);
        let level = coarse.min((self.levels.len() - 1) as f32);
        let (low, t) = (level.floor() as usize, level.fract());
        let a = bilinear(&self.levels[low], x, y);
        match self.levels.get(low + 1) {
            Some(next) if t > 0.0 => a + (bilinear(next, x, y) - a) * t,
            _ => a,
        }
    }
}

fn halved(p: &Plane<f32>) -> Plane<f32> {
    let (w, h) = (p.width() / 2, p.height() / 2);
    Plane::from_fn(w.max(1), h.max(1), |x, y| {
        0.25 * (p[(2 * x, 2 * y)]
            + p[(2 * x + 1, 2 * y)]
            + p[(2 * x, 2 * y + 1)]
            + p[(2 * x + 1, 2 * y + 1)])
    })
}

fn bilinear(p: &Plane<f32>, x: f32, y: f32) -> f32 {
    let (w, h) = p.size();
    let (fx, fy) = (x * w as f32 - 0.5, y * h as f32 - 0.5);
    let (s, t) = (fx - fx.floor(), fy - fy.floor());
    let at = |i: i64, j: i64| {
        let (i, j) = (i.rem_euclid(w as i64), j.clamp(0, h as i64 - 1));
        p[(i as usize, j as usize)]
    };
    let (i, j) = (fx.floor() as i64, fy.floor() as i64);
    let row = |j: i64| at(i, j) + (at(i + 1, j) - at(i, j)) * s;
    row(j) + (row(j + 1) - row(j)) * t
}
