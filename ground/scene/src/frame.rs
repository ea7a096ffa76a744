//! [`Frame`]: the scene frozen at a time.

use crate::pose::normal_matrix;
use crate::{Bounds, Light, MeshId, NodeId, Pose};
use chiaro_basis::math::{Affine3A, Mat3, Vec3, Vec4};
use std::sync::Arc;

/// The scene frozen at a time. Object, vertex and triangle ids are the same at every time (except
/// for meshes that are remade).
#[derive(Clone, Debug)]
pub struct Frame {
    /// Seconds.
    pub time: f64,
    /// Deformed geometry. A shape with one object is in world space; a shape that is drawn several
    /// times is in its own space, placed by each object's matrix.
    pub shapes: Vec<Shape>,
    /// What is drawn.
    pub objects: Vec<Object>,
    /// Each of [`crate::Scene::cameras`] in world space.
    pub cameras: Vec<Pose>,
    /// Each of [`crate::Scene::lights`], with its world matrix (it shines along -z).
    pub lights: Vec<(Light, Affine3A)>,
}

/// Deformed geometry of one mesh.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Whose triangles, materials, uvs and colours.
    pub mesh: MeshId,
    /// The mesh made anew at this time, if it is of that kind; it replaces the scene's.
    pub remade: Option<Arc<crate::Mesh>>,
    /// Vertex positions.
    pub positions: Arc<[Vec3]>,
    /// Unit shading normals, one a vertex.
    pub normals: Arc<[Vec3]>,
    /// Unit tangents with the bitangent's sign, one a vertex, or empty.
    pub tangents: Arc<[Vec4]>,
}

/// One thing drawn.
#[derive(Clone, Debug)]
pub struct Object {
    /// The node that shows it.
    pub node: NodeId,
    /// Index into [`Frame::shapes`].
    pub shape: usize,
    /// From the shape's space to the world; the identity for shapes drawn once.
    pub world_from_shape: Affine3A,
    /// Whether the matrix mirrors, so that triangles wind clockwise seen from the front. World-space
    /// shapes of mirrored nodes have this flag too.
    pub mirrored: bool,
}

impl Object {
    /// The matrix for normals, up to a positive factor; finite where a flat matrix has no inverse.
    pub fn normal_from_shape(&self) -> Mat3 {
        if self.world_from_shape == Affine3A::IDENTITY {
            return Mat3::IDENTITY;
        }
        let m = normal_matrix(&Mat3::from(self.world_from_shape.matrix3).as_dmat3());
        let largest = m.to_cols_array().iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        if largest > 0.0 { (m * largest.recip()).as_mat3() } else { Mat3::IDENTITY }
    }
}

impl Shape {
    /// The mesh whose triangles these positions move.
    pub fn mesh_in<'a>(&'a self, scene: &'a crate::Scene) -> &'a crate::Mesh {
        self.remade.as_deref().unwrap_or_else(|| &scene.meshes[self.mesh.index()])
    }
}

impl Frame {
    /// World positions of an object's vertices.
    pub fn world_positions(&self, object: &Object) -> impl Iterator<Item = Vec3> + '_ {
        let m = object.world_from_shape;
        self.shapes[object.shape].positions.iter().map(move |&p| m.transform_point3(p))
    }

    /// The box of everything drawn, in world space.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.objects.iter().flat_map(|o| self.world_positions(o)))
    }
}
