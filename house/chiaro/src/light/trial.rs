//! How near to the truth, for how much work: ways to light one frame, each against a path-traced
//! reference of one-bounce or longer irradiance at pixel centres.
//!
//! The reference is two independent halves A and B; the mean of (X - A)(X - B) is the square error
//! of a picture X without the reference's own noise, so that few paths suffice. Work is the
//! processor time of this process over all threads: primary rays and the hierarchy over triangles
//! are left out, everything else counts.

use super::still::{Set, set};
use crate::project::Project;
use chiaro_basis::{Error, Result, Run, random};
use chiaro_image::Plane;
use chiaro_pbgi::surfel::Lit;
use chiaro_pbgi::{LightKnobs, indirect, pooled_paths, prepare, sites_by};
use chiaro_trace::path::PathTracer;
use chiaro_trace::{GBuffer, Sequence, Vertex};
use std::f32::consts::PI;
use std::path::Path;
use std::time::Instant;

/// A way to light a frame.
#[derive(Clone, Debug)]
pub struct Way {
    /// What it is called.
    pub name: String,
    /// Its knobs.
    pub knobs: LightKnobs,
    /// Paths a pixel instead of points.
    pub paths: Option<u32>,
    /// Whether paths are pooled over neighbours as near rays are; one bounce.
    pub pooled: bool,
    /// Moves the pattern of near rays.
    pub shift: u32,
}

/// What came of a way.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Root of the mean square error of grey irradiance, over its mean.
    pub error: f64,
    /// Mean irradiance over the reference's, less 1.
    pub bias: f64,
    /// Processor seconds: of surfels with their light and tree, and of the gathers.
    pub seconds: [f64; 2],
    /// Cube buffers filled.
    pub gathers: u64,
    /// The irradiance itself.
    pub irradiance: Plane<[f32; 3]>,
}

/// The truth in two halves, and what it was measured on.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Irradiance by reflected light.
    pub halves: [Plane<[f32; 3]>; 2],
    /// Pixels that show geometry.
    pub covered: Plane<bool>,
}

/// Lights one frame of a project in all `ways`, with a reference of twice `paths` paths a pixel,
/// kept in the folder `kept` if there is one.
pub fn trial(
    project: &Project,
    ways: &[Way],
    paths: u32,
    kept: Option<&Path>,
    run: &Run,
) -> Result<(Truth, Vec<Outcome>)> {
    let Some(first) = ways.first() else {
        return Err(Error::setting("ways", "", "at least one"));
    };
    set(project, &first.knobs, run, |set| tried(project, set, ways, paths, kept, run))
}

fn tried(
    project: &Project,
    set: &Set,
    ways: &[Way],
    paths: u32,
    kept: Option<&Path>,
    run: &Run,
) -> Result<(Truth, Vec<Outcome>)> {
    let Set { frame, lit, buffer, .. } = set;
    let first = &ways[0];
    let reference = |half: u64| {
        let name = format!(
            "{}-{}-{}x{}-{paths}-{half}",
            &project.hash[..12],
            first.knobs.bounces,
            buffer.size().0,
            buffer.size().1
        );
        remembered(kept.map(|k| k.join(name)).as_deref(), buffer, || {
            by_paths(lit, buffer, first.knobs.bounces, paths, half, run)
        })
    };
    let truth = Truth { halves: [reference(1)?, reference(2)?], covered: buffer.covered.clone() };
    let outcomes = ways
        .iter()
        .map(|way| {
            let start = processor_seconds();
            let (irradiance, gathers, prepared) = match way.paths {
                Some(count) if way.pooled => {
                    let found = pooled_paths(lit, buffer, count, way.shift, run)?;
                    (found.irradiance, 0, start)
                }
                Some(count) => (by_paths(lit, buffer, way.knobs.bounces, count, 3, run)?, 0, start),
                None => {
                    let sites = sites_by(&way.knobs, &project.scene, frame, &set.shot.focus);
                    let mut scene = prepare(*lit, &sites, &way.knobs, run)?;
                    scene.shift = way.shift;
                    let prepared = processor_seconds();
                    let found = indirect(&scene, buffer, run)?;
                    (found.irradiance, found.gathers, prepared)
                }
            };
            let seconds = [prepared - start, processor_seconds() - prepared];
            let (error, bias) = truth.error(&irradiance);
            Ok(Outcome { error, bias, seconds, gathers, irradiance })
        })
        .collect::<Result<_>>()?;
    Ok((truth, outcomes))
}

impl Truth {
    /// The relative error of a picture, and that of its mean.
    pub fn error(&self, picture: &Plane<[f32; 3]>) -> (f64, f64) {
        let grey = |c: &[f32; 3]| f64::from((c[0] + c[1] + c[2]) / 3.0);
        let [a, b] = &self.halves;
        let (mut square, mut own, mut mean, mut count) = (0.0, 0.0, 0.0, 0.0);
        for (i, _) in self.covered.pixels().iter().enumerate().filter(|(_, c)| **c) {
            let (x, a, b) =
                (grey(&picture.pixels()[i]), grey(&a.pixels()[i]), grey(&b.pixels()[i]));
            square += (x - a) * (x - b);
            mean += 0.5 * (a + b);
            own += x;
            count += 1.0;
        }
        ((square / count).max(0.0).sqrt() / (mean / count), own / mean - 1.0)
    }

    /// The mean of the halves.
    pub fn mean(&self) -> Plane<[f32; 3]> {
        let [a, b] = &self.halves;
        let (width, height) = a.size();
        Plane::from_fn(width, height, |x, y| {
            std::array::from_fn(|c| 0.5 * (a[(x, y)][c] + b[(x, y)][c]))
        })
    }
}

/// Irradiance by reflected light, by plain paths.
fn by_paths(
    lit: &Lit,
    buffer: &GBuffer,
    bounces: u32,
    paths: u32,
    seed: u64,
    run: &Run,
) -> Result<Plane<[f32; 3]>> {
    let tracer = PathTracer {
        tracer: lit.tracer,
        surfaces: lit.surfaces,
        lights: lit.lights,
        bounces,
        glossy: false,
    };
    let (width, height) = buffer.size();
    let plane = Plane::from_fn(width, height, |x, y| {
        if run.check().is_err() || !buffer.covered[(x, y)] {
            return [0.0; 3];
        }
        let mut vertex = Vertex::of_pixel(lit.tracer, buffer, (x, y));
        vertex.albedo = [1.0; 3];
        let sequence = Sequence::new(random::hash(seed, (y * width + x) as u64));
        let mut sum = [0.0; 3];
        for index in 0..paths {
            let light = tracer.path(vertex, &sequence, index).indirect;
            (0..3).for_each(|c| sum[c] += PI * light[c] / paths as f32);
        }
        sum
    });
    run.check()?;
    Ok(plane)
}

/// A plane kept in a file, or made and kept.
fn remembered(
    path: Option<&Path>,
    buffer: &GBuffer,
    make: impl FnOnce() -> Result<Plane<[f32; 3]>>,
) -> Result<Plane<[f32; 3]>> {
    let (width, height) = buffer.size();
    if let Some(bytes) = path.and_then(|p| std::fs::read(p).ok())
        && bytes.len() == 12 * width * height
    {
        let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        let pixel = |b: &[u8]| [number(&b[0..4]), number(&b[4..8]), number(&b[8..12])];
        return Ok(Plane::from_pixels(width, height, bytes.chunks(12).map(pixel).collect()));
    }
    let plane = make()?;
    if let Some(path) = path {
        let bytes: Vec<u8> =
            plane.pixels().iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        crate::write::whole(path, &bytes)?;
    }
    Ok(plane)
}

/// Processor seconds of this process so far, over all its threads; the clock's where the system
/// does not tell.
fn processor_seconds() -> f64 {
    let nanoseconds = |path: std::path::PathBuf| -> Option<f64> {
        std::fs::read_to_string(path).ok()?.split(' ').next()?.parse().ok()
    };
    let threads = std::fs::read_dir("/proc/self/task").ok().map(|tasks| {
        let tasks = tasks.filter_map(|t| t.ok());
        tasks.filter_map(|t| nanoseconds(t.path().join("schedstat"))).sum::<f64>()
    });
    match threads {
        Some(n) if n > 0.0 => 1e-9 * n,
        _ => {
            static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
            START.get_or_init(Instant::now).elapsed().as_secs_f64()
        }
    }
}
