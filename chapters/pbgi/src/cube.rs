//! [`CubeBuffer`]: what surrounds a receiver, on the six faces of a cube (thesis, 6.3.2).
//!
//! Splats come nearest first; each is a square of its solid angle about its direction, over an edge of the cube on the
//! faces on both sides, and adds its radiance to every texel by the share of the texel that it covers and
//! that is still free. Coverage ends at 1, so that nearer things hide farther ones. A texel knows where in it
//! that lies: light that grazes a receiver does not come from the middle of the texel above its plane.

mod texel;

pub use texel::{Back, Texel};

use crate::cut::Splat;
use chiaro_basis::math::{Vec3, smoothstep};

/// The faces of a cube with texels that hold radiance.
#[derive(Clone, Debug)]
pub struct CubeBuffer {
    shape: CubeShape,
    texels: Vec<Texel>,
    /// Distances and indices of splats, to be sorted.
    order: Vec<u64>,
    /// What a splat covers.
    covered: Vec<Covered>,
}

/// What a splat covers of a texel.
#[derive(Clone, Copy, Debug)]
struct Covered {
    texel: usize,
    share: f32,
    /// Where that lies from the texel's middle, in texels.
    place: [f32; 2],
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

/// Coverage between which a texel's radiance comes to be divided by it.
const NEARLY_FULL: [f32; 2] = [0.2, 0.4];
/// Coverage and what is near between which a surface is taken to go on in the near field.
const GOES_ON: [f32; 2] = [0.6, 0.8];
/// A square of less than so much of its solid angle is made wider.
const CLEARLY_LESS: f32 = 0.97;
/// What looks larger reaches into any texel, steradians.
const WIDE: f32 = 1.0;
/// What has to be in a texel, far and near, for that.
const SOME: [f32; 2] = [0.0, 0.1];
/// The mean coverage of the texels around a nearly full one between which it comes to be closed.
const CLOSED: [f32; 2] = [0.65, 0.85];
/// Distances over that of a texel around it between which one comes to show what lies behind an opening.
const OPENING: [f32; 2] = [1.25, 2.0];

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

    /// Finds what a square covers that is `factor` times as wide as the splat's; its solid angle.
    #[inline]
    fn under(&self, splat: &Splat, factor: f32, covered: &mut Vec<Covered>) -> f32 {
        covered.clear();
        let mut sum = 0.0;
        Square::each_of(splat, self.side, factor, |square| {
            let base = square.face * self.side * self.side;
            square.each(self.side, |texel, share, place| {
                // All faces are alike.
                sum += share * self.solid_angles[texel];
                covered.push(Covered { texel: base + texel, share, place });
            });
        });
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

/// A square on a face, in texels, as far as it lies on it.
#[derive(Clone, Copy)]
struct Square {
    face: usize,
    low: [f32; 2],
    high: [f32; 2],
}

impl Square {
    /// Calls `each` with what lies on the faces of a square about a splat's direction, `factor` times as wide as the
    /// square of its solid angle: on the direction's own, and, where it crosses an edge or a corner of the cube, beyond.
    #[inline]
    fn each_of(splat: &Splat, side: usize, factor: f32, mut each: impl FnMut(&Self)) {
        let n = side as f32;
        let size = splat.solid_angle * (0.25 * n * factor).powi(2);
        let d = splat.direction;
        let (face, u, v) = face_of(d);
        let (first, over) = Self::at(face, [u, v], size, n);
        each(&first);
        for (i, over) in over.into_iter().enumerate() {
            let axis = (face / 2 + 1 + i) % 3;
            if over && d[axis] != 0.0 {
                Self::beyond(d, axis, size, n).iter().for_each(&mut each);
            }
        }
    }

    /// What lies on the face of an axis that is not the direction's own.
    fn beyond(d: Vec3, axis: usize, size: f32, n: f32) -> Option<Self> {
        let place = [1, 2].map(|i| d[(axis + i) % 3] / d[axis].abs());
        let (square, _) = Self::at(2 * axis + usize::from(d[axis] < 0.0), place, size, n);
        let any = square.low[0] < square.high[0] && square.low[1] < square.high[1];
        any.then_some(square)
    }

    /// The square about a place on a face's plane, of a solid angle of which `size` is a sixteenth times the square of
    /// the `n` texels along a side; and which of its coordinates go over an edge.
    #[inline]
    fn at(face: usize, [u, v]: [f32; 2], size: f32, n: f32) -> (Self, [bool; 2]) {
        // A face's area element is (1 + u^2 + v^2)^(3/2) solid angles.
        let square = 1.0 + u.abs().min(1.0).powi(2) + v.abs().min(1.0).powi(2);
        let half = (size * square * square.sqrt()).sqrt().min(0.5 * n);
        let centre = [u, v].map(|t| (0.5 * t + 0.5) * n);
        let over = centre.map(|c| c < half || c > n - half);
        let [low, high] = [-half, half].map(|h| centre.map(|c| (c + h).clamp(0.0, n)));
        (Self { face, low, high }, over)
    }

    /// Calls `each` with every texel of the face that it covers, the share covered, and where that lies from the
    /// texel's middle.
    #[inline]
    fn each(&self, side: usize, mut each: impl FnMut(usize, f32, [f32; 2])) {
        let [columns, rows] = [0, 1].map(|i| Extent { low: self.low[i], high: self.high[i] });
        let (x, y) = (columns.low as usize, rows.low as usize);
        for row in y..rows.end(side) {
            let (height, v) = rows.within(row);
            for column in x..columns.end(side) {
                let (width, u) = columns.within(column);
                each(row * side + column, width * height, [u, v]);
            }
        }
    }
}

/// From one coordinate to another, in texels.
#[derive(Clone, Copy)]
struct Extent {
    low: f32,
    high: f32,
}

impl Extent {
    /// The length within a cell, and its middle from the cell's.
    #[inline]
    fn within(self, cell: usize) -> (f32, f32) {
        let (low, high) = (self.low - cell as f32, self.high - cell as f32);
        let (low, high) = (low.max(0.0), high.min(1.0));
        ((high - low).max(0.0), 0.5 * (low + high) - 0.5)
    }

    /// The cell after the last.
    #[inline]
    fn end(self, side: usize) -> usize {
        // Rounded up; `ceil` is a call on processors without an instruction for it.
        let whole = self.high as usize;
        (whole + usize::from(self.high > whole as f32)).min(side)
    }
}

impl CubeBuffer {
    /// An empty buffer.
    pub fn new(shape: CubeShape) -> Self {
        let texels = vec![Texel::default(); shape.directions.len()];
        Self { shape, texels, order: Vec::new(), covered: Vec::new() }
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
        let Self { shape, covered, .. } = self;
        let mut solid_angle = shape.under(splat, 1.0, covered);
        if solid_angle < CLEARLY_LESS * splat.solid_angle {
            let factor = (splat.solid_angle / solid_angle).sqrt();
            solid_angle = shape.under(splat, factor, covered);
        }
        // The area element varies over a square; what is too much or too little is spread over it.
        let scale = if solid_angle > 0.0 { splat.solid_angle / solid_angle } else { 0.0 };
        for part in &*covered {
            self.texels[part.texel].cover(splat, (part.share * scale).min(1.0), part.place);
        }
    }

    /// Takes a texel's light away.
    pub(crate) fn blacken(&mut self, i: usize) {
        (self.texels[i].light, self.texels[i].back.light) = ([0.0; 3], [0.0; 3]);
    }

    /// Takes away what lies far behind the rest of a texel, which then fills it.
    pub(crate) fn close(&mut self, i: usize) {
        let t = &mut self.texels[i];
        let back = std::mem::take(&mut t.back);
        let scale = 1.0 / (t.coverage - back.coverage);
        (0..3).for_each(|c| t.light[c] = scale * (t.light[c] - back.light[c]).max(0.0));
        t.distance = scale * (t.distance - back.distance);
        let all = scale / t.coverage * (t.coverage - back.coverage);
        (t.axis, t.place) = (t.axis * all, t.place.map(|p| p * all));
        t.coverage = 1.0;
    }

    /// Fills a texel with a flat piece of surface.
    #[cfg(test)]
    pub(crate) fn fill_flat(&mut self, i: usize, radiance: [f32; 3], distance: f32, axis: Vec3) {
        let splat = Splat { distance, radiance, axis, ..Splat::default() };
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
            Square::each_of(&Splat { solid_angle, ..*disc }, side, 1.0, |square| {
                let base = square.face * side * side;
                square.each(side, |texel, _, _| texels[base + texel] = true);
            });
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
        let splat = Splat { distance, radiance, ..Splat::default() };
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

    /// A texel's radiance seen by the receiver: divided by its coverage as far as it is closed.
    pub fn radiance(&self, texel: usize) -> [f32; 3] {
        let t = &self.texels[texel];
        let closed = self.closed(texel);
        let more = if closed > 0.0 { 1.0 - closed + closed / t.coverage } else { 1.0 };
        t.light.map(|l| l * more)
    }

    /// The share of a texel behind which nothing is seen, by the same rule.
    pub fn coverage(&self, texel: usize) -> f32 {
        let t = &self.texels[texel];
        t.coverage + self.closed(texel) * (1.0 - t.coverage)
    }

    /// How far the holes of a texel are but cracks between splats: as far as it is nearly full in closed
    /// surroundings, or as a surface that fills it goes on in the near field. In between nothing flips.
    fn closed(&self, texel: usize) -> f32 {
        let t = &self.texels[texel];
        if t.coverage <= 0.0 || t.coverage >= 1.0 {
            return 0.0;
        }
        let goes_on = smoothstep(SOME, t.coverage)
            * smoothstep(SOME, t.near)
            * smoothstep(GOES_ON, t.coverage + t.near);
        let full = smoothstep(NEARLY_FULL, t.coverage);
        if goes_on >= 1.0 || full <= 0.0 {
            goes_on
        } else {
            goes_on.max(full * smoothstep(CLOSED, self.around(texel)))
        }
    }

    /// The mean coverage of the texels around one, on its face, by what does not lie far before it.
    fn around(&self, texel: usize) -> f32 {
        let side = self.shape.side;
        let own = self.texels[texel].mean_distance();
        let (x, y, face) = (texel % side, texel / side % side, texel / (side * side));
        let (mut sum, mut count) = (0.0, 0.0);
        for v in y.saturating_sub(1)..(y + 2).min(side) {
            for u in x.saturating_sub(1)..(x + 2).min(side) {
                if (u, v) != (x, y) {
                    let t = &self.texels[(face * side + v) * side + u];
                    let behind = smoothstep(OPENING, own / t.mean_distance());
                    sum += (1.0 - behind) * (t.coverage + t.near).min(1.0);
                    count += 1.0;
                }
            }
        }
        sum / f32::max(count, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::vec3;
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
    fn what_is_seen_through_an_opening_is_not_taken_for_a_crack() {
        let shape = CubeShape::new(8);
        let i = shape.texel(vec3(0.2, 0.1, 1.0));
        let seen = |distance: f32| {
            let mut buffer = CubeBuffer::new(shape.clone());
            for k in (0..64).map(|k| i / 64 * 64 + k).filter(|k| *k != i) {
                buffer.fill(k, [0.0; 3], 5.0, (1.0, [0.0; 2]));
            }
            buffer.fill(i, [1.0; 3], distance, (0.5, [0.0; 2]));
            buffer.radiance(i)[0]
        };
        assert!((seen(5.0) - 1.0).abs() < 1e-4 && (seen(12.0) - 0.5).abs() < 1e-4);
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
                ..Splat::default()
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

    /// Splats over an edge and over a corner of the cube, moved a little across it, cover what they covered.
    #[test]
    fn nothing_jumps_over_an_edge_or_a_corner() {
        let covered = |direction: Vec3, solid_angle: f32| {
            let mut buffer = CubeBuffer::new(CubeShape::new(10));
            let (radiance, axis) = ([1.0; 3], Vec3::ZERO);
            let distance = 1.0;
            let rest = Splat::default();
            buffer.add(&Splat { direction, distance, solid_angle, radiance, axis, ..rest });
            buffer.texels().iter().map(|t| t.coverage).collect::<Vec<f32>>()
        };
        for (over, across) in [
            (Vec3::new(1.0, 0.2, 1.0), Vec3::X),
            (Vec3::new(-1.0, -1.0, 0.5), Vec3::Y),
            (Vec3::new(1.0, -1.0, 1.0), Vec3::new(0.3, 1.0, -0.5)),
        ] {
            for omega in [0.003, 0.02, 0.1] {
                let [a, b] = [-1e-3, 1e-3].map(|t| covered((over + t * across).normalize(), omega));
                let (apart, all) = (
                    a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum::<f32>(),
                    a.iter().sum::<f32>(),
                );
                assert!(apart < 0.06 * all, "{over} {omega}: {apart} of {all}");
            }
        }
    }

    #[test]
    fn a_texel_closes_without_a_jump() {
        let shape = CubeShape::new(4);
        let middle = 5;
        let seen = |own: f32, around: f32, near: f32| {
            let mut buffer = CubeBuffer::new(shape.clone());
            for i in 0..16 {
                let share = if i == middle { own } else { around };
                buffer.fill(i, [1.0; 3], 2.0, (share, [0.0; 2]));
            }
            buffer.texels[middle].near = near;
            (buffer.radiance(middle)[0], buffer.coverage(middle))
        };
        for k in 0..1000 {
            let t = k as f32 * 1e-3;
            for [a, b] in [
                [seen(t, 1.0, 0.0), seen(t + 1e-3, 1.0, 0.0)],
                [seen(0.5, t, 0.0), seen(0.5, t + 1e-3, 0.0)],
                [seen(0.2, 0.0, t), seen(0.2, 0.0, t + 1e-3)],
                [seen(t, 0.0, 0.7), seen(t + 1e-3, 0.0, 0.7)],
            ] {
                assert!((a.0 - b.0).abs() < 0.03 && (a.1 - b.1).abs() < 0.03, "{t} {a:?} {b:?}");
            }
        }
        assert_eq!(seen(0.5, 1.0, 0.0), (1.0, 1.0));
        assert_eq!(seen(0.5, 0.3, 0.0), (0.5, 0.5));
        assert_eq!(seen(0.2, 0.0, 0.8), (1.0, 1.0));
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
                ..Splat::default()
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
            ..Splat::default()
        };
        buffer.add_sorted(&[splat(2.0, 9.0), splat(1.0, 1.0)]);
        let full = buffer.texels().iter().filter(|t| t.coverage == 1.0);
        assert!(full.clone().count() > 0 && full.clone().all(|t| (t.light[0] - 1.0).abs() < 1e-6));
    }
}
