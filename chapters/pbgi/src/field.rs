//! [`Field`]: what is far from a cluster of pixels, as a cube buffer that all of them use.
//!
//! The cut at the cluster's centre holds only what lies beyond the radius D around it: an exact
//! partition, since near rays end at the same sphere. A pixel sees each texel from where it stands,
//! towards where the texel's surface is at its mean distance.

use crate::cluster::Pixel;
use crate::cube::{CubeBuffer, CubeShape};
use crate::cut::{Chooser, Splat};
use crate::hierarchy::Hierarchy;
use crate::indirect::Prepared;
use chiaro_basis::math::Vec3;
use chiaro_scene::Bounds;
use chiaro_trace::{GBuffer, Vertex};

/// Light and openness: linear RGB, and 1 where nothing is.
pub(crate) type Light = [f32; 4];

/// The ball around a cluster in which rays look.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    pub(crate) centre: Vec3,
    /// D.
    pub(crate) radius: f32,
}

impl Ball {
    /// The ball of a cluster: `reach` times as large as the cluster, and not smaller than `least`.
    pub(crate) fn around(buffer: &GBuffer, pixels: &[Pixel], reach: f32, least: f32) -> Self {
        let place = |p: &Pixel| Vec3::from(buffer.position[*p]);
        let centre = Bounds::of(pixels.iter().map(place)).centre();
        let radius = pixels.iter().map(|p| place(p).distance(centre)).fold(0.0, f32::max);
        Self { centre, radius: least.max(reach * radius) }
    }

    /// How far a ray goes inside the ball; nothing when it starts outside.
    pub(crate) fn exit(&self, origin: Vec3, direction: Vec3) -> f32 {
        let offset = origin - self.centre;
        let inside = self.radius * self.radius - offset.length_squared();
        if inside <= 0.0 {
            return 0.0;
        }
        let along = offset.dot(direction);
        (along * along + inside).sqrt() - along
    }
}

/// Texels side by side, so that the compiler can use vectors.
const LANES: usize = 8;
type Lanes = [f32; LANES];

/// A few texels: their places relative to the centre, their distances, both in radii of the ball,
/// and light times solid angle.
#[derive(Clone, Copy, Default)]
struct Pack {
    place: [Lanes; 3],
    distance: Lanes,
    light: [Lanes; 4],
}

/// The least distance of a texel, in radii of the ball.
const LEAST: f32 = 1e-3;

/// What lies beyond the ball of a cluster.
pub(crate) struct Field {
    pub(crate) ball: Ball,
    side: usize,
    /// Radii of the ball in a scene unit.
    scale: f32,
    packs: Vec<Pack>,
    /// The packs that hold light or openness.
    lit: Vec<u16>,
}

/// How a field is gathered.
#[derive(Clone, Copy)]
pub(crate) struct Gathering {
    /// Nodes larger than this are opened, steradians.
    pub(crate) threshold: f32,
    /// What is farther does not occlude, scene units.
    pub(crate) occlusion: f32,
    /// The distance of what is open, scene units.
    pub(crate) beyond: f32,
}

impl Field {
    /// Gathers what lies beyond a ball; also the number of nodes visited.
    pub(crate) fn gather<T: Hierarchy>(
        scene: &Prepared<T>,
        ball: Ball,
        how: &Gathering,
        buffer: &mut CubeBuffer,
        splats: &mut Vec<Splat>,
    ) -> (Self, u64) {
        let chooser = Chooser {
            from: ball.centre,
            threshold: how.threshold,
            near: if scene.knobs.near_field { ball.radius } else { 0.0 },
            above: None,
            flat: scene.knobs.flat_nodes,
        };
        buffer.clear();
        splats.clear();
        let visited = scene.tree.cut(&chooser, splats);
        buffer.add_sorted(splats);
        (Self::of_buffer(buffer, ball, how), visited)
    }

    fn of_buffer(buffer: &CubeBuffer, ball: Ball, how: &Gathering) -> Self {
        let shape = buffer.shape();
        let scale = if ball.radius > 0.0 { 1.0 / ball.radius } else { 100.0 / how.beyond };
        let mut packs = vec![Pack::default(); shape.directions.len().div_ceil(LANES)];
        for (i, texel) in buffer.texels().iter().enumerate() {
            let (pack, lane) = (&mut packs[i / LANES], i % LANES);
            let open =
                if texel.mean_distance() < how.occlusion { 1.0 - buffer.coverage(i) } else { 1.0 };
            let distance = (texel.mean_distance().min(how.beyond) * scale).max(LEAST);
            let [r, g, b] = buffer.radiance(i);
            pack.distance[lane] = distance;
            let place = shape.directions[i] * distance;
            (0..3).for_each(|c| pack.place[c][lane] = place[c]);
            for (c, value) in [r, g, b, open].into_iter().enumerate() {
                pack.light[c][lane] = value * shape.solid_angles[i];
            }
        }
        let sends = |p: &Pack| p.light.iter().flatten().any(|l| *l > 0.0);
        let lit = (0..packs.len()).filter(|&i| sends(&packs[i])).map(|i| i as u16).collect();
        Self { ball, side: shape.side(), scale, packs, lit }
    }

    /// Irradiance of a receiver by the far field; the last is pi where all is open. What a texel
    /// shows is taken for a piece of the sphere of its distance d: at v from the receiver, seen in
    /// the direction w from the centre, it has the solid angle of the texel times
    /// (d / |v|)^2 (w.v / |v|), so that all texels together still fill the sphere.
    #[allow(clippy::needless_range_loop, reason = "lanes are vectors of the processor")]
    pub(crate) fn irradiance(&self, at: &Vertex) -> Light {
        let (p, n, s) = (self.scale * (at.position - self.ball.centre), at.normal, at.side);
        let mut sum = [[0.0f32; LANES]; 4];
        for &index in &self.lit {
            let t = &self.packs[index as usize];
            for k in 0..LANES {
                let [px, py, pz] = [t.place[0][k], t.place[1][k], t.place[2][k]];
                let (x, y, z) = (px - p.x, py - p.y, pz - p.z);
                let above = x * s.x + y * s.y + z * s.z > 0.0;
                let cosine = (x * n.x + y * n.y + z * n.z).max(0.0);
                let cosine = if above { cosine } else { 0.0 };
                let facing = (x * px + y * py + z * pz).max(0.0) * t.distance[k];
                let square = x * x + y * y + z * z;
                let weight = cosine * facing / (square * square).max(f32::MIN_POSITIVE);
                (0..4).for_each(|c| sum[c][k] += weight * t.light[c][k]);
            }
        }
        sum.map(|lanes| lanes.iter().sum())
    }

    /// Far light along a ray: of the texel in which the ray, as long as things are far there, ends.
    pub(crate) fn light(&self, shape: &CubeShape, origin: Vec3, direction: Vec3) -> Light {
        debug_assert_eq!(shape.side(), self.side);
        let first = shape.texel(direction);
        let distance = self.packs[first / LANES].distance[first % LANES];
        let from = self.scale * (origin - self.ball.centre);
        let texel = shape.texel(from + direction * distance);
        let pack = &self.packs[texel / LANES];
        let scale = 1.0 / shape.solid_angles[texel];
        pack.light.map(|lanes| lanes[texel % LANES] * scale)
    }

    /// Texels along a side of its buffer.
    pub(crate) fn side(&self) -> usize {
        self.side
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A field whose surroundings are white at distance `d`, seen by a receiver at `offset`.
    fn in_a_ball(d: f32, offset: Vec3, normal: Vec3) -> Light {
        let shape = CubeShape::new(12);
        let mut buffer = CubeBuffer::new(shape.clone());
        for i in 0..shape.directions.len() {
            buffer.fill(i, [1.0, 2.0, 3.0], d, 1.0);
        }
        let ball = Ball { centre: Vec3::new(5.0, 6.0, 7.0), radius: 1.0 };
        let how = Gathering { threshold: 0.1, occlusion: 1e3, beyond: 1e3 };
        let at = Vertex {
            position: ball.centre + offset,
            lifted: ball.centre + offset,
            side: normal,
            smooth: normal,
            normal,
            albedo: [1.0; 3],
            emission: [0.0; 3],
            offset: 0.0,
        };
        Field::of_buffer(&buffer, ball, &how).irradiance(&at)
    }

    #[test]
    fn a_receiver_off_the_centre_of_white_surroundings_sees_white_everywhere() {
        let normal = Vec3::new(0.6, 0.0, 0.8);
        for (offset, tolerance) in [(0.0, 0.01), (0.3, 0.02), (0.6, 0.04)] {
            for axis in [Vec3::X, Vec3::Y, Vec3::NEG_Z] {
                let light = in_a_ball(1.1, axis * offset, normal);
                for c in 0..3 {
                    let exact = (c + 1) as f32 * std::f32::consts::PI;
                    assert!(
                        (light[c] / exact - 1.0).abs() < tolerance,
                        "{axis} {offset} {light:?}"
                    );
                }
                assert!(light[3].abs() < 1e-6);
            }
        }
    }

    #[test]
    fn rays_end_on_the_ball() {
        let ball = Ball { centre: Vec3::new(1.0, 2.0, 3.0), radius: 2.0 };
        let (origin, direction) = (Vec3::new(1.5, 2.0, 4.0), Vec3::new(0.6, 0.0, -0.8));
        let end = origin + direction * ball.exit(origin, direction);
        assert!((end.distance(ball.centre) - 2.0).abs() < 1e-5);
        assert_eq!(ball.exit(Vec3::splat(9.0), direction), 0.0);
    }
}
