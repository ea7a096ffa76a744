//! Planes of pixels, colour, filters, codecs and picture metrics.

pub mod codec;
pub mod colour;
pub mod filter;
mod plane;
pub mod statistics;

pub use plane::Plane;
