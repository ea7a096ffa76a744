//! [`Edges`]: the sides of all triangles, gathered into edges by a counting sort.

use super::Side;

const NONE: u32 = u32::MAX;

/// Which sides lie on which edge, as offsets into one list, and back.
#[derive(Clone, Debug)]
pub(super) struct Edges {
    start: Vec<u32>,
    sides: Vec<Side>,
    under: Vec<u32>,
}

impl Edges {
    /// The ends of each edge and the sides on it. Edges rise by their lower end, then their higher.
    pub(super) fn of(
        triangles: &[[u32; 3]],
        collapsed: &[u32],
        vertices: usize,
    ) -> (Vec<[u32; 2]>, Self) {
        let (first, mut by_low) = sorted_by_low_end(triangles, collapsed, vertices);
        let (mut ends, mut start) = (Vec::new(), Vec::new());
        let mut under = vec![NONE; 3 * triangles.len()];
        for low in 0..vertices {
            let range = first[low] as usize..first[low + 1] as usize;
            by_low[range.clone()].sort_unstable();
            for i in range {
                let (high, side) = by_low[i];
                if ends.last() != Some(&[low as u32, high]) {
                    ends.push([low as u32, high]);
                    start.push(i as u32);
                }
                under[side.index()] = ends.len() as u32 - 1;
            }
        }
        start.push(by_low.len() as u32);
        let sides = by_low.into_iter().map(|(_, side)| side).collect();
        (ends, Self { start, sides, under })
    }

    pub(super) fn at(&self, edge: usize) -> &[Side] {
        &self.sides[self.start[edge] as usize..self.start[edge + 1] as usize]
    }

    pub(super) fn under(&self, side: Side) -> Option<usize> {
        let edge = self.under[side.index()];
        (edge != NONE).then_some(edge as usize)
    }
}

/// All sides with their higher ends, grouped by their lower ends: where each group begins, and the
/// groups one after another.
fn sorted_by_low_end(
    triangles: &[[u32; 3]],
    collapsed: &[u32],
    vertices: usize,
) -> (Vec<u32>, Vec<(u32, Side)>) {
    let mut counts = vec![0u32; vertices + 1];
    let each = |visit: &mut dyn FnMut(u32, u32, Side)| {
        let mut skip = collapsed.iter().peekable();
        for (face, t) in triangles.iter().enumerate() {
            if skip.next_if(|&&c| c as usize == face).is_some() {
                continue;
            }
            for corner in 0..3 {
                let (a, b) = (t[corner], t[(corner + 1) % 3]);
                visit(a.min(b), a.max(b), Side::new(face, corner));
            }
        }
    };
    each(&mut |low, _, _| counts[low as usize + 1] += 1);
    for v in 0..vertices {
        counts[v + 1] += counts[v];
    }
    let mut next = counts.clone();
    let mut sides = vec![(0, Side(0)); counts[vertices] as usize];
    each(&mut |low, high, side| {
        sides[next[low as usize] as usize] = (high, side);
        next[low as usize] += 1;
    });
    (counts, sides)
}
