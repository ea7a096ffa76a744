//! [`Builder`]: records, part by part, to a coded tree in memory or to the bytes of a file.
//!
//! Records come along the cube's curve; a part is coded on all threads as soon as it is whole, and the
//! levels above the parts at the end. Into a file, no part stays in memory.

use super::{Compact, Format, PART_BLOCKS, Part};
use crate::block::SECOND;
use crate::code::Pen;
use crate::curve::Cube;
use crate::file;
use crate::packed::{
    PART, PART_LEVELS, Packed, Record, Store, Sums, counts, crown, leaf_radius, part,
};
use chiaro_basis::Result;
use rayon::prelude::*;
use std::sync::Arc;

/// Collects a part's bytes.
struct Writer<'a> {
    format: &'a Format,
    levels: Vec<Vec<u8>>,
    blocks: Vec<u8>,
    seconds: Vec<u8>,
    pen: Pen,
}

impl<'a> Writer<'a> {
    fn new(format: &'a Format) -> Self {
        let (blocks, seconds) = (Vec::new(), Vec::new());
        Self { format, levels: Vec::new(), blocks, seconds, pen: Pen::default() }
    }
}

impl Store for Writer<'_> {
    fn block(&mut self, sums: &Sums, records: &[Record]) {
        let mut node = Vec::with_capacity(64);
        self.format.encode(sums, &mut node, &mut self.pen);
        self.format.encode_block(&node, records, &mut self.blocks, &mut self.seconds);
        self.levels.resize(self.levels.len().max(1), Vec::new());
        self.levels[0].extend(node);
    }

    fn node(&mut self, level: usize, sums: &Sums) {
        // A block has stored its node itself.
        if level > 0 {
            self.levels.resize(self.levels.len().max(level + 1), Vec::new());
            self.format.encode(sums, &mut self.levels[level], &mut self.pen);
        }
    }
}

/// Takes the bytes of a file, in order.
pub type Sink<'a> = Box<dyn FnMut(&[u8]) -> Result<()> + 'a>;

/// A tree that grows part by part, in memory or into a file.
pub struct Builder<'a> {
    tree: Compact,
    roots: Vec<Sums>,
    waiting: Vec<Record>,
    area: f64,
    sink: Option<Sink<'a>>,
    written: u64,
}

impl<'a> Builder<'a> {
    /// An empty tree.
    pub fn new(format: Format) -> Self {
        let (whole, stride) = (format.starts(PART_BLOCKS), format.node_bytes());
        let tree = Compact {
            format: Arc::new(format),
            parts: Vec::new(),
            crown: Vec::new(),
            records: 0,
            seconds: Vec::new(),
            counts: Vec::new(),
            stride,
            whole,
        };
        let (roots, waiting) = (Vec::new(), Vec::new());
        Self { tree, roots, waiting, area: 0.0, sink: None, written: 0 }
    }

    /// An empty tree whose parts go to a file as they are made.
    pub fn into_file(format: Format, sink: Sink<'a>) -> Result<Self> {
        let mut builder = Self { sink: Some(sink), ..Self::new(format) };
        builder.write(&file::head())?;
        Ok(builder)
    }

    /// The scene's cube, along whose curve records come.
    pub fn cube(&self) -> Cube {
        self.tree.format.cube
    }

    fn write(&mut self, bytes: &[u8]) -> Result<()> {
        self.written += bytes.len() as u64;
        self.sink.as_mut().map_or(Ok(()), |sink| sink(bytes))
    }

    /// Adds records that follow on the curve; whole parts are coded at once, the rest waits.
    pub fn add(&mut self, records: Vec<Record>) -> Result<()> {
        self.waiting.extend(records);
        let whole = self.waiting.len() / PART * PART;
        let rest = self.waiting.split_off(whole);
        let ready = std::mem::replace(&mut self.waiting, rest);
        self.store(&ready)
    }

    fn store(&mut self, records: &[Record]) -> Result<()> {
        let format = &self.tree.format;
        let parts: Vec<(Part, u16, Sums)> = records
            .par_chunks(PART)
            .map(|records| {
                let mut writer = Writer::new(format);
                let root = part(records, &mut writer);
                let seconds = (writer.seconds.len() / SECOND) as u16;
                let mut bytes = Vec::with_capacity(format.part_bytes(records.len(), seconds));
                writer.levels.iter().for_each(|level| bytes.extend(level));
                bytes.extend(&writer.blocks);
                bytes.extend(&writer.seconds);
                (Part { bytes: Arc::new(bytes), start: 0 }, seconds, root)
            })
            .collect();
        for (part, seconds, root) in parts {
            if self.sink.is_some() {
                let bytes = (*part.bytes).as_ref();
                self.write(bytes)?;
                self.write(&file::checksum(bytes).to_le_bytes())?;
            } else {
                self.tree.parts.push(part);
            }
            self.tree.seconds.push(seconds);
            self.roots.push(root);
        }
        self.tree.records += records.len();
        self.area += records.iter().map(|r| f64::from(r.area)).sum::<f64>();
        Ok(())
    }

    /// Codes what waits and the levels above the parts. The tree of a file has no parts here:
    /// [`open`](crate::file::open) it. `origin` says in the file what the tree was made from.
    pub fn done(&mut self, origin: &str) -> Result<Packed<Compact>> {
        let rest = std::mem::take(&mut self.waiting);
        self.store(&rest)?;
        let format = Arc::clone(&self.tree.format);
        let mut writer = Writer::new(&format);
        crown(&self.roots, &mut writer);
        let tree = &mut self.tree;
        // What searched for words is not needed any more.
        tree.format = Arc::new(Format { book: format.book.to_be_read(), ..(*format).clone() });
        tree.seconds.shrink_to_fit();
        tree.crown = writer.levels.into_iter().skip(PART_LEVELS).collect();
        tree.counts = counts(tree.records);
        let leaf_radius = leaf_radius(self.area, tree.records);
        let tree = Packed { store: tree.clone(), leaf_radius };
        if self.sink.is_some() {
            let before = self.written;
            self.write(&file::tail(&tree, origin, before))?;
        }
        Ok(tree)
    }
}
