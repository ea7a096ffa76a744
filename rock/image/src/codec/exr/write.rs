//! An [`ExrImage`] to bytes.

use super::header::{self, RESERVED};
use super::layout::{Block, Channel, Part, Window};
use super::{ExrChannel, ExrImage};
use chiaro_basis::{Error, Result};
use exr::meta::attribute::{Compression, IntegerBounds, SampleType};
use exr::prelude::Vec2;
use rayon::prelude::*;

/// The longest side that can be written, in pixels.
const LONGEST_SIDE: usize = 1 << 24;

/// Writes a single-part OpenEXR file, its channels sorted by name. Equal images give equal bytes.
///
/// # Errors
/// [`Error::Setting`] when there is no channel or pixel, when channels differ in size or share a
/// name, or when a name is longer than 255 bytes, empty, or one that the format keeps for itself.
pub fn write_exr(image: &ExrImage) -> Result<Vec<u8>> {
    let mut layers: Vec<&(String, ExrChannel)> = image.layers.iter().collect();
    layers.sort_by(|a, b| a.0.cmp(&b.0));
    check(image, &layers)?;
    let part = part(image, &layers);
    let library = part.library_header();
    let compress = |row: usize| {
        let block = part.block(0, row).expect("a row of the grid");
        let area = IntegerBounds::new((0, 0), Vec2(block.width, block.height));
        let lines = lines(&layers, &block);
        let packed = part.compression.compress_image_section_to_le(&library, lines, area);
        packed.map(|bytes| (block.y as i32, bytes))
    };
    let blocks: exr::error::Result<Vec<_>> =
        (0..part.block_count()).into_par_iter().map(compress).collect();
    let blocks = blocks.map_err(|why| Error::setting("channels", layers.len(), why.to_string()))?;
    Ok(assemble(header::write(&part), &blocks))
}

fn check(image: &ExrImage, layers: &[&(String, ExrChannel)]) -> Result<()> {
    let (width, height) = image.size;
    let sides = 1..=LONGEST_SIDE;
    if !sides.contains(&width) || !sides.contains(&height) {
        let size = format!("{width} x {height}");
        return Err(Error::setting("size", size, format!("sides of 1 to {LONGEST_SIDE} pixels")));
    }
    if layers.is_empty() {
        return Err(Error::setting("channels", 0, "at least one channel"));
    }
    let clash = layers.windows(2).find(|pair| pair[0].0 == pair[1].0).map(|pair| &pair[0].0);
    if let Some(name) = clash {
        return Err(Error::setting("channel", name, "names that differ"));
    }
    let stray = layers.iter().find(|(_, channel)| size(channel) != image.size);
    if let Some((name, channel)) = stray {
        let (w, h) = size(channel);
        let range = format!("{width} x {height} pixels, as the image has");
        return Err(Error::setting(format!("channel {name}"), format!("{w} x {h}"), range));
    }
    let names = layers.iter().map(|(name, _)| name).chain(image.attributes.keys());
    let unfit = |name: &&String| name.is_empty() || name.len() > 255 || name.contains('\0');
    let reserved = image.attributes.keys().find(|name| RESERVED.contains(&name.as_str()));
    match names.clone().find(unfit).or(reserved) {
        Some(name) => Err(Error::setting("name", name, "1 to 255 bytes that OpenEXR leaves free")),
        None => Ok(()),
    }
}

fn size(channel: &ExrChannel) -> (usize, usize) {
    match channel {
        ExrChannel::F32(plane) => plane.size(),
        ExrChannel::U32(plane) => plane.size(),
    }
}

fn part(image: &ExrImage, layers: &[&(String, ExrChannel)]) -> Part {
    let (width, height) = image.size;
    let window = Window { x: 0, y: 0, width, height };
    let channel = |(name, channel): &&(String, ExrChannel)| Channel {
        name: name.clone(),
        sample: match channel {
            ExrChannel::F32(_) => SampleType::F32,
            ExrChannel::U32(_) => SampleType::U32,
        },
        linear: false,
    };
    Part {
        name: None,
        window,
        display: window,
        channels: layers.iter().map(channel).collect(),
        compression: Compression::ZIP16,
        tiles: None,
        attributes: image.attributes.iter().map(|(n, t)| (n.clone(), t.clone())).collect(),
    }
}

/// The samples of a block line by line, and within a line channel by channel.
fn lines(layers: &[&(String, ExrChannel)], block: &Block) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(block.width * block.height * layers.len() * 4);
    for y in block.y..block.y + block.height {
        for (_, channel) in layers {
            match channel {
                ExrChannel::F32(plane) => {
                    bytes.extend(plane.row(y).iter().flat_map(|v| v.to_ne_bytes()))
                }
                ExrChannel::U32(plane) => {
                    bytes.extend(plane.row(y).iter().flat_map(|v| v.to_ne_bytes()))
                }
            }
        }
    }
    bytes
}

/// The header, the table of where each chunk begins, and the chunks: first line, length, data.
fn assemble(header: Vec<u8>, blocks: &[(i32, Vec<u8>)]) -> Vec<u8> {
    let mut file = header;
    let mut place = file.len() + 8 * blocks.len();
    for (_, data) in blocks {
        file.extend((place as u64).to_le_bytes());
        place += 8 + data.len();
    }
    for (y, data) in blocks {
        file.extend(y.to_le_bytes());
        file.extend((data.len() as u32).to_le_bytes());
        file.extend(data);
    }
    file
}
