//! [`Seer`]: the light that leaves what a reflected ray met.

use crate::cluster::Pixel;
use crate::hierarchy::Hierarchy;
use crate::indirect::Prepared;
use crate::near;
use crate::surfel::Surfel;
use chiaro_basis::math::Vec3;
use chiaro_trace::{Hit, Lamp, Sequence, Vertex, lamp_irradiance};

/// Small lamps in the place of what shines and of the sky, for mirrors: the same for all pixels, so that there is no
/// noise.
const GLOW_LAMPS: usize = 24;
const SKY_LAMPS: u32 = 48;
/// Lobes narrower than this see by those lamps, wider ones by one shadow ray for each of theirs.
const MIRROR: f32 = 0.03;
/// A cone over the distance between surfels below which none of their light is used, and above which all is.
const NARROW: f32 = 0.5;
const WIDE: f32 = 1.5;
/// How much brighter than its surfel a texture may be.
const MOST_CONTRAST: f32 = 4.0;

/// Sees what reflected rays meet.
pub(super) struct Seer<'a, 'b, T: Hierarchy> {
    scene: &'a Prepared<'b, T>,
    lamps: Vec<Lamp>,
}

/// The same for one pixel; what was lit for one ray serves the others nearby.
pub(super) struct Looking<'s, 'a, 'b, T: Hierarchy> {
    seer: &'s Seer<'a, 'b, T>,
    sequence: Sequence,
    is_mirror: bool,
    /// Place, side and irradiance of what was lit last.
    last: Option<(Vec3, Vec3, [f32; 3])>,
}

/// What a ray met.
struct Met<'h> {
    hit: &'h Hit,
    at: Vertex,
    /// How wide the ray's cone is there, scene units.
    footprint: f32,
    /// Where the ray went, and its number among those of its pixel.
    direction: Vec3,
    index: u32,
}

impl<'a, 'b, T: Hierarchy> Seer<'a, 'b, T> {
    pub(super) fn new(scene: &'a Prepared<'b, T>) -> Self {
        let lights = scene.lit.lights;
        let mut lamps = lights.lamps.clone();
        lamps.extend(lights.glow.lamps(GLOW_LAMPS));
        if let Some(sky) = &lights.sky {
            let sequence = Sequence::new(0);
            let samples = (0..SKY_LAMPS).filter_map(|i| sky.sample(sequence.point(i, 0)));
            lamps.extend(samples.map(|s| Lamp::of_sky(&s, SKY_LAMPS as f32)));
        }
        Self { scene, lamps }
    }

    pub(super) fn looking(&self, (x, y): Pixel, alpha: f32) -> Looking<'_, 'a, 'b, T> {
        let sequence = Sequence::new((y << 32 | x) as u64);
        Looking { seer: self, sequence, is_mirror: alpha < MIRROR, last: None }
    }
}

impl<T: Hierarchy> Looking<'_, '_, '_, T> {
    /// Where a ray met something, the light that is reflected there, and what shines. The ray stands
    /// for a cone of so many steradians.
    pub(super) fn met(
        &mut self,
        hit: &Hit,
        direction: Vec3,
        cone: f32,
        index: u32,
    ) -> (Vec3, [f32; 3], [f32; 3]) {
        let scene = self.seer.scene;
        let footprint = cone.sqrt().min(1.0) * hit.t;
        let lit = &scene.lit;
        let at = Vertex::of(lit.tracer, lit.surfaces, hit, direction, footprint);
        let dark = scene.knobs.bounces == 0 || at.albedo == [0.0; 3];
        let light = match dark {
            true => [0.0; 3],
            false => self.reflected(&Met { hit, at, footprint, direction, index }),
        };
        (at.position, light, at.emission)
    }

    /// The light that is reflected there.
    fn reflected(&mut self, met: &Met) -> [f32; 3] {
        let (scene, at) = (self.seer.scene, &met.at);
        let grid = &scene.reflected.grid;
        let nearest = grid.nearest(&scene.surfels, at.position, at.side);
        let surfel = nearest.map(|(k, side)| (&scene.surfels.all[k as usize], side));
        let share = surfel.map_or(0.0, |(s, _)| {
            ((met.footprint / s.area.sqrt() - NARROW) / (WIDE - NARROW)).clamp(0.0, 1.0)
        });
        let stored = surfel.map_or([0.0; 3], |(s, side)| textured(s, side, at));
        if share >= 1.0 {
            return stored;
        }
        let mut e = self.irradiance(met);
        if let (Some((k, side)), false) = (nearest, scene.reflected.irradiance.is_empty()) {
            let more = scene.reflected.irradiance[k as usize][side];
            (0..3).for_each(|c| e[c] += more[c]);
        }
        let own = near::radiance(at, e);
        std::array::from_fn(|c| own[c] + (stored[c] - own[c]) * share)
    }

    /// Direct irradiance there.
    fn irradiance(&mut self, met: &Met) -> [f32; 3] {
        let (lit, at) = (&self.seer.scene.lit, &met.at);
        if !self.is_mirror {
            return near::lit(lit, met.hit, met.direction, &self.sequence, met.index).1;
        }
        if let Some((place, side, e)) = self.last
            && place.distance(at.position) < met.footprint
            && side.dot(at.side) > 0.98
        {
            return e;
        }
        let e = lamp_irradiance((lit.tracer, &lit.lights.glow), at, &self.seer.lamps);
        self.last = Some((at.position, at.side, e));
        e
    }
}

/// The radiance of a surfel's side with the colour of a point beside it.
fn textured(surfel: &Surfel, side: usize, at: &Vertex) -> [f32; 3] {
    std::array::from_fn(|c| {
        let ratio = at.albedo[c] / surfel.albedo[c].max(1e-3);
        surfel.radiance[side][c] * ratio.min(MOST_CONTRAST)
    })
}
