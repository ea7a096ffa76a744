//! Animated PNG: a short film in one file that any browser plays.

use super::packed::Pictures;
use super::png::RECIPE;
use chiaro_basis::{Error, Result};
use png::{BitDepth, ColorType, Encoder, SrgbRenderingIntent};

/// An endless animation of RGBA frames of one size, sRGB-encoded, `fps` frames a second, with the
/// recipe where [`read_png_recipe`](super::read_png_recipe) finds it.
///
/// # Errors
/// [`Error::Setting`] without frames, or when their sizes differ.
pub fn write_apng(frames: &dyn Pictures, fps: f64, recipe: Option<&str>) -> Result<Vec<u8>> {
    let count = frames.count();
    let wrong = |why: String| Error::setting("animation", format!("{count} frames"), why);
    if count == 0 {
        return Err(wrong("at least one frame".into()));
    }
    let (width, height) = frames.size(0);
    if (1..count).any(|k| frames.size(k) != (width, height)) {
        return Err(wrong("frames of one size".into()));
    }
    let mut bytes = Vec::new();
    let written = (|| {
        let mut encoder = Encoder::new(&mut bytes, width as u32, height as u32);
        encoder.set_color(ColorType::Rgba);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_animated(count as u32, 0)?;
        encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
        let (numerator, denominator) = delay(fps);
        encoder.set_frame_delay(numerator, denominator)?;
        if let Some(recipe) = recipe {
            encoder.add_itxt_chunk(RECIPE.into(), recipe.into())?;
        }
        let mut writer = encoder.write_header()?;
        for k in 0..count {
            writer.write_image_data(frames.picture(k).pixels().as_flattened())?;
        }
        writer.finish()
    })();
    written
        .map_err(|e: png::EncodingError| wrong(format!("an animation that PNG can hold ({e})")))?;
    Ok(bytes)
}

/// The seconds that a frame stays, as a fraction of two 16-bit numbers: exact to a thousandth of a
/// frame a second as far as that fits, and to a whole one past it.
fn delay(fps: f64) -> (u16, u16) {
    let scale = if fps * 1000.0 <= 65535.0 { 1000 } else { 1 };
    (scale, (fps * f64::from(scale)).round().clamp(1.0, 65535.0) as u16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Plane;
    use std::io::Cursor;

    #[test]
    fn frames_and_recipe_come_back() {
        let frame = |n: u8| Plane::from_fn(9, 5, |x, y| [n * 50, x as u8, y as u8, 255]);
        let frames: Vec<_> = (0..3).map(frame).collect();
        let bytes = write_apng(&frames, 24.0, Some("shot = 1")).unwrap();
        let recipe = crate::codec::read_png_recipe(&bytes, "a.apng").unwrap();
        assert_eq!(recipe.as_deref(), Some("shot = 1"));
        let mut reader = png::Decoder::new(Cursor::new(&bytes)).read_info().unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 3);
        for frame in &frames {
            let mut data = vec![0; 9 * 5 * 4];
            reader.next_frame(&mut data).unwrap();
            assert_eq!(data, frame.pixels().as_flattened());
            let control = reader.info().frame_control().unwrap();
            assert_eq!((control.delay_num, control.delay_den), (1000, 24000));
        }
    }

    #[test]
    fn delays_fit_their_fraction() {
        assert_eq!(
            [23.976, 60.0, 120.0, 0.0].map(delay),
            [(1000, 23976), (1000, 60000), (1, 120), (1000, 1)]
        );
    }

    #[test]
    fn animations_of_nothing_or_of_two_sizes_are_refused() {
        assert!(write_apng(&Vec::<Plane<[u8; 4]>>::new(), 24.0, None).is_err());
        let frames = vec![Plane::filled(2, 2, [0; 4]), Plane::filled(2, 3, [0; 4])];
        assert!(write_apng(&frames, 24.0, None).is_err());
        assert!(write_apng(&vec![Plane::default()], 24.0, None).is_err());
    }
}
