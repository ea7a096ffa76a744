//! Filters on planes, one concept a file: Gaussian averages and medians over the covered pixels,
//! and distances to marks.
//!
//! A *mask* says which pixels are covered, that is, show geometry. Only covered pixels are ever
//! averaged: what lies outside the picture or beside the objects has no weight, so that nothing
//! bleeds across a silhouette into nothing.

mod distance;
mod gaussian;
mod means;
mod median;

pub use distance::distance_to;
pub use gaussian::{gaussian_covered, gaussian_masked};
pub use means::{Means, gaussian_covered3};
pub use median::median3;
