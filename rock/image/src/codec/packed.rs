//! [`Pictures`]: a film's pictures one at a time, and [`Packed`] ones, so that a film that becomes one file need
//! not be in memory as pixels.

use crate::Plane;
use png::{BitDepth, ColorType, Compression, Decoder, Encoder};
use std::borrow::Cow;
use std::io::Cursor;

/// The RGBA pictures of a film, sRGB-encoded.
pub trait Pictures: Sync {
    /// How many.
    fn count(&self) -> usize;

    /// Width and height of a picture.
    fn size(&self, k: usize) -> (usize, usize);

    /// A picture.
    fn picture(&self, k: usize) -> Cow<'_, Plane<[u8; 4]>>;
}

impl Pictures for Vec<Plane<[u8; 4]>> {
    fn count(&self) -> usize {
        self.len()
    }

    fn size(&self, k: usize) -> (usize, usize) {
        self[k].size()
    }

    fn picture(&self, k: usize) -> Cow<'_, Plane<[u8; 4]>> {
        Cow::Borrowed(&self[k])
    }
}

impl Pictures for Vec<Packed> {
    fn count(&self) -> usize {
        self.len()
    }

    fn size(&self, k: usize) -> (usize, usize) {
        self[k].size
    }

    fn picture(&self, k: usize) -> Cow<'_, Plane<[u8; 4]>> {
        self[k].open()
    }
}

/// A picture without loss in little memory: drawings take some hundredths of their pixels.
#[derive(Clone, Debug)]
pub struct Packed {
    size: (usize, usize),
    pixels: Pixels,
}

#[derive(Clone, Debug)]
enum Pixels {
    Png(Vec<u8>),
    /// Those of sizes that PNG has not.
    Plain(Plane<[u8; 4]>),
}

impl Packed {
    /// Packs a picture.
    pub fn of(picture: Plane<[u8; 4]>) -> Self {
        let size = picture.size();
        match packed(&picture) {
            Ok(bytes) => Self { size, pixels: Pixels::Png(bytes) },
            Err(_) => Self { size, pixels: Pixels::Plain(picture) },
        }
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        match &self.pixels {
            Pixels::Png(bytes) => bytes.len(),
            Pixels::Plain(plane) => 4 * plane.pixels().len(),
        }
    }

    /// The picture.
    pub fn open(&self) -> Cow<'_, Plane<[u8; 4]>> {
        match &self.pixels {
            Pixels::Png(bytes) => Cow::Owned(unpacked(bytes, self.size)),
            Pixels::Plain(plane) => Cow::Borrowed(plane),
        }
    }
}

fn packed(picture: &Plane<[u8; 4]>) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let (width, height) = picture.size();
    let mut encoder = Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(picture.pixels().as_flattened())?;
    writer.finish()?;
    Ok(bytes)
}

fn unpacked(bytes: &[u8], (width, height): (usize, usize)) -> Plane<[u8; 4]> {
    let mut data = vec![0; 4 * width * height];
    let mut reader = Decoder::new(Cursor::new(bytes)).read_info().expect("it was written here");
    reader.next_frame(&mut data).expect("it was written here");
    let pixels = data.as_chunks::<4>().0;
    Plane::from_fn(width, height, |x, y| pixels[y * width + x])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_pictures_come_back() {
        let line = |x: usize, y: usize| if x == y { [9, 8, 7, 200] } else { [255; 4] };
        let picture = Plane::from_fn(200, 100, line);
        let packed = Packed::of(picture.clone());
        assert_eq!(*packed.open(), picture);
        assert!(packed.bytes() < 4 * 200 * 100 / 20, "{}", packed.bytes());
        let nothing: Plane<[u8; 4]> = Plane::default();
        assert_eq!(*Packed::of(nothing.clone()).open(), nothing);
    }
}
