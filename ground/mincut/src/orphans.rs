//! Orphans by distance: the lowest comes first.
//!
//! A list for every distance, linked through one stack that is emptied when nobody waits.

/// Nodes that lost their parent.
#[derive(Default)]
pub(crate) struct Orphans {
    /// For each distance one more than the last link of its list, zero if the list is empty.
    first: Vec<u32>,
    /// A node, and the link before it as in `first`.
    links: Vec<(u32, u32)>,
    lowest: usize,
    waiting: usize,
}

impl Orphans {
    /// Adds `v` at `distance`.
    #[inline(always)]
    pub(crate) fn push(&mut self, v: usize, distance: usize) {
        if self.first.len() <= distance {
            self.first.resize(distance + 64, 0);
        }
        self.links.push((v as u32, self.first[distance]));
        self.first[distance] = self.links.len() as u32;
        self.waiting += 1;
        self.lowest = self.lowest.min(distance);
    }

    /// Takes the orphan at the lowest distance, the last added first.
    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<usize> {
        if self.waiting == 0 {
            self.links.clear();
            self.lowest = usize::MAX;
            return None;
        }
        while self.first[self.lowest] == 0 {
            self.lowest += 1;
        }
        let (v, next) = self.links[self.first[self.lowest] as usize - 1];
        self.first[self.lowest] = next;
        self.waiting -= 1;
        Some(v as usize)
    }
}
