//! Ordered labels, exactly.
//!
//! A labelling is the stack of its level sets {l >= j}. With total variation between neighbours its
//! cost is a sum of binary costs, one a level; where every pixel's price is convex over the tones,
//! the levels' canonical cuts are nested by themselves (Hochbaum 2001; Darbon and Sigelle 2006), and
//! divide and conquer finds them with `log2 k` cuts of the grid. Otherwise one cut of a layered
//! graph finds them.

use super::nested::Nested;
use super::{Distance, LabelError, LabelGrid, Labelling, layered};

/// The labelling of least energy; of several the one whose labels are the lowest everywhere.
///
/// # Errors
/// What [`LabelError`] lists; [`Distance::Metric`] is not ordered.
///
/// ```
/// use chiaro_mincut::{Distance, LabelGrid, solve_ordered};
///
/// // Three tones on a row of three pixels; the middle one has no opinion.
/// let grid = LabelGrid {
///     width: 3,
///     height: 1,
///     labels: 3,
///     mask: &[true; 3],
///     data: &[0, 5, 9, 0, 0, 0, 9, 5, 0],
///     neighbour: &[[1, 0, 0, 0]; 3],
///     distance: Distance::Tones(&[0, 1, 2]),
/// };
/// let best = solve_ordered(&grid)?;
/// assert_eq!((best.labels, best.energy), (vec![0, 0, 2], 2));
/// # Ok::<(), chiaro_mincut::LabelError>(())
/// ```
pub fn solve_ordered(grid: &LabelGrid) -> Result<Labelling, LabelError> {
    grid.check()?;
    let labels = match grid.distance {
        Distance::Metric(_) => {
            return Err(LabelError::Distance("labels of a metric have no order; expand them"));
        }
        Distance::Tones(tones) if is_convex(grid, tones) => nested(grid, tones)?,
        _ => layered::labels(grid)?,
    };
    let energy = grid.energy(&labels);
    Ok(Labelling { labels, energy })
}

/// Whether the slopes of every pixel's price over the tones never fall.
fn is_convex(grid: &LabelGrid, tones: &[i32]) -> bool {
    let slope = |p: usize, l: usize| {
        let rise = grid.price(p, l) - grid.price(p, l - 1);
        (i128::from(rise), i128::from(step(tones, l)))
    };
    (0..grid.mask.len()).filter(|&p| grid.mask[p]).all(|p| {
        (2..grid.labels).all(|l| {
            let ((rise, run), (next_rise, next_run)) = (slope(p, l - 1), slope(p, l));
            rise * next_run <= next_rise * run
        })
    })
}

/// How far tone `l` is from the one below.
fn step(tones: &[i32], l: usize) -> i64 {
    i64::from(tones[l]) - i64::from(tones[l - 1])
}

fn nested(grid: &LabelGrid, tones: &[i32]) -> Result<Vec<u8>, LabelError> {
    // From the highest level down, since what reaches a level reaches all below.
    let top = grid.labels - 1;
    let level = |member: u32| top - member as usize;
    let terminal = vec![[0; 2]; grid.mask.len()];
    let nested = Nested {
        grid: &grid.grid(&terminal),
        pull: |p, m| grid.price(p, level(m) - 1) - grid.price(p, level(m)),
        bond: |m| step(tones, level(m)) as i32,
    };
    let reached = nested.solve(top as u32)?;
    let label = |(&member, &node): (&u32, &bool)| if node { level(member) as u8 } else { 0 };
    Ok(reached.iter().zip(grid.mask).map(label).collect())
}
