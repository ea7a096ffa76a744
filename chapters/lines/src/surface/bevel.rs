//! Creases opened and closed again with strips of no width.
//!
//! Along a crease the corners of the two sides become vertices of their own, and two triangles
//! fill the gap. Where three or more creases meet, a polygon fills the hole between their strips.
//! All these triangles have no area at any time; only normals turn across them.

use super::{Anchor, Crease, Fold, NONE, Source, Surface, next};
use std::collections::HashMap;

/// Triangles before their vertices are parted.
#[derive(Default)]
pub(super) struct Corners {
    pub(super) anchors: Vec<Anchor>,
    pub(super) faces: Vec<[u32; 3]>,
    pub(super) sources: Vec<Source>,
    pub(super) mate: Vec<u32>,
    pub(super) folds: Vec<Fold>,
}

pub(super) fn surface(mut corners: Corners) -> Surface {
    smooth_isolated(&mut corners);
    let sectors = Sectors::of(&corners);
    let mut surface = Surface {
        anchors: sectors.anchors,
        faces: sectors.faces,
        real_faces: corners.faces.len(),
        sources: corners.sources,
        mate: corners.mate.clone(),
        ..Surface::default()
    };
    let mut rungs = HashMap::new();
    for half in 0..corners.mate.len() as u32 {
        let mate = corners.mate[half as usize];
        let fold = corners.folds[half as usize];
        if fold.opens() && half < mate {
            let sharp = fold == Fold::Crease;
            surface.creases.push(Crease { left: half, right: mate, sharp });
            strip(&mut surface, half, mate, &mut rungs);
            let crease = surface.creases.len() as u32 - 1;
            surface.strips.resize(surface.faces.len() - surface.real_faces, crease);
        }
    }
    join_rungs(&mut surface, &rungs);
    fill_corners(&mut surface);
    surface.strips.resize(surface.faces.len() - surface.real_faces, NONE);
    surface.finish();
    surface.pieces = crate::intersect::pieces(&surface);
    surface
}

/// A lone hard edge whose two ends lie inside smooth fans opens nothing: it is taken as smooth.
fn smooth_isolated(corners: &mut Corners) {
    let sectors = Sectors::of(corners);
    let vertex = |h: u32| sectors.faces[h as usize / 3][h as usize % 3];
    for half in 0..corners.mate.len() as u32 {
        let mate = corners.mate[half as usize];
        if corners.folds[half as usize].opens()
            && vertex(half) == vertex(next(mate))
            && vertex(next(half)) == vertex(mate)
        {
            corners.folds[half as usize] = Fold::Smooth;
            corners.folds[mate as usize] = Fold::Smooth;
        }
    }
}

/// Corners that belong to one vertex: those that can be reached round it without crossing a crease.
struct Sectors {
    anchors: Vec<Anchor>,
    faces: Vec<[u32; 3]>,
}

impl Sectors {
    fn of(corners: &Corners) -> Self {
        let count = corners.mate.len();
        let mut root: Vec<u32> = (0..count as u32).collect();
        for half in 0..count as u32 {
            let mate = corners.mate[half as usize];
            if mate == NONE || mate < half || corners.folds[half as usize].opens() {
                continue;
            }
            unite(&mut root, half, next(mate));
            unite(&mut root, next(half), mate);
        }
        let mut number = vec![NONE; count];
        let mut anchors = Vec::new();
        let mut faces = corners.faces.clone();
        for half in 0..count {
            let r = find(&mut root, half as u32) as usize;
            if number[r] == NONE {
                number[r] = anchors.len() as u32;
                anchors.push(corners.anchors[corners.faces[half / 3][half % 3] as usize]);
            }
            faces[half / 3][half % 3] = number[r];
        }
        Self { anchors, faces }
    }
}

pub(super) fn find(root: &mut [u32], mut x: u32) -> u32 {
    while root[x as usize] != x {
        root[x as usize] = root[root[x as usize] as usize];
        x = root[x as usize];
    }
    x
}

/// The lower number stays the root.
pub(super) fn unite(root: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(root, a), find(root, b));
    root[a.max(b) as usize] = a.min(b);
}

/// Half-edges across strips by their ends, waiting for a mate.
type Rungs = HashMap<(u32, u32), u32>;

/// Fills a crease between `left` (a to b) and `right` (b to a) with two triangles, one if the
/// crease ends at one of its ends inside a smooth fan.
fn strip(surface: &mut Surface, left: u32, right: u32, rungs: &mut Rungs) {
    let [al, bl] = [surface.from(left), surface.to(left)];
    let [br, ar] = [surface.from(right), surface.to(right)];
    if al == ar {
        let h = push(surface, [bl, al, br]);
        join(surface, h, left);
        join(surface, h + 1, right);
        rungs.insert((br, bl), h + 2);
    } else if bl == br {
        let h = push(surface, [bl, al, ar]);
        join(surface, h, left);
        join(surface, h + 2, right);
        rungs.insert((al, ar), h + 1);
    } else {
        let h = push(surface, [bl, al, ar]);
        let k = push(surface, [bl, ar, br]);
        join(surface, h, left);
        join(surface, h + 2, k);
        join(surface, k + 1, right);
        rungs.insert((al, ar), h + 1);
        rungs.insert((br, bl), k + 2);
    }
}

fn push(surface: &mut Surface, face: [u32; 3]) -> u32 {
    surface.faces.push(face);
    surface.mate.extend([NONE; 3]);
    3 * (surface.faces.len() as u32 - 1)
}

fn join(surface: &mut Surface, a: u32, b: u32) {
    surface.mate[a as usize] = b;
    surface.mate[b as usize] = a;
}

fn join_rungs(surface: &mut Surface, rungs: &Rungs) {
    for (&(from, to), &half) in rungs {
        if let Some(&other) = rungs.get(&(to, from)) {
            join(surface, half, other);
        }
    }
}

/// Fills the holes where three or more strips meet: rings of rungs without a mate, all at one
/// place.
fn fill_corners(surface: &mut Surface) {
    let first = 3 * surface.real_faces as u32;
    let open: Vec<u32> =
        (first..surface.mate.len() as u32).filter(|&h| surface.mate[h as usize] == NONE).collect();
    let mut leaving: HashMap<u32, u32> = open.iter().map(|&h| (surface.from(h), h)).collect();
    for &start in &open {
        let mut ring = Vec::new();
        let mut half = start;
        while leaving.remove(&surface.from(half)).is_some() {
            ring.push(half);
            match leaving.get(&surface.to(half)) {
                Some(&following) => half = following,
                None => break,
            }
        }
        let closes = ring.len() >= 3 && surface.to(ring[ring.len() - 1]) == surface.from(ring[0]);
        if closes {
            fill(surface, &ring);
        }
    }
}

/// Fans a polygon whose sides are the mates of `ring`.
fn fill(surface: &mut Surface, ring: &[u32]) {
    let corner: Vec<u32> = ring.iter().map(|&h| surface.from(h)).collect();
    let n = ring.len();
    let mut diagonal = ring[0];
    for i in 1..n - 1 {
        // Against the ring: its sides run from corner i + 1 to corner i.
        let h = push(surface, [corner[0], corner[i + 1], corner[i]]);
        join(surface, h + 1, ring[i]);
        join(surface, h + 2, diagonal);
        diagonal = h;
    }
    join(surface, diagonal, ring[n - 1]);
}
