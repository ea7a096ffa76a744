//! The nodes of a level that wait to grow, in blocks.
//!
//! Levels come and go; their blocks go back to a pool as they are grown, so that memory follows the
//! nodes that wait and never doubles.

/// Nodes in a block.
const BLOCK: usize = 2048;

/// Empty blocks.
pub(crate) type Pool = Vec<Vec<u32>>;

/// Nodes that wait.
#[derive(Default)]
pub(crate) struct Level {
    full: Vec<Vec<u32>>,
    last: Vec<u32>,
}

impl Level {
    #[inline(always)]
    pub(crate) fn push(&mut self, v: usize, pool: &mut Pool) {
        if self.last.len() == self.last.capacity() {
            self.begin_block(pool);
        }
        self.last.push(v as u32);
    }

    #[cold]
    fn begin_block(&mut self, pool: &mut Pool) {
        let block = pool.pop().unwrap_or_else(|| Vec::with_capacity(BLOCK));
        let full = std::mem::replace(&mut self.last, block);
        if !full.is_empty() {
            self.full.push(full);
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.last.is_empty()
    }

    /// All nodes, in the order in which they came.
    pub(crate) fn blocks(self) -> impl Iterator<Item = Vec<u32>> {
        self.full.into_iter().chain([self.last])
    }
}
