//! [`overlap`]: how much of a frame's lines is drawn twice, which a plotter's pen would show.

use crate::stroke::Stroke;
use chiaro_basis::math::DVec2;
use std::collections::HashMap;

/// Lines nearer than this are one on paper, pixels.
const NEAR: f64 = 0.75;
/// Cosine of the greatest angle between lines that run along each other.
const ALONG: f64 = 0.95;
/// Pixels between the places that are compared.
const STEP: f64 = 1.0;
/// A line is beside itself where it comes back after at least so many pixels.
const BACK: f64 = 12.0;
/// Lines that only cross or touch are along each other for less than this, pixels.
const TOUCH: f64 = 6.0;

/// A place of a stroke.
#[derive(Clone, Copy)]
struct Place {
    stroke: usize,
    length: f64,
    at: DVec2,
    along: DVec2,
}

/// The length of strokes in pixels that lies along another stroke, or along another part of its own,
/// within 0.75 px for 6 px and more.
pub fn overlap(strokes: &[Stroke]) -> f64 {
    let cell = |p: DVec2| [p.x, p.y].map(|x| x.floor() as i32);
    let all: Vec<Vec<Place>> = strokes.iter().enumerate().map(|(i, s)| places(i, s)).collect();
    let mut cells: HashMap<[i32; 2], Vec<Place>> = HashMap::new();
    for place in all.iter().flatten() {
        cells.entry(cell(place.at)).or_default().push(*place);
    }
    let doubled = |p: &Place| {
        let [x, y] = cell(p.at);
        let around = (0..9).filter_map(|k| cells.get(&[x + k % 3 - 1, y + k / 3 - 1])).flatten();
        let total = strokes[p.stroke].total();
        let apart = |q: &Place| {
            let way = (p.length - q.length).abs();
            let way = if strokes[p.stroke].closed { way.min(total - way) } else { way };
            q.stroke != p.stroke || way >= BACK
        };
        around
            .into_iter()
            .any(|q| apart(q) && q.at.distance(p.at) < NEAR && q.along.dot(p.along).abs() > ALONG)
    };
    let runs = |places: &Vec<Place>| -> f64 {
        let held: Vec<bool> = places.iter().map(doubled).collect();
        let long = |r: &[bool]| if r[0] && r.len() as f64 * STEP >= TOUCH { r.len() } else { 0 };
        held.chunk_by(|a, b| a == b).map(long).sum::<usize>() as f64 * STEP
    };
    all.iter().map(runs).sum()
}

/// Places along a stroke, evenly.
fn places(stroke: usize, s: &Stroke) -> Vec<Place> {
    let n = s.samples.len();
    let mut places = Vec::new();
    let mut k = 0;
    for i in 0..(s.total() / STEP) as usize {
        let length = i as f64 * STEP;
        while k + 2 < s.length.len() && s.length[k + 1] <= length {
            k += 1;
        }
        let (a, b) = (s.samples[k].at, s.samples[(k + 1) % n].at);
        let step = s.length[k + 1] - s.length[k];
        let share = if step > 0.0 { (length - s.length[k]) / step } else { 0.0 };
        places.push(Place {
            stroke,
            length,
            at: a.lerp(b, share),
            along: (b - a).normalize_or_zero(),
        });
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::{Kind, Path, Point, Segment};
    use crate::view::View;
    use crate::visibility::Run;
    use chiaro_basis::math::{DVec3, Vec3};
    use chiaro_scene::{Pose, Projection};

    fn line(points: &[[f64; 2]]) -> Stroke {
        let projection = Projection::Orthographic { half_height: 50.0 };
        let pose = Pose::look_at(Vec3::Z * 10.0, Vec3::ZERO, Vec3::Y, projection);
        let view = View::new(pose, (100, 100));
        let point = |p: &[f64; 2]| {
            let world = DVec3::new(p[0] - 50.0, 50.0 - p[1], 0.0);
            Point { world, next: None, pushed: world, on_chain: 0.0 }
        };
        let points: Vec<Point> = points.iter().map(point).collect();
        let plain = Segment::of([0; 2]);
        let segments = vec![plain; points.len() - 1];
        let path = Path::new(Kind::Crease, 0, false, &points, &segments, &view, 0.0);
        let run = Run { start: 0.0, end: segments.len() as f64 };
        Stroke::of(&path, run, 3.0, &view, None)
    }

    #[test]
    fn what_is_drawn_twice_is_found() {
        let across = line(&[[10.0, 50.0], [90.0, 50.0]]);
        let crossing = line(&[[50.0, 10.0], [50.0, 90.0]]);
        assert_eq!(overlap(&[across.clone(), crossing]), 0.0);
        let along = line(&[[40.0, 50.3], [70.0, 50.3]]);
        let both = overlap(&[across, along]);
        assert!((both - 60.0).abs() < 4.0, "{both}");
        // There and back again.
        let back = overlap(&[line(&[[10.0, 20.0], [60.0, 20.0], [60.0, 20.5], [10.0, 20.5]])]);
        assert!(back > 60.0, "{back}");
    }
}
