//! Where lines of a frame cross in the picture: there the farther may begin or cease to be seen.
//!
//! Each crossing is found in one square of the picture, among the few segments that pass through it.

use crate::path::{Kind, Path, Place};
use crate::view::View;
use chiaro_basis::math::DVec2;

/// Lines meet in space where their depths differ by less than this, in parts of the depth.
const MEET: f64 = 1e-3;
/// Greatest and least side of the squares in which crossings are looked for, pixels.
const CELL: [f64; 2] = [8.0, 2.0];
/// How many lines a square may hold on the mean.
const HELD: f64 = 0.25;

/// A segment in the picture.
struct Straight {
    path: u32,
    index: u32,
    a: DVec2,
    b: DVec2,
    depth: [f64; 2],
    kind: Kind,
}

/// For each path, the places where a nearer line crosses it. What is `buried` changes nothing that is
/// seen.
pub(crate) fn crossings(paths: &[Path], buried: &[Vec<bool>], view: &View) -> Vec<Vec<Place>> {
    let lines = lines(paths, buried);
    let cells = Cells::of(&lines, view);
    let mut cuts: Vec<Vec<Place>> = paths.iter().map(|_| Vec::new()).collect();
    for (cell, members) in cells.members() {
        for (i, &a) in members.iter().enumerate() {
            for &b in &members[i + 1..] {
                let (a, b) = (&lines[a as usize], &lines[b as usize]);
                if [a.kind, b.kind].iter().any(|k| cuts_others(*k)) {
                    cross(a, b, |p| cells.cell(p) == cell, &mut cuts);
                }
            }
        }
    }
    cuts
}

fn lines(paths: &[Path], buried: &[Vec<bool>]) -> Vec<Straight> {
    let mut lines = Vec::new();
    for (p, path) in paths.iter().enumerate() {
        for (k, segment) in path.segments.iter().enumerate() {
            let gone = segment.buried || buried[p].get(k).is_some_and(|b| *b);
            if let (Some(a), Some(b), false) = (path.seen[k], path.seen[k + 1], gone) {
                lines.push(Straight {
                    path: p as u32,
                    index: k as u32,
                    a: a.at,
                    b: b.at,
                    depth: [a.depth, b.depth],
                    kind: path.kind,
                });
            }
        }
    }
    lines
}

/// Cuts the farther of two segments where they cross.
fn cross(a: &Straight, b: &Straight, here: impl Fn(DVec2) -> bool, cuts: &mut [Vec<Place>]) {
    let apart = |p: f64, q: f64, r: f64, s: f64| p.max(q) < r.min(s) || r.max(s) < p.min(q);
    if apart(a.a.x, a.b.x, b.a.x, b.b.x) || apart(a.a.y, a.b.y, b.a.y, b.b.y) {
        return;
    }
    let (u, v, w) = (a.b - a.a, b.b - b.a, b.a - a.a);
    let det = u.perp_dot(v);
    let (s, t) = (w.perp_dot(v) / det, w.perp_dot(u) / det);
    let inside = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    if !(inside && here(a.a + u * s)) {
        return;
    }
    if a.path == b.path && a.index.abs_diff(b.index) <= 1 {
        return;
    }
    // Depth is not linear in the picture, its inverse is; on short segments both will do.
    let depth = |l: &Straight, t: f64| 1.0 / (1.0 / l.depth[0] * (1.0 - t) + t / l.depth[1]);
    let (za, zb) = (depth(a, s), depth(b, t));
    // What passes through a surface is hidden from there on.
    let meet = (za - zb).abs() < MEET * za;
    let cut = |kind: Kind, nearer: bool| match kind {
        Kind::Intersection => meet,
        _ => kind.occludes() && nearer,
    };
    if cut(a.kind, za < zb) {
        cuts[b.path as usize].push(f64::from(b.index) + t);
    } else if cut(b.kind, zb < za) {
        cuts[a.path as usize].push(f64::from(a.index) + s);
    }
}

/// Whether a line can change what is seen of others that it crosses.
fn cuts_others(kind: Kind) -> bool {
    kind.occludes() || kind == Kind::Intersection
}

/// Squares of the picture with the segments that may pass through each.
struct Cells {
    side: f64,
    columns: usize,
    rows: usize,
    start: Vec<u32>,
    lines: Vec<u32>,
}

impl Cells {
    fn of(lines: &[Straight], view: &View) -> Self {
        let area = (view.size.0 * view.size.1) as f64;
        let side = (HELD * area / lines.len().max(1) as f64).sqrt().clamp(CELL[1], CELL[0]);
        let cells = |p: usize| (p as f64 / side).ceil() as usize + 2;
        let mut this = Self {
            side,
            columns: cells(view.size.0),
            rows: cells(view.size.1),
            start: Vec::new(),
            lines: Vec::new(),
        };
        let mut counts = vec![0u32; this.columns * this.rows + 1];
        lines.iter().for_each(|l| this.each(l, |c| counts[c + 1] += 1));
        for c in 1..counts.len() {
            counts[c] += counts[c - 1];
        }
        let mut at = counts.clone();
        let mut members = vec![0; counts[counts.len() - 1] as usize];
        for (i, line) in lines.iter().enumerate() {
            this.each(line, |c| {
                members[at[c] as usize] = i as u32;
                at[c] += 1;
            });
        }
        this.start = counts;
        this.lines = members;
        this
    }

    /// Column and row; the first of each holds what is left of or above the picture.
    fn grid(&self, p: DVec2) -> (usize, usize) {
        let clamp =
            |x: f64, n: usize| ((x / self.side).floor() + 1.0).clamp(0.0, (n - 1) as f64) as usize;
        (clamp(p.x, self.columns), clamp(p.y, self.rows))
    }

    fn cell(&self, p: DVec2) -> usize {
        let (x, y) = self.grid(p);
        y * self.columns + x
    }

    fn each(&self, line: &Straight, mut visit: impl FnMut(usize)) {
        let (top, bottom) = if line.a.y <= line.b.y { (line.a, line.b) } else { (line.b, line.a) };
        let (y0, y1) = (self.grid(top).1, self.grid(bottom).1);
        let slope = (bottom.x - top.x) / (bottom.y - top.y);
        for y in y0..=y1 {
            // The part of the line in this row, and a little more.
            let edge = |row: usize| (row as f64 - 1.0) * self.side;
            let at = |height: f64| top.x + slope * (height - top.y);
            let from = if y == y0 { top.x } else { at(edge(y)) };
            let to = if y == y1 { bottom.x } else { at(edge(y + 1)) };
            let column = |x: f64| self.grid(DVec2::new(x, 0.0)).0;
            let (x0, x1) = (column(from.min(to) - 1e-6), column(from.max(to) + 1e-6));
            for x in x0..=x1 {
                visit(y * self.columns + x);
            }
        }
    }

    fn members(&self) -> impl Iterator<Item = (usize, &[u32])> {
        (0..self.start.len() - 1).filter_map(|c| {
            let members = &self.lines[self.start[c] as usize..self.start[c + 1] as usize];
            (members.len() > 1).then_some((c, members))
        })
    }
}
