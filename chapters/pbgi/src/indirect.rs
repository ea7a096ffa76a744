//! From a lit frame to the irradiance of every pixel.

use crate::bounce::bounce;
use crate::cover;
use crate::cube::CubeShape;
use crate::estimate;
use crate::glossy;
use crate::grid::SurfelGrid;
use crate::hierarchy::Hierarchy;
use crate::knob::LightKnobs;
use crate::near::Reflected;
use crate::opening::{Dome, Opening, Openings};
use crate::pixel::{self, Gathered, Workspace};
use crate::records;
use crate::site::Site;
use crate::surfel::{Lit, Surfels};
use crate::tile;
use crate::tree::Tree;
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_trace::{GBuffer, Vertex};
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;

/// A frame's surfels and tree, ready to be gathered from.
pub struct Prepared<'a, T: Hierarchy = Tree> {
    /// The frame.
    pub lit: Lit<'a>,
    /// The surfels, in the order of their sites.
    pub surfels: Surfels,
    /// Light that surfels received from each other.
    pub reflected: Reflected,
    /// The tree over them.
    pub tree: T,
    /// The knobs.
    pub knobs: LightKnobs,
    /// Moves the pattern of near rays, to measure how much a picture depends on it; usually 0.
    pub shift: u32,
}

impl<'a, T: Hierarchy> Prepared<'a, T> {
    /// The same frame with another tree.
    pub fn with_tree<U: Hierarchy>(self, tree: U) -> (Prepared<'a, U>, T) {
        let Self { lit, surfels, reflected, tree: before, knobs, shift } = self;
        (Prepared { lit, surfels, reflected, tree, knobs, shift }, before)
    }
}

/// The points of a frame without the frame: what stays while nothing but the eye moves.
pub struct Points<T: Hierarchy = Tree> {
    surfels: Surfels,
    reflected: Reflected,
    tree: T,
}

/// How much larger a leaf may be than the surfel found: density changes from place to place.
const ALLOWANCE: f32 = 1.2;

impl<T: Hierarchy> Prepared<'_, T> {
    /// The radius of leaves around a point of a surface.
    pub(crate) fn leaf_radius(&self, point: Vec3, normal: Vec3) -> f32 {
        let mean = self.tree.leaf_radius();
        if !self.surfels.uneven || self.knobs.is_compact() {
            return mean;
        }
        match self.reflected.grid.nearest_of_any(&self.surfels, point, normal) {
            Some(k) => ALLOWANCE * (self.surfels.all[k as usize].area * FRAC_1_PI).sqrt(),
            None => 2.0 * mean,
        }
    }

    /// Lets go of the frame.
    pub fn into_points(self) -> Points<T> {
        Points { surfels: self.surfels, reflected: self.reflected, tree: self.tree }
    }
}

impl<T: Hierarchy> Points<T> {
    /// The points again, in a frame that has the same surfaces and the same light.
    pub fn again<'a>(self, lit: Lit<'a>, knobs: &LightKnobs) -> Prepared<'a, T> {
        let Self { surfels, reflected, tree } = self;
        Prepared { lit, surfels, reflected, tree, knobs: knobs.clone(), shift: 0 }
    }
}

/// Irradiance by reflected light, with counts.
#[derive(Clone, Debug, Default)]
pub struct Indirect {
    /// Linear RGB, at each covered pixel.
    pub irradiance: Plane<[f32; 3]>,
    /// The open share of the hemisphere, by cosine.
    pub openness: Plane<f32>,
    /// From where it is open, if that is wanted.
    pub openings: Option<Openings>,
    /// Radiance towards the eye by specular reflection of all light, if that is wanted.
    pub specular: Option<Plane<[f32; 3]>>,
    /// Cube buffers filled.
    pub gathers: u64,
    /// Nodes visited by all of them.
    pub visited: u64,
}

impl Indirect {
    /// No light, and nothing that occludes.
    pub(crate) fn none(width: usize, height: usize) -> Self {
        Self {
            irradiance: Plane::filled(width, height, [0.0; 3]),
            openness: Plane::filled(width, height, 1.0),
            openings: None,
            specular: None,
            gathers: 0,
            visited: 0,
        }
    }

    /// The same with room for what is wanted.
    pub(crate) fn wanting(wanted: Wanted, width: usize, height: usize) -> Self {
        let openings = wanted.openings.then(|| Openings::none(width, height));
        Self { openings, ..Self::none(width, height) }
    }
}

/// What is wanted of a gather beside irradiance and openness.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// From where pixels are open: [`Indirect::openings`]; records do not tell.
    pub openings: bool,
    /// What pixels reflect specularly: [`Indirect::specular`].
    pub specular: bool,
}

/// Lights the sites of a frame and builds the tree.
pub fn prepare<'a>(
    lit: Lit<'a>,
    sites: &[Site],
    knobs: &LightKnobs,
    run: &Run,
) -> Result<Prepared<'a>> {
    let by_records = knobs.is_by_records();
    // Rays meet sides as they are; dead ones need not be known but to spare bounces.
    let side_rays = if by_records && knobs.bounces < 2 { 0 } else { knobs.side_rays };
    let tested = LightKnobs { side_rays, ..knobs.clone() };
    let (mut surfels, sky) = Surfels::light_apart(&lit, sites, &tested, run)?;
    let count = surfels.all.len() as u64;
    let grid = SurfelGrid::new(&surfels);
    let sky = run.stage("direct", 0, || estimate::settled(&surfels, &grid, &sky));
    surfels.all.par_iter_mut().zip(&sky).for_each(|(s, e)| s.add(e));
    let times = knobs.bounces.saturating_sub(1);
    let irradiance = run.stage("direct", count, || {
        bounce(&lit, &mut surfels, &grid, times, knobs.bounce_rays, run)
    })?;
    let shown = run.stage("direct", 0, || cover::shown(&lit, &surfels, (&surfels, &grid)));
    cover::show(&mut surfels, &shown);
    let in_tree = if by_records && !knobs.is_compact() { &[] } else { &surfels.all[..] };
    let tree = run.stage("tree", in_tree.len() as u64, || Tree::build_by(knobs.hierarchy, in_tree));
    let irradiance = if times > 0 { irradiance } else { Vec::new() };
    let reflected = Reflected { grid, irradiance, sky };
    Ok(Prepared { lit, surfels, reflected, tree, knobs: knobs.clone(), shift: 0 })
}

/// Irradiance by reflected light at the covered pixels of a buffer; nothing with 0 bounces.
pub fn indirect<T: Hierarchy>(
    scene: &Prepared<T>,
    buffer: &GBuffer,
    run: &Run,
) -> Result<Indirect> {
    indirect_of(scene, buffer, Wanted::default(), run)
}

/// The same with more that is wanted; no openings with 0 bounces.
pub fn indirect_of<T: Hierarchy>(
    scene: &Prepared<T>,
    buffer: &GBuffer,
    wanted: Wanted,
    run: &Run,
) -> Result<Indirect> {
    let (width, height) = buffer.size();
    let pixels = (width * height) as u64;
    let specular = run.stage("gather", pixels, || {
        let wanted = wanted.specular && scene.knobs.glossy;
        wanted.then(|| glossy::specular(scene, buffer, run)).transpose()
    })?;
    let by_records = scene.knobs.is_by_records();
    if scene.knobs.bounces == 0 || (scene.tree.is_empty() && !by_records) {
        return Ok(Indirect { specular, ..Indirect::none(width, height) });
    }
    let found = run.stage("gather", pixels, || match scene.knobs.error_bound {
        _ if by_records => records::indirect(scene, buffer, run),
        bound if bound > 0.0 => tile::indirect(scene, buffer, wanted, run),
        _ => by_pixel(scene, buffer, wanted, run),
    })?;
    Ok(Indirect { specular, ..found })
}

/// Every pixel by itself.
fn by_pixel<T: Hierarchy>(
    scene: &Prepared<T>,
    buffer: &GBuffer,
    wanted: Wanted,
    run: &Run,
) -> Result<Indirect> {
    let (width, height) = buffer.size();
    let side = scene.knobs.resolution as usize;
    let occlusion = scene.knobs.occlusion * buffer.radius;
    let dome = wanted
        .openings
        .then(|| Dome::new(scene.lit.lights.sky.as_deref(), &[CubeShape::new(side)]));
    let gathered: Vec<Vec<Option<(Gathered, Opening)>>> = (0..height)
        .into_par_iter()
        .map_init(
            || Workspace::new(side),
            |work, y| {
                run.check()?;
                let pixel = |x| {
                    buffer.covered[(x, y)].then(|| {
                        let at = Vertex::of_pixel(scene.lit.tracer, buffer, (x, y));
                        let seed = (y * width + x) as u64;
                        let gathered = pixel::gather(scene, &at, occlusion, work, seed);
                        let open = |dome| pixel::opening(work, at.normal, at.side, occlusion, dome);
                        (gathered, dome.as_ref().map_or([0.0; 6], open))
                    })
                };
                Ok((0..width).map(pixel).collect())
            },
        )
        .collect::<Result<_>>()?;
    let mut found = Indirect::wanting(wanted, width, height);
    for (i, one) in gathered.into_iter().flatten().enumerate() {
        if let Some((one, opening)) = one {
            if let Some(openings) = &mut found.openings {
                openings.set((i % width, i / width), &opening);
            }
            found.irradiance.pixels_mut()[i] = one.irradiance;
            found.openness.pixels_mut()[i] = one.openness;
            found.gathers += 1;
            found.visited += one.visited;
        }
    }
    Ok(found)
}
