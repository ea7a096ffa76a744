//! Rays into scenes: closest hits, shadows, geometry buffers and appearance channels.
//!
//! ```text
//! Frame --Tracer--> rays --GBuffer--> what is seen --channels--> how it looks, in [0, 1]
//! ```

pub mod channel;
mod gbuffer;
mod glow;
mod hierarchy;
mod light;
mod link;
mod mip;
mod motion;
mod occlusion;
mod smooth;
mod surface;
mod tracer;
mod triangle;
pub mod view;

pub use gbuffer::GBuffer;
pub use glow::{Glow, GlowPoint, GlowTriangle};
pub use hierarchy::Hierarchy;
pub use light::{Arrival, KEY_FROM, Lamp, Patch};
pub use link::{Match, UNLINKED, links};
pub use motion::motion;
pub use occlusion::ambient_occlusion;
pub use surface::{Surface, Surfaces};
pub use tracer::{Hit, Ray, Sides, Tracer};
