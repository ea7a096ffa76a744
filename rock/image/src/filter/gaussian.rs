//! Gaussian averages over the covered pixels of a plane.
//!
//! A masked average is *normalized convolution* (Knutsson and Westin 1993): values times coverage,
//! and coverage itself, are filtered alike, and the quotient is the average. Hence every weight
//! must be positive, also far out, which excludes recursive filters: theirs ring around zero.
//!
//! 1. Up to a sigma of 4 pixels the plane is convolved, first along x, then along y, with a sampled
//!    Gaussian that is cut off past 4 sigma and stretched so that its variance is sigma^2.
//! 2. For more, the plane is gathered onto a grid coarser by f = ceil(sigma / 4) with quadratic
//!    B-splines, convolved there, and spread back with the same splines. Their first three moments
//!    do not depend on where a pixel falls in its cell, and two of them add f^2 / 2 to the
//!    variance, so the coarse kernel has sigma^2 / f^2 - 1 / 2 and the whole again sigma^2.
//!
//! Guaranteed: weights that are never negative, a variance of sigma^2 and, past a sigma of 1, the
//! weights of a Gaussian to 0.5 % of their peak; a cost per pixel that stops growing at sigma 4;
//! the same bytes for any number of threads. Not guaranteed: weights past 4 sigma, which are zero
//! or small.

use crate::{Plane, Runs};
use chiaro_basis::widely;
use rayon::prelude::*;
use std::ops::Range;

/// The largest sigma that is convolved at full size, in pixels.
pub(super) const FINE_SIGMA: f64 = 4.0;

/// The Gaussian average of the covered pixels around each pixel; `sigma` is the standard deviation
/// in pixels.
///
/// Pixels that are not covered get the average of the covered ones in reach, or 0 where none is.
/// Covered values that are not finite count as uncovered. A sigma of 0 or less averages nothing.
/// Panics when the sizes differ.
pub fn gaussian_masked(plane: &Plane<f32>, mask: &Plane<bool>, sigma: f32) -> Plane<f32> {
    let have = Runs::of(mask);
    let reach = reach(sigma);
    let want = have.grown(reach, reach);
    average(plane, mask, sigma, (&have, &want))
}

/// [`gaussian_masked`] where pixels are covered; what it is elsewhere is not said. Half-empty
/// pictures take half the time.
pub fn gaussian_covered(plane: &Plane<f32>, mask: &Plane<bool>, sigma: f32) -> Plane<f32> {
    let runs = Runs::of(mask);
    average(plane, mask, sigma, (&runs, &runs))
}

fn average(plane: &Plane<f32>, mask: &Plane<bool>, sigma: f32, runs: (&Runs, &Runs)) -> Plane<f32> {
    assert_eq!(plane.size(), mask.size(), "a mask has the size of its plane");
    let line = |y: usize, run: Range<usize>, out: &mut [[f32; 2]]| {
        let row = plane.row(y)[run.clone()].iter().zip(&mask.row(y)[run]);
        for (out, (&v, &covered)) in out.iter_mut().zip(row) {
            *out = if covered && v.is_finite() { [v, 1.0] } else { [0.0; 2] };
        }
    };
    let finish = |&[sum, weight]: &[f32; 2]| if weight > 0.0 { sum / weight } else { 0.0 };
    blur(runs, sigma, line, finish)
}

/// Pixels past which nothing is averaged.
fn reach(sigma: f32) -> usize {
    // A coarse grid adds its splines' width on either side, less than 2 cells of sigma / 3 in all.
    if sigma > 0.0 { (6.0 * sigma.min(1e6)).ceil() as usize + 2 } else { 0 }
}

/// `finish` of the Gaussian convolution of what `line` fills in run by run and is zero elsewhere.
/// `have` are the runs that are filled in, `want` those that are asked for; elsewhere the result is
/// `finish` of nothing.
fn blur<const C: usize, T: Clone + Send>(
    (have, want): (&Runs, &Runs),
    sigma: f32,
    line: impl Fn(usize, Range<usize>, &mut [[f32; C]]) + Sync,
    finish: impl Fn(&[f32; C]) -> T + Sync,
) -> Plane<T> {
    // A standard deviation of a million pixels is flat on any picture.
    let sigma = if sigma > 0.0 { f64::from(sigma).min(1e6) } else { 0.0 };
    if sigma == 0.0 {
        return finished(have, |y, run, sums| line(y, run, sums), finish);
    }
    if sigma <= FINE_SIGMA {
        return convolved((have, want), &gaussian_taps(sigma * sigma), line, finish);
    }
    let (coarse, factor) = coarse((have, want), sigma, line);
    spread(&coarse, factor, want, finish)
}

/// The convolution with a Gaussian over [`FINE_SIGMA`] on a coarser grid, and how much coarser that is.
pub(super) fn coarse<const C: usize>(
    (have, want): (&Runs, &Runs),
    sigma: f64,
    line: impl Fn(usize, Range<usize>, &mut [[f32; C]]) + Sync,
) -> (Plane<[f32; C]>, usize) {
    let factor = (sigma / FINE_SIGMA).ceil();
    let taps = gaussian_taps((sigma / factor).powi(2) - 0.5);
    let factor = factor as usize;
    let gathered = gather(have, factor, line);
    let line = |y: usize, run: Range<usize>, out: &mut [[f32; C]]| {
        out.copy_from_slice(&gathered.row(y)[run]);
    };
    let (from, to) = (coarser(have, factor), coarser(want, factor));
    (convolved((&from, &to), &taps, line, |sum| *sum), factor)
}

/// The taps at 0, 1, 2, ... of a Gaussian cut off past four standard deviations, scaled so that
/// all taps, both sides counted, sum to 1. The width of the bell is found by bisection so that the
/// variance of the taps, as sampled and cut, is `variance`.
pub(super) fn gaussian_taps(variance: f64) -> Vec<f32> {
    let radius = (4.0 * variance.sqrt()).ceil() as usize;
    let (mut narrow, mut wide) = (0.0, 1.5 * variance.sqrt() + 0.5);
    for _ in 0..50 {
        let middle = 0.5 * (narrow + wide);
        if variance_of(&bell(middle, radius)) < variance { narrow = middle } else { wide = middle }
    }
    bell(wide, radius).iter().map(|tap| *tap as f32).collect()
}

fn bell(width: f64, radius: usize) -> Vec<f64> {
    let height = |n: usize| (-0.5 * (n as f64 / width).powi(2)).exp();
    let taps: Vec<f64> = (0..=radius).map(height).collect();
    let sum = taps[0] + 2.0 * taps[1..].iter().sum::<f64>();
    taps.iter().map(|tap| tap / sum).collect()
}

fn variance_of(taps: &[f64]) -> f64 {
    taps.iter().enumerate().map(|(n, tap)| 2.0 * tap * (n * n) as f64).sum()
}

/// `finish` of the convolution with symmetric `taps`, along x and then along y, in single precision.
fn convolved<const C: usize, T: Clone + Send>(
    (have, want): (&Runs, &Runs),
    taps: &[f32],
    line: impl Fn(usize, Range<usize>, &mut [[f32; C]]) + Sync,
    finish: impl Fn(&[f32; C]) -> T + Sync,
) -> Plane<T> {
    let radius = taps.len() - 1;
    let along_x = convolved_along_x((have, &want.grown(0, radius)), taps, line);
    let along_y = |y: usize, run: Range<usize>, sums: &mut [[f32; C]]| {
        convolve_along_y(&along_x, taps, (y, run), sums.as_flattened_mut());
    };
    finished(want, along_y, finish)
}

/// The convolution with symmetric `taps` along x of the runs that `line` fills in.
pub(super) fn convolved_along_x<const C: usize>(
    (have, want): (&Runs, &Runs),
    taps: &[f32],
    line: impl Fn(usize, Range<usize>, &mut [[f32; C]]) + Sync,
) -> Plane<[f32; C]> {
    let (width, height) = have.size();
    let radius = (taps.len() - 1).min(width);
    let mut sums = vec![[0.0; C]; width * height];
    sums.par_chunks_mut(width.max(1)).enumerate().for_each_init(
        || vec![[0.0; C]; width + 2 * radius],
        |row, (y, sums)| {
            let inside = &mut row[radius..][..width];
            let mut any = false;
            for run in have.row(y) {
                line(y, run.clone(), &mut inside[run]);
                any = true;
            }
            if !any {
                return;
            }
            let values = row.as_flattened();
            for run in want.row(y) {
                let at = |x: usize| &values[x * C..(x + run.len()) * C];
                let sums = sums[run.clone()].as_flattened_mut();
                let middle = run.start + radius;
                add_scaled(sums, at(middle), taps[0]);
                for (n, &tap) in taps.iter().enumerate().skip(1).take_while(|(n, _)| *n < width) {
                    add_both(sums, [at(middle - n), at(middle + n)], tap);
                }
            }
            have.row(y).for_each(|run| row[radius..][run].fill([0.0; C]));
        },
    );
    Plane::from_pixels(width, height, sums)
}

/// Adds a run of row `y` of the convolution with symmetric `taps` along y.
pub(super) fn convolve_along_y<const C: usize>(
    plane: &Plane<[f32; C]>,
    taps: &[f32],
    (y, run): (usize, Range<usize>),
    sums: &mut [f32],
) {
    let row = |y: usize| plane.row(y)[run.clone()].as_flattened();
    add_scaled(sums, row(y), taps[0]);
    for (n, &tap) in taps.iter().enumerate().skip(1) {
        match (y.checked_sub(n), Some(y + n).filter(|&y| y < plane.height())) {
            (Some(above), Some(below)) => add_both(sums, [row(above), row(below)], tap),
            (None, None) => break,
            (above, below) => {
                above.or(below).into_iter().for_each(|y| add_scaled(sums, row(y), tap))
            }
        }
    }
}

/// `sum += weight * values`, as far as both reach, in the widest vectors that the machine has.
fn add_scaled(sum: &mut [f32], values: &[f32], weight: f32) {
    widely(add_scaled_plainly, (sum, values, weight));
}

/// [`add_scaled`] of the first values and then of the second.
fn add_both(sum: &mut [f32], values: [&[f32]; 2], weight: f32) {
    widely(add_both_plainly, (sum, values, weight));
}

#[inline(always)]
fn add_scaled_plainly((sum, values, weight): (&mut [f32], &[f32], f32)) {
    for (s, v) in sum.iter_mut().zip(values) {
        *s += weight * v;
    }
}

#[inline(always)]
fn add_both_plainly((sum, [first, second], weight): (&mut [f32], [&[f32]; 2], f32)) {
    for ((s, a), b) in sum.iter_mut().zip(first).zip(second) {
        *s = *s + weight * a + weight * b;
    }
}

/// A plane whose runs are summed in parallel, from zero, by `sum`, and then finished.
fn finished<const C: usize, T: Clone + Send>(
    want: &Runs,
    sum: impl Fn(usize, Range<usize>, &mut [[f32; C]]) + Sync,
    finish: impl Fn(&[f32; C]) -> T + Sync,
) -> Plane<T> {
    let (width, height) = want.size();
    let mut pixels = vec![finish(&[0.0; C]); width * height];
    pixels.par_chunks_mut(width.max(1)).enumerate().for_each_init(
        || vec![[0.0; C]; width],
        |sums, (y, row)| {
            for run in want.row(y) {
                let sums = &mut sums[run.clone()];
                sums.fill([0.0; C]);
                sum(y, run.clone(), sums);
                for (pixel, sum) in row[run].iter_mut().zip(sums.iter()) {
                    *pixel = finish(sum);
                }
            }
        },
    );
    Plane::from_pixels(width, height, pixels)
}

/// The first of three cells, and a pixel's weights in them.
pub(super) type Cells = (usize, [f32; 3]);

/// Where pixel `x` falls on a grid coarser by `factor`, and its three quadratic B-spline weights.
/// The grid begins one cell before the picture and ends one cell after it.
fn cells(x: usize, factor: usize) -> Cells {
    let first = x / factor;
    let offset = ((x % factor) as f64 + 0.5) / factor as f64 - 0.5;
    let weights =
        [0.5 * (0.5 - offset).powi(2), 0.75 - offset * offset, 0.5 * (0.5 + offset).powi(2)];
    (first, weights.map(|w| w as f32))
}

/// Cells that a side of `length` pixels needs.
fn cell_count(length: usize, factor: usize) -> usize {
    length.div_ceil(factor) + 2
}

/// [`cells`] of a row of pixels.
pub(super) fn cells_of(length: usize, factor: usize) -> Vec<Cells> {
    (0..length).map(|x| cells(x, factor)).collect()
}

/// The cells that runs of pixels fall on.
fn coarser(runs: &Runs, factor: usize) -> Runs {
    let (width, height) = runs.size();
    let size = (cell_count(width, factor), cell_count(height, factor));
    let row = |run: Range<usize>| run.start / factor..(run.end - 1) / factor + 3;
    runs.mapped(size, |y| y / factor..y / factor + 3, row)
}

/// Gathers runs onto the grid coarser by `factor`: the transpose of [`spread`].
fn gather<const C: usize>(
    have: &Runs,
    factor: usize,
    line: impl Fn(usize, Range<usize>, &mut [[f32; C]]) + Sync,
) -> Plane<[f32; C]> {
    let (width, height) = have.size();
    let columns = cells_of(width, factor);
    let across = cell_count(width, factor);
    let mut along_x = vec![[0.0; C]; across * height];
    along_x.par_chunks_mut(across).enumerate().for_each_init(
        || vec![[0.0; C]; width],
        |row, (y, out)| {
            for run in have.row(y) {
                line(y, run.clone(), &mut row[run.clone()]);
                add_to_cells(out, &row[run.clone()], &columns[run]);
            }
        },
    );
    let along_x = Plane::from_pixels(across, height, along_x);
    let down = |cell: usize, run: Range<usize>, sums: &mut [[f32; C]]| {
        let rows = (cell.saturating_sub(2) * factor)..((cell + 1) * factor).min(height);
        for y in rows {
            let (first, weights) = cells(y, factor);
            let from = along_x.row(y)[run.clone()].as_flattened();
            add_scaled(sums.as_flattened_mut(), from, weights[cell - first]);
        }
    };
    finished(&coarser(have, factor), down, |sum| *sum)
}

/// Adds neighbouring pixels to the cells that they fall on, in their order. A pixel's three cells are kept
/// at hand, since the next one adds to the same, or to these but one.
fn add_to_cells<const C: usize>(cells: &mut [[f32; C]], pixels: &[[f32; C]], columns: &[Cells]) {
    let Some(&(mut at, _)) = columns.first() else { return };
    let mut sums = [cells[at], cells[at + 1], cells[at + 2]];
    for (pixel, &(first, weights)) in pixels.iter().zip(columns) {
        if first != at {
            cells[at] = sums[0];
            sums = [sums[1], sums[2], cells[first + 2]];
            at = first;
        }
        for (sum, weight) in sums.iter_mut().zip(weights) {
            for (sum, v) in sum.iter_mut().zip(pixel) {
                *sum += weight * v;
            }
        }
    }
    cells[at..at + 3].copy_from_slice(&sums);
}

/// Spreads a coarse plane back over runs of pixels, finished one by one.
fn spread<const C: usize, T: Clone + Send>(
    coarse: &Plane<[f32; C]>,
    factor: usize,
    want: &Runs,
    finish: impl Fn(&[f32; C]) -> T + Sync,
) -> Plane<T> {
    let (width, height) = want.size();
    let columns = cells_of(width, factor);
    let mut pixels = vec![finish(&[0.0; C]); width * height];
    pixels.par_chunks_mut(width.max(1)).enumerate().for_each_init(
        || vec![[0.0; C]; coarse.width()],
        |line, (y, row)| {
            for run in want.row(y) {
                let columns = &columns[run.clone()];
                let sums = spread_row((coarse, factor), y, columns, line);
                row[run].iter_mut().zip(sums).for_each(|(pixel, sum)| *pixel = finish(&sum));
            }
        },
    );
    Plane::from_pixels(width, height, pixels)
}

/// What a coarse plane spreads to a run of row `y`, of which `columns` are the cells; `line` is as wide as
/// that plane.
#[inline(always)]
pub(super) fn spread_row<'a, const C: usize>(
    (coarse, factor): (&Plane<[f32; C]>, usize),
    y: usize,
    columns: &'a [Cells],
    line: &'a mut [[f32; C]],
) -> impl Iterator<Item = [f32; C]> + 'a {
    // Each pixel is gathered with weights that sum to 1 and spread over factor^2 pixels.
    let scale = 1.0 / (factor * factor) as f32;
    let (first, weights) = cells(y, factor);
    let cells = columns[0].0..columns[columns.len() - 1].0 + 3;
    line[cells.clone()].fill([0.0; C]);
    for (cell, weight) in (first..).zip(weights) {
        let from = coarse.row(cell)[cells.clone()].as_flattened();
        add_scaled(line[cells.clone()].as_flattened_mut(), from, weight * scale);
    }
    let line = &*line;
    columns.iter().map(move |(first, [a, b, c])| {
        let cells = &line[*first..*first + 3];
        std::array::from_fn(|i| a * cells[0][i] + b * cells[1][i] + c * cells[2][i])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random;

    fn disc(width: usize, height: usize) -> Plane<bool> {
        let (cx, cy) = (width as f32 * 0.45, height as f32 * 0.5);
        let radius = 0.4 * width.min(height) as f32;
        Plane::from_fn(width, height, |x, y| (x as f32 - cx).hypot(y as f32 - cy) < radius)
    }

    fn noise(width: usize, height: usize) -> Plane<f32> {
        Plane::from_fn(width, height, |x, y| random::unit(3, (y * width + x) as u64))
    }

    #[test]
    fn wide_vectors_give_the_same_bytes() {
        let values: Vec<f32> = (0..103).map(|i| random::unit(4, i) - 0.5).collect();
        let (mut wide, mut plain) = (values.clone(), values.clone());
        add_scaled(&mut wide[2..], &values, 0.37);
        add_scaled_plainly((&mut plain[2..], &values, 0.37));
        assert_eq!(wide, plain);
        add_both(&mut wide, [&values[3..], &values[1..]], 0.23);
        add_scaled_plainly((&mut plain[..100], &values[3..], 0.23));
        add_scaled_plainly((&mut plain[..100], &values[1..101], 0.23));
        assert_eq!(wide[..100], plain[..100]);
    }

    /// The plain convolution of a plane.
    fn response(plane: &Plane<[f32; 1]>, sigma: f32) -> Plane<[f32; 1]> {
        let line = |y: usize, run: Range<usize>, out: &mut [[f32; 1]]| {
            out.copy_from_slice(&plane.row(y)[run]);
        };
        let runs = Runs::everywhere(plane.size());
        blur((&runs, &runs), sigma, line, |v| *v)
    }

    /// Weight, mean and variance along x of the response to an impulse at (x, y).
    fn moments(sigma: f32, side: usize, x: usize, y: usize) -> (f64, f64, f64) {
        let mut impulse = Plane::filled(side, side, [0.0]);
        impulse[(x, y)] = [1.0];
        let response = response(&impulse, sigma);
        let mut m = [0.0f64; 3];
        for (i, [v]) in response.pixels().iter().enumerate() {
            assert!(*v >= 0.0);
            let d = (i % side) as f64 - x as f64;
            for (k, m) in m.iter_mut().enumerate() {
                *m += f64::from(*v) * d.powi(k as i32);
            }
        }
        (m[0], m[1] / m[0], m[2] / m[0] - (m[1] / m[0]).powi(2))
    }

    #[test]
    fn an_impulse_keeps_its_weight_and_place_and_gains_sigma_squared() {
        for (sigma, x) in
            [(0.3, 9), (0.5, 9), (1.0, 20), (2.5, 30), (4.0, 40), (4.1, 53), (6.0, 64), (11.0, 131)]
        {
            let side = 2 * x + 17;
            let (weight, mean, variance) = moments(sigma, side, x, side / 2);
            let t = f64::from(sigma).powi(2);
            assert!((weight - 1.0).abs() < 2e-3, "sigma {sigma}: weight {weight}");
            assert!(mean.abs() < 0.01 * f64::from(sigma), "sigma {sigma}: mean {mean}");
            assert!((variance / t - 1.0).abs() < 1e-3, "sigma {sigma}: {variance} for {t}");
        }
    }

    #[test]
    fn coarse_weights_are_a_gaussians_wherever_the_pixel_falls() {
        let side = 161;
        for (sigma, x) in
            [(1.0f64, 80), (4.0, 80), (4.1, 80), (4.1, 81), (10.0, 79), (10.0, 80), (10.0, 81)]
        {
            let mut impulse = Plane::filled(side, 1, [0.0]);
            impulse[(x, 0)] = [1.0];
            let response = response(&impulse, sigma as f32);
            let sum: f64 = response.pixels().iter().map(|[v]| f64::from(*v)).sum();
            let peak = 1.0 / (sigma * std::f64::consts::TAU.sqrt());
            for (i, [v]) in response.pixels().iter().enumerate() {
                let d = (i as f64 - x as f64) / sigma;
                let wanted = peak * (-0.5 * d * d).exp();
                let error = (f64::from(*v) / sum - wanted).abs() / peak;
                assert!(error < 0.005, "sigma {sigma}: {error} at {i} from {x}");
            }
        }
    }

    #[test]
    fn the_average_of_a_constant_is_the_constant_up_to_the_mask() {
        let mask = disc(90, 70);
        for sigma in [0.4, 1.5, 4.0, 7.0, 40.0, 5000.0] {
            let plane = Plane::from_fn(90, 70, |x, y| if mask[(x, y)] { 0.7 } else { f32::NAN });
            let average = gaussian_masked(&plane, &mask, sigma);
            for (v, covered) in average.pixels().iter().zip(mask.pixels()) {
                assert!(!covered || (v - 0.7).abs() < 1e-5, "sigma {sigma}: {v}");
            }
        }
    }

    #[test]
    fn a_ramp_stays_a_ramp_away_from_the_border() {
        let plane = Plane::from_fn(400, 9, |x, _| x as f32);
        let mask = Plane::filled(400, 9, true);
        for sigma in [2.0, 9.0, 20.0] {
            let average = gaussian_masked(&plane, &mask, sigma);
            for x in 100..300 {
                assert!((average[(x, 4)] - x as f32).abs() < 0.1, "sigma {sigma} at {x}");
            }
        }
    }

    #[test]
    fn a_very_wide_average_is_the_mean() {
        let (plane, mask) = (noise(40, 30), disc(40, 30));
        let average = gaussian_masked(&plane, &mask, f32::INFINITY);
        let covered = plane.pixels().iter().zip(mask.pixels()).filter(|(_, c)| **c);
        let (sum, count) = covered.fold((0.0, 0.0), |(s, n), (v, _)| (s + v, n + 1.0));
        assert!(average.pixels().iter().all(|v| (v - sum / count).abs() < 1e-4));
    }

    #[test]
    fn what_is_left_out_was_nothing() {
        // Two small things in a large picture, and the same pixels when every row counts.
        let (w, h) = (300, 90);
        let mask = Plane::from_fn(w, h, |x, y| {
            (40..60).contains(&x) && (20..31).contains(&y) || (x, y) == (211, 70)
        });
        let plane = noise(w, h);
        for sigma in [0.0, 0.8, 3.9, 4.6, 11.0, 60.0] {
            let all = Runs::everywhere((w, h));
            let whole = average(&plane, &mask, sigma, (&all, &all));
            assert_eq!(gaussian_masked(&plane, &mask, sigma).pixels(), whole.pixels(), "{sigma}");
            let covered = gaussian_covered(&plane, &mask, sigma);
            let pixels = covered.pixels().iter().zip(whole.pixels()).zip(mask.pixels());
            assert!(pixels.filter(|(_, m)| **m).all(|((a, b), _)| a == b), "{sigma}");
        }
    }

    #[test]
    fn nothing_is_averaged_at_sigma_zero_and_nothing_in_no_picture() {
        let (plane, mask) = (noise(8, 6), Plane::filled(8, 6, true));
        assert_eq!(gaussian_masked(&plane, &mask, 0.0), plane);
        assert_eq!(gaussian_masked(&plane, &mask, f32::NAN), plane);
        let none = Plane::filled(0, 0, 0.0);
        assert!(gaussian_masked(&none, &none.map(|_| true), 9.0).is_empty());
        let bare = gaussian_masked(&plane, &Plane::filled(8, 6, false), 3.0);
        assert!(bare.pixels().iter().all(|v| *v == 0.0));
    }

    #[test]
    fn the_bytes_do_not_depend_on_threads() {
        let (plane, mask) = (noise(97, 61), disc(97, 61));
        let on = |threads: usize, sigma: f32| {
            let pool =
                rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let average = pool.install(|| gaussian_masked(&plane, &mask, sigma));
            average.pixels().iter().map(|v| v.to_bits()).collect::<Vec<_>>()
        };
        for sigma in [1.3, 13.0] {
            assert_eq!(on(1, sigma), on(2, sigma));
            assert_eq!(on(1, sigma), on(5, sigma));
        }
    }
}
