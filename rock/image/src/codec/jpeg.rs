//! JPEG, reading only: baseline and progressive, grey, YCbCr, RGB and CMYK.

use super::Limits;
use super::limits::{self, check_plausible};
use crate::Plane;
use chiaro_basis::{Error, Result};
use image::codecs::jpeg::JpegDecoder;
use image::{ColorType, ImageDecoder};
use std::io::Cursor;

/// Bytes of grey that one byte of JPEG can unpack to, generously: a block of 64 takes at least one
/// bit in the scan of its mean values, and the scans of a progressive file may leave out the rest.
const RATIO: u64 = 4096;

/// Decodes a JPEG, opaque. The orientation that a camera notes beside the pixels is not applied.
pub(super) fn decode(bytes: &[u8], name: &str, limits: &Limits) -> Result<Plane<[u8; 4]>> {
    let decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(|why| damaged(name, why))?;
    let (width, height) = decoder.dimensions();
    limits.check(name, (u64::from(width), u64::from(height)), 4)?;
    check_plausible(name, bytes.len(), u64::from(width) * u64::from(height), RATIO)?;
    let channels = match decoder.color_type() {
        ColorType::L8 => 1,
        ColorType::Rgb8 => 3,
        other => return Err(damaged(name, format!("its pixels are {other:?}"))),
    };
    let mut data = vec![0; width as usize * height as usize * channels];
    decoder.read_image(&mut data).map_err(|why| damaged(name, why))?;
    let rgba =
        |p: &[u8]| if channels == 1 { [p[0], p[0], p[0], 255] } else { [p[0], p[1], p[2], 255] };
    let pixels = data.chunks_exact(channels).map(rgba).collect();
    Ok(Plane::from_pixels(width as usize, height as usize, pixels))
}

fn damaged(name: &str, why: impl std::fmt::Display) -> Error {
    limits::damaged(name, "JPEG", why)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::ExtendedColorType;
    use image::codecs::jpeg::JpegEncoder;

    fn encoded(size: (u32, u32), colour: ExtendedColorType, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        JpegEncoder::new_with_quality(&mut bytes, 95)
            .encode(data, size.0, size.1, colour)
            .expect("the encoder takes it");
        bytes
    }

    #[test]
    fn colour_and_grey_are_read() {
        let colour: Vec<u8> = (0..16 * 16).flat_map(|_| [200, 100, 50]).collect();
        let bytes = encoded((16, 16), ExtendedColorType::Rgb8, &colour);
        let plane = decode(&bytes, "a.jpg", &Limits::default()).unwrap();
        let [r, g, b, a] = plane[(8, 8)];
        assert!(r.abs_diff(200) < 4 && g.abs_diff(100) < 4 && b.abs_diff(50) < 4 && a == 255);
        let bytes = encoded((9, 5), ExtendedColorType::L8, &[77; 45]);
        let plane = decode(&bytes, "a.jpg", &Limits::default()).unwrap();
        assert_eq!(plane.size(), (9, 5));
        assert!(plane.pixels().iter().all(|p| p[0].abs_diff(77) < 3 && p[0] == p[2]));
    }

    #[test]
    fn sizes_beyond_the_limit_or_the_file_are_refused() {
        let mut bytes = encoded((8, 8), ExtendedColorType::L8, &[0; 64]);
        let tight = Limits { pixels: 63, bytes: 1 << 20 };
        assert!(matches!(decode(&bytes, "a.jpg", &tight), Err(Error::Limit { .. })));
        let frame = bytes.windows(2).position(|w| w == [0xFF, 0xC0]).expect("a frame header");
        bytes[frame + 5..frame + 9].copy_from_slice(&[0x3F, 0xFF, 0x3F, 0xFF]);
        let message = decode(&bytes, "a.jpg", &Limits::default()).unwrap_err().to_string();
        assert!(message.contains("cannot hold"), "{message}");
    }
}
