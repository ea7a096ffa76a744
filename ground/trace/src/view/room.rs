//! The view from inside a room.
//!
//! A scene is a room when, at some point of a coarse grid inside its box, at least 95 % of evenly
//! spread rays meet the front of a face, and their median length is over 2 % of the diagonal and
//! half a unit (a metre in glTF: helmets and cannons are hollow too), or over 12 % of the diagonal.
//!
//! 1. Eyes stand at 45 % of the room's height above or below the passing points; those with the
//!    greatest median length are tried.
//! 2. Each looks level into 16 quarters, from where it stands and from as far back as the room
//!    goes: the view is 75 degrees wide.
//! 3. The view counts whose small picture has features spread over most of its area, depth, and no
//!    wall right before the eye. (The deepest quarter alone often shows one blank wall.) All are
//!    judged by tiny pictures first, and the best eighth by larger ones.

use crate::tracer::{Hit, Ray, Sides, Tracer};
use chiaro_basis::math::{Quat, Vec3};
use chiaro_scene::{Bounds, Pose, Projection};
use rayon::prelude::*;

/// Rays from each grid point.
const RAYS: usize = 96;
/// Eyes that are tried, at most.
const EYES: usize = 24;
/// Directions that each eye looks into.
const HEADINGS: usize = 16;
/// Cells of the small pictures that views are judged by: each has a feature or has none.
const CELLS: (usize, usize) = (8, 6);
/// Pixels along the side of a cell, at first and then of the best views, one in so many.
const TINY: usize = 2;
const SMALL: usize = 5;
const BEST: usize = 8;

/// Where to stand in a room, and where to look.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stand {
    eye: Vec3,
    forward: Vec3,
}

impl Stand {
    /// The best stand, if the scene is a room.
    pub(super) fn find(tracer: &Tracer) -> Option<Self> {
        let bounds = tracer.frame.bounds();
        let eyes = eyes(tracer, &bounds);
        let stands: Vec<Stand> =
            eyes.iter().flat_map(|&eye| Self::around(tracer, &bounds, eye)).collect();
        let diagonal = 2.0 * bounds.radius();
        let count = stands.len().div_ceil(BEST);
        let promising = best(stands, count, |s| s.score(tracer, diagonal, TINY));
        best(promising, 1, |s| s.score(tracer, diagonal, SMALL)).pop()
    }

    /// The stands with the eye at a place and with its back to the wall.
    fn around(tracer: &Tracer, bounds: &Bounds, eye: Vec3) -> Vec<Self> {
        let heading = |k: usize| {
            Quat::from_rotation_y(k as f32 * std::f32::consts::TAU / HEADINGS as f32) * -Vec3::Z
        };
        let both = |k: usize| {
            let forward = heading(k);
            let behind = match reach(tracer, eye, -forward) {
                Some(wall) => 0.8 * wall,
                // Through an opening the eye may step out until it sees the room's whole height.
                None => leave(bounds, eye, -forward) + 0.7 * (bounds.max.y - bounds.min.y),
            };
            [eye, eye - forward * behind].map(|eye| Self { eye, forward })
        };
        (0..HEADINGS).flat_map(both).collect()
    }

    /// The level view, 75 degrees wide at 4:3.
    pub(super) fn view(&self, orbit: f32) -> Pose {
        let forward = Quat::from_rotation_y(orbit.to_radians()) * self.forward;
        let fov_y = 2.0 * (0.75 * (37.5f32).to_radians().tan()).atan();
        let projection = Projection::Perspective { fov_y };
        Pose::look_at(self.eye, self.eye + forward, Vec3::Y, projection)
    }

    /// How much the view shows: the share of cells with a feature and the depth of the room, less
    /// what is too near or empty.
    fn score(&self, tracer: &Tracer, diagonal: f32, cell: usize) -> f32 {
        let pose = self.view(0.0);
        let (w, h) = (CELLS.0 * cell, CELLS.1 * cell);
        let small: Vec<Option<Seen>> =
            (0..w * h).map(|i| Seen::at(tracer, &pose, (i % w, i / w), (w, h))).collect();
        let hits = small.iter().flatten();
        let mut depths: Vec<f32> = hits.map(|s| s.depth).collect();
        if depths.is_empty() {
            return f32::NEG_INFINITY;
        }
        depths.sort_by(f32::total_cmp);
        let far = depths[depths.len() * 9 / 10];
        let count = |f: &dyn Fn(&f32) -> bool| depths.iter().filter(|d| f(d)).count() as f32;
        let all = (w * h) as f32;
        let near = count(&|d| *d < 0.15 * far) / all;
        let empty = 1.0 - depths.len() as f32 / all;
        let behind = small.iter().flatten().filter(|s| s.back).count() as f32 / all;
        let mean = depths.iter().sum::<f32>() / all;
        let shown = featured(&small, cell) + 0.8 * mean / diagonal;
        shown - 0.8 * near - 0.5 * (empty - 0.3).max(0.0) - behind
    }
}

/// What a small picture shows in a pixel.
struct Seen {
    hit: Hit,
    depth: f32,
    position: Vec3,
    normal: Vec3,
    back: bool,
}

impl Seen {
    fn at(
        tracer: &Tracer,
        pose: &Pose,
        (x, y): (usize, usize),
        (w, h): (usize, usize),
    ) -> Option<Self> {
        let (origin, direction) = pose.ray(x as f32 + 0.5, y as f32 + 0.5, w as f32, h as f32);
        let ray = Ray { origin, direction, t_max: f32::INFINITY };
        let hit = tracer.hit(&ray, Sides::AsMaterials)?;
        let position = origin + direction * hit.t;
        let normal = tracer.face_normal(&hit);
        let back = !tracer.meets_front(&hit, direction);
        let depth = pose.view(position).z;
        Some(Self { hit, depth, position, normal, back })
    }

    /// Whether a line would be drawn between two neighbours.
    fn differs(&self, other: &Self) -> bool {
        let offset = other.position - self.position;
        let step = offset.dot(self.normal).abs().min(offset.dot(other.normal).abs());
        let bend = self.normal.dot(other.normal).abs() < 0.8;
        bend || step > 0.04 * self.depth.min(other.depth) || self.hit.object != other.hit.object
    }
}

/// The `count` stands of the highest score, of equal ones the first.
fn best(
    stands: Vec<Stand>,
    count: usize,
    score: impl Fn(&Stand) -> f32 + Sync + Send,
) -> Vec<Stand> {
    let scores: Vec<f32> = stands.par_iter().map(score).collect();
    let mut ranked: Vec<(f32, Stand)> = scores.into_iter().zip(stands).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    ranked.into_iter().take(count).map(|(_, stand)| stand).collect()
}

/// The share of cells, of this side in pixels, that hold a feature: a step, a bend, another object,
/// or an outline.
fn featured(small: &[Option<Seen>], cell: usize) -> f32 {
    let (columns, rows) = CELLS;
    let (w, h) = (columns * cell, rows * cell);
    let is_feature = |a: usize, b: usize| match (&small[a], &small[b]) {
        (Some(a), Some(b)) => a.differs(b),
        (None, None) => false,
        _ => true,
    };
    let has = |at: usize| {
        let (x0, y0) = (at % columns * cell, at / columns * cell);
        let pairs = (0..cell * cell).map(|i| (x0 + i % cell, y0 + i / cell));
        let mut pairs = pairs.filter(|(x, y)| x + 1 < w && y + 1 < h);
        pairs.any(|(x, y)| {
            let at = y * w + x;
            is_feature(at, at + 1) || is_feature(at, at + w)
        })
    };
    (0..columns * rows).filter(|c| has(*c)).count() as f32 / (columns * rows) as f32
}

/// Places to stand, those with the longest median first; none when the scene is no room.
fn eyes(tracer: &Tracer, bounds: &Bounds) -> Vec<Vec3> {
    let diagonal = 2.0 * bounds.radius();
    let found: Vec<Option<(f32, Vec3)>> = grid(bounds)
        .into_par_iter()
        .map(|p| {
            let is_roomy = |m: &f32| *m > 0.12 * diagonal || (*m > 0.02 * diagonal && *m > 0.5);
            median_length(tracer, p).filter(is_roomy)?;
            // A point under the roof may be the freest, and its eye inside a column.
            let eye = eye_over(tracer, p);
            Some((median_length(tracer, eye)?, eye))
        })
        .collect();
    let mut eyes: Vec<(f32, Vec3)> = found.into_iter().flatten().collect();
    eyes.sort_by(|a, b| b.0.total_cmp(&a.0));
    eyes.dedup_by(|a, b| a.1.distance(b.1) < 1e-3 * diagonal);
    eyes.into_iter().take(EYES).map(|(_, eye)| eye).collect()
}

/// The distance to the nearest surface.
fn reach(tracer: &Tracer, origin: Vec3, direction: Vec3) -> Option<f32> {
    let ray = Ray { origin, direction, t_max: f32::INFINITY };
    tracer.hit(&ray, Sides::Both).map(|h| h.t)
}

/// The distance at which a ray from inside leaves the box.
fn leave(bounds: &Bounds, origin: Vec3, direction: Vec3) -> f32 {
    let side = |k: usize| {
        let wall = if direction[k] > 0.0 { bounds.max[k] } else { bounds.min[k] };
        if direction[k].abs() < 1e-6 { f32::INFINITY } else { (wall - origin[k]) / direction[k] }
    };
    (0..3).map(side).fold(f32::INFINITY, f32::min).max(0.0)
}

/// The place above or below `point` at 45 % of the room's height there.
fn eye_over(tracer: &Tracer, point: Vec3) -> Vec3 {
    let floor = point.y - reach(tracer, point, -Vec3::Y).unwrap_or(0.0);
    let ceiling = point.y + reach(tracer, point, Vec3::Y).unwrap_or(0.0);
    Vec3::new(point.x, floor + 0.45 * (ceiling - floor), point.z)
}

/// Points of a coarse grid inside the box.
fn grid(bounds: &Bounds) -> Vec<Vec3> {
    const N: usize = 6;
    let at = |i: usize| (i as f32 + 0.5) / N as f32;
    let size = bounds.max - bounds.min;
    (0..N * N * N)
        .map(|i| bounds.min + size * Vec3::new(at(i % N), at(i / N % N), at(i / N / N)))
        .collect()
}

/// The median length of evenly spread rays from a point, if nearly all meet the front of a face.
fn median_length(tracer: &Tracer, origin: Vec3) -> Option<f32> {
    let mut lengths = Vec::with_capacity(RAYS);
    for direction in sphere(RAYS) {
        let ray = Ray { origin, direction, t_max: f32::INFINITY };
        if let Some(hit) = tracer.hit(&ray, Sides::Both)
            && tracer.meets_front(&hit, direction)
        {
            lengths.push(hit.t);
        }
    }
    if lengths.len() * 100 < RAYS * 95 {
        return None;
    }
    let middle = lengths.len() / 2;
    Some(*lengths.select_nth_unstable_by(middle, f32::total_cmp).1)
}

/// Evenly spread directions: a spherical Fibonacci lattice.
pub(super) fn sphere(count: usize) -> impl Iterator<Item = Vec3> {
    (0..count).map(move |i| {
        let z = 1.0 - (2 * i + 1) as f32 / count as f32;
        let r = (1.0 - z * z).sqrt();
        let angle = i as f32 * 2.399_963_2;
        Vec3::new(r * angle.cos(), z, r * angle.sin())
    })
}
