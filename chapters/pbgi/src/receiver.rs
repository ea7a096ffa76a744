//! [`Receiver`]: a pixel and what its near rays found beyond what the far fields say.

use crate::cluster::Pixel;
use crate::cube::CubeShape;
use crate::field::{Ball, Field, Light};
use crate::hierarchy::Hierarchy;
use crate::indirect::Prepared;
use crate::near;
use crate::opening::{Dome, Opening};
use crate::surfel::Lit;
use chiaro_basis::math::Vec3;
use chiaro_trace::{GBuffer, Sequence, Sides, Tracer, Vertex};

/// The least cosine of a surface towards the eye, for how long its pixels are.
const LEAST_COSINE: f32 = 0.1;
/// Fields that a receiver mixes, at most.
const MOST_PARTS: usize = 4;
/// The ball of rays without an end.
const EVERYWHERE: (f32, Ball) = (1.0, Ball { centre: Vec3::ZERO, radius: f32::INFINITY });
const NOWHERE: (f32, Ball) = (0.0, Ball { centre: Vec3::ZERO, radius: 0.0 });
/// Pixels along a side of the lattice's pattern, and in all of it.
const PATTERN: usize = 4;

/// What a near ray found, and what the far fields whose balls hold it say in its direction, by the mean of
/// their shares.
#[derive(Clone, Copy)]
pub(crate) struct Residual {
    pub(crate) position: Vec3,
    pub(crate) own: Light,
    pub(crate) far: Light,
}

impl Residual {
    /// What was found less the far light, of which so much is among the sums of the far fields.
    pub(crate) fn light(&self, share: &Light) -> Light {
        std::array::from_fn(|c| self.own[c] - share[c] * self.far[c])
    }
}

/// A pixel that gathers.
pub(crate) struct Receiver {
    pub(crate) pixel: Pixel,
    pub(crate) at: Vertex,
    /// The width of a pixel here, scene units.
    pub(crate) footprint: f32,
    /// How many times longer a pixel is on the surface.
    pub(crate) stretch: f32,
    /// The balls in which its rays look, and their shares.
    pub(crate) parts: [(f32, Ball); MOST_PARTS],
    /// Near rays cast.
    pub(crate) rays: u32,
    /// Those that hit.
    pub(crate) hits: Vec<Residual>,
    /// Rays along which far light was looked up, whether they hit or not, and its sum.
    pub(crate) looked: u32,
    pub(crate) looked_up: Light,
    /// Irradiance by the far fields.
    pub(crate) far: Light,
    /// Irradiance by what is bright in them and hidden from some.
    pub(crate) bright: [f32; 3],
    /// What the far fields leave open, where that is wanted.
    pub(crate) opening: Opening,
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

    /// Irradiance of a receiver by what is bright and hidden from some, told by rays, and what it would be if nothing hid that.
    pub(crate) fn bright(&self, tracer: &Tracer, at: &Vertex) -> [f32; 6] {
        let mut sum = [0.0; 6];
        for (share, field) in &self.parts {
            let found = field.by_bright(at, tracer, *share);
            (0..6).for_each(|c| sum[c] += share * found[c]);
        }
        sum
    }

    /// What that would be if nothing hid it.
    pub(crate) fn open_to_bright(&self, at: &Vertex) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for (share, field) in &self.parts {
            let open = field.open_to_bright(at);
            (0..3).for_each(|c| sum[c] += share * open[c]);
        }
        sum
    }

    /// What the far fields leave open to a receiver under a dome.
    pub(crate) fn opening(&self, at: &Vertex, dome: &Dome) -> Opening {
        let mut sum = [0.0; 6];
        for (share, field) in &self.parts {
            let open = field.opening(at, dome.of_side(field.side()));
            (0..6).for_each(|c| sum[c] += share * open[c]);
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
    pub(crate) fn new(tracer: &Tracer, buffer: &GBuffer, pixel: Pixel) -> Self {
        let at = Vertex::of_pixel(tracer, buffer, pixel);
        let footprint = buffer.pose.pixel_size(buffer.depth[pixel], buffer.size().1 as f32);
        let (w, h) = buffer.size();
        let (x, y) = (pixel.0 as f32 + 0.5, pixel.1 as f32 + 0.5);
        let (_, direction) = buffer.pose.ray(x, y, w as f32, h as f32);
        let stretch = 1.0 / direction.dot(at.side).abs().max(LEAST_COSINE);
        Self::of(at, pixel, (footprint, stretch))
    }

    /// A receiver that has not looked yet, its pixel so wide and so many times longer on the surface.
    pub(crate) fn of(at: Vertex, pixel: Pixel, (footprint, stretch): (f32, f32)) -> Self {
        Self {
            pixel,
            at,
            footprint,
            stretch,
            parts: [EVERYWHERE, NOWHERE, NOWHERE, NOWHERE],
            rays: 0,
            hits: Vec::new(),
            looked: 0,
            looked_up: [0.0; 4],
            far: [0.0; 4],
            bright: [0.0; 3],
            opening: [0.0; 6],
        }
    }

    /// Casts near rays up to number `until`; a hit counts for every field whose ball holds it, beside
    /// that field's own light in this direction. What is farther than `occlusion` does not occlude.
    /// Rays after the first `blind` ones look up far light where they miss, too.
    pub(crate) fn cast<T: Hierarchy>(
        &mut self,
        scene: &Prepared<T>,
        mix: &Mix,
        (lattice, kind): (&Lattice, usize),
        (until, blind): (u32, u32),
        occlusion: f32,
    ) {
        let at = self.at;
        // The hits of a block share out one sequence, all blocks the same: noise would be mottles.
        let sequence = Sequence::new(u64::from(scene.shift));
        self.parts = [NOWHERE; MOST_PARTS];
        self.parts.iter_mut().zip(&mix.parts).for_each(|(p, (share, f))| *p = (*share, f.ball));
        let origin = at.position + at.side * at.offset;
        while self.rays < until {
            let k = self.rays;
            self.rays += 1;
            self.looked += u32::from(k >= blind);
            let direction = at.cosine_direction(lattice.point(kind, k, self.pixel));
            if direction.dot(at.side) <= 0.0 {
                continue;
            }
            let mut exits = [0.0f32; MOST_PARTS];
            exits.iter_mut().zip(&mix.parts).for_each(|(exit, (_, f))| {
                *exit = f.ball.exit(origin, direction);
            });
            let longest = exits.iter().copied().fold(0.0, f32::max);
            let hit = scene.lit.tracer.hit(&at.ray(direction, longest), Sides::Both);
            if hit.is_none() && k < blind {
                continue;
            }
            let (mut within, mut far, mut all) = (0.0, [0.0; 4], [0.0; 4]);
            for ((share, field), exit) in mix.parts.iter().zip(exits) {
                let one = mix.far(field, origin, direction);
                (0..4).for_each(|c| all[c] += share * one[c]);
                if hit.as_ref().is_some_and(|h| h.t <= exit) {
                    within += share;
                    (0..4).for_each(|c| far[c] += share * one[c]);
                }
            }
            if k >= blind {
                (0..4).for_each(|c| self.looked_up[c] += all[c]);
            }
            let Some(hit) = hit.filter(|_| within > 0.0) else { continue };
            let (lit, surfels) = (&scene.lit, &scene.surfels);
            let number = self.hits.len() * PATTERN * PATTERN + place_of(self.pixel);
            let number = number as u32;
            let met =
                near::shade(lit, surfels, &scene.reflected, &hit, direction, &sequence, number);
            let open = if hit.t < occlusion { 0.0 } else { 1.0 };
            let [r, g, b] = met.radiance;
            let (own, far) = ([r, g, b, open], far.map(|l| l / within));
            self.hits.push(Residual { position: met.position, own, far });
        }
    }

    /// Casts so many rays without an end, over nothing: a hit adds its radiance by one shadow ray, and
    /// takes openness away.
    pub(crate) fn cast_far(&mut self, lit: &Lit, lattice: &Lattice, count: u32) {
        let (at, (x, y)) = (self.at, self.pixel);
        let sequence = Sequence::new((y << 32 | x) as u64);
        self.rays = count;
        for k in 0..count {
            let direction = at.cosine_direction(lattice.point(0, k, self.pixel));
            if direction.dot(at.side) <= 0.0 {
                continue;
            }
            let ray = at.ray(direction, f32::INFINITY);
            let Some(hit) = lit.tracer.hit(&ray, Sides::Both) else { continue };
            let (vertex, e) = near::lit(lit, &hit, direction, &sequence, k);
            let [r, g, b] = near::radiance(&vertex, e);
            let (own, far) = ([r, g, b, -1.0], [0.0; 4]);
            self.hits.push(Residual { position: vertex.position, own, far });
        }
    }
}

/// Near rays of all pixels, as points in [0, 1)^2. Each net of a manner is an aligned piece of one
/// (0, 2) sequence; the pixels of a 4 x 4 pattern share it out so that the rays of a pixel, of 2 x 2
/// and of 4 x 4 pixels are all spread well.
pub(crate) struct Lattice {
    manners: Vec<Manner>,
}

struct Manner {
    rays: usize,
    points: Vec<[f32; 2]>,
}

impl Lattice {
    /// For manners whose nets end after so many rays of a pixel each; `shift` chooses another sequence.
    pub(crate) fn new(manners: &[&[u32]], shift: u32) -> Self {
        let sequence = Sequence::new(u64::from(shift));
        let manner = |(pair, ends): (usize, &&[u32])| Manner {
            rays: ends.last().map_or(0, |end| *end as usize),
            points: places(ends).map(|i| sequence.point(i, pair as u32)).collect(),
        };
        Self { manners: manners.iter().enumerate().map(manner).collect() }
    }

    /// Ray `k` of a pixel by the rays of a manner.
    pub(crate) fn point(&self, manner: usize, k: u32, pixel: Pixel) -> [f32; 2] {
        let manner = &self.manners[manner];
        manner.points[place_of(pixel) * manner.rays + k as usize]
    }
}

/// The place of a pixel in the lattice's pattern.
pub(crate) fn place_of((x, y): Pixel) -> usize {
    let bit = |v: usize, i: usize| v >> i & 1;
    bit(x, 0) | bit(y, 0) << 1 | bit(x, 1) << 2 | bit(y, 1) << 3
}

/// Where in the sequence the rays of each place of the pattern are.
fn places(ends: &[u32]) -> impl Iterator<Item = u32> {
    (0..(PATTERN * PATTERN) as u32).flat_map(move |place| {
        let (mut start, mut index, mut before) = (0u32, Vec::new(), 0);
        for end in ends {
            let block = (end - before).next_power_of_two();
            let piece = block * (PATTERN * PATTERN) as u32;
            start = start.next_multiple_of(piece);
            index.extend((0..end - before).map(|j| start + place * block + j));
            (start, before) = (start + piece, *end);
        }
        index
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_of_a_pixel_and_of_blocks_are_spread_well() {
        let lattice = Lattice::new(&[&[4, 12, 44], &[32]], 0);
        let pixels = |x: usize, y: usize, side: usize| {
            (0..side * side).map(move |i| (x + i % side, y + i / side))
        };
        for (manner, rays, side) in
            [(0, 4, 1), (0, 4, 2), (0, 4, 4), (1, 8, 1), (1, 32, 1), (1, 32, 4)]
        {
            let count = rays * side * side;
            for (columns, lines) in [(count, 1), (count / 2, 2), (1, count)] {
                let mut cells = vec![0; count];
                for pixel in pixels(4, 8, side) {
                    for k in 0..rays {
                        let [u, v] = lattice.point(manner, k as u32, pixel);
                        let at = |t: f32, n: usize| (t * n as f32) as usize;
                        cells[at(v, lines) * columns + at(u, columns)] += 1;
                    }
                }
                assert!(cells.iter().all(|c| *c == 1), "{side}: {columns} x {lines}");
            }
        }
    }
}
