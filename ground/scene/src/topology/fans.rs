//! [`Fans`]: the triangles around each vertex, in order.
//!
//! A vertex of a manifold has one fan, closed inside the surface and open on its border. Around
//! other vertices (two cones that touch, an edge where three sheets meet) the triangles fall into
//! several fans: an edge joins two triangles only if it is interior, so fans are what is left when
//! the surface is cut along its non-manifold edges and vertices.

use super::{Side, Topology};

/// The fans of all vertices of a topology.
#[derive(Clone, Debug, Default)]
pub struct Fans {
    /// Where each vertex's fans begin.
    start: Vec<u32>,
    /// Where each fan's corners and ring begin.
    begin: Vec<[u32; 2]>,
    corners: Vec<Side>,
    ring: Vec<u32>,
}

/// Triangles around one vertex, each sharing an edge with the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fan<'a> {
    /// The side that begins at the vertex, for each triangle; counter-clockwise seen from the
    /// front of the first.
    pub corners: &'a [Side],
    /// The vertices around, in the same order; one more than triangles if the fan is open.
    pub ring: &'a [u32],
}

impl Fan<'_> {
    /// Whether the last triangle shares an edge with the first.
    pub fn is_closed(&self) -> bool {
        self.ring.len() == self.corners.len()
    }
}

impl Fans {
    /// The fans of a topology.
    pub fn of(topology: &Topology) -> Self {
        let (first, corners) = corners_by_vertex(topology);
        let mut walk = Walk {
            topology,
            done: vec![false; 3 * topology.triangles.len()],
            fans: Self::default(),
        };
        for v in 0..topology.weld.first.len() {
            walk.fans.start.push(walk.fans.begin.len() as u32);
            walk.vertex(&corners[first[v] as usize..first[v + 1] as usize]);
        }
        let mut fans = walk.fans;
        fans.start.push(fans.begin.len() as u32);
        fans.begin.push([fans.corners.len() as u32, fans.ring.len() as u32]);
        fans
    }

    /// The fans around a welded vertex; none if no triangle uses it.
    pub fn at(&self, vertex: usize) -> impl ExactSizeIterator<Item = Fan<'_>> {
        let range = self.start[vertex] as usize..self.start[vertex + 1] as usize;
        range.map(|f| {
            let ([c, r], [c_end, r_end]) = (self.begin[f], self.begin[f + 1]);
            Fan {
                corners: &self.corners[c as usize..c_end as usize],
                ring: &self.ring[r as usize..r_end as usize],
            }
        })
    }

    /// Vertices with more than one fan, rising.
    pub fn pinched(&self) -> Vec<u32> {
        let several = |v: &u32| self.start[*v as usize + 1] - self.start[*v as usize] > 1;
        (0..self.start.len() as u32 - 1).filter(several).collect()
    }
}

/// The sides that begin at each vertex, as offsets into one list.
fn corners_by_vertex(topology: &Topology) -> (Vec<u32>, Vec<Side>) {
    let vertices = topology.weld.first.len();
    let mut first = vec![0u32; vertices + 1];
    let sides = || {
        let all = (0..topology.triangles.len()).flat_map(|f| (0..3).map(move |c| Side::new(f, c)));
        all.filter(|s| topology.edge(*s).is_some())
    };
    sides().for_each(|s| first[topology.start(s) as usize + 1] += 1);
    for v in 0..vertices {
        first[v + 1] += first[v];
    }
    let mut next = first.clone();
    let mut corners = vec![Side(0); first[vertices] as usize];
    for s in sides() {
        let slot = &mut next[topology.start(s) as usize];
        corners[*slot as usize] = s;
        *slot += 1;
    }
    (first, corners)
}

/// A walk around the vertices, fan by fan.
struct Walk<'a> {
    topology: &'a Topology,
    /// Which corners have been passed, by the side that begins there.
    done: Vec<bool>,
    fans: Fans,
}

impl Walk<'_> {
    /// Open fans first, from their beginnings; then those that only begin against the winding;
    /// what is left is closed.
    fn vertex(&mut self, corners: &[Side]) {
        let border = |t: &Topology, side: Side| t.twin(side).is_none();
        for &corner in corners {
            if border(self.topology, corner) {
                self.fan(corner, corner);
            }
        }
        for &corner in corners {
            if border(self.topology, corner.previous()) {
                self.fan(corner, corner.previous());
            }
        }
        for &corner in corners {
            self.fan(corner, corner);
        }
    }

    /// Walks on from `corner`, away from its side `entry`, until the fan ends or closes.
    fn fan(&mut self, mut corner: Side, mut entry: Side) {
        if self.done[corner.index()] {
            return;
        }
        self.fans.begin.push([self.fans.corners.len() as u32, self.fans.ring.len() as u32]);
        loop {
            self.done[corner.index()] = true;
            self.fans.corners.push(corner);
            self.fans.ring.push(self.far_end(corner, entry));
            let exit = if entry == corner { corner.previous() } else { corner };
            let Some(across) = self.topology.twin(exit) else {
                self.fans.ring.push(self.far_end(corner, exit));
                return;
            };
            // Neighbours that wind against each other meet side to side in the same direction.
            let from_here = self.topology.start(across) == self.topology.start(corner);
            (corner, entry) = (if from_here { across } else { across.next() }, across);
            if self.done[corner.index()] {
                return;
            }
        }
    }

    /// The other end of a side at a corner's vertex.
    fn far_end(&self, corner: Side, side: Side) -> u32 {
        self.topology.start(if side == corner { corner.next() } else { side })
    }
}
