//! Unpacking one chunk, and what keeps a forged one from unpacking to too much.
//!
//! The `exr` library decompresses. It trusts the counters inside a DWA chunk, so they are checked
//! here against the size of the block before it sees them.

use exr::meta::attribute::{Compression, IntegerBounds};
use exr::meta::header::Header;
use exr::prelude::Vec2;

/// Bytes that one byte in the file can unpack to, at most.
pub(super) fn ratio(compression: Compression) -> u64 {
    match compression {
        Compression::Uncompressed => 1,
        // Two bytes hold a run of 128.
        Compression::RLE => 64,
        // Deflate holds 258 bytes in two bits; PXR24 drops a quarter of a float besides.
        Compression::ZIP1 | Compression::ZIP16 => 1032,
        Compression::PXR24 => 1376,
        // Huffman codes hold a run of 255 words in nine bits.
        Compression::PIZ => 512,
        // Three bytes hold a flat block of 16 half floats.
        Compression::B44 | Compression::B44A => 11,
        // Two bytes hold an even block of 64 half floats, and are deflated.
        _ => 64 * 1032,
    }
}

/// The samples of a block of `width` x `height` pixels, line by line and within a line channel by
/// channel, in the byte order of this machine.
pub(super) fn unpack(
    data: &[u8],
    (width, height): (usize, usize),
    library: &Header,
) -> Result<Vec<u8>, String> {
    let size = width * height * library.channels.bytes_per_pixel;
    if data.is_empty() || data.len() > size {
        return Err("a block of pixels has a wrong length".into());
    }
    let dwa = matches!(library.compression, Compression::DWAA(_) | Compression::DWAB(_));
    if dwa && data.len() < size {
        let samples = width.next_multiple_of(8) * height.next_multiple_of(8);
        check_dwa(data, samples * library.channels.list.len())?;
    }
    let area = IntegerBounds::new((0, 0), Vec2(width, height));
    library
        .compression
        .decompress_image_section_from_le(library, data.to_vec(), area, false)
        .map_err(|why| format!("a block of pixels is damaged ({why})"))
}

/// Checks the eleven counters at the front of a DWA chunk: its version, sizes of its sections, counts
/// of coefficients. None can exceed what so many samples take, a float each, in a run-length code
/// at its worst.
fn check_dwa(data: &[u8], samples: usize) -> Result<(), String> {
    const COUNTERS: usize = 11;
    let counters = data.as_chunks::<8>().0.iter().take(COUNTERS).map(|b| u64::from_le_bytes(*b));
    let most = samples as u64 * 8;
    if data.len() < 8 * COUNTERS || counters.into_iter().any(|counter| counter > most) {
        return Err("a block of pixels is damaged (DWA counters out of range)".into());
    }
    Ok(())
}
