//! [`Focus`]: where surfels lie denser, because a shot's cameras see them.
//!
//! Surfels spread evenly by area leave few to what is seen of a wide scene: its leaves look large, and the
//! near field, whose rays are noise, must reach far. Here density follows the square of how large a piece looks from
//! the nearest camera, within bounds, and falls off beside the picture. All cameras of a shot count, and
//! sites are chosen once a shot, so that surfels do not change while a camera moves.
//!
//! Guaranteed: what no camera sees keeps at least 1 / 128 of the density of what is seen best at
//! close range. Triangles large for their distance are cut into pieces, so that density changes inside them.

use crate::site::{Site, areas};
use chiaro_basis::math::Vec3;
use chiaro_basis::random;
use chiaro_scene::{Frame, Pose, Projection, Scene};

/// The density of what is far beside the picture or behind the eye, over that of what is seen.
const UNSEEN: f32 = 0.125;
/// How fast density falls beside the picture, by half pictures.
const FALL: f32 = 2.0;
/// The density of what looks largest over the mean, and of what looks smallest under it.
const CLOSE: f32 = 4.0;
/// Triangles are cut in four until their edges are shorter than this share of the eye's distance, so
/// many times at most.
const EDGE: f32 = 0.5;
const CUTS: u32 = 5;

/// A camera at one time of the shot.
#[derive(Clone, Copy, Debug)]
struct Eye {
    pose: Pose,
    /// The picture's width over its height.
    aspect: f32,
}

/// The cameras of a shot; without any, density is even.
#[derive(Clone, Debug, Default)]
pub struct Focus {
    eyes: Vec<Eye>,
}

/// A piece of a triangle, with barycentric coordinates of its corners.
struct Part {
    object: u32,
    face: u32,
    corners: [[f32; 2]; 3],
    area: f64,
    triangle: f64,
    /// Where it is.
    middle: Vec3,
}

impl Eye {
    /// 1 inside the picture, less beside it, and the distance along the view.
    fn looks_at(&self, point: Vec3) -> (f32, f32) {
        let v = point - self.pose.position;
        let z = v.dot(self.pose.forward);
        let half = match self.pose.projection {
            Projection::Perspective { fov_y } => z * (0.5 * fov_y).tan(),
            Projection::Orthographic { half_height } => half_height,
        };
        if z <= 0.0 {
            return (UNSEEN, v.length());
        }
        let (x, y) = (v.dot(self.pose.right).abs(), v.dot(self.pose.up).abs());
        let beside = ((x / self.aspect).max(y) / half - 1.0).max(0.0);
        ((1.0 / (1.0 + (FALL * beside).powi(2))).max(UNSEEN), v.length())
    }

    /// How dense surfels should be at a point, where `mean` is the usual distance.
    fn density(&self, point: Vec3, mean: f32) -> f32 {
        let (inside, distance) = self.looks_at(point);
        let near = match self.pose.projection {
            Projection::Perspective { .. } => (mean / distance.max(1e-9)).powi(2),
            Projection::Orthographic { .. } => 1.0,
        };
        inside * near.clamp(1.0 / CLOSE, CLOSE)
    }
}

impl Focus {
    /// The cameras of a shot at some of its times, for pictures of an aspect (width over height).
    pub fn new(poses: impl IntoIterator<Item = Pose>, aspect: f32) -> Self {
        Self { eyes: poses.into_iter().map(|pose| Eye { pose, aspect }).collect() }
    }

    /// About `count` sites; `None` where density is even.
    pub(crate) fn sites(&self, scene: &Scene, frame: &Frame, count: usize) -> Option<Vec<Site>> {
        if self.eyes.is_empty() || count == 0 {
            return None;
        }
        let mean = self.mean_distance(scene, frame)?;
        let weight = |p: &Part| {
            let density = self.eyes.iter().map(|e| e.density(p.middle, mean)).fold(0.0, f32::max);
            f64::from(density)
        };
        let mut total = 0.0;
        self.parts(scene, frame, |p| total += p.area * weight(&p));
        let spacing = total / count as f64;
        if !(spacing > 0.0 && spacing.is_finite()) {
            return None;
        }
        let mut sites = Vec::with_capacity(count + 1);
        let mut before = 0.0;
        self.parts(scene, frame, |p| {
            let weight = weight(&p);
            let first = (before / spacing + 0.5).floor() as u64;
            before += p.area * weight;
            let end = ((before / spacing + 0.5).floor() as u64).min(count as u64);
            let share = (spacing / (weight * p.triangle)) as f32;
            sites.extend((first..end).map(|index| p.site(index, share)));
        });
        Some(sites)
    }

    /// The mean distance of what is seen from the nearest eye.
    fn mean_distance(&self, scene: &Scene, frame: &Frame) -> Option<f32> {
        let (mut sum, mut all) = (0.0, 0.0);
        self.parts(scene, frame, |p| {
            let seen = self.eyes.iter().map(|e| e.looks_at(p.middle));
            let (inside, distance) =
                seen.fold((0.0, f32::MAX), |a, b| if b.0 / b.1 > a.0 / a.1 { b } else { a });
            if inside >= 1.0 {
                // Near things count as much as far ones: by area as it looks.
                let looks = p.area / f64::from(distance * distance).max(1e-30);
                sum += looks * f64::from(distance);
                all += looks;
            }
        });
        let mean = (sum / all) as f32;
        (mean > 0.0 && mean.is_finite()).then_some(mean)
    }

    /// Calls `each` for all pieces of all triangles, in their order.
    fn parts(&self, scene: &Scene, frame: &Frame, mut each: impl FnMut(Part)) {
        for piece in areas(scene, frame) {
            let object = &frame.objects[piece.object as usize];
            let shape = &frame.shapes[object.shape];
            let triangle = shape.mesh_in(scene).triangles[piece.face as usize];
            let place = triangle
                .map(|v| object.world_from_shape.transform_point3(shape.positions[v as usize]));
            let whole = Part {
                object: piece.object,
                face: piece.face,
                corners: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
                area: piece.area,
                triangle: piece.triangle,
                middle: Vec3::ZERO,
            };
            // Of a point's disc one triangle stands for all.
            let cuts = if piece.area == piece.triangle { CUTS } else { 0 };
            self.cut(whole, place, cuts, &mut each);
        }
    }

    fn cut(&self, part: Part, place: [Vec3; 3], cuts: u32, each: &mut impl FnMut(Part)) {
        let [a, b, c] = place;
        let middle = (a + b + c) / 3.0;
        let edge = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let reach = self.eyes.iter().map(|e| e.pose.position.distance(middle));
        if cuts == 0 || edge <= EDGE * reach.fold(f32::MAX, f32::min) {
            return each(Part { middle, ..part });
        }
        let half = |p: [f32; 2], q: [f32; 2]| [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
        let [p, q, r] = part.corners;
        let (pq, qr, rp) = (half(p, q), half(q, r), half(r, p));
        let (ab, bc, ca) = (0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a));
        for (corners, place) in [
            ([p, pq, rp], [a, ab, ca]),
            ([pq, q, qr], [ab, b, bc]),
            ([rp, qr, r], [ca, bc, c]),
            ([qr, rp, pq], [bc, ca, ab]),
        ] {
            self.cut(Part { corners, area: 0.25 * part.area, ..part }, place, cuts - 1, each);
        }
    }
}

impl Part {
    /// Site `index` of all, at a point of a low-discrepancy sequence.
    fn site(&self, index: u64, share: f32) -> Site {
        let [u, v] = random::r2(index);
        let [s, t] = if u < v { [0.5 * u, v - 0.5 * u] } else { [u - 0.5 * v, 0.5 * v] };
        let [p, q, r] = self.corners;
        let b = std::array::from_fn(|k| p[k] + s * (q[k] - p[k]) + t * (r[k] - p[k]));
        Site { object: self.object, face: self.face, b, share }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::vec3;
    use chiaro_scene::{Poser, demo};

    #[test]
    fn what_is_seen_has_more_surfels_and_no_area_is_lost() {
        let scene = demo::scene("cornell-box").unwrap();
        let (playback, _) = scene.playback(&Default::default()).unwrap();
        let frame = Poser::new(&scene).frame(0.0, &playback);
        let bounds = frame.bounds();
        let eye = bounds.centre();
        let pose = Pose::look_at(
            eye,
            eye + vec3(0.0, 0.0, -1.0),
            Vec3::Y,
            Projection::Perspective { fov_y: 0.8 },
        );
        let found = Focus::new([pose], 1.0).sites(&scene, &frame, 20_000).unwrap();
        assert!((found.len() as i64 - 20_000).abs() <= 1);
        let triangle = |s: &Site| {
            areas(&scene, &frame)
                .find(|p| p.object == s.object && p.face == s.face)
                .map_or(0.0, |p| p.triangle)
        };
        let mut known = std::collections::HashMap::new();
        let mut sum = 0.0;
        for s in &found {
            let area = *known.entry((s.object, s.face)).or_insert_with(|| triangle(s));
            sum += area * f64::from(s.share);
        }
        let total: f64 = areas(&scene, &frame).map(|p| p.area).sum();
        assert!((sum / total - 1.0).abs() < 0.01, "{sum} {total}");
        let least = found.iter().map(|s| s.share).fold(f32::MAX, f32::min);
        assert!(found.iter().any(|s| s.share > 4.0 * least));
    }
}
