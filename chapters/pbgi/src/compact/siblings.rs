//! [`Siblings`]: coded nodes that share a parent, read side by side.

use super::{BOTH, Format, HEAD, share, signed, u16_at, u32_at};
use crate::bits::{axis_of, from_float16};
use crate::code::Decoded;
use crate::packed::{self, FAN, Means, Spheres};
use crate::payload::Sent;
use chiaro_basis::math::Vec3;
use std::borrow::Cow;

/// Bytes of siblings, one after the other.
pub struct Siblings<'a> {
    pub(super) format: &'a Format,
    pub(super) bytes: Cow<'a, [u8]>,
    /// Bytes of one.
    pub(super) stride: usize,
}

impl Siblings<'_> {
    /// What comes before the code of each.
    fn heads(&self) -> impl Iterator<Item = &[u8; HEAD]> {
        self.bytes.chunks_exact(self.stride).filter_map(<[u8]>::first_chunk).take(FAN)
    }

    fn one(&self, k: usize) -> &[u8] {
        &self.bytes[k * self.stride..(k + 1) * self.stride]
    }

    /// What is known of a node beside its code.
    fn known(&self, k: usize, means: &Means) -> (f32, Vec3, f32) {
        (means.area[k], means.axis(k), share(self.one(k)[BOTH]))
    }
}

impl packed::Siblings for Siblings<'_> {
    fn spheres(&self) -> Spheres {
        let mut spheres = Spheres::default();
        for (k, head) in self.heads().enumerate() {
            let (centre, radius) = self.format.sphere(head);
            spheres.set(k, centre, radius);
        }
        spheres
    }

    fn means(&self, spheres: &Spheres) -> Means {
        let mut codes = [0u32; FAN];
        let mut means = Means::default();
        for (k, head) in self.heads().enumerate() {
            codes[k] = u32_at(head, 13);
            means.area[k] = from_float16(u16_at(head, 8), self.format.top_area);
            (0..3).for_each(|i| means.mean[i][k] = signed(head[10 + i]));
        }
        for (mean, centre) in means.mean.iter_mut().zip(&spheres.centre) {
            for k in 0..FAN {
                mean[k] = centre[k] + mean[k] * (spheres.radius[k] / 127.0);
            }
        }
        for (k, code) in codes.into_iter().enumerate() {
            let axis = axis_of(code);
            (0..3).for_each(|i| means.axis[i][k] = axis[i]);
        }
        means
    }

    fn lobes(&self, k: usize, means: &Means) -> Decoded {
        self.format.book.decode(&self.one(k)[HEAD..], self.known(k, means))
    }

    fn along_axis(&self, k: usize, means: &Means) -> [Sent; 2] {
        self.format.book.along_axis(&self.one(k)[HEAD..], self.known(k, means))
    }

    fn is_one_sided(&self, k: usize) -> bool {
        self.one(k)[BOTH] == 0
    }
}
