//! The faces around each place, and the clusters among them that share a normal.

use chiaro_basis::math::Vec3;
use rayon::prelude::*;

/// Places that one task looks at.
const CHUNK: usize = 4096;

/// The corners of faces around each place: slots of one list, place by place.
pub(super) struct Fans {
    /// Where each place's slots start; one more than there are places.
    start: Vec<usize>,
    /// A slot's face, and which of its corners.
    pub(super) corners: Vec<(u32, u8)>,
    /// The places of each face's corners.
    faces: Vec<[u32; 3]>,
}

impl Fans {
    /// The places, also those without faces.
    pub(super) fn places(&self) -> usize {
        self.start.len() - 1
    }

    /// The slots around a place.
    pub(super) fn slots(&self, place: usize) -> std::ops::Range<usize> {
        self.start[place]..self.start[place + 1]
    }
}

/// The fans of triangles whose vertices lie at `places`.
pub(super) fn fans(triangles: &[[u32; 3]], places: &[u32]) -> Fans {
    let faces: Vec<[u32; 3]> =
        triangles.par_iter().map(|t| t.map(|v| places[v as usize])).collect();
    let mut start = vec![0; places.len() + 1];
    for place in faces.iter().flatten() {
        start[*place as usize + 1] += 1;
    }
    for i in 0..places.len() {
        start[i + 1] += start[i];
    }
    let mut next = start.clone();
    let mut corners = vec![(0, 0); 3 * triangles.len()];
    for (f, places) in faces.iter().enumerate() {
        for (c, place) in places.iter().enumerate() {
            let slot = &mut next[*place as usize];
            corners[*slot] = (f as u32, c as u8);
            *slot += 1;
        }
    }
    Fans { start, corners, faces }
}

/// For each slot the lowest slot of its cluster: faces that share an edge at the place are of one
/// cluster when the cosine between their normals is at least `limit` or, where there are smoothing
/// groups, when they are of the same group but 0.
pub(super) fn clusters(fans: &Fans, normals: &[Vec3], limit: f32, smoothing: &[u32]) -> Vec<u32> {
    let mut clusters: Vec<u32> = (0..fans.corners.len() as u32).collect();
    let around = Around { fans, normals, limit, smoothing };
    let mut rest = clusters.as_mut_slice();
    let mut tasks = Vec::with_capacity(fans.places().div_ceil(CHUNK));
    for first in (0..fans.places()).step_by(CHUNK) {
        let last = (first + CHUNK).min(fans.places());
        let (mine, others) = rest.split_at_mut(fans.start[last] - fans.start[first]);
        rest = others;
        tasks.push((first..last, mine));
    }
    tasks.into_par_iter().for_each(|(places, mine)| around.each(places, mine));
    clusters
}

struct Around<'a> {
    fans: &'a Fans,
    normals: &'a [Vec3],
    limit: f32,
    smoothing: &'a [u32],
}

/// An edge from the place of a fan to another place, on the side of one of its faces.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Spoke {
    to: u32,
    smoothing: u32,
    face: u32,
    /// Counted from the fan's first.
    slot: u32,
}

impl Around<'_> {
    /// Clusters the slots of some places, which `mine` are.
    fn each(&self, places: std::ops::Range<usize>, mine: &mut [u32]) {
        let mut spokes = Vec::new();
        let first = self.fans.start[places.start];
        for place in places {
            let slots = self.fans.slots(place);
            let parent = &mut mine[slots.start - first..slots.end - first];
            let flat = self.spokes(slots.clone(), &mut spokes);
            for pair in spokes.windows(2) {
                if self.joined(&pair[0], &pair[1]) {
                    unite(parent, slots.start, pair[0].slot as usize, pair[1].slot as usize);
                }
            }
            if flat {
                self.house_flat_faces(slots.clone(), parent);
            }
            for i in 0..parent.len() {
                parent[i] = root(parent, slots.start, i) as u32 + slots.start as u32;
            }
        }
    }

    /// Collects the spokes of a fan, those with one end together, and says whether some of its
    /// faces have no area.
    fn spokes(&self, slots: std::ops::Range<usize>, spokes: &mut Vec<Spoke>) -> bool {
        spokes.clear();
        let mut flat = false;
        for (slot, &(face, corner)) in self.fans.corners[slots].iter().enumerate() {
            if self.normals[face as usize] == Vec3::ZERO {
                flat = true;
                continue;
            }
            let smoothing = self.smoothing.get(face as usize).copied().unwrap_or(0);
            let places = self.fans.faces[face as usize];
            for step in [1, 2] {
                let to = places[(usize::from(corner) + step) % 3];
                spokes.push(Spoke { to, smoothing, face, slot: slot as u32 });
            }
        }
        spokes.sort_unstable();
        flat
    }

    fn joined(&self, a: &Spoke, b: &Spoke) -> bool {
        let normal = |s: &Spoke| self.normals[s.face as usize];
        a.to == b.to
            && if self.smoothing.is_empty() {
                normal(a).dot(normal(b)) >= self.limit
            } else {
                a.smoothing == b.smoothing && a.smoothing != 0
            }
    }

    /// Lets faces without area live with any other face, so that they split no vertex.
    fn house_flat_faces(&self, slots: std::ops::Range<usize>, parent: &mut [u32]) {
        let is_flat =
            |slot: &usize| self.normals[self.fans.corners[*slot].0 as usize] == Vec3::ZERO;
        let Some(host) = slots.clone().find(|slot| !is_flat(slot)) else { return };
        for slot in slots.clone().filter(is_flat) {
            unite(parent, slots.start, slot - slots.start, host - slots.start);
        }
    }
}

/// Joins the sets of slots `a` and `b`, counted from `first`; the lower root stays.
fn unite(parent: &mut [u32], first: usize, a: usize, b: usize) {
    let (a, b) = (root(parent, first, a), root(parent, first, b));
    parent[a.max(b)] = (first + a.min(b)) as u32;
}

fn root(parent: &mut [u32], first: usize, mut i: usize) -> usize {
    loop {
        let up = parent[i] as usize - first;
        if up == i {
            return i;
        }
        parent[i] = parent[up];
        i = up;
    }
}
