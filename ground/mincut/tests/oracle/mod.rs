//! The slow, obvious oracle: shortest augmenting paths one by one over an adjacency list.

use chiaro_mincut::Grid;
use std::collections::VecDeque;

struct Network {
    /// Arcs in pairs: `arcs[a ^ 1]` is the reverse of `arcs[a]`; (head, residual).
    arcs: Vec<(usize, i64)>,
    from: Vec<Vec<usize>>,
}

impl Network {
    fn connect(&mut self, a: usize, b: usize, forth: i64, back: i64) {
        for (tail, head, capacity) in [(a, b, forth), (b, a, back)] {
            self.from[tail].push(self.arcs.len());
            self.arcs.push((head, capacity));
        }
    }

    /// The arc by which a breadth-first walk from `source` first reaches each node.
    fn reach(&self, source: usize) -> Vec<Option<usize>> {
        let mut via = vec![None; self.from.len()];
        let mut queue = VecDeque::from([source]);
        while let Some(v) = queue.pop_front() {
            for &a in &self.from[v] {
                let (w, residual) = self.arcs[a];
                if residual > 0 && via[w].is_none() && w != source {
                    via[w] = Some(a);
                    queue.push_back(w);
                }
            }
        }
        via
    }

    fn augment(&mut self, via: &[Option<usize>], sink: usize) -> i64 {
        let mut path = Vec::new();
        let mut v = sink;
        while let Some(a) = via[v] {
            path.push(a);
            v = self.arcs[a ^ 1].0;
        }
        let amount = path.iter().map(|&a| self.arcs[a].1).min().unwrap_or(0);
        for a in path {
            self.arcs[a].1 -= amount;
            self.arcs[a ^ 1].1 += amount;
        }
        amount
    }
}

/// The canonical labels and the maximal flow of `grid`.
pub(crate) fn solve(grid: &Grid) -> (Vec<bool>, i64) {
    let pixels = grid.width * grid.height;
    let (white, black) = (pixels, pixels + 1);
    let mut network = Network { arcs: Vec::new(), from: vec![Vec::new(); pixels + 2] };
    for i in (0..pixels).filter(|&i| grid.mask[i]) {
        network.connect(white, i, i64::from(grid.terminal[i][0]), 0);
        network.connect(i, black, i64::from(grid.terminal[i][1]), 0);
        let (x, y) = ((i % grid.width) as isize, (i / grid.width) as isize);
        for (d, (dx, dy)) in [(1, 0), (1, 1), (0, 1), (-1, 1)].into_iter().enumerate() {
            let (x, y) = (x + dx, y + dy);
            let inside =
                (0..grid.width as isize).contains(&x) && (0..grid.height as isize).contains(&y);
            let j = (y * grid.width as isize + x) as usize;
            if inside && grid.mask[j] {
                let capacity = i64::from(grid.neighbour[i][d]);
                network.connect(i, j, capacity, capacity);
            }
        }
    }
    let mut flow = 0;
    loop {
        let via = network.reach(white);
        if via[black].is_none() {
            return (via[..pixels].iter().map(Option::is_some).collect(), flow);
        }
        flow += network.augment(&via, black);
    }
}
