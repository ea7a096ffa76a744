//! The default view: from where to look at a scene that brings no camera.
//!
//! An object is seen from three quarters (`object`), a room from inside (`room`).

mod object;
mod room;

use crate::tracer::Tracer;
use chiaro_scene::{Bounds, Frame, Pose};
use object::Outline;
use room::Stand;

/// What the view was chosen for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// Something to be looked at from outside.
    Object,
    /// Something to stand in.
    Room,
}

/// What a default view is made from: the shape over a shot, and whether it is a room.
pub struct Framing {
    /// The box of what the view frames, over the shot.
    pub bounds: Bounds,
    outline: Outline,
    room: Option<Stand>,
}

impl Framing {
    /// The framing of a shot: `tracer` holds its first frame, `frames` are a few of all.
    pub fn of(tracer: &Tracer, frames: &[Frame]) -> Self {
        let outline = Outline::of(frames);
        Self { bounds: outline.bounds(), outline, room: Stand::find(tracer) }
    }

    /// The same for a camera that turns once round the vertical through the middle of what it frames; a room as it is.
    pub fn turned(self) -> Self {
        let outline = self.outline.turned();
        Self { bounds: outline.bounds(), outline, ..self }
    }

    /// A good aspect (width over height): the shape's own in the default view, between 3:4 and
    /// 4:3; rooms are 4:3.
    pub fn aspect(&self, orbit: f32) -> f32 {
        if self.room.is_some() { 4.0 / 3.0 } else { self.outline.aspect(orbit) }
    }

    /// The default view for a picture of this `aspect`, turned by `orbit` degrees.
    pub fn view(&self, aspect: f32, orbit: f32) -> (Pose, Setting) {
        match &self.room {
            Some(stand) => (stand.view(orbit), Setting::Room),
            None => (self.outline.view(aspect, orbit), Setting::Object),
        }
    }
}
