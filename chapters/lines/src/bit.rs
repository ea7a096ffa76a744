//! [`Bits`]: short runs that are drawn all the same.
//!
//! Short runs are specks where triangles are small, and are left out. What is seen of a long straight edge
//! between two things before it is none: without it the edge would have a gap.

use crate::path::Path;
use crate::view::View;
use crate::visibility::Run;

/// The shortest bit, in parts of the shortest line.
const LEAST: f64 = 0.6;

/// The runs of some paths, among which bits are sought.
pub(crate) struct Bits<'a> {
    paths: &'a [Path],
    view: &'a View,
    /// Lines are no shorter, pixels.
    pub(crate) shortest: f64,
    /// By path.
    runs: Vec<(usize, Run)>,
}

impl<'a> Bits<'a> {
    /// The bits of lines of which none is shorter than `shortest` pixels.
    pub(crate) fn of(
        paths: &'a [Path],
        view: &'a View,
        shortest: f64,
        mut runs: Vec<(usize, Run)>,
    ) -> Self {
        runs.sort_by_key(|r| r.0);
        Self { paths, view, shortest, runs }
    }

    /// Whether a run is long enough, or a bit: all on one edge, of which a longer run shows more.
    pub(crate) fn is_drawn(&self, path: usize, run: Run) -> bool {
        let length = |r: Run| self.paths[path].run_length(r);
        if length(run) >= self.shortest {
            return true;
        }
        let edge = run.start.floor();
        let on_edge = |r: Run| r.start < edge + 1.0 && r.end > edge;
        let first = self.runs.partition_point(|r| r.0 < path);
        let mut others = self.runs[first..].iter().take_while(|r| r.0 == path).map(|r| r.1);
        let middle = self.paths[path].seen_at(0.5 * (run.start + run.end));
        run.end <= edge + 1.0
            && length(run) >= LEAST * self.shortest
            && middle.is_some_and(|s| self.view.holds(s.at, 0.0))
            && others.any(|r| on_edge(r) && length(r) >= self.shortest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::{Kind, Point, Segment};
    use chiaro_basis::math::{DVec3, Vec3};
    use chiaro_scene::{Pose, Projection};

    #[test]
    fn bits_of_edges_are_drawn_and_specks_are_not() {
        let projection = Projection::Orthographic { half_height: 50.0 };
        let pose = Pose::look_at(Vec3::Z * 10.0, Vec3::ZERO, Vec3::Y, projection);
        let view = View::new(pose, (100, 100));
        let plain = Segment::of([0; 2]);
        // One edge of 80 pixels, and as long a line of short ones.
        let path = |edges: u32| {
            let point = |k: u32| {
                let x = 80.0 * f64::from(k) / f64::from(edges) - 40.0;
                let world = DVec3::new(x, 0.0, 0.0);
                Point { world, next: None, pushed: world, on_chain: f64::from(k) }
            };
            let points: Vec<Point> = (0..=edges).map(point).collect();
            let segments = vec![plain; edges as usize];
            Path::new(Kind::Crease, 0, false, &points, &segments, &view, 8.0)
        };
        let paths = [path(1), path(40)];
        let part = |path: usize, from: f64, to: f64| {
            let [start, end] = [from, to].map(|l| paths[path].place_at(l));
            (path, Run { start, end })
        };
        let runs = vec![part(1, 0.0, 40.0), part(0, 0.0, 40.0)];
        let bits = Bits::of(&paths, &view, 10.0, runs.clone());
        let drawn = |(path, run): (usize, Run)| bits.is_drawn(path, run);
        assert!(drawn(part(0, 50.0, 57.0)));
        assert!(!drawn(part(1, 50.0, 57.0)), "not where edges are short");
        assert!(!drawn(part(0, 50.0, 54.0)), "not what is hardly seen");
        assert!(drawn(part(1, 50.0, 61.0)));
        let alone = Bits::of(&paths, &view, 10.0, runs[..1].to_vec());
        assert!(!alone.is_drawn(0, part(0, 50.0, 57.0).1), "not where no more of the edge is seen");
    }
}
