//! Brushes: strokes with u to marks on paper.
//!
//! ```text
//! centre line + u + id ─Spine→ smoothed, refined ─Brush→ Ribbons ─pieces→ tiles of coverage ─→ pixels
//!                                                            ├─Halos, outlines→ closed curves for SVG
//!                                                            └─tones→ filled outlines of grain
//! ```
//!
//! Everything that varies along a stroke (pressure, wobble, grain, the places of dashes, dots,
//! thorns and hairs) is a function of u and the stroke's id alone: where u follows the surface, so
//! does the mark. Where u is periodic, nothing shows where a loop closes. Only tapers and swells are
//! measured from the ends that are seen.
//!
//! Not guaranteed: a texture is torn apart on the inside of a turn that is tighter than half the
//! width, where the nearest piece counts.

mod contour;
mod grain;
mod halo;
mod knob;
mod marks;
mod noise;
mod paint;
mod ribbon;
mod spine;
mod strip;
mod texture;
mod trace;
mod width;

pub use halo::Halos;
pub use knob::{Brush, Cap, Grain, Mark, Side};
pub use marks::{ribbons, rim};
pub use noise::Axis;
pub use paint::{Stroke, paint};
pub use ribbon::{Rib, Ribbon};
pub use spine::{Knot, Spine};
pub use texture::Texture;
pub use trace::{Tone, tones};
