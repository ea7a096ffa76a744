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

    /// The ink at (`x`, `y`) in [0, 1], drawn `height` pixels high; y ends, and x unless it `repeats`.
    pub(super) fn sample(&self, [x, y]: [f32; 2], height: f32, repeats: bool) -> f32 {
        let coarse = (self.levels[0].height() as f32 / height).log2().max(0.0);
        let level = coarse.min((self.levels.len() - 1) as f32);
        let (low, t) = (level.floor() as usize, level.fract());
        let level = |k: usize| self.levels.get(k).map(|p| bilinear(p, x, y, repeats));
        let a = level(low).unwrap_or(0.0);
        match (t > 0.0).then(|| level(low + 1)).flatten() {
            Some(next) => a + (next - a) * t,
            None => a,
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

fn bilinear(p: &Plane<f32>, x: f32, y: f32, repeats: bool) -> f32 {
    let (w, h) = p.size();
    let (fx, fy) = (x * w as f32 - 0.5, y * h as f32 - 0.5);
    let (s, t) = (fx - fx.floor(), fy - fy.floor());
    let at = |i: i64, j: i64| {
        let i = if repeats { i.rem_euclid(w as i64) } else { i.clamp(0, w as i64 - 1) };
        let j = j.clamp(0, h as i64 - 1);
        p[(i as usize, j as usize)]
    };
    let (i, j) = (fx.floor() as i64, fy.floor() as i64);
    let row = |j: i64| at(i, j) + (at(i + 1, j) - at(i, j)) * s;
    row(j) + (row(j + 1) - row(j)) * t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_that_is_laid_once_ends_where_it_ends() {
        let picture = Plane::from_fn(8, 4, |x, _| [0, 0, 0, if x < 4 { 200 } else { 0 }]);
        let texture = Texture::of(&picture);
        for height in [4.0, 2.0, 1.0] {
            let ends = |repeats| [0.0, 1.0].map(|x| texture.sample([x, 0.5], height, repeats));
            assert_eq!(ends(false), [200.0 / 255.0, 0.0], "{height}");
            // Where it comes again its last column is beside its first.
            assert!(ends(true).iter().all(|ink| (ink - 100.0 / 255.0).abs() < 1e-3), "{height}");
        }
    }
}
