//! [`IrradianceRecord`]: a receiver that looks in all directions by rays, and how what it receives changes
//! around it (Ward and Heckbert 1992, Irradiance gradients).
//!
//! Its hemisphere is cut into cells of equal cosine, one ray each. When the receiver turns, cells
//! change their cosine; when it moves, the borders between cells move by the distance of the nearer of the
//! two, so that occlusion is in the gradient. A few patterns of rays that complete each other alternate between records, so that those
//! around a pixel look into different directions.

use crate::field::Light;
use crate::hierarchy::Hierarchy;
use crate::indirect::Prepared;
use crate::near;
use chiaro_basis::math::Vec3;
use chiaro_trace::{Hit, Ray, Sequence, Sides, Vertex};
use std::f32::consts::{PI, TAU};

/// The cells of a hemisphere: rows from the pole to the horizon, columns around it.
pub(crate) struct Hemisphere {
    rows: usize,
    columns: usize,
    /// A direction in each cell of each pattern, row by row; z is the pole.
    patterns: Vec<Vec<Vec3>>,
    sequence: Sequence,
}

/// Irradiance and openness of a receiver, linear RGB and pi where all is open, with gradients.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IrradianceRecord {
    pub(crate) position: Vec3,
    pub(crate) normal: Vec3,
    /// Unit normal of its triangle.
    pub(crate) side: Vec3,
    pub(crate) light: Light,
    /// Change for a step along the surface, a scene unit.
    moved: [Vec3; 4],
    /// Change with the normal.
    turned: [Vec3; 4],
    /// The harmonic mean distance of what its rays met.
    pub(crate) clearance: f32,
}

/// What the cells of a receiver show: light, and its distance.
#[derive(Default)]
pub(crate) struct Cells {
    all: Vec<(Light, f32)>,
}

/// Spacings of surfels within which hits are lit by themselves.
const NEAR: f32 = 6.0;
/// Patterns of rays that alternate.
const PATTERNS: usize = 16;
/// Extrapolation changes light by this share of it at most.
const MOST_CHANGE: f32 = 0.7;

impl Hemisphere {
    /// About so many cells; `shift` chooses other directions in them.
    pub(crate) fn new(count: u32, shift: u32) -> Self {
        let rows = ((count as f32 / PI).sqrt().round() as usize).max(2);
        let columns = (count as usize).div_ceil(rows).max(4);
        let sequence = Sequence::new(u64::from(shift));
        let direction = |pattern: usize, i: usize| {
            // Four patterns in a row take a quarter of each cell each.
            let [a, b] = sequence.point((i * PATTERNS + pattern) as u32, u32::MAX);
            let square = ((i / columns) as f32 + a) / rows as f32;
            let (sin, cos) = (TAU * ((i % columns) as f32 + b) / columns as f32).sin_cos();
            let root = square.sqrt();
            Vec3::new(root * cos, root * sin, (1.0 - square).max(1e-6).sqrt())
        };
        let pattern = |p: usize| (0..rows * columns).map(|i| direction(p, i)).collect();
        Self { rows, columns, patterns: (0..PATTERNS).map(pattern).collect(), sequence }
    }

    /// Looks from a receiver; what is farther than `occlusion` does not occlude.
    pub(crate) fn look<T: Hierarchy>(
        &self,
        scene: &Prepared<T>,
        at: &Vertex,
        occlusion: f32,
        (pattern, cells): (usize, &mut Cells),
    ) -> IrradianceRecord {
        let directions = &self.patterns[pattern % PATTERNS];
        let (right, up) = at.normal.any_orthonormal_pair();
        let cell = |(k, d): (usize, &Vec3)| {
            let direction = right * d.x + up * d.y + at.normal * d.z;
            if direction.dot(at.side) <= 0.0 {
                return ([0.0; 4], f32::INFINITY);
            }
            let ray = at.ray(direction, f32::INFINITY);
            let hit = scene.lit.tracer.hit(&ray, Sides::Both);
            let Some(hit) = hit else { return ([0.0, 0.0, 0.0, 1.0], f32::INFINITY) };
            let [r, g, b] = far_radiance(scene, &ray, &hit).unwrap_or_else(|| {
                let index = (k * PATTERNS + pattern) as u32;
                let (lit, surfels, reflected) = (&scene.lit, &scene.surfels, &scene.reflected);
                near::shade(lit, surfels, reflected, &hit, direction, &self.sequence, index)
                    .radiance
            });
            ([r, g, b, if hit.t < occlusion { 0.0 } else { 1.0 }], hit.t)
        };
        cells.all.clear();
        cells.all.extend(directions.iter().enumerate().map(cell));
        self.record(at, [right, up], (&cells.all, directions))
    }

    /// Irradiance and its gradients from what the cells show.
    fn record(
        &self,
        at: &Vertex,
        axes: [Vec3; 2],
        (cells, directions): (&[(Light, f32)], &[Vec3]),
    ) -> IrradianceRecord {
        let share = PI / cells.len() as f32;
        let (mut light, mut nearness) = ([0.0; 4], 0.0);
        let mut turned = [Vec3::ZERO; 4];
        for ((shown, distance), d) in cells.iter().zip(directions) {
            let across = (axes[0] * d.x + axes[1] * d.y) * (share / d.z);
            nearness += 1.0 / distance;
            for c in 0..4 {
                light[c] += share * shown[c];
                turned[c] += across * shown[c];
            }
        }
        IrradianceRecord {
            position: at.position,
            normal: at.normal,
            side: at.side,
            light,
            moved: self.moved(axes, cells),
            turned,
            clearance: cells.len() as f32 / nearness,
        }
    }

    /// The change of light for a step: over all borders between cells, the difference of what both show
    /// times the cosine-weighted solid angle by which the border moves.
    fn moved(&self, [right, up]: [Vec3; 2], cells: &[(Light, f32)]) -> [Vec3; 4] {
        let (rows, columns) = (self.rows, self.columns);
        let mut moved = [Vec3::ZERO; 4];
        let mut add = |along: Vec3, a: &(Light, f32), b: &(Light, f32)| {
            let nearer = a.1.min(b.1);
            if nearer.is_finite() {
                let along = along / nearer;
                (0..4).for_each(|c| moved[c] += along * (a.0[c] - b.0[c]));
            }
        };
        let turn = |k: f32| {
            let (sin, cos) = (TAU * k / columns as f32).sin_cos();
            (right * cos + up * sin, up * cos - right * sin)
        };
        let sine = |j: usize| (j as f32 / rows as f32).sqrt();
        for k in 0..columns {
            let (outward, _) = turn(k as f32 + 0.5);
            let (_, around) = turn(k as f32);
            let before = (k + columns - 1) % columns;
            for j in 0..rows {
                let cell = &cells[j * columns + k];
                add(around * (sine(j + 1) - sine(j)), cell, &cells[j * columns + before]);
                if j > 0 {
                    let square = 1.0 - j as f32 / rows as f32;
                    let width = TAU / columns as f32 * sine(j) * square;
                    add(outward * width, cell, &cells[(j - 1) * columns + k]);
                }
            }
        }
        moved
    }
}

/// What the surfel nearest to a hit sends, which is less noisy than one shadow ray; `None` where the hit is
/// so near that the surfels' spacing would show, or no surfel is there.
fn far_radiance<T: Hierarchy>(scene: &Prepared<T>, ray: &Ray, hit: &Hit) -> Option<[f32; 3]> {
    if hit.t < NEAR * scene.surfels.spacing {
        return None;
    }
    let [a, b, c] = scene.lit.tracer.corners(hit.object, hit.face);
    let face = (b - a).cross(c - a).normalize_or_zero();
    let facing = if face.dot(ray.direction) > 0.0 { -face } else { face };
    let point = ray.origin + ray.direction * hit.t;
    let (index, side) = scene.reflected.grid.nearest(&scene.surfels, point, facing)?;
    Some(scene.surfels.all[index as usize].radiance[side])
}

impl IrradianceRecord {
    /// About how wrong what it foretells is at a distance, if gradients change over the distance of what is
    /// around.
    pub(crate) fn doubt(&self, distance: f32) -> f32 {
        let moved = (self.moved[0] + self.moved[1] + self.moved[2]) / 3.0;
        0.5 * moved.length() * distance * distance / self.clearance.max(f32::MIN_POSITIVE)
    }

    /// What a receiver near this one is expected to receive.
    pub(crate) fn at(&self, position: Vec3, normal: Vec3) -> Light {
        let (step, turn) = (position - self.position, normal - self.normal);
        std::array::from_fn(|c| {
            let change = self.moved[c].dot(step) + self.turned[c].dot(turn);
            let most = MOST_CHANGE * self.light[c];
            self.light[c] + change.clamp(-most, most)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::knob::{LightKnobs, Sharing};
    use crate::surfel::Lit;
    use crate::{prepare, sites};
    use chiaro_basis::Run;
    use chiaro_scene::{Poser, demo};
    use chiaro_trace::{GBuffer, Glow, Lights, Surfaces, Tracer};

    /// In the Cornell box, what a record foretells a step away and turned is nearer to what is there than
    /// its own light is.
    #[test]
    fn gradients_foretell_what_receivers_around_receive() {
        let scene = demo::scene("cornell-box").unwrap();
        let (playback, _) = scene.playback(&Default::default()).unwrap();
        let frame = Poser::new(&scene).frame(0.0, &playback);
        let tracer = Tracer::new(&scene, &frame);
        let surfaces = Surfaces::new(&scene);
        let lights = Lights { glow: Glow::of(&tracer, &surfaces), ..Lights::default() };
        let lit = Lit { tracer: &tracer, surfaces: &surfaces, lights: &lights };
        let run = Run::default();
        let knobs = LightKnobs { sharing: Sharing::Records, bounces: 1, ..LightKnobs::default() };
        let prepared = prepare(lit, &sites(&scene, &frame, 5000), &knobs, &run).unwrap();
        let buffer = GBuffer::trace(&tracer, &surfaces, &frame.cameras[0], (12, 12), &run).unwrap();
        let hemisphere = Hemisphere::new(2048, 0);
        let mut cells = Cells::default();
        let mut look = |at: &Vertex| hemisphere.look(&prepared, at, 1.0, (0, &mut cells));
        // Square changes, and what is left of them.
        let (mut moved, mut turned) = ([0.0; 2], [0.0; 2]);
        for (x, y) in (0..144).map(|i| (i % 12, i / 12)).filter(|p| buffer.covered[*p]) {
            let at = Vertex::of_pixel(&tracer, &buffer, (x, y));
            let record = look(&at);
            let aside = at.normal.any_orthonormal_vector();
            let step = aside * (0.05 * record.clearance);
            let there = Vertex { position: at.position + step, ..at };
            let bent = Vertex { normal: (at.normal + 0.15 * aside).normalize(), ..at };
            for (sum, at) in [(&mut moved, there), (&mut turned, bent)] {
                let (exact, told) = (look(&at).light, record.at(at.position, at.normal));
                for c in 0..4 {
                    sum[0] += (exact[c] - record.light[c]).powi(2);
                    sum[1] += (exact[c] - told[c]).powi(2);
                }
            }
        }
        assert!(moved[1] < 0.5 * moved[0], "{moved:?}");
        assert!(turned[1] < 0.35 * turned[0], "{turned:?}");
    }
}
