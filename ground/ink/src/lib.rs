//! Marks on paper: label images to smooth borders, marked edges to lines, lines to pixels.
//!
//! ```text
//! labels --border--> smooth coverage          cracks --chain--> polylines --draw--> coverage
//! ```
//!
//! Coordinates are in pixels, y down, pixel centres at + 0.5.

mod border;
mod crack;
mod stroke;

pub use border::smooth_coverage;
pub use crack::{Cracks, Polyline};
pub use stroke::draw;
