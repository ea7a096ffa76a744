//! Animated GIF: a short film for the places that play nothing else.
//!
//! 1. One palette serves the whole film, so that what stands still keeps its colour: the film's own
//!    colours where they are at most 256, else those that a self-organizing map finds in a sample
//!    of its pixels, between which a fixed pattern dithers.
//! 2. A frame is the rectangle in which it differs from the one before. Films with transparent
//!    pixels have whole frames.
//!
//! GIF counts time in hundredths of a second: frames begin at the hundredth nearest to their time,
//! so that a film keeps its length whatever its rate.

use super::packed::Pictures;
use crate::Plane;
use chiaro_basis::{Error, Result};
use color_quant::NeuQuant;
use gif::{AnyExtension, DisposalMethod, Encoder, EncodingError, Extension, Frame, Repeat};
use rayon::prelude::*;
use std::collections::{BTreeSet, HashMap};

/// The most pixels that the palette is learned on.
const SAMPLE: usize = 1 << 18;

/// Frames that are worked on at once, so that memory does not grow with the film.
const AT_ONCE: usize = 16;

/// Half the difference between the greatest and the least offset of the dither, in code values.
const DITHER: i32 = 5;

/// An endless animation of RGBA frames of one size, sRGB-encoded, `fps` frames a second (at most 50
/// are shown), with the recipe as a comment. A pixel is transparent where its alpha is under a half.
///
/// # Errors
/// [`Error::Setting`] without frames, when their sizes differ, or when a side is over 65535.
pub fn write_gif(frames: &dyn Pictures, fps: f64, recipe: Option<&str>) -> Result<Vec<u8>> {
    let count = frames.count();
    let wrong = |why: String| Error::setting("animation", format!("{count} frames"), why);
    if count == 0 {
        return Err(wrong("at least one frame".into()));
    }
    let size = frames.size(0);
    if (1..count).any(|k| frames.size(k) != size) {
        return Err(wrong("frames of one size".into()));
    }
    let side = |n: usize| u16::try_from(n).ok().filter(|n| *n > 0);
    let (Some(width), Some(height)) = (side(size.0), side(size.1)) else {
        return Err(wrong("frames of 1 to 65535 pixels a side, as GIF has them".into()));
    };
    let palette = Palette::of(frames);
    let mut bytes = Vec::new();
    let written = (|| {
        let mut encoder = Encoder::new(&mut bytes, width, height, &palette.colours)?;
        encoder.set_repeat(Repeat::Infinite)?;
        if let Some(recipe) = recipe {
            let comment = AnyExtension(Extension::Comment as u8);
            let blocks: Vec<&[u8]> = recipe.as_bytes().chunks(255).collect();
            encoder.write_raw_extension(comment, &blocks)?;
        }
        write_frames(&mut encoder, frames, &palette, fps)
    })();
    written.map_err(|e: EncodingError| wrong(format!("an animation that GIF can hold ({e})")))?;
    Ok(bytes)
}

/// Writes the frames that show something else than the one before, some at once.
fn write_frames<W: std::io::Write>(
    encoder: &mut Encoder<W>,
    frames: &dyn Pictures,
    palette: &Palette,
    fps: f64,
) -> std::result::Result<(), EncodingError> {
    let count = frames.count();
    let width = frames.size(0).0 as u16;
    // Each frame waits for the one that ends it.
    let mut waiting: Option<(usize, Frame<'static>)> = None;
    let mut last: Option<Vec<u8>> = None;
    let mut end = |waiting: Option<(usize, Frame<'static>)>, end: usize| {
        let Some((start, mut frame)) = waiting else { return Ok(()) };
        frame.delay = (hundredth(end, fps) - hundredth(start, fps)).clamp(2, 65535) as u16;
        encoder.write_lzw_pre_encoded_frame(&frame)
    };
    for first in (0..count).step_by(AT_ONCE) {
        let chunk = first..(first + AT_ONCE).min(count);
        let indices: Vec<Vec<u8>> =
            chunk.clone().into_par_iter().map(|k| palette.indices(&frames.picture(k))).collect();
        let before = |i: usize| if i == 0 { last.as_ref() } else { Some(&indices[i - 1]) };
        let shows = |i: &usize| palette.transparent.is_some() || before(*i) != Some(&indices[*i]);
        let encoded: Vec<(usize, Frame<'static>)> = (0..indices.len())
            .into_par_iter()
            .filter(shows)
            .map(|i| {
                let mut frame = palette.frame(&indices[i], before(i).map(Vec::as_slice), width);
                frame.make_lzw_pre_encoded();
                (first + i, frame)
            })
            .collect();
        for (start, frame) in encoded {
            end(waiting.replace((start, frame)), start)?;
        }
        last = indices.into_iter().next_back();
    }
    end(waiting, count)
}

/// The hundredth of a second at which frame `k` begins.
fn hundredth(k: usize, fps: f64) -> i64 {
    (k as f64 * 100.0 / fps.clamp(0.01, 50.0)).round() as i64
}

/// The colours of a film.
struct Palette {
    /// Red, green and blue of each.
    colours: Vec<u8>,
    transparent: Option<u8>,
    kind: Kind,
}

enum Kind {
    Exact(HashMap<[u8; 3], u8>),
    Learned(Box<NeuQuant>),
}

impl Palette {
    fn of(frames: &dyn Pictures) -> Self {
        let is_clear = |p: &[u8; 4]| p[3] < 128;
        let any_clear = |k| frames.picture(k).pixels().iter().any(is_clear);
        let has_clear = (0..frames.count()).into_par_iter().any(any_clear);
        let most = 256 - usize::from(has_clear);
        let mut palette = exact(frames, most).unwrap_or_else(|| learned(frames, most));
        if has_clear {
            palette.transparent = Some((palette.colours.len() / 3) as u8);
            palette.colours.extend([255; 3]);
        }
        palette
    }

    /// The index of each pixel.
    fn indices(&self, frame: &Plane<[u8; 4]>) -> Vec<u8> {
        let width = frame.width();
        let mut known: HashMap<[u8; 3], u8> = HashMap::new();
        let pixels = frame.pixels().iter().enumerate();
        pixels
            .map(|(i, &[r, g, b, a])| match (&self.kind, self.transparent) {
                (_, Some(clear)) if a < 128 => clear,
                (Kind::Exact(indices), _) => indices[&[r, g, b]],
                (Kind::Learned(map), _) => {
                    let offset = dither(i % width, i / width);
                    let [r, g, b] = [r, g, b].map(|v| (i32::from(v) + offset).clamp(0, 255) as u8);
                    let nearest = || map.index_of(&[r, g, b, 255]) as u8;
                    *known.entry([r, g, b]).or_insert_with(nearest)
                }
            })
            .collect()
    }

    /// The part of a frame that differs from the one before.
    fn frame(&self, now: &[u8], before: Option<&[u8]>, width: u16) -> Frame<'static> {
        let before = before.filter(|_| self.transparent.is_none());
        let row = usize::from(width);
        let [left, top, right, bottom] = match before {
            Some(before) => changed(now, before, row),
            None => [0, 0, row, now.len() / row],
        };
        let rows = now.chunks_exact(row).skip(top).take(bottom - top);
        Frame {
            left: left as u16,
            top: top as u16,
            width: (right - left) as u16,
            height: (bottom - top) as u16,
            transparent: self.transparent,
            dispose: match self.transparent {
                Some(_) => DisposalMethod::Background,
                None => DisposalMethod::Keep,
            },
            buffer: rows.flat_map(|r| r[left..right].iter().copied()).collect(),
            ..Frame::default()
        }
    }
}

/// A palette of the film's own colours, if there are few enough.
fn exact(frames: &dyn Pictures, most: usize) -> Option<Palette> {
    let mut found = BTreeSet::new();
    for k in 0..frames.count() {
        let mut last = None;
        for &[r, g, b, a] in frames.picture(k).pixels() {
            if a >= 128 && last != Some([r, g, b]) {
                last = Some([r, g, b]);
                found.insert([r, g, b]);
            }
            if found.len() > most {
                return None;
            }
        }
    }
    let indices = found.iter().enumerate().map(|(i, c)| (*c, i as u8)).collect();
    let colours = found.into_iter().flatten().collect();
    Some(Palette { colours, transparent: None, kind: Kind::Exact(indices) })
}

/// A palette that lies near the film's colours.
fn learned(frames: &dyn Pictures, most: usize) -> Palette {
    let (width, height) = frames.size(0);
    let (count, area) = (frames.count(), width * height);
    // Odd, so that the sample is no column of the frame.
    let step = (count * area).div_ceil(SAMPLE) | 1;
    let opaque = |p: &&[u8; 4]| p[3] >= 128;
    let of = |k: usize| -> Vec<u8> {
        let picture = frames.picture(k);
        // The sample goes on from frame to frame.
        let pixels = picture.pixels().iter().skip((step - k * area % step) % step).step_by(step);
        pixels.filter(opaque).flat_map(|&[r, g, b, _]| [r, g, b, 255]).collect()
    };
    let sample: Vec<u8> = (0..count).flat_map(of).collect();
    let map = NeuQuant::new(1, most, &sample);
    Palette { colours: map.color_map_rgb(), transparent: None, kind: Kind::Learned(Box::new(map)) }
}

/// Bayer's pattern of four by four, spread over twice [`DITHER`].
fn dither(x: usize, y: usize) -> i32 {
    const BAYER: [[i32; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];
    (2 * BAYER[y % 4][x % 4] - 15) * DITHER / 15
}

/// The smallest rectangle outside which two frames are equal: left, top, right, bottom. One pixel
/// where they are equal everywhere.
fn changed(now: &[u8], before: &[u8], width: usize) -> [usize; 4] {
    let mut bounds: Option<[usize; 4]> = None;
    for (y, (a, b)) in now.chunks_exact(width).zip(before.chunks_exact(width)).enumerate() {
        let differs = |x: &usize| a[*x] != b[*x];
        let Some(left) = (0..width).find(differs) else { continue };
        let right = (0..width).rfind(differs).unwrap_or(left) + 1;
        let [l, t, r, _] = bounds.unwrap_or([left, y, right, y]);
        bounds = Some([l.min(left), t, r.max(right), y + 1]);
    }
    bounds.unwrap_or([0, 0, 1, 1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use gif::{ColorOutput, DecodeOptions};

    /// The frames as a player shows them, with their delays, and the comment.
    fn played(bytes: &[u8]) -> Vec<(Plane<[u8; 4]>, u16)> {
        let mut options = DecodeOptions::new();
        options.set_color_output(ColorOutput::RGBA);
        let mut reader = options.read_info(bytes).unwrap();
        let mut canvas = Plane::filled(reader.width().into(), reader.height().into(), [0; 4]);
        let mut shown = Vec::new();
        while let Some(frame) = reader.read_next_frame().unwrap() {
            let (left, top, width) =
                (frame.left as usize, frame.top as usize, frame.width as usize);
            for (i, pixel) in frame.buffer.as_chunks::<4>().0.iter().enumerate() {
                canvas[(left + i % width, top + i / width)] = *pixel;
            }
            shown.push((canvas.clone(), frame.delay));
        }
        shown
    }

    #[test]
    fn few_colours_come_back_exactly() {
        let picture = |n: usize| {
            Plane::from_fn(19, 7, |x, y| {
                if (x + n) % 5 < 2 && y > 2 { [9, n as u8, 3, 255] } else { [255; 4] }
            })
        };
        let frames: Vec<_> = (0..6).map(picture).collect();
        let bytes = write_gif(&frames, 24.0, Some("shot = 1")).unwrap();
        let shown = played(&bytes);
        for (frame, (back, _)) in frames.iter().zip(&shown) {
            assert_eq!(frame, back);
        }
        let delays: Vec<_> = shown.iter().map(|(_, delay)| *delay).collect();
        assert_eq!(delays, [4, 4, 5, 4, 4, 4]);
        assert!(bytes.windows(8).any(|w| w == b"shot = 1"));
    }

    #[test]
    fn what_stands_still_is_one_frame_of_the_whole_time() {
        let frames = vec![Plane::filled(4, 4, [1, 2, 3, 255]); 36];
        let shown = played(&write_gif(&frames, 24.0, None).unwrap());
        assert_eq!((shown.len(), shown[0].1), (1, 150));
    }

    #[test]
    fn clear_pixels_stay_clear() {
        let picture = |n: usize| {
            Plane::from_fn(8, 8, |x, _| if x == n { [0, 0, 0, 255] } else { [9, 9, 9, 0] })
        };
        let frames: Vec<_> = (0..3).map(picture).collect();
        let shown = played(&write_gif(&frames, 10.0, None).unwrap());
        for (n, (back, _)) in shown.iter().enumerate() {
            assert!(back.pixels().iter().enumerate().all(|(i, p)| (p[3] == 255) == (i % 8 == n)));
        }
    }

    #[test]
    fn many_colours_stay_near_in_the_mean() {
        let picture = |n: usize| {
            Plane::from_fn(96, 64, |x, y| [(x * 2) as u8, (y * 3) as u8, (60 + 10 * n) as u8, 255])
        };
        let frames: Vec<_> = (0..4).map(picture).collect();
        let shown = played(&write_gif(&frames, 12.0, None).unwrap());
        for (frame, (back, _)) in frames.iter().zip(&shown) {
            let differences =
                frame.pixels().iter().zip(back.pixels()).flat_map(|(a, b)| {
                    (0..3).map(move |c| (i32::from(a[c]) - i32::from(b[c])).abs())
                });
            let mean = f64::from(differences.sum::<i32>()) / (96.0 * 64.0 * 3.0);
            assert!(mean < 9.0, "{mean}");
        }
    }

    #[test]
    fn films_of_nothing_or_of_two_sizes_are_refused() {
        assert!(write_gif(&Vec::<Plane<[u8; 4]>>::new(), 24.0, None).is_err());
        let frames = vec![Plane::filled(2, 2, [0; 4]), Plane::filled(2, 3, [0; 4])];
        assert!(write_gif(&frames, 24.0, None).is_err());
        assert!(write_gif(&vec![Plane::filled(70_000, 1, [0; 4])], 24.0, None).is_err());
    }
}
