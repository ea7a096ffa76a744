//! [`Pack`]: a few pieces of what surrounds receivers, side by side.

use chiaro_basis::math::Vec3;

/// Texels side by side, so that the compiler can use vectors.
pub(crate) const LANES: usize = 8;
pub(crate) type Lanes = [f32; LANES];

/// A few texels or other things as flat pieces: their places relative to the centre, in radii of the ball; their
/// slants, against the normal and as long as the squared distance over the normal's cosine towards
/// the centre; and light times solid angle.
#[derive(Clone, Copy, Default)]
pub(crate) struct Pack {
    pub(crate) place: [Lanes; 3],
    pub(crate) slant: [Lanes; 3],
    pub(crate) light: [Lanes; 4],
}

impl Pack {
    /// Sets one to a flat piece of a mean normal at a place, which sends this.
    pub(crate) fn set(&mut self, k: usize, (place, axis): (Vec3, Vec3), light: [f32; 3]) {
        let (towards, distance) = place.normalize_and_length();
        let slant = slant(towards, axis) * (distance * distance);
        for c in 0..3 {
            self.place[c][k] = place[c];
            self.slant[c][k] = slant[c];
            self.light[c][k] = light[c];
        }
    }

    /// A texel from a receiver (its place, normal and side): the way to it, and the weight of its light.
    #[inline(always)]
    pub(crate) fn seen(&self, k: usize, [p, n, s]: &[Vec3; 3]) -> ([f32; 3], f32) {
        let [px, py, pz] = [self.place[0][k], self.place[1][k], self.place[2][k]];
        let (x, y, z) = (px - p.x, py - p.y, pz - p.z);
        let above = x * s.x + y * s.y + z * s.z > 0.0;
        let cosine = (x * n.x + y * n.y + z * n.z).max(0.0);
        let cosine = if above { cosine } else { 0.0 };
        let slant = [self.slant[0][k], self.slant[1][k], self.slant[2][k]];
        let facing = (x * slant[0] + y * slant[1] + z * slant[2]).max(0.0);
        let square = x * x + y * y + z * z;
        ([x, y, z], cosine * facing / (square * square).max(f32::MIN_POSITIVE))
    }
}

/// The least cosine at which a piece is slanted.
pub(crate) const LEAST_COSINE: f32 = 0.2;

/// Against the normal of a piece in the direction `towards`, over the cosine between both; facing the
/// centre where its mean normal says little.
pub(crate) fn slant(towards: Vec3, axis: Vec3) -> Vec3 {
    let normal = axis - towards * (1.0 - axis.length()).max(0.0);
    let normal = normal.normalize_or(-towards);
    let cosine = -normal.dot(towards);
    if cosine >= LEAST_COSINE {
        return -normal / cosine;
    }
    // Turned towards the centre until it has the least cosine.
    let across = (normal + towards * cosine).normalize_or_zero();
    let least = across * (1.0 - LEAST_COSINE * LEAST_COSINE).sqrt() - towards * LEAST_COSINE;
    -least / LEAST_COSINE
}
