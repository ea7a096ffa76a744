//! [`Topology`]: adjacency of a mesh welded over its whole animation.
//!
//! 1. Vertices that a file keeps apart for the sake of normals or texture seams become one where
//!    nothing can ever part them: the same position, joints and morph targets ([`weld`]).
//! 2. The sides of all triangles are gathered into edges, however many triangles meet there.
//! 3. [`Fans`] order the triangles around each vertex; [`crease`] tells sharp edges from smooth.
//!
//! Guaranteed: everything is numbered in an order that the mesh alone decides; any list of
//! triangles is accepted. Triangles that welding collapses take no part. Not guaranteed: that
//! triangles which pass through each other, or lie on each other, are noticed.

pub mod crease;
mod edges;
mod fans;
pub mod weld;

pub use fans::{Fan, Fans};

use crate::Mesh;
use chiaro_basis::math::Vec3;
use edges::Edges;
use weld::Weld;

/// Adjacency of a welded mesh.
#[derive(Clone, Debug)]
pub struct Topology {
    /// Which vertices are one.
    pub weld: Weld,
    /// The mesh's triangles over welded vertices; in the mesh's order and number.
    pub triangles: Vec<[u32; 3]>,
    /// Triangles that lost an edge to welding, rising; they take no part in what follows.
    pub collapsed: Vec<u32>,
    /// Ends of each edge, welded, the lower first; rising.
    pub edges: Vec<[u32; 2]>,
    sides: Edges,
}

/// One side of one triangle: from corner `corner` to the next, in the triangle's winding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Side(u32);

impl Side {
    /// The side of triangle `face` that begins at its corner `corner` (0, 1 or 2).
    pub fn new(face: usize, corner: usize) -> Self {
        Self(u32::try_from(3 * face + corner).expect("budgets keep sides below 2^32"))
    }

    /// Its triangle.
    pub fn face(self) -> usize {
        self.0 as usize / 3
    }

    /// The corner where it begins.
    pub fn corner(self) -> usize {
        self.0 as usize % 3
    }

    fn index(self) -> usize {
        self.0 as usize
    }

    /// The side after this one in its triangle.
    pub fn next(self) -> Self {
        if self.0 % 3 == 2 { Self(self.0 - 2) } else { Self(self.0 + 1) }
    }

    /// The side before this one in its triangle.
    pub fn previous(self) -> Self {
        if self.0.is_multiple_of(3) { Self(self.0 + 2) } else { Self(self.0 - 1) }
    }
}

/// How many triangles meet at an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// One: the surface ends.
    Boundary,
    /// Two: the surface goes on.
    Interior,
    /// Three or more.
    NonManifold,
}

impl Topology {
    /// The topology of a mesh whose vertices are welded where nothing can part them.
    pub fn of(mesh: &Mesh) -> Self {
        Self::new(Weld::of(mesh), &mesh.triangles)
    }

    /// The topology of a mesh whose vertices are welded where they coincide in every one of
    /// `poses` (each one position a vertex): less careful than [`Topology::of`], for meshes whose
    /// joints always move together.
    pub fn over(mesh: &Mesh, poses: &[&[Vec3]]) -> Self {
        Self::new(Weld::over(mesh, poses), &mesh.triangles)
    }

    fn new(weld: Weld, triangles: &[[u32; 3]]) -> Self {
        let triangles: Vec<[u32; 3]> =
            triangles.iter().map(|t| t.map(|v| weld.welded[v as usize])).collect();
        let collapsed = (0..triangles.len() as u32)
            .filter(|&t| {
                let [a, b, c] = triangles[t as usize];
                a == b || b == c || c == a
            })
            .collect::<Vec<u32>>();
        let (edges, sides) = Edges::of(&triangles, &collapsed, weld.first.len());
        Self { weld, triangles, collapsed, edges, sides }
    }

    /// The sides that lie on an edge, rising.
    pub fn sides(&self, edge: usize) -> &[Side] {
        self.sides.at(edge)
    }

    /// The edge under a side; `None` for collapsed triangles.
    pub fn edge(&self, side: Side) -> Option<usize> {
        self.sides.under(side)
    }

    /// How many triangles meet at an edge.
    pub fn kind(&self, edge: usize) -> EdgeKind {
        match self.sides(edge).len() {
            1 => EdgeKind::Boundary,
            2 => EdgeKind::Interior,
            _ => EdgeKind::NonManifold,
        }
    }

    /// Whether the triangles at an edge wind alike: as many sides run along it one way as the
    /// other. Boundaries have nothing to disagree with.
    pub fn is_consistent(&self, edge: usize) -> bool {
        let sides = self.sides(edge);
        let rising = sides.iter().filter(|s| self.start(**s) == self.edges[edge][0]).count();
        sides.len() == 1 || 2 * rising == sides.len()
    }

    /// The welded vertex where a side begins.
    pub fn start(&self, side: Side) -> u32 {
        self.triangles[side.face()][side.corner()]
    }

    /// The side across an interior edge; `None` at boundaries and where more than two meet.
    pub fn twin(&self, side: Side) -> Option<Side> {
        match *self.sides(self.edge(side)?) {
            [a, b] => Some(if a == side { b } else { a }),
            _ => None,
        }
    }

    /// Whether the surface ends nowhere: it has triangles, and no edge has only one.
    pub fn is_closed(&self) -> bool {
        !self.edges.is_empty() && (0..self.edges.len()).all(|e| self.kind(e) != EdgeKind::Boundary)
    }

    /// Whether all neighbours wind alike.
    pub fn is_oriented(&self) -> bool {
        (0..self.edges.len()).all(|e| self.is_consistent(e))
    }

    /// Vertices - edges + faces, of what triangles that did not collapse use: 2 for a sphere, 0
    /// for a torus, their sum for both.
    pub fn euler_characteristic(&self) -> i64 {
        let mut used = vec![false; self.weld.first.len()];
        self.edges.iter().flatten().for_each(|&v| used[v as usize] = true);
        let vertices = used.into_iter().filter(|&u| u).count();
        let faces = self.triangles.len() - self.collapsed.len();
        vertices as i64 - self.edges.len() as i64 + faces as i64
    }

    /// Unit normals of the welded vertices in one pose (one position a vertex of the mesh):
    /// angle-weighted means of all faces around, across hard edges too.
    pub fn normals(&self, positions: &[Vec3]) -> Vec<Vec3> {
        let welded = self.weld.gather(positions);
        let groups: Vec<u32> = (0..welded.len() as u32).collect();
        crate::normals::of_faces(&welded, &self.triangles, &groups)
    }
}
