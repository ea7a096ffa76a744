//! [`Refinement`]: coarse meshes made fine by midpoints, the same ones in every frame.
//!
//! 1. Every triangle becomes four. The points that were there stay, so that the fine surface passes
//!    through the coarse one's vertices.
//! 2. The midpoint of a smooth edge is that of the curved triangle over it (Vlachos et al. 2001):
//!    m = (a + b) / 2 - ((b - a) . n_a n_a + (a - b) . n_b n_b) / 8, with n the mean of the faces
//!    around, weighed by area: small bevels then leave large flat faces flat.
//!    It moves no farther than a share of the height of the faces beside the edge: across a narrow strip normals
//!    may turn by much, and would throw its long edges far out of it.
//! 3. Creases and borders are curves of their own (a cubic through their points), so that the two
//!    sides of a crease stay together; where they bend, end or meet they are straight up to a corner.
//!    They too keep to a share of the height of the faces beside: where a rim runs along a sliver of a
//!    flat face, as in files of machine parts, it would cross the sliver and fold it over.
//!
//! Everything but the points' places is decided once; a pose costs a few sums a point.

use super::bevel::{find, unite};
use super::{Fold, NONE, next};
use chiaro_basis::math::{DVec3, Vec3};
use std::collections::{BTreeMap, HashMap};

/// A crease that turns by more than this at a point has a corner there: cosine of 50 degrees.
const CORNER: f64 = 0.64;

/// The share of a curved triangle's middle that is bent.
const BEND: f64 = 0.125;
/// How far the middle of a smooth edge may move, in parts of the least height of the faces beside it.
const LIFT: f64 = 0.2;
/// The same for creases and borders: their middle crosses a face from half its height on.
const SHARP_LIFT: f64 = 0.4;

/// A shape's triangles with their neighbours; half-edge 3 f + c runs from corner c of face f to
/// the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Net {
    /// Corners of each face: points.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Where each face comes from.
    pub(super) origins: Vec<Origin>,
    /// The half-edge across each, or [`NONE`].
    pub(super) mate: Vec<u32>,
    /// What becomes of each half-edge; opened ones stay sharp.
    pub(super) folds: Vec<Fold>,
}

/// A face's triangle in the mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    /// Index into the mesh's triangles.
    pub(super) face: u32,
    /// Whether it is turned over.
    pub(super) turned: bool,
    /// Whether the mesh has it twice, once for each side.
    pub(super) twice: bool,
    /// Which part of the triangle: one base-four digit a level, after a leading 1.
    pub(super) part: u16,
}

/// How the points of a refined shape come from its vertices.
#[derive(Clone, Debug, Default)]
pub struct Refinement {
    /// The vertex of the shape at each of the first points.
    base: Vec<u32>,
    levels: Vec<Level>,
}

/// One step: new points in the middle of edges.
#[derive(Clone, Debug, Default)]
struct Level {
    triangles: Vec<[u32; 3]>,
    /// For each corner of each face, which of the normals.
    sectors: Vec<[u32; 3]>,
    normals: usize,
    middles: Vec<Middle>,
}

/// A new point.
#[derive(Clone, Copy, Debug)]
struct Middle {
    ends: [u32; 2],
    curve: Curve,
}

#[derive(Clone, Copy, Debug)]
enum Curve {
    /// Bent by the normals at its ends, by so many parts of its length at most.
    Smooth([u32; 2], f32),
    /// Bent by the points before and after ([`NONE`] at corners), by so many parts of its length at most.
    Sharp([u32; 2], f32),
}

impl Refinement {
    /// Refines a net `levels` times. `base`: the shape's vertex at each point; `shape`: its positions
    /// in the pose in which corners are told.
    pub(super) fn of(net: Net, base: &[u32], shape: &[Vec3], levels: u8) -> (Self, Net) {
        let mut this = Self { base: base.to_vec(), levels: Vec::new() };
        let mut net = net;
        for _ in 0..levels {
            let points = this.points(shape);
            let (level, finer) = Level::of(&net, &points);
            this.levels.push(level);
            net = finer;
        }
        (this, net)
    }

    /// How many points there are.
    pub(super) fn count(&self) -> usize {
        self.base.len() + self.levels.iter().map(|l| l.middles.len()).sum::<usize>()
    }

    /// The points in the shape's space.
    pub fn points(&self, shape: &[Vec3]) -> Vec<DVec3> {
        let mut points = Vec::with_capacity(self.count());
        points.extend(self.base.iter().map(|&v| shape[v as usize].as_dvec3()));
        for level in &self.levels {
            level.extend(&mut points);
        }
        points
    }
}

impl Level {
    fn of(net: &Net, points: &[DVec3]) -> (Self, Net) {
        let (sectors, normals) = sectors(net);
        let beyond = sharp_neighbours(net, points);
        let mut this =
            Self { triangles: net.triangles.clone(), sectors, normals, middles: Vec::new() };
        let mut middle = vec![NONE; net.mate.len()];
        let lifts = lifts_of_sharp(net, points);
        let mut shared: HashMap<[u32; 2], u32> = HashMap::new();
        for half in 0..net.mate.len() as u32 {
            if middle[half as usize] == NONE {
                let number = (points.len() + this.middles.len()) as u32;
                let known = lifts.get(&key(net, half)).copied();
                let lift = known.unwrap_or_else(|| LIFT * height(net, half, points));
                let at = this.middle(net, (half, lift), &beyond, (&mut shared, number));
                middle[half as usize] = at;
                let mate = net.mate[half as usize];
                if mate != NONE {
                    middle[mate as usize] = at;
                }
            }
        }
        (this, quartered(net, &middle))
    }

    /// The point in the middle of a half-edge, made if need be; those of creases and borders are
    /// shared by all edges between the same points.
    fn middle(
        &mut self,
        net: &Net,
        (half, lift): (u32, f64),
        beyond: &dyn Fn(u32, u32) -> u32,
        (shared, number): (&mut HashMap<[u32; 2], u32>, u32),
    ) -> u32 {
        let [a, b] = ends(net, half);
        let h = half as usize;
        if net.mate[h] != NONE && !net.folds[h].opens() {
            let of = |x: u32| self.sectors[x as usize / 3][x as usize % 3];
            let curve = Curve::Smooth([of(half), of(next(half))], lift as f32);
            self.middles.push(Middle { ends: [a, b], curve });
            return number;
        }
        *shared.entry(key(net, half)).or_insert_with(|| {
            let curve = Curve::Sharp([beyond(a, b), beyond(b, a)], lift as f32);
            self.middles.push(Middle { ends: [a, b], curve });
            number
        })
    }

    fn extend(&self, points: &mut Vec<DVec3>) {
        let mut normals = vec![DVec3::ZERO; self.normals];
        for (t, s) in self.triangles.iter().zip(&self.sectors) {
            let [a, b, c] = t.map(|v| points[v as usize]);
            let cross = (b - a).cross(c - a);
            s.iter().for_each(|&s| normals[s as usize] += cross);
        }
        normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        for middle in &self.middles {
            let [a, b] = middle.ends.map(|v| points[v as usize]);
            let bent = match middle.curve {
                Curve::Smooth(sectors, lift) => {
                    let [m, n] = sectors.map(|s| normals[s as usize]);
                    let d = b - a;
                    let bent = n * d.dot(n) - m * d.dot(m);
                    bent.clamp_length_max(f64::from(lift) * d.length() / BEND)
                }
                Curve::Sharp([before, after], lift) => {
                    let tangent = |from: u32, to: u32, or: DVec3| match (from, to) {
                        (NONE, _) | (_, NONE) => or,
                        (from, to) => {
                            let along = points[to as usize] - points[from as usize];
                            along.normalize_or_zero() * or.length()
                        }
                    };
                    let d = b - a;
                    let bent =
                        tangent(before, middle.ends[1], d) - tangent(middle.ends[0], after, d);
                    bent.clamp_length_max(f64::from(lift) * d.length() / BEND)
                }
            };
            points.push(0.5 * (a + b) + BEND * bent);
        }
    }
}

/// The least height of the faces beside an edge, in parts of its length: twice their area by their
/// longest side.
fn height(net: &Net, half: u32, points: &[DVec3]) -> f64 {
    let [a, b] = ends(net, half).map(|v| points[v as usize]);
    let height = |h: u32| {
        let [p, q, r] = net.triangles[h as usize / 3].map(|v| points[v as usize]);
        let longest = p.distance(q).max(q.distance(r)).max(r.distance(p));
        (q - p).cross(r - p).length() / longest.max(1e-300)
    };
    let sides = [half, net.mate[half as usize]].into_iter().filter(|h| *h != NONE);
    sides.map(height).fold(f64::INFINITY, f64::min) / a.distance(b).max(1e-300)
}

/// The least lift of the faces beside each crease and border, whose edges share their middles.
fn lifts_of_sharp(net: &Net, points: &[DVec3]) -> HashMap<[u32; 2], f64> {
    let mut least = HashMap::new();
    for half in 0..net.mate.len() as u32 {
        if net.mate[half as usize] == NONE || net.folds[half as usize].opens() {
            let lift = SHARP_LIFT * height(net, half, points);
            least.entry(key(net, half)).and_modify(|l: &mut f64| *l = l.min(lift)).or_insert(lift);
        }
    }
    least
}

/// The points that a half-edge joins, whichever way it runs.
fn key(net: &Net, half: u32) -> [u32; 2] {
    let [a, b] = ends(net, half);
    [a.min(b), a.max(b)]
}

fn ends(net: &Net, half: u32) -> [u32; 2] {
    let at = |h: u32| net.triangles[h as usize / 3][h as usize % 3];
    [at(half), at(next(half))]
}

/// Numbers the normals: corners that can be reached round a point without crossing a crease have
/// one.
fn sectors(net: &Net) -> (Vec<[u32; 3]>, usize) {
    let count = net.mate.len();
    let mut root: Vec<u32> = (0..count as u32).collect();
    for half in 0..count as u32 {
        let mate = net.mate[half as usize];
        if mate != NONE && half < mate && !net.folds[half as usize].opens() {
            unite(&mut root, half, next(mate));
            unite(&mut root, next(half), mate);
        }
    }
    let mut number = vec![NONE; count];
    let mut total = 0;
    let mut sectors = vec![[0; 3]; net.triangles.len()];
    for half in 0..count {
        let slot = &mut number[find(&mut root, half as u32) as usize];
        if *slot == NONE {
            *slot = total;
            total += 1;
        }
        sectors[half / 3][half % 3] = *slot;
    }
    (sectors, total as usize)
}

/// For a point of a crease or border, and the next, the point before; [`NONE`] at corners.
fn sharp_neighbours(net: &Net, points: &[DVec3]) -> impl Fn(u32, u32) -> u32 + use<> {
    let mut around: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for half in 0..net.mate.len() as u32 {
        if net.mate[half as usize] == NONE || net.folds[half as usize].opens() {
            let [a, b] = ends(net, half);
            for (from, to) in [(a, b), (b, a)] {
                let list = around.entry(from).or_default();
                if !list.contains(&to) {
                    list.push(to);
                }
            }
        }
    }
    around.retain(|&at, list| match list[..] {
        [a, b] => {
            let p = points[at as usize];
            let [u, v] = [p - points[a as usize], points[b as usize] - p];
            u.normalize_or_zero().dot(v.normalize_or_zero()) > CORNER
        }
        _ => false,
    });
    move |at, ahead| {
        around.get(&at).map_or(NONE, |list| if list[0] == ahead { list[1] } else { list[0] })
    }
}

/// Every face in four; `middle` is the new point on each half-edge.
fn quartered(net: &Net, middle: &[u32]) -> Net {
    let count = net.triangles.len();
    let mut finer = Net {
        triangles: Vec::with_capacity(4 * count),
        origins: Vec::with_capacity(4 * count),
        mate: vec![NONE; 12 * count],
        folds: vec![Fold::Smooth; 12 * count],
    };
    for (f, [a, b, c]) in net.triangles.iter().copied().enumerate() {
        let [m, n, o] = [0, 1, 2].map(|k| middle[3 * f + k]);
        finer.triangles.extend([[a, m, o], [m, b, n], [o, n, c], [m, n, o]]);
        let origin = net.origins[f];
        finer.origins.extend((0..4).map(|k| Origin { part: 4 * origin.part + k, ..origin }));
        let inner = |child: usize, corner: usize| 3 * (4 * f + child) + corner;
        for (x, y) in
            [(inner(0, 1), inner(3, 2)), (inner(1, 2), inner(3, 0)), (inner(2, 0), inner(3, 1))]
        {
            finer.mate[x] = y as u32;
            finer.mate[y] = x as u32;
        }
    }
    for half in 0..net.mate.len() as u32 {
        let [first, second] = halves(half);
        let mate = net.mate[half as usize];
        if mate != NONE {
            let [other_first, other_second] = halves(mate);
            finer.mate[first as usize] = other_second;
            finer.mate[second as usize] = other_first;
        }
        finer.folds[first as usize] = net.folds[half as usize];
        finer.folds[second as usize] = net.folds[half as usize];
    }
    finer
}

/// The two parts of a half-edge after a step.
fn halves(half: u32) -> [u32; 2] {
    let (face, corner) = (half / 3, half % 3);
    let after = (corner + 1) % 3;
    [3 * (4 * face + corner) + corner, 3 * (4 * face + after) + corner]
}
