//! Animated PNG: a short film in one file that any browser plays.

use crate::Plane;
use chiaro_basis::{Error, Result};
use png::{BitDepth, ColorType, Encoder};

/// An endless animation of RGBA frames of one size, `fps` frames a second.
///
/// # Errors
/// [`Error::Setting`] without frames, or when their sizes differ.
pub fn write_apng(frames: &[Plane<[u8; 4]>], fps: f64, recipe: Option<&str>) -> Result<Vec<u8>> {
    let wrong = |why: String| Error::setting("animation", format!("{} frames", frames.len()), why);
    let first = frames.first().ok_or_else(|| wrong("at least one frame".into()))?;
    if frames.iter().any(|f| f.size() != first.size()) {
        return Err(wrong("frames of one size".into()));
    }
    let (width, height) = first.size();
    let mut bytes = Vec::new();
    let written = (|| {
        let mut encoder = Encoder::new(&mut bytes, width as u32, height as u32);
        encoder.set_color(ColorType::Rgba);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_animated(frames.len() as u32, 0)?;
        // A delay is a fraction of two 16-bit numbers.
        encoder.set_frame_delay(1000, (fps * 1000.0).round().clamp(16.0, 65535.0) as u16)?;
        if let Some(recipe) = recipe {
            encoder.add_itxt_chunk("chiaro".into(), recipe.into())?;
        }
        let mut writer = encoder.write_header()?;
        for frame in frames {
            writer.write_image_data(frame.pixels().as_flattened())?;
        }
        writer.finish()
    })();
    written
        .map_err(|e: png::EncodingError| wrong(format!("an animation that PNG can hold ({e})")))?;
    Ok(bytes)
}
