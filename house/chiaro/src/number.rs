//! Numbers as users type them: sizes, frame lists, points.

use chiaro_basis::{Error, Result};

/// The longest side of a picture, in pixels.
pub const LONGEST_SIDE: usize = 32_768;
/// The most pixels of a picture.
pub const MOST_PIXELS: usize = 160_000_000;
/// The most frames of a film.
const MOST_FRAMES: usize = 1_000_000;

/// A picture size, as in `1920x1080`.
pub fn parse_size(text: &str) -> Result<(usize, usize)> {
    let range = || {
        format!(
            "WIDTHxHEIGHT in pixels, each from 1 to {LONGEST_SIDE}, as in 1920x1080, {} megapixels at most",
            MOST_PIXELS / 1_000_000
        )
    };
    let fail = || Error::setting("--size", text, range());
    let (w, h) = text.split_once(['x', 'X']).ok_or_else(fail)?;
    let side = |s: &str| s.trim().parse::<usize>().ok().filter(|n| (1..=LONGEST_SIDE).contains(n));
    let (w, h) = (side(w).ok_or_else(fail)?, side(h).ok_or_else(fail)?);
    if w * h > MOST_PIXELS { Err(fail()) } else { Ok((w, h)) }
}

/// A list of frames: `7`, `1-48`, `1-100x2`, and such with commas between. Sorted, without doubles.
pub fn parse_frames(option: &str, text: &str) -> Result<Vec<u32>> {
    let fail = || {
        Error::setting(option, text, "frames from 1 on, as in 7, 1-48, 1-100x2 or 1-10,20,30-40")
    };
    let mut frames = Vec::new();
    for part in text.split(',') {
        let (first, last, step) = parse_range(part.trim()).ok_or_else(fail)?;
        if first == 0 || last < first || step == 0 {
            return Err(fail());
        }
        let count = ((last - first) / step + 1) as usize;
        if frames.len() + count > MOST_FRAMES {
            return Err(Error::setting(option, text, format!("at most {MOST_FRAMES} frames")));
        }
        frames.extend((first..=last).step_by(step as usize));
    }
    frames.sort_unstable();
    frames.dedup();
    Ok(frames)
}

fn parse_range(part: &str) -> Option<(u32, u32, u32)> {
    let (range, step) = match part.split_once('x') {
        Some((range, step)) => (range, step.parse().ok()?),
        None => (part, 1),
    };
    match range.split_once('-') {
        Some((a, b)) => Some((a.trim().parse().ok()?, b.trim().parse().ok()?, step)),
        None => {
            let one = range.parse().ok()?;
            Some((one, one, step))
        }
    }
}

/// `N` finite numbers with commas between.
pub fn parse_numbers<const N: usize>(option: &str, text: &str, what: &str) -> Result<[f32; N]> {
    let fail = || Error::setting(option, text, what);
    let numbers: Option<Vec<f32>> =
        text.split(',').map(|s| s.trim().parse::<f32>().ok().filter(|x| x.is_finite())).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(fail)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_lists_read_as_documented() {
        let read = |t| parse_frames("--frames", t).unwrap();
        assert_eq!(read("7"), [7]);
        assert_eq!(read("1-4"), [1, 2, 3, 4]);
        assert_eq!(read("1-6x2, 10,3"), [1, 3, 5, 10]);
        for bad in ["", "0", "5-2", "a", "1-", "1-3x0", "1-4000000000", "-3", "1.5"] {
            assert!(parse_frames("--frames", bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes_have_bounds() {
        assert_eq!(parse_size("1920x1080").unwrap(), (1920, 1080));
        for bad in ["0x0", "100000x100000", "640", "ax4", "-1x4", "32768x32768", "1e3x4", "4x"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }
}
