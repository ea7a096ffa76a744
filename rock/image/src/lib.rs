//! Planes of pixels, colour, filters, codecs and picture metrics.
//!
//! Everything here is about pictures and knows nothing of rays, scenes or styles. All results are
//! the same bytes for any number of threads. A tour:
//!
//! - [`Plane`]: the only two-dimensional array; row-major, y down, pixel centres at + 0.5.
//! - [`Runs`]: where the rows of a mask are covered, for passes that leave out the rest.
//! - [`colour`]: the sRGB curve, luminance, colours as typed.
//! - [`filter`], [`statistics`]: averages, medians, percentiles and thresholds of the covered
//!   pixels, those that a mask says show geometry.
//! - [`labels`]: the connected pieces of a picture of labels.
//! - [`resample`]: pictures of another size.
//! - [`codec`]: PNG, JPEG, PBM and OpenEXR from and to bytes, with limits against hostile files.
//! - [`metric`]: how far two pictures are apart.
//! - [`sheet`], [`text`]: contact sheets with captions.
//! - [`tone`]: light of any brightness to what a display shows.
//!
//! ```
//! use chiaro_image::{Plane, codec, filter, metric, statistics};
//!
//! // A disc on a dark ground, every pixel covered.
//! let picture = Plane::from_fn(64, 48, |x, y| {
//!     let distance = (x as f32 - 31.5).hypot(y as f32 - 23.5);
//!     if distance < 15.0 { 0.9 } else { 0.2 }
//! });
//! let covered = picture.map(|_| true);
//!
//! // Smooth it, and split it into black and white where the two classes part.
//! let smooth = filter::gaussian_masked(&picture, &covered, 2.0);
//! let threshold = statistics::otsu(&smooth, &covered);
//! let white = smooth.map(|v| *v > threshold);
//!
//! // To a file's bytes with its recipe, and back.
//! let png = codec::write_png_bits(&white, Some("sigma = 2"))?;
//! assert_eq!(codec::read_png_recipe(&png, "disc.png")?.as_deref(), Some("sigma = 2"));
//! let back = codec::read_colour(&png, "disc.png", &codec::Limits::default())?;
//! let drawn = white.map(|w| [f32::from(u8::from(*w)); 3]);
//! assert_eq!(metric::changed_pixels(&metric::displayed(&back), &drawn)?, 0);
//! # Ok::<(), chiaro_basis::Error>(())
//! ```

pub mod codec;
pub mod colour;
pub mod filter;
pub mod labels;
pub mod metric;
mod plane;
pub mod resample;
mod runs;
pub mod sheet;
pub mod statistics;
pub mod text;
pub mod tone;

pub use plane::Plane;
pub use runs::Runs;
