//! [`Leaf`]: how the thesis's tree stores a surfel (table 6.2).
//!
//! Half floats have units of the tree's own, so that scenes in millimetres and kilometres, by candles
//! and in the sun, keep their eleven bits.

use crate::bits::{from_grid, grid};
use crate::packed::Record;
use chiaro_basis::choice;
use chiaro_basis::math::Vec3;
use half::f16;

/// Units of what is stored in few bits.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Scale {
    /// No node is larger.
    pub(crate) radius: f32,
    area: f32,
    light: f32,
}

/// The brightest colour in its unit.
const BRIGHTEST: f32 = 1024.0;

impl Scale {
    /// The units of a tree over records.
    pub(crate) fn of(records: &[Record]) -> Self {
        let low = records.iter().fold(Vec3::INFINITY, |m, r| m.min(r.position));
        let high = records.iter().fold(Vec3::NEG_INFINITY, |m, r| m.max(r.position));
        let brightest =
            records.iter().flat_map(|r| r.radiance[0]).fold(f32::MIN_POSITIVE, f32::max);
        let area: f64 = records.iter().map(|r| f64::from(r.area)).sum();
        let positive = |x: f32| if x > 0.0 && x.is_finite() { x } else { 1.0 };
        Self {
            radius: positive(high.distance(low)),
            area: positive((area / records.len().max(1) as f64) as f32),
            light: brightest / BRIGHTEST,
        }
    }

    /// The brightest number of a colour.
    pub(crate) fn brightest(&self) -> f32 {
        BRIGHTEST * self.light
    }
}

choice! {
    /// How a leaf is stored (table 6.2).
    pub enum Leaf {
        /// The position in full.
        #[default]
        A = "a",
        /// The position relative to its parent.
        B = "b",
    }
}

impl Leaf {
    /// Bytes of a leaf: position, colour, normal, area.
    pub fn bytes(self) -> [usize; 4] {
        match self {
            Self::A => [12, 6, 6, 2],
            Self::B => [2, 6, 6, 2],
        }
    }

    pub(crate) fn size(self) -> usize {
        self.bytes().iter().sum()
    }

    /// Writes a record whose parent is a sphere.
    pub(crate) fn write(
        self,
        record: &Record,
        (centre, radius): (Vec3, f32),
        scale: &Scale,
        bytes: &mut [u8],
    ) {
        let half = |v: f32| f16::from_f32(v.clamp(-65_504.0, 65_504.0)).to_le_bytes();
        let mut leaf = Vec::with_capacity(26);
        match self {
            Self::A => {
                record.position.to_array().iter().for_each(|v| leaf.extend(v.to_le_bytes()));
            }
            Self::B => {
                let over = if radius > 0.0 { 1.0 / radius } else { 0.0 };
                let place = ((record.position - centre) * over).to_array().map(|c| grid(c, 5));
                let code = place[0] | place[1] << 5 | place[2] << 10;
                leaf.extend((code as u16).to_le_bytes());
            }
        }
        record.radiance[0].iter().for_each(|v| leaf.extend(half(v / scale.light)));
        record.normal.to_array().iter().for_each(|v| leaf.extend(half(*v)));
        leaf.extend(half(record.area / scale.area));
        bytes[..leaf.len()].copy_from_slice(&leaf);
    }

    /// The record in the bytes of a leaf whose parent is a sphere.
    pub(crate) fn read(self, bytes: &[u8], (centre, radius): (Vec3, f32), scale: &Scale) -> Record {
        let word = |i: usize| u16::from_le_bytes([bytes[i], bytes[i + 1]]);
        let half = |i: usize| f16::from_bits(word(i)).to_f32();
        let (position, at) = match self {
            Self::A => {
                let float = |i: usize| f32::from_le_bytes(std::array::from_fn(|k| bytes[i + k]));
                (Vec3::new(float(0), float(4), float(8)), 12)
            }
            Self::B => {
                let place = [0, 5, 10].map(|shift| from_grid(u32::from(word(0)) >> shift & 31, 5));
                (centre + Vec3::from(place) * radius, 2)
            }
        };
        Record {
            position,
            radiance: [[0, 2, 4].map(|i| half(at + i) * scale.light), [0.0; 3]],
            normal: Vec3::new(half(at + 6), half(at + 8), half(at + 10)),
            area: half(at + 12) * scale.area,
            alive: [true, false],
            albedo: [0.0; 3],
        }
    }
}
