//! Bytes to an [`ExrImage`].
//!
//! Chunks are walked in the order in which they lie, not through the table of their places: every
//! byte of the file is then unpacked at most once, however the table is forged, and files whose
//! table was never written (a render that crashed) still open.

use super::compression;
use super::cursor::Cursor;
use super::header::{self, Headers};
use super::layout::{Block, Part, Window};
use super::{ExrChannel, ExrImage};
use crate::Plane;
use crate::codec::Limits;
use chiaro_basis::Result;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::f16;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Chunks that are unpacked at a time, which bounds the memory on top of the planes.
const BATCH: usize = 64;

/// Reads every channel of every part, as `f32` or `u32`, onto the display window of the first
/// part; pixels outside a data window are 0. In a file of several parts a channel `Z` of the part
/// `ViewLayer.Depth` is called `ViewLayer.Depth.Z`, unless its name begins so already. Of channels
/// that share a name the first counts.
///
/// # Errors
/// [`Error::Input`](chiaro_basis::Error::Input) when the file is damaged or of a kind that is not
/// read, [`Error::Limit`](chiaro_basis::Error::Limit) when the planes would exceed `limits`; both
/// name the file by `name`.
pub fn read_exr(bytes: &[u8], name: &str, limits: &Limits) -> Result<ExrImage> {
    let headers = header::parse(bytes, name)?;
    check_sizes(&headers, bytes.len(), name, limits)?;
    let chunks = chunks(&headers)?;
    let mut planes: Vec<Vec<ExrChannel>> = headers.parts.iter().map(blank).collect();
    unpack(&headers, &chunks, &mut planes)?;
    Ok(image(&headers.parts, planes))
}

/// Checks what will be allocated against the limits and against the length of the file.
fn check_sizes(headers: &Headers, length: usize, name: &str, limits: &Limits) -> Result<()> {
    let parts = &headers.parts;
    let wrong = |why: String| Err(headers.behind.wrong(why));
    let display = parts[0].display;
    let size = (display.width as u64, display.height as u64);
    let channels: u64 = parts.iter().map(|part| part.channels.len() as u64).sum();
    limits.check(name, size, 4 * channels)?;
    let (mut least, mut largest) = (0u64, 0);
    for part in parts {
        let size = (part.window.width as u64, part.window.height as u64);
        limits.check(name, size, 4 * channels)?;
        let bytes = part.window.pixels().saturating_mul(part.bytes_per_pixel() as u64);
        least = least.saturating_add(bytes / compression::ratio(part.compression));
        largest = largest.max(part.window.pixels());
    }
    if least > length as u64 {
        return wrong(format!("{length} bytes cannot hold the pixels that the headers announce"));
    }
    // A small picture may stand on a large canvas, but not a speck on an ocean.
    if display.pixels() > (largest * 64).max(1 << 20) {
        return wrong("nearly all of the display window lies outside the data window".into());
    }
    Ok(())
}

/// A chunk of the largest level, still packed.
struct Chunk<'a> {
    part: usize,
    block: Block,
    data: &'a [u8],
}

/// Finds every block of every part, exactly once.
fn chunks<'a>(headers: &Headers<'a>) -> Result<Vec<Chunk<'a>>> {
    let parts = &headers.parts;
    let mut cursor = headers.behind;
    let wanted: usize = parts.iter().map(Part::block_count).sum();
    let table = parts.iter().map(Part::chunk_count).fold(0usize, usize::saturating_add);
    cursor.take(table.saturating_mul(8))?;
    let mut seen: Vec<Vec<bool>> = parts.iter().map(|p| vec![false; p.block_count()]).collect();
    let mut found = Vec::with_capacity(wanted);
    while found.len() < wanted {
        let Some(chunk) = chunk(&mut cursor, headers)? else { continue };
        if std::mem::replace(&mut seen[chunk.part][chunk.block.index], true) {
            return Err(cursor.wrong("a block of pixels occurs twice"));
        }
        found.push(chunk);
    }
    Ok(found)
}

/// The next chunk, or `None` when it belongs to a smaller level.
fn chunk<'a>(cursor: &mut Cursor<'a>, headers: &Headers<'a>) -> Result<Option<Chunk<'a>>> {
    let index = if headers.multi_part { cursor.count()? } else { 0 };
    let stray = |cursor: &Cursor| cursor.wrong("a block of pixels lies outside the picture");
    let part = headers.parts.get(index).ok_or_else(|| stray(cursor))?;
    let (block, small) = match part.tiles {
        None => (part.scan_line_block(i64::from(cursor.i32()?)), false),
        Some(_) => {
            let (column, row) = (cursor.count()?, cursor.count()?);
            let small = (cursor.i32()?, cursor.i32()?) != (0, 0);
            (part.block(column, row), small)
        }
    };
    let length = cursor.count()?;
    let data = cursor.take(length)?;
    if small {
        return Ok(None);
    }
    let block = block.ok_or_else(|| stray(cursor))?;
    Ok(Some(Chunk { part: index, block, data }))
}

/// Planes of zeros for the channels of a part.
fn blank(part: &Part) -> Vec<ExrChannel> {
    let Window { width, height, .. } = part.window;
    let plane = |sample| match sample {
        SampleType::U32 => ExrChannel::U32(Plane::filled(width, height, 0)),
        SampleType::F16 | SampleType::F32 => ExrChannel::F32(Plane::filled(width, height, 0.0)),
    };
    part.channels.iter().map(|channel| plane(channel.sample)).collect()
}

/// Unpacks all chunks, a batch at a time in parallel, and lays them into the planes.
fn unpack(headers: &Headers, chunks: &[Chunk], planes: &mut [Vec<ExrChannel>]) -> Result<()> {
    let library: Vec<Header> = headers.parts.iter().map(Part::library_header).collect();
    for batch in chunks.chunks(BATCH) {
        let unpacked: Vec<_> =
            batch.par_iter().map(|chunk| samples(chunk, &library[chunk.part])).collect();
        for (chunk, bytes) in batch.iter().zip(unpacked) {
            let bytes = bytes.map_err(|why| headers.behind.wrong(why))?;
            lay(&chunk.block, &headers.parts[chunk.part], &bytes, &mut planes[chunk.part]);
        }
    }
    Ok(())
}

fn samples(chunk: &Chunk, library: &Header) -> std::result::Result<Vec<u8>, String> {
    compression::unpack(chunk.data, (chunk.block.width, chunk.block.height), library)
}

/// Lays the samples of a block into the planes of its part.
fn lay(block: &Block, part: &Part, bytes: &[u8], planes: &mut [ExrChannel]) {
    let mut rest = bytes;
    for y in block.y..block.y + block.height {
        for (plane, channel) in planes.iter_mut().zip(&part.channels) {
            let (line, behind) = rest.split_at(block.width * channel.sample.bytes_per_sample());
            rest = behind;
            let from = y * part.window.width + block.x;
            let place = from..from + block.width;
            match (plane, channel.sample) {
                (ExrChannel::U32(plane), _) => {
                    fill(&mut plane.pixels_mut()[place], line, u32::from_ne_bytes);
                }
                (ExrChannel::F32(plane), SampleType::F16) => {
                    let half = |b| f16::from_ne_bytes(b).to_f32();
                    fill(&mut plane.pixels_mut()[place], line, half);
                }
                (ExrChannel::F32(plane), _) => {
                    fill(&mut plane.pixels_mut()[place], line, f32::from_ne_bytes);
                }
            }
        }
    }
}

fn fill<T, const N: usize>(pixels: &mut [T], bytes: &[u8], sample: impl Fn([u8; N]) -> T) {
    for (pixel, b) in pixels.iter_mut().zip(bytes.as_chunks::<N>().0) {
        *pixel = sample(*b);
    }
}

/// All parts on the first one's display window, under full names.
fn image(parts: &[Part], planes: Vec<Vec<ExrChannel>>) -> ExrImage {
    let display = parts[0].display;
    let mut image = ExrImage { size: (display.width, display.height), ..ExrImage::default() };
    let mut taken = BTreeSet::new();
    for (part, planes) in parts.iter().zip(planes) {
        for (channel, plane) in part.channels.iter().zip(planes) {
            let name = full_name(part, &channel.name, parts.len() > 1);
            if taken.insert(name.clone()) {
                image.layers.push((name, fit(plane, &part.window, &display)));
            }
        }
        for (name, text) in &part.attributes {
            image.attributes.entry(name.clone()).or_insert_with(|| text.clone());
        }
    }
    image
}

fn full_name(part: &Part, channel: &str, several: bool) -> String {
    match part.name.as_deref().filter(|name| several && !name.is_empty()) {
        Some(name) if !channel.starts_with(&format!("{name}.")) => format!("{name}.{channel}"),
        _ => channel.to_owned(),
    }
}

/// Crops or pads a channel from its data window to the display window.
fn fit(channel: ExrChannel, data: &Window, display: &Window) -> ExrChannel {
    if data == display {
        return channel;
    }
    match channel {
        ExrChannel::F32(plane) => ExrChannel::F32(moved(&plane, data, display)),
        ExrChannel::U32(plane) => ExrChannel::U32(moved(&plane, data, display)),
    }
}

fn moved<T: Copy + Default + Send + Sync>(
    plane: &Plane<T>,
    data: &Window,
    display: &Window,
) -> Plane<T> {
    let (right, down) = (display.x - data.x, display.y - data.y);
    Plane::from_fn(display.width, display.height, |x, y| {
        let pixel = plane.at((x as i64 + right) as isize, (y as i64 + down) as isize);
        pixel.copied().unwrap_or_default()
    })
}
