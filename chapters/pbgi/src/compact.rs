//! [`Compact`]: the packed tree in some ten bytes a surfel (thesis, 6.5.3).
//!
//! ```text
//! record, 8 bytes   position in the block's sphere 3 x 8 bits, normal 2 x 8 (octahedral),
//!                   area 4 (quarters of an octave about the block's mean), colour 20
//! block             16 records, and the gain of their colours, 2 bytes
//! node              centre 3 x 21 bits in the scene's cube, radius 16 (rounded up), area 16,
//!                   mean 3 x 8 in the sphere, axis 2 x 12 (octahedral) and 8 (length), the
//!                   lobes' code (crate::code)
//! ```
//!
//! A part's levels and blocks lie side by side, as they do in a file, so that what is built, what
//! is read and what is mapped from a disk are the same bytes, little-endian everywhere.
//! Numbers that bytes name are clamped to what is there: any bytes give some picture.

mod builder;

pub use builder::{Builder, Sink};

use crate::bits::{
    Carry, axis_of, colour_of, encode_axis, float16, float16_above, from_float16, grid, octahedral,
};
use crate::code::{Book, Decoded, Lobes, Pen, Recipe};
use crate::curve::Cube;
use crate::packed::{BLOCK, FAN, PART, PART_LEVELS, Places, Record, Spheres, Stored, Sums, counts};
use crate::tree::Node;
use chiaro_basis::math::{Vec3, vec3};
use std::ops::Range;
use std::sync::{Arc, LazyLock};

/// Bytes of a node before its code.
const HEAD: usize = 19;
/// Bytes of a record, and of a block.
const RECORD: usize = 8;
const BLOCK_BYTES: usize = BLOCK * RECORD + 2;
/// Blocks of a part.
const PART_BLOCKS: usize = PART / BLOCK;

/// Areas over a block's mean, quarters of an octave apart.
static RATIOS: LazyLock<[f32; 16]> =
    LazyLock::new(|| std::array::from_fn(|i| ((i as f32 - 8.0) / 4.0).exp2()));

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
    counts: Vec<usize>,
    /// Where the levels of a whole part begin, and then its blocks.
    whole: [usize; PART_LEVELS + 1],
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

    /// Bytes of a part of so many records.
    pub fn part_bytes(&self, records: usize) -> usize {
        let blocks = records.div_ceil(BLOCK);
        self.starts(blocks)[PART_LEVELS] + blocks * BLOCK_BYTES
    }

    /// Where in a part of so many blocks its levels begin, and then its blocks.
    fn starts(&self, blocks: usize) -> [usize; PART_LEVELS + 1] {
        let mut starts = [0; PART_LEVELS + 1];
        for level in 0..PART_LEVELS {
            let nodes = blocks.div_ceil(FAN.pow(level as u32));
            starts[level + 1] = starts[level] + nodes * self.node_bytes();
        }
        starts
    }

    /// A node's bytes.
    fn encode(&self, sums: &Sums, bytes: &mut Vec<u8>, pen: &mut Pen) {
        let node = &sums.node;
        let last = ((1u64 << 21) - 1) as f32;
        let place = (node.centre - self.cube.low) * (last / self.cube.side);
        let [x, y, z] = place.to_array().map(|c| c.clamp(0.0, last).round() as u64);
        bytes.extend((x | y << 21 | z << 42).to_le_bytes());
        let centre = self.centre(x | y << 21 | z << 42);
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
        let lobes = Lobes { sums: &sums.lobes, area, axis: axis_of(axis) };
        self.book.encode(&lobes, bytes, pen);
    }

    fn centre(&self, code: u64) -> Vec3 {
        let last = (1u64 << 21) - 1;
        let at = |shift: u32| (code >> shift & last) as f32;
        self.cube.low + vec3(at(0), at(21), at(42)) * (self.cube.side / last as f32)
    }

    fn sphere(&self, bytes: &[u8]) -> (Vec3, f32) {
        let centre = self.centre(u64_at(bytes, 0));
        (centre, from_float16(u16_at(bytes, 8), self.cube.side))
    }

    fn decode(&self, bytes: &[u8]) -> (Node, Decoded) {
        let (centre, radius) = self.sphere(bytes);
        let area = from_float16(u16_at(bytes, 10), self.top_area);
        let mean = vec3(signed(bytes[12]), signed(bytes[13]), signed(bytes[14])) * (radius / 127.0);
        let axis = axis_of(u32_at(bytes, 15));
        let node = Node { centre, radius, mean: centre + mean, area, axis, ..Node::default() };
        (node, self.book.decode(&bytes[HEAD..], area, axis))
    }

    /// A block's bytes. Its records lie in its node's sphere, as it is decoded.
    fn encode_block(&self, node: &[u8], records: &[Record], bytes: &mut Vec<u8>) {
        let (centre, radius) = self.sphere(node);
        let area = from_float16(u16_at(node, 10), self.top_area) / records.len() as f32;
        let sum = |r: &Record| r.radiance[0].iter().sum::<f32>();
        let gain = float16_above(records.iter().map(sum).fold(0.0, f32::max), self.top_light);
        bytes.extend(gain.to_le_bytes());
        let gain = from_float16(gain, self.top_light);
        // What rounding takes from a record's area and colour goes to the next.
        let (mut left, mut carry) = (0.0, Carry::default());
        for r in records {
            let place = (r.position - centre) * (127.0 / radius.max(f32::MIN_POSITIVE));
            let [x, y, z] = place.to_array().map(|c| c.round().clamp(-127.0, 127.0) as i8 as u8);
            let [nx, ny] = octahedral(r.normal).map(|c| grid(c, 8) as u8);
            let wanted = (r.area + left).max(f32::MIN_POSITIVE) / area;
            let ratio = (4.0 * wanted.log2()).round().clamp(-8.0, 7.0) + 8.0;
            let most = 0.25 * r.area;
            left = (left + r.area - area * RATIOS[ratio as usize]).clamp(-most, most);
            let code = u64::from(u32::from_le_bytes([x, y, z, nx]))
                | u64::from(ny) << 32
                | (ratio as u64) << 40
                | carry.encode(r.radiance[0], gain) << 44;
            bytes.extend(code.to_le_bytes());
        }
        bytes.resize(bytes.len() + (BLOCK - records.len()) * RECORD, 0);
    }
}

/// Bytes a record of a large tree that is coded so, without its tables.
pub(crate) fn bytes_a_record(recipe: &Recipe) -> f64 {
    let nodes = (HEAD + recipe.bytes()) as f64 * FAN as f64 / (FAN - 1) as f64;
    (nodes + BLOCK_BYTES as f64) / BLOCK as f64
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

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(*number(bytes, at))
}

impl Compact {
    /// The tree whose parts lie in `bytes`, each at a start and of a length; `None` when numbers do
    /// not fit each other.
    pub(crate) fn of_bytes(
        format: Format,
        bytes: Bytes,
        parts: &[(usize, usize)],
        crown: Vec<Vec<u8>>,
        records: usize,
    ) -> Option<Self> {
        let counts = counts(records);
        let above = counts.iter().skip(PART_LEVELS).map(|n| n * format.node_bytes());
        if !above.eq(crown.iter().map(Vec::len)) {
            return None;
        }
        let part = |&(start, _): &(usize, usize)| Part { bytes: Arc::clone(&bytes), start };
        let parts = parts.iter().map(part).collect();
        let whole = format.starts(PART_BLOCKS);
        Some(Self { format: Arc::new(format), parts, crown, records, counts, whole })
    }

    /// The bytes of nodes that share a parent.
    fn nodes_at(&self, level: usize, nodes: Range<usize>) -> &[u8] {
        let stride = self.format.node_bytes();
        if level >= PART_LEVELS {
            return &self.crown[level - PART_LEVELS][nodes.start * stride..nodes.end * stride];
        }
        // 8^(levels above): how many nodes of the level a part has.
        let shift = FAN.ilog2() * (PART_LEVELS - 1 - level) as u32;
        let part = nodes.start >> shift;
        let at = self.starts(part)[level] + (nodes.start - (part << shift)) * stride;
        &self.part(part)[at..at + nodes.len() * stride]
    }

    fn node_at(&self, level: usize, index: usize) -> &[u8] {
        self.nodes_at(level, index..index + 1)
    }

    fn starts(&self, part: usize) -> [usize; PART_LEVELS + 1] {
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
        let part = |first: usize| self.format.part_bytes(PART.min(self.records - first)) + HOLDER;
        let parts: usize = (0..self.records).step_by(PART).map(part).sum();
        parts + self.crown.iter().map(Vec::capacity).sum::<usize>() + self.format.book.size()
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

    fn spheres(&self, level: usize, nodes: Range<usize>) -> Spheres {
        let mut spheres = Spheres::default();
        // Nodes of the level of parts share a parent in the crown, and lie in several parts.
        let parts = if level == PART_LEVELS - 1 { nodes.len() } else { 1 };
        let of_each = nodes.len() / parts.max(1);
        for i in 0..parts {
            let first = nodes.start + i * of_each;
            let bytes = self.nodes_at(level, first..first + of_each);
            for (k, node) in bytes.chunks_exact(self.format.node_bytes()).enumerate() {
                let (centre, radius) = self.format.sphere(node);
                spheres.set(i + k, centre, radius);
            }
        }
        spheres
    }

    fn node(&self, level: usize, index: usize) -> (Node, Decoded) {
        self.format.decode(self.node_at(level, index))
    }

    fn records(
        &self,
        block: usize,
        wanted: impl Fn(&Places) -> u32,
        mut each: impl FnMut(&Record),
    ) {
        let node = self.node_at(0, block);
        let (part, within) = (block / PART_BLOCKS, block % PART_BLOCKS);
        let at = self.starts(part)[PART_LEVELS] + within * BLOCK_BYTES;
        let bytes = &self.part(part)[at..at + BLOCK_BYTES];
        let codes: [u64; BLOCK] = std::array::from_fn(|k| u64_at(bytes, 2 + k * RECORD));
        let places = places(&codes, self.format.sphere(node));
        let count = BLOCK.min(self.records - block * BLOCK);
        let mut left = wanted(&places) & ((1 << count) - 1);
        let gain = from_float16(u16_at(bytes, 0), self.format.top_light);
        let area = from_float16(u16_at(node, 10), self.format.top_area) / count as f32;
        while left != 0 {
            let k = left.trailing_zeros() as usize;
            left &= left - 1;
            let rest = codes[k] >> 40;
            let lane = |axes: &[[f32; BLOCK]; 3]| vec3(axes[0][k], axes[1][k], axes[2][k]);
            each(&Record {
                position: lane(&places.position),
                normal: lane(&places.normal).normalize_or(Vec3::Z),
                area: area * RATIOS[rest as usize & 15],
                alive: [true, false],
                albedo: [0.0; 3],
                radiance: [colour_of(rest >> 4, gain), [0.0; 3]],
            });
        }
    }
}

/// Positions and normals of the records of a block in a sphere.
#[allow(clippy::needless_range_loop, reason = "lanes are vectors of the processor")]
fn places(codes: &[u64; BLOCK], (centre, radius): (Vec3, f32)) -> Places {
    let mut places = Places::default();
    let step = radius / 127.0;
    let low = codes.map(|c| c as u32);
    let byte = |code: u32, shift: u32| (code << (24 - shift)) as i32 >> 24;
    for (i, position) in places.position.iter_mut().enumerate() {
        for k in 0..BLOCK {
            position[k] = centre[i] + byte(low[k], 8 * i as u32) as f32 * step;
        }
    }
    let ys = codes.map(|c| (c >> 32) as u32 & 255);
    let [nx, ny, nz] = &mut places.normal;
    for k in 0..BLOCK {
        let x = (low[k] >> 24) as f32 * (1.0 / 127.0) - 1.0;
        let y = ys[k] as f32 * (1.0 / 127.0) - 1.0;
        let z = 1.0 - x.abs() - y.abs();
        let under = (-z).max(0.0);
        nx[k] = x - under.copysign(x);
        ny[k] = y - under.copysign(y);
        nz[k] = z;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::Gains;
    use crate::file;
    use crate::packed::tests::sheet;
    use crate::packed::{Floats, Packed, records};
    use chiaro_basis::Run;

    fn both(n: u64) -> (Packed<Floats>, Packed<Compact>) {
        let all = records(&sheet(n));
        let exact = Packed::build(&all);
        let mut nodes = Vec::new();
        exact.each_node(|node, lobes| nodes.push((*node, *lobes)));
        let lobes: Vec<Lobes> =
            nodes.iter().map(|(n, l)| Lobes { sums: l, area: n.area, axis: n.axis }).collect();
        let recipe = Recipe::residual(Gains::Colours, true, 3, 2);
        let format = Format {
            book: Book::train(&lobes, &recipe, 1, &Run::default()).unwrap(),
            cube: Cube::around(vec3(0.0, -0.2, 0.0), Vec3::ONE),
            top_area: 2.0,
            top_light: 4.0,
        };
        let mut builder = Builder::new(format);
        all.chunks(5000).for_each(|some| builder.add(some.to_vec()).unwrap());
        (exact, builder.done("").unwrap())
    }

    #[test]
    fn a_coded_tree_is_near_the_exact_one_in_a_tenth_of_the_memory() {
        let (exact, coded) = both(30_000);
        assert_eq!(exact.store.counts(), coded.store.counts());
        assert!((exact.leaf_radius / coded.leaf_radius - 1.0).abs() < 1e-6);
        for level in 0..exact.store.counts().len() {
            for index in 0..exact.store.counts()[level] {
                let (a, _) = exact.store.node(level, index);
                let (b, _) = coded.store.node(level, index);
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
            let radius = exact.store.node(0, block).0.radius;
            for (a, b) in a.iter().zip(&b) {
                assert!(a.position.distance(b.position) < 0.01 * radius);
                assert!(a.normal.dot(b.normal) > 0.9998);
                assert!((a.area / b.area - 1.0).abs() < 0.1);
                let sum: f32 = a.radiance[0].iter().sum();
                for c in 0..3 {
                    assert!((a.radiance[0][c] - b.radiance[0][c]).abs() < 0.08 * sum);
                }
            }
            // Together they are nearer than one by one.
            let light = |all: &[Record]| {
                let of = |r: &Record| Vec3::from(r.radiance[0]) * r.area;
                all.iter().map(of).sum::<Vec3>()
            };
            let (a, b) = (light(&a), light(&b));
            assert!((a - b).abs().max_element() < 0.03 * a.element_sum(), "{a} {b}");
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
                assert_eq!(read.store.node_at(level, index), coded.store.node_at(level, index));
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
