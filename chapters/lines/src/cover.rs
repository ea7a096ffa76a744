//! [`Cover`]: what surely hides, pixel by pixel, where there are many faces.
//!
//! A buffer of the nearest face at every pixel's centre. What lies well behind the four centres around it is
//! hidden, and nobody needs to be asked; faces that are well behind everywhere hide nothing that is seen.
//! Holes between centres are below a pixel.
//!
//! Stored is nearness, affine in the picture: 1 / depth, or -depth for orthographic cameras.

use crate::view::View;
use chiaro_basis::math::DVec2;

/// How far behind is well behind, in pixels of that depth.
const BEHIND: f64 = 8.0;
/// Greatest side of a part of the picture that is asked as a whole, pixels.
const SMALL: usize = 24;

/// A corner of a face: in the picture, from the centre of its first pixel, and its nearness.
#[derive(Clone, Copy, Default)]
pub(crate) struct Corner {
    at: [f32; 2],
    near: f32,
}

/// The least whole number that is no less than one that is not negative. Rounding is a call where processors are
/// not known to do it.
fn above(x: f64) -> usize {
    let whole = x as usize;
    whole + usize::from((whole as f64) < x)
}

/// The nearest faces of a picture.
pub(crate) struct Cover {
    view: View,
    columns: usize,
    rows: usize,
    near: Vec<f32>,
}

impl Cover {
    /// Nothing yet.
    pub(crate) fn new(view: &View) -> Self {
        let (columns, rows) = view.size;
        Self { view: *view, columns, rows, near: vec![f32::NEG_INFINITY; columns * rows] }
    }

    fn nearness(&self, depth: f64) -> f64 {
        if self.view.perspective() { depth.recip() } else { -depth }
    }

    /// The least nearness at which something at a depth is not well behind.
    fn limit(&self, depth: f64) -> f32 {
        let front = depth - BEHIND * self.view.pixel(depth);
        // What is nearer than so many pixels is behind nothing.
        if front <= 0.0 && self.view.perspective() {
            return f32::INFINITY;
        }
        self.nearness(front) as f32
    }

    /// A corner of a face in front of the camera, as [`Cover::add`] takes it.
    pub(crate) fn corner(&self, at: DVec2, depth: f64) -> Corner {
        Corner { at: [at.x as f32 - 0.5, at.y as f32 - 0.5], near: self.nearness(depth) as f32 }
    }

    /// Adds a face by its corners, all in front of the camera.
    pub(crate) fn add(&mut self, corners: &[Corner; 3]) {
        let ([a, b, c], q) = (corners.map(|c| c.at), corners.map(|c| c.near));
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let least = |k: usize| above(f64::from(a[k].min(b[k]).min(c[k]).max(0.0)));
        let most = |k: usize, n: usize| {
            let m = a[k].max(b[k]).max(c[k]);
            if m < 0.0 { 0 } else { (m as usize + 1).min(n) }
        };
        let (x0, x1, y0, y1) = (least(0), most(0, self.columns), least(1), most(1, self.rows));
        if x0 >= x1 || y0 >= y1 || area == 0.0 {
            return;
        }
        let scale = area.recip();
        // Weight of the corner across from an edge: at a point, and its steps.
        let edge = |p: [f32; 2], r: [f32; 2], x: f32, y: f32| {
            ((p[0] - x) * (r[1] - y) - (p[1] - y) * (r[0] - x)) * scale
        };
        for y in y0..y1 {
            let fy = y as f32;
            let row = &mut self.near[y * self.columns..][x0..x1];
            // Narrow numbers and no branch: four pixels at a time.
            for (x, here) in (x0 as i32..).zip(row) {
                let fx = x as f32;
                let [u, v] = [edge(b, c, fx, fy), edge(c, a, fx, fy)];
                let w = 1.0 - u - v;
                let inside = (u >= 0.0) & (v >= 0.0) & (w >= 0.0);
                let near = u * q[0] + v * q[1] + w * q[2];
                *here = if inside & (near > *here) { near } else { *here };
            }
        }
    }

    /// Whether something well in front covers the four pixel centres around a place.
    pub(crate) fn hides(&self, at: DVec2, depth: f64) -> bool {
        let (x, y) = (at.x - 0.5, at.y - 0.5);
        let (w, h) = (self.columns as f64, self.rows as f64);
        if !(x >= 0.0 && y >= 0.0 && x < w - 1.0 && y < h - 1.0) {
            return false;
        }
        let (first, limit) = (y as usize * self.columns + x as usize, self.limit(depth));
        [first, first + 1, first + self.columns, first + self.columns + 1]
            .iter()
            .all(|&i| self.near[i] > limit)
    }

    /// Whether something well in front covers all of a small part of the picture, for what begins at a
    /// depth.
    pub(crate) fn buries(&self, low: DVec2, high: DVec2, depth: f64) -> bool {
        let (w, h) = (self.columns as f64, self.rows as f64);
        let (low, high) = (low - 0.5, high - 0.5);
        if !(low.x >= 0.0 && low.y >= 0.0 && high.x <= w - 1.0 && high.y <= h - 1.0) {
            return false;
        }
        let [x0, y0] = [low.x as usize, low.y as usize];
        let [x1, y1] = [above(high.x), above(high.y)];
        if (x1 - x0).max(y1 - y0) > SMALL {
            return false;
        }
        let limit = self.limit(depth);
        (y0..=y1).all(|y| self.near[y * self.columns..][x0..=x1].iter().all(|q| *q > limit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::Vec3;
    use chiaro_scene::{Pose, Projection};

    #[test]
    fn a_face_covers_the_centres_within_it_and_buries_what_is_well_behind() {
        let projection = Projection::Orthographic { half_height: 16.0 };
        let pose = Pose::look_at(Vec3::Z * 50.0, Vec3::ZERO, Vec3::Y, projection);
        let mut cover = Cover::new(&View::new(pose, (32, 32)));
        // Reaches out of the picture at its top.
        let corners = [[3.0, -4.0], [29.3, 6.1], [5.0, 27.2]].map(|[x, y]| DVec2::new(x, y));
        let face = corners.map(|at| cover.corner(at, 10.0));
        cover.add(&face);
        let is_inside = |p: DVec2| {
            let side = |k: usize| (corners[(k + 1) % 3] - corners[k]).perp_dot(p - corners[k]);
            [0, 1, 2].map(side).iter().all(|s| *s > 0.0)
        };
        for (i, near) in cover.near.iter().enumerate() {
            let centre = DVec2::new((i % 32) as f64 + 0.5, (i / 32) as f64 + 0.5);
            assert_eq!((near + 10.0).abs() < 1e-4, is_inside(centre), "{centre}");
        }
        let [low, high] = [DVec2::new(8.2, 8.0), DVec2::new(12.0, 13.7)];
        assert!(cover.buries(low, high, 18.5) && !cover.buries(low, high, 17.5));
        assert!(!cover.buries(low, DVec2::new(25.0, 13.7), 18.5), "its border is crossed");
        assert!(cover.hides(low, 18.5) && !cover.hides(low, 17.5));
        assert!(!cover.hides(DVec2::new(0.4, 8.0), 18.5));
    }
}
