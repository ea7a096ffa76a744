//! Tree files: a compact tree as bytes, to be read from memory or mapped from a disk.
//!
//! ```text
//! 16 bytes   "chiaro pbgi\n", the version (4 bytes)
//! parts      each its bytes (crate::compact) and a checksum (8 bytes)
//! tail       how numbers are read, what the tree was made from, the book, the levels above the parts, a
//!            checksum (8 bytes)
//! 16 bytes   where the tail begins (8 bytes), "pbgi end"
//! ```
//!
//! Little-endian everywhere. Parts are written as they are made, so that no tree need ever be in
//! memory as a whole, and they are read where they lie. [`open`] checks every byte: a file that was
//! cut off or altered is an error of one sentence, never a wrong picture or a panic. The checksum
//! is against accidents, not against forgers: forged bytes give some picture. Books alone are files
//! too ([`book_bytes`], [`read_book`]).

use crate::code::{Book, Gains, Recipe, Table, Words, whole};
use crate::compact::{Bytes, Compact, Format};
use crate::curve::Cube;
use crate::packed::{PART, Packed};
use chiaro_basis::math::vec3;
use chiaro_basis::{Error, Result};
use rayon::prelude::*;

const MAGIC: &[u8; 12] = b"chiaro pbgi\n";
const BOOK_MAGIC: &[u8; 12] = b"chiaro book\n";
const VERSION: u32 = 4;
const END: &[u8; 8] = b"pbgi end";
const CUT: &str = "is no whole tree file; bake it again with chiaro light --bake";
const ALTERED: &str = "was altered or damaged; bake it again with chiaro light --bake";
/// Parts that are checked between two pauses: some ten megabytes.
const PARTS_AT_ONCE: usize = 128;
/// Bytes of a checksum.
pub(crate) const SUM: usize = 8;

/// The first bytes of a file.
pub(crate) fn head() -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes
}

/// The last bytes of a file of so many bytes up to them; `origin` says what the tree was made from.
pub(crate) fn tail(tree: &Packed<Compact>, origin: &str, before: u64) -> Vec<u8> {
    let (store, format) = (&tree.store, &tree.store.format);
    let mut w = Writer::default();
    for value in format.cube.low.to_array() {
        w.f32(value);
    }
    for value in [format.cube.side, format.top_area, format.top_light, tree.leaf_radius] {
        w.f32(value);
    }
    w.u64(store.records as u64);
    store.seconds.iter().for_each(|n| w.0.extend(n.to_le_bytes()));
    w.u64(origin.len() as u64);
    w.0.extend(origin.as_bytes());
    w.book(&format.book);
    w.u64(store.crown.len() as u64);
    for level in &store.crown {
        w.u64(level.len() as u64);
        w.0.extend(level);
    }
    let sum = checksum(&w.0);
    w.0.extend(sum.to_le_bytes());
    w.u64(before);
    w.0.extend(END);
    w.0
}

/// A book as the bytes of a file: "chiaro book\n", the version (4 bytes), the book, a checksum.
pub fn book_bytes(book: &Book) -> Vec<u8> {
    let mut w = Writer(BOOK_MAGIC.to_vec());
    w.0.extend(VERSION.to_le_bytes());
    w.book(book);
    let sum = checksum(&w.0);
    w.0.extend(sum.to_le_bytes());
    w.0
}

/// The book in the bytes of a file. `name` is told in errors.
pub fn read_book(bytes: &[u8], name: &str) -> Result<Book> {
    let wrong = |why: &str| Error::input(name, "", why);
    let Some(rest) = bytes.strip_prefix(BOOK_MAGIC) else {
        return Err(wrong("is no book; name a file that is not there, and a book is made in it"));
    };
    let altered = || wrong("was cut off, altered or damaged; delete it, and a new book is made");
    let (version, rest) = rest.split_at_checked(4).ok_or_else(altered)?;
    if version != VERSION.to_le_bytes() {
        return Err(wrong(
            "was made by another version of chiaro; delete it, and a new one is made",
        ));
    }
    let (numbers, sum) =
        rest.split_at_checked(rest.len().saturating_sub(SUM)).ok_or_else(altered)?;
    if checksum(&bytes[..bytes.len() - sum.len()]).to_le_bytes() != sum {
        return Err(altered());
    }
    Reader(numbers).book().ok_or_else(altered)
}

/// What the tree in the bytes of a file was made from; of the bytes of its parts nothing is read.
pub fn origin(bytes: &[u8], name: &str) -> Result<String> {
    Ok(tail_of(bytes, name)?.0.origin)
}

/// The tail of a tree file's bytes, and where it begins.
fn tail_of(all: &[u8], name: &str) -> Result<(Tail, usize)> {
    let wrong = |why: &str| Error::input(name, "", why);
    let cut = || wrong(CUT);
    if !all.starts_with(MAGIC) {
        return Err(wrong("is no tree file; make one with chiaro light --bake"));
    }
    if all.len() < 40 || !all.ends_with(END) {
        return Err(cut());
    }
    if u32::from_le_bytes(std::array::from_fn(|i| all[12 + i])) != VERSION {
        return Err(wrong("was baked by another version of chiaro; bake it again"));
    }
    let start = u64::from_le_bytes(std::array::from_fn(|i| all[all.len() - 16 + i]));
    let end = all.len() - 16 - SUM;
    let start = usize::try_from(start).ok().filter(|s| (16..=end).contains(s)).ok_or_else(cut)?;
    if checksum(&all[start..end]).to_le_bytes() != all[end..end + SUM] {
        return Err(wrong(ALTERED));
    }
    let tail = read_tail(&all[start..end]).ok_or_else(|| wrong(ALTERED))?;
    Ok((tail, start))
}

/// A tree in the bytes of a file, and what it was made from. `name` is told in errors; `pause` is
/// called whenever some more megabytes have been read, so that pages can be given back.
pub fn open(bytes: Bytes, name: &str, pause: &dyn Fn()) -> Result<(Packed<Compact>, String)> {
    let all = (*bytes).as_ref();
    let wrong = |why: &str| Error::input(name, "", why);
    let altered = || wrong(ALTERED);
    let (tail, start) = tail_of(all, name)?;
    let Tail { format, leaf_radius, records, seconds, origin, crown } = tail;
    let mut starts = Vec::new();
    let mut at = 16;
    for (first, seconds) in (0..records).step_by(PART).zip(&seconds) {
        let length = format.part_bytes(PART.min(records - first), *seconds);
        starts.push((at, length));
        at += length + SUM;
    }
    if at != start {
        return Err(wrong(CUT));
    }
    let sound = |&(at, length): &(usize, usize)| {
        checksum(&all[at..at + length]).to_le_bytes() == all[at + length..at + length + SUM]
    };
    for some in starts.chunks(PARTS_AT_ONCE) {
        if !some.par_iter().all(sound) {
            return Err(altered());
        }
        pause();
    }
    let store =
        Compact::of_bytes(format, bytes, &starts, crown, (records, seconds)).ok_or_else(altered)?;
    Ok((Packed { store, leaf_radius }, origin))
}

struct Tail {
    format: Format,
    leaf_radius: f32,
    records: usize,
    seconds: Vec<u16>,
    origin: String,
    crown: Vec<Vec<u8>>,
}

fn read_tail(bytes: &[u8]) -> Option<Tail> {
    let mut r = Reader(bytes);
    let low = vec3(r.f32()?, r.f32()?, r.f32()?);
    let cube = Cube { low, side: r.f32()? };
    let (top_area, top_light, leaf_radius) = (r.f32()?, r.f32()?, r.f32()?);
    let records = r.size()?;
    let seconds = r.take(records.div_ceil(PART).checked_mul(2)?)?;
    let seconds = seconds.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
    let length = r.size()?;
    let origin = String::from_utf8(r.take(length)?.to_vec()).ok()?;
    let book = r.book()?;
    let levels = r.size().filter(|n| *n < 64)?;
    let mut crown = Vec::new();
    for _ in 0..levels {
        let length = r.size()?;
        crown.push(r.take(length)?.to_vec());
    }
    let format = Format { book, cube, top_area, top_light };
    Some(Tail { format, leaf_radius, records, seconds, origin, crown })
}

#[derive(Default)]
struct Writer(Vec<u8>);

impl Writer {
    fn f32(&mut self, value: f32) {
        self.0.extend(value.to_le_bytes());
    }

    fn u64(&mut self, value: u64) {
        self.0.extend(value.to_le_bytes());
    }

    fn book(&mut self, book: &Book) {
        let recipe = &book.recipe;
        let gains = match recipe.gains {
            Gains::None => 0,
            Gains::One => 1,
            Gains::Colours => 2,
            Gains::Shape => 3,
        };
        self.0.extend([u8::from(recipe.by_area), u8::from(recipe.turned), gains]);
        self.f32(book.top);
        for (tables, stages) in [(&book.light, &recipe.light), (&book.area, &recipe.area)] {
            self.u64(stages.len() as u64);
            for (table, words) in tables.iter().zip(stages) {
                self.u64(*words as u64);
                self.u64(table.len() as u64);
                table.halves().iter().for_each(|x| self.0.extend(x.to_le_bytes()));
            }
        }
    }
}

struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn f32(&mut self) -> Option<f32> {
        Some(f32::from_le_bytes(self.take(4)?.try_into().ok()?)).filter(|f| f.is_finite())
    }

    fn size(&mut self) -> Option<usize> {
        usize::try_from(u64::from_le_bytes(self.take(8)?.try_into().ok()?)).ok()
    }

    fn book(&mut self) -> Option<Book> {
        let flags = self.take(3)?;
        let all = [Gains::None, Gains::One, Gains::Colours, Gains::Shape];
        let gains = *all.get(usize::from(flags[2]))?;
        let (by_area, turned) = (flags[0] != 0, flags[1] != 0);
        let top = self.f32()?;
        let (light, light_words) = self.tables(gains.dim())?;
        let (area, area_words) = self.tables(9)?;
        let words = Words::Clustered;
        let recipe = Recipe { by_area, turned, gains, light: light_words, area: area_words, words };
        Some(Book { recipe, top, light, area })
    }

    /// Tables of words, and how many words each was meant to have.
    fn tables(&mut self, dim: usize) -> Option<(Vec<Table>, Vec<usize>)> {
        let stages = self.size().filter(|n| *n <= 16)?;
        let (mut tables, mut words) = (Vec::new(), Vec::new());
        for _ in 0..stages {
            words.push(self.size().filter(|n| *n <= 65_536)?);
            let count = self.size().filter(|n| *n <= self.0.len() / (2 * dim))?;
            let halves = self.take(2 * dim * count)?.chunks_exact(2);
            let halves: Vec<u16> = halves.map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
            if !halves.iter().all(|h| whole(*h).is_finite()) {
                return None;
            }
            tables.push(Table::of_halves(halves, dim));
        }
        Some((tables, words))
    }
}

/// A checksum of 64 bits: four lanes of multiplications, then mixed.
pub(crate) fn checksum(bytes: &[u8]) -> u64 {
    const ODD: [u64; 4] = [
        0x9E37_79B9_7F4A_7C15,
        0xC2B2_AE3D_27D4_EB4F,
        0x1656_67B1_9E37_79F9,
        0xD6E8_FEB8_6659_FD93,
    ];
    let mut lanes = ODD;
    let chunks = bytes.chunks_exact(32);
    let rest = chunks.remainder();
    let mut mix = |chunk: &[u8]| {
        for (lane, word) in chunk.chunks(8).enumerate() {
            let word = word.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b));
            lanes[lane] = (lanes[lane] ^ word).wrapping_mul(ODD[lane]).rotate_left(29);
        }
    };
    chunks.for_each(&mut mix);
    mix(rest);
    let all = lanes.iter().fold(bytes.len() as u64, |h, l| (h ^ l).wrapping_mul(ODD[1]) ^ h >> 31);
    all ^ all >> 32
}
