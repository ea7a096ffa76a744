//! `chiaro light`: scenes under full light, one picture or a film.
//!
//! 1. Once for the shot (`shot`): the camera, the light where the scene has none, where surfels
//!    lie, and the exposure, measured on a few small frames.
//! 2. A frame at a time: rays, direct light, surfels, tree, gathers, and the file, written whole.

mod baked;
mod book;
mod cap;
mod check;
mod coded;
mod job;
mod kept;
mod layers;
mod shot;
mod still;
mod trial;
mod under;

pub use baked::adopt;
pub use cap::parse_bytes;
pub use job::{Check, Job, Method, check_target};
pub(crate) use still::{AnyTree, Still, nearness, still};
pub use trial::{Outcome, Truth, Way, trial};
pub(crate) use under::Under;
