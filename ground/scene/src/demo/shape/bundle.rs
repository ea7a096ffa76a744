//! [`Bundle`]: many strands of round cones as one field, looked up by place.

use super::field::{limb, merge};
use crate::Bounds;
use chiaro_basis::math::Vec3;
use rayon::prelude::*;

/// A round cone of a strand.
#[derive(Clone, Copy)]
struct Piece {
    strand: u32,
    ends: [(Vec3, f32); 2],
}

/// Strands, each a row of points with radii. Strands blend with one another, the pieces of one do
/// not bulge at their joints.
pub(crate) struct Bundle {
    origin: Vec3,
    size: [usize; 3],
    /// The pieces near each cell of a grid, strand by strand.
    near: Vec<Vec<Piece>>,
    /// How far all pieces are at least from anywhere in each cell.
    far: Vec<f32>,
    blend: f32,
}

/// The width of a grid cell.
const CELL: f32 = 0.1;

impl Bundle {
    /// Strands that blend over `blend` units.
    pub(crate) fn new(strands: &[Vec<(Vec3, f32)>], blend: f32) -> Self {
        let reach = Vec3::splat(CELL);
        let ends = strands.iter().flatten().flat_map(|&(p, r)| [p - r - reach, p + r + reach]);
        let bounds = Bounds::of(ends);
        let size = ((bounds.max - bounds.min) / CELL).to_array().map(|x| x.max(0.0) as usize + 1);
        let near = vec![Vec::new(); size.iter().product()];
        let mut bundle = Self { origin: bounds.min, size, near, far: Vec::new(), blend };
        for (k, strand) in strands.iter().enumerate() {
            for w in strand.windows(2) {
                bundle.put(Piece { strand: k as u32, ends: [w[0], w[1]] });
            }
        }
        bundle.far = bundle.distances(strands);
        bundle
    }

    /// The least distance from each cell to the strands, less than a cell's half diagonal too small.
    fn distances(&self, strands: &[Vec<(Vec3, f32)>]) -> Vec<f32> {
        let pieces: Vec<_> = strands.iter().flat_map(|s| s.windows(2)).collect();
        let least = |i: usize| {
            let (x, y, z) = (i % self.size[0], i / self.size[0] % self.size[1], i);
            let middle = self.middle([x, y, z / (self.size[0] * self.size[1])]);
            let to = |w: &&[(Vec3, f32)]| limb(middle, w[0].0, w[1].0, w[0].1, w[1].1);
            pieces.iter().map(to).fold(f32::INFINITY, f32::min) - 0.87 * CELL
        };
        let empty = |i: usize| if self.near[i].is_empty() { least(i) } else { f32::INFINITY };
        (0..self.near.len()).into_par_iter().map(empty).collect()
    }

    fn middle(&self, cell: [usize; 3]) -> Vec3 {
        self.origin + CELL * (Vec3::from(cell.map(|c| c as f32)) + 0.5)
    }

    /// Enters a piece in the cells that it comes near to.
    fn put(&mut self, piece: Piece) {
        let [(a, ra), (b, rb)] = piece.ends;
        let reach = ra.max(rb) + self.blend + CELL;
        let low = ((a.min(b) - reach - self.origin) / CELL).max(Vec3::ZERO);
        let high = ((a.max(b) + reach - self.origin) / CELL).max(Vec3::ZERO);
        let span = |k: usize| low[k] as usize..=(high[k] as usize).min(self.size[k] - 1);
        for z in span(2) {
            for y in span(1) {
                for x in span(0) {
                    if limb(self.middle([x, y, z]), a, b, ra, rb) < 0.87 * CELL + self.blend {
                        self.near[(z * self.size[1] + y) * self.size[0] + x].push(piece);
                    }
                }
            }
        }
    }

    /// `field` merged with the strands; exact near them, a bound of both farther than the blend.
    pub(crate) fn merged(&self, p: Vec3, field: f32) -> f32 {
        let cell = ((p - self.origin) / CELL).floor();
        let inside = (0..3).all(|k| cell[k] >= 0.0 && cell[k] < self.size[k] as f32);
        if !inside {
            let far = self.origin + CELL * Vec3::from(self.size.map(|n| n as f32));
            return field.min(CELL + p.distance(p.clamp(self.origin, far)));
        }
        let [x, y, z] = cell.to_array().map(|c| c as usize);
        let index = (z * self.size[1] + y) * self.size[0] + x;
        let field = field.min(self.far[index]);
        let (mut all, mut strand, mut one) = (field, u32::MAX, f32::INFINITY);
        for piece in &self.near[index] {
            if piece.strand != strand {
                all = merge(all, one, self.blend);
                (strand, one) = (piece.strand, f32::INFINITY);
            }
            let [(a, ra), (b, rb)] = piece.ends;
            one = one.min(limb(p, a, b, ra, rb));
        }
        merge(all, one, self.blend)
    }
}

/// A strand through some joints, smooth between them (Catmull and Rom 1974), `steps` to a span.
pub(crate) fn strand(joints: &[(Vec3, f32)], steps: usize) -> Vec<(Vec3, f32)> {
    let last = joints.len() - 1;
    let at = |i: isize| {
        let (p, r) = joints[i.clamp(0, last as isize) as usize];
        p.extend(r)
    };
    let point = |k: usize| {
        let span = (k / steps).min(last - 1);
        let (t, s) = (k as f32 / steps as f32 - span as f32, span as isize);
        let [a, b, c, d] = [at(s - 1), at(s), at(s + 1), at(s + 2)];
        let (p, q) = (2.0 * a - 5.0 * b + 4.0 * c - d, 3.0 * b - a - 3.0 * c + d);
        let v = 0.5 * (2.0 * b + t * ((c - a) + t * (p + t * q)));
        (v.truncate(), v.w.max(1e-4))
    };
    (0..=last * steps).map(point).collect()
}
