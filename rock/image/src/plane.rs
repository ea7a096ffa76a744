//! [`Plane`]: the only two-dimensional array.
//!
//! Row-major, x to the right, y down; the centre of pixel (x, y) is at (x + 0.5, y + 0.5).

use chiaro_basis::{Error, Result};
use rayon::prelude::*;

/// A `width` x `height` array of pixels.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Plane<T> {
    width: usize,
    height: usize,
    pixels: Vec<T>,
}

impl<T> Plane<T> {
    /// A plane from its pixels, row by row. Panics when their number is not `width * height`.
    pub fn from_pixels(width: usize, height: usize, pixels: Vec<T>) -> Self {
        assert_eq!(pixels.len(), width * height, "a plane holds width x height pixels");
        Self { width, height, pixels }
    }

    /// A plane whose pixel (x, y) is `pixel(x, y)`, made row by row in parallel.
    pub fn from_fn(width: usize, height: usize, pixel: impl Fn(usize, usize) -> T + Sync) -> Self
    where
        T: Send,
    {
        // By index, so that every pixel is written once, into its place.
        let pixels = (0..width * height)
            .into_par_iter()
            .with_min_len(width)
            .map(|i| pixel(i % width, i / width))
            .collect();
        Self { width, height, pixels }
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Width and height.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Pixels in all.
    pub fn len(&self) -> usize {
        self.pixels.len()
    }

    /// Whether there is no pixel.
    pub fn is_empty(&self) -> bool {
        self.pixels.is_empty()
    }

    /// All pixels, row by row.
    pub fn pixels(&self) -> &[T] {
        &self.pixels
    }

    /// All pixels, row by row, to be changed in place.
    pub fn pixels_mut(&mut self) -> &mut [T] {
        &mut self.pixels
    }

    /// The pixels themselves.
    pub fn into_pixels(self) -> Vec<T> {
        self.pixels
    }

    /// Row `y`.
    pub fn row(&self, y: usize) -> &[T] {
        &self.pixels[y * self.width..(y + 1) * self.width]
    }

    /// The pixel at (x, y), or `None` outside the picture.
    pub fn at(&self, x: isize, y: isize) -> Option<&T> {
        let inside = x >= 0 && y >= 0 && (x as usize) < self.width && (y as usize) < self.height;
        inside.then(|| &self.pixels[y as usize * self.width + x as usize])
    }

    /// A plane of `f(pixel)`.
    pub fn map<U: Send>(&self, f: impl Fn(&T) -> U + Sync + Send) -> Plane<U>
    where
        T: Sync,
    {
        let pixels = self.pixels.par_iter().map(f).collect();
        Plane { width: self.width, height: self.height, pixels }
    }

    /// A plane of `f(this pixel, other's pixel)`; [`Error::Input`] when the sizes differ.
    pub fn zip<U: Sync, V: Send>(
        &self,
        other: &Plane<U>,
        f: impl Fn(&T, &U) -> V + Sync + Send,
    ) -> Result<Plane<V>>
    where
        T: Sync,
    {
        same_size(self.size(), other.size())?;
        let pixels = self.pixels.par_iter().zip(&other.pixels).map(|(a, b)| f(a, b)).collect();
        Ok(Plane { width: self.width, height: self.height, pixels })
    }
}

impl<T: Clone> Plane<T> {
    /// A plane of one value.
    pub fn filled(width: usize, height: usize, value: T) -> Self {
        Self { width, height, pixels: vec![value; width * height] }
    }
}

impl<T> std::ops::Index<(usize, usize)> for Plane<T> {
    type Output = T;
    fn index(&self, (x, y): (usize, usize)) -> &T {
        debug_assert!(x < self.width);
        &self.pixels[y * self.width + x]
    }
}

impl<T> std::ops::IndexMut<(usize, usize)> for Plane<T> {
    fn index_mut(&mut self, (x, y): (usize, usize)) -> &mut T {
        debug_assert!(x < self.width);
        &mut self.pixels[y * self.width + x]
    }
}

/// [`Error::Input`] unless two planes have the same size.
pub(crate) fn same_size(a: (usize, usize), b: (usize, usize)) -> Result<()> {
    if a == b {
        return Ok(());
    }
    let why = format!(
        "the sizes differ ({} x {} and {} x {}); render both at one size",
        a.0, a.1, b.0, b.1
    );
    Err(Error::input("the two pictures", "", why))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_row_major_from_the_top() {
        let p = Plane::from_fn(3, 2, |x, y| (x, y));
        assert_eq!(p.pixels()[4], (1, 1));
        assert_eq!(p[(2, 0)], (2, 0));
        assert_eq!(p.row(1)[0], (0, 1));
        assert_eq!(p.at(-1, 0), None);
        assert_eq!(p.at(0, 2), None);
    }

    #[test]
    fn planes_of_different_sizes_do_not_zip() {
        let (a, b) = (Plane::filled(2, 2, 1), Plane::filled(2, 3, 1));
        assert!(a.zip(&b, |x, y| x + y).is_err());
    }
}
