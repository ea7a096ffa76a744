//! Planes of pixels, colour, filters, codecs and picture metrics.

pub mod codec;
pub mod colour;
pub mod filter;
pub mod labels;
pub mod metric;
mod plane;
pub mod resample;
pub mod statistics;

pub use plane::Plane;
