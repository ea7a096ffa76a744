//! Tracking a zero set through time: section 4.5.2, without its epsilon steps.
//!
//! Between two frames the function is taken as linear in time at each vertex; so each vertex
//! changes side at most once an interval, and the whole history of the zero set is the list of these
//! flips in the order of time ([`Kinetic`]). The surface S of the thesis is what the zero set sweeps:
//! its slices are the zero sets of the frames, its critical points are flips ([`Event`]).

mod identity;
mod kinetic;
mod order;

pub use identity::{Identity, Strands};
pub use kinetic::{Event, EventKind, Interval, Kinetic};
pub use order::Order;
