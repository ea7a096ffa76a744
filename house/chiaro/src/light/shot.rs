//! What the frames of a lit shot share.

use super::baked::TreeFiles;
use super::kept::Kept;
use crate::camera::Camera;
use crate::disk;
use crate::project::Project;
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_image::codec::{self, Limits};
use chiaro_image::colour::luminance;
use chiaro_pbgi::{Focus, LightKnobs, OwnSky, Site, Spread, sites_by};
use chiaro_scene::{Frame, LightKind, Pose};
use chiaro_trace::path::{Aim, PathImage, PathTracer};
use chiaro_trace::{
    Glow, KEY_FROM, Lamp, Lights, Ray, Sides, Sky, Surfaces, Tracer, cosine_direction, daylight,
    sky_of_sun,
};
use std::path::Path;
use std::sync::Arc;

/// Frames on which the exposure is measured, at most; their height and paths a pixel.
const SURVEY_FRAMES: usize = 5;
const SURVEY_HEIGHT: usize = 64;
const SURVEY_SAMPLES: u32 = 16;
/// The display value that the geometric mean of what is seen gets.
const MIDDLE: f32 = 0.3;
/// What is seen is black when paths find light on fewer than one in so many pixels.
const UNLIT: usize = 100;
/// The display value that the brightest twentieth of what is seen keeps below.
const BRIGHT: f32 = 1.6;

/// What does not change over a shot.
pub(crate) struct Shot<'a> {
    pub(crate) project: &'a Project,
    pub(crate) camera: Camera,
    pub(crate) surfaces: Surfaces<'a>,
    /// Where surfels lie denser.
    pub(crate) focus: Focus,
    /// Surfels that are lit in full, and all of a coded tree.
    pub(crate) sites: Vec<Site>,
    pub(crate) spread: Spread,
    pub(crate) files: TreeFiles,
    /// Display values over radiance.
    pub(crate) exposure: f32,
    /// Whether paths found no light on what is seen: then there is none, and nothing is gathered.
    pub(crate) black: bool,
    source: Source,
    /// The points of the frame before.
    pub(crate) kept: Kept,
    /// The hash of the environment's file.
    pub(crate) env_hash: Option<String>,
}

/// Where light comes from.
enum Source {
    /// The scene alone, or with a sky.
    Scene(Option<Arc<Sky>>),
    /// One lamp and perhaps a sky, in the place of the scene's lamps.
    Instead(Lamp, Option<Arc<Sky>>),
}

impl<'a> Shot<'a> {
    /// Decides what a shot shares.
    pub(crate) fn survey(
        project: &'a Project,
        knobs: &LightKnobs,
        env: Option<&Path>,
        run: &Run,
    ) -> Result<Self> {
        let (sky, env_hash) = match env {
            Some(path) => {
                let bytes = run.stage("load", 1, || disk::read(path))?;
                (Some(environment(path, &bytes)?), Some(crate::write::sha256(&bytes)))
            }
            None => (None, None),
        };
        let poser = project.poser();
        let numbers = project.sampled_shot(SURVEY_FRAMES);
        let frames: Vec<Frame> = numbers.iter().map(|&n| project.pose(&poser, n, run)).collect();
        let camera = Camera::choose(project, &frames, run)?;
        let surfaces = Surfaces::new(&project.scene);
        let pose = camera.pose(&frames[0], numbers[0]);
        let (width, height) = camera.size;
        let poses = frames.iter().zip(&numbers).map(|(frame, &number)| camera.pose(frame, number));
        let focus = Focus::new(poses, width as f32 / height as f32);
        let sites = sites_by(knobs, &project.scene, &frames[0], &focus);
        let spread = match knobs.is_compact() {
            true => Spread::of(&project.scene, &frames[0], knobs.surfels.into()),
            false => Spread::default(),
        };
        let tracer = Tracer::new(&project.scene, &frames[0]);
        let clear_sky = knobs.sky == OwnSky::Auto;
        let source = Source::choose(project, sky, &tracer, &surfaces, &pose, clear_sky, run);
        drop(tracer);
        let mut shot = Self {
            project,
            camera,
            surfaces,
            focus,
            sites,
            spread,
            files: TreeFiles::default(),
            exposure: 1.0,
            black: false,
            source,
            kept: Kept::default(),
            env_hash,
        };
        shot.exposure = shot.expose(&numbers, &frames, knobs, run)?;
        Ok(shot)
    }

    /// The light of a frame.
    pub(crate) fn lights(&self, tracer: &Tracer) -> Lights {
        self.source.lights(tracer, &self.surfaces)
    }

    /// The exposure that puts the geometric mean of what is seen, over all surveyed frames, in the
    /// middle, unless its bright parts would burn out.
    fn expose(
        &mut self,
        numbers: &[u32],
        frames: &[Frame],
        knobs: &LightKnobs,
        run: &Run,
    ) -> Result<f32> {
        let small = self.camera.at_height(SURVEY_HEIGHT).size;
        let (mut seen, mut covered): (Vec<f32>, usize) = (Vec::new(), 0);
        for (&number, frame) in numbers.iter().zip(frames) {
            let tracer = Tracer::new(&self.project.scene, frame);
            let lights = self.lights(&tracer);
            let paths = PathTracer {
                tracer: &tracer,
                surfaces: &self.surfaces,
                lights: &lights,
                bounces: knobs.bounces,
                glossy: knobs.glossy,
            };
            let mut image = PathImage::new(small.0, small.1);
            let pose = self.camera.pose(frame, number);
            paths.add(&mut image, &pose, SURVEY_SAMPLES, Aim::Spread, run)?;
            let (direct, indirect, coverage) = (image.direct(), image.indirect(), image.coverage());
            let specular = image.specular();
            covered += coverage.pixels().iter().filter(|c| **c > 0.5).count();
            seen.extend(
                direct
                    .pixels()
                    .iter()
                    .zip(indirect.pixels())
                    .zip(specular.pixels())
                    .zip(coverage.pixels())
                    .filter(|(_, c)| **c > 0.5)
                    .map(|(((d, i), s), c)| (luminance(*d) + luminance(*i) + luminance(*s)) / c)
                    .filter(|l| *l > 0.0 && l.is_finite()),
            );
        }
        self.black = seen.len() <= covered / UNLIT;
        if self.black {
            run.warn("no light reaches what is seen: the picture is black; add a lamp or --env");
        }
        let exposure = if self.black { 1.0 } else { exposure(&mut seen) };
        Ok(exposure * knobs.exposure.exp2())
    }
}

/// Display values over radiance for these luminances.
fn exposure(seen: &mut [f32]) -> f32 {
    if seen.is_empty() {
        return 1.0;
    }
    seen.sort_by(f32::total_cmp);
    // What is nearly black says nothing of how bright the rest should be.
    let floor = 1e-3 * seen[seen.len() * 9 / 10];
    let lit: Vec<f64> = seen.iter().filter(|l| **l > floor).map(|l| f64::from(l.ln())).collect();
    let mean = (lit.iter().sum::<f64>() / lit.len().max(1) as f64).exp() as f32;
    let bright = seen[seen.len() * 19 / 20];
    (MIDDLE / mean).min(BRIGHT / bright)
}

/// The sky in a picture file.
fn environment(path: &Path, bytes: &[u8]) -> Result<Arc<Sky>> {
    let name = path.display().to_string();
    let picture = codec::read_colour(bytes, &name, &Limits::default())?;
    let sky = Sky::new(picture.map(|&[r, g, b, _]| [r, g, b]));
    if sky.is_black() {
        return Err(chiaro_basis::Error::input(
            name,
            "",
            "the picture is black; it gives no light",
        ));
    }
    Ok(Arc::new(sky))
}

impl Source {
    fn choose(
        project: &Project,
        sky: Option<Arc<Sky>>,
        tracer: &Tracer,
        surfaces: &Surfaces,
        pose: &Pose,
        clear_sky: bool,
        run: &Run,
    ) -> Self {
        if let Some([azimuth, elevation]) = project.options.sun {
            let (a, e) = (azimuth.to_radians(), elevation.to_radians());
            let towards = Vec3::new(e.cos() * a.sin(), e.sin(), e.cos() * a.cos());
            let (sun, clear) = daylight(towards);
            return Self::Instead(sun, Some(sky.unwrap_or_else(|| Arc::new(clear))));
        }
        let own = Self::Scene(None).lights(tracer, surfaces);
        if let (None, Some(sun)) = (&sky, lone_sun(&own))
            && clear_sky
            && !is_closed(tracer, pose)
        {
            run.warn("a sun alone: a clear sky beside it; --set sky=none leaves it out");
            return Self::Scene(Some(Arc::new(sky_of_sun(sun))));
        }
        if sky.is_some() || !own.is_empty() {
            return Self::Scene(sky);
        }
        if is_closed(tracer, pose) {
            run.warn("no light in the scene, and no sky to be seen: a lamp beside the eye");
            return Self::Instead(lamp_beside(tracer, pose), None);
        }
        run.warn("no light in the scene: a sun from above, on the left, and a clear sky");
        let [x, y, z] = KEY_FROM;
        let mut towards = pose.right * x + pose.up * y - pose.forward * z;
        towards.y = towards.y.max(0.4);
        let (sun, clear) = daylight(towards);
        Self::Instead(sun, Some(Arc::new(clear)))
    }

    fn lights(&self, tracer: &Tracer, surfaces: &Surfaces) -> Lights {
        match self {
            Self::Scene(sky) => Lights {
                lamps: Lamp::of_frame(tracer.frame),
                glow: Glow::of(tracer, surfaces),
                sky: sky.clone(),
            },
            Self::Instead(lamp, sky) => {
                Lights { lamps: vec![*lamp], glow: Glow::default(), sky: sky.clone() }
            }
        }
    }
}

/// The only light of a scene, if that is parallel.
fn lone_sun(lights: &Lights) -> Option<&Lamp> {
    match &lights.lamps[..] {
        [lamp] if lights.glow.is_empty() && lamp.kind == LightKind::Directional => Some(lamp),
        _ => None,
    }
}

/// Whether nearly all rays from the eye meet something.
fn is_closed(tracer: &Tracer, pose: &Pose) -> bool {
    const RAYS: u64 = 64;
    let meets = (0..RAYS).filter(|&i| {
        let point = chiaro_basis::random::r2(i);
        let up = if i % 2 == 0 { Vec3::Y } else { -Vec3::Y };
        let direction = cosine_direction(up, point);
        let ray = Ray { origin: pose.position, direction, t_max: f32::INFINITY };
        tracer.hit(&ray, Sides::Both).is_some()
    });
    meets.count() as u64 * 20 >= RAYS * 19
}

/// A lamp a little above and beside the eye, in front of what is there.
fn lamp_beside(tracer: &Tracer, pose: &Pose) -> Lamp {
    let aside = (pose.up - pose.right * 0.5).normalize();
    let ray = Ray { origin: pose.position, direction: aside, t_max: f32::INFINITY };
    let room = tracer.hit(&ray, Sides::Both).map_or(0.0, |h| h.t);
    Lamp {
        position: pose.position + aside * (0.3 * room),
        kind: LightKind::Point,
        ..Lamp::sun(-Vec3::Y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exposure_follows_the_light_over_many_orders() {
        let mean = ((1..100).map(|i| f64::from(i).ln()).sum::<f64>() / 99.0).exp() as f32;
        for scale in [1e-9f32, 1.0, 1e9] {
            let mut seen: Vec<f32> = (1..100).map(|i| scale * i as f32).collect();
            let e = exposure(&mut seen);
            assert!((e * scale * mean / MIDDLE - 1.0).abs() < 1e-3, "{e}");
            let mut glaring: Vec<f32> = [2.0, 2.0, 2.0, 1e3].map(|l| scale * l).to_vec();
            assert!((exposure(&mut glaring) * scale * 1e3 / BRIGHT - 1.0).abs() < 1e-3);
        }
        assert_eq!(exposure(&mut []), 1.0);
    }
}
