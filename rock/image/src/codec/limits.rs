//! How large a picture may be, checked before any memory is asked for, and the errors that every
//! decoder shares.

use chiaro_basis::{Error, Result};

/// How much a picture may unpack to. The default suits a film frame of any size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Width times height, at most.
    pub pixels: u64,
    /// Bytes of all planes handed back, at most. A decoder may need as much again while it works.
    pub bytes: u64,
}

impl Default for Limits {
    /// 2^28 pixels (16384 x 16384) and 4 GiB.
    fn default() -> Self {
        Self { pixels: 1 << 28, bytes: 1 << 32 }
    }
}

impl Limits {
    /// [`Error::Input`] for a picture without pixels, [`Error::Limit`] for one with too many, or
    /// with too many bytes at `bytes_per_pixel`.
    pub(super) fn check(
        &self,
        name: &str,
        (width, height): (u64, u64),
        bytes_per_pixel: u64,
    ) -> Result<()> {
        if width == 0 || height == 0 {
            let why =
                format!("the picture is {width} x {height} pixels; nothing can be seen in it");
            return Err(Error::input(name, "", why));
        }
        let pixels = width.saturating_mul(height);
        if pixels > self.pixels {
            let need = format!("{width} x {height} = {pixels} pixels");
            return Err(too_much(name, need, format!("{} pixels", self.pixels)));
        }
        let bytes = pixels.saturating_mul(bytes_per_pixel);
        if bytes > self.bytes {
            let need = format!("{bytes} bytes for {width} x {height} pixels");
            return Err(too_much(name, need, format!("{} bytes", self.bytes)));
        }
        Ok(())
    }
}

fn too_much(name: &str, need: String, have: String) -> Error {
    Error::limit(format!("{name} (scale it down, or raise the limit)"), need, have)
}

/// [`Error::Input`] when `bytes` of packed data cannot possibly unpack to `unpacked` bytes, at up
/// to `ratio` bytes for each one. A short file that claims to be huge stops here.
pub(super) fn check_plausible(name: &str, bytes: usize, unpacked: u64, ratio: u64) -> Result<()> {
    // Headers and the like may outweigh the pixels of a tiny picture.
    let most = (bytes as u64).saturating_mul(ratio).saturating_add(1 << 12);
    if unpacked <= most {
        return Ok(());
    }
    let why = format!("{bytes} bytes cannot hold the {unpacked} bytes of pixels that it announces");
    Err(Error::input(name, "", why + "; the file is cut short or damaged"))
}

/// [`Error::Input`] for data that a library cannot decode, with its reason on one line.
pub(super) fn damaged(name: &str, format: &str, why: impl std::fmt::Display) -> Error {
    let why = one_line(why);
    let sentence = format!("the {format} data cannot be read ({why}); save the picture again");
    Error::input(name, "", sentence)
}

/// Text that may quote a hostile file, without line breaks and other control characters.
pub(super) fn one_line(text: impl std::fmt::Display) -> String {
    let text = text.to_string().replace(|c: char| c.is_control(), " ");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_checked_without_overflow() {
        let limits = Limits { pixels: 100, bytes: 1000 };
        assert!(limits.check("a", (10, 10), 10).is_ok());
        assert!(matches!(limits.check("a", (0, 10), 1), Err(Error::Input { .. })));
        assert!(matches!(limits.check("a", (10, 11), 1), Err(Error::Limit { .. })));
        assert!(matches!(limits.check("a", (10, 10), 11), Err(Error::Limit { .. })));
        assert!(matches!(limits.check("a", (u64::MAX, 3), 4), Err(Error::Limit { .. })));
        assert!(check_plausible("a", 100, 1 << 40, 1032).is_err());
        assert!(check_plausible("a", usize::MAX, u64::MAX, u64::MAX).is_ok());
    }
}
