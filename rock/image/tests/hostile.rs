//! Hostile files: small pictures of every kind, cut at every length and mutated, must neither
//! panic, nor hang, nor ask for much memory; what fails is one sentence that names the file.
//!
//! `CHIARO_MUTANTS` sets the number of mutants of each picture, 2000 if it does not say.
#![allow(unsafe_code)] // A counting allocator is the one way to see what a library asks for.

use chiaro_basis::{Error, Result, random};
use chiaro_image::Plane;
use chiaro_image::codec::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Cursor;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

static LIVE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, counting live bytes and their peak.
struct Counting;

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let live = LIVE.fetch_add(layout.size(), Relaxed) + layout.size();
        PEAK.fetch_max(live, Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Relaxed);
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        let live = LIVE.fetch_add(layout.size(), Relaxed) + layout.size();
        PEAK.fetch_max(live, Relaxed);
        unsafe { System.alloc_zeroed(layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The counters are shared, so one test runs at a time.
static GATE: Mutex<()> = Mutex::new(());

const LIMITS: Limits = Limits { pixels: 1 << 20, bytes: 1 << 24 };

/// What a decoder may hold at its peak: the planes twice, and the libraries' tables.
const MOST_BYTES: usize = 2 * (1 << 24) + (1 << 23);

const MOST_TIME: Duration = Duration::from_secs(5);

/// Decodes one hostile file and checks what it cost and said.
fn survive<T>(bytes: &[u8], what: &str, decode: impl Fn(&[u8], &str) -> Result<T>) -> bool {
    let before = LIVE.load(Relaxed);
    PEAK.store(before, Relaxed);
    let start = Instant::now();
    let outcome = decode(bytes, "hostile.file").map(drop);
    let peak = PEAK.load(Relaxed).saturating_sub(before);
    assert!(peak < MOST_BYTES, "{what}: {peak} bytes at the peak for {} in the file", bytes.len());
    assert!(start.elapsed() < MOST_TIME, "{what}: {:?}", start.elapsed());
    let Err(error) = &outcome else { return true };
    let message = error.to_string();
    assert!(matches!(error, Error::Input { .. } | Error::Limit { .. }), "{what}: {message}");
    assert!(message.starts_with("hostile.file") && !message.contains('\n'), "{what}: {message}");
    false
}

/// A mutant: one to eight changes of a byte, a number, a run, or the length.
fn mutant(seed: &[u8], number: u64) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    let mut draws = (0..).map(|i| random::hash(number, i) as usize);
    let mut draw = |below: usize| draws.next().expect("no end of numbers") % below.max(1);
    for _ in 0..1 + draw(8) {
        let at = draw(bytes.len());
        match draw(7) {
            0 => bytes[at] ^= 1 << draw(8),
            1 => bytes[at] = draw(256) as u8,
            2 => bytes[at] = [0, 1, 0x7F, 0x80, 0xFF][draw(5)],
            3 => {
                let number = [0u32, 1, 0x7FFF_FFFF, 0xFFFF_FFFF, 0x8000_0000, 0x0001_0000][draw(6)];
                let end = (at + 4).min(bytes.len());
                bytes[at..end].copy_from_slice(&number.to_le_bytes()[..end - at]);
            }
            4 => {
                let from = draw(bytes.len());
                let run = bytes[from..(from + draw(32)).min(bytes.len())].to_vec();
                bytes.splice(at..at, run);
            }
            5 => drop(bytes.drain(at..(at + draw(16)).min(bytes.len()))),
            _ => bytes.truncate(at.max(bytes.len() / 2)),
        }
        if bytes.is_empty() {
            break;
        }
    }
    bytes
}

fn mutants() -> u64 {
    std::env::var("CHIARO_MUTANTS").ok().and_then(|text| text.parse().ok()).unwrap_or(2000)
}

/// Cuts `seed` at every length and mutates it; `mend` repairs checksums so that mutants get past.
fn attack<T>(
    what: &str,
    seed: &[u8],
    mend: impl Fn(&mut [u8]),
    decode: impl Fn(&[u8], &str) -> Result<T>,
) {
    let _alone = GATE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    assert!(survive(seed, what, &decode), "{what}: the unharmed file is read");
    for length in 0..seed.len() {
        survive(&seed[..length], &format!("{what} cut at {length}"), &decode);
    }
    for number in 0..mutants() {
        let mut bytes = mutant(seed, number);
        if number % 4 != 0 {
            mend(&mut bytes);
        }
        survive(&bytes, &format!("{what} mutant {number}"), &decode);
    }
}

/// Sets the checksums of all chunks of a PNG right.
fn mend_png(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(length) = bytes.get(at..at + 4) {
        let length = u32::from_be_bytes([length[0], length[1], length[2], length[3]]) as usize;
        let end = at.saturating_add(8).saturating_add(length);
        if end.saturating_add(4) > bytes.len() {
            break;
        }
        let crc = bytes[at + 4..end].iter().fold(!0u32, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |c, _| {
                (c >> 1) ^ (0xEDB8_8320 & (c & 1).wrapping_neg())
            })
        });
        bytes[end..end + 4].copy_from_slice(&(!crc).to_be_bytes());
        at = end + 4;
    }
}

fn unmended(_: &mut [u8]) {}

fn read_any(bytes: &[u8], name: &str) -> Result<Plane<[f32; 4]>> {
    read_colour(bytes, name, &LIMITS)
}

fn noise(x: usize, y: usize) -> u8 {
    random::hash(x as u64 / 3, y as u64 / 2) as u8
}

#[test]
fn hostile_png() {
    let rgba = Plane::from_fn(19, 13, |x, y| [noise(x, y), noise(y, x), x as u8, 200]);
    let recipe = Some("version = 1");
    let seeds = [
        ("rgba", write_png_rgba(&rgba, recipe)),
        ("grey", write_png_grey(&rgba.map(|p| p[0]), None)),
        ("bits", write_png_bits(&rgba.map(|p| p[0] > 99), recipe)),
    ];
    for (what, seed) in seeds {
        let seed = seed.expect("a picture");
        attack(what, &seed, mend_png, read_any);
        attack(what, &seed, mend_png, read_png_recipe);
    }
}

#[test]
fn hostile_png_of_foreign_kinds() {
    use png::{BitDepth, ColorType};
    let data: Vec<u8> = (0..16 * 9 * 8).map(|i| noise(i, 1)).collect();
    for (colour, depth) in [
        (ColorType::Indexed, BitDepth::Four),
        (ColorType::Rgb, BitDepth::Sixteen),
        (ColorType::GrayscaleAlpha, BitDepth::Eight),
    ] {
        let mut seed = Vec::new();
        let mut encoder = png::Encoder::new(&mut seed, 16, 9);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        if colour == ColorType::Indexed {
            encoder.set_palette(data[..48].to_vec());
        }
        let row = 16 * colour.samples() * depth as usize / 8;
        let mut writer = encoder.write_header().expect("a header");
        writer.write_image_data(&data[..row * 9]).expect("a picture");
        writer.finish().expect("an end");
        attack(&format!("{colour:?} {depth:?}"), &seed, mend_png, read_any);
    }
}

#[test]
fn hostile_jpeg() {
    use image::ExtendedColorType::{L8, Rgb8};
    for (what, colour, channels) in [("rgb", Rgb8, 3), ("grey", L8, 1)] {
        let data: Vec<u8> = (0..24 * 17 * channels).map(|i| noise(i, 5)).collect();
        let mut seed = Vec::new();
        image::codecs::jpeg::JpegEncoder::new_with_quality(&mut seed, 40)
            .encode(&data, 24, 17, colour)
            .expect("a picture");
        attack(what, &seed, unmended, read_any);
    }
}

#[test]
fn hostile_pbm() {
    let seed = write_pbm(&Plane::from_fn(21, 9, |x, y| noise(x, y) > 128));
    attack("pbm", &seed, unmended, |bytes, name| read_pbm(bytes, name, &LIMITS));
}

#[test]
fn hostile_exr() {
    let floats = Plane::from_fn(17, 21, |x, y| f32::from(noise(x, y)) / 9.0);
    let layers = vec![
        ("depth.Z".into(), ExrChannel::F32(floats.clone())),
        ("object.ID".into(), ExrChannel::U32(floats.map(|v| *v as u32))),
    ];
    let attributes = [("chiaro".to_owned(), "a = 1".to_owned())].into();
    let image = ExrImage { size: (17, 21), layers, attributes };
    let seed = write_exr(&image).expect("an image");
    attack("ours", &seed, unmended, |bytes, name| read_exr(bytes, name, &LIMITS));
}

/// An OpenEXR file of two parts, one of them tiled, as the library writes it.
fn foreign_exr(compression: exr::prelude::Compression) -> Vec<u8> {
    use exr::prelude::*;
    let layer = |name: &str, blocks| {
        let size = Vec2(18, 15);
        let value = |i: usize| f32::from(noise(i, 3)) / 7.0;
        let halves = (0..size.area()).map(|i| f16::from_f32(value(i))).collect();
        let singles = (0..size.area()).map(value).collect();
        let channels = [("R", FlatSamples::F16(halves)), ("Z", FlatSamples::F32(singles))];
        let channels = channels.map(|(name, samples)| AnyChannel::new(name, samples));
        let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
        let list = AnyChannels::sort(channels.into_iter().collect());
        Layer::new(size, LayerAttributes::named(name), encoding, list)
    };
    let layers = vec![layer("lines", Blocks::ScanLines), layer("tiles", Blocks::Tiles(Vec2(8, 8)))];
    let mut bytes = Cursor::new(Vec::new());
    let image = Image::from_layers(ImageAttributes::with_size(Vec2(18, 15)), layers);
    image.write().to_buffered(&mut bytes).expect("the library writes it");
    bytes.into_inner()
}

#[test]
#[cfg_attr(debug_assertions, ignore = "B44 counts on sums that wrap, which this build checks")]
fn hostile_exr_of_every_compression() {
    use exr::prelude::Compression::*;
    for compression in [Uncompressed, RLE, ZIP1, PIZ, PXR24, B44, B44A, DWAA(None), DWAB(None)] {
        let seed = foreign_exr(compression);
        let decode = |bytes: &[u8], name: &str| read_exr(bytes, name, &LIMITS);
        attack(&format!("{compression:?}"), &seed, unmended, decode);
    }
}
