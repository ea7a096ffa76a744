//! Clouds of points as surfaces: every point a small disc of the surface that its neighbours span.
//!
//! 1. The nearest neighbours of every point are found ([`neighbours`]).
//! 2. Where the file has no normals they are those of the planes through the neighbours, turned to
//!    one side from point to point ([`orient`]).
//! 3. A point stands for the area that the distance to its neighbours tells. Its disc, a hexagon, is
//!    so wide that it meets those of the neighbours all around.
//! 4. The corners of a hexagon lie on the moving least squares plane of the points near them, with
//!    their mean normals and colours (Alexa et al. 2003), so that discs run into each other smoothly.
//!
//! Guaranteed: the same mesh for any number of threads. Not guaranteed: sharp edges, which are
//! rounded over a spacing; discs reach a little beyond the cloud's rim, and close gaps narrower than
//! about two spacings.

mod neighbours;
mod orient;

use crate::mesh::is_in_reach;
use crate::{MaterialId, Mesh, NormalSource};
use chiaro_basis::math::{Vec3, Vec4};
use neighbours::Tree;
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};

/// Points with what a file says of them; arrays are empty or as long as `positions`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Points {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    /// Linear RGBA.
    pub(crate) colours: Vec<Vec4>,
}

/// Triangles of a disc; the first holds its middle.
pub(crate) const FACES: usize = 4;
const CORNERS: usize = 6;
/// Neighbours that a disc is made from.
const NEAREST: usize = 14;
/// The neighbour whose distance tells the area that a point stands for.
const KTH: usize = 8;
/// Radii of discs, in radii of that area.
const NARROWEST: f32 = 1.1;
const WIDEST: f32 = 2.5;
/// The radius of a disc over its distance to a neighbour that it must meet.
const MEETS: f32 = 0.75;
/// The least cosine between normals of one sheet.
const SHEET: f32 = 0.3;

/// A point's neighbourhood.
struct Place {
    near: Vec<u32>,
    /// The area that the point stands for.
    area: f32,
}

/// The discs of a cloud, and whether its normals had to be estimated. Points that are not finite, and
/// all but one at one place, are left out; a cloud of fewer than three has no discs.
pub(crate) fn discs(mut points: Points) -> (Mesh, bool) {
    points.clean();
    if points.positions.len() < 3 {
        return (Mesh::default(), false);
    }
    let tree = Tree::new(&points.positions);
    let places: Vec<Place> = (0..points.positions.len())
        .into_par_iter()
        .map(|i| place(&points.positions, &tree, i as u32))
        .collect();
    let given = points.normals.len() == points.positions.len()
        && points.normals.iter().all(|n| n.is_finite() && n.length_squared() > 0.0);
    points.normals = match given {
        true => points.normals.iter().map(|n| n.normalize()).collect(),
        false => {
            let near: Vec<&[u32]> = places.iter().map(|p| &p.near[..]).collect();
            orient::normals(&points.positions, &near)
        }
    };
    (mesh(&points, &places), !given)
}

impl Points {
    /// Leaves out what is not finite or stands where another does.
    fn clean(&mut self) {
        let mut order: Vec<u32> = (0..self.positions.len() as u32).collect();
        let counts = |p: Vec3| p.is_finite() && is_in_reach(p);
        order.retain(|&i| counts(self.positions[i as usize]));
        let key = |i: u32| self.positions[i as usize].to_array().map(|c| (c + 0.0).to_bits());
        order.sort_by_key(|&i| (key(i), i));
        order.dedup_by_key(|i| key(*i));
        order.sort_unstable();
        fn pick<T: Copy>(of: &mut Vec<T>, order: &[u32]) {
            if !of.is_empty() {
                *of = order.iter().map(|&i| of[i as usize]).collect();
            }
        }
        pick(&mut self.positions, &order);
        pick(&mut self.normals, &order);
        pick(&mut self.colours, &order);
    }
}

fn place(positions: &[Vec3], tree: &Tree, index: u32) -> Place {
    let p = positions[index as usize];
    let found = tree.nearest(positions, p, NEAREST + 1);
    let near: Vec<u32> = found.iter().map(|n| n.1).filter(|n| *n != index).collect();
    let kth = KTH.min(near.len());
    let square = (positions[near[kth - 1] as usize] - p).length_squared();
    Place { near, area: (PI * square / kth as f32).max(1e-30) }
}

/// How wide a disc must be to meet its neighbours all around: the nearest in each sixth counts.
fn radius(points: &Points, place: &Place, index: usize, [right, up]: [Vec3; 2]) -> f32 {
    let own = (place.area / PI).sqrt();
    let (p, n) = (points.positions[index], points.normals[index]);
    let mut nearest = [f32::INFINITY; CORNERS];
    for &j in &place.near {
        let d = points.positions[j as usize] - p;
        if points.normals[j as usize].dot(n) > SHEET {
            let angle = d.dot(up).atan2(d.dot(right)) / TAU + 0.5;
            let sixth = ((angle * CORNERS as f32) as usize).min(CORNERS - 1);
            nearest[sixth] = nearest[sixth].min(d.length());
        }
    }
    let far = nearest.into_iter().filter(|d| d.is_finite()).fold(0.0, f32::max);
    (MEETS * far).clamp(NARROWEST * own, WIDEST * own)
}

fn mesh(points: &Points, places: &[Place]) -> Mesh {
    struct Disc {
        corners: [(Vec3, Vec3, Vec4); CORNERS],
        share: f32,
    }
    let discs: Vec<Disc> = places
        .par_iter()
        .enumerate()
        .map(|(i, place)| {
            let n = points.normals[i];
            let right = n.any_orthonormal_vector();
            let up = n.cross(right);
            let wide = radius(points, place, i, [right, up]) / (PI / CORNERS as f32).cos();
            let corners = std::array::from_fn(|k| {
                let (sin, cos) = (TAU * k as f32 / CORNERS as f32).sin_cos();
                let at = points.positions[i] + (right * cos + up * sin) * wide;
                corner(points, place, i, at)
            });
            let [a, b, c] = [0, 2, 4].map(|k| corners[k].0);
            let inner = 0.5 * (b - a).cross(c - a).length();
            Disc { corners, share: place.area / inner.max(f32::MIN_POSITIVE) }
        })
        .collect();
    let corners = || discs.iter().flat_map(|d| &d.corners);
    let fan = |d: usize| {
        let v = (CORNERS * d) as u32;
        [[0, 2, 4], [0, 1, 2], [2, 3, 4], [4, 5, 0]].map(|t| t.map(|k| v + k))
    };
    Mesh {
        positions: corners().map(|c| c.0).collect(),
        normals: NormalSource::Given(corners().map(|c| c.1).collect()),
        colours: match points.colours.is_empty() {
            true => Vec::new(),
            false => corners().map(|c| c.2).collect(),
        },
        triangles: (0..discs.len()).flat_map(fan).collect(),
        materials: vec![MaterialId::new(0); FACES * discs.len()],
        discs: discs.iter().map(|d| d.share).collect(),
        ..Mesh::default()
    }
}

/// A corner moved onto the plane of the points near it, with their normal and colour.
fn corner(points: &Points, place: &Place, index: usize, at: Vec3) -> (Vec3, Vec3, Vec4) {
    let own = points.normals[index];
    let scale = PI / place.area;
    let (mut normal, mut middle, mut colour, mut sum) = (Vec3::ZERO, Vec3::ZERO, Vec4::ZERO, 0.0);
    for j in place.near.iter().map(|j| *j as usize).chain([index]) {
        let n = points.normals[j];
        if n.dot(own) <= SHEET {
            continue;
        }
        let w = (-scale * (points.positions[j] - at).length_squared()).exp() + 1e-6;
        sum += w;
        normal += n * w;
        middle += points.positions[j] * w;
        colour += points.colours.get(j).copied().unwrap_or(Vec4::ONE) * w;
    }
    let normal = normal.normalize_or(own);
    let lift = normal.dot(middle / sum - at);
    // Far from its points a plane says nothing.
    let most = 0.5 * (place.area / PI).sqrt();
    (at + normal * lift.clamp(-most, most), normal, colour / sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::vec3;
    use chiaro_basis::random;

    /// Points of a unit sphere, random but for their number.
    fn sphere(count: usize) -> Points {
        let point = |i: usize| {
            let [u, v] = [random::unit(1, i as u64), random::unit(2, i as u64)];
            let (z, (sin, cos)) = (2.0 * u - 1.0, (TAU * v).sin_cos());
            let r = (1.0 - z * z).sqrt();
            vec3(r * cos, z, r * sin)
        };
        Points { positions: (0..count).map(point).collect(), ..Points::default() }
    }

    #[test]
    fn a_sphere_of_points_becomes_a_closed_one() {
        let (mesh, estimated) = discs(sphere(3000));
        assert!(estimated);
        assert_eq!((mesh.discs.len(), mesh.triangles.len()), (3000, 12_000));
        let NormalSource::Given(normals) = &mesh.normals else { panic!("discs have normals") };
        for (p, n) in mesh.positions.iter().zip(normals) {
            assert!((p.length() - 1.0).abs() < 0.03, "{p}");
            assert!(n.dot(p.normalize()) > 0.97, "{p} {n}");
        }
        // What the points stand for is the sphere's area, though discs overlap.
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        let sum: f32 =
            mesh.discs.iter().enumerate().map(|(i, s)| s * area(&mesh.triangles[FACES * i])).sum();
        assert!((sum / (4.0 * PI) - 1.0).abs() < 0.1, "{sum}");
        // From the middle nearly nothing of the outside is seen.
        let blocked = |d: Vec3| {
            mesh.triangles.iter().any(|t| {
                let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
                [a.cross(b), b.cross(c), c.cross(a)].iter().all(|n| n.dot(d) > -1e-7)
            })
        };
        let holes = (0..500).filter(|i| !blocked(sphere(5000).positions[4000 + i])).count();
        assert!(holes <= 2, "{holes} holes of 500");
    }

    #[test]
    fn odd_points_are_left_out() {
        let mut points = sphere(100);
        points.positions.extend([vec3(f32::NAN, 0.0, 0.0), points.positions[3], Vec3::splat(1e20)]);
        points.normals = vec![Vec3::ZERO; 103];
        let (mesh, estimated) = discs(points);
        assert!(estimated && mesh.discs.len() == 100);
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        assert!(discs(sphere(2)).0.triangles.is_empty());
        let line = (0..50).map(|i| vec3(i as f32, 0.0, 0.0)).collect();
        let (mesh, _) = discs(Points { positions: line, ..Points::default() });
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
    }
}
