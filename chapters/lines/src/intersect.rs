//! Lines along which pieces of the surface pass through each other, or through themselves.
//!
//! 1. Faces that share a tile of the picture and of space are tried in pairs, unless they share a
//!    corner. Beyond [`MANY`] faces pieces are tried against others alone.
//! 2. Two faces share a segment. Its ends are where an edge of one goes through the other, and so
//!    belong to the neighbour across that edge too: by them segments are chained.
//! 3. A chain runs along n_f x n_g, f of the piece that is numbered first: the same way in every frame.
//!
//! Faces that only touch, or lie in one plane, share no line.

use crate::contour::{Sags, Scenery};
use crate::path::{Kind, Path, Point, Segment};
use crate::sight::Sight;
use crate::surface::{NONE, Surface};
use chiaro_basis::math::DVec3;
use std::collections::{BTreeMap, HashMap};

/// What is behind a face by less than this counts as before it, in parts of the face's size: feet on
/// a floor only touch it.
const TOUCH: f64 = 1e-5;

/// Faces beyond which no piece is tried against itself.
const MANY: usize = 100_000;

/// An edge that goes through a face: its creases' two sides are one.
type Hole = (u32, u32);

/// What two faces share.
struct Shared {
    faces: [u32; 2],
    ends: [Hole; 2],
}

/// The paths along which pieces meet, where the picture may show them.
pub(crate) fn intersections(scenery: &Scenery<'_>, sight: &Sight<'_>) -> Vec<Path> {
    let pieces = &scenery.surface.pieces;
    if pieces.len() > MANY && pieces.iter().all(|p| *p == 0) {
        return Vec::new();
    }
    let pairs = pairs(scenery, sight);
    if pairs.is_empty() {
        return Vec::new();
    }
    let edges = Edges::of(scenery.surface);
    let mut holes = HashMap::new();
    let mut shared = Vec::new();
    for (f, g) in pairs {
        if let Some(ends) = edges.holes(scenery, (f, g), &mut holes) {
            shared.push(Shared { faces: [f, g], ends });
        }
    }
    let chains = chained(&shared);
    let mut sags = Sags::new(scenery);
    let chains = chains.iter().enumerate();
    chains.map(|(i, c)| path(i as u32, c, &shared, (&holes, &mut sags), scenery)).collect()
}

/// A face, or a piece, with its least and greatest coordinates.
#[derive(Clone, Copy)]
struct Boxed {
    face: u32,
    low: DVec3,
    high: DVec3,
}

impl Boxed {
    fn nothing(face: u32) -> Self {
        Self { face, low: DVec3::INFINITY, high: DVec3::NEG_INFINITY }
    }

    fn grow(&mut self, low: DVec3, high: DVec3) {
        self.low = self.low.min(low);
        self.high = self.high.max(high);
    }

    fn of(face: u32, scenery: &Scenery<'_>) -> Self {
        let corners = scenery.surface.faces[face as usize];
        let [a, b, c] = corners.map(|v| scenery.posed.positions[v as usize]);
        Self { face, low: a.min(b).min(c), high: a.max(b).max(c) }
    }

    fn meets(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

/// Faces that pass through each other's planes in the picture, each pair once, rising.
fn pairs(scenery: &Scenery<'_>, sight: &Sight<'_>) -> Vec<(u32, u32)> {
    let pieces = &scenery.surface.pieces;
    let piece = |b: &Boxed| pieces[b.face as usize];
    let (regions, all) = (regions(scenery, sight), pieces.len() <= MANY);
    let tried = |a: &Boxed, b: &Boxed| {
        piece(a) != piece(b) || (all && !touch(scenery.surface, a.face, b.face))
    };
    let mut pairs = Vec::new();
    let mut here: Vec<Boxed> = Vec::new();
    for faces in sight.tiles() {
        let first = faces.first().map(|f| pieces[*f as usize]);
        if !all && faces.iter().all(|f| Some(pieces[*f as usize]) == first) {
            continue;
        }
        here.clear();
        let boxes = faces.iter().map(|&f| Boxed::of(f, scenery));
        here.extend(boxes.filter(|b| all || regions[piece(b) as usize].meets(b)));
        here.sort_by(|a, b| a.low.x.total_cmp(&b.low.x).then(a.face.cmp(&b.face)));
        for (i, a) in here.iter().enumerate() {
            for b in here[i + 1..].iter().take_while(|b| b.low.x <= a.high.x) {
                if a.meets(b)
                    && tried(a, b)
                    && is_split(scenery, a.face, b.face)
                    && is_split(scenery, b.face, a.face)
                {
                    pairs.push((a.face.min(b.face), a.face.max(b.face)));
                }
            }
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Whether two faces share a corner; the sides of a crease do.
fn touch(surface: &Surface, a: u32, b: u32) -> bool {
    let corners = |f: u32| surface.faces[f as usize].map(|v| surface.anchors[v as usize]);
    let (a, b) = (corners(a), corners(b));
    a.iter().any(|p| b.contains(p))
}

/// For each piece, a box that holds all of it that is within the boxes of others, as far as the picture shows them.
fn regions(scenery: &Scenery<'_>, sight: &Sight<'_>) -> Vec<Boxed> {
    let pieces = &scenery.surface.pieces;
    let count = pieces.iter().max().map_or(0, |p| *p + 1);
    let mut boxes: Vec<Boxed> = (0..count).map(Boxed::nothing).collect();
    for f in sight.tiles().flatten() {
        let face = Boxed::of(*f, scenery);
        boxes[pieces[*f as usize] as usize].grow(face.low, face.high);
    }
    let mut regions: Vec<Boxed> = (0..count).map(Boxed::nothing).collect();
    boxes.sort_by(|a, b| a.low.x.total_cmp(&b.low.x).then(a.face.cmp(&b.face)));
    for (i, a) in boxes.iter().enumerate() {
        for b in boxes[i + 1..].iter().take_while(|b| b.low.x <= a.high.x) {
            if a.meets(b) {
                let (low, high) = (a.low.max(b.low), a.high.min(b.high));
                regions[a.face as usize].grow(low, high);
                regions[b.face as usize].grow(low, high);
            }
        }
    }
    regions
}

/// Whether a face has corners on both sides of the plane of another.
fn is_split(scenery: &Scenery<'_>, face: u32, by: u32) -> bool {
    let plane = Plane::of(scenery, by);
    let corners = scenery.surface.faces[face as usize];
    let before = |v: u32| plane.before(scenery.posed.positions[v as usize]).1;
    let first = before(corners[0]);
    corners[1..].iter().any(|v| before(*v) != first)
}

/// The plane of a face.
struct Plane {
    corners: [DVec3; 3],
    normal: DVec3,
    least: f64,
}

impl Plane {
    fn of(scenery: &Scenery<'_>, face: u32) -> Self {
        let corners =
            scenery.surface.faces[face as usize].map(|v| scenery.posed.positions[v as usize]);
        let normal = scenery.posed.face_normals[face as usize];
        let size = corners[0].distance(corners[1]).max(corners[1].distance(corners[2]));
        Self { corners, normal, least: TOUCH * size }
    }

    /// The distance of a point, and whether that counts as before the plane.
    fn before(&self, p: DVec3) -> (f64, bool) {
        let d = (p - self.corners[0]).dot(self.normal);
        (d, d >= -self.least)
    }
}

/// Edges as they are in space: the two sides of a crease have one name.
struct Edges<'a> {
    surface: &'a Surface,
    twin: HashMap<u32, u32>,
}

impl<'a> Edges<'a> {
    fn of(surface: &'a Surface) -> Self {
        let edge = |h: u32| surface.edge[h as usize];
        let twin = surface.creases.iter().map(|c| (edge(c.right), edge(c.left))).collect();
        Self { surface, twin }
    }

    fn of_face(&self, face: u32) -> [u32; 3] {
        [0, 1, 2].map(|k| {
            let edge = self.surface.edge[(3 * face + k) as usize];
            self.twin.get(&edge).copied().unwrap_or(edge)
        })
    }

    /// The two places where the edges of two faces go through the other; `known` is told how far
    /// along its edge each is.
    fn holes(
        &self,
        scenery: &Scenery<'_>,
        (f, g): (u32, u32),
        known: &mut HashMap<Hole, f64>,
    ) -> Option<[Hole; 2]> {
        let mut found = [(NONE, NONE); 2];
        let mut count = 0;
        for (from, to) in [(f, g), (g, f)] {
            for edge in self.of_face(from) {
                let hole = (edge, to);
                let Some(t) = through(scenery, hole) else { continue };
                known.insert(hole, t);
                *found.get_mut(count)? = hole;
                count += 1;
            }
        }
        (count == 2).then_some(found)
    }
}

/// How far along an edge it goes through a face, if it does.
fn through(scenery: &Scenery<'_>, (edge, face): Hole) -> Option<f64> {
    let [a, b] = scenery.surface.ends(edge).map(|v| scenery.posed.positions[v as usize]);
    let plane = Plane::of(scenery, face);
    let ((da, a_before), (db, b_before)) = (plane.before(a), plane.before(b));
    if a_before == b_before {
        return None;
    }
    let t = (da / (da - db)).clamp(0.0, 1.0);
    let at = a.lerp(b, t);
    let inside = (0..3).all(|i| {
        let (u, v) = (plane.corners[i], plane.corners[(i + 1) % 3]);
        (v - u).cross(at - u).dot(plane.normal) >= 0.0
    });
    inside.then_some(t)
}

/// Segments in a row, each with the hole by which it is left.
struct Chain {
    first: Hole,
    steps: Vec<(usize, Hole)>,
    closed: bool,
}

fn chained(shared: &[Shared]) -> Vec<Chain> {
    let mut at: BTreeMap<Hole, Vec<usize>> = BTreeMap::new();
    for (i, s) in shared.iter().enumerate() {
        s.ends.iter().for_each(|e| at.entry(*e).or_default().push(i));
    }
    let mut done = vec![false; shared.len()];
    let mut chains = Vec::new();
    let ends = at.iter().filter(|(_, segments)| segments.len() != 2).map(|(hole, _)| *hole);
    let starts: Vec<Hole> = ends.chain(shared.iter().map(|s| s.ends[0])).collect();
    for first in starts {
        while let Some(&start) = at[&first].iter().find(|s| !done[**s]) {
            let mut chain = Chain { first, steps: Vec::new(), closed: false };
            let (mut segment, mut hole) = (start, first);
            loop {
                done[segment] = true;
                let [a, b] = shared[segment].ends;
                hole = if hole == a { b } else { a };
                chain.steps.push((segment, hole));
                match at[&hole][..] {
                    [x, y] if !done[x] || !done[y] => segment = if done[x] { y } else { x },
                    _ => break,
                }
            }
            chain.closed = hole == first && chain.steps.len() > 2;
            chains.push(chain);
        }
    }
    chains
}

fn path(
    index: u32,
    chain: &Chain,
    shared: &[Shared],
    (holes, sags): (&HashMap<Hole, f64>, &mut Sags<'_>),
    scenery: &Scenery<'_>,
) -> Path {
    let mix = |hole: &Hole, v: &[DVec3]| {
        let [a, b] = scenery.surface.ends(hole.0).map(|v| v as usize);
        v[a].lerp(v[b], holes[hole])
    };
    let at = |hole: &Hole| mix(hole, &scenery.posed.positions);
    let mut point = |(hole, k): (Hole, usize)| {
        let (world, normal) = (at(&hole), mix(&hole, &scenery.posed.normals));
        let next = scenery.next.map(|next| mix(&hole, next));
        let pushed = world + push(hole, (world, normal), scenery, sags);
        Point { world, next, pushed, on_chain: k as f64 }
    };
    let ends = std::iter::once(chain.first).chain(chain.steps.iter().map(|s| s.1));
    let ends: Vec<Hole> = ends.collect();
    let faces: Vec<[u32; 2]> = chain.steps.iter().map(|s| shared[s.0].faces).collect();
    let along = |(ends, faces): (&[Hole], &[u32; 2])| {
        (at(&ends[1]) - at(&ends[0])).dot(direction(scenery, *faces))
    };
    let backwards = ends.windows(2).zip(&faces).map(along).sum::<f64>() < 0.0;
    let order = |k: usize, count: usize| if backwards { count - 1 - k } else { k };
    let points: Vec<Point> =
        (0..ends.len()).map(|k| point((ends[order(k, ends.len())], k))).collect();
    let segment = Segment::of;
    let segments: Vec<Segment> =
        (0..faces.len()).map(|k| segment(faces[order(k, faces.len())])).collect();
    let (view, margin) = (scenery.view, scenery.margin);
    Path::new(Kind::Intersection, index, chain.closed, &points, &segments, view, margin)
}

/// How far an edge's hole in a face is pushed out of both surfaces, where they face the viewer: near outlines
/// the faces around would hide it.
fn push(
    (edge, face): Hole,
    (at, normal): (DVec3, DVec3),
    scenery: &Scenery<'_>,
    sags: &mut Sags<'_>,
) -> DVec3 {
    let posed = scenery.posed;
    let corners = scenery.surface.faces[face as usize];
    let [a, b, c] = corners.map(|v| posed.positions[v as usize] - at);
    let plane = posed.face_normals[face as usize];
    let shares = [b.cross(c), c.cross(a), a.cross(b)].map(|s| s.dot(plane));
    let through = |k: usize| posed.normals[corners[k] as usize] * shares[k];
    let through = through(0) + through(1) + through(2);
    let eye = scenery.view.to_eye(at);
    let mut out = |normal: DVec3, vertices: &[u32]| match normal.normalize_or_zero() {
        n if n.dot(eye) > 0.0 => n * sags.push(vertices),
        _ => DVec3::ZERO,
    };
    out(normal, &scenery.surface.ends(edge)) + out(through, &corners)
}

/// The way along what two faces share: told by which of their pieces, or of themselves, comes first.
fn direction(scenery: &Scenery<'_>, faces: [u32; 2]) -> DVec3 {
    let [a, b] = faces.map(|f| (scenery.surface.pieces[f as usize], f));
    let [a, b] = [a.min(b), a.max(b)].map(|f| scenery.posed.face_normals[f.1 as usize]);
    a.cross(b).normalize_or_zero()
}

/// Numbers the connected pieces of a surface, for each real face.
pub(crate) fn pieces(surface: &Surface) -> Vec<u32> {
    let mut piece = vec![NONE; surface.faces.len()];
    let mut count = 0;
    let mut open = Vec::new();
    for first in 0..surface.real_faces {
        if piece[first] != NONE {
            continue;
        }
        piece[first] = count;
        open.push(first as u32);
        while let Some(face) = open.pop() {
            for half in 3 * face..3 * face + 3 {
                let mate = surface.mate[half as usize];
                if mate != NONE && piece[mate as usize / 3] == NONE {
                    piece[mate as usize / 3] = count;
                    open.push(mate / 3);
                }
            }
        }
        count += 1;
    }
    piece.truncate(surface.real_faces);
    piece
}
