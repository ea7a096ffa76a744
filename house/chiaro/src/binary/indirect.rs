//! Indirect light and its occlusion as appearance channels: the points of chapter 6 light the
//! pictures of chapter 3.
//!
//! Surfels lie where the shot's first frame has its surfaces and are lit by the lamps of the diffuse
//! channel. Illuminance by reflected light becomes E / (E + median E), the median being that of the
//! first frame that is surveyed, so that a film does not flicker as its own light varies; the openness
//! of the same gathers takes the place of the occlusion that is sampled by rays.

use chiaro_basis::{Result, Run};
use chiaro_binary::{BinaryKnobs, Channel, Channels, Lit};
use chiaro_image::Plane;
use chiaro_image::colour::luminance;
use chiaro_pbgi::{LightKnobs, Site, indirect, prepare, sites};
use chiaro_scene::{Frame, Scene};
use chiaro_trace::Lights;
use std::sync::OnceLock;

/// Times that light is reflected.
const BOUNCES: u32 = 2;

/// What the frames of a shot share to be lit by each other's surfaces.
pub(super) struct Reflections {
    knobs: LightKnobs,
    sites: Vec<Site>,
    /// What becomes a half: the first frame's median.
    middle: OnceLock<f32>,
}

impl Reflections {
    /// Places surfels on a frame.
    pub(super) fn of(scene: &Scene, frame: &Frame, knobs: &BinaryKnobs) -> Self {
        let knobs = LightKnobs {
            bounces: BOUNCES,
            occlusion: knobs.occlusion_radius,
            ..LightKnobs::default()
        };
        let sites = sites(scene, frame, knobs.surfels as usize);
        Self { knobs, sites, middle: OnceLock::new() }
    }

    /// Puts indirect light, and occlusion if wanted, into the channels of a frame.
    pub(super) fn put(
        &self,
        lit: &Lit<'_>,
        channels: &mut Channels,
        occlusion: bool,
        run: &Run,
    ) -> Result<()> {
        let (lamps, glow) = (lit.lamps.single().to_vec(), lit.lamps.glow().clone());
        let lights = Lights { lamps, glow, sky: None };
        let points =
            chiaro_pbgi::Lit { tracer: lit.tracer, surfaces: lit.surfaces, lights: &lights };
        let frame = lit.tracer.frame;
        let own = frame.shapes.iter().any(|s| s.remade.is_some());
        let anew = own.then(|| sites(lit.tracer.scene, frame, self.knobs.surfels as usize));
        let scene = prepare(points, anew.as_ref().unwrap_or(&self.sites), &self.knobs, run)?;
        let found = indirect(&scene, lit.buffer, run)?;
        let tone = toned(&found.irradiance, &lit.buffer.covered, &self.middle);
        channels.set(Channel::Indirect, tone);
        if occlusion {
            let open = lit.buffer.over_covered(|x, y| found.openness[(x, y)]);
            channels.set(Channel::Occlusion, open);
        }
        Ok(())
    }
}

/// Illuminances E as E / (E + median E), so that any wattage ends in [0, 1]. The first picture with any
/// light sets the median.
fn toned(
    irradiance: &Plane<[f32; 3]>,
    covered: &Plane<bool>,
    middle: &OnceLock<f32>,
) -> Plane<f32> {
    let all = irradiance.map(|e| luminance(*e).max(0.0));
    if middle.get().is_none() {
        let lit = all.pixels().iter().zip(covered.pixels()).filter(|(e, c)| **c && **e > 0.0);
        let mut values: Vec<f32> = lit.map(|(e, _)| *e).collect();
        if values.is_empty() {
            return all;
        }
        let half = values.len() / 2;
        let _ = middle.set(*values.select_nth_unstable_by(half, f32::total_cmp).1);
    }
    let middle = middle.get().copied().unwrap_or(1.0);
    all.map(|e| e / (e + middle))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_what_is_lit_is_over_a_half_at_any_wattage() {
        for scale in [1e-6f32, 1.0, 1e6] {
            let e = Plane::from_fn(9, 1, |x, _| [scale * x as f32; 3]);
            let tone = toned(&e, &Plane::filled(9, 1, true), &OnceLock::new());
            assert_eq!(tone[(0, 0)], 0.0);
            assert!((tone[(5, 0)] - 0.5).abs() < 1e-6, "{}", tone[(5, 0)]);
            assert!(tone[(8, 0)] > 0.6 && tone[(8, 0)] < 1.0);
        }
        let black =
            toned(&Plane::filled(2, 2, [0.0; 3]), &Plane::filled(2, 2, true), &OnceLock::new());
        assert!(black.pixels().iter().all(|v| *v == 0.0));
    }

    #[test]
    fn a_shot_has_one_scale() {
        let (middle, covered) = (OnceLock::new(), Plane::filled(2, 1, true));
        toned(&Plane::filled(2, 1, [0.0; 3]), &covered, &middle);
        assert!(middle.get().is_none(), "darkness sets no scale");
        toned(&Plane::filled(2, 1, [2.0; 3]), &covered, &middle);
        let dim = toned(&Plane::filled(2, 1, [1.0; 3]), &covered, &middle);
        assert!((dim[(0, 0)] - 1.0 / 3.0).abs() < 1e-6, "half the light is darker");
    }
}
