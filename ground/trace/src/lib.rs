//! Rays into scenes: closest hits, shadows, geometry buffers and appearance channels.
//!
//! ```text
//! Frame --Tracer--> rays --GBuffer--> what is seen --channels--> how it looks, in [0, 1]
//! ```

pub mod channel;
mod coincide;
mod daylight;
mod direct;
mod gbuffer;
mod gloss;
mod glow;
mod hierarchy;
mod lamps;
mod lattice;
mod light;
mod lights;
mod link;
mod mip;
mod motion;
mod occlusion;
mod panels;
pub mod path;
mod penumbra;
mod sample;
mod shadow;
mod sky;
mod smooth;
mod surface;
mod surroundings;
mod tracer;
mod triangle;
mod vertex;
pub mod view;

pub use daylight::{daylight, sky_of_sun};
pub use direct::{Direct, direct_irradiance, lamp_irradiance};
pub use gbuffer::GBuffer;
pub use gloss::Gloss;
pub use glow::{Glow, GlowPoint, GlowTriangle};
pub use hierarchy::Hierarchy;
pub use lamps::Lamps;
pub use light::{Arrival, KEY_FROM, Lamp, Patch, Shown};
pub use lights::{LightNumbers, LightSample, Lights};
pub use link::{Match, UNLINKED, links};
pub use motion::motion;
pub use occlusion::ambient_occlusion;
pub use sample::Sequence;
pub use sky::{BlurredSky, Sky, SkySample};
pub use surface::{Surface, Surfaces};
pub use tracer::{Hit, Ray, Sides, Tracer};
pub use vertex::{Vertex, albedo, cosine_direction};
