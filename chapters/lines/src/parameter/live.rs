//! [`Live`]: lines and parameters frame by frame, for previews (section 4.9).
//!
//! A frame costs its own lines and one diffusion; nothing is asked of frames to come, nothing is kept
//! but the samples of the frame before. Ids are not tracked: a stroke's id is its place in the frame.

use super::diffuse::Diffuser;
use crate::extract::{Lines, Moment, Stage};
use crate::film::Ground;
use crate::knob::LinesKnobs;
use crate::posed::Posed;
use crate::stroke::Stroke;
use crate::view::View;

/// A preview in progress.
///
/// ```
/// use chiaro_basis::math::{Vec3, vec3};
/// use chiaro_lines::parameter::Live;
/// use chiaro_lines::{Ground, LinesKnobs, Posed, View};
/// use chiaro_scene::{Playback, Pose, Projection, demo};
///
/// let scene = demo::scene("peanut")?;
/// let frame = scene.frame(0.0, &Playback::still());
/// let knobs = LinesKnobs::default();
/// let ground = Ground::of(&scene, &frame, &knobs, &[]);
/// let posed = Posed::new(&ground.surface, &frame, knobs.smooth_normals);
/// let mut live = Live::new(&ground, &knobs);
/// for step in 0..3 {
///     let eye = vec3(0.1 * step as f32, 2.0, 6.0);
///     let lens = Projection::Perspective { fov_y: 0.6 };
///     let view = View::new(Pose::look_at(eye, Vec3::ZERO, Vec3::Y, lens), (320, 240));
///     let strokes = live.frame(&posed, &view);
///     assert!(strokes.iter().all(|s| s.u.len() == s.length.len()));
/// }
/// # chiaro_basis::Result::Ok(())
/// ```
pub struct Live<'a> {
    ground: &'a Ground,
    knobs: &'a LinesKnobs,
    quick: bool,
    diffuser: Diffuser,
}

impl<'a> Live<'a> {
    /// Begins on a surface.
    pub fn new(ground: &'a Ground, knobs: &'a LinesKnobs) -> Self {
        Self { ground, knobs, quick: false, diffuser: Diffuser::default() }
    }

    /// The same with visibility by a depth buffer: much faster, ends of lines to within a pixel or
    /// two, and no lines where pieces pass through each other ([`Lines::preview`]).
    pub fn quick(ground: &'a Ground, knobs: &'a LinesKnobs) -> Self {
        Self { quick: true, ..Self::new(ground, knobs) }
    }

    /// The strokes of the next frame, seen ones first, then hidden ones where they are wanted.
    pub fn frame(&mut self, posed: &Posed, view: &View) -> Vec<Stroke> {
        let stage = Stage {
            surface: &self.ground.surface,
            features: &self.ground.features,
            masks: &self.ground.masks,
            knobs: self.knobs,
        };
        let moment = Moment { posed, view, next: None };
        let lines = match self.quick {
            true => Lines::preview(&stage, &moment),
            false => Lines::find(&stage, &moment),
        };
        let mut strokes = lines.strokes;
        strokes.extend(lines.hidden);
        strokes.iter_mut().enumerate().for_each(|(i, s)| s.id = i as u32);
        self.diffuser.advance(&mut strokes, view, f64::from(self.knobs.pattern_length));
        strokes
    }

    /// Forgets the frame before: after a cut of the camera.
    pub fn forget(&mut self) {
        self.diffuser = Diffuser::default();
    }
}
