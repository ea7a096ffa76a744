//! [`Compact`]: the packed tree in some nine bytes a surfel, eleven where both sides live (thesis, 6.5.3).
//!
//! ```text
//! node     centre 3 x 16 bits in the scene's cube, radius 16 (rounded up), area 16, mean 3 x 8 in
//!          the sphere, axis 2 x 12 (octahedral) and 8 (length), how much of it has two living
//!          sides 8, the lobes' code (crate::code)
//! block    16 surfels, 6 bytes each, and 11 that they share (crate::block)
//! second   2 bytes a surfel with two living sides, behind the part's blocks
//! ```
//!
//! A part's levels and blocks lie side by side, as they do in a file, so that what is built, what
//! is read and what is mapped from a disk are the same bytes, little-endian everywhere.
//! Numbers that bytes name are clamped to what is there: any bytes give some picture.

mod builder;
mod siblings;

pub use builder::{Builder, Sink};
pub use siblings::Siblings;

use crate::bits::{axis_of, encode_axis, float16, float16_above, from_float16};
use crate::block::{self, BLOCK_BYTES, Block, SECOND};
use crate::code::{self, Book, Lobes, Pen};
use crate::curve::Cube;
use crate::packed::{BLOCK, FAN, PART, PART_LEVELS, Places, Record, Stored, Sums, counts};
use chiaro_basis::math::Vec3;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

/// Bytes of a node before its code.
const HEAD: usize = 18;
/// Where in it the share of two living sides is.
const BOTH: usize = 17;
/// Blocks of a part.
const PART_BLOCKS: usize = PART / BLOCK;

/// The last step of a centre's coordinate.
const LAST: f32 = 65_535.0;

/// Bytes that live as long as something holds them: built here, or mapped from a file.
pub type Bytes = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// How the numbers of a tree are to be read.
#[derive(Clone, Debug)]
pub struct Format {
    /// The tables of lobes.
    pub book: Book,
    /// The scene's cube.
    pub cube: Cube,
    /// No node's area is twice as large.
    pub top_area: f32,
    /// No colour's sum is twice as large.
    pub top_light: f32,
}

/// The packed tree, coded.
#[derive(Clone)]
pub struct Compact {
    /// How its numbers are read.
    pub format: Arc<Format>,
    /// The parts, in order.
    pub parts: Vec<Part>,
    /// The levels above the parts.
    pub crown: Vec<Vec<u8>>,
    /// Records in all.
    pub records: usize,
    /// How many second sides each part has.
    pub(crate) seconds: Vec<u16>,
    counts: Vec<usize>,
    /// Bytes of a node.
    stride: usize,
    /// Where the levels of a whole part begin, its blocks, and its second sides.
    whole: [usize; PART_LEVELS + 2],
}

/// A part's bytes.
#[derive(Clone)]
pub struct Part {
    bytes: Bytes,
    start: usize,
}

impl Format {
    /// Bytes of a node.
    pub fn node_bytes(&self) -> usize {
        HEAD + self.book.recipe.bytes()
    }

    /// Bytes of a part of so many records and second sides.
    pub fn part_bytes(&self, records: usize, seconds: u16) -> usize {
        self.starts(records.div_ceil(BLOCK))[PART_LEVELS + 1] + usize::from(seconds) * SECOND
    }

    /// Where in a part of so many blocks its levels begin, its blocks, and its second sides.
    fn starts(&self, blocks: usize) -> [usize; PART_LEVELS + 2] {
        let mut starts = [0; PART_LEVELS + 2];
        for level in 0..PART_LEVELS {
            let nodes = blocks.div_ceil(FAN.pow(level as u32));
            starts[level + 1] = starts[level] + nodes * self.node_bytes();
        }
        starts[PART_LEVELS + 1] = starts[PART_LEVELS] + blocks * BLOCK_BYTES;
        starts
    }

    /// A node's bytes.
    fn encode(&self, sums: &Sums, bytes: &mut Vec<u8>, pen: &mut Pen) {
        let node = &sums.node;
        let place = (node.centre - self.cube.low) * (LAST / self.cube.side);
        let place = place.to_array().map(|c| c.clamp(0.0, LAST).round() as u16);
        bytes.extend(place.map(u16::to_le_bytes).as_flattened());
        let centre = self.centre(place);
        // The sphere still holds what it held.
        let radius = float16_above(node.radius + centre.distance(node.centre), self.cube.side);
        bytes.extend(radius.to_le_bytes());
        bytes.extend(float16(node.area, self.top_area).to_le_bytes());
        let scale = 127.0 / from_float16(radius, self.cube.side).max(f32::MIN_POSITIVE);
        let mean = (node.mean - centre) * scale;
        bytes.extend(mean.to_array().map(|c| c.round().clamp(-127.0, 127.0) as i8 as u8));
        let axis = encode_axis(node.axis);
        bytes.extend(axis.to_le_bytes());
        let area = from_float16(float16(node.area, self.top_area), self.top_area);
        let both = (255.0 * code::both(&sums.lobes, node.area)).round() as u8;
        bytes.push(both);
        let lobes = Lobes { sums: &sums.lobes, area, axis: axis_of(axis), both: share(both) };
        self.book.encode(&lobes, bytes, pen);
    }

    fn centre(&self, place: [u16; 3]) -> Vec3 {
        self.cube.low + Vec3::from(place.map(f32::from)) * (self.cube.side / LAST)
    }

    fn sphere(&self, bytes: &[u8]) -> (Vec3, f32) {
        let centre = self.centre([0, 2, 4].map(|at| u16_at(bytes, at)));
        (centre, from_float16(u16_at(bytes, 6), self.cube.side))
    }

    /// A block's bytes, and its second sides'. Its records lie in its node's sphere, as it is decoded.
    fn encode_block(
        &self,
        node: &[u8],
        records: &[Record],
        bytes: &mut Vec<u8>,
        seconds: &mut Vec<u8>,
    ) {
        block::encode(self.ball(node), self.top_light, records, bytes, seconds);
    }

    /// A node's sphere and area.
    fn ball(&self, bytes: &[u8]) -> (Vec3, f32, f32) {
        let (centre, radius) = self.sphere(bytes);
        (centre, radius, from_float16(u16_at(bytes, 8), self.top_area))
    }
}

/// The share that a byte stands for.
fn share(byte: u8) -> f32 {
    f32::from(byte) / 255.0
}

fn signed(byte: u8) -> f32 {
    f32::from(byte as i8)
}

/// The bytes of a number.
#[inline]
fn number<const N: usize>(bytes: &[u8], at: usize) -> &[u8; N] {
    bytes[at..].first_chunk().unwrap_or(&[0; N])
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes(*number(bytes, at))
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(*number(bytes, at))
}

impl Compact {
    /// The tree whose parts lie in `bytes`, each at a start and of a length; `None` when numbers do
    /// not fit each other.
    pub(crate) fn of_bytes(
        format: Format,
        bytes: Bytes,
        parts: &[(usize, usize)],
        crown: Vec<Vec<u8>>,
        (records, seconds): (usize, Vec<u16>),
    ) -> Option<Self> {
        let counts = counts(records);
        let above = counts.iter().skip(PART_LEVELS).map(|n| n * format.node_bytes());
        if !above.eq(crown.iter().map(Vec::len)) {
            return None;
        }
        let part = |&(start, _): &(usize, usize)| Part { bytes: Arc::clone(&bytes), start };
        let parts = parts.iter().map(part).collect();
        let (whole, stride) = (format.starts(PART_BLOCKS), format.node_bytes());
        let format = Arc::new(format);
        Some(Self { format, parts, crown, records, seconds, counts, stride, whole })
    }

    /// The bytes of nodes that share a parent and a part.
    fn nodes_at(&self, level: usize, nodes: Range<usize>) -> &[u8] {
        let stride = self.stride;
        if level >= PART_LEVELS {
            return &self.crown[level - PART_LEVELS][nodes.start * stride..nodes.end * stride];
        }
        // 8^(levels above): how many nodes of the level a part has.
        let shift = FAN.ilog2() * (PART_LEVELS - 1 - level) as u32;
        let part = nodes.start >> shift;
        let at = self.starts(part)[level] + (nodes.start - (part << shift)) * stride;
        &self.part(part)[at..at + nodes.len() * stride]
    }

    fn starts(&self, part: usize) -> [usize; PART_LEVELS + 2] {
        let blocks = PART_BLOCKS.min(self.counts[0] - part * PART_BLOCKS);
        if blocks == PART_BLOCKS { self.whole } else { self.format.starts(blocks) }
    }

    fn part(&self, index: usize) -> &[u8] {
        let part = &self.parts[index];
        &(*part.bytes).as_ref()[part.start..]
    }

    /// Bytes of nodes, records and tables in memory, with what holds them.
    pub fn bytes(&self) -> usize {
        // A part's vector, its counts of owners, and its place in the list.
        const HOLDER: usize = 40 + size_of::<Part>();
        let records = (0..self.records).step_by(PART).map(|first| PART.min(self.records - first));
        let part = |(records, seconds)| self.format.part_bytes(records, seconds) + HOLDER;
        let parts: usize = records.zip(self.seconds.iter().copied()).map(part).sum();
        parts
            + 2 * self.seconds.capacity()
            + self.crown.iter().map(Vec::capacity).sum::<usize>()
            + self.format.book.size()
    }

    /// Living sides of all records.
    pub fn sides(&self) -> usize {
        self.records + self.seconds.iter().map(|n| usize::from(*n)).sum::<usize>()
    }

    /// Nodes of all levels.
    pub fn nodes(&self) -> usize {
        self.counts.iter().sum()
    }
}

impl Stored for Compact {
    fn counts(&self) -> &[usize] {
        &self.counts
    }

    type Siblings<'a> = Siblings<'a>;

    fn siblings(&self, level: usize, nodes: Range<usize>) -> Siblings<'_> {
        // Nodes of the level of parts share a parent in the crown, and lie in several parts.
        let bytes = match level == PART_LEVELS - 1 && nodes.len() > 1 {
            true => nodes.flat_map(|i| self.nodes_at(level, i..i + 1)).copied().collect(),
            false => Cow::Borrowed(self.nodes_at(level, nodes)),
        };
        Siblings { format: &self.format, bytes, stride: self.stride }
    }

    fn records(&self, block: usize, wanted: impl Fn(&Places) -> u32, each: impl FnMut(&Record)) {
        let ball = self.format.ball(self.nodes_at(0, block..block + 1));
        let (part, within) = (block / PART_BLOCKS, block % PART_BLOCKS);
        let [.., blocks, seconds] = self.starts(part);
        let bytes = self.part(part);
        let at = blocks + within * BLOCK_BYTES;
        let count = BLOCK.min(self.records - block * BLOCK);
        let second = &bytes[seconds..seconds + SECOND * usize::from(self.seconds[part])];
        Block::new(&bytes[at..at + BLOCK_BYTES], second, count, ball, self.format.top_light)
            .records(wanted, each);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{Gains, Recipe};
    use crate::file;
    use crate::packed::tests::{node, sheet};
    use crate::packed::{Floats, Packed, records};
    use crate::stream;
    use chiaro_basis::Run;

    fn both(n: u64) -> (Packed<Floats>, Packed<Compact>) {
        let all = records(&sheet(n));
        let exact = Packed::build(&all);
        let mut nodes = Vec::new();
        exact.each_node(|node, lobes| nodes.push((*node, *lobes)));
        let lobes: Vec<Lobes> = nodes.iter().map(|(n, l)| Lobes::new(l, n.area, n.axis)).collect();
        let recipe = Recipe::residual(Gains::Colours, true, 3, 2);
        let format = Format {
            book: Book::train(&lobes, &recipe, 1, &Run::default()).unwrap(),
            cube: Cube::around(Vec3::new(0.0, -0.2, 0.0), Vec3::ONE),
            top_area: 2.0,
            top_light: 4.0,
        };
        let mut builder = Builder::new(format);
        all.chunks(5000).for_each(|some| builder.add(some.to_vec()).unwrap());
        (exact, builder.done("").unwrap())
    }

    #[test]
    fn codes_span_the_brighter_side_of_surfels() {
        const BACK: [f32; 3] = [40.0, 20.0, 30.0];
        let mut all = records(&sheet(2000));
        all.iter_mut().filter(|r| r.alive[1]).for_each(|r| r.radiance[1] = BACK);
        let cube = Cube::around(Vec3::new(0.0, -0.2, 0.0), Vec3::ONE);
        let run = Run::default();
        let book = stream::book(&all, &Recipe::default(), &run).unwrap();
        let coded = stream::coded_in_memory(&all, cube, &book).unwrap();
        let mut backs = 0;
        for block in 0..coded.store.counts()[0] {
            coded.store.records(
                block,
                |_| u32::MAX,
                |r| {
                    backs += usize::from(r.alive[1]);
                    let near =
                        r.radiance[1].iter().zip(BACK).all(|(a, b)| (a / b - 1.0).abs() < 0.1);
                    assert!(near || !r.alive[1], "{:?}", r.radiance);
                },
            );
        }
        assert_eq!(backs, all.iter().filter(|r| r.alive[1]).count());
    }

    #[test]
    fn a_coded_tree_is_near_the_exact_one_in_a_tenth_of_the_memory() {
        let (exact, coded) = both(30_000);
        assert_eq!(exact.store.counts(), coded.store.counts());
        assert!((exact.leaf_radius / coded.leaf_radius - 1.0).abs() < 1e-6);
        for level in 0..exact.store.counts().len() {
            for index in 0..exact.store.counts()[level] {
                let a = node(&exact.store, level, index);
                let b = node(&coded.store, level, index);
                assert!(a.centre.distance(b.centre) + a.radius <= b.radius * 1.0001);
                assert!(b.radius < 1.01 * a.radius + 1e-5);
                assert!(a.mean.distance(b.mean) < 0.02 * a.radius + 1e-5);
                assert!((a.area / b.area - 1.0).abs() < 1e-3);
                assert!(a.axis.distance(b.axis) < 5e-3, "{} {}", a.axis, b.axis);
            }
        }
        for block in 0..exact.store.counts()[0] {
            let (mut a, mut b) = (Vec::new(), Vec::new());
            exact.store.records(block, |_| u32::MAX, |r| a.push(*r));
            coded.store.records(block, |_| u32::MAX, |r| b.push(*r));
            assert_eq!(a.len(), b.len());
            let radius = node(&exact.store, 0, block).radius;
            for (a, b) in a.iter().zip(&b) {
                assert!(a.position.distance(b.position) < 0.06 * radius);
                assert!(a.normal.dot(b.normal) > 0.99 && a.alive == b.alive);
                assert!((a.area / b.area - 1.0).abs() < 0.1);
                let living = a.alive.iter().zip(a.radiance.iter().zip(&b.radiance));
                for (_, (a, b)) in living.filter(|(alive, _)| **alive) {
                    let sum: f32 = a.iter().sum();
                    assert!((0..3).all(|c| (a[c] - b[c]).abs() < 0.16 * sum), "{a:?} {b:?}");
                }
            }
            // Together they are nearer than one by one.
            let light = |all: &[Record], side: usize| {
                let of = |r: &Record| Vec3::from(r.radiance[side]) * r.side_area(side);
                all.iter().map(of).sum::<Vec3>()
            };
            for side in 0..2 {
                let (a, b) = (light(&a, side), light(&b, side));
                // Of second sides a block may have one, whose rounding nothing makes up for.
                let most = [0.03, 0.06][side] * a.element_sum();
                assert!((a - b).abs().max_element() <= most, "{a} {b}");
            }
        }
        let bytes = coded.store.bytes() - coded.store.format.book.size();
        assert!(bytes < 11 * coded.store.records, "{}", bytes as f64 / coded.store.records as f64);
    }

    /// A tree file's bytes.
    fn file_of(n: u64) -> Vec<u8> {
        let (_, coded) = both(n);
        let mut bytes = Vec::new();
        let format = (*coded.store.format).clone();
        let sink: Sink = Box::new(|more: &[u8]| {
            bytes.extend(more);
            Ok(())
        });
        let mut builder = Builder::into_file(format, sink).unwrap();
        builder.add(records(&sheet(n))).unwrap();
        builder.done("a sheet").unwrap();
        drop(builder);
        bytes
    }

    #[test]
    fn a_tree_from_a_file_is_the_tree_in_memory() {
        let (_, coded) = both(12_000);
        let bytes = file_of(12_000);
        let (read, origin) = file::open(Arc::new(bytes), "t", &|| ()).unwrap();
        assert_eq!((origin.as_str(), read.leaf_radius), ("a sheet", coded.leaf_radius));
        assert_eq!(read.store.counts(), coded.store.counts());
        for level in 0..read.store.counts().len() {
            for index in 0..read.store.counts()[level] {
                assert_eq!(
                    read.store.nodes_at(level, index..index + 1),
                    coded.store.nodes_at(level, index..index + 1)
                );
            }
        }
        for block in 0..read.store.counts()[0] {
            let (mut a, mut b) = (Vec::new(), Vec::new());
            read.store.records(block, |_| u32::MAX, |r| a.push(r.radiance));
            coded.store.records(block, |_| u32::MAX, |r| b.push(r.radiance));
            assert_eq!(a, b);
        }
    }

    #[test]
    fn a_book_comes_back_from_its_file_and_damaged_ones_are_one_sentence() {
        let (_, coded) = both(3000);
        let bytes = file::book_bytes(&coded.store.format.book);
        let back = file::read_book(&bytes, "b").unwrap();
        assert_eq!(file::book_bytes(&back), bytes);
        let told = |bytes: &[u8]| match file::read_book(bytes, "b.book") {
            Ok(_) => String::new(),
            Err(e) => e.to_string(),
        };
        for length in [0, 11, 13, 17, 40, bytes.len() - 1] {
            assert!(told(&bytes[..length]).contains("b.book"), "{length}");
        }
        for i in 0..100 {
            let mut other = bytes.clone();
            let at = chiaro_basis::random::hash(6, i) as usize % other.len();
            other[at] ^= 1 << (i % 8);
            assert!(told(&other).contains("b.book"), "{at}");
        }
    }

    #[test]
    fn files_cut_off_or_altered_are_one_sentence() {
        let bytes = file_of(12_000);
        let told = |bytes: Vec<u8>| match file::open(Arc::new(bytes), "t.pbgi", &|| ()) {
            Ok(_) => String::new(),
            Err(e) => e.to_string(),
        };
        for length in [0, 5, 20, 40, 1000, bytes.len() / 2, bytes.len() - 9, bytes.len() - 1] {
            let text = told(bytes[..length].to_vec());
            assert!(text.contains("t.pbgi") && text.contains("bake"), "{length}: {text}");
        }
        for i in 0..300 {
            let mut other = bytes.clone();
            let at = chiaro_basis::random::hash(5, i) as usize % other.len();
            other[at] ^= 1 << (i % 8);
            assert!(told(other).contains("bake"), "{at}");
        }
    }
}
