//! Readers: untrusted bytes to a [`Scene`](crate::Scene).

mod door;

pub use door::{Budget, Door, Source};
