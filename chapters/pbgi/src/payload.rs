//! What a node stores of the light of its surfels: [`Payload`], a type parameter of the tree.
//!
//! The gather asks a payload for two things in a direction: the area that is seen and the radiance
//! times area that is sent. [`Exact`] keeps both as spherical harmonics in single precision, the
//! sums over all surfels of the subtree: 36 numbers, the thesis's 27 and the 9 of the area.

use crate::harmonic::{self, Sh};
use crate::surfel::Surfel;

/// Area seen, and radiance times area, in one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sent {
    /// In scene units squared; may be negative, since the series is short.
    pub area: f32,
    /// Linear RGB radiance times scene units squared.
    pub light: [f32; 3],
}

/// What a node stores.
pub trait Payload: Copy + Send + Sync {
    /// What all nodes share, such as a table of code words.
    type Book: Sync;

    /// The area that is seen and the light that is sent in the direction of `basis`.
    fn sent(&self, book: &Self::Book, basis: &Sh) -> Sent;

    /// The same, and what is sent in the opposite direction.
    fn both(&self, book: &Self::Book, basis: &Sh) -> [Sent; 2];
}

/// The sums themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exact {
    /// The area's coefficients.
    pub area: Sh,
    /// Those of radiance times area, for red, green and blue.
    pub light: [Sh; 3],
}

impl Exact {
    /// Adds the lobes of a surfel's living sides.
    pub fn add(&mut self, surfel: &Surfel) {
        for side in (0..2).filter(|s| surfel.alive[*s]) {
            let normal = if side == 0 { surfel.normal } else { -surfel.normal };
            let lobe = harmonic::disc(normal, surfel.area);
            for (i, value) in lobe.into_iter().enumerate() {
                self.area[i] += value;
                for c in 0..3 {
                    self.light[c][i] += surfel.radiance[side][c] * value;
                }
            }
        }
    }

    /// The sum of two nodes.
    pub fn plus(&self, other: &Self) -> Self {
        let sum = |a: &Sh, b: &Sh| std::array::from_fn(|i| a[i] + b[i]);
        Self {
            area: sum(&self.area, &other.area),
            light: std::array::from_fn(|c| sum(&self.light[c], &other.light[c])),
        }
    }
}

impl Exact {
    /// What is sent in the direction of `basis`, and in the opposite one.
    pub(crate) fn sent_both(&self, basis: &Sh) -> [Sent; 2] {
        let [a, a_behind] = harmonic::evaluate_both(&self.area, basis);
        let [r, g, b] = self.light.each_ref().map(|c| harmonic::evaluate_both(c, basis));
        [
            Sent { area: a, light: [r[0], g[0], b[0]] },
            Sent { area: a_behind, light: [r[1], g[1], b[1]] },
        ]
    }
}

impl Payload for Exact {
    type Book = ();

    fn both(&self, (): &(), basis: &Sh) -> [Sent; 2] {
        self.sent_both(basis)
    }

    fn sent(&self, (): &(), basis: &Sh) -> Sent {
        Sent {
            area: harmonic::evaluate(&self.area, basis),
            light: [0, 1, 2].map(|c| harmonic::evaluate(&self.light[c], basis)),
        }
    }
}
