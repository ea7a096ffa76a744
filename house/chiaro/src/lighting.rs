//! Which light black-and-white pictures of a shot stand in.
//!
//! In order: the sun that the user set; the scene's lamps and the surfaces that shine; a key light
//! where there is neither, or where what shines lights too little to draw by (eyes of a robot, a
//! screen on a desk).

use crate::camera::Camera;
use crate::project::Project;
use chiaro_basis::math::{Quat, Vec3};
use chiaro_basis::{Result, Run};
use chiaro_scene::Frame;
use chiaro_trace::{GBuffer, Glow, Lamp, Lamps, Surfaces, Tracer, channel};

/// The share of what is seen that shining surfaces must reach to be the light of a scene.
const LEAST_LIT: f32 = 0.25;
/// The height of the picture on which that is measured.
const PROBE_HEIGHT: usize = 96;

/// The light of a shot.
pub(crate) enum Lighting {
    /// One parallel light.
    Sun(Lamp),
    /// One parallel light that turns round the vertical, so many degrees a second.
    Turning(Lamp, f32),
    /// The scene's lamps, and what shines in it.
    Scene { glow: bool },
}

impl Lighting {
    /// Chooses by the first frame of a shot.
    pub(crate) fn choose(
        project: &Project,
        surfaces: &Surfaces,
        camera: &Camera,
        (frame, number): (&Frame, u32),
        run: &Run,
    ) -> Result<Self> {
        if let Some([azimuth, elevation]) = project.options.sun {
            let (a, e) = (azimuth.to_radians(), elevation.to_radians());
            let from = Vec3::new(e.cos() * a.sin(), e.sin(), e.cos() * a.cos());
            return Ok(Self::Sun(Lamp::sun(-from)));
        }
        let shines = project.scene.materials.iter().any(|m| m.shines());
        let punctual = Lamp::of_frame(frame);
        if !punctual.is_empty() {
            return Ok(Self::Scene { glow: shines });
        }
        let pose = camera.pose(frame, number);
        if shines && reach(project, surfaces, camera, (frame, number), run)? >= LEAST_LIT {
            return Ok(Self::Scene { glow: true });
        }
        run.warn(
            "no light in the scene: a key light from above, on the left, on the viewer's side",
        );
        Ok(Self::Sun(Lamp::key(&pose)))
    }

    /// The lamps of a frame.
    pub(crate) fn lamps(&self, tracer: &Tracer, surfaces: &Surfaces) -> Lamps {
        match self {
            Self::Sun(sun) => Lamps::of(vec![*sun]),
            Self::Turning(sun, speed) => {
                let turn = Quat::from_rotation_y(speed.to_radians() * tracer.frame.time as f32);
                Lamps::of(vec![Lamp { direction: turn * sun.direction, ..*sun }])
            }
            Self::Scene { glow } => {
                let lamps = Lamps::of(Lamp::of_frame(tracer.frame));
                if *glow { lamps.with(Glow::of(tracer, surfaces)) } else { lamps }
            }
        }
    }
}

/// The share of a small picture to which light comes from surfaces that shine.
fn reach(
    project: &Project,
    surfaces: &Surfaces,
    camera: &Camera,
    (frame, number): (&Frame, u32),
    run: &Run,
) -> Result<f32> {
    let tracer = project.tracer(frame);
    let lamps = Lamps::default().with(Glow::of(&tracer, surfaces));
    if lamps.all().is_empty() {
        return Ok(0.0);
    }
    let size = camera.at_height(PROBE_HEIGHT).size;
    let buffer = GBuffer::trace(&tracer, surfaces, &camera.pose(frame, number), size, run)?;
    let light = channel::diffuse(&tracer, &buffer, &lamps, true, run)?;
    let covered = buffer.covered.pixels().iter().filter(|c| **c).count();
    // The tone is one half at the median of what is lit; a trace of light counts for nothing, nor
    // does what shines by itself.
    let tones = light.shadowed.pixels().iter().zip(buffer.emissive.pixels());
    let lit = tones.filter(|(t, e)| **t > 0.1 && **e == [0.0; 3]).count();
    Ok(lit as f32 / covered.max(1) as f32)
}
