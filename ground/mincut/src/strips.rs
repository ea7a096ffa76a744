//! The first levels of a large picture, strip after strip.
//!
//! Grown over a whole large picture, every level fetches all that it looks at from far memory. But
//! most paths are short. So the first levels grow within one strip of rows after the other, which
//! the caches hold:
//!
//! 1. The arcs between strips are closed.
//! 2. Every strip grows from its roots, up to some level.
//! 3. The arcs open. The nodes beside them grow again, what was left to grow in a strip does so now,
//!    and the search goes on over the whole picture.
//!
//! Paths longer than the levels gain nothing, and would lose if strips were solved to the end: what
//! crosses a seam would first have been led astray within its strip.

use crate::capacity::Capacity;
use crate::network::{Black, White};
use crate::residual::Residual;
use crate::search::{GAP, Search};

/// The fewest strips that are worth their seams.
const FEWEST: usize = 4;

/// Begins a fresh search with the first `levels` of strips of about `pixels` pixels; `None` as for
/// [`Search::run`].
pub(crate) fn begin<C: Capacity>(
    search: &mut Search<Residual<C>>,
    pixels: usize,
    levels: i32,
) -> Option<()> {
    let network = &mut search.network;
    let (height, rows) = (network.height(), (pixels / network.width.max(1)).max(1));
    if height < FEWEST * rows {
        return Some(());
    }
    let starts = (0..height).step_by(rows);
    starts.clone().skip(1).for_each(|row| network.close_seam(row));
    let mut waiting = [Vec::new(), Vec::new()];
    for row in starts.clone() {
        let last = (row + rows).min(height) - 1;
        search.seed(search.network.row(row).start..search.network.row(last).end);
        search.run_up_to(levels)?;
        waiting[0].append(&mut search.take_waiting::<White>());
        waiting[1].append(&mut search.take_waiting::<Black>());
    }
    for (tree, waiting) in search.trees.iter_mut().zip(waiting) {
        (tree.grown, tree.again) = (levels + GAP, waiting);
    }
    starts.skip(1).for_each(|row| search.open_seam(row));
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{HEIGHT, Noise, WIDTH};

    #[test]
    fn the_cut_does_not_depend_on_strips() {
        for rare in [1, 4, 30] {
            let noise = Noise::new(rare);
            let whole = noise.cut(|_| {});
            for pixels in [WIDTH, 3 * WIDTH + 5, 10 * WIDTH] {
                for levels in [1, 2, 5, 100] {
                    let strips = noise.cut(|search| {
                        begin(search, pixels, levels).expect("distances are short");
                        assert!(!search.trees.iter().all(|tree| tree.again.is_empty()));
                    });
                    assert_eq!(strips, whole, "{rare} {pixels} {levels}, {HEIGHT} rows");
                }
            }
        }
    }
}
