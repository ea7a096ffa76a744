//! [`Posed`]: a surface at one time, and g of section 4.5.2.
//!
//! Normals are means of the faces around a vertex, weighted by angle, within its side of a crease;
//! then averaged over one-rings as often as the style asks, which takes the noise of scans out of
//! the silhouettes.

use crate::surface::{NONE, Surface, next};
use crate::view::View;
use chiaro_basis::math::DVec3;
use chiaro_scene::Frame;
use rayon::prelude::*;

/// Positions and normals of a surface's vertices at one time, in world space.
#[derive(Clone, Debug, Default)]
pub struct Posed {
    /// Positions.
    pub positions: Vec<DVec3>,
    /// Unit normals, or zero where all faces are flat.
    pub normals: Vec<DVec3>,
    /// Unit normals of the real faces, or zero.
    pub face_normals: Vec<DVec3>,
}

impl Posed {
    /// The surface in a frame, its normals smoothed `passes` times.
    pub fn new(surface: &Surface, frame: &Frame, passes: u32) -> Self {
        let positions = positions(surface, frame);
        let (mut normals, face_normals) = normals(surface, &positions);
        for _ in 0..passes {
            normals = smoothed(surface, &normals);
        }
        Self { positions, normals, face_normals }
    }

    /// g_v = n_v . (C - P_v): positive where a vertex faces the camera.
    pub fn facing(&self, view: &View) -> Vec<f64> {
        let g = |(p, n): (&DVec3, &DVec3)| n.dot(view.to_eye(*p));
        self.positions.par_iter().zip(&self.normals).map(g).collect()
    }
}

/// World positions; those of a vertex whose pose is not finite are the origin.
pub fn positions(surface: &Surface, frame: &Frame) -> Vec<DVec3> {
    let refined: Vec<Option<Vec<DVec3>>> = (surface.refinements.iter().zip(&frame.shapes))
        .map(|(r, shape)| r.as_ref().map(|r| r.points(&shape.positions)))
        .collect();
    let place = |a: &crate::surface::Anchor| {
        let object = &frame.objects[a.object as usize];
        let p = match refined.get(object.shape) {
            Some(Some(points)) => {
                let to_world = &object.world_from_shape;
                let m = to_world.matrix3;
                let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(|v| v.as_dvec3());
                let p = points[a.vertex as usize];
                x * p.x + y * p.y + z * p.z + to_world.translation.as_dvec3()
            }
            _ => {
                let p = frame.shapes[object.shape].positions[a.vertex as usize];
                object.world_from_shape.transform_point3(p).as_dvec3()
            }
        };
        if p.is_finite() { p } else { DVec3::ZERO }
    };
    surface.anchors.iter().map(place).collect()
}

fn normals(surface: &Surface, positions: &[DVec3]) -> (Vec<DVec3>, Vec<DVec3>) {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    let mut faces = vec![DVec3::ZERO; surface.real_faces];
    for (face, normal) in surface.faces[..surface.real_faces].iter().zip(&mut faces) {
        let [a, b, c] = face.map(|v| positions[v as usize]);
        let sides = [b - a, c - b, a - c];
        let cross = sides[0].cross(-sides[2]);
        let Some(n) = cross.try_normalize() else { continue };
        *normal = n;
        let lengths = sides.map(|s| s.length());
        for corner in 0..3 {
            let (u, v) = (sides[corner], -sides[(corner + 2) % 3]);
            let cosine = u.dot(v) / (lengths[corner] * lengths[(corner + 2) % 3]);
            sums[face[corner] as usize] += n * angle(cosine);
        }
    }
    (sums.into_iter().map(DVec3::normalize_or_zero).collect(), faces)
}

/// The arc cosine to within 7e-5 (Abramowitz and Stegun 4.4.45): enough for a weight.
fn angle(cosine: f64) -> f64 {
    let x = cosine.abs().min(1.0);
    let root = (1.0 - x).sqrt();
    let a = root * (1.570_728_8 + x * (-0.212_114_4 + x * (0.074_261_0 - x * 0.018_729_3)));
    if cosine < 0.0 { std::f64::consts::PI - a } else { a }
}

/// One-ring means over real edges; what a strip joins stays apart.
fn smoothed(surface: &Surface, normals: &[DVec3]) -> Vec<DVec3> {
    let mut sums = normals.to_vec();
    for half in 0..3 * surface.real_faces as u32 {
        let (a, b) = (surface.from(half) as usize, surface.from(next(half)) as usize);
        sums[a] += normals[b];
        let mate = surface.mate[half as usize];
        // The last spoke of an open fan has no half-edge out of its vertex.
        if mate == NONE || surface.is_strip(mate as usize / 3) {
            sums[b] += normals[a];
        }
    }
    sums.into_iter().map(DVec3::normalize_or_zero).collect()
}
