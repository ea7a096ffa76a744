//! Capacities of a picture that imitates a shaded relief: smooth noise at eight scales gives the
//! tone, a second one the creases where neighbours bind less. Bonds grow with the height of what is
//! shown, as the weights of binary shading do.

/// One unit of cost in fixed point.
const UNIT: f32 = 8192.0;
/// How strongly two pixels bind at 480 rows.
const BOND: f32 = 0.15;

/// The capacities of the picture; `rows` is the height at which its forms and bonds are drawn: that of
/// the picture for the same forms at any size, less for more forms of the same size in pixels.
pub(crate) fn relief(width: usize, height: usize, rows: usize) -> (Vec<[i32; 2]>, Vec<[i32; 4]>) {
    let tone = fractal(width, height, rows, 1);
    let crease = fractal(width, height, rows, 2);
    let average = blur(&tone, width, height, rows / 30);
    let bond = BOND * rows as f32 / 480.0;
    let terminal = (0..tone.len())
        .map(|i| {
            let local = (1.2 * (tone[i] - average[i])).clamp(-0.5, 0.5);
            let cost = (UNIT * (0.35 * 2.0 * tone[i] + 0.65 * local)) as i32;
            [cost.max(0), (-cost).max(0)]
        })
        .collect();
    let binding = |i: usize, j: usize, length: f32| {
        let step = (crease[i] - crease[j]).abs() / length * rows as f32 / 480.0;
        let smooth = (-(step / 0.02).powi(2)).exp();
        let apart = if (crease[i] > 0.1) == (crease[j] > 0.1) { 1.0 } else { 0.3 };
        (UNIT * bond / length * (0.1 + 0.9 * smooth * apart)) as i32
    };
    let neighbour = (0..tone.len())
        .map(|i| {
            let other = |dx: isize, dy: usize| {
                let x = (i % width).saturating_add_signed(dx).min(width - 1);
                (i / width + dy).min(height - 1) * width + x
            };
            let diagonal = std::f32::consts::SQRT_2;
            [((1, 0), 1.0), ((1, 1), diagonal), ((0, 1), 1.0), ((-1, 1), diagonal)]
                .map(|((dx, dy), length)| binding(i, other(dx, dy), length))
        })
        .collect();
    (terminal, neighbour)
}

/// Smooth noise at eight scales, from -1 to 1, most of it near 0.
fn fractal(width: usize, height: usize, rows: usize, seed: u32) -> Vec<f32> {
    let mut sum = vec![0.0; width * height];
    for octave in 0..8 {
        let cell = (rows as f32 / 3.0 / 2_f32.powi(octave)).max(2.0);
        let weight = 0.62f32.powi(octave) * 0.9;
        for (i, sum) in sum.iter_mut().enumerate() {
            let (x, y) = ((i % width) as f32 / cell, (i / width) as f32 / cell);
            *sum += weight * smooth_noise(x, y, seed * 8 + octave as u32);
        }
    }
    sum
}

/// Values at whole coordinates, joined by a cubic.
fn smooth_noise(x: f32, y: f32, seed: u32) -> f32 {
    let ease = |t: f32| t * t * (3.0 - 2.0 * t);
    let (fx, fy) = (ease(x.fract()), ease(y.fract()));
    let at = |dx, dy| hash(x as u32 + dx, y as u32 + dy, seed);
    let top = at(0, 0) + fx * (at(1, 0) - at(0, 0));
    let bottom = at(0, 1) + fx * (at(1, 1) - at(0, 1));
    top + fy * (bottom - top)
}

fn hash(x: u32, y: u32, seed: u32) -> f32 {
    let mut h = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca6b) ^ seed << 20;
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    (h ^ (h >> 15)) as f32 / u32::MAX as f32 * 2.0 - 1.0
}

/// The average over a square of `2 radius + 1` pixels, cropped at the border.
fn blur(plane: &[f32], width: usize, height: usize, radius: usize) -> Vec<f32> {
    let row = blur_lines(plane, width, height, radius, |line, at| line * width + at);
    blur_lines(&row, height, width, radius, |line, at| at * width + line)
}

fn blur_lines(
    plane: &[f32],
    length: usize,
    lines: usize,
    radius: usize,
    index: impl Fn(usize, usize) -> usize,
) -> Vec<f32> {
    let mut out = vec![0.0; plane.len()];
    for line in 0..lines {
        let mut sums = vec![0.0; length + 1];
        for at in 0..length {
            sums[at + 1] = sums[at] + plane[index(line, at)];
        }
        for at in 0..length {
            let (low, high) = (at.saturating_sub(radius), (at + radius + 1).min(length));
            out[index(line, at)] = (sums[high] - sums[low]) / (high - low) as f32;
        }
    }
    out
}
