//! The mesh of an object: triangles, and one vertex for each corner that differs.

use super::super::polygon::Triangulator;
use super::file::{Corner, Face, File, NONE};
use super::part::Part;
use crate::{Mesh, NormalSource, normals};
use chiaro_basis::math::{Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// Builds meshes from the faces of one file, in memory that is used again.
pub(super) struct Builder<'a> {
    file: &'a File,
    triangulator: Triangulator,
    vertices: Vertices,
    points: Vec<Vec3>,
    triangles: Vec<[usize; 3]>,
}

/// The corners of an object that differ.
struct Vertices {
    /// The distinct corners, in order of first use.
    order: Vec<Corner>,
    /// For corners that are nothing but a position: the object, from 1, that used it last, and its
    /// vertex there.
    plain: Vec<(u32, u32)>,
    object: u32,
    others: HashMap<Corner, u32>,
}

impl Vertices {
    fn next_object(&mut self) {
        self.order.clear();
        self.others.clear();
        self.object += 1;
    }

    fn vertex(&mut self, corner: Corner) -> u32 {
        let next = self.order.len() as u32;
        let vertex = if corner.uv == NONE && corner.normal == NONE {
            let slot = &mut self.plain[corner.position as usize];
            if slot.0 != self.object {
                *slot = (self.object, next);
            }
            slot.1
        } else {
            *self.others.entry(corner).or_insert(next)
        };
        if vertex == next {
            self.order.push(corner);
        }
        vertex
    }
}

impl<'a> Builder<'a> {
    pub(super) fn new(file: &'a File) -> Self {
        let vertices = Vertices {
            order: Vec::new(),
            plain: vec![(0, 0); file.positions.len()],
            object: 0,
            others: HashMap::new(),
        };
        let (points, triangles) = Default::default();
        Self { file, triangulator: Triangulator::default(), vertices, points, triangles }
    }

    /// The mesh of an object, normals included.
    pub(super) fn mesh(&mut self, part: Part) -> Mesh {
        let Part { name, faces } = part;
        let mut mesh = Mesh { name, ..Mesh::default() };
        let faceted = faces.iter().all(|face| self.is_faceted(face));
        self.vertices.next_object();
        for (polygon, face) in faces.iter().enumerate() {
            self.face(&mut mesh, face, faceted);
            mesh.materials.resize(mesh.triangles.len(), face.material);
            mesh.polygons.resize(mesh.triangles.len(), polygon as u32);
        }
        let smoothing = smoothing(&faces, &mesh.polygons);
        if mesh.triangles.len() == faces.len() {
            mesh.polygons.clear();
        }
        self.attributes(&mut mesh);
        normals::finish(&mut mesh, &smoothing);
        mesh
    }

    /// Appends the triangles of a face.
    fn face(&mut self, mesh: &mut Mesh, face: &Face, faceted: bool) {
        let corners = self.file.corners(face);
        self.points.clear();
        self.points.extend(corners.iter().map(|c| self.file.positions[c.position as usize]));
        self.triangles.clear();
        self.triangulator.cut(&self.points, &mut self.triangles);
        for triangle in &self.triangles {
            mesh.triangles.push(triangle.map(|i| {
                let normal = if faceted { NONE } else { corners[i].normal };
                self.vertices.vertex(Corner { normal, ..corners[i] })
            }));
        }
    }

    /// Whether a face's normals say no more than its corners do. A whole object of such faces was
    /// meant to be faceted by nobody, as a rule: exporters write them for want of better ones.
    fn is_faceted(&self, face: &Face) -> bool {
        let corners = self.file.corners(face);
        let p = |i: usize| self.file.positions[corners[i].position as usize].as_dvec3();
        let normal = (p(1) - p(0)).cross(p(2) - p(0)).normalize_or_zero().as_vec3();
        corners.iter().all(|c| match self.file.normals.get(c.normal as usize) {
            Some(given) => normal == Vec3::ZERO || given.normalize_or_zero().dot(normal) > 0.9999,
            None => true,
        })
    }

    /// Fills in what belongs to the vertices; missing normals are NaN.
    fn attributes(&self, mesh: &mut Mesh) {
        let (file, order) = (self.file, &self.vertices.order);
        mesh.positions = order.iter().map(|c| file.positions[c.position as usize]).collect();
        if order.iter().any(|c| c.uv != NONE) {
            let uv = |c: &Corner| file.uvs.get(c.uv as usize).copied().unwrap_or(Vec2::ZERO);
            mesh.uvs = vec![order.iter().map(uv).collect()];
        }
        if order.iter().any(|c| c.normal != NONE) {
            let normal = |c: &Corner| file.normals.get(c.normal as usize).copied();
            let normals = order.iter().map(|c| normal(c).unwrap_or(Vec3::NAN));
            mesh.normals = NormalSource::Given(normals.collect());
        }
        if order.iter().any(|c| file.colour(c.position).is_some()) {
            let colour = |c: &Corner| {
                file.colour(c.position).map_or(Vec4::ONE, |c| Vec3::from(c).extend(1.0))
            };
            mesh.colours = order.iter().map(colour).collect();
        }
    }
}

/// The smoothing group of each triangle, or nothing when no face is in one: an `s off` that holds
/// throughout says no more than the format's default.
fn smoothing(faces: &[Face], polygons: &[u32]) -> Vec<u32> {
    if faces.iter().all(|face| face.smoothing == 0) {
        return Vec::new();
    }
    polygons.iter().map(|&polygon| faces[polygon as usize].smoothing).collect()
}
