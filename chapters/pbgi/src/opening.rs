//! Directional occlusion: where a point is open, and how much light from all around comes in there.
//!
//! The same sums that tell the open share of the hemisphere tell its mean direction (the bent
//! normal) and the irradiance of a dome through it:
//!
//! ```text
//! b = 1/pi integral of open(w) (n.w) w dw        E = integral of open(w) (n.w) L(w) dw
//! ```
//!
//! L is the scene's sky, averaged over the texels of the buffers; a white dome of radiance 1 where
//! there is none, whose E / pi is the ambient occlusion. What is farther than the knob `occlusion`
//! does not occlude.

use crate::cube::CubeShape;
use chiaro_basis::math::Vec3;
use chiaro_image::Plane;
use chiaro_trace::Sky;
use std::f32::consts::FRAC_1_PI;

/// pi times the bent normal, and the irradiance of the dome.
pub(crate) type Opening = [f32; 6];

/// The bent normal's length below which nothing is open; in the open it is 2/3.
const CLOSED: f32 = 0.01;

/// Radiance from all around, by the texels of buffers.
pub(crate) struct Dome {
    shapes: Vec<CubeShape>,
    texels: Vec<Vec<[f32; 3]>>,
}

impl Dome {
    /// A sky's mean in the texels of each shape; white without a sky.
    pub(crate) fn new(sky: Option<&Sky>, shapes: &[CubeShape]) -> Self {
        let texels = |shape: &CubeShape| match sky {
            Some(sky) => means(sky, shape),
            None => vec![[1.0; 3]; shape.directions.len()],
        };
        Self { texels: shapes.iter().map(texels).collect(), shapes: shapes.to_vec() }
    }

    /// Radiance by the texels of buffers of so many texels along a side.
    pub(crate) fn of_side(&self, side: usize) -> &[[f32; 3]] {
        let index = self.shapes.iter().position(|s| s.side() == side).unwrap_or(0);
        &self.texels[index]
    }

    /// Radiance from a direction.
    pub(crate) fn radiance(&self, direction: Vec3) -> [f32; 3] {
        self.texels[0][self.shapes[0].texel(direction)]
    }
}

/// The mean radiance of a sky in each texel.
fn means(sky: &Sky, shape: &CubeShape) -> Vec<[f32; 3]> {
    let mut sums = vec![[0.0f64; 4]; shape.directions.len()];
    for (towards, radiance, solid_angle) in sky.texels() {
        let sum = &mut sums[shape.texel(towards)];
        let weight = f64::from(solid_angle);
        (0..3).for_each(|c| sum[c] += weight * f64::from(radiance[c]));
        sum[3] += weight;
    }
    let mean = |(sum, towards): (&[f64; 4], &Vec3)| match sum[3] > 0.0 {
        true => [0, 1, 2].map(|c| (sum[c] / sum[3]) as f32),
        false => sky.radiance(*towards),
    };
    sums.iter().zip(&shape.directions).map(mean).collect()
}

/// Where pixels are open: from all covered ones that gathered.
#[derive(Clone, Debug)]
pub struct Openings {
    /// The unit mean of the open directions, weighted by cosine; zero where nothing is open.
    pub bent: Plane<[f32; 3]>,
    /// Irradiance over pi of the sky through what is open; of a white dome of radiance 1 where there
    /// is no sky.
    pub dome: Plane<[f32; 3]>,
}

impl Openings {
    pub(crate) fn none(width: usize, height: usize) -> Self {
        let black = Plane::filled(width, height, [0.0; 3]);
        Self { bent: black.clone(), dome: black }
    }

    pub(crate) fn set(&mut self, pixel: (usize, usize), opening: &Opening) {
        let [x, y, z, r, g, b] = opening.map(|v| v * FRAC_1_PI);
        let mean = Vec3::new(x, y, z);
        let unit = if mean.length() > CLOSED { mean.normalize() } else { Vec3::ZERO };
        self.bent[pixel] = unit.to_array();
        self.dome[pixel] = [r, g, b].map(|e| e.max(0.0));
    }
}
