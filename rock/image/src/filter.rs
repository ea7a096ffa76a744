//! Filters on planes, one concept a file: Gaussian averages and medians over the covered pixels.
//!
//! A *mask* says which pixels are covered, that is, show geometry. Only covered pixels are ever
//! averaged: what lies outside the picture or beside the objects has no weight, so that nothing
//! bleeds across a silhouette into nothing.

mod gaussian;
mod median;

pub use gaussian::{gaussian_masked, gaussian_masked3};
pub use median::median3;
