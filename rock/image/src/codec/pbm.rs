//! PBM, the plainest bitmap: the raw kind P4, one bit a pixel, rows padded to bytes.
//!
//! In PBM a set bit is black; in chiaro's labels `true` is white.

use super::Limits;
use crate::Plane;
use chiaro_basis::{Error, Result};

/// A raw PBM: `true` is white.
pub fn write_pbm(plane: &Plane<bool>) -> Vec<u8> {
    let mut bytes = format!("P4\n{} {}\n", plane.width(), plane.height()).into_bytes();
    bytes.extend(pack_bits(plane, |white| !white));
    bytes
}

/// Rows of bits, the leftmost pixel in the highest bit, padded with zeros to whole bytes.
pub(super) fn pack_bits(plane: &Plane<bool>, set: impl Fn(bool) -> bool) -> Vec<u8> {
    let pack = |eight: &[bool]| {
        eight.iter().enumerate().fold(0, |byte, (i, &v)| byte | (u8::from(set(v)) << (7 - i)))
    };
    (0..plane.height()).flat_map(|y| plane.row(y).chunks(8).map(pack)).collect()
}

/// Reads a raw PBM: black becomes `false`, white `true`. Further pictures in the file are not
/// looked at.
///
/// # Errors
/// [`Error::Input`] when the bytes are not a whole raw PBM, [`Error::Limit`] when it is too large.
pub fn read_pbm(bytes: &[u8], name: &str, limits: &Limits) -> Result<Plane<bool>> {
    let wrong = |why: &str| Error::input(name, "", why);
    let mut rest = bytes
        .strip_prefix(b"P4")
        .ok_or_else(|| wrong("not a raw PBM picture; save it as PBM of kind P4"))?;
    let mut side = || read_number(&mut rest).ok_or_else(|| wrong("the PBM header has no size"));
    let (width, height) = (side()?, side()?);
    let data = rest
        .split_first()
        .filter(|(space, _)| space.is_ascii_whitespace())
        .map(|(_, data)| data)
        .ok_or_else(|| wrong("the PBM header does not end; save the picture again"))?;
    limits.check(name, (width, height), 1)?;
    if (data.len() as u64) < width.div_ceil(8) * height {
        return Err(wrong("the PBM data is cut short; save the picture again"));
    }
    let stride = width.div_ceil(8) as usize;
    let white = |x: usize, y: usize| data[y * stride + x / 8] & (0x80 >> (x % 8)) == 0;
    Ok(Plane::from_fn(width as usize, height as usize, white))
}

/// The next number in a PBM header, past white space and comments; `rest` goes on behind it.
fn read_number(rest: &mut &[u8]) -> Option<u64> {
    loop {
        *rest = rest.trim_ascii_start();
        if rest.first() != Some(&b'#') {
            break;
        }
        let end = rest.iter().position(|&b| b == b'\n' || b == b'\r')?;
        *rest = &rest[end..];
    }
    let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    let (number, after) = rest.split_at(digits);
    *rest = after;
    std::str::from_utf8(number).ok()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_survive_the_round_trip() {
        for width in [1, 7, 8, 9, 30] {
            let plane = Plane::from_fn(width, 5, |x, y| (x * x + y) % 3 == 0);
            let bytes = write_pbm(&plane);
            assert_eq!(read_pbm(&bytes, "a.pbm", &Limits::default()).unwrap(), plane);
        }
    }

    #[test]
    fn black_is_one_and_the_leftmost_pixel_the_highest_bit() {
        let plane = Plane::from_pixels(3, 1, vec![false, true, true]);
        assert_eq!(write_pbm(&plane), b"P4\n3 1\n\x80");
    }

    #[test]
    fn headers_may_hold_comments() {
        let bytes = b"P4 # made by hand\n# twice\n 2\t1\n\x40";
        let plane = read_pbm(bytes, "a.pbm", &Limits::default()).unwrap();
        assert_eq!(plane.pixels(), [true, false]);
    }

    #[test]
    fn wrong_headers_are_one_sentence() {
        let limits = Limits { pixels: 1 << 20, bytes: 1 << 20 };
        for bytes in [
            &b"P1\n1 1\n1"[..],
            b"P4",
            b"P4\n1",
            b"P4\n0 1\n",
            b"P4\n1 1",
            b"P4\n9 1\n\x00",
            b"P4\n99999999999999999999 1\n",
            b"P4\n4294967295 4294967295\n",
            b"P4 #",
        ] {
            let message = read_pbm(bytes, "a.pbm", &limits).unwrap_err().to_string();
            assert!(message.starts_with("a.pbm"), "{message}");
        }
    }
}
