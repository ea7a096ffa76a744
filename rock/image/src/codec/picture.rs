//! Any picture a user hands over, told by its first bytes, never by its name.

use super::limits::one_line;
use super::png::{self, Stored};
use super::{ExrImage, Limits, jpeg, read_exr};
use crate::Plane;
use crate::colour::srgb_decode;
use chiaro_basis::{Error, Result};

/// A kind of picture file that chiaro reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Portable Network Graphics.
    Png,
    /// JPEG, in JFIF, Exif or bare.
    Jpeg,
    /// OpenEXR.
    Exr,
    /// Raw portable bitmap, P4.
    Pbm,
    /// Radiance HDR.
    Hdr,
}

impl Format {
    /// The format that the first bytes of a file announce.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let announced: [(&[u8], Self); 5] = [
            (b"\x89PNG\r\n\x1a\n", Self::Png),
            (b"\xFF\xD8\xFF", Self::Jpeg),
            (b"\x76\x2F\x31\x01", Self::Exr),
            (b"P4", Self::Pbm),
            (b"#?", Self::Hdr),
        ];
        announced.iter().find(|(magic, _)| bytes.starts_with(magic)).map(|(_, format)| *format)
    }
}

/// Decodes a PNG or JPEG into red, green, blue, alpha as stored: sRGB-encoded, alpha not
/// multiplied in. Palettes, grey and CMYK are converted, 16 bits rounded to 8; profiles and camera
/// orientation are not applied.
///
/// # Errors
/// [`Error::Input`] when the bytes are no whole PNG or JPEG, [`Error::Limit`] when the picture is
/// larger than `limits`; both name the file by `name`.
pub fn read_picture(bytes: &[u8], name: &str, limits: &Limits) -> Result<Plane<[u8; 4]>> {
    match decode(bytes, name, limits)? {
        Stored::Bytes(plane) => Ok(plane),
        Stored::Words(plane) => Ok(plane.map(|p| p.map(|v| ((u32::from(v) + 128) / 257) as u8))),
    }
}

/// [`read_picture`] with components in [0, 1] at the file's full precision, 8 or 16 bits: for
/// normal maps and depth, whose components are not colours. Errors as there.
pub fn read_components(bytes: &[u8], name: &str, limits: &Limits) -> Result<Plane<[f32; 4]>> {
    let room = Limits { bytes: limits.bytes / 2, ..*limits };
    match decode(bytes, name, &room)? {
        Stored::Bytes(plane) => Ok(plane.map(|p| p.map(|v| f32::from(v) / 255.0))),
        Stored::Words(plane) => Ok(plane.map(|p| p.map(|v| f32::from(v) / 65535.0))),
    }
}

/// The picture in a PNG, JPEG, OpenEXR or Radiance HDR file as linear light, Rec. 709 red, green and blue
/// multiplied by alpha, and alpha: one convention, so that pictures of different kinds compare.
/// For what counts as the picture in an OpenEXR file see [`ExrImage::colour`].
///
/// # Errors
/// As [`read_picture`], and [`Error::Input`] when an OpenEXR file holds no colours.
///
/// [`ExrImage::colour`]: super::ExrImage::colour
pub fn read_colour(bytes: &[u8], name: &str, limits: &Limits) -> Result<Plane<[f32; 4]>> {
    if Format::of(bytes) == Some(Format::Exr) {
        let image = read_exr(bytes, name, limits)?;
        return image.colour().ok_or_else(|| no_colour(name, &image));
    }
    if Format::of(bytes) == Some(Format::Hdr) {
        return Ok(super::read_hdr(bytes, name, limits)?.map(|&[r, g, b]| [r, g, b, 1.0]));
    }
    let encoded = read_components(bytes, name, limits)?;
    Ok(encoded.map(|&[r, g, b, a]| {
        let [r, g, b] = [r, g, b].map(|c| srgb_decode(c) * a);
        [r, g, b, a]
    }))
}

fn no_colour(name: &str, image: &ExrImage) -> Error {
    let names: Vec<&str> = image.layers.iter().map(|(name, _)| name.as_str()).take(8).collect();
    let why = format!(
        "there are no channels R, G and B, nor Y, among {}; add the combined pass to the file",
        one_line(names.join(", "))
    );
    Error::input(name, "", why)
}

fn decode(bytes: &[u8], name: &str, limits: &Limits) -> Result<Stored> {
    match Format::of(bytes) {
        Some(Format::Png) => png::decode(bytes, name, limits),
        Some(Format::Jpeg) => jpeg::decode(bytes, name, limits).map(Stored::Bytes),
        _ => Err(Error::input(name, "", format!("{}; save it as PNG or JPEG", kind(bytes)))),
    }
}

/// What a file that is neither PNG nor JPEG seems to be.
fn kind(bytes: &[u8]) -> &'static str {
    let announced: [(&[u8], &str); 9] = [
        (b"\x76\x2F\x31\x01", "this is an OpenEXR file, which holds no bytes of colour"),
        (b"P4", "this is a PBM bitmap, which has no colours"),
        (b"GIF8", "GIF pictures are not read"),
        (b"RIFF", "WebP pictures are not read"),
        (b"II*\0", "TIFF pictures are not read"),
        (b"MM\0*", "TIFF pictures are not read"),
        (b"BM", "BMP pictures are not read"),
        (b"#?RADIANCE", "this is a Radiance HDR picture, which holds no bytes of colour"),
        (b"<", "this is text, perhaps SVG or a web page"),
    ];
    let found = announced.iter().find(|(magic, _)| bytes.starts_with(magic));
    found.map_or("this is not a picture in a format that chiaro reads", |(_, kind)| *kind)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::ExrChannel;

    #[test]
    fn sixteen_bits_round_to_eight_and_stay_whole_as_components() {
        let mut bytes = Vec::new();
        let mut encoder = ::png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(::png::ColorType::Grayscale);
        encoder.set_depth(::png::BitDepth::Sixteen);
        let data = [0x80, 0x00, 0x81, 0x01];
        encoder.write_header().unwrap().write_image_data(&data).unwrap();
        let limits = Limits::default();
        let plane = read_picture(&bytes, "a.png", &limits).unwrap();
        assert_eq!(plane.pixels(), [[128, 128, 128, 255], [129, 129, 129, 255]]);
        let fine = read_components(&bytes, "a.png", &limits).unwrap();
        assert_eq!(fine[(1, 0)][0], 33025.0 / 65535.0);
    }

    #[test]
    fn colours_of_every_kind_are_linear_and_multiplied_by_alpha() {
        let limits = Limits::default();
        let plane = Plane::filled(1, 1, [255, 188, 0, 51]);
        let png = crate::codec::write_png_rgba(&plane, None).unwrap();
        let [r, g, b, a] = read_colour(&png, "a.png", &limits).unwrap()[(0, 0)];
        assert!((r - 0.2).abs() < 1e-6 && (g - 0.1).abs() < 1e-3 && b == 0.0 && a == 0.2);
        let names = ["R", "G", "B", "A"];
        let channel = |i: usize| ExrChannel::F32(Plane::filled(1, 1, [r, g, b, a][i]));
        let layers = (0..4).map(|i| (names[i].to_string(), channel(i))).collect();
        let image = ExrImage { size: (1, 1), layers, ..ExrImage::default() };
        let exr = crate::codec::write_exr(&image).unwrap();
        assert_eq!(read_colour(&exr, "a.exr", &limits).unwrap()[(0, 0)], [r, g, b, a]);
        let depth = ExrImage { layers: vec![("depth.Z".into(), channel(0))], ..image };
        let exr = crate::codec::write_exr(&depth).unwrap();
        let message = read_colour(&exr, "a.exr", &limits).unwrap_err().to_string();
        assert!(message.contains("among depth.Z;"), "{message}");
    }

    #[test]
    fn what_is_not_read_is_named() {
        let message = |bytes: &[u8]| {
            read_picture(bytes, "a.gif", &Limits::default()).unwrap_err().to_string()
        };
        assert_eq!(
            message(b"GIF89a..."),
            "a.gif: GIF pictures are not read; save it as PNG or JPEG"
        );
        assert!(message(b"").contains("not a picture"));
    }
}
