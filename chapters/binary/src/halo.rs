//! Haloes: a gap of paper behind what occludes, so that a contour reads on black as on white.
//!
//! Where the depth steps from one covered pixel to the next, what lies behind the nearer one, on the
//! farther one's side and within the halo's width, is white whatever its label. The contour in front
//! of it is drawn as between two white sides; what lines the gap holds are left out.

use crate::knob::{BinaryKnobs, scaled};
use crate::line::Finder;
use chiaro_image::Plane;
use chiaro_trace::GBuffer;
use rayon::prelude::*;

type Pixel = (usize, usize);

/// The pixels in haloes; `None` where the knobs ask for none.
pub(crate) fn behind(
    buffer: &GBuffer,
    finder: &Finder<'_>,
    knobs: &BinaryKnobs,
) -> Option<Plane<bool>> {
    let (w, h) = buffer.size();
    let width = scaled(knobs.halo, h);
    if width <= 0.0 || !knobs.lines {
        return None;
    }
    let steps = |y: usize| -> Vec<(Pixel, (isize, isize))> {
        (0..w)
            .flat_map(|x| [((x, y), (1, 0)), ((x, y), (0, 1))])
            .filter_map(|(p, d)| step(buffer, finder, p, d))
            .collect()
    };
    let steps: Vec<_> = (0..h).into_par_iter().flat_map_iter(steps).collect();
    let mut gap = Plane::filled(w, h, false);
    for (near, towards) in steps {
        stamp(&mut gap, buffer, (near, towards), width, finder.limit(near));
    }
    Some(gap)
}

/// The nearer pixel of a depth step between a pixel and a neighbour, and where the farther one is.
fn step(
    buffer: &GBuffer,
    finder: &Finder<'_>,
    p: Pixel,
    (dx, dy): (isize, isize),
) -> Option<(Pixel, (isize, isize))> {
    let q = (p.0 + dx as usize, p.1 + dy as usize);
    let inside = q.0 < buffer.size().0 && q.1 < buffer.size().1;
    if !inside || !buffer.covered[p] || !buffer.covered[q] || !finder.hides(p, q) {
        return None;
    }
    Some(if buffer.depth[p] <= buffer.depth[q] { (p, (dx, dy)) } else { (q, (-dx, -dy)) })
}

/// Marks what is behind a pixel, within `width` of its side, at least `least` farther.
fn stamp(
    gap: &mut Plane<bool>,
    buffer: &GBuffer,
    (near, (dx, dy)): (Pixel, (isize, isize)),
    width: f32,
    least: f32,
) {
    let reach = (width + 0.5).ceil() as isize;
    let far = buffer.depth[near] + least;
    for v in -reach..=reach {
        for u in -reach..=reach {
            let on_its_side = u * dx + v * dy > 0;
            if !on_its_side || (u as f32).hypot(v as f32) > width + 0.5 {
                continue;
            }
            let (x, y) = (near.0 as isize + u, near.1 as isize + v);
            if buffer.covered.at(x, y) == Some(&true) {
                let at = (x as usize, y as usize);
                gap[at] |= buffer.depth[at] > far;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line::{Features, Lines};
    use chiaro_basis::math::Vec3;
    use chiaro_scene::{Pose, Projection};

    /// A square at depth 1 before a wall at depth 9.
    fn square() -> GBuffer {
        let projection = Projection::Orthographic { half_height: 240.0 };
        let pose = Pose::look_at(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, projection);
        let mut buffer = GBuffer::empty(&pose, 1.0, (60, 480));
        let depth = |x: usize, y: usize| {
            if (20..40).contains(&x) && (200..240).contains(&y) { 1.0 } else { 9.0 }
        };
        buffer.covered = Plane::filled(60, 480, true);
        buffer.depth = Plane::from_fn(60, 480, depth);
        buffer.position =
            Plane::from_fn(60, 480, |x, y| [x as f32, 240.0 - y as f32, -depth(x, y)]);
        for plane in [&mut buffer.normal, &mut buffer.smooth_normal, &mut buffer.geometric_normal] {
            *plane = Plane::filled(60, 480, [0.0, 0.0, 1.0]);
        }
        buffer
    }

    #[test]
    fn what_occludes_has_a_white_gap_and_a_black_contour() {
        let buffer = square();
        let knobs = BinaryKnobs { halo: 4.0, ..BinaryKnobs::default() };
        let features = Features::find(&buffer, &knobs);
        let black = Plane::filled(60, 480, false);
        let shown = features.haloed(&black);
        let row: Vec<usize> = (0..60).filter(|x| shown[(*x, 220)]).collect();
        assert_eq!(row, [16, 17, 18, 19, 40, 41, 42, 43]);
        let of =
            |shown: &Plane<bool>| Lines::between(&features, shown, &buffer.covered, true, &knobs);
        assert!(of(&shown).black.is_empty(), "black before a gap needs no line");
        let square_white = Plane::from_fn(60, 480, |x, y| buffer.depth[(x, y)] < 2.0);
        let lines = of(&features.haloed(&square_white));
        assert!(!lines.black.is_empty(), "white before a gap has one");
        let none = Features::find(&buffer, &BinaryKnobs::default());
        assert_eq!(none.haloed(&black), black);
    }
}
