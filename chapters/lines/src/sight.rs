//! [`Sight`]: what hides a point, answered without rays.
//!
//! Every ray of visibility ends in the eye, so the picture itself is the index: faces are sorted
//! into square tiles of it, and a point is compared with the faces of its tile alone. Faces are
//! crossed in homogeneous coordinates, so that those that reach behind the camera need no clipping.
//! Where there are many faces most are hidden: a depth buffer ([`Cover`]) answers first.

use crate::contour::Scenery;
use crate::cover::{Corner, Cover};
use crate::mask::Masks;
use crate::solid::Solids;
use crate::surface::{NONE, Surface};
use crate::view::{Seen, View};
use chiaro_basis::math::DVec2;

/// Sides of tiles that are tried, pixels: the less, the fewer faces in each.
const TILES: [f64; 3] = [2.0, 4.0, 8.0];
/// Tiles are small enough when faces are in so many times as many of them as of the largest.
const SPREAD: f64 = 1.5;
/// Faces from which a depth buffer is worth its while.
const MANY: usize = 50_000;

/// Faces of one frame, sorted into tiles.
pub struct Sight<'a> {
    surface: &'a Surface,
    /// Homogeneous picture coordinates and depth of every vertex.
    vertices: Vec<[f64; 4]>,
    grid: Grid,
    start: Vec<u32>,
    faces: Vec<u32>,
    /// Beside each of `faces`, what it surely stays within: questions touch little else.
    bounds: Vec<Bounds>,
    masks: &'a Masks,
    cover: Option<Cover>,
    /// Whether there is more than one connected piece.
    several: bool,
}

/// Least and greatest picture position of a face, and its least depth; a little too wide.
#[derive(Clone, Copy)]
struct Bounds {
    low: [f32; 2],
    high: [f32; 2],
    near: f32,
}

/// By how much bounds are too wide, in parts of their numbers: more than single precision loses.
const WIDER: f64 = 1e-6;

impl Bounds {
    const NONE: Self = Self { low: [0.0; 2], high: [0.0; 2], near: 0.0 };

    fn of(low: DVec2, high: DVec2, near: f64) -> Self {
        let down = |x: f64| (x - WIDER * x.abs().max(1e-30)) as f32;
        let up = |x: f64| (x + WIDER * x.abs().max(1e-30)) as f32;
        Self { low: [down(low.x), down(low.y)], high: [up(high.x), up(high.y)], near: down(near) }
    }

    fn low(&self) -> DVec2 {
        DVec2::new(f64::from(self.low[0]), f64::from(self.low[1]))
    }

    fn high(&self) -> DVec2 {
        DVec2::new(f64::from(self.high[0]), f64::from(self.high[1]))
    }

    /// A place and a depth as they are asked about.
    fn ask(seen: &Seen) -> ([f32; 2], f32) {
        ([seen.at.x as f32, seen.at.y as f32], (seen.depth * (1.0 + WIDER)) as f32)
    }

    fn may_hide(&self, [x, y]: [f32; 2], depth: f32) -> bool {
        let inside = (self.low[0] <= x) & (x <= self.high[0]) & (self.low[1] <= y);
        inside & (y <= self.high[1]) & (self.near <= depth)
    }
}

impl<'a> Sight<'a> {
    /// Sorts the faces that hide what is behind; `masks`: holes in faces.
    pub(crate) fn new(scenery: &Scenery<'a>, masks: &'a Masks, solids: &Solids) -> Self {
        let Scenery { surface, posed, view, .. } = *scenery;
        let vertices: Vec<[f64; 4]> =
            posed.positions.iter().map(|p| view.homogeneous(*p)).collect();
        let near = f64::from(view.pose.near).max(1e-9);
        let whole = Grid::of(view, scenery.margin, TILES[2]);
        let mut shown: Vec<(u32, Bounds)> = Vec::new();
        let mut cover = (surface.real_faces >= MANY).then(|| Cover::new(view));
        let flat: Vec<DVec2> =
            vertices.iter().map(|[x, y, w, _]| DVec2::new(x / w, y / w)).collect();
        let corner = |cover: &Cover, v: usize| cover.corner(flat[v], vertices[v][3]);
        let covering: Vec<Corner> =
            cover.iter().flat_map(|c| (0..flat.len()).map(|v| corner(c, v))).collect();
        for (f, face) in surface.faces[..surface.real_faces].iter().enumerate() {
            let corners = face.map(|v| vertices[v as usize]);
            let Some(front) = shows_front(&corners) else { continue };
            if !surface.hides(f, front) {
                continue;
            }
            let nearest = corners.iter().map(|c| c[3]).fold(f64::INFINITY, f64::min);
            let extent = if nearest > near {
                let [a, b, c] = face.map(|v| flat[v as usize]);
                Some((a.min(b).min(c), a.max(b).max(c)))
            } else {
                extent(&corners, near)
            };
            let Some((low, high)) = extent else { continue };
            let bounds = Bounds::of(low, high, nearest);
            if !whole.reaches(&bounds) {
                continue;
            }
            shown.push((f as u32, bounds));
            if let Some(cover) = &mut cover
                && nearest > near
                && (front || !solids.is_outside(surface.pieces[f]))
                && !masks.has(f as u32)
            {
                cover.add(&face.map(|v| covering[v as usize]));
            }
        }
        if let Some(cover) = &cover {
            shown.retain(|(_, b)| !cover.buries(b.low(), b.high(), f64::from(b.near)));
        }
        let grid = Grid::fitting(view, scenery.margin, &shown);
        let (start, faces, bounds) = grid.sorted(&shown);
        let several = surface.pieces.iter().any(|p| *p != 0);
        Self { surface, vertices, grid, start, faces, bounds, masks, cover, several }
    }

    /// Whether all of these faces have holes ([`NONE`] left out).
    pub(crate) fn is_masked(&self, faces: &[u32]) -> bool {
        let mut real = faces.iter().filter(|f| **f != NONE).peekable();
        real.peek().is_some() && real.all(|f| self.masks.has(*f))
    }

    /// Whether a picture position is in holes of all of these faces ([`NONE`] left out).
    pub(crate) fn in_hole(&self, at: DVec2, faces: &[u32]) -> bool {
        let masks = self.masks;
        let mut real = faces.iter().copied().filter(|f| *f != NONE).peekable();
        real.peek().is_some()
            && real.all(|f| {
                masks.has(f) && {
                    let weights = self.weights(f, at).map(|w| w.max(0.0));
                    let sum: f64 = weights.iter().sum();
                    sum > 0.0 && masks.is_hole(f, weights.map(|w| w / sum))
                }
            })
    }

    /// The weights of a face's corners at a picture position, up to a factor; all of one sign where
    /// the face covers it.
    fn weights(&self, face: u32, at: DVec2) -> [f64; 3] {
        let corners = self.surface.faces[face as usize].map(|v| self.vertices[v as usize]);
        let local = corners.map(|[x, y, w, _]| [x - at.x * w, y - at.y * w]);
        let side = |i: usize, j: usize| local[i][0] * local[j][1] - local[i][1] * local[j][0];
        let weights = [side(1, 2), side(2, 0), side(0, 1)];
        if weights.iter().sum::<f64>() < 0.0 { weights.map(|w| -w) } else { weights }
    }

    /// Whether a depth buffer answers at all.
    pub(crate) fn is_covered(&self) -> bool {
        self.cover.is_some()
    }

    /// Whether the depth buffer, if there is one, knows that a place is hidden.
    pub(crate) fn surely_hidden(&self, at: DVec2, depth: f64) -> bool {
        self.cover.as_ref().is_some_and(|c| c.hides(at, depth))
    }

    /// Whether some face other than `own` hides a point, at least `slack` (scene units) nearer than it is; a point
    /// `pushed` out of the surface for faces of its own piece, there and where it is for those of others: what stands
    /// on a floor is not pushed into it. Far outside the picture nothing is hidden.
    pub fn hidden(&self, [pushed, plain]: [Seen; 2], slack: f64, own: &[u32; 2]) -> bool {
        let Some(tile) = self.grid.at(pushed.at) else { return false };
        if self.surely_hidden(pushed.at, pushed.depth) {
            return true;
        }
        let pieces = &self.surface.pieces;
        let of = |f: u32| pieces.get(f as usize).copied();
        let own_pieces = own.map(of);
        // Where two pieces meet neither is its own.
        let own_piece =
            own_pieces.into_iter().flatten().reduce(|p, q| if p == q { p } else { NONE });
        let is_own = |f: u32| own_piece.is_some_and(|p| of(f) == Some(p));
        let nearer = |f: u32, Seen { at, depth }: Seen| {
            !own.contains(&f) && self.depth(f, at).is_some_and(|z| z > 0.0 && z < depth - slack)
        };
        if !self.several || own_piece.is_none() || pushed == plain {
            return self.faces_at(tile, [&pushed; 2]).any(|f| nearer(f, pushed));
        }
        // What others hide they hide at both places: near an outline they may reach into its facets.
        let beside = self.grid.at(plain.at).filter(|t| *t != tile);
        let mut before = [false; 2];
        for f in self.faces_at(tile, [&pushed, &plain]) {
            if is_own(f) {
                if nearer(f, pushed) {
                    return true;
                }
            } else {
                before[0] = before[0] || nearer(f, pushed);
                before[1] = before[1] || (beside.is_none() && nearer(f, plain));
            }
            if before == [true; 2] {
                return true;
            }
        }
        let hides = |f: u32| !is_own(f) && nearer(f, plain);
        let there = || beside.is_some_and(|t| self.faces_at(t, [&plain; 2]).any(hides));
        before[0] && (before[1] || there())
    }

    /// The faces of a tile that may be before one of two points.
    fn faces_at(&self, tile: usize, asked: [&Seen; 2]) -> impl Iterator<Item = u32> {
        let [p, q] = asked.map(Bounds::ask);
        let range = self.start[tile] as usize..self.start[tile + 1] as usize;
        let faces = self.faces[range.clone()].iter().zip(&self.bounds[range]);
        faces.filter(move |(_, b)| b.may_hide(p.0, p.1) | b.may_hide(q.0, q.1)).map(|(f, _)| *f)
    }

    /// The faces of each tile.
    pub(crate) fn tiles(&self) -> impl Iterator<Item = &[u32]> {
        let range = |w: &[u32]| w[0] as usize..w[1] as usize;
        self.start.windows(2).map(move |w| &self.faces[range(w)])
    }

    /// The depth at which a face covers a picture position.
    fn depth(&self, face: u32, at: DVec2) -> Option<f64> {
        let corners = self.surface.faces[face as usize].map(|v| self.vertices[v as usize]);
        let weights = self.weights(face, at);
        let sum: f64 = weights.iter().sum();
        if weights.iter().any(|w| *w < 0.0) || sum == 0.0 {
            return None;
        }
        if self.masks.has(face) && self.masks.is_hole(face, weights.map(|w| w / sum)) {
            return None;
        }
        Some((0..3).map(|i| weights[i] * corners[i][3]).sum::<f64>() / sum)
    }
}

/// Whether a face shows its front (its corners turn counter-clockwise on paper, y down); `None`
/// edge-on.
pub(crate) fn shows_front(c: &[[f64; 4]; 3]) -> Option<bool> {
    let [a, b, d] = [0, 1, 2].map(|i| [c[i][0], c[i][1], c[i][2]]);
    let det = a[0] * (b[1] * d[2] - b[2] * d[1]) - a[1] * (b[0] * d[2] - b[2] * d[0])
        + a[2] * (b[0] * d[1] - b[1] * d[0]);
    (det != 0.0).then_some(det < 0.0)
}

/// Least and greatest picture position of what of a face is in front of the camera.
pub(crate) fn extent(corners: &[[f64; 4]; 3], near: f64) -> Option<(DVec2, DVec2)> {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let mut take = |x: f64, y: f64, w: f64| {
        let p = DVec2::new(x / w, y / w);
        low = low.min(p);
        high = high.max(p);
    };
    for i in 0..3 {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        if a[3] > near {
            take(a[0], a[1], a[2]);
        }
        if (a[3] > near) != (b[3] > near) {
            let t = (near - a[3]) / (b[3] - a[3]);
            let mix = |k: usize| a[k] + (b[k] - a[k]) * t;
            take(mix(0), mix(1), mix(2));
        }
    }
    (low.x <= high.x && low.y <= high.y).then_some((low, high))
}

/// Square tiles of the picture and of a rim around it: lines are followed out of it.
struct Grid {
    tile: f64,
    /// Columns and rows of tiles left of and above the picture.
    rim: f64,
    columns: usize,
    rows: usize,
}

impl Grid {
    fn of(view: &View, margin: f64, tile: f64) -> Self {
        let tiles = |pixels: f64| (pixels / tile).ceil() as usize;
        let rim = tiles(margin);
        let [columns, rows] = [view.size.0, view.size.1].map(|n| tiles(n as f64).max(1) + 2 * rim);
        Self { tile, rim: rim as f64, columns, rows }
    }

    /// Tiles as small as makes sense for some faces.
    fn fitting(view: &View, margin: f64, faces: &[(u32, Bounds)]) -> Self {
        let [small, middle, large] = TILES.map(|tile| Self::of(view, margin, tile));
        let entries = |grid: &Self| faces.iter().map(|(_, b)| grid.count(b)).sum::<usize>() as f64;
        let most = SPREAD * entries(&large);
        match () {
            () if entries(&small) <= most => small,
            () if entries(&middle) <= most => middle,
            () => large,
        }
    }

    /// A picture position in tiles from the first; what is whole in it tells the tile.
    fn place(&self, p: DVec2) -> DVec2 {
        p / self.tile + self.rim
    }

    /// The tile of a picture position.
    fn at(&self, p: DVec2) -> Option<usize> {
        let place = self.place(p);
        let inside = place.cmpge(DVec2::ZERO).all()
            && place.x < self.columns as f64
            && place.y < self.rows as f64;
        inside.then(|| place.y as usize * self.columns + place.x as usize)
    }

    /// Whether a face may cover any tile.
    fn reaches(&self, bounds: &Bounds) -> bool {
        let [low, high] = [bounds.low(), bounds.high()].map(|p| self.place(p));
        low.x < self.columns as f64 && low.y < self.rows as f64 && high.x >= 0.0 && high.y >= 0.0
    }

    /// First and last column and row of the tiles that a face may cover.
    fn span(&self, bounds: &Bounds) -> Option<[u32; 4]> {
        let (w, h) = (self.columns as f64, self.rows as f64);
        let [low, high] = [bounds.low(), bounds.high()].map(|p| self.place(p));
        let clamp = |v: f64, most: f64| v.clamp(0.0, most - 1.0) as u32;
        let span = || [clamp(low.x, w), clamp(low.y, h), clamp(high.x, w), clamp(high.y, h)];
        self.reaches(bounds).then(span)
    }

    /// How many tiles a face may cover.
    fn count(&self, bounds: &Bounds) -> usize {
        let count = |[x0, y0, x1, y1]: [u32; 4]| (x1 - x0 + 1) as usize * (y1 - y0 + 1) as usize;
        self.span(bounds).map_or(0, count)
    }

    fn for_tiles(&self, bounds: &Bounds, mut each: impl FnMut(usize)) {
        let Some([x0, y0, x1, y1]) = self.span(bounds) else { return };
        for y in y0..=y1 {
            for x in x0..=x1 {
                each(y as usize * self.columns + x as usize);
            }
        }
    }

    /// Faces tile by tile: where those of each begin, which they are, and their bounds.
    fn sorted(&self, faces: &[(u32, Bounds)]) -> (Vec<u32>, Vec<u32>, Vec<Bounds>) {
        let count = self.columns * self.rows;
        let mut start = vec![0u32; count + 1];
        for (_, bounds) in faces {
            self.for_tiles(bounds, |t| start[t + 1] += 1);
        }
        for t in 0..count {
            start[t + 1] += start[t];
        }
        let mut at = start.clone();
        let mut sorted = vec![0; start[count] as usize];
        let mut beside = vec![Bounds::NONE; sorted.len()];
        for (face, bounds) in faces {
            self.for_tiles(bounds, |t| {
                sorted[at[t] as usize] = *face;
                beside[at[t] as usize] = *bounds;
                at[t] += 1;
            });
        }
        (start, sorted, beside)
    }
}
