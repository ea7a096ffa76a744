//! Radiance pictures (.hdr): red, green and blue with a common exponent, in scan lines that may be
//! run-length encoded. After G. Ward, "Real Pixels" (Graphics Gems II), and Radiance's file notes.
//!
//! Read: both run-length schemes and plain pixels, the usual orientation `-Y height +X width`.
//! Not read: other orientations, XYZ pictures.

use super::Limits;
use super::limits::damaged;
use crate::Plane;
use chiaro_basis::{Error, Result};

/// The linear colours of a Radiance picture.
///
/// # Errors
/// [`Error::Input`] when the bytes are no whole picture of that kind, [`Error::Limit`] when it is
/// larger than `limits`; both name the file by `name`.
pub fn read_hdr(bytes: &[u8], name: &str, limits: &Limits) -> Result<Plane<[f32; 3]>> {
    let (width, height, start) = header(bytes, name)?;
    limits.check(name, (width as u64, height as u64), 16)?;
    // A run of 127 pixels takes 8 bytes at the least.
    super::limits::check_plausible(name, bytes.len(), width as u64 * height as u64 * 4, 128)?;
    let mut reader = Reader { bytes, at: start, name };
    let mut pixels = Vec::with_capacity(width * height);
    for _ in 0..height {
        let line = reader.line(width)?;
        pixels.extend(line.into_iter().map(linear));
    }
    Ok(Plane::from_pixels(width, height, pixels))
}

/// Width, height and where the pixels begin.
fn header(bytes: &[u8], name: &str) -> Result<(usize, usize, usize)> {
    let fail = |why: &str| damaged(name, "HDR", why);
    let mut at = 0;
    let mut line = || {
        let rest = bytes.get(at..)?;
        let length = rest.iter().take(4096).position(|b| *b == b'\n')?;
        at += length + 1;
        Some((String::from_utf8_lossy(&rest[..length]).into_owned(), at))
    };
    let (first, _) = line().ok_or_else(|| fail("no header"))?;
    if !first.starts_with("#?") {
        return Err(fail("it does not begin with #?RADIANCE"));
    }
    for _ in 0..1000 {
        let (text, _) = line().ok_or_else(|| fail("the header does not end"))?;
        if text.trim().is_empty() {
            let (size, start) = line().ok_or_else(|| fail("no size"))?;
            let words: Vec<&str> = size.split_whitespace().collect();
            let ["-Y", h, "+X", w] = words.as_slice() else {
                return Err(fail("its orientation is not -Y +X"));
            };
            let side = |s: &str| s.parse::<usize>().ok().filter(|n| (1..1 << 20).contains(n));
            let (Some(w), Some(h)) = (side(w), side(h)) else {
                return Err(fail("its size is no number"));
            };
            return Ok((w, h, start));
        }
        if text.starts_with("FORMAT=") && !text.contains("32-bit_rle_rgbe") {
            return Err(fail("its colours are not RGBE"));
        }
    }
    Err(fail("the header does not end"))
}

fn linear([r, g, b, e]: [u8; 4]) -> [f32; 3] {
    if e == 0 {
        return [0.0; 3];
    }
    let scale = (f32::from(e) - 136.0).exp2();
    [r, g, b].map(|c| (f32::from(c) + 0.5) * scale)
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    name: &'a str,
}

impl Reader<'_> {
    fn short(&self) -> Error {
        damaged(self.name, "HDR", "it ends early or a run is too long")
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N]> {
        let taken = self.bytes.get(self.at..self.at + N).ok_or_else(|| self.short())?;
        self.at += N;
        Ok(taken.try_into().expect("a slice of N bytes"))
    }

    fn line(&mut self, width: usize) -> Result<Vec<[u8; 4]>> {
        let first = self.take::<4>()?;
        let announced = usize::from(first[2]) << 8 | usize::from(first[3]);
        if first[0] == 2 && first[1] == 2 && first[2] < 128 && announced == width {
            self.planar_runs(width)
        } else {
            self.at -= 4;
            self.pixels_with_repeats(width)
        }
    }

    /// Each component's runs, one component after the other.
    fn planar_runs(&mut self, width: usize) -> Result<Vec<[u8; 4]>> {
        let mut line = vec![[0u8; 4]; width];
        for component in 0..4 {
            let mut x = 0;
            while x < width {
                let [count] = self.take::<1>()?;
                let (length, run) = match count {
                    129.. => (usize::from(count - 128), Some(self.take::<1>()?[0])),
                    _ => (usize::from(count), None),
                };
                if length == 0 || x + length > width {
                    return Err(self.short());
                }
                for pixel in &mut line[x..x + length] {
                    pixel[component] = match run {
                        Some(value) => value,
                        None => self.take::<1>()?[0],
                    };
                }
                x += length;
            }
        }
        Ok(line)
    }

    /// Pixels one after the other; 1, 1, 1, n repeats the one before.
    fn pixels_with_repeats(&mut self, width: usize) -> Result<Vec<[u8; 4]>> {
        let mut line: Vec<[u8; 4]> = Vec::with_capacity(width);
        let mut shift = 0;
        while line.len() < width {
            let pixel = self.take::<4>()?;
            match (pixel, line.last().copied()) {
                ([1, 1, 1, n], Some(last)) => {
                    let count = usize::from(n) << shift;
                    if shift > 16 || count > width - line.len() {
                        return Err(self.short());
                    }
                    line.extend(std::iter::repeat_n(last, count));
                    shift += 8;
                }
                _ => {
                    line.push(pixel);
                    shift = 0;
                }
            }
        }
        Ok(line)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random;

    fn file(size: &str, pixels: &[u8]) -> Vec<u8> {
        let mut f = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n".to_vec();
        f.extend(size.as_bytes());
        f.push(b'\n');
        f.extend(pixels);
        f
    }

    fn read(bytes: &[u8]) -> Result<Plane<[f32; 3]>> {
        read_hdr(bytes, "a.hdr", &Limits::default())
    }

    #[test]
    fn plain_pixels_repeats_and_runs_read_alike() {
        let plain = file("-Y 1 +X 8", &[[128, 64, 32, 129]; 8].concat());
        let repeated = file("-Y 1 +X 8", &[128, 64, 32, 129, 1, 1, 1, 7]);
        let runs = file("-Y 1 +X 8", &[2, 2, 0, 8, 136, 128, 136, 64, 136, 32, 136, 129]);
        let p = read(&plain).unwrap();
        assert!((p[(7, 0)][0] - 128.5 / 128.0).abs() < 1e-6);
        assert_eq!(p, read(&repeated).unwrap());
        assert_eq!(p, read(&runs).unwrap());
    }

    #[test]
    fn damaged_files_are_one_sentence() {
        let whole =
            file("-Y 4 +X 8", &[2, 2, 0, 8, 136, 128, 136, 64, 136, 32, 136, 129].repeat(4));
        assert!(read(&whole).is_ok());
        for end in 0..whole.len() {
            assert!(read(&whole[..end]).is_err(), "{end}");
        }
        for i in 0..2000u64 {
            let mut broken = whole.clone();
            let at = random::hash(1, i) as usize % broken.len();
            broken[at] = random::hash(2, i) as u8;
            let _ = read(&broken);
        }
        let huge = file("-Y 900000 +X 900000", &[0; 64]);
        assert!(read(&huge).unwrap_err().to_string().contains("a.hdr"));
    }
}
