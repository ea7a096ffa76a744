//! [`Still`]: one frame of a scene, lit directly, to be gathered from any tree.

use super::check::displayed;
use super::shot::Shot;
use crate::project::{Options, Project};
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_image::{Plane, metric};
use chiaro_pbgi::curve::Cube;
use chiaro_pbgi::packed::{Record, sides};
use chiaro_pbgi::pixel::{Workspace, gather};
use chiaro_pbgi::resolve::{Irradiance, Seen, resolve};
use chiaro_pbgi::surfel::{Lit, Surfels};
use chiaro_pbgi::{Hierarchy, LightKnobs, Prepared, Spread, indirect, prepare, sites, stream};
use chiaro_scene::Frame;
use chiaro_trace::{Direct, GBuffer, Vertex, direct_irradiance};
use std::f32::consts::{PI, TAU};
use std::time::Instant;

/// A tree of any kind.
pub(crate) type AnyTree = Box<dyn Hierarchy>;

/// A frame with all but its tree.
pub(crate) struct Still<'a> {
    shot: &'a Shot<'a>,
    frame: &'a Frame,
    lit: Lit<'a>,
    buffer: &'a GBuffer,
    direct: Direct,
    knobs: LightKnobs,
}

/// How near two displayed pictures are.
pub(crate) struct Nearness {
    /// Decibels; `None` when they are equal.
    pub(crate) psnr: Option<f64>,
    /// The share of pixels that an eye tells apart (Yee 2004), and which.
    pub(crate) different: f64,
    pub(crate) map: Plane<bool>,
}

/// The first frame of a project, posed, lit and seen.
pub(crate) struct Set<'a> {
    pub(crate) shot: &'a Shot<'a>,
    pub(crate) frame: &'a Frame,
    pub(crate) lit: Lit<'a>,
    pub(crate) buffer: &'a GBuffer,
}

/// Sets up the first frame of a project, and works on it.
pub(crate) fn set<T>(
    project: &Project,
    knobs: &LightKnobs,
    run: &Run,
    work: impl FnOnce(&Set) -> Result<T>,
) -> Result<T> {
    let survey = LightKnobs { surfels: 16, ..knobs.clone() };
    let shot = Shot::survey(project, &survey, None, run)?;
    let number = project.frames()[0];
    let frame = project.pose(&project.poser(), number, run);
    let tracer = project.tracer(&frame);
    let pose = shot.camera.pose(&frame, number);
    let buffer = GBuffer::trace(&tracer, &shot.surfaces, &pose, shot.camera.size, run)?;
    let lights = shot.lights(&tracer);
    let lit = Lit { tracer: &tracer, surfaces: &shot.surfaces, lights: &lights };
    work(&Set { shot: &shot, frame: &frame, lit, buffer: &buffer })
}

/// Opens the first frame of a scene at a size, and works on it.
pub(crate) fn still<T>(
    scene: &str,
    size: (usize, usize),
    knobs: &LightKnobs,
    run: &Run,
    work: impl FnOnce(&Still) -> Result<T>,
) -> Result<T> {
    let options = Options { size: Some(size), ..Options::default() };
    let project = Project::open(scene, options, run)?;
    set(&project, knobs, run, |&Set { shot, frame, lit, buffer }| {
        let direct = direct_irradiance(lit.tracer, buffer, lit.lights, run)?;
        work(&Still { shot, frame, lit, buffer, direct, knobs: knobs.clone() })
    })
}

impl Still<'_> {
    /// So many surfels with their light; their tree is to be replaced.
    pub(crate) fn points(&self, count: usize, run: &Run) -> Result<Prepared<'_, AnyTree>> {
        let knobs = LightKnobs { surfels: count as u32, ..self.knobs.clone() };
        let sites = sites(&self.shot.project.scene, self.frame, count);
        let Prepared { lit, surfels, reflected, tree, knobs, shift } =
            prepare(self.lit, &sites, &knobs, run)?;
        Ok(Prepared { lit, surfels, reflected, tree: Box::new(tree), knobs, shift })
    }

    /// Seconds to light so many surfels, dead sides found.
    pub(crate) fn lighting(&self, count: usize, run: &Run) -> Result<f64> {
        let sites = sites(&self.shot.project.scene, self.frame, count);
        let start = Instant::now();
        Surfels::light(&self.lit, &sites, &self.knobs, run)?;
        Ok(start.elapsed().as_secs_f64())
    }

    /// Surfels with living sides along the curve.
    pub(crate) fn records(&self, points: &Prepared<AnyTree>) -> Vec<Record> {
        stream::sorted(&points.surfels.all, &self.cube(points.surfels.all.len()))
    }

    /// The cube along whose curve the records of so many surfels lie.
    pub(crate) fn cube(&self, count: usize) -> Cube {
        let spread = Spread::of(&self.shot.project.scene, self.frame, count.max(1) as u64);
        stream::cube(&self.lit, &spread)
    }

    /// The living sides of surfels along the curve: leaves of the thesis's tree.
    pub(crate) fn sides(&self, points: &Prepared<AnyTree>) -> Vec<Record> {
        sides(&self.records(points))
    }

    /// What is seen by the light of a tree.
    pub(crate) fn seen(&self, points: &Prepared<AnyTree>, run: &Run) -> Result<Plane<Seen>> {
        let found = indirect(points, self.buffer, run)?;
        let irradiance =
            Irradiance { direct: &self.direct, indirect: &found.irradiance, specular: None };
        resolve(&self.lit, self.buffer, &irradiance, self.knobs.edges, run)
    }

    /// The picture as displayed, sRGB-encoded; indirect light alone, or all.
    pub(crate) fn shown(&self, seen: &Plane<Seen>, alone: bool) -> Plane<[f32; 3]> {
        if !alone {
            return displayed(seen, self.shot.exposure, self.knobs.tone);
        }
        let indirect = seen.map(|s| Seen { direct: [0.0; 3], beyond: [0.0; 3], ..*s });
        displayed(&indirect, self.shot.exposure, self.knobs.tone)
    }

    /// All that the receiver at a pixel gathers, in latitude and longitude, by a buffer of `side` x `side` texels a face.
    pub(crate) fn received(
        &self,
        points: &mut Prepared<AnyTree>,
        pixel: (usize, usize),
        side: u32,
    ) -> Plane<[f32; 3]> {
        let usual = points.knobs.clone();
        points.knobs = LightKnobs { resolution: side, solid_angle: 1.0, ..usual.clone() };
        let at = Vertex::of_pixel(self.lit.tracer, self.buffer, pixel);
        let mut work = Workspace::new(side as usize);
        gather(points, &at, 1.0, &mut work, 0);
        points.knobs = usual;
        let buffer = work.buffer();
        let (width, height) = (2 * self.buffer.size().1, self.buffer.size().1);
        let seen = Plane::from_fn(width, height, |x, y| {
            let longitude = TAU * (x as f32 + 0.5) / width as f32;
            let (sin, cos) = (PI * (y as f32 + 0.5) / height as f32).sin_cos();
            let direction = Vec3::new(sin * longitude.sin(), cos, -sin * longitude.cos());
            let direct = buffer.radiance(buffer.shape().texel(direction));
            Seen { direct, ..Seen::default() }
        });
        displayed(&seen, self.shot.exposure, self.knobs.tone)
    }

    /// The surfel discs that are seen: each pixel in its surfel's colour, grey between discs.
    pub(crate) fn discs(&self, points: &Prepared<AnyTree>) -> Plane<[f32; 3]> {
        let (surfels, grid) = (&points.surfels, &points.reflected.grid);
        let (width, height) = self.buffer.size();
        let radiance = Plane::from_fn(width, height, |x, y| {
            let at = (x, y);
            if !self.buffer.covered[at] {
                return Seen::default();
            }
            let position = self.buffer.position[at].into();
            let found = grid.nearest(surfels, position, self.buffer.normal[at].into());
            let disc = found.map(|(k, side)| (&surfels.all[k as usize], side)).filter(|(s, _)| {
                // Seven tenths of a disc of the surfel's area, so that discs are told apart.
                let radius = 0.7 * (s.area / std::f32::consts::PI).sqrt();
                s.position.distance(position) < radius
            });
            let grey = [0.04 / self.shot.exposure; 3];
            Seen { direct: disc.map_or(grey, |(s, side)| s.radiance[side]), ..Seen::default() }
        });
        displayed(&radiance, self.shot.exposure, self.knobs.tone)
    }
}

/// How near a displayed picture is to another.
pub(crate) fn nearness(own: &Plane<[f32; 3]>, truth: &Plane<[f32; 3]>) -> Result<Nearness> {
    let map = metric::different_map(own, truth)?;
    let count = map.pixels().iter().filter(|d| **d).count();
    let different = count as f64 / map.len().max(1) as f64;
    Ok(Nearness { psnr: metric::psnr_db(own, truth)?, different, map })
}
