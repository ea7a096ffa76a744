//! Seams: what lies beneath the borders that two fills share.
//!
//! Programs that draw a file antialias each fill for itself, so that the page shines through along a
//! border that two of them share, though they never gap. A stroke along the border, beneath both, in the
//! colour of the fill that is drawn first closes it: a pixel there then has the mean of the two colours
//! by area, exactly. Printers call this trapping.
//!
//! Strokes keep away from what is not covered, so that none is seen beside the fills.

use crate::path::distance;
use crate::{NOTHING, Partition, Path, Point, Segment};
use chiaro_image::Plane;

/// How wide strokes along seams may be, in pixels.
pub const SEAM_WIDTH: f64 = 2.0;

/// How far from the centre of a pixel without a label strokes stay, in pixels: outlines may pass
/// almost a pixel beside it.
const CLEAR: f64 = 0.5 * SEAM_WIDTH + 0.98;

/// The parts of shared borders that a stroke of [`SEAM_WIDTH`] pixels can follow unseen, with the lower of the two
/// labels. `labels` are those that the partition was traced from.
pub fn seams(partition: &Partition, labels: &Plane<u8>) -> Vec<(u8, Path)> {
    let inner = partition.shared().filter(|(_, sides)| !sides.contains(&NOTHING));
    let parts = inner.flat_map(|(path, sides)| {
        let lower = sides[0].min(sides[1]);
        hidden(path, labels).into_iter().map(move |part| (lower, part))
    });
    parts.collect()
}

/// The parts of a path that keep away from what is not covered.
fn hidden(path: &Path, labels: &Plane<u8>) -> Vec<Path> {
    let mut parts: Vec<Path> = Vec::new();
    let (mut from, mut broken) = (path.start, true);
    let mut ahead: Vec<Segment> = path.segments.iter().rev().copied().collect();
    while let Some(segment) = ahead.pop() {
        if is_hidden(from, segment, labels) {
            if std::mem::take(&mut broken) {
                parts.push(Path { start: from, segments: Vec::new(), closed: false });
            }
            parts.iter_mut().last().into_iter().for_each(|p| p.segments.push(segment));
        } else if reach(from, segment) > 1.0 {
            let [first, second] = halves(from, segment);
            ahead.extend([second, first]);
            continue;
        } else {
            broken = true;
        }
        from = segment.end();
    }
    parts
}

/// Whether a stroke along a segment would be over covered pixels alone.
fn is_hidden(from: Point, segment: Segment, labels: &Plane<u8>) -> bool {
    let path = Path { start: from, segments: vec![segment], closed: false };
    path.points(0.05).windows(2).all(|ends| {
        let steps = (2.0 * distance(ends[0], ends[1])).ceil().max(1.0) as usize;
        (0..=steps).all(|i| {
            let t = i as f64 / steps as f64;
            is_inside([0, 1].map(|k| ends[0][k] + t * (ends[1][k] - ends[0][k])), labels)
        })
    })
}

fn is_inside(at: Point, labels: &Plane<u8>) -> bool {
    let [x, y] = at.map(|v| v.floor() as i64);
    let covered = |u: i64, v: i64| match (usize::try_from(u), usize::try_from(v)) {
        (Ok(u), Ok(v)) => u < labels.width() && v < labels.height() && labels[(u, v)] != NOTHING,
        _ => false,
    };
    let far = |u: i64, v: i64| distance(at, [u as f64 + 0.5, v as f64 + 0.5]) > CLEAR;
    (y - 2..=y + 2).all(|v| (x - 2..=x + 2).all(|u| covered(u, v) || far(u, v)))
}

/// A bound of a segment's length.
fn reach(from: Point, segment: Segment) -> f64 {
    match segment {
        Segment::Line(p) => distance(from, p),
        Segment::Cubic(a, b, p) => distance(from, a) + distance(a, b) + distance(b, p),
    }
}

/// The two halves of a segment (de Casteljau).
fn halves(from: Point, segment: Segment) -> [Segment; 2] {
    let middle = |a: Point, b: Point| [0, 1].map(|i| 0.5 * (a[i] + b[i]));
    match segment {
        Segment::Line(p) => [Segment::Line(middle(from, p)), Segment::Line(p)],
        Segment::Cubic(a, b, p) => {
            let (fa, ab, bp) = (middle(from, a), middle(a, b), middle(b, p));
            let (left, right) = (middle(fa, ab), middle(ab, bp));
            [Segment::Cubic(fa, left, middle(left, right)), Segment::Cubic(right, bp, p)]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Fit;

    const HOW: Fit = Fit { tolerance: 0.05, corner: 0.7, blur: 1.0, rounds: 0 };

    #[test]
    fn seams_follow_inner_borders_and_keep_off_the_outside() {
        let disc = |x: usize, y: usize| (x as f64 - 20.0).hypot(y as f64 - 20.0) < 15.0;
        let label = |x: usize, y: usize| if disc(x, y) { u8::from(x + y > 40) } else { NOTHING };
        let labels = Plane::from_fn(40, 40, label);
        let seams = seams(&Partition::trace(&labels, |_, _| 0.5, &HOW), &labels);
        let length: f64 = seams.iter().map(|(_, path)| path.length()).sum();
        assert!((22.0..30.0).contains(&length), "{length} of about 29");
        for (lower, path) in &seams {
            assert_eq!(*lower, 0);
            for p in path.points(0.01) {
                assert!((p[0] + p[1] - 41.0).abs() < 1.0, "{p:?}");
                assert!((p[0] - 20.5).hypot(p[1] - 20.5) < 14.5);
            }
        }
    }

    #[test]
    fn one_colour_has_no_seams() {
        let labels = Plane::filled(9, 9, 1u8);
        assert!(seams(&Partition::trace(&labels, |_, _| 0.5, &HOW), &labels).is_empty());
    }
}
