//! [`CubeBuffer`]: what surrounds a receiver, on the six faces of a cube (thesis, 6.3.2).
//!
//! Splats come nearest first; each is a square of its solid angle, moved inside the face of its
//! direction, and adds its radiance to every texel by the share of the texel that it covers and
//! that is still free. Coverage ends at 1, so that nearer things hide farther ones. A texel knows where in it
//! that lies: light that grazes a receiver does not come from the middle of the texel above its plane.

use crate::cut::Splat;
use chiaro_basis::math::Vec3;

/// The faces of a cube with texels that hold radiance.
#[derive(Clone, Debug)]
pub struct CubeBuffer {
    shape: CubeShape,
    texels: Vec<Texel>,
    /// Distances and indices of splats, to be sorted.
    order: Vec<u64>,
}

/// One texel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Texel {
    /// Radiance times coverage.
    pub light: [f32; 3],
    /// The share that is covered, in [0, 1].
    pub coverage: f32,
    /// Distance times coverage.
    pub distance: f32,
    /// Mean normal times coverage.
    pub axis: Vec3,
    /// Where in it what is covered lies, from its middle, in texels, times coverage.
    pub place: [f32; 2],
    /// The share in which something nearer than the near field's radius is.
    pub near: f32,
}

/// Directions and solid angles of a cube's texels.
#[derive(Clone, Debug)]
pub struct CubeShape {
    side: usize,
    /// Unit vectors through the texels' centres.
    pub directions: Vec<Vec3>,
    /// Steradians.
    pub solid_angles: Vec<f32>,
}

/// Coverage above which a texel's radiance is divided by it.
const NEARLY_FULL: f32 = 0.3;
/// Coverage and what is near over which a surface is taken to go on in the near field.
const GOES_ON: f32 = 0.7;
/// What looks larger reaches into any texel, steradians.
const WIDE: f32 = 1.0;
/// The least coverage that is divided by.
const LEAST_COVERAGE: f32 = 0.05;
/// The mean coverage of the texels around it that this takes.
const CLOSED: f32 = 0.75;

impl CubeShape {
    /// A cube of `side` x `side` texels a face.
    pub fn new(side: usize) -> Self {
        let mut directions = Vec::with_capacity(6 * side * side);
        let mut solid_angles = Vec::with_capacity(6 * side * side);
        let edge = |i: usize| 2.0 * i as f64 / side as f64 - 1.0;
        // The solid angle under a corner rectangle of the face, in closed form.
        let corner = |u: f64, v: f64| (u * v).atan2((u * u + v * v + 1.0).sqrt());
        for face in 0..6 {
            for y in 0..side {
                for x in 0..side {
                    let (u0, u1, v0, v1) = (edge(x), edge(x + 1), edge(y), edge(y + 1));
                    let omega = corner(u1, v1) - corner(u0, v1) - corner(u1, v0) + corner(u0, v0);
                    solid_angles.push(omega as f32);
                    let (u, v) = (0.5 * (u0 + u1), 0.5 * (v0 + v1));
                    directions.push(on_face(face, u as f32, v as f32).normalize());
                }
            }
        }
        Self { side, directions, solid_angles }
    }

    /// Texels along a side.
    pub fn side(&self) -> usize {
        self.side
    }

    /// The mean solid angle of a texel.
    pub fn mean_solid_angle(&self) -> f32 {
        4.0 * std::f32::consts::PI / (6 * self.side * self.side) as f32
    }

    /// The solid angle under a square.
    fn under(&self, square: &Square) -> f32 {
        let mut sum = 0.0;
        // All faces are alike.
        square.each(self.side, |texel, share, _| sum += share * self.solid_angles[texel]);
        sum
    }

    /// The texel that a direction falls into.
    pub fn texel(&self, direction: Vec3) -> usize {
        let (face, u, v) = face_of(direction);
        let at = |t: f32| (((0.5 * t + 0.5) * self.side as f32) as usize).min(self.side - 1);
        (face * self.side + at(v)) * self.side + at(u)
    }
}

/// The face of a direction and the place on it, each coordinate in [-1, 1].
pub(crate) fn face_of(d: Vec3) -> (usize, f32, f32) {
    let axis = d.abs().max_position();
    let major = d[axis];
    let (u, v) = (d[(axis + 1) % 3] / major.abs(), d[(axis + 2) % 3] / major.abs());
    (2 * axis + usize::from(major < 0.0), u, v)
}

pub(crate) fn on_face(face: usize, u: f32, v: f32) -> Vec3 {
    let axis = face / 2;
    let mut d = Vec3::ZERO;
    d[axis] = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    d[(axis + 1) % 3] = u;
    d[(axis + 2) % 3] = v;
    d
}

/// A square on a face, in texels.
struct Square {
    face: usize,
    low: [f32; 2],
    high: [f32; 2],
}

impl Square {
    /// The square of a splat's solid angle about its direction, moved inside the face.
    fn of(splat: &Splat, side: usize) -> Self {
        let (face, u, v) = face_of(splat.direction);
        let n = side as f32;
        let root = 0.25 * n * splat.solid_angle.sqrt();
        let place = |t: f32, half: f32| ((0.5 * t + 0.5) * n).clamp(half, n - half);
        let (mut x, mut y, mut half) = (u, v, 0.0);
        // A face's area element is (1 + u^2 + v^2)^(3/2) solid angles; where the square ends up
        // tells its size, and its size where it ends up.
        for _ in 0..2 {
            let square = 1.0 + x * x + y * y;
            half = (root * (square * square.sqrt()).sqrt()).min(0.5 * n);
            (x, y) = (place(u, half) * 2.0 / n - 1.0, place(v, half) * 2.0 / n - 1.0);
        }
        let centre = [place(u, half), place(v, half)];
        Self { face, low: centre.map(|c| c - half), high: centre.map(|c| c + half) }
    }

    /// Makes it wider by a factor, inside its face of `n` texels.
    fn grow(&mut self, factor: f32, n: f32) {
        let half = (0.5 * factor * (self.high[0] - self.low[0])).min(0.5 * n);
        let centre = [0, 1].map(|i| (0.5 * (self.low[i] + self.high[i])).clamp(half, n - half));
        (self.low, self.high) = (centre.map(|c| c - half), centre.map(|c| c + half));
    }

    /// Calls `each` with every texel of the face that it covers, the share covered, and where that lies from the
    /// texel's middle.
    #[inline]
    fn each(&self, side: usize, mut each: impl FnMut(usize, f32, [f32; 2])) {
        let last = |end: f32| {
            // Rounded up; `ceil` is a call on processors without an instruction for it.
            let whole = end as usize;
            (whole + usize::from(end > whole as f32)).min(side)
        };
        let ([x0, y0], [x1, y1]) = (self.low, self.high);
        // The length of a span within a cell, and its middle from the cell's.
        let within = |low: f32, high: f32, cell: usize| {
            let (low, high) = (low - cell as f32, high - cell as f32);
            let (low, high) = (low.max(0.0), high.min(1.0));
            ((high - low).max(0.0), 0.5 * (low + high) - 0.5)
        };
        for row in y0 as usize..last(y1) {
            let (height, v) = within(y0, y1, row);
            for column in x0 as usize..last(x1) {
                let (width, u) = within(x0, x1, column);
                each(row * side + column, width * height, [u, v]);
            }
        }
    }
}

impl CubeBuffer {
    /// An empty buffer.
    pub fn new(shape: CubeShape) -> Self {
        let texels = vec![Texel::default(); shape.directions.len()];
        Self { shape, texels, order: Vec::new() }
    }

    /// Empties it.
    pub fn clear(&mut self) {
        self.texels.fill(Texel::default());
    }

    /// The directions and solid angles.
    pub fn shape(&self) -> &CubeShape {
        &self.shape
    }

    /// The texels, face by face, row by row.
    pub fn texels(&self) -> &[Texel] {
        &self.texels
    }

    /// Adds splats by distance; of equal ones those that come first.
    pub fn add_sorted(&mut self, splats: &[Splat]) {
        let mut order = std::mem::take(&mut self.order);
        order.clear();
        // The bits of numbers that are not negative are in the order of the numbers.
        let key = |(i, s): (usize, &Splat)| u64::from(s.distance.to_bits()) << 32 | i as u64;
        order.extend(splats.iter().enumerate().map(key));
        order.sort_unstable();
        order.iter().for_each(|key| self.add(&splats[*key as u32 as usize]));
        self.order = order;
    }

    /// Adds one splat behind all that are there. What it covers in all, before anything hides it, is
    /// its solid angle.
    pub fn add(&mut self, splat: &Splat) {
        let mut square = Square::of(splat, self.shape.side);
        let mut solid_angle = self.shape.under(&square);
        if solid_angle < splat.solid_angle {
            square.grow((splat.solid_angle / solid_angle).sqrt(), self.shape.side as f32);
            solid_angle = self.shape.under(&square);
        }
        // The area element varies over a square; what is too much or too little is spread over it.
        let scale = if solid_angle > 0.0 { splat.solid_angle / solid_angle } else { 0.0 };
        let base = square.face * self.shape.side * self.shape.side;
        square.each(self.shape.side, |texel, share, place| {
            self.texels[base + texel].cover(splat, (share * scale).min(1.0), place);
        });
    }

    /// Fills a texel with a flat piece of surface.
    #[cfg(test)]
    pub(crate) fn fill_flat(&mut self, i: usize, radiance: [f32; 3], distance: f32, axis: Vec3) {
        let zero = Vec3::ZERO;
        let splat =
            Splat { direction: zero, distance, solid_angle: 0.0, radiance, axis, marks: false };
        self.texels[i].cover(&splat, 1.0, [0.0; 2]);
    }

    /// Finds the texels that discs reach into: squares about them twice as wide as they are.
    pub(crate) fn touched<'a>(
        &self,
        discs: impl Iterator<Item = &'a Splat>,
        texels: &mut Vec<bool>,
    ) {
        let side = self.shape.side;
        texels.clear();
        texels.resize(self.texels.len(), false);
        for disc in discs {
            // A slanted disc is as long as one that is not.
            let cosine = disc.axis.dot(disc.direction).abs().max(1e-3);
            let solid_angle = 4.0 * disc.solid_angle * (0.25 / cosine).max(1.0);
            if solid_angle > WIDE {
                texels.fill(true);
                return;
            }
            let square = Square::of(&Splat { solid_angle, ..*disc }, side);
            let base = square.face * side * side;
            square.each(side, |texel, _, _| texels[base + texel] = true);
        }
    }

    /// Fills a share of a texel, at a place from its middle in texels, before any splat, with something at a distance.
    pub fn fill(
        &mut self,
        texel: usize,
        radiance: [f32; 3],
        distance: f32,
        (share, place): (f32, [f32; 2]),
    ) {
        let zero = Vec3::ZERO;
        let splat = Splat {
            direction: zero,
            distance,
            solid_angle: 0.0,
            radiance,
            axis: zero,
            marks: false,
        };
        self.texels[texel].cover(&splat, share, place);
    }

    /// The unit vector towards what is in a texel; through its middle where nothing is.
    pub fn towards(&self, texel: usize) -> Vec3 {
        let t = &self.texels[texel];
        if t.coverage <= 0.0 {
            return self.shape.directions[texel];
        }
        let side = self.shape.side;
        let (x, y, face) = (texel % side, texel / side % side, texel / (side * side));
        let at = |i: usize, place: f32| {
            (2.0 * (i as f32 + 0.5 + place / t.coverage) / side as f32) - 1.0
        };
        on_face(face, at(x, t.place[0]), at(y, t.place[1])).normalize()
    }

    /// A texel's radiance seen by the receiver: divided by its coverage where it is closed.
    pub fn radiance(&self, texel: usize) -> [f32; 3] {
        let t = &self.texels[texel];
        if self.is_closed(texel) { t.light.map(|l| l / t.coverage) } else { t.light }
    }

    /// The share of a texel behind which nothing is seen, by the same rule.
    pub fn coverage(&self, texel: usize) -> f32 {
        if self.is_closed(texel) { 1.0 } else { self.texels[texel].coverage }
    }

    /// Whether the holes of a texel are but cracks between splats: where it is nearly full in closed
    /// surroundings; or where a surface that fills it goes on in the near field.
    fn is_closed(&self, texel: usize) -> bool {
        let t = &self.texels[texel];
        let goes_on = t.near > 0.0 && t.coverage > LEAST_COVERAGE && t.coverage + t.near > GOES_ON;
        (t.coverage > NEARLY_FULL || goes_on)
            && t.coverage < 1.0
            && (goes_on || self.around(texel) > CLOSED)
    }

    /// The mean coverage of the texels around one, on its face.
    fn around(&self, texel: usize) -> f32 {
        let side = self.shape.side;
        let (x, y, face) = (texel % side, texel / side % side, texel / (side * side));
        let (mut sum, mut count) = (0.0, 0.0);
        for v in y.saturating_sub(1)..(y + 2).min(side) {
            for u in x.saturating_sub(1)..(x + 2).min(side) {
                if (u, v) != (x, y) {
                    let t = &self.texels[(face * side + v) * side + u];
                    sum += (t.coverage + t.near).min(1.0);
                    count += 1.0;
                }
            }
        }
        sum / f32::max(count, 1.0)
    }
}

impl Texel {
    fn cover(&mut self, splat: &Splat, share: f32, place: [f32; 2]) {
        if splat.marks {
            self.near = (self.near + share).min(1.0);
            return;
        }
        let share = share.min(1.0 - self.coverage);
        if share > 0.0 {
            self.coverage += share;
            self.distance += share * splat.distance;
            self.axis += splat.axis * share;
            (0..2).for_each(|i| self.place[i] += share * place[i]);
            (0..3).for_each(|c| self.light[c] += share * splat.radiance[c]);
        }
    }

    /// The mean normal of what is there; nothing where nothing is.
    pub fn mean_axis(&self) -> Vec3 {
        if self.coverage > 0.0 { self.axis / self.coverage } else { Vec3::ZERO }
    }

    /// The mean distance of what is there; infinite where nothing is.
    pub fn mean_distance(&self) -> f32 {
        if self.coverage > 0.0 { self.distance / self.coverage } else { f32::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random::r2;
    use std::f32::consts::{PI, TAU};

    #[test]
    fn texels_tile_the_sphere() {
        for side in [2, 8, 12] {
            let shape = CubeShape::new(side);
            let total: f32 = shape.solid_angles.iter().sum();
            assert!((total - 4.0 * PI).abs() < 1e-4);
            for (i, d) in shape.directions.iter().enumerate() {
                assert_eq!(shape.texel(*d), i);
            }
        }
    }

    #[test]
    fn a_splat_covers_its_solid_angle_near_edges_too() {
        let mut buffer = CubeBuffer::new(CubeShape::new(16));
        for i in 0..600 {
            let omega = [0.002, 0.02, 0.2][i as usize % 3];
            let [u, v] = r2(i);
            let (z, (sin, cos)) = (1.0 - 2.0 * u, (TAU * v).sin_cos());
            let r = (1.0 - z * z).sqrt();
            let direction = Vec3::new(r * cos, r * sin, z);
            buffer.clear();
            let radiance = [1.0; 3];
            buffer.add(&Splat {
                direction,
                distance: 1.0,
                solid_angle: omega,
                radiance,
                axis: Vec3::ZERO,
                marks: false,
            });
            let covered: f32 = buffer
                .texels()
                .iter()
                .zip(&buffer.shape().solid_angles)
                .map(|(t, omega)| t.coverage * omega)
                .sum();
            assert!((covered / omega - 1.0).abs() < 0.03, "{direction} {omega}: {covered}");
        }
    }

    #[test]
    fn a_small_splat_is_seen_where_it_is() {
        let mut buffer = CubeBuffer::new(CubeShape::new(8));
        for i in 0..200 {
            let [u, v] = r2(i);
            let (z, (sin, cos)) = (1.0 - 2.0 * u, (TAU * v).sin_cos());
            let r = (1.0 - z * z).sqrt();
            let direction = Vec3::new(r * cos, r * sin, z);
            buffer.clear();
            buffer.add(&Splat {
                direction,
                distance: 1.0,
                solid_angle: 1e-6,
                radiance: [1.0; 3],
                axis: Vec3::ZERO,
                marks: false,
            });
            let texel = (0..buffer.texels().len()).max_by(|a, b| {
                buffer.texels()[*a].coverage.total_cmp(&buffer.texels()[*b].coverage)
            });
            assert!(buffer.towards(texel.unwrap()).distance(direction) < 2e-3, "{direction}");
        }
    }

    #[test]
    fn nearer_splats_hide_farther_ones() {
        let mut buffer = CubeBuffer::new(CubeShape::new(4));
        let splat = |distance: f32, red: f32| Splat {
            direction: Vec3::X,
            distance,
            solid_angle: 1.0,
            radiance: [red, 0.0, 0.0],
            axis: Vec3::ZERO,
            marks: false,
        };
        buffer.add_sorted(&[splat(2.0, 9.0), splat(1.0, 1.0)]);
        let full = buffer.texels().iter().filter(|t| t.coverage == 1.0);
        assert!(full.clone().count() > 0 && full.clone().all(|t| (t.light[0] - 1.0).abs() < 1e-6));
    }
}
