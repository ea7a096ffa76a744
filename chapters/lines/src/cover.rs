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
const SMALL: f64 = 24.0;

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

    /// Adds a face: homogeneous corners with their depths, all in front of the camera.
    pub(crate) fn add(&mut self, corners: &[[f64; 4]; 3]) {
        let [a, b, c] = corners.map(|[x, y, w, _]| [(x / w) as f32 - 0.5, (y / w) as f32 - 0.5]);
        let q = corners.map(|c| self.nearness(c[3]) as f32);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let least = |k: usize| a[k].min(b[k]).min(c[k]).ceil().max(0.0) as usize;
        let most = |k: usize, n: usize| {
            let m = a[k].max(b[k]).max(c[k]).floor();
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
            let row = &mut self.near[y * self.columns..(y + 1) * self.columns];
            for (x, here) in row.iter_mut().enumerate().take(x1).skip(x0) {
                let (fx, fy) = (x as f32, y as f32);
                let [u, v] = [edge(b, c, fx, fy), edge(c, a, fx, fy)];
                let w = 1.0 - u - v;
                if u >= 0.0 && v >= 0.0 && w >= 0.0 {
                    *here = here.max(u * q[0] + v * q[1] + w * q[2]);
                }
            }
        }
    }

    /// Whether something well in front covers the four pixel centres around a place.
    pub(crate) fn hides(&self, at: DVec2, depth: f64) -> bool {
        let (x, y) = ((at.x - 0.5).floor(), (at.y - 0.5).floor());
        if !(x >= 0.0 && y >= 0.0 && x + 1.0 < self.columns as f64 && y + 1.0 < self.rows as f64) {
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
        let (low, high) = ((low - 0.5).floor(), (high - 0.5).ceil());
        let inside = low.x >= 0.0 && low.y >= 0.0 && high.x < w && high.y < h;
        if !inside || (high - low).max_element() > SMALL {
            return false;
        }
        let limit = self.limit(depth);
        (low.y as usize..=high.y as usize).all(|y| {
            let row = y * self.columns;
            self.near[row + low.x as usize..=row + high.x as usize].iter().all(|q| *q > limit)
        })
    }
}
