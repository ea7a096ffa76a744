//! The cheapest bridges that join all cores of a sheet.
//!
//! 1. The picture is laid out in cells of a fifth of a bridge. A bridge through a cell pays the mean
//!    price around it, a bridge wide, for every pixel of its length.
//! 2. Dijkstra's search from all cores at once; where the grounds of two cores meet there is a way
//!    between them. The cheapest ways that span all cores (Kruskal) are the bridges.
//! 3. At the ends of that tree, parts that cost less to leave out than to join are left out.
//! 4. Ways are pulled straight as far as that costs no more.

use super::cores::{Cores, NONE};
use super::{StencilForm, along};
use chiaro_basis::Sets;
use chiaro_image::labels::{UNCOVERED, components_by_sides};
use chiaro_image::{Plane, filter};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Cells across a bridge.
const CELLS: f32 = 5.0;
/// What a pixel of bridge costs at least, so that ways do not wander where all is free.
const LEAST: f32 = 1e-3;
/// How much dearer than the cheapest way a straight one may be.
const SLACK: f32 = 1.1;

/// What joins the cores.
pub(super) struct Tree {
    /// The middle lines of the bridges, in pixels.
    pub(super) ways: Vec<Vec<[f32; 2]>>,
    /// Cores to be left out.
    pub(super) dropped: Vec<u32>,
}

/// Joins all cores of a sheet. What was sheet in the picture `given` costs nothing to give back.
pub(super) fn join(
    (sheet, given): (&Plane<bool>, &Plane<bool>),
    cores: &Cores,
    price: &Plane<f32>,
    form: &StencilForm,
) -> Tree {
    let cells = Cells::new((sheet, given), cores, price, form);
    let ground = Ground::search(&cells);
    let mut edges = spanning(ground.meetings(&cells), cores.areas.len());
    let dropped = prune(&mut edges, &worth(sheet, cores, price));
    let ways = edges.iter().map(|e| ground.way(&cells, cores, e)).collect();
    Tree { ways, dropped }
}

/// The picture in cells.
struct Cells {
    /// Pixels across a cell.
    step: usize,
    /// What a pixel of bridge costs here.
    price: Plane<f32>,
    /// The first core in each cell, or [`NONE`].
    core: Plane<u32>,
}

impl Cells {
    fn new(
        (sheet, given): (&Plane<bool>, &Plane<bool>),
        cores: &Cores,
        price: &Plane<f32>,
        form: &StencilForm,
    ) -> Self {
        let step = (form.bridge / CELLS).floor().max(1.0) as usize;
        let (w, h) = sheet.size();
        let (columns, rows) = (w.div_ceil(step), h.div_ceil(step));
        let inside = |cx: usize, cy: usize| {
            let (xs, ys) =
                (cx * step..((cx + 1) * step).min(w), cy * step..((cy + 1) * step).min(h));
            ys.flat_map(move |y| xs.clone().map(move |x| (x, y)))
        };
        let mean = |cx: usize, cy: usize| {
            let (mut sum, mut count) = (0.0, 0.0f32);
            for at in inside(cx, cy) {
                sum += if sheet[at] || given[at] { 0.0 } else { price[at] };
                count += 1.0;
            }
            sum / count
        };
        let core = Plane::from_fn(columns, rows, |cx, cy| {
            inside(cx, cy).map(|at| cores.ids[at]).find(|id| *id != NONE).unwrap_or(NONE)
        });
        let sharp = Plane::from_fn(columns, rows, mean);
        let sigma = 0.3 * form.bridge / step as f32;
        let tube = filter::gaussian_masked(&sharp, &sharp.map(|_| true), sigma);
        Self { step, price: tube.map(|p| form.bridge * p + LEAST), core }
    }

    fn centre(&self, cell: usize) -> [f32; 2] {
        let at = |i: usize| (i as f32 + 0.5) * self.step as f32;
        [at(cell % self.price.width()), at(cell / self.price.width())]
    }

    /// What a straight bridge between two points costs.
    fn straight(&self, a: [f32; 2], b: [f32; 2]) -> f32 {
        let points = along(&[a, b], 0.5 * self.step as f32);
        let length = (b[0] - a[0]).hypot(b[1] - a[1]) / points.len().max(1) as f32;
        let (w, h) = self.price.size();
        let cell = |v: f32, n: usize| ((v / self.step as f32) as usize).min(n - 1);
        points.iter().map(|p| self.price[(cell(p[0], w), cell(p[1], h))] * length).sum()
    }

    /// The cells around one, with how far they are in pixels.
    fn around(&self, cell: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
        const AROUND: [(isize, isize); 8] =
            [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];
        let (w, h) = self.price.size();
        let (x, y) = ((cell % w) as isize, (cell / w) as isize);
        AROUND.iter().filter_map(move |(dx, dy)| {
            let (u, v) = (x + dx, y + dy);
            let inside = u >= 0 && v >= 0 && (u as usize) < w && (v as usize) < h;
            let length = ((dx * dx + dy * dy) as f32).sqrt() * self.step as f32;
            inside.then(|| (v as usize * w + u as usize, length))
        })
    }

    fn between(&self, a: usize, b: usize, length: f32) -> f32 {
        0.5 * (self.price.pixels()[a] + self.price.pixels()[b]) * length
    }
}

/// For each cell the core that is cheapest to reach, and the way there.
struct Ground {
    cost: Vec<f32>,
    core: Vec<u32>,
    from: Vec<u32>,
}

impl Ground {
    fn search(cells: &Cells) -> Self {
        let count = cells.price.len();
        let mut ground = Self {
            cost: vec![f32::INFINITY; count],
            core: cells.core.pixels().to_vec(),
            from: vec![NONE; count],
        };
        // Costs are not negative, so that their bits are in their order.
        let mut queue = BinaryHeap::new();
        for cell in (0..count).filter(|c| cells.core.pixels()[*c] != NONE) {
            ground.cost[cell] = 0.0;
            queue.push(Reverse((0u32, cell)));
        }
        while let Some(Reverse((bits, cell))) = queue.pop() {
            if f32::from_bits(bits) > ground.cost[cell] {
                continue;
            }
            for (next, length) in cells.around(cell) {
                let cost = ground.cost[cell] + cells.between(cell, next, length);
                if cost < ground.cost[next] {
                    ground.cost[next] = cost;
                    ground.core[next] = ground.core[cell];
                    ground.from[next] = cell as u32;
                    queue.push(Reverse((cost.to_bits(), next)));
                }
            }
        }
        ground
    }

    /// The cheapest way between any two cores whose grounds meet.
    fn meetings(&self, cells: &Cells) -> Vec<Edge> {
        let mut best: BTreeMap<(u32, u32), Edge> = BTreeMap::new();
        for a in 0..self.cost.len() {
            for (b, length) in cells.around(a).filter(|(b, _)| *b > a) {
                let (p, q) = (self.core[a], self.core[b]);
                if p == q || p == NONE || q == NONE {
                    continue;
                }
                let cost = self.cost[a] + self.cost[b] + cells.between(a, b, length);
                let edge = Edge { cost, cores: [p, q], cells: [a, b] };
                let kept = best.entry((p.min(q), p.max(q))).or_insert(edge);
                if cost < kept.cost {
                    *kept = edge;
                }
            }
        }
        best.into_values().collect()
    }

    /// From the core of one end to that of the other.
    fn way(&self, cells: &Cells, cores: &Cores, edge: &Edge) -> Vec<[f32; 2]> {
        let back = |mut cell: usize| {
            let mut list = vec![cell];
            while self.from[cell] != NONE {
                cell = self.from[cell] as usize;
                list.push(cell);
            }
            list
        };
        let [mut first, second] = edge.cells.map(back);
        first.reverse();
        let ends = [first[0], second[second.len() - 1]];
        let [start, end] = [0, 1].map(|i| inside(cells, cores, ends[i], edge.cores[i]));
        let middle = first.into_iter().chain(second).map(|c| cells.centre(c));
        let points: Vec<_> = [start].into_iter().chain(middle).chain([end]).collect();
        pulled(cells, &points)
    }
}

/// A pixel of a core in a cell.
fn inside(cells: &Cells, cores: &Cores, cell: usize, core: u32) -> [f32; 2] {
    let (w, h) = cores.ids.size();
    let step = cells.step;
    let (x, y) = (cell % cells.price.width() * step, cell / cells.price.width() * step);
    let pixels = (y..(y + step).min(h)).flat_map(|v| (x..(x + step).min(w)).map(move |u| (u, v)));
    let found = pixels.into_iter().find(|at| cores.ids[*at] == core);
    found.map_or_else(|| cells.centre(cell), |(u, v)| [u as f32 + 0.5, v as f32 + 0.5])
}

/// A way pulled straight: from each point to the farthest one that is as cheap to reach.
fn pulled(cells: &Cells, points: &[[f32; 2]]) -> Vec<[f32; 2]> {
    let mut sums = vec![0.0f32];
    for p in points.windows(2) {
        sums.push(sums[sums.len() - 1] + cells.straight(p[0], p[1]));
    }
    let mut way = vec![points[0]];
    let mut i = 0;
    while i + 1 < points.len() {
        let cheap = |j: &usize| {
            cells.straight(points[i], points[*j]) <= SLACK * (sums[*j] - sums[i]) + LEAST
        };
        i = (i + 2..points.len()).rev().find(cheap).unwrap_or(i + 1);
        way.push(points[i]);
    }
    way
}

#[derive(Clone, Copy, Debug)]
struct Edge {
    cost: f32,
    cores: [u32; 2],
    cells: [usize; 2],
}

/// The cheapest edges that join `count` cores.
fn spanning(mut edges: Vec<Edge>, count: usize) -> Vec<Edge> {
    edges.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.cores.cmp(&b.cores)));
    let mut sets = Sets::new(count);
    edges.retain(|edge| sets.join(edge.cores[0] as usize, edge.cores[1] as usize));
    edges
}

/// What it costs to leave a core's part out; infinite where the part holds other cores or the rim.
fn worth(sheet: &Plane<bool>, cores: &Cores, price: &Plane<f32>) -> Vec<f32> {
    let parts = components_by_sides(sheet, sheet);
    let mut sums = vec![0.0f64; parts.pieces.len()];
    let mut holds: Vec<Option<u32>> = vec![None; parts.pieces.len()];
    let mut shared = vec![false; parts.pieces.len()];
    let pixels = parts.ids.pixels().iter().zip(cores.ids.pixels()).zip(price.pixels());
    for ((part, core), price) in pixels.filter(|((part, _), _)| **part != UNCOVERED) {
        let part = *part as usize;
        sums[part] += f64::from(*price);
        if *core != NONE {
            shared[part] |= holds[part].is_some_and(|c| c != *core);
            holds[part] = Some(*core);
        }
    }
    let mut worth = vec![f32::INFINITY; cores.areas.len()];
    for part in (0..sums.len()).filter(|p| !shared[*p]) {
        if let Some(core) = holds[part].filter(|c| *c != 0) {
            worth[core as usize] = sums[part] as f32;
        }
    }
    worth
}

/// Takes leaves off the tree that cost more to join than to leave out; the cores left out.
fn prune(edges: &mut Vec<Edge>, worth: &[f32]) -> Vec<u32> {
    let mut dropped = Vec::new();
    loop {
        let mut degree = vec![0usize; worth.len()];
        edges.iter().flat_map(|e| e.cores).for_each(|c| degree[c as usize] += 1);
        let poor = |e: &Edge| {
            let mut ends = e.cores.into_iter();
            ends.find(|c| degree[*c as usize] == 1 && worth[*c as usize] < e.cost)
        };
        let Some((i, core)) = edges.iter().enumerate().find_map(|(i, e)| Some((i, poor(e)?)))
        else {
            return dropped;
        };
        edges.remove(i);
        dropped.push(core);
    }
}
