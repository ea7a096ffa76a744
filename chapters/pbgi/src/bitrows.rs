//! [`BitRows`]: numbers of a few bits each, row after row without gaps (thesis, 6.5.3).
//!
//! Rows may be written by several threads at once, each once and in any order: bits are added to
//! words that begin as zeros, so that the result does not depend on the order.

use std::sync::atomic::{AtomicU64, Ordering};

/// Rows of numbers; the same widths in every row.
#[derive(Debug, Default)]
pub(crate) struct BitRows {
    words: Vec<AtomicU64>,
    widths: Vec<u32>,
    row: usize,
}

impl BitRows {
    /// So many rows of zeros; widths are at most 32 bits.
    pub(crate) fn new(rows: usize, widths: Vec<u32>) -> Self {
        let row = widths.iter().sum::<u32>() as usize;
        let words = (rows * row).div_ceil(64) + 1;
        Self { words: (0..words).map(|_| AtomicU64::new(0)).collect(), widths, row }
    }

    /// Writes a row that has not been written before.
    pub(crate) fn write(&self, row: usize, numbers: impl Iterator<Item = u32>) {
        let mut at = row * self.row;
        for (number, width) in numbers.zip(&self.widths) {
            let bits = u64::from(number) & ((1 << width) - 1);
            let (word, shift) = (at / 64, at % 64);
            self.words[word].fetch_or(bits << shift, Ordering::Relaxed);
            if shift + *width as usize > 64 {
                self.words[word + 1].fetch_or(bits >> (64 - shift), Ordering::Relaxed);
            }
            at += *width as usize;
        }
    }

    /// The numbers of a row.
    pub(crate) fn read(&self, row: usize) -> impl Iterator<Item = u32> + '_ {
        let mut at = row * self.row;
        self.widths.iter().map(move |width| {
            let (word, shift) = (at / 64, at % 64);
            let low = self.words[word].load(Ordering::Relaxed) >> shift;
            let high = match shift {
                0 => 0,
                _ => self.words[word + 1].load(Ordering::Relaxed) << (64 - shift),
            };
            at += *width as usize;
            ((low | high) & ((1 << width) - 1)) as u32
        })
    }

    /// Bytes of all rows.
    pub(crate) fn bytes(&self) -> usize {
        8 * self.words.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_in_whatever_order_they_were_written() {
        let widths = vec![7, 14, 32, 1, 10];
        let rows = BitRows::new(100, widths.clone());
        let number = |row: usize, k: usize| {
            let bits = chiaro_basis::random::hash(row as u64, k as u64) as u32;
            (u64::from(bits) & ((1u64 << widths[k]) - 1)) as u32
        };
        for i in 0..100 {
            let row = i * 37 % 100;
            rows.write(row, (0..5).map(|k| number(row, k)));
        }
        for row in 0..100 {
            assert!(rows.read(row).eq((0..5).map(|k| number(row, k))), "{row}");
        }
        assert!(rows.bytes() <= 100 * 64 / 8 + 16);
    }
}
