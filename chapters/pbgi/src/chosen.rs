//! The smallest book that keeps an error bound (thesis, 6.7, Error-Driven Quantization).
//!
//! Half of the lessons teach, the other half examine: books of a fixed ladder of recipes, from 16
//! words up to ten stages, are tried until one keeps the bound on nodes it has not seen.

use crate::code::{Book, Gains, Pen, Recipe};
use crate::stream::{Lesson, taught};
use chiaro_basis::{Result, Run};

/// A book, and what the other half of the lessons said of it.
pub struct Chosen {
    /// The book, taught by all lessons.
    pub book: Book,
    /// Its error on nodes that it had not seen: see [`error`].
    pub error: f64,
}

/// The recipes that are tried, the smallest codes first.
pub fn ladder() -> Vec<Recipe> {
    let words = [16, 64, 256, 1024, 4096].map(Recipe::clusters);
    let staged = [(Gains::One, 2, 1), (Gains::One, 3, 2), (Gains::One, 4, 3)]
        .into_iter()
        .chain([(3, 2), (4, 3), (6, 4), (8, 6), (10, 8)].map(|(l, a)| (Gains::Colours, l, a)));
    let staged = staged.map(|(gains, light, area)| Recipe::residual(gains, false, light, area));
    words.into_iter().chain(staged).collect()
}

/// The root mean square error of nodes' light, each node over its area, relative to the root mean
/// square of the light itself.
pub fn error<'a>(book: &Book, lessons: impl Iterator<Item = &'a Lesson>) -> f64 {
    let mut pen = Pen::default();
    let sums = lessons.filter(|l| l.area > 0.0).fold([0.0; 2], |[wrong, there], lesson| {
        let [w, t] = book.error(&lesson.lobes(), &mut pen);
        let scale = f64::from(lesson.area).powi(-2);
        [wrong + w * scale, there + t * scale]
    });
    if sums[1] > 0.0 { (sums[0] / sums[1]).sqrt() } else { 0.0 }
}

/// The first book of the ladder whose error is at most `bound`; the last one, and a warning, when
/// none keeps it.
pub fn smallest(lessons: &[Lesson], bound: f64, run: &Run) -> Result<Chosen> {
    let half = |k: usize| lessons.iter().skip(k).step_by(2);
    let teaching: Vec<Lesson> = half(0).copied().collect();
    let mut last = (Recipe::default(), f64::INFINITY);
    for recipe in ladder() {
        let found = error(&taught(&teaching, &recipe, run)?, half(1));
        last = (recipe, found);
        if found <= bound {
            break;
        }
    }
    let (recipe, error) = last;
    if error > bound {
        run.warn(format!("no book keeps an error of {bound:.4}; the largest has {error:.4}"));
    }
    Ok(Chosen { book: taught(lessons, &recipe, run)?, error })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packed::records;
    use crate::packed::tests::sheet;
    use crate::stream::{LESSONS, lessons};

    #[test]
    fn smaller_bounds_take_larger_books_that_keep_them() {
        let run = Run::default();
        let lessons = lessons(&records(&sheet(1000)), LESSONS);
        let of = |bound| smallest(&lessons, bound, &run).unwrap();
        let (rough, fine) = (of(0.4), of(0.05));
        assert!(rough.error <= 0.4 && fine.error <= 0.05, "{} {}", rough.error, fine.error);
        let rank = |c: &Chosen| ladder().iter().position(|r| *r == c.book.recipe);
        assert!(rank(&rough) < rank(&fine) && rank(&rough).is_some());
        let sizes: Vec<usize> = ladder().iter().map(Recipe::bytes).collect();
        assert!(sizes.is_sorted());
    }
}
