//! Pictures to bytes and back: PNG, JPEG and Radiance HDR (reading only), PBM and OpenEXR; films as
//! animated PNG and GIF; planes
//! as NPY (writing only).
//!
//! Codecs take and give bytes, never files, so that the caller alone decides how a file appears on
//! disk. What they write depends on the picture and the recipe alone. What they read may be
//! hostile: sizes are checked against [`Limits`] and against what a file of that length can hold
//! *before* memory is asked for, and anything wrong is one sentence that names the file.

mod apng;
mod exr;
mod gif;
mod hdr;
mod jpeg;
mod limits;
mod npy;
mod packed;
mod pbm;
mod picture;
mod png;
mod tiff;

pub use apng::write_apng;
pub use exr::{ExrChannel, ExrImage, read_exr, write_exr};
pub use gif::write_gif;
pub use hdr::read_hdr;
pub use limits::Limits;
pub use npy::{write_npy, write_npy_labels};
pub use packed::{Packed, Pictures};
pub use pbm::{read_pbm, write_pbm};
pub use picture::{Format, read_colour, read_components, read_picture};
pub use png::{read_png_recipe, write_png_bits, write_png_grey, write_png_rgb, write_png_rgba};
pub use tiff::write_tiff_bits;
