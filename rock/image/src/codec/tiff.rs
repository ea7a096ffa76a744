//! TIFF with CCITT Group 4 compression: one bit a pixel, as printers and plate makers take it.
//!
//! Little-endian, strips of 512 rows, white as 0, so that the compression's runs of white are
//! white; the resolution in dots an inch and the recipe as the image description. Only the coding
//! of the lines is the `fax` library's. Format: *TIFF revision 6.0*, Adobe 1992; ITU-T T.6.

use crate::Plane;
use fax::encoder::Encoder;
use fax::{Color, VecWriter};
use rayon::prelude::*;

/// Rows that are compressed together, strips in parallel.
const STRIP: usize = 512;

/// One bit a pixel, white where true, at `dpi` dots an inch, with a recipe if there is one.
pub fn write_tiff_bits(white: &Plane<bool>, dpi: f64, recipe: Option<&str>) -> Vec<u8> {
    let strips: Vec<Vec<u8>> = (0..white.height().div_ceil(STRIP))
        .into_par_iter()
        .map(|i| strip(white, i * STRIP, ((i + 1) * STRIP).min(white.height())))
        .collect();
    let mut file = b"II*\0\0\0\0\0".to_vec();
    let mut starts = Vec::new();
    for strip in &strips {
        starts.push(file.len() as u32);
        file.extend_from_slice(strip);
    }
    let mut directory = Directory { file, entries: Vec::new() };
    let side = |n: usize| n as u32;
    directory.long(256, &[side(white.width())]);
    directory.long(257, &[side(white.height())]);
    directory.short(258, 1);
    directory.short(259, 4);
    directory.short(262, 0);
    if let Some(recipe) = recipe {
        directory.text(270, recipe);
    }
    directory.long(273, &starts);
    directory.short(277, 1);
    directory.long(278, &[STRIP as u32]);
    directory.long(279, &strips.iter().map(|s| s.len() as u32).collect::<Vec<_>>());
    directory.ratio(282, dpi);
    directory.ratio(283, dpi);
    directory.short(296, 2);
    directory.text(305, "chiaro");
    directory.finish()
}

/// Rows of a picture, Group 4.
fn strip(white: &Plane<bool>, from: usize, to: usize) -> Vec<u8> {
    let mut encoder = Encoder::new(VecWriter::new());
    for y in from..to {
        let colours = white.row(y).iter().map(|w| if *w { Color::White } else { Color::Black });
        // A vector takes all bits.
        let Ok(()) = encoder.encode_line(colours, white.width() as u32);
    }
    let Ok(writer) = encoder.finish();
    writer.finish()
}

/// The tags of a picture, written in ascending order; what does not fit into an entry goes before
/// the directory.
struct Directory {
    file: Vec<u8>,
    entries: Vec<[u8; 12]>,
}

impl Directory {
    fn entry(&mut self, tag: u16, kind: u16, count: usize, bytes: &[u8]) {
        let mut entry = [0; 12];
        entry[..2].copy_from_slice(&tag.to_le_bytes());
        entry[2..4].copy_from_slice(&kind.to_le_bytes());
        entry[4..8].copy_from_slice(&(count as u32).to_le_bytes());
        if bytes.len() <= 4 {
            entry[8..8 + bytes.len()].copy_from_slice(bytes);
        } else {
            self.align();
            entry[8..].copy_from_slice(&(self.file.len() as u32).to_le_bytes());
            self.file.extend_from_slice(bytes);
        }
        self.entries.push(entry);
    }

    fn align(&mut self) {
        if self.file.len() % 2 == 1 {
            self.file.push(0);
        }
    }

    fn short(&mut self, tag: u16, value: u16) {
        self.entry(tag, 3, 1, &value.to_le_bytes());
    }

    fn long(&mut self, tag: u16, values: &[u32]) {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.entry(tag, 4, values.len(), &bytes);
    }

    fn ratio(&mut self, tag: u16, value: f64) {
        let parts = [(value.clamp(0.0, 4e6) * 1000.0).round() as u32, 1000];
        let bytes: Vec<u8> = parts.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.entry(tag, 5, 1, &bytes);
    }

    /// Seven-bit text, as the format has it; other characters become question marks.
    fn text(&mut self, tag: u16, text: &str) {
        let ascii = |c: char| if c.is_ascii() && c != '\0' { c as u8 } else { b'?' };
        let mut bytes: Vec<u8> = text.chars().map(ascii).collect();
        bytes.push(0);
        self.entry(tag, 2, bytes.len(), &bytes);
    }

    fn finish(mut self) -> Vec<u8> {
        self.align();
        let start = self.file.len() as u32;
        self.file[4..8].copy_from_slice(&start.to_le_bytes());
        self.file.extend_from_slice(&(self.entries.len() as u16).to_le_bytes());
        self.entries.iter().for_each(|e| self.file.extend_from_slice(e));
        self.file.extend_from_slice(&[0; 4]);
        self.file
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The value, or its place, of a tag.
    fn tag(file: &[u8], wanted: u16) -> (usize, usize) {
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        let directory = word(4);
        let count = usize::from(u16::from_le_bytes([file[directory], file[directory + 1]]));
        let at = (0..count).map(|i| directory + 2 + 12 * i);
        let is = |a: &usize| u16::from_le_bytes([file[*a], file[a + 1]]) == wanted;
        let at = at.into_iter().find(is).unwrap();
        (word(at + 4), word(at + 8))
    }

    #[test]
    fn what_is_written_decodes_to_the_same_pixels() {
        for (w, h) in [(1, 1), (9, 3), (1, 700), (301, 40)] {
            let white = Plane::from_fn(w, h, |x, y| (x * x / 7 + y * y / 5) % 3 != 0);
            let file = write_tiff_bits(&white, 600.0, Some("{\"a\":1}"));
            assert_eq!((tag(&file, 256).1, tag(&file, 257).1), (w, h));
            let (strips, starts) = tag(&file, 273);
            let start = if strips == 1 {
                starts
            } else {
                u32::from_le_bytes(file[starts..starts + 4].try_into().unwrap()) as usize
            };
            let mut rows: Vec<Vec<bool>> = Vec::new();
            let bytes = file[start..].iter().copied();
            fax::decoder::decode_g4(bytes, w as u32, Some(h.min(STRIP) as u32), |line| {
                rows.push(fax::decoder::pels(line, w as u32).map(|c| c == Color::White).collect());
            })
            .unwrap();
            let expected: Vec<Vec<bool>> =
                (0..h.min(STRIP)).map(|y| white.row(y).to_vec()).collect();
            assert_eq!(rows, expected, "{w} x {h}");
            let (length, at) = tag(&file, 270);
            assert_eq!(&file[at..at + length - 1], b"{\"a\":1}");
            let (_, at) = tag(&file, 282);
            assert_eq!(
                &file[at..at + 8],
                [600_000u32.to_le_bytes(), 1000u32.to_le_bytes()].as_flattened()
            );
        }
    }
}
