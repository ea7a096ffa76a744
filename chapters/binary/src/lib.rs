//! Binary shading: black and white from appearance and geometry by a minimal cut over the image
//! (thesis, chapter 3).
//!
//! ```text
//! Scene, camera --Lit--> Channels --Exposure--> terminal weights --+
//!                        GBuffer ------------> neighbour weights --+-> Graph -> Labels -> Lines -> picture
//! ```
//!
//! 1. [`Channels`]: the appearance channels that the style mixes (3.5.1).
//! 2. [`expose`]: levels and threshold, once for a shot.
//! 3. [`shade`]: weights (3.1 to 3.9), the cut, islands, lines.
//! 4. [`compose`]: regions and lines as one grey picture.

mod appearance;
mod baseline;
mod bridge;
mod cel;
mod compose;
mod cut;
mod exposure;
mod faint;
mod film;
mod flat;
mod flicker;
mod geometry;
mod halo;
mod hold;
mod island;
mod knob;
mod line;
mod mend;
mod paint;
mod palette;
mod patch;
mod plateau;
mod price;
mod room;
mod round;
mod rows;
mod shade;
mod still;
mod tariff;
mod terminal;
mod window;

pub use appearance::{Channel, Channels, Lit};
pub use baseline::{Method, image_bonds};
pub use cel::{Cel, Layer};
pub use compose::{Marks, compose, map_colours, one_bit};
pub use cut::{Border, FeaturePairs, Graph, Labels};
pub use exposure::{Exposure, LEAST_REACH, MOST_STEPS, Sample, local_contrast, mixed_tone};
pub use film::{BLOCK, Done, Film, Plan};
pub use flicker::{Flicker, REVERSAL, Shown};
pub use geometry::{EDGES, angle, depth_step, neighbour_factors};
pub use island::without_islands;
pub use knob::{BinaryKnobs, CurvatureForm, DepthForm, Model, REFERENCE_HEIGHT, scaled};
pub use line::{Features, Lines};
pub use paint::{Lesson, Paint, Stroke, Strokes};
pub use palette::{Coloured, Palette, colour_regions, film_layers, is_light, labelled, tint};
pub use shade::{Prepared, Steps, View, Weights, expose, outline, prepare, shade, weigh};
pub use tariff::Tariff;
pub use terminal::terminal;
