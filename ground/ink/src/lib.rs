//! Marks on paper: label images to smooth borders, marked edges to lines, lines to pixels, and all
//! of it to SVG in millimetres.
//!
//! ```text
//! labels --border--> smooth coverage            cracks --chain--> polylines --draw--> coverage
//! labels --soften, partition, fit--> regions --+            ink, prices --stencil--> a sheet in one piece
//!     regions --hatch--> strokes, polylines --fit, travel--> strokes --> Drawing --> SVG
//! ```
//!
//! Pictures have coordinates in pixels, y down, pixel centres at + 0.5; a [`Drawing`] has them in
//! millimetres, and a [`Placement`] leads from one to the other.

mod border;
pub mod brush;
mod centre;
mod crack;
mod drawing;
mod fit;
mod hatch;
mod join;
mod paper;
mod partition;
mod path;
mod relax;
mod seam;
mod soften;
mod stencil;
mod stroke;
mod svg;
mod travel;

pub use border::smooth_coverage;
pub use centre::centre_lines;
pub use crack::{Cracks, Polyline};
pub use drawing::{Colour, Drawing, Layer, Mark, Picture, Travel};
pub use fit::{Fit, fit, simplified};
pub use hatch::{Area, Hatch};
pub use paper::{Placement, Sheet, length};
pub use partition::{Partition, Region};
pub use path::{Path, Point, Segment};
pub use seam::{SEAM_WIDTH, seams};
pub use soften::{NOTHING, Soft};
pub use stencil::{Bridge, Stencil, StencilForm, stencil};
pub use stroke::draw;
pub use travel::{Plan, joined, plan, route};
