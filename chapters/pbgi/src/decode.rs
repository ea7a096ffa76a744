//! Reading a node's code ([`Book`]): its lobes, or what they send along its mean normal alone.
//!
//! A flat node is told by what it sends ahead and behind ([`harmonic::front_of_flat`]). Its area there follows from
//! the mean normal, so that only its light is read: most of what a gather sees in rooms and cities.

use crate::bits::from_float16;
use crate::code::{AREA, Book, Gains, LIGHT, expected, frame};
use crate::harmonic::{self, Sh};
use crate::payload::{Exact, Sent};
use crate::recipe::word_bytes;
use chiaro_basis::math::{Mat3, Vec3};

/// Lobes in the frame of their node.
#[derive(Clone, Copy, Debug, Default)]
pub struct Decoded {
    /// Turns directions of the world into the lobes' frame, where they are turned.
    pub local_from_world: Option<Mat3>,
    /// The sums.
    pub lobes: Exact,
}

impl Decoded {
    fn basis(&self, direction: Vec3) -> Sh {
        harmonic::basis(self.local_from_world.map_or(direction, |m| m * direction))
    }

    /// What is seen and sent in a direction of the world, and in the opposite one.
    pub fn both(&self, direction: Vec3) -> [Sent; 2] {
        self.lobes.sent_both(&self.basis(direction))
    }

    /// What is seen and sent in a direction of the world.
    pub fn sent(&self, direction: Vec3) -> Sent {
        let basis = self.basis(direction);
        Sent {
            area: harmonic::evaluate(&self.lobes.area, &basis),
            light: [0, 1, 2].map(|c| harmonic::evaluate(&self.lobes.light[c], &basis)),
        }
    }
}

/// The numbers of a code, one after the other.
struct Numbers<'a>(&'a [u8]);

impl Numbers<'_> {
    /// The next number, of one byte or of two.
    #[inline]
    fn next(&mut self, bytes: usize) -> usize {
        match (bytes, self.0) {
            (1, [a, rest @ ..]) => {
                self.0 = rest;
                usize::from(*a)
            }
            (2, [a, b, rest @ ..]) => {
                self.0 = rest;
                usize::from(u16::from_le_bytes([*a, *b]))
            }
            _ => 0,
        }
    }
}

impl Book {
    /// The lobes of a code. Known beside it: the node's area, its mean normal, the share of the area both of whose
    /// sides live.
    pub fn decode(&self, code: &[u8], (area, axis, both): (f32, Vec3, f32)) -> Decoded {
        let recipe = &self.recipe;
        let mut numbers = Numbers(code);
        let (gains, light) = self.light(&mut numbers);
        let frame = recipe.turned.then(|| frame(axis));
        let mut disc = expected(recipe, axis, both, frame.as_ref());
        for (table, words) in self.area.iter().zip(&recipe.area) {
            table.add(numbers.next(word_bytes(*words)), &mut disc);
        }
        let scale = if recipe.by_area { area } else { 1.0 };
        let lobes = Exact {
            area: disc.map(|a| a * scale),
            light: std::array::from_fn(|c| {
                let (own, gain) = (self.colour(&light, c), gains[c] * scale);
                own.map(|value| value * gain)
            }),
        };
        let local_from_world = frame.map(|f| f.transpose());
        Decoded { local_from_world, lobes }
    }

    /// What a code's lobes send along the mean normal and against it, where the area is what the mean normal tells.
    pub(crate) fn along_axis(
        &self,
        code: &[u8],
        (area, axis, both): (f32, Vec3, f32),
    ) -> [Sent; 2] {
        if !self.recipe.by_area {
            return self.decode(code, (area, axis, both)).both(axis.normalize_or(Vec3::Z));
        }
        let (gains, light) = self.light(&mut Numbers(code));
        let length = axis.length();
        let ahead = if self.recipe.turned || length == 0.0 { Vec3::Z } else { axis / length };
        let basis = harmonic::basis(ahead);
        let told = harmonic::expected_along(length, both);
        let sent: [[f32; 2]; 3] = std::array::from_fn(|c| {
            let along = harmonic::evaluate_both(&self.colour(&light, c), &basis);
            along.map(|value| value * gains[c] * area)
        });
        std::array::from_fn(|k| Sent { area: told[k] * area, light: sent.map(|both| both[k]) })
    }

    /// The gains of a code's colours, and the sum of its words of light.
    #[inline]
    fn light(&self, numbers: &mut Numbers) -> ([f32; 3], [f32; LIGHT]) {
        let mut gain = || from_float16(numbers.next(2) as u16, self.top);
        let gains = match self.recipe.gains {
            Gains::None => [1.0; 3],
            Gains::One => [gain(); 3],
            Gains::Colours | Gains::Shape => [gain(), gain(), gain()],
        };
        let mut light = [0.0f32; LIGHT];
        for (table, words) in self.light.iter().zip(&self.recipe.light) {
            table.add(numbers.next(word_bytes(*words)), &mut light);
        }
        (gains, light)
    }

    /// A colour's part of a sum of words.
    #[inline]
    fn colour(&self, light: &[f32; LIGHT], c: usize) -> Sh {
        let at = if self.recipe.gains == Gains::Shape { 0 } else { AREA * c };
        std::array::from_fn(|i| light[at + i])
    }
}

#[cfg(test)]
mod tests {
    use crate::code::tests::{lobes, nodes};
    use crate::code::{Book, Gains, Pen, Recipe};
    use chiaro_basis::Run;

    #[test]
    fn along_the_mean_normal_light_is_that_of_the_lobes() {
        let all = nodes(400);
        for recipe in [
            Recipe::residual(Gains::One, false, 2, 0),
            Recipe::residual(Gains::Colours, true, 2, 0),
            Recipe::clusters(64),
            Recipe::raw(64),
        ] {
            let book = Book::train(&lobes(&all), &recipe, 1, &Run::default()).unwrap();
            for node in lobes(&all) {
                let mut code = Vec::new();
                book.encode(&node, &mut code, &mut Pen::default());
                let known = (node.area, node.axis, node.both);
                let whole = book.decode(&code, known).both(node.axis.normalize());
                for (a, b) in book.along_axis(&code, known).iter().zip(&whole) {
                    let near = |a: f32, b: f32| (a - b).abs() <= 1e-4 * (1.0 + b.abs());
                    assert!((0..3).all(|c| near(a.light[c], b.light[c])), "{a:?} {b:?}");
                    assert!(!recipe.area.is_empty() || near(a.area, b.area), "{a:?} {b:?}");
                }
            }
        }
    }
}
