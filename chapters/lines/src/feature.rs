//! [`Features`]: lines that are edges of the surface, the same in every frame: creases, borders,
//! material borders.
//!
//! Edges of one kind are chained through the places where two of them meet; where more meet, the
//! pairs that run on most straight in the pose given are joined. A chain's index is its identity.

use crate::contour::Scenery;
use crate::fringe::Fringe;
use crate::path::{Kind, Path, Point, Segment};
use crate::surface::{Anchor, Crease, NONE, Surface};
use chiaro_basis::math::DVec3;
use std::collections::BTreeMap;

/// Pairs of edges that turn by more than this at a junction are not joined: cosine of 105 degrees.
const STRAIGHT: f64 = -0.26;

/// Half-edges of one line, in order; each ends where the next begins.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureChain {
    /// What kind.
    pub kind: Kind,
    /// Half-edges of real faces.
    pub halves: Vec<u32>,
    /// Whether the last ends where the first begins.
    pub closed: bool,
}

/// The edge lines of a surface.
#[derive(Clone, Debug, Default)]
pub struct Features {
    /// The chains.
    pub chains: Vec<FeatureChain>,
    /// Where masked faces end; their chains are counted on from those.
    pub fringes: Vec<Fringe>,
}

impl Features {
    /// Chains the creases, borders and material borders of a surface.
    pub fn of(surface: &Surface, positions: &[DVec3]) -> Self {
        let mut chains = Vec::new();
        for (kind, halves) in [
            (Kind::Crease, creases(surface)),
            (Kind::Border, borders(surface)),
            (Kind::Material, material_borders(surface)),
        ] {
            chains.extend(chained(surface, positions, kind, halves));
        }
        Self { chains, fringes: Vec::new() }
    }

    /// How many segments each chain has.
    pub(crate) fn counts(&self) -> impl Iterator<Item = usize> {
        let fringes = self.fringes.iter().map(|f| f.faces.len());
        self.chains.iter().map(|c| c.halves.len()).chain(fringes)
    }

    /// The paths of the chains in one frame; `g` is the silhouettes'. Where a silhouette runs along
    /// a crease it is left out here.
    pub fn paths(&self, scenery: &Scenery<'_>, g: &[f64]) -> Vec<Path> {
        let path = |(i, c): (usize, &FeatureChain)| feature_path(c, i as u32, scenery, g);
        let first = self.chains.len() as u32;
        let fringe = |(i, f): (usize, &Fringe)| f.path(first + i as u32, scenery);
        let fringes = self.fringes.iter().enumerate().map(fringe);
        self.chains.iter().enumerate().map(path).chain(fringes).collect()
    }
}

fn creases(surface: &Surface) -> Vec<u32> {
    surface.creases.iter().filter(|c| c.sharp).map(|c| c.left).collect()
}

fn borders(surface: &Surface) -> Vec<u32> {
    let real = 0..3 * surface.real_faces as u32;
    real.filter(|&h| surface.mate[h as usize] == NONE).collect()
}

fn material_borders(surface: &Surface) -> Vec<u32> {
    let material = |h: u32| surface.sources[h as usize / 3].material;
    let real = 0..3 * surface.real_faces as u32;
    real.filter(|&h| {
        let across = surface.across(h);
        let is_crease = || surface.crease_at(h).is_some_and(|c| c.sharp);
        across != NONE && h < across && material(h) != material(across) && !is_crease()
    })
    .collect()
}

/// Where edges meet: copies of a vertex on the sides of a crease are one place.
fn node(surface: &Surface, vertex: u32) -> (u32, u32) {
    let Anchor { object, vertex } = surface.anchors[vertex as usize];
    (object, vertex)
}

/// An edge end: half-edge, and whether it leaves (at its start) or arrives.
type End = (u32, bool);

fn chained(
    surface: &Surface,
    positions: &[DVec3],
    kind: Kind,
    halves: Vec<u32>,
) -> Vec<FeatureChain> {
    let mut at: BTreeMap<(u32, u32), Vec<End>> = BTreeMap::new();
    for &h in &halves {
        at.entry(node(surface, surface.from(h))).or_default().push((h, true));
        at.entry(node(surface, surface.to(h))).or_default().push((h, false));
    }
    let mut partner: BTreeMap<End, End> = BTreeMap::new();
    for ends in at.values() {
        pair(surface, positions, ends, &mut partner);
    }
    let mut done: BTreeMap<u32, bool> = halves.iter().map(|h| (*h, false)).collect();
    let mut chains = Vec::new();
    let heads = halves.iter().filter(|h| !partner.contains_key(&(**h, true)));
    let tails = halves.iter().filter(|h| !partner.contains_key(&(**h, false)));
    let starts = heads.map(|h| (*h, true)).chain(tails.map(|h| (*h, false)));
    let starts: Vec<End> = starts.chain(halves.iter().map(|h| (*h, true))).collect();
    for start in starts {
        if !done[&start.0] {
            chains.push(walk(kind, start, &partner, &mut done));
        }
    }
    chains
}

/// Follows partners from an end; edges walked backwards are given by their other side where there
/// is one.
fn walk(
    kind: Kind,
    start: End,
    partner: &BTreeMap<End, End>,
    done: &mut BTreeMap<u32, bool>,
) -> FeatureChain {
    let mut halves = Vec::new();
    let mut end = start;
    loop {
        let (half, forward) = end;
        done.insert(half, true);
        halves.push(if forward { half } else { half | BACKWARDS });
        match partner.get(&(half, !forward)) {
            Some(&next) if !done[&next.0] => end = next,
            Some(&next) => return FeatureChain { kind, halves, closed: next == start },
            None => return FeatureChain { kind, halves, closed: false },
        }
    }
}

/// Marks half-edges that a chain follows from end to start.
pub(crate) const BACKWARDS: u32 = 1 << 31;

fn pair(surface: &Surface, positions: &[DVec3], ends: &[End], partner: &mut BTreeMap<End, End>) {
    if let [a, b] = *ends {
        partner.insert(a, b);
        partner.insert(b, a);
        return;
    }
    let away = |(h, leaves): End| {
        let (p, q) = (surface.from(h), surface.to(h));
        let d = positions[q as usize] - positions[p as usize];
        (if leaves { d } else { -d }).normalize_or_zero()
    };
    let mut pairs = Vec::new();
    for (i, a) in ends.iter().enumerate() {
        for b in &ends[i + 1..] {
            pairs.push((away(*a).dot(away(*b)), *a, *b));
        }
    }
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    for (cosine, a, b) in pairs {
        if cosine < -STRAIGHT && !partner.contains_key(&a) && !partner.contains_key(&b) {
            partner.insert(a, b);
            partner.insert(b, a);
        }
    }
}

fn feature_path(chain: &FeatureChain, index: u32, scenery: &Scenery<'_>, g: &[f64]) -> Path {
    let (surface, posed) = (scenery.surface, scenery.posed);
    let mut points: Vec<Point> = Vec::with_capacity(chain.halves.len() + 1);
    let mut segments = Vec::with_capacity(chain.halves.len());
    for (k, &marked) in chain.halves.iter().enumerate() {
        let half = marked & !BACKWARDS;
        let [a, b] = [surface.from(half), surface.to(half)];
        let [a, b] = if marked & BACKWARDS == 0 { [a, b] } else { [b, a] };
        let point = |v: u32, on_chain: f64| {
            let world = posed.positions[v as usize];
            Point { world, next: scenery.next.map(|n| n[v as usize]), pushed: world, on_chain }
        };
        if points.is_empty() {
            points.push(point(a, 0.0));
        }
        let (from, to) = (points[points.len() - 1], point(b, (k + 1) as f64));
        let own = [half / 3, face_across(surface, half)];
        for ([t0, t1], [buried, shared]) in parts(half, marked != half, scenery, g) {
            if t0 < t1 {
                segments.push(Segment { buried, shared, ..Segment::of(own) });
                points.push(if t1 >= 1.0 { to } else { Point::mix(&from, &to, t1) });
            }
        }
    }
    Path::new(chain.kind, index, chain.closed, &points, &segments, scenery.view, scenery.margin)
}

/// The real face on the other side of an edge.
fn face_across(surface: &Surface, half: u32) -> u32 {
    match surface.across(half) {
        NONE => NONE,
        across => across / 3,
    }
}

/// The parts of an edge, as shares of it, whether each is never visible, and whether a silhouette
/// runs there: where both sides show their backs, or, where the surface is opened, one.
fn parts(
    half: u32,
    backwards: bool,
    scenery: &Scenery<'_>,
    g: &[f64],
) -> Vec<([f64; 2], [bool; 2])> {
    let surface = scenery.surface;
    let source = &surface.sources[half as usize / 3];
    let left = front_interval([surface.from(half), surface.to(half)], g);
    let right = match surface.crease_at(half) {
        Some(Crease { right, .. }) => front_interval([surface.to(right), surface.from(right)], g),
        // Turned faces are shown from their backs.
        None if source.two_sided || source.turned => return vec![([0.0, 1.0], [false; 2])],
        None => left,
    };
    let two_sided = source.two_sided;
    let mut cuts = [0.0, left[0], left[1], right[0], right[1], 1.0].map(|t: f64| t.clamp(0.0, 1.0));
    cuts.sort_by(f64::total_cmp);
    let covers = |i: [f64; 2], t: f64| t > i[0] && t < i[1];
    let buried = |t: f64| match (covers(left, t), covers(right, t)) {
        (true, true) => [false; 2],
        (false, false) => [!two_sided, false],
        _ => [true; 2],
    };
    let part = |c: &[f64]| ([c[0], c[1]], buried(0.5 * (c[0] + c[1])));
    let mut parts: Vec<([f64; 2], [bool; 2])> = cuts.windows(2).map(part).collect();
    if backwards {
        parts.reverse();
        parts.iter_mut().for_each(|(t, _)| *t = [1.0 - t[1], 1.0 - t[0]]);
    }
    parts
}

/// Where g is positive between two vertices, as shares of the way.
fn front_interval([a, b]: [u32; 2], g: &[f64]) -> [f64; 2] {
    let (ga, gb) = (g[a as usize], g[b as usize]);
    let at = || (ga / (ga - gb)).clamp(0.0, 1.0);
    match (crate::slice::positive(ga), crate::slice::positive(gb)) {
        (true, true) => [0.0, 1.0],
        (true, false) => [0.0, at()],
        (false, true) => [at(), 1.0],
        (false, false) => [1.0, 0.0],
    }
}
