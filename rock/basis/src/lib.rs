//! What every long computation of chiaro takes, and nothing about pixels, meshes or files.
//!
//! - [`Run`]: seed, cancellation and progress, handed down to everything that takes time.
//! - [`random`]: randomness that depends on a seed and an index, never on an order.
//! - [`reduce`]: parallel sums of fixed shape, the same bits for any number of threads.
//! - [`prefetch`]: asks for memory that will be needed soon.
//! - [`widely`]: loops in the widest vectors that the machine has.
//! - [`Sets`]: numbers that belong together.
//! - [`isotonic`]: the nearest values that never fall.
//! - [`typed_id!`]: indices that cannot be mixed up.
//! - [`knobs!`]: the one table of a chapter's parameters, read by command line, styles and manual.
//! - [`Error`]: what went wrong, sorted by who can act.
//! - [`math`]: the vector types, re-exported in one place.

mod error;
mod id;
mod isotonic;
mod knob;
mod prefetch;
pub mod random;
pub mod reduce;
mod run;
mod sets;
mod wide;

pub use error::{Error, Result};
pub use isotonic::isotonic;
pub use knob::{Knob, KnobKind, KnobValue, Knobs, Value, nearest};
pub use prefetch::prefetch;
pub use run::{Cancel, Observer, Run};
pub use sets::Sets;
pub use wide::widely;

/// The vector and matrix types of the workspace. One crate re-exports them, so that a change of
/// the underlying library is a change in one place.
pub mod math {
    pub use glam::{
        Affine3A, BVec3, DAffine3, DMat3, DMat4, DQuat, DVec2, DVec3, IVec2, Mat3, Mat4, Quat,
        Vec2, Vec3, Vec3A, Vec4, dvec3, vec2, vec3,
    };

    /// From 0 to 1 between two edges, level at both; falling where the first edge is the greater.
    pub fn smoothstep([from, to]: [f32; 2], x: f32) -> f32 {
        let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }
}
