//! [`Field`]: what is far from a cluster of pixels, as a cube buffer that all of them use.
//!
//! The cut at the cluster's centre holds only what lies beyond the radius D around it: an exact
//! partition, since near rays end at the same sphere. A pixel sees each texel from where it stands:
//! as a flat piece of surface at its mean distance, slanted as what is there.

mod opening;

use crate::bright::{self, Bright};
use crate::cluster::Pixel;
use crate::cube::{CubeBuffer, CubeShape};
use crate::cut::{Chooser, Splat};
use crate::hierarchy::Hierarchy;
use crate::indirect::Prepared;
use crate::pack::{LANES, LEAST_COSINE, Lanes, Pack, slant};
use crate::veil::Veil;
use chiaro_basis::math::Vec3;
use chiaro_scene::Bounds;
use chiaro_trace::{GBuffer, Tracer, Vertex};

/// Light and openness: linear RGB, and 1 where nothing is.
pub(crate) type Light = [f32; 4];

/// The ball around a cluster in which rays look.
#[derive(Clone, Copy, Debug, PartialEq)]
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

    /// Whether a place is inside.
    pub(crate) fn holds(&self, place: Vec3) -> bool {
        place.distance_squared(self.centre) <= self.radius * self.radius
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

/// What is nearer than the ball's radius is marked from this share of it on.
const MARK: f32 = 0.5;
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
    /// What is bright; the packs are without it.
    bright: Bright,
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
    /// Gathers what lies beyond a ball, as far as some receivers see it; also the number of nodes visited.
    pub(crate) fn gather<T: Hierarchy>(
        scene: &Prepared<T>,
        ball: Ball,
        how: &Gathering,
        receivers: &[Vertex],
        (buffer, splats): (&mut CubeBuffer, &mut Vec<Splat>),
    ) -> (Self, u64) {
        let near = if scene.knobs.near_field { ball.radius } else { 0.0 };
        let chooser = Chooser {
            from: ball.centre,
            threshold: how.threshold,
            near,
            mark: MARK * near,
            above: None,
            flat: scene.knobs.flat_nodes,
        };
        buffer.clear();
        splats.clear();
        let visited = scene.tree.cut(&chooser, splats);
        let groups = match receivers.is_empty() {
            true => Vec::new(),
            false => bright::take(&scene.tree, ball.centre, buffer.shape(), splats),
        };
        buffer.add_sorted(splats);
        Veil { ball, tracer: scene.lit.tracer, receivers }.draw(buffer);
        let mut field = Self::of_buffer(buffer, ball, how);
        let told = groups.into_iter().map(|g| {
            let arrives = g.arrives(scene.lit.tracer, receivers);
            (g, arrives)
        });
        field.bright = Bright::of(&told.collect::<Vec<_>>(), field.scale);
        (field, visited)
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
            let towards = buffer.towards(i);
            let place = towards * distance;
            let slant = slant(towards, texel.mean_axis()) * (distance * distance);
            (0..3).for_each(|c| pack.place[c][lane] = place[c]);
            (0..3).for_each(|c| pack.slant[c][lane] = slant[c]);
            for (c, value) in [r, g, b, open].into_iter().enumerate() {
                pack.light[c][lane] = value * shape.solid_angles[i];
            }
        }
        let sends = |p: &Pack| p.light.iter().flatten().any(|l| *l > 0.0);
        let lit = (0..packs.len()).filter(|&i| sends(&packs[i])).map(|i| i as u16).collect();
        Self { ball, side: shape.side(), scale, packs, lit, bright: Bright::default() }
    }

    /// Irradiance of a receiver by the far field; the last is pi where all is open. What a texel
    /// shows is taken for a flat piece at its distance d with the normal n: at v from the receiver,
    /// seen in the direction w from the centre, it has the solid angle of the texel times
    /// (d / |v|)^2 (n.v / |v|) / (n.w).
    #[allow(clippy::needless_range_loop, reason = "lanes are vectors of the processor")]
    pub(crate) fn irradiance(&self, at: &Vertex) -> Light {
        let receiver = self.receiver(at);
        let mut sum = [[0.0f32; LANES]; 4];
        for &index in &self.lit {
            let t = &self.packs[index as usize];
            for k in 0..LANES {
                let (_, weight) = t.seen(k, &receiver);
                (0..4).for_each(|c| sum[c][k] += weight * t.light[c][k]);
            }
        }
        sum.map(|lanes| lanes.iter().sum())
    }

    /// Irradiance of a receiver by what is bright, told by a share of the rays, and what it would be if nothing hid that.
    pub(crate) fn by_bright(&self, at: &Vertex, tracer: &Tracer, share: f32) -> [f32; 6] {
        self.bright.irradiance(&self.receiver(at), (at, tracer), share)
    }

    /// What that would be if nothing hid it.
    pub(crate) fn open_to_bright(&self, at: &Vertex) -> [f32; 3] {
        self.bright.open(&self.receiver(at))
    }

    /// Whether there is any such thing.
    pub(crate) fn has_bright(&self) -> bool {
        !self.bright.is_empty()
    }

    /// Where a receiver lies in the field, in the field's scale, its normal and its side.
    fn receiver(&self, at: &Vertex) -> [Vec3; 3] {
        [self.scale * (at.position - self.ball.centre), at.normal, at.side]
    }

    /// Far light along a ray: of the texel whose sphere it meets in that texel. The search begins where the ray
    /// leaves the ball.
    pub(crate) fn light(&self, shape: &CubeShape, origin: Vec3, direction: Vec3) -> Light {
        debug_assert_eq!(shape.side(), self.side);
        let from = self.scale * (origin - self.ball.centre);
        let along = from.dot(direction);
        let inside = along * along - from.length_squared();
        let met = |distance: f32| (inside + distance * distance).max(0.0).sqrt() - along;
        let first = shape.texel(from + direction * met(1.0));
        let pack = &self.packs[first / LANES];
        let lane = first % LANES;
        let (place, slant) = (pack.place.map(|l| l[lane]), pack.slant.map(|l| l[lane]));
        let (place, slant) = (Vec3::from(place), Vec3::from(slant));
        let length = if slant.dot(direction) > LEAST_COSINE * slant.length() {
            slant.dot(place - from) / slant.dot(direction)
        } else {
            met(place.length().max(1.0))
        };
        let texel = shape.texel(from + direction * length.max(0.0));
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

    /// A white receiver.
    fn receiver(position: Vec3, normal: Vec3) -> Vertex {
        Vertex {
            position,
            lifted: position,
            side: normal,
            smooth: normal,
            normal,
            albedo: [1.0; 3],
            emission: [0.0; 3],
            offset: 0.0,
        }
    }

    /// A field whose surroundings are white at distance `d`, seen by a receiver at `offset`.
    fn in_a_ball(d: f32, offset: Vec3, normal: Vec3) -> Light {
        let shape = CubeShape::new(12);
        let mut buffer = CubeBuffer::new(shape.clone());
        for i in 0..shape.directions.len() {
            buffer.fill(i, [1.0, 2.0, 3.0], d, (1.0, [0.0; 2]));
        }
        let ball = Ball { centre: Vec3::new(5.0, 6.0, 7.0), radius: 1.0 };
        let how = Gathering { threshold: 0.1, occlusion: 1e3, beyond: 1e3 };
        Field::of_buffer(&buffer, ball, &how).irradiance(&receiver(ball.centre + offset, normal))
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

    /// A wall fills a half-space's directions: a receiver that stands upright on it sees it in half of
    /// its hemisphere, wherever it stands.
    #[test]
    fn a_receiver_off_the_centre_sees_a_slanted_wall_as_it_is() {
        let shape = CubeShape::new(16);
        let mut buffer = CubeBuffer::new(shape.clone());
        for (i, d) in shape.directions.iter().enumerate().filter(|(_, d)| d.x > 0.02) {
            buffer.fill_flat(i, [1.0; 3], 1.2 / d.x, Vec3::NEG_X);
        }
        let ball = Ball { centre: Vec3::ZERO, radius: 1.0 };
        let how = Gathering { threshold: 0.1, occlusion: 1e3, beyond: 1e3 };
        let field = Field::of_buffer(&buffer, ball, &how);
        let seen = |x: f32, normal: Vec3| {
            field.irradiance(&receiver(Vec3::new(x, 0.0, 0.0), normal))[0] / std::f32::consts::PI
        };
        for x in [-0.5, 0.0, 0.5] {
            assert!((seen(x, Vec3::X) - 1.0).abs() < 0.05, "{x} {}", seen(x, Vec3::X));
            assert!((seen(x, Vec3::Y) - 0.5).abs() < 0.05, "{x} {}", seen(x, Vec3::Y));
        }
        // Rays meet the wall where it is.
        let (origin, direction) = (Vec3::new(0.4, 0.3, 0.0), Vec3::new(0.6, 0.8, 0.0));
        assert!((field.light(&shape, origin, direction)[0] - 1.0).abs() < 1e-5);
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
