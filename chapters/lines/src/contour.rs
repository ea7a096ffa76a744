//! Chains of a zero set to paths: places in space, the push against false hiding, and the
//! convexity sign.
//!
//! 1. *Convexity*: on a crossed face, take grad g . (C - p), g linear on the face. Where it is
//!    negative the silhouette lies on the concave side of a fold, and of a solid that is never seen
//!    (`solid`). A crease's strip takes the sign of the dihedral angle instead.
//! 2. *Push*: visibility is asked from p + h n, h = 0.3 max |(p_j - p_i) . n_i| over the one-rings of
//!    the face's vertices (p - h n where the fold is seen from the back): half of the faces that a
//!    silhouette crosses turn away from the camera, and would hide it.

use crate::path::{Kind, Path, Point, Segment};
use crate::posed::Posed;
use crate::slice::{Chain, Crossing, Slice};
use crate::solid::Solids;
use crate::surface::{Crease, NONE, Ring, Surface, previous};
use crate::view::View;
use crate::zeroset::ZeroSet;
use chiaro_basis::math::DVec3;

/// Share of the sag of a one-ring by which points are pushed out.
const PUSH: f64 = 0.3;

/// All that paths are made from, in one frame.
pub struct Scenery<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// Its pose.
    pub posed: &'a Posed,
    /// Positions one frame later, if there is one.
    pub next: Option<&'a [DVec3]>,
    /// The camera.
    pub view: &'a View,
    /// How often normals were smoothed.
    pub passes: u32,
    /// Pixels outside the picture where lines end.
    pub margin: f64,
}

impl Scenery<'_> {
    /// The paths of the silhouettes, g given at the vertices.
    pub fn silhouettes(&self, slice: &Slice, g: &[f64]) -> Vec<Path> {
        self.silhouettes_of(slice, g, &Solids::of(self))
    }

    /// The same where it is known which pieces are solids.
    pub(crate) fn silhouettes_of(&self, slice: &Slice, g: &[f64], solids: &Solids) -> Vec<Path> {
        let mut sags = Sags::new(self);
        let chains = slice.chains.iter().enumerate();
        let path = |(i, chain): (usize, &Chain)| {
            self.silhouette((i as u32, chain), slice, g, &mut sags, solids)
        };
        chains.map(path).collect()
    }

    /// The paths of another zero set; what is not kept of it is never visible.
    pub(crate) fn trimmed(&self, set: &ZeroSet) -> Vec<Path> {
        let mut sags = Sags::new(self);
        let path = |(i, chain): (usize, &Chain)| {
            let crossings = chain.of(&set.slice);
            let around = crossings.iter().take(usize::from(chain.closed));
            let all = crossings.iter().chain(around).enumerate();
            let points: Vec<Point> =
                all.map(|(k, c)| self.crossing(c, k as f64, &mut sags)).collect();
            let start = chain.start as usize;
            let segment = |(k, c): (usize, &Crossing)| Segment {
                buried: !set.keep[start + k],
                ..Segment::of([c.face, NONE])
            };
            let segments: Vec<Segment> = crossings.iter().enumerate().map(segment).collect();
            Path::new(set.kind, i as u32, chain.closed, &points, &segments, self.view, self.margin)
        };
        set.slice.chains.iter().enumerate().map(path).collect()
    }

    fn silhouette(
        &self,
        (index, chain): (u32, &Chain),
        slice: &Slice,
        g: &[f64],
        sags: &mut Sags<'_>,
        solids: &Solids,
    ) -> Path {
        let crossings = chain.of(slice);
        let mut points: Vec<Point> = Vec::with_capacity(crossings.len() + 1);
        let mut segments: Vec<Segment> = Vec::with_capacity(crossings.len());
        let around = crossings.iter().take(usize::from(chain.closed));
        for (k, crossing) in crossings.iter().chain(around).enumerate() {
            let point = self.crossing(crossing, k as f64, sags);
            if let Some(last) = points.last() {
                // Across a strip a silhouette stands still for a moment.
                if last.world.distance_squared(point.world) == 0.0 {
                    if k == crossings.len() {
                        points.last_mut().expect("it has one").on_chain = k as f64;
                    }
                    continue;
                }
                segments.push(self.segment(crossings[k - 1].face, g, last.world, solids));
            }
            points.push(point);
        }
        push_back(&mut points, &segments, chain.closed);
        Path::new(Kind::Silhouette, index, chain.closed, &points, &segments, self.view, self.margin)
    }

    fn crossing(&self, c: &Crossing, on_chain: f64, sags: &mut Sags<'_>) -> Point {
        let [a, b] = self.surface.ends(c.edge).map(|v| v as usize);
        let mix = |v: &[DVec3]| v[a].lerp(v[b], c.at);
        let world = mix(&self.posed.positions);
        let normal = mix(&self.posed.normals).normalize_or_zero();
        let pushed = world + normal * sags.push(&[a as u32, b as u32]);
        Point { world, next: self.next.map(mix), pushed, on_chain }
    }

    fn segment(&self, face: u32, g: &[f64], at: DVec3, solids: &Solids) -> Segment {
        let (own, convex) = match self.surface.is_strip(face as usize) {
            true => match self.surface.crease_of(face as usize) {
                Some(Crease { left, right, .. }) => {
                    ([left / 3, right / 3], self.is_convex(left, right))
                }
                None => return Segment { buried: true, ..Segment::of([NONE; 2]) },
            },
            false => ([face, NONE], self.bends_away(face, g, at)),
        };
        let two_sided = self.surface.sources[own[0] as usize].two_sided;
        let buried = solids.buries(self.surface.pieces[own[0] as usize], convex, two_sided);
        Segment { buried, back: !convex && !buried, ..Segment::of(own) }
    }

    /// Whether g rises towards the eye on a face.
    fn bends_away(&self, face: u32, g: &[f64], at: DVec3) -> bool {
        let corners = self.surface.faces[face as usize];
        let [a, b, c] = corners.map(|v| self.posed.positions[v as usize]);
        let values = corners.map(|v| g[v as usize]);
        let normal = (b - a).cross(c - a);
        // grad g, up to the positive factor |normal|^2.
        let gradient = normal.cross(c - b) * values[0]
            + normal.cross(a - c) * values[1]
            + normal.cross(b - a) * values[2];
        gradient.dot(self.view.to_eye(at)) >= 0.0
    }

    /// Whether the surface bends away from the viewer over the edge between two half-edges.
    pub fn is_convex(&self, left: u32, right: u32) -> bool {
        let normal = self.posed.face_normals[left as usize / 3];
        let apex = self.posed.positions[self.surface.from(previous(right)) as usize];
        (apex - self.posed.positions[self.surface.from(left) as usize]).dot(normal) < 0.0
    }
}

/// Turns the push of points between segments beside which the surface's back is seen.
fn push_back(points: &mut [Point], segments: &[Segment], closed: bool) {
    let count = segments.len();
    let before = |k: usize| match k {
        0 if closed => segments.last(),
        0 => None,
        k => segments.get(k - 1),
    };
    let after = |k: usize| segments.get(if closed && k == count { 0 } else { k });
    for (k, point) in points.iter_mut().enumerate() {
        if [before(k), after(k)].into_iter().flatten().all(|s| s.back) {
            point.pushed = 2.0 * point.world - point.pushed;
        }
    }
}

/// How far the surface leaves the tangent planes around vertices; found when asked for.
pub(crate) struct Sags<'a> {
    scenery: &'a Scenery<'a>,
    known: Vec<f64>,
    ring: Ring,
}

impl<'a> Sags<'a> {
    pub(crate) fn new(scenery: &'a Scenery<'a>) -> Self {
        let known = vec![f64::NAN; scenery.surface.anchors.len()];
        Self { scenery, known, ring: Ring::default() }
    }

    /// How far points at some vertices are pushed out.
    pub(crate) fn push(&mut self, vertices: &[u32]) -> f64 {
        PUSH * vertices.iter().map(|v| self.of(*v)).fold(0.0, f64::max)
    }

    /// The greatest within `passes` rings.
    fn of(&mut self, vertex: u32) -> f64 {
        self.within(vertex, self.scenery.passes)
    }

    fn within(&mut self, vertex: u32, rings: u32) -> f64 {
        let here = self.own(vertex);
        if rings == 0 {
            return here;
        }
        let mut ring = Ring::default();
        ring.walk(self.scenery.surface, vertex);
        ring.around.iter().map(|&v| self.within(v, rings - 1)).fold(here, f64::max)
    }

    fn own(&mut self, vertex: u32) -> f64 {
        let known = self.known[vertex as usize];
        if !known.is_nan() {
            return known;
        }
        let posed = self.scenery.posed;
        self.ring.walk(self.scenery.surface, vertex);
        let (p, n) = (posed.positions[vertex as usize], posed.normals[vertex as usize]);
        let sag = |v: &u32| (posed.positions[*v as usize] - p).dot(n).abs();
        let most = self.ring.around.iter().map(sag).fold(0.0, f64::max);
        self.known[vertex as usize] = most;
        most
    }
}
