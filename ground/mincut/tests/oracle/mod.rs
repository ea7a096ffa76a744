//! The slow, obvious oracle: shortest augmenting paths one by one over an adjacency list.

use chiaro_mincut::{Graph, Lattice, Links, Neighbours};
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

    /// Saturates all paths between the two nodes after the first `nodes`; who is still reached.
    fn cut(&mut self, nodes: usize) -> (Vec<bool>, i64) {
        let mut flow = 0;
        loop {
            let via = self.reach(nodes);
            if via[nodes + 1].is_none() {
                return (via[..nodes].iter().map(Option::is_some).collect(), flow);
            }
            flow += self.augment(&via, nodes + 1);
        }
    }
}

/// What stands for "whatever it costs": more than all capacities of a small problem.
const FIXED: i64 = 1 << 50;

/// The canonical labels and the maximal flow of `lattice`.
#[allow(dead_code, reason = "each test has its own copy of the oracle")]
pub(crate) fn solve(lattice: &Lattice) -> (Vec<bool>, i64) {
    let (width, height) = (lattice.width as isize, lattice.height as isize);
    let pixels = lattice.width * lattice.height * lattice.frames;
    let (white, black) = (pixels, pixels + 1);
    let mut network = Network { arcs: Vec::new(), from: vec![Vec::new(); pixels + 2] };
    let steps: &[(isize, isize)] = match lattice.neighbours {
        Neighbours::Four(_) => &[(1, 0), (0, 1)],
        Neighbours::Eight(_) => &[(1, 0), (1, 1), (0, 1), (-1, 1)],
        Neighbours::Sixteen(_) => {
            &[(1, 0), (1, 1), (0, 1), (-1, 1), (2, 1), (1, 2), (-1, 2), (-2, 1)]
        }
    };
    let mut unavoidable = 0;
    for i in (0..pixels).filter(|&i| lattice.mask[i]) {
        let mut terminal = lattice.terminal[i].map(i64::from);
        if let Some(Some(label)) = lattice.fixed.get(i) {
            // What a fixed pixel pays is paid whatever else happens.
            unavoidable += terminal[usize::from(*label)];
            terminal = if *label { [FIXED, 0] } else { [0, FIXED] };
        }
        network.connect(white, i, terminal[0], 0);
        network.connect(i, black, terminal[1], 0);
        let (row, x) = (i as isize / width, i as isize % width);
        let (frame, y) = (row / height, row % height);
        for (link, (dx, dy)) in steps.iter().enumerate() {
            let (x, y) = (x + dx, y + dy);
            let j = ((frame * height + y) * width + x) as usize;
            if (0..width).contains(&x) && (0..height).contains(&y) && lattice.mask[j] {
                let [forth, back] = capacity(&lattice.neighbours, i, link);
                network.connect(i, j, i64::from(forth), i64::from(back));
            }
        }
        if let Some(Some(link)) = lattice.time.get(i) {
            let j = (frame - 1) as usize * lattice.width * lattice.height + link.to as usize;
            if lattice.mask[j] {
                network.connect(i, j, i64::from(link.capacity[0]), i64::from(link.capacity[1]));
            }
        }
    }
    let (labels, flow) = network.cut(pixels);
    (labels, flow + unavoidable)
}

/// The canonical labels and the maximal flow of `graph`.
#[allow(dead_code, reason = "each test has its own copy of the oracle")]
pub(crate) fn solve_graph(graph: &Graph) -> (Vec<bool>, i64) {
    let nodes = graph.terminal.len();
    let mut network = Network { arcs: Vec::new(), from: vec![Vec::new(); nodes + 2] };
    for (v, &[white, black]) in graph.terminal.iter().enumerate() {
        network.connect(nodes, v, white, 0);
        network.connect(v, nodes + 1, black, 0);
    }
    for edge in &graph.edges {
        let [a, b] = edge.ends.map(|v| v as usize);
        network.connect(a, b, edge.forth, 0);
        network.connect(b, a, edge.back, 0);
    }
    network.cut(nodes)
}

fn capacity(neighbours: &Neighbours, i: usize, link: usize) -> [i32; 2] {
    fn of<const L: usize>(links: &Links<L>, i: usize, link: usize) -> [i32; 2] {
        match links {
            Links::Symmetric(links) => [links[i][link]; 2],
            Links::Directed(links) => links[i][link],
        }
    }
    match neighbours {
        Neighbours::Four(links) => of(links, i, link),
        Neighbours::Eight(links) => of(links, i, link),
        Neighbours::Sixteen(links) => of(links, i, link),
    }
}
