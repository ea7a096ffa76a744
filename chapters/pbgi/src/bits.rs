//! Numbers in few bits: floats in 16, unit vectors, mean normals, colours.
//!
//! Any code gives some finite number, so that bytes from a file need no checks.

use chiaro_basis::math::{Vec3, vec3};

/// A positive number under twice `top` in 16 bits: 64 octaves, ten bits for each; 0 stays 0.
pub(crate) fn float16(value: f32, top: f32) -> u16 {
    rounded16(value / top, 1 << 12)
}

/// The same, never below the value.
pub(crate) fn float16_above(value: f32, top: f32) -> u16 {
    rounded16(value / top, (1 << 13) - 1)
}

/// The exponent of the smallest number.
const LOWEST: u32 = 64;

fn rounded16(value: f32, add: u32) -> u16 {
    if value.is_nan() || value <= 0.0 {
        return 0;
    }
    let code = (value.to_bits().saturating_add(add) >> 13).saturating_sub(LOWEST << 10);
    code.min(65_535) as u16
}

/// The number of a code.
pub(crate) fn from_float16(code: u16, top: f32) -> f32 {
    if code == 0 { 0.0 } else { top * f32::from_bits((u32::from(code) + (LOWEST << 10)) << 13) }
}

/// Shares of red and green in a colour's sum, in so many bits each. Grey keeps its hue, and pure colours theirs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hue {
    bits: u32,
    /// Steps of a share's root up to 1. Of grey, whose shares are 1/3, it is a whole number.
    steps: f32,
    /// The last step is the share 1.
    whole: u32,
    /// The share of each step.
    shares: [f32; 64],
}

impl Hue {
    /// Five or six bits.
    pub(crate) const fn new(bits: u32) -> Self {
        let steps = (36 >> (6 - bits)) as f32 * 1.732_050_8;
        let whole = (1 << bits) - 1;
        let mut shares = [1.0; 64];
        let mut root = 0;
        while root < whole {
            shares[root] = (root * root) as f32 / (steps * steps);
            root += 1;
        }
        Self { bits, steps, whole: whole as u32, shares }
    }

    /// The code of a colour, which is not black.
    fn encode(&self, colour: [f32; 3]) -> u64 {
        let sum: f32 = colour.iter().sum();
        let share = |c: usize| {
            let root = self.steps * (colour[c] / sum).sqrt();
            let last = (self.whole - 1) as f32;
            let past = root > 0.5 * (last + self.steps);
            u64::from(if past { self.whole } else { root.round() as u32 })
        };
        share(0) | share(1) << self.bits
    }

    /// The colour of a code and a sum.
    pub(crate) fn colour(&self, code: u32, sum: f32) -> [f32; 3] {
        let share = |shift: u32| self.shares[(code >> shift & self.whole & 63) as usize];
        let (r, g) = (share(0), share(self.bits));
        let b = (1.0 - r - g).max(0.0);
        let all = sum / (r + g + b);
        [r * all, g * all, b * all]
    }
}

/// What rounding took from the colours before. The next ones make up for it, each by a tenth at most, so
/// that neighbours together keep the strength and the hue of their light, though each is a few percent off.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Carry([f32; 3]);

/// What a colour makes up for at most, over its sum.
const MADE_UP: f32 = 0.1;

impl Carry {
    /// The code of a colour: the step of its sum in `bits`, then its hue. Step 0 is black; `value` is a step's sum.
    pub(crate) fn encode(
        &mut self,
        colour: [f32; 3],
        (hue, bits): (&Hue, u32),
        step: impl Fn(f32) -> u32,
        value: impl Fn(u32) -> f32,
    ) -> u64 {
        let sum: f32 = colour.iter().sum();
        if sum <= 0.0 {
            return 0;
        }
        let most = MADE_UP * sum;
        let wanted = |c: usize| (colour[c] + self.0[c].clamp(-most, most)).max(0.0);
        let wanted: [f32; 3] = std::array::from_fn(wanted);
        let step = step(wanted.iter().sum());
        let shares = if step == 0 { 0 } else { hue.encode(wanted) };
        let coded = hue.colour(shares as u32, value(step));
        (0..3).for_each(|c| self.0[c] += colour[c] - coded[c]);
        u64::from(step) | shares << bits
    }
}

/// A unit vector on a square (Meyer et al. 2010), each coordinate in [-1, 1].
pub(crate) fn octahedral(n: Vec3) -> [f32; 2] {
    let p = n / n.abs().element_sum().max(f32::MIN_POSITIVE);
    let fold = |a: f32, b: f32| (1.0 - b.abs()) * if a >= 0.0 { 1.0 } else { -1.0 };
    if p.z >= 0.0 { [p.x, p.y] } else { [fold(p.x, p.y), fold(p.y, p.x)] }
}

/// The unit vector of a place on the square.
pub(crate) fn from_octahedral([x, y]: [f32; 2]) -> Vec3 {
    let z = 1.0 - x.abs() - y.abs();
    let under = (-z).max(0.0);
    vec3(x - under.copysign(x), y - under.copysign(y), z).normalize_or(Vec3::Z)
}

/// A coordinate in [-1, 1] as one of 2^bits - 1 steps, 0 among them.
pub(crate) fn grid(c: f32, bits: u32) -> u32 {
    let half = ((1u32 << (bits - 1)) - 1) as f32;
    ((c * half).round().clamp(-half, half) + half) as u32
}

/// The coordinate of a step.
pub(crate) fn from_grid(code: u32, bits: u32) -> f32 {
    let half = ((1u32 << (bits - 1)) - 1) as f32;
    (code as f32 - half) / half
}

/// A mean normal in 32 bits: its length is finest near 1, where nodes are flat.
pub(crate) fn encode_axis(axis: Vec3) -> u32 {
    let length = axis.length().min(1.0);
    let [x, y] = octahedral(axis.normalize_or(Vec3::Z)).map(|c| grid(c, 12));
    let short = (255.0 * (1.0 - length).sqrt()).round() as u32;
    x | y << 12 | short << 24
}

/// The mean normal of a code.
pub(crate) fn axis_of(code: u32) -> Vec3 {
    let at = |shift: u32| from_grid(code >> shift & 0xfff, 12);
    let short = (code >> 24) as f32 / 255.0;
    from_octahedral([at(0), at(12)]) * (1.0 - short * short)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random::unit;

    #[test]
    fn sixteen_bits_keep_ten_of_each_octave() {
        for i in 0..2000 {
            let value = 1e-9 * 1.02f32.powi(i);
            let top = 1e9;
            let back = from_float16(float16(value, top), top);
            assert!((back / value - 1.0).abs() < 6e-4, "{value} {back}");
            assert!(from_float16(float16_above(value, top), top) >= value);
        }
        assert_eq!(from_float16(float16(0.0, 1.0), 1.0), 0.0);
        assert_eq!(from_float16(float16(f32::NAN, 1.0), 1.0), 0.0);
    }

    #[test]
    fn unit_vectors_and_colours_come_back() {
        for i in 0..500 {
            let v = |k| vec3(unit(k, i) - 0.5, unit(k + 1, i) - 0.5, unit(k + 2, i) - 0.5);
            let n = v(1).normalize();
            assert!(from_octahedral(octahedral(n)).distance(n) < 1e-5);
            let colour = [unit(5, i), unit(6, i), unit(7, i)];
            let sum: f32 = colour.iter().sum();
            for (bits, most) in [(6, 0.02), (5, 0.04)] {
                let hue = Hue::new(bits);
                let back = hue.colour(hue.encode(colour) as u32, sum);
                assert!((0..3).all(|c| (back[c] - colour[c]).abs() < most * sum), "{back:?}");
            }
        }
    }

    #[test]
    fn grey_stays_grey_and_pure_colours_stay_pure() {
        for i in 0..200 {
            let light = unit(3, i);
            for hue in [Hue::new(5), Hue::new(6)] {
                let coded = |colour| hue.colour(hue.encode(colour) as u32, light);
                let [r, g, b] = coded([light; 3]);
                assert!((r - b).abs() < 1e-5 * r && (g - b).abs() < 1e-5 * g, "{r} {g} {b}");
                for c in 0..3 {
                    let mut pure = [0.0; 3];
                    pure[c] = light;
                    let back = coded(pure);
                    assert!((0..3).all(|k| (back[k] > 0.0) == (k == c)), "{back:?}");
                }
            }
        }
    }

    #[test]
    fn neighbours_together_keep_their_light() {
        let hue = Hue::new(5);
        // Eight steps an octave.
        let (step, value) =
            (|s: f32| (80.0 + 8.0 * s.log2()).round() as u32, |s| (s as f32 / 8.0 - 10.0).exp2());
        for i in 0..200 {
            let base = [unit(4, i), unit(5, i), unit(6, i)];
            let (mut carry, mut sums) = (Carry::default(), [[0.0f32; 3]; 2]);
            for k in 0..16 {
                let shade = 1.0 + 0.2 * unit(7, 16 * i + k);
                let colour = base.map(|b| b * shade);
                let code = carry.encode(colour, (&hue, 8), step, value) as u32;
                let coded = hue.colour(code >> 8, value(code & 255));
                (0..3).for_each(|c| sums[0][c] += colour[c]);
                (0..3).for_each(|c| sums[1][c] += coded[c]);
            }
            let all: f32 = sums[0].iter().sum();
            assert!((0..3).all(|c| (sums[0][c] - sums[1][c]).abs() < 0.008 * all), "{sums:?}");
        }
        assert_eq!(Carry([0.05; 3]).encode([0.0; 3], (&hue, 8), step, value), 0);
    }
}
