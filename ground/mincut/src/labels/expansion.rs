//! Alpha-expansion: labels without an order, by one cut a label in turn.
//!
//! After Boykov, Veksler and Zabih, "Fast approximate energy minimization via graph cuts" (2001).
//! A move lets every pixel keep its label or take label alpha; the best move is a minimal cut
//! (white takes), because no detour over a third label is shorter (Kolmogorov and Zabih 2004, with
//! directed edges instead of their extra nodes). Moves are tried label by label until a whole round
//! brings nothing: the energy never rises, and ends within twice the ratio of the largest to the
//! smallest distance of the best.

use super::{Distance, LabelError, LabelGrid, LabelStack, Labelling};
use crate::lattice::{Lattice, Links, Neighbours, TimeLink};
use crate::solver::Solver;

/// A labelling that no expansion improves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expansion {
    /// The labels and their energy.
    pub labelling: Labelling,
    /// The energy at the start and after each move that was made; it falls from one to the next.
    pub energies: Vec<i64>,
}

/// Improves `start` (one label a pixel) by expansions until none helps.
///
/// # Errors
/// What [`LabelError`] lists; [`Distance::Convex`] is in general no metric, see [`solve_ordered`].
///
/// ```
/// use chiaro_mincut::{Distance, LabelGrid, expand};
///
/// // Three unordered labels: a row of two pixels that each like one of the last two.
/// let grid = LabelGrid {
///     width: 2,
///     height: 1,
///     labels: 3,
///     mask: &[true; 2],
///     data: &[9, 0, 9, 9, 9, 0],
///     neighbour: &[[1, 0, 0, 0]; 2],
///     distance: Distance::Metric(&[0, 1, 1, 1, 0, 1, 1, 1, 0]),
/// };
/// let found = expand(&grid, &[0, 0])?;
/// assert_eq!(found.labelling.labels, [1, 2]);
/// assert_eq!(found.energies, [18, 9, 1]);
/// # Ok::<(), chiaro_mincut::LabelError>(())
/// ```
///
/// [`solve_ordered`]: crate::solve_ordered
pub fn expand(grid: &LabelGrid, start: &[u8]) -> Result<Expansion, LabelError> {
    expand_stack(&LabelStack { grid: *grid, frames: 1, time: &[] }, start)
}

/// [`expand`] for a stack of frames, whose pixels are linked to those of the frame before.
///
/// # Errors
/// What [`LabelError`] lists.
pub fn expand_stack(stack: &LabelStack, start: &[u8]) -> Result<Expansion, LabelError> {
    stack.check()?;
    let grid = &stack.grid;
    if let Distance::Convex(_) = grid.distance {
        return Err(LabelError::Distance(
            "convex distances may allow detours; solve them in order",
        ));
    }
    let (got, expected) = (start.len(), grid.mask.len());
    if got != expected {
        return Err(LabelError::Length { slice: "start", got, expected });
    }
    if let Some(&label) = start.iter().find(|&&l| usize::from(l) >= grid.labels) {
        return Err(LabelError::Labels(usize::from(label) + 1));
    }
    let clear = |(&label, &node): (&u8, &bool)| if node { label } else { 0 };
    let mut labels: Vec<u8> = start.iter().zip(grid.mask).map(clear).collect();
    let mut energies = vec![stack.energy(&labels)];
    let mut idle = 0;
    for alpha in (0..grid.labels).cycle() {
        if idle == grid.labels {
            break;
        }
        idle += 1;
        let moved = best_move(stack, &labels, alpha)?;
        let energy = stack.energy(&moved);
        if energy < energies[energies.len() - 1] {
            energies.push(energy);
            labels = moved;
            idle = 1;
        }
    }
    let energy = energies[energies.len() - 1];
    Ok(Expansion { labelling: Labelling { labels, energy }, energies })
}

/// The labels after the best expansion of `alpha`; of several the one that changes the least.
fn best_move(stack: &LabelStack, labels: &[u8], alpha: usize) -> Result<Vec<u8>, LabelError> {
    let grid = &stack.grid;
    // What draws a pixel to alpha: what it pays for the label it keeps, less what for alpha.
    let pull = |p: usize| grid.price(p, labels[p].into()) - grid.price(p, alpha);
    let mut pull: Vec<i64> = (0..labels.len()).map(pull).collect();
    let mut bind = |p: usize, q: usize, weight: i64| {
        let (a, b) = (usize::from(labels[p]), usize::from(labels[q]));
        let between = |a: usize, b: usize| weight * grid.distance.between(grid.labels, a, b);
        let [keep, first_keeps, second_keeps] =
            [between(a, b), between(a, alpha), between(alpha, b)];
        // keep + (second_keeps - keep) [p takes] - second_keeps [q takes]
        //      + (first_keeps + second_keeps - keep) [p keeps and q takes]
        pull[p] += keep - second_keeps;
        pull[q] += second_keeps;
        [0, (first_keeps + second_keeps - keep) as i32]
    };
    let mut links = vec![[[0; 2]; 4]; labels.len()];
    for (p, link, q) in stack.edges() {
        links[p][link] = bind(p, q, grid.neighbour[p][link].into());
    }
    let mut time = stack.time.to_vec();
    for (p, q, weight) in stack.time_edges() {
        let to = (q % stack.frame()) as u32;
        time[p] = Some(TimeLink { to, capacity: bind(p, q, weight) });
    }
    let terminal: Vec<[i32; 2]> =
        pull.iter().map(|&p| [p.max(0), (-p).max(0)].map(|p| p as i32)).collect();
    let solver = Solver::new(&Lattice {
        width: grid.width,
        height: grid.height / stack.frames,
        frames: stack.frames,
        mask: grid.mask,
        terminal: &terminal,
        neighbours: Neighbours::Eight(Links::Directed(&links)),
        time: &time,
        fixed: &[],
    })?;
    let label = |(&label, &takes): (&u8, &bool)| if takes { alpha as u8 } else { label };
    Ok(labels.iter().zip(solver.labels()).map(label).collect())
}
