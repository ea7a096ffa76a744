//! [`Receiver`]: a pixel and what its near rays found beyond what the far fields say.

use crate::cluster::Pixel;
use crate::cube::CubeShape;
use crate::field::{Field, Light};
use crate::hierarchy::Hierarchy;
use crate::indirect::Prepared;
use crate::near;
use chiaro_basis::math::Vec3;
use chiaro_trace::{GBuffer, Sequence, Sides, Vertex};

/// Rays of the largest block of the lattice.
const BLOCK: u32 = 64;
/// Pixels along a side of its pattern.
const PATTERN: usize = 4;

/// What a near ray found, less what the far fields say in its direction.
#[derive(Clone, Copy)]
pub(crate) struct Residual {
    pub(crate) position: Vec3,
    pub(crate) light: Light,
}

/// A pixel that gathers.
pub(crate) struct Receiver {
    pub(crate) pixel: Pixel,
    pub(crate) at: Vertex,
    /// The width of a pixel here, scene units.
    pub(crate) footprint: f32,
    /// Near rays cast.
    pub(crate) rays: u32,
    /// Those that hit.
    pub(crate) hits: Vec<Residual>,
}

/// Fields that a receiver mixes, with their shares, and the shapes of their buffers.
pub(crate) struct Mix<'a> {
    pub(crate) parts: Vec<(f32, &'a Field)>,
    pub(crate) shapes: [&'a CubeShape; 2],
}

impl Mix<'_> {
    /// Far irradiance of a receiver.
    pub(crate) fn irradiance(&self, at: &Vertex) -> Light {
        let mut sum = [0.0; 4];
        for (share, field) in &self.parts {
            let e = field.irradiance(at);
            (0..4).for_each(|c| sum[c] += share * e[c]);
        }
        sum
    }

    fn far(&self, field: &Field, origin: Vec3, direction: Vec3) -> Light {
        let [first, second] = self.shapes;
        let shape = if first.side() == field.side() { first } else { second };
        field.light(shape, origin, direction)
    }
}

impl Receiver {
    pub(crate) fn new<T: Hierarchy>(scene: &Prepared<T>, buffer: &GBuffer, pixel: Pixel) -> Self {
        let at = Vertex::of_pixel(scene.lit.tracer, buffer, pixel);
        let footprint = buffer.pose.pixel_size(buffer.depth[pixel], buffer.size().1 as f32);
        Self { pixel, at, footprint, rays: 0, hits: Vec::new() }
    }

    /// Casts near rays up to number `until`; a hit counts for every field whose ball holds it, less
    /// that field's own light in this direction. What is farther than `occlusion` does not occlude.
    pub(crate) fn cast<T: Hierarchy>(
        &mut self,
        scene: &Prepared<T>,
        mix: &Mix,
        lattice: &Lattice,
        until: u32,
        occlusion: f32,
    ) {
        let at = self.at;
        let seed = (self.pixel.1 << 32 | self.pixel.0) as u64;
        let sequence = Sequence::new(seed);
        let origin = at.position + at.side * at.offset;
        while self.rays < until {
            let k = self.rays;
            self.rays += 1;
            let direction = at.cosine_direction(lattice.point(k, self.pixel));
            if direction.dot(at.side) <= 0.0 {
                continue;
            }
            let exit = |f: &Field| f.ball.exit(origin, direction);
            let longest = mix.parts.iter().map(|(_, f)| exit(f)).fold(0.0, f32::max);
            let hit = scene.lit.tracer.hit(&at.ray(direction, longest), Sides::Both);
            let Some(hit) = hit else { continue };
            let (lit, surfels) = (&scene.lit, &scene.surfels);
            let met = near::shade(lit, surfels, &scene.reflected, &hit, direction, &sequence, k);
            let open = if hit.t < occlusion { 0.0 } else { 1.0 };
            let [r, g, b] = met.radiance;
            let own = [r, g, b, open];
            let mut light = [0.0; 4];
            for (share, field) in mix.parts.iter().filter(|(_, f)| hit.t <= exit(f)) {
                let far = mix.far(field, origin, direction);
                (0..4).for_each(|c| light[c] += share * (own[c] - far[c]));
            }
            self.hits.push(Residual { position: met.position, light });
        }
    }
}

/// Near rays of all pixels, as points in [0, 1)^2: the pixels of a 4 x 4 pattern share out one
/// (0, 2) sequence in blocks, so that a pixel's rays are spread well, and those of 16 pixels together
/// too.
pub(crate) struct Lattice {
    rays: usize,
    points: Vec<[f32; 2]>,
}

impl Lattice {
    /// For up to so many rays a pixel; `shift` chooses another sequence.
    pub(crate) fn new(rays: u32, shift: u32) -> Self {
        let sequence = Sequence::new(u64::from(shift));
        let point = |place: u32, k: u32| sequence.point(place * BLOCK + k % BLOCK, k / BLOCK);
        let pattern = (PATTERN * PATTERN) as u32;
        let points = (0..pattern).flat_map(|place| (0..rays).map(move |k| point(place, k)));
        Self { rays: rays as usize, points: points.collect() }
    }

    /// Ray `k` of a pixel.
    pub(crate) fn point(&self, k: u32, (x, y): Pixel) -> [f32; 2] {
        const ORDER: [usize; 16] = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];
        let place = ORDER[(y % PATTERN) * PATTERN + x % PATTERN];
        self.points[place * self.rays + k as usize]
    }
}
