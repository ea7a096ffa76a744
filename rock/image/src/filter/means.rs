//! Gaussian means of vectors a row at a time, for what reads each row once or twice: a plane of them
//! is written and read again in a quarter of the time that they take.

use super::gaussian::{
    Cells, FINE_SIGMA, cells_of, coarse, convolve_along_y, convolved_along_x, gaussian_taps,
    spread_row,
};
use crate::{Plane, Runs};
use rayon::prelude::*;
use std::ops::Range;

/// Gaussian means of the covered vectors of a plane, made up to the last step. A mean of unit normals
/// is shorter than 1, and by how much tells how much they bend: it is not made a unit again.
pub struct Means {
    sums: Sums,
    width: usize,
}

/// Sums of vectors, and of how many they are.
enum Sums {
    /// Convolved along x.
    Fine { along_x: Plane<[f32; 4]>, taps: Vec<f32> },
    /// Convolved on a coarser grid.
    Coarse { plane: Plane<[f32; 4]>, factor: usize, columns: Vec<Cells> },
}

impl Means {
    /// Those over the covered pixels that are finite; `sigma` is the standard deviation in pixels, of
    /// which 0 averages nothing. Panics when the sizes differ.
    pub fn of(plane: &Plane<[f32; 3]>, mask: &Plane<bool>, sigma: f32) -> Self {
        assert_eq!(plane.size(), mask.size(), "a mask has the size of its plane");
        let line = |y: usize, run: Range<usize>, out: &mut [[f32; 4]]| {
            let row = plane.row(y)[run.clone()].iter().zip(&mask.row(y)[run]);
            for (out, (&[a, b, c], &covered)) in out.iter_mut().zip(row) {
                let fit = covered && a.is_finite() && b.is_finite() && c.is_finite();
                *out = if fit { [a, b, c, 1.0] } else { [0.0; 4] };
            }
        };
        let (runs, width) = (Runs::of(mask), plane.width());
        let sigma = if sigma > 0.0 { f64::from(sigma).min(1e6) } else { 0.0 };
        let sums = if sigma > FINE_SIGMA {
            let (plane, factor) = coarse((&runs, &runs), sigma, line);
            Sums::Coarse { plane, factor, columns: cells_of(width, factor) }
        } else {
            let taps = if sigma > 0.0 { gaussian_taps(sigma * sigma) } else { vec![1.0] };
            let want = runs.grown(0, taps.len() - 1);
            Sums::Fine { along_x: convolved_along_x((&runs, &want), &taps, line), taps }
        };
        Self { sums, width }
    }

    /// The means of a run of row `y` of covered pixels, one slice a component. `line` is kept from one
    /// run to the next.
    #[inline(always)]
    pub fn row(
        &self,
        y: usize,
        run: Range<usize>,
        line: &mut Vec<[f32; 4]>,
        [a, b, c]: [&mut [f32]; 3],
    ) {
        line.resize(self.width + 2, [0.0; 4]);
        let out = a.iter_mut().zip(b).zip(c);
        let mean =
            |(((a, b), c), [x, y, z, weight]): (((&mut f32, &mut f32), &mut f32), [f32; 4])| {
                let scale = if weight > 0.0 { 1.0 / weight } else { 0.0 };
                (*a, *b, *c) = (x * scale, y * scale, z * scale);
            };
        match &self.sums {
            Sums::Fine { along_x, taps } => {
                let sums = &mut line[..run.len()];
                sums.fill([0.0; 4]);
                convolve_along_y(along_x, taps, (y, run), sums.as_flattened_mut());
                out.zip(sums.iter().copied()).for_each(mean);
            }
            Sums::Coarse { plane, factor, columns } => {
                let sums = spread_row((plane, *factor), y, &columns[run], line);
                out.zip(sums).for_each(mean);
            }
        }
    }
}

/// [`gaussian_covered`](super::gaussian_covered) of vectors, as a plane.
pub fn gaussian_covered3(
    plane: &Plane<[f32; 3]>,
    mask: &Plane<bool>,
    sigma: f32,
) -> Plane<[f32; 3]> {
    let ((width, height), means, runs) =
        (plane.size(), Means::of(plane, mask, sigma), Runs::of(mask));
    let mut pixels = vec![[0.0; 3]; width * height];
    pixels.par_chunks_mut(width.max(1)).enumerate().for_each_init(
        || (Vec::new(), [0; 3].map(|_| vec![0.0; width])),
        |(line, [a, b, c]), (y, row)| {
            for run in runs.row(y) {
                let n = run.len();
                means.row(y, run.clone(), line, [&mut a[..n], &mut b[..n], &mut c[..n]]);
                let means = a.iter().zip(b.iter()).zip(c.iter());
                for (pixel, ((a, b), c)) in row[run].iter_mut().zip(means) {
                    *pixel = [*a, *b, *c];
                }
            }
        },
    );
    Plane::from_pixels(width, height, pixels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::gaussian_covered;
    use chiaro_basis::random::unit;

    #[test]
    fn means_of_vectors_are_those_of_their_components() {
        let (w, h) = (70, 45);
        let number = |k: u64| Plane::from_fn(w, h, |x, y| unit(k, (y * w + x) as u64) - 0.5);
        let parts = [number(1), number(2), number(3)];
        let vectors = Plane::from_fn(w, h, |x, y| [0, 1, 2].map(|k: usize| parts[k][(x, y)]));
        let mask = Plane::from_fn(w, h, |x, y| (x * 5 + y * 3) % 17 > 2 && x + y > 20);
        for sigma in [0.0, 0.8, 3.9, 4.5, 13.0] {
            let means = gaussian_covered3(&vectors, &mask, sigma);
            for (k, part) in parts.iter().enumerate() {
                let alone = gaussian_covered(part, &mask, sigma);
                for y in 0..h {
                    for x in (0..w).filter(|x| mask[(*x, y)]) {
                        let error = (means[(x, y)][k] - alone[(x, y)]).abs();
                        assert!(error < 1e-5, "{sigma}: {error} at {x} {y}");
                    }
                }
            }
        }
    }

    #[test]
    fn mean_normals_are_shorter_where_they_bend() {
        let plane =
            Plane::from_fn(41, 5, |x, _| if x < 20 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] });
        let mean = gaussian_covered3(&plane, &Plane::filled(41, 5, true), 2.0);
        let length = |x: usize| mean[(x, 2)].iter().map(|c| c * c).sum::<f32>().sqrt();
        assert!((length(2) - 1.0).abs() < 1e-3);
        assert!((length(20) - 0.5f32.sqrt()).abs() < 0.02);
    }
}
