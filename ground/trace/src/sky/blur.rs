//! [`BlurredSky`]: a sky at any sharpness, for rays that stand for a cone of directions (Krivanek and
//! Colbert 2008: filtered importance sampling).

use super::{Sky, texel_solid_angle};
use chiaro_basis::math::Vec3;
use chiaro_image::Plane;

/// A sky and its halves in size, down to a few texels.
pub struct BlurredSky {
    levels: Vec<Sky>,
    /// A texel of the first level at the equator, steradians.
    texel: f32,
}

impl BlurredSky {
    /// All levels of a sky.
    pub fn new(sky: &Sky) -> Self {
        let mut levels = vec![sky.clone()];
        while let Some(last) = levels.last().filter(|l| l.radiance.height() >= 8) {
            let next = Sky::new(halved(&last.radiance));
            levels.push(next);
        }
        let size = sky.radiance.size();
        Self { levels, texel: texel_solid_angle(size.1 / 2, size) }
    }

    /// The mean radiance about a direction over so many steradians.
    pub fn radiance(&self, towards: Vec3, solid_angle: f32) -> [f32; 3] {
        let level = (0.5 * (solid_angle / self.texel).max(1.0).log2())
            .clamp(0.0, (self.levels.len() - 1) as f32);
        let (low, t) = (level as usize, level.fract());
        let a = self.levels[low].backdrop(towards);
        let b = self.levels[(low + 1).min(self.levels.len() - 1)].backdrop(towards);
        std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
    }
}

/// Half as large, texels weighed by their solid angles.
fn halved(plane: &Plane<[f32; 3]>) -> Plane<[f32; 3]> {
    let (w, h) = plane.size();
    Plane::from_fn((w / 2).max(1), (h / 2).max(1), |x, y| {
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (u, v) = ((2 * x + dx).min(w - 1), (2 * y + dy).min(h - 1));
            let weight = texel_solid_angle(v, (w, h));
            (0..3).for_each(|c| sum[c] += weight * plane[(u, v)][c]);
            total += weight;
        }
        sum.map(|s| s / total)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_has_the_same_light() {
        let sky = Sky::new(Plane::from_fn(64, 32, |x, y| [(x * y % 7) as f32, y as f32, 1.0]));
        let blurred = BlurredSky::new(&sky);
        assert!(blurred.levels.len() > 2);
        for level in &blurred.levels {
            assert!((level.power() / sky.power() - 1.0).abs() < 0.02, "{}", level.power());
        }
        let one = |angle| blurred.radiance(Vec3::new(0.6, 0.0, 0.8), angle);
        assert!((one(1e-9)[2] - 1.0).abs() < 1e-5 && (one(10.0)[2] - 1.0).abs() < 1e-5);
    }
}
