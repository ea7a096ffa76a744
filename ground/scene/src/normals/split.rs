//! Vertices split so that each belongs to one cluster of faces.

use super::cluster::Fans;

/// The vertices after splitting.
pub(super) struct Split {
    /// For each vertex the one that it was; the first ones are the old vertices in their order.
    pub(super) source: Vec<u32>,
    /// For each vertex the first vertex of its cluster.
    pub(super) groups: Vec<u32>,
}

/// Splits `vertices` vertices along the borders of `clusters` and points the triangles to them.
pub(super) fn split(
    triangles: &mut [[u32; 3]],
    fans: &Fans,
    clusters: &[u32],
    vertices: usize,
) -> Split {
    let all: Vec<u32> = (0..vertices as u32).collect();
    let mut split = Split { source: all.clone(), groups: all };
    let mut taken = vec![false; vertices];
    let mut users = Vec::new();
    for place in 0..fans.places() {
        let slots = fans.slots(place);
        let vertex = |slot: usize| {
            let (face, corner) = fans.corners[slot];
            triangles[face as usize][usize::from(corner)]
        };
        if slots.clone().all(|slot| clusters[slot] as usize == slots.start) {
            slots.for_each(|slot| split.groups[vertex(slot) as usize] = place as u32);
        } else {
            users.clear();
            users.extend(slots.map(|slot| User {
                cluster: clusters[slot],
                vertex: vertex(slot),
                slot,
            }));
            split.place(triangles, fans, &mut users, &mut taken);
        }
    }
    split
}

/// A corner at the place in question.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct User {
    cluster: u32,
    vertex: u32,
    slot: usize,
}

impl Split {
    /// Splits the vertices at one place among its users; those of another cluster were `taken`.
    fn place(
        &mut self,
        triangles: &mut [[u32; 3]],
        fans: &Fans,
        users: &mut [User],
        taken: &mut [bool],
    ) {
        users.sort_unstable();
        for cluster in users.chunk_by(|a, b| a.cluster == b.cluster) {
            let mut group = None;
            for same in cluster.chunk_by(|a, b| a.vertex == b.vertex) {
                let new = self.vertex(same[0].vertex, taken);
                self.groups[new as usize] = *group.get_or_insert(new);
                for user in same {
                    let (face, corner) = fans.corners[user.slot];
                    triangles[face as usize][usize::from(corner)] = new;
                }
            }
        }
    }

    /// The vertex itself for its first cluster, a copy of it for each further one.
    fn vertex(&mut self, old: u32, taken: &mut [bool]) -> u32 {
        if !std::mem::replace(&mut taken[old as usize], true) {
            return old;
        }
        self.source.push(old);
        self.groups.push(0);
        self.source.len() as u32 - 1
    }
}
