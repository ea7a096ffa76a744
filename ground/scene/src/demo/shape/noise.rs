//! Noise in space: smooth, layered, ridged, and the cells of scattered points.

use chiaro_basis::math::{IVec2, Vec3, vec3};
use chiaro_basis::random::{hash, unit};

/// Gradient noise in about [-1, 1], zero at lattice points, twice differentiable (Perlin 2002).
pub(crate) fn noise(seed: u64, p: Vec3) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let corner = |x: f32, y: f32, z: f32| {
        let c = vec3(x, y, z);
        gradient(seed, cell + c).dot(f - c)
    };
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let edge = |y: f32, z: f32| mix(corner(0.0, y, z), corner(1.0, y, z), s.x);
    let face = |z: f32| mix(edge(0.0, z), edge(1.0, z), s.y);
    1.5 * mix(face(0.0), face(1.0), s.z)
}

/// A unit vector of a lattice point.
fn gradient(seed: u64, cell: Vec3) -> Vec3 {
    let h = hash(seed, key(cell));
    let part = |k: u32| ((h >> (20 * k)) & 0xf_ffff) as f32 / 524_288.0 - 1.0;
    let (z, turn) = (part(0), part(1) * std::f32::consts::PI);
    let r = (1.0 - z * z).max(0.0).sqrt();
    vec3(r * turn.cos(), r * turn.sin(), z)
}

fn key(cell: Vec3) -> u64 {
    let bits = |x: f32| (x as i64 & 0x1f_ffff) as u64;
    bits(cell.x) | bits(cell.y) << 21 | bits(cell.z) << 42
}

/// Layers of noise, each at twice the frequency and half the height.
pub(crate) fn layers(seed: u64, p: Vec3, count: u32) -> f32 {
    let layer = |k: u32| noise(seed + u64::from(k), p * (1u32 << k) as f32) / (1u32 << k) as f32;
    (0..count).map(layer).sum()
}

/// Layers with sharp crests, in about [0, 1] (after Musgrave's ridged multifractals).
pub(crate) fn ridges(seed: u64, p: Vec3, count: u32) -> f32 {
    let (mut sum, mut weight) = (0.0, 0.5);
    for k in 0..count {
        let n = 1.0 - noise(seed + u64::from(k), p * (1u32 << k) as f32).abs();
        sum += weight * n * n;
        weight *= 0.5;
    }
    sum
}

/// The nearest of one point a unit cell in the plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// Distance to the nearest point.
    pub(crate) nearest: f32,
    /// Distance to the border with the next point's cell.
    pub(crate) border: f32,
    /// A number of the nearest point, for more randomness.
    pub(crate) id: u64,
    /// From the nearest point.
    pub(crate) from: [f32; 2],
}

/// Cells of jittered points in the plane (Worley 1996), `jitter` in [0, 1].
pub(crate) fn cells(seed: u64, x: f32, y: f32, jitter: f32) -> Cell {
    let (cx, cy) = (x.floor() as i32, y.floor() as i32);
    let point = |i: i32, j: i32| {
        let at = IVec2::new(cx + i, cy + j);
        let id = (at.x as u32 as u64) << 32 | at.y as u32 as u64;
        let place = |k: u64| 0.5 + jitter * (unit(seed + k, id) - 0.5);
        (at.x as f32 + place(0) - x, at.y as f32 + place(1) - y, id)
    };
    let around = || (-2..=2).flat_map(|j| (-2..=2).map(move |i| (i, j)));
    let nearest = around()
        .map(|(i, j)| point(i, j))
        .min_by(|a, b| (a.0 * a.0 + a.1 * a.1).total_cmp(&(b.0 * b.0 + b.1 * b.1)))
        .expect("there are 25 cells around");
    let border = around()
        .map(|(i, j)| point(i, j))
        .filter(|p| p.2 != nearest.2)
        .map(|p| {
            let (dx, dy) = (p.0 - nearest.0, p.1 - nearest.1);
            let (mx, my) = (0.5 * (p.0 + nearest.0), 0.5 * (p.1 + nearest.1));
            (mx * dx + my * dy) / dx.hypot(dy).max(1e-6)
        })
        .fold(f32::INFINITY, f32::min);
    Cell {
        nearest: nearest.0.hypot(nearest.1),
        border,
        id: nearest.2,
        from: [-nearest.0, -nearest.1],
    }
}
