//! Planes of pixels, colour, filters, codecs and picture metrics.

mod plane;

pub use plane::Plane;
