//! PNG: 8-bit grey, RGB and RGBA and 1-bit grey out, every kind in, with the recipe as text.
//!
//! The recipe, the text that says how a picture was made, is an iTXt chunk under the keyword
//! `chiaro` in front of the pixels. Files say that their bytes are sRGB-encoded; ICC profiles and
//! gamma of the files read are not applied.

use super::Limits;
use super::limits::{self, check_plausible};
use crate::Plane;
use chiaro_basis::{Error, Result};
use png::{BitDepth, ColorType, Decoder, Encoder, Reader, SrgbRenderingIntent, Transformations};
use std::io::Cursor;

/// The keyword of the text chunk that holds the recipe.
pub(super) const RECIPE: &str = "chiaro";

/// Deflate unpacks at most 258 bytes from two bits.
const DEFLATE_RATIO: u64 = 1032;

/// A PNG of grey bytes, sRGB-encoded. [`Error::Setting`] when the plane has no pixels or over
/// 2^31 - 1 on a side; likewise the other writers.
pub fn write_png_grey(plane: &Plane<u8>, recipe: Option<&str>) -> Result<Vec<u8>> {
    write(plane.size(), (ColorType::Grayscale, BitDepth::Eight), plane.pixels(), recipe)
}

/// A PNG of red, green, blue bytes, sRGB-encoded.
pub fn write_png_rgb(plane: &Plane<[u8; 3]>, recipe: Option<&str>) -> Result<Vec<u8>> {
    let data = plane.pixels().as_flattened();
    write(plane.size(), (ColorType::Rgb, BitDepth::Eight), data, recipe)
}

/// A PNG of red, green, blue bytes, sRGB-encoded, and alpha, by which they are not multiplied.
pub fn write_png_rgba(plane: &Plane<[u8; 4]>, recipe: Option<&str>) -> Result<Vec<u8>> {
    let data = plane.pixels().as_flattened();
    write(plane.size(), (ColorType::Rgba, BitDepth::Eight), data, recipe)
}

/// A PNG of one bit a pixel: `true` is white.
pub fn write_png_bits(plane: &Plane<bool>, recipe: Option<&str>) -> Result<Vec<u8>> {
    let data = super::pbm::pack_bits(plane, |white| white);
    write(plane.size(), (ColorType::Grayscale, BitDepth::One), &data, recipe)
}

fn write(
    (width, height): (usize, usize),
    (colour, depth): (ColorType, BitDepth),
    data: &[u8],
    recipe: Option<&str>,
) -> Result<Vec<u8>> {
    let size = format!("{width} x {height}");
    let wrong = |why: String| Error::setting("size", &size, why);
    let side = |length: usize| {
        let in_range = i32::try_from(length).ok().filter(|&side| side > 0);
        in_range.ok_or_else(|| wrong("sides of 1 to 2147483647 pixels".into()))
    };
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, side(width)? as u32, side(height)? as u32);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
    let written = (|| {
        if let Some(recipe) = recipe {
            encoder.add_itxt_chunk(RECIPE.into(), recipe.into())?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(data)?;
        writer.finish()
    })();
    written.map_err(|why| wrong(format!("a picture that PNG can hold ({why})")))?;
    Ok(bytes)
}

/// The recipe in a PNG, or `None` when it has none. [`Error::Input`] when it is not a PNG.
pub fn read_png_recipe(bytes: &[u8], name: &str) -> Result<Option<String>> {
    // A compressed recipe is not ours, and may be a bomb: only plain text is looked at.
    let reader = Decoder::new(Cursor::new(bytes)).read_info().map_err(|why| damaged(name, why))?;
    let recipe = reader.info().utf8_text.iter().find(|t| t.keyword == RECIPE && !t.compressed);
    Ok(recipe.and_then(|text| text.get_text().ok()))
}

/// Pixels as a PNG stores them, with grey and palettes made RGBA.
pub(super) enum Stored {
    Bytes(Plane<[u8; 4]>),
    Words(Plane<[u16; 4]>),
}

/// Decodes any PNG; of an animated one, the first picture.
pub(super) fn decode(bytes: &[u8], name: &str, limits: &Limits) -> Result<Stored> {
    let mut reader = checked_reader(bytes, name, limits)?;
    let (width, height) = reader.info().size();
    let (colour, depth) = reader.output_color_type();
    let length = reader.output_buffer_size().ok_or_else(|| damaged(name, "size"))?;
    let mut data = vec![0; length];
    reader.next_frame(&mut data).map_err(|why| damaged(name, why))?;
    let size = (width as usize, height as usize);
    let grey = colour == ColorType::GrayscaleAlpha;
    if depth == BitDepth::Sixteen {
        let words = data.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect();
        Ok(Stored::Words(rgba(size, words, grey)))
    } else {
        Ok(Stored::Bytes(rgba(size, data, grey)))
    }
}

/// A reader that has passed the header and found its size sane, and will hand out grey and alpha,
/// or RGBA, with 8 or 16 bits.
fn checked_reader<'a>(
    bytes: &'a [u8],
    name: &str,
    limits: &Limits,
) -> Result<Reader<Cursor<&'a [u8]>>> {
    let memory = usize::try_from(limits.bytes).unwrap_or(usize::MAX);
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: memory });
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(Transformations::EXPAND | Transformations::ALPHA);
    let info = decoder.read_header_info().map_err(|why| damaged(name, why))?;
    let deep = info.bit_depth == BitDepth::Sixteen;
    let (width, height) = (u64::from(info.width), u64::from(info.height));
    limits.check(name, (width, height), if deep { 8 } else { 4 })?;
    let row = (width * info.bits_per_pixel() as u64).div_ceil(8) + 1;
    check_plausible(name, bytes.len(), row * height, DEFLATE_RATIO)?;
    decoder.read_info().map_err(|why| damaged(name, why))
}

/// Four channels from samples of either two (grey and alpha) or four.
fn rgba<T: Copy>((width, height): (usize, usize), samples: Vec<T>, grey: bool) -> Plane<[T; 4]> {
    let pixels = if grey {
        samples.chunks_exact(2).map(|s| [s[0], s[0], s[0], s[1]]).collect()
    } else {
        samples.chunks_exact(4).map(|s| [s[0], s[1], s[2], s[3]]).collect()
    };
    Plane::from_pixels(width, height, pixels)
}

fn damaged(name: &str, why: impl std::fmt::Display) -> Error {
    limits::damaged(name, "PNG", why)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stored(bytes: &[u8]) -> Plane<[u8; 4]> {
        match decode(bytes, "a.png", &Limits::default()).unwrap() {
            Stored::Bytes(plane) => plane,
            Stored::Words(_) => panic!("eight bits expected"),
        }
    }

    /// A PNG straight from the library, for the kinds that chiaro only reads.
    fn foreign(colour: ColorType, depth: BitDepth, size: (u32, u32), data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, size.0, size.1);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        if colour == ColorType::Indexed {
            encoder.set_palette(vec![10, 20, 30, 40, 50, 60]);
            encoder.set_trns(vec![255, 0]);
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    }

    #[test]
    fn every_kind_survives_the_round_trip() {
        let rgba = Plane::from_fn(7, 5, |x, y| [x as u8 * 30, y as u8 * 40, 99, (x * y) as u8]);
        assert_eq!(stored(&write_png_rgba(&rgba, None).unwrap()), rgba);
        let rgb = rgba.map(|&[r, g, b, _]| [r, g, b]);
        let opaque = rgb.map(|&[r, g, b]| [r, g, b, 255]);
        assert_eq!(stored(&write_png_rgb(&rgb, None).unwrap()), opaque);
        let grey = rgba.map(|p| p[0]);
        let wide = grey.map(|&v| [v, v, v, 255]);
        assert_eq!(stored(&write_png_grey(&grey, Some("r")).unwrap()), wide);
        let bits = Plane::from_fn(13, 5, |x, y| (x * 3 + y) % 4 == 0);
        let black_and_white = bits.map(|&b| [[0, 0, 0, 255], [255; 4]][usize::from(b)]);
        assert_eq!(stored(&write_png_bits(&bits, None).unwrap()), black_and_white);
    }

    #[test]
    fn palettes_grey_and_sixteen_bits_are_read() {
        let palette = foreign(ColorType::Indexed, BitDepth::One, (2, 1), &[0b0100_0000]);
        assert_eq!(stored(&palette).pixels(), [[10, 20, 30, 255], [40, 50, 60, 0]]);
        let grey = foreign(ColorType::Grayscale, BitDepth::Two, (2, 1), &[0b0111_0000]);
        assert_eq!(stored(&grey).pixels(), [[85, 85, 85, 255], [255; 4]]);
        let deep = foreign(ColorType::Rgb, BitDepth::Sixteen, (1, 1), &[1, 2, 3, 4, 5, 6]);
        match decode(&deep, "a.png", &Limits::default()).unwrap() {
            Stored::Words(plane) => assert_eq!(plane.pixels(), [[258, 772, 1286, 65535]]),
            Stored::Bytes(_) => panic!("sixteen bits expected"),
        }
    }

    #[test]
    fn the_recipe_comes_back() {
        let plane = Plane::filled(3, 2, 7u8);
        let recipe = "version = 1\nink = \"noir é\"";
        let bytes = write_png_grey(&plane, Some(recipe)).unwrap();
        assert_eq!(read_png_recipe(&bytes, "a.png").unwrap().as_deref(), Some(recipe));
        let bare = write_png_grey(&plane, None).unwrap();
        assert_eq!(read_png_recipe(&bare, "a.png").unwrap(), None);
        assert!(read_png_recipe(b"not a picture", "a.png").is_err());
    }

    #[test]
    fn an_empty_plane_is_no_picture() {
        let error = write_png_grey(&Plane::filled(0, 3, 0), None).unwrap_err();
        assert!(matches!(error, Error::Setting { .. }));
    }

    #[test]
    fn a_small_file_that_claims_to_be_huge_is_refused_at_its_header() {
        let mut bytes = write_png_grey(&Plane::filled(4, 4, 0), None).unwrap();
        bytes[16..24].copy_from_slice(&[0, 0, 0x3F, 0xFF, 0, 0, 0x3F, 0xFF]);
        let crc = crc_of(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&crc.to_be_bytes());
        let message = decode(&bytes, "a.png", &Limits::default()).err().unwrap().to_string();
        assert!(message.contains("cannot hold"), "{message}");
        let tight = Limits { pixels: 1000, bytes: 1 << 30 };
        let error = decode(&bytes, "a.png", &tight).err().unwrap();
        assert!(matches!(error, Error::Limit { .. }), "{error}");
    }

    /// The checksum of a PNG chunk.
    fn crc_of(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0u32, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |c, _| {
                (c >> 1) ^ (0xEDB8_8320 & (c & 1).wrapping_neg())
            })
        })
    }
}
