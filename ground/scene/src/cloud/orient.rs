//! Normals of points that come without: planes through neighbours, turned to one side.
//!
//! The normal of a point is the direction in which it and its neighbours vary least. Sides are
//! carried from neighbour to neighbour along a spanning tree, first where normals agree most (Hoppe
//! et al. 1992); each piece of the cloud begins at its point farthest from the middle of all, which
//! looks away from there.

use chiaro_basis::math::{DMat3, DVec3, Vec3};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Unit normals of points, given each one's neighbours.
pub(super) fn normals(points: &[Vec3], near: &[&[u32]]) -> Vec<Vec3> {
    let mut normals: Vec<Vec3> =
        (0..points.len()).into_par_iter().map(|i| plane(points, i, near[i])).collect();
    orient(points, near, &mut normals);
    normals
}

/// The direction in which a point and its neighbours vary least.
fn plane(points: &[Vec3], index: usize, near: &[u32]) -> Vec3 {
    let all =
        || near.iter().map(|j| points[*j as usize].as_dvec3()).chain([points[index].as_dvec3()]);
    let mean = all().sum::<DVec3>() / (near.len() + 1) as f64;
    let spread = all().fold(DMat3::ZERO, |sum, p| {
        let d = p - mean;
        sum + DMat3::from_cols(d * d.x, d * d.y, d * d.z)
    });
    least_direction(spread).as_vec3().normalize_or(Vec3::Y)
}

/// The unit eigenvector of the least eigenvalue of a symmetric matrix: the eigenvalue in closed form
/// (Smith 1961), the vector from the rows that it leaves.
fn least_direction(m: DMat3) -> DVec3 {
    let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z;
    if !(trace > 0.0 && trace.is_finite()) {
        return DVec3::Y;
    }
    let m = m * (1.0 / trace);
    let b = m - DMat3::IDENTITY * (1.0 / 3.0);
    let square = b.x_axis.length_squared() + b.y_axis.length_squared() + b.z_axis.length_squared();
    let p = (square / 6.0).sqrt();
    if p < 1e-12 {
        return DVec3::Y;
    }
    let half = ((b * (1.0 / p)).determinant() / 2.0).clamp(-1.0, 1.0);
    let least = 1.0 / 3.0 + 2.0 * p * (half.acos() / 3.0 + std::f64::consts::TAU / 3.0).cos();
    let rest = m - DMat3::IDENTITY * least;
    let (x, y, z) = (rest.x_axis, rest.y_axis, rest.z_axis);
    let longest = [x.cross(y), y.cross(z), z.cross(x)]
        .into_iter()
        .fold(DVec3::ZERO, |a, b| if b.length_squared() > a.length_squared() { b } else { a });
    if longest.length_squared() > 1e-24 {
        return longest.normalize();
    }
    // Two least eigenvalues: whatever is square to the largest, as with points of a line.
    let along = [x, y, z]
        .into_iter()
        .fold(x, |a, b| if b.length_squared() > a.length_squared() { b } else { a });
    along.try_normalize().map_or(DVec3::Y, |a| a.any_orthonormal_vector())
}

fn orient(points: &[Vec3], near: &[&[u32]], normals: &mut [Vec3]) {
    let middle = points.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / points.len() as f64;
    let middle = middle.as_vec3();
    let mut links: Vec<Vec<u32>> = near.iter().map(|n| n.to_vec()).collect();
    for (i, n) in near.iter().enumerate() {
        n.iter().for_each(|j| links[*j as usize].push(i as u32));
    }
    let mut outermost: Vec<u32> = (0..points.len() as u32).collect();
    let far = |i: &u32| (points[*i as usize] - middle).length_squared();
    outermost.sort_by(|a, b| far(b).total_cmp(&far(a)).then(a.cmp(b)));
    let mut done = vec![false; points.len()];
    for seed in outermost {
        if done[seed as usize] {
            continue;
        }
        let s = seed as usize;
        if normals[s].dot(points[s] - middle) < 0.0 {
            normals[s] = -normals[s];
        }
        // Least disagreement first; bits of floats that are not negative are in their order.
        let mut heap = BinaryHeap::from([Reverse((0u32, seed, seed))]);
        while let Some(Reverse((_, i, from))) = heap.pop() {
            let k = i as usize;
            if std::mem::replace(&mut done[k], true) {
                continue;
            }
            if normals[k].dot(normals[from as usize]) < 0.0 {
                normals[k] = -normals[k];
            }
            for &j in links[k].iter().filter(|j| !done[**j as usize]) {
                let disagree = (1.0 - normals[k].dot(normals[j as usize]).abs()).max(0.0);
                heap.push(Reverse((disagree.to_bits(), j, i)));
            }
        }
    }
}
