//! The camera of a picture that does not say where it was taken from, fitted to what it shows.
//!
//! - With positions P and depths z: P = C + z (a + x b + y c) is linear in the eye C and in the
//!   vectors a, b, c that span the picture; least squares gives them all.
//! - With depths and world normals alone: positions for a 50 mm lens on 36 mm film (Blender's own)
//!   give normals in the axes of the camera; the turn that takes the given normals to them best
//!   (Wahba's problem, by Davenport's quaternion) is the camera's.
//! - With neither the normals are those of the camera's own axes: x right, y up, z to the viewer.

use chiaro_basis::math::Vec3;
use chiaro_image::Plane;
use chiaro_scene::{Pose, Projection};

/// The camera's own axes, the eye in the origin.
pub(super) fn axes(projection: Projection) -> Pose {
    Pose {
        position: Vec3::ZERO,
        right: Vec3::X,
        up: Vec3::Y,
        forward: Vec3::NEG_Z,
        projection,
        near: 0.0,
    }
}

/// A 50 mm lens on film 36 mm wide, the longer side of the picture.
pub(super) fn usual_lens((width, height): (usize, usize)) -> Projection {
    let longer = width.max(height) as f32;
    Projection::Perspective { fov_y: 2.0 * (0.36 * height as f32 / longer).atan() }
}

/// Fits a camera to positions and depths along its axis; `None` when they do not make one.
pub(super) fn fitted(
    position: &Plane<[f32; 3]>,
    depth: &Plane<f32>,
    covered: &Plane<bool>,
) -> Option<Pose> {
    let (w, h) = covered.size();
    let (mut normal, mut right) = ([[0.0f64; 4]; 4], [[0.0f64; 3]; 4]);
    for y in 0..h {
        for x in (0..w).filter(|x| covered[(*x, y)]) {
            let z = f64::from(depth[(x, y)]);
            let row = [
                1.0,
                z,
                z * (x as f64 + 0.5 - 0.5 * w as f64),
                z * (0.5 * h as f64 - y as f64 - 0.5),
            ];
            for i in 0..4 {
                for j in 0..4 {
                    normal[i][j] += row[i] * row[j];
                }
                for (k, p) in position[(x, y)].into_iter().enumerate() {
                    right[i][k] += row[i] * f64::from(p);
                }
            }
        }
    }
    let [eye, forward, across, up] = solve(normal, right)?.map(|v| Vec3::from(v.map(|x| x as f32)));
    let lengths = [forward.length(), across.length(), up.length()];
    let square = (lengths[1] / lengths[2] - 1.0).abs() < 0.2;
    let upright = forward.dot(across).abs() < 0.05 * lengths[0] * lengths[1];
    let sane = (lengths[0] - 1.0).abs() < 0.05 && square && upright && eye.is_finite();
    sane.then(|| {
        let fov_y = 2.0 * (0.5 * h as f32 * lengths[2]).atan();
        Pose::look_at(eye, eye + forward, up, Projection::Perspective { fov_y })
    })
}

/// Gauss elimination with pivots.
fn solve(mut a: [[f64; 4]; 4], mut b: [[f64; 3]; 4]) -> Option<[[f64; 3]; 4]> {
    for i in 0..4 {
        let pivot = (i..4).max_by(|j, k| a[*j][i].abs().total_cmp(&a[*k][i].abs()))?;
        a.swap(i, pivot);
        b.swap(i, pivot);
        if a[i][i].abs() < 1e-12 {
            return None;
        }
        for j in (0..4).filter(|j| *j != i) {
            let t = a[j][i] / a[i][i];
            let (pivot, beside) = (a[i], b[i]);
            a[j].iter_mut().zip(pivot).for_each(|(x, p)| *x -= t * p);
            b[j].iter_mut().zip(beside).for_each(|(x, p)| *x -= t * p);
        }
    }
    Some(std::array::from_fn(|i| b[i].map(|v| v / a[i][i])))
}

/// The turn that takes `pairs` of (given, seen) directions onto each other best, as a camera pose
/// with the eye in the origin: `seen` are in the camera's axes.
pub(super) fn turned(pairs: impl Iterator<Item = (Vec3, Vec3)>, projection: Projection) -> Pose {
    let mut m = [[0.0f64; 3]; 3];
    for (given, seen) in pairs {
        let (g, s) = (given.to_array(), seen.to_array());
        for i in 0..3 {
            for j in 0..3 {
                m[i][j] += f64::from(s[i]) * f64::from(g[j]);
            }
        }
    }
    let [w, x, y, z] = quaternion(m);
    // Rows take world to camera; the camera's axes in the world are the rows themselves.
    let row = |a: f64, b: f64, c: f64| Vec3::new(a as f32, b as f32, c as f32);
    let right = row(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y));
    let up = row(2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x));
    let back = row(2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y));
    Pose { position: Vec3::ZERO, right, up, forward: -back, projection, near: 0.0 }
}

/// The greatest eigenvector of Davenport's matrix for sum of seen x given^T, by power iteration.
fn quaternion(m: [[f64; 3]; 3]) -> [f64; 4] {
    let trace = m[0][0] + m[1][1] + m[2][2];
    let v = [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]];
    let mut k = [[0.0; 4]; 4];
    k[0] = [trace, v[0], v[1], v[2]];
    for i in 0..3 {
        k[i + 1][0] = v[i];
        for j in 0..3 {
            k[i + 1][j + 1] = m[i][j] + m[j][i] - if i == j { trace } else { 0.0 };
        }
    }
    // Made positive, so that the greatest in value is the greatest in size.
    let shift: f64 = k.iter().flatten().map(|x| x.abs()).sum::<f64>().max(1e-30);
    let mut q = [1.0, 0.01, 0.02, 0.03];
    for _ in 0..2000 {
        let next: [f64; 4] =
            std::array::from_fn(|i| shift * q[i] + (0..4).map(|j| k[i][j] * q[j]).sum::<f64>());
        let length = next.iter().map(|x| x * x).sum::<f64>().sqrt();
        q = next.map(|x| x / length);
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose() -> Pose {
        let projection = Projection::Perspective { fov_y: 0.6 };
        Pose::look_at(Vec3::new(4.0, 3.0, 5.0), Vec3::new(0.2, 0.0, -0.3), Vec3::Y, projection)
    }

    #[test]
    fn a_camera_is_found_from_positions_and_depths() {
        let (w, h) = (40, 30);
        let pose = pose();
        let depth = Plane::from_fn(w, h, |x, y| 5.0 + ((x * 7 + y * 13) % 11) as f32 * 0.2);
        let position = Plane::from_fn(w, h, |x, y| {
            let (o, d) = pose.ray(x as f32 + 0.5, y as f32 + 0.5, w as f32, h as f32);
            (o + d * (depth[(x, y)] / d.dot(pose.forward))).to_array()
        });
        let found = fitted(&position, &depth, &Plane::filled(w, h, true)).unwrap();
        assert!((found.position - pose.position).length() < 1e-3);
        assert!((found.forward - pose.forward).length() < 1e-4);
        assert!((found.up - pose.up).length() < 1e-3);
        let Projection::Perspective { fov_y } = found.projection else { panic!() };
        assert!((fov_y - 0.6).abs() < 1e-3);
        let flat = Plane::filled(w, h, [0.0; 3]);
        assert!(fitted(&flat, &depth, &Plane::filled(w, h, true)).is_none());
    }

    #[test]
    fn a_turn_is_found_from_two_sets_of_normals() {
        let pose = pose();
        let normals = (0..50).map(|i| {
            let (a, b) = (i as f32 * 0.7, i as f32 * 1.3);
            Vec3::new(a.sin(), b.cos(), (a * b).sin()).normalize()
        });
        let pairs = normals
            .map(|n| (n, Vec3::new(n.dot(pose.right), n.dot(pose.up), -n.dot(pose.forward))));
        let found = turned(pairs, pose.projection);
        assert!((found.forward - pose.forward).length() < 1e-3, "{found:?}");
        assert!((found.up - pose.up).length() < 1e-3);
    }
}
