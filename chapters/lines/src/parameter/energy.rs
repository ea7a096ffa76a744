//! [`Energy`]: the energies (4.5) to (4.13) as weighted rows of a least-squares problem.
//!
//! Sums over samples stand for integrals over length s and time t, and residuals are pixels, so that
//! neither sampling nor frame rate moves the balance:
//!
//! ```text
//! w_dis  sum (L du - ds)^2 dt / ds      (4.10), (4.11)   L: pixels a unit of u
//! w_proj sum (L (u - u'))^2 ds / dt     (4.7)            u': between two samples one frame later
//! w_end  sum (L u_first)^2 dt + (L (u_last - 1))^2 dt    (4.8), stretched textures alone
//! ```
//!
//! What is hidden of a line between two strokes spreads evenly too: (4.11) over all of it is one row.
//! Periodic textures leave one constant a component free; a weak anchor on every line holds it.

use super::net::{Line, Link, Net};
use super::onward::Across;
use chiaro_solve::{Normal, Rows, Singular};

/// Weight of the anchor, next to the others of order one.
const ANCHOR: f64 = 1e-7;

/// The three weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// w_proj: how much texture follows the surface, per square pixel.
    pub projection: f64,
    /// w_dis: how evenly it spreads.
    pub distortion: f64,
    /// w_end: how firmly stretched textures end where lines do.
    pub end: f64,
}

/// What a net's rows need to know of its textures.
pub(crate) struct Setting<'a> {
    /// Pixels a unit of u, for each line.
    pub(crate) scale: &'a [f64],
    /// Once round in u, for each closed line that closes without a seam.
    pub(crate) period: &'a [Option<f64>],
    /// Length of the interval after each frame, and before it for the last one, in 24ths of a
    /// second.
    pub(crate) dt: &'a [f64],
    /// Whether textures stretch to cover their lines.
    pub(crate) stretched: bool,
}

/// A distortion row.
pub(crate) struct Stretch {
    /// The samples at its ends.
    pub(crate) unknowns: [u32; 2],
    /// Their distance in pixels.
    pub(crate) ds: f64,
    /// Weight at w = 1.
    weight: f64,
    /// ds, less a whole turn where a loop closes.
    target: f64,
}

/// What weights and right sides are changed by.
#[derive(Clone, Copy)]
pub(crate) struct Factors<'a> {
    /// On distortion rows, in their order.
    pub(crate) stiff: &'a [f64],
    /// On links.
    pub(crate) trust: &'a [f64],
    /// What is added to each link's right side, in units of u.
    pub(crate) wraps: &'a [f64],
}

/// Rows with what their weights and right sides are made of.
pub(crate) struct Energy {
    normal: Normal,
    /// What each distortion row is about: the segments', and after them those of what is hidden.
    pub(crate) stretches: Vec<Stretch>,
    /// How many of them are segments'.
    segments: usize,
    /// Weight at w = 1, and what the scale is, of each link row.
    links: Vec<(f64, f64)>,
    /// Weight at w = 1, and right side, of each end row.
    ends: Vec<(f64, f64)>,
    anchors: usize,
}

impl Energy {
    /// The rows of a net, and of what is hidden between its lines; patterns that they share with those `before`
    /// are not factored again.
    pub(crate) fn of(
        net: &Net,
        setting: &Setting<'_>,
        across: &[Across],
        before: Option<&Self>,
    ) -> Self {
        let mut rows = Rows::new(net.unknowns);
        let (links, anchors) = (net.links.len(), net.lines.len());
        let ends = if setting.stretched { 2 * anchors } else { 0 };
        let few = ends + anchors;
        rows.reserve(net.unknowns + links + few, 2 * net.unknowns + 3 * links + few);
        let mut stretches = Vec::with_capacity(net.unknowns);
        for (l, line) in net.lines.iter().enumerate() {
            let (scale, dt) = (setting.scale[l], setting.dt[line.frame as usize]);
            for (k, ([a, b], ds)) in line.segments().enumerate() {
                let closing = k as u32 + 1 == line.count;
                let once = match (closing, setting.period[l]) {
                    (true, None) => continue,
                    (true, Some(period)) => period,
                    (false, _) => 0.0,
                };
                rows.push(&[(b, scale), (a, -scale)]);
                let target = ds - scale * once;
                stretches.push(Stretch { unknowns: [a, b], ds, weight: dt / ds, target });
            }
        }
        let segments = stretches.len();
        for gap in across {
            let (l, [a, b]) = (gap.lines[1] as usize, gap.unknowns);
            let (scale, dt) = (setting.scale[l], setting.dt[net.lines[l].frame as usize]);
            rows.push(&[(b, scale), (a, -scale)]);
            let (ds, target) = (gap.length, gap.length + scale * gap.turns);
            stretches.push(Stretch { unknowns: [a, b], ds, weight: gap.weight * dt / ds, target });
        }
        let mut links = Vec::with_capacity(net.links.len());
        for link in &net.links {
            let [a, b] = link.lines.map(|l| setting.scale[l as usize]);
            let scale = 0.5 * (a + b);
            rows.push(&[
                (link.from, scale),
                (link.to[0], -scale * (1.0 - link.share)),
                (link.to[1], -scale * link.share),
            ]);
            let dt = setting.dt[net.lines[link.lines[0] as usize].frame as usize];
            links.push((link.weight / dt, scale));
        }
        let mut ends = Vec::new();
        if setting.stretched {
            for (l, line) in net.lines.iter().enumerate() {
                end_rows(line, setting, l, &mut rows, &mut ends);
            }
        }
        for (l, line) in net.lines.iter().enumerate() {
            rows.push(&[(line.first, setting.scale[l])]);
        }
        let normal = Normal::after(rows, before.map(|b| &b.normal));
        Self { normal, stretches, segments, links, ends, anchors: net.lines.len() }
    }

    /// The parameters that minimize the energy.
    pub(crate) fn solve(&self, weights: &Weights, by: &Factors<'_>) -> Result<Vec<f64>, Singular> {
        let mut u = vec![0.0; self.normal.rows().unknowns()];
        self.solve_some(weights, by, &vec![true; self.parts()], &mut u)?;
        Ok(u)
    }

    /// The same for `which` of the parts that nothing joins; parameters of the others stay.
    pub(crate) fn solve_some(
        &self,
        weights: &Weights,
        by: &Factors<'_>,
        which: &[bool],
        u: &mut [f64],
    ) -> Result<(), Singular> {
        let Factors { stiff, trust, wraps } = *by;
        let mut weight = Vec::with_capacity(self.normal.rows().len());
        let mut right = Vec::with_capacity(weight.capacity());
        for (stretch, factor) in self.stretches.iter().zip(stiff) {
            weight.push(weights.distortion * stretch.weight * factor);
            right.push(stretch.target);
        }
        for (((w, scale), factor), wrap) in self.links.iter().zip(trust).zip(wraps) {
            weight.push(weights.projection * w * factor);
            right.push(scale * wrap);
        }
        for (w, target) in &self.ends {
            weight.push(weights.end * w);
            right.push(*target);
        }
        weight.extend(std::iter::repeat_n(ANCHOR, self.anchors));
        right.extend(std::iter::repeat_n(0.0, self.anchors));
        self.normal.solve_some(&weight, &right, which, u)
    }

    /// How many parts there are that nothing joins.
    pub(crate) fn parts(&self) -> usize {
        self.normal.parts()
    }

    /// The distortion rows of a part's segments.
    pub(crate) fn segments_of(&self, part: usize) -> impl Iterator<Item = usize> + '_ {
        let rows = self.normal.rows_of(part);
        let end = rows.partition_point(|r| (*r as usize) < self.segments);
        rows[..end].iter().map(|r| *r as usize)
    }

    /// The links of a part.
    pub(crate) fn links_of(&self, part: usize) -> impl Iterator<Item = usize> + '_ {
        let rows = self.normal.rows_of(part);
        let first = self.stretches.len();
        let before = |end: usize| rows.partition_point(|r| (*r as usize) < end);
        rows[before(first)..before(first + self.links.len())]
            .iter()
            .map(move |r| *r as usize - first)
    }

    /// Copies the parameters of parts whose rows are as they were `before` and whose links agreed `then` by
    /// their residuals, and says which they are.
    pub(crate) fn unchanged(
        &self,
        before: &Self,
        then: (&[f64], &[f64]),
        most: f64,
        u: &mut [f64],
    ) -> Vec<bool> {
        let (then, residual) = then;
        let copied = |part: usize| {
            let agreed = |old: &usize| before.links_of(*old).all(|i| residual[i].abs() <= most);
            let old = self.normal.same_before(part).filter(agreed);
            let Some(old) = old.filter(|old| self.is(part, before, *old)) else { return false };
            let unknowns = self.normal.unknowns_of(part).iter();
            for (k, old) in unknowns.zip(before.normal.unknowns_of(old)) {
                u[*k as usize] = then[*old as usize];
            }
            true
        };
        (0..self.parts()).map(copied).collect()
    }

    /// Whether weights and right sides of a part are those of a part that has its left sides.
    fn is(&self, part: usize, before: &Self, old: usize) -> bool {
        let rows = self.normal.rows_of(part).iter().zip(before.normal.rows_of(old));
        rows.into_iter().all(|(r, s)| self.data(*r as usize) == before.data(*s as usize))
    }

    /// Weight, right side, and length or scale of a row.
    fn data(&self, row: usize) -> [f64; 3] {
        let (stretches, links) = (self.stretches.len(), self.links.len());
        if let Some(s) = self.stretches.get(row) {
            return [s.weight, s.target, s.ds];
        }
        if let Some((weight, scale)) = self.links.get(row - stretches) {
            return [*weight, 0.0, *scale];
        }
        let end = self.ends.get(row - stretches - links);
        end.map_or([0.0; 3], |(weight, target)| [*weight, *target, 0.0])
    }

    /// L du / ds of each segment: 1 where the texture has its size, 0 where it stands still,
    /// less where it folds.
    pub(crate) fn slopes(&self, u: &[f64]) -> Vec<f64> {
        let slope =
            |(i, s): (usize, &Stretch)| (self.normal.rows().left(i, u) - s.target + s.ds) / s.ds;
        self.stretches[..self.segments].iter().enumerate().map(slope).collect()
    }

    /// The residual of a link in pixels.
    pub(crate) fn residual(&self, link: usize, u: &[f64], wrap: f64) -> f64 {
        let row = self.stretches.len() + link;
        self.normal.rows().left(row, u) - self.links[link].1 * wrap
    }

    /// The residual of a link in units of u, before it is wrapped.
    pub(crate) fn difference(&self, link: usize, u: &[f64]) -> f64 {
        self.residual(link, u, 0.0) / self.links[link].1
    }
}

fn end_rows(
    line: &Line,
    setting: &Setting<'_>,
    l: usize,
    rows: &mut Rows,
    ends: &mut Vec<(f64, f64)>,
) {
    let (scale, dt) = (setting.scale[l], setting.dt[line.frame as usize]);
    rows.push(&[(line.first, scale)]);
    ends.push((dt, 0.0));
    if !line.closed {
        rows.push(&[(line.first + line.count - 1, scale)]);
        ends.push((dt, scale));
    }
}

impl Link {
    /// What comes to the right side, in units of u, if it passes `turns` times round a line of this
    /// period.
    pub(crate) fn wrap(&self, turns: f64, period: Option<f64>) -> f64 {
        let closing = if self.around { self.share } else { 0.0 };
        (turns + closing) * period.unwrap_or(0.0)
    }
}
