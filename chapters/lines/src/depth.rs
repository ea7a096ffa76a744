//! [`Depth`]: a depth buffer, by which previews tell what hides a line.
//!
//! Faces are sorted into bands of rows and drawn band by band, in homogeneous coordinates (Olano and
//! Greer 1997), so that those that reach behind the camera need no clipping. A pixel holds the
//! nearest depth at its centre; what covers no centre is not there. The same for any number of threads.

use crate::contour::Scenery;
use crate::mask::Masks;
use crate::sight::{extent, shows_front};
use crate::surface::Surface;
use chiaro_basis::math::DVec2;
use rayon::prelude::*;

/// Rows of a band.
const BAND: usize = 32;
/// Faces that are sorted at once.
const CHUNK: usize = 1 << 14;

/// The nearest depths of a picture and of the rim in which lines are followed.
pub(crate) struct Depth {
    /// Pixels of the rim on every side.
    rim: usize,
    width: usize,
    height: usize,
    nearest: Vec<f32>,
}

/// A face and the pixels that it may cover: first and last column and row.
#[derive(Clone, Copy)]
struct Item {
    face: u32,
    columns: [u16; 2],
    rows: [u16; 2],
}

/// What draws a frame.
struct Raster<'a> {
    surface: &'a Surface,
    /// Homogeneous picture coordinates and depth of every vertex.
    vertices: Vec<[f64; 4]>,
    masks: &'a Masks,
    near: f64,
    size: [usize; 2],
}

impl Depth {
    /// Draws the faces that hide what is behind; `masks`: holes in faces.
    pub(crate) fn of(scenery: &Scenery<'_>, masks: &Masks) -> Self {
        let Scenery { surface, posed, view, .. } = *scenery;
        let rim = scenery.margin.ceil() as usize;
        let (width, height) = (view.size.0 + 2 * rim, view.size.1 + 2 * rim);
        let moved = |p| {
            let [x, y, w, depth] = view.homogeneous(p);
            [x + rim as f64 * w, y + rim as f64 * w, w, depth]
        };
        let vertices = posed.positions.par_iter().map(|p| moved(*p)).collect();
        let near = f64::from(view.pose.near).max(1e-9);
        let raster = Raster { surface, vertices, masks, near, size: [width, height] };
        let bands = height.div_ceil(BAND).max(1);
        let faces = 0..surface.real_faces;
        let chunks: Vec<Vec<Vec<Item>>> = (0..faces.end.div_ceil(CHUNK))
            .into_par_iter()
            .map(|c| raster.sorted(CHUNK * c..(CHUNK * (c + 1)).min(faces.end), bands))
            .collect();
        let mut nearest = vec![f32::INFINITY; width * height];
        nearest.par_chunks_mut((BAND * width).max(1)).enumerate().for_each(|(b, band)| {
            chunks.iter().flat_map(|c| &c[b]).for_each(|item| raster.draw(item, BAND * b, band));
        });
        Self { rim, width, height, nearest }
    }

    /// The nearest depth at a picture position; nothing is outside of the rim.
    pub(crate) fn at(&self, at: DVec2) -> f64 {
        let at = at + self.rim as f64;
        let inside =
            at.x >= 0.0 && at.y >= 0.0 && at.x < self.width as f64 && at.y < self.height as f64;
        if inside {
            f64::from(self.nearest[at.y as usize * self.width + at.x as usize])
        } else {
            f64::INFINITY
        }
    }
}

impl Raster<'_> {
    /// Some faces by the bands that they touch.
    fn sorted(&self, faces: std::ops::Range<usize>, bands: usize) -> Vec<Vec<Item>> {
        let mut sorted = vec![Vec::new(); bands];
        for face in faces {
            let corners = self.corners(face as u32);
            let Some(front) = shows_front(&corners) else { continue };
            if !self.surface.hides(face, front) {
                continue;
            }
            let Some(item) = self.item(face as u32, &corners) else { continue };
            let [first, last] = item.rows.map(|r| usize::from(r) / BAND);
            sorted[first..=last].iter_mut().for_each(|band| band.push(item));
        }
        sorted
    }

    fn corners(&self, face: u32) -> [[f64; 4]; 3] {
        self.surface.faces[face as usize].map(|v| self.vertices[v as usize])
    }

    fn item(&self, face: u32, corners: &[[f64; 4]; 3]) -> Option<Item> {
        let (low, high) = extent(corners, self.near)?;
        let range = |low: f64, high: f64, n: usize| {
            // The centres within.
            let (first, last) = ((low - 0.5).ceil().max(0.0), (high - 0.5).floor());
            let last = last.min(n as f64 - 1.0);
            (first <= last).then_some([first as u16, last as u16])
        };
        let columns = range(low.x, high.x, self.size[0])?;
        let rows = range(low.y, high.y, self.size[1])?;
        Some(Item { face, columns, rows })
    }

    /// Draws a face into a band that begins at a row.
    fn draw(&self, item: &Item, first: usize, band: &mut [f32]) {
        let width = self.size[0];
        let corners = self.corners(item.face);
        let sides = [side(&corners, 1, 2), side(&corners, 2, 0), side(&corners, 0, 1)];
        let masked = self.masks.has(item.face);
        let rows = band.len() / width.max(1);
        let [top, bottom] = item.rows.map(usize::from);
        for row in top.max(first)..(bottom + 1).min(first + rows) {
            let y = row as f64 + 0.5;
            let at_row = sides.map(|[a, b, c]| (a, b * y + c));
            for column in usize::from(item.columns[0])..=usize::from(item.columns[1]) {
                let x = column as f64 + 0.5;
                let w = at_row.map(|(a, c)| a * x + c);
                if !(w.iter().all(|w| *w >= 0.0) || w.iter().all(|w| *w <= 0.0)) {
                    continue;
                }
                let sum = w[0] + w[1] + w[2];
                let z = (w[0] * corners[0][3] + w[1] * corners[1][3] + w[2] * corners[2][3]) / sum;
                // Also where nothing is left of a face seen from its side.
                if z.is_nan() || z <= self.near {
                    continue;
                }
                let nearest = &mut band[(row - first) * width + column];
                if (z as f32) < *nearest
                    && !(masked && self.masks.is_hole(item.face, w.map(|w| w / sum)))
                {
                    *nearest = z as f32;
                }
            }
        }
    }
}

/// The line through two corners: a x + b y + c, 0 on it.
fn side(corners: &[[f64; 4]; 3], i: usize, j: usize) -> [f64; 3] {
    let ([xi, yi, wi, _], [xj, yj, wj, _]) = (corners[i], corners[j]);
    [yi * wj - wi * yj, wi * xj - xi * wj, xi * yj - yi * xj]
}
