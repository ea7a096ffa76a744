//! Where the pixels of a part lie: windows, channels, scan line blocks, tiles and their levels.

use exr::meta::BlockDescription;
use exr::meta::attribute::{
    ChannelDescription, Compression, LevelMode, LineOrder, SampleType, Text, TileDescription,
};
use exr::meta::header::Header;
use exr::prelude::Vec2;

/// A rectangle of pixels on OpenEXR's endless canvas: its upper left corner and its size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Window {
    pub(super) x: i64,
    pub(super) y: i64,
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Window {
    pub(super) fn pixels(&self) -> u64 {
        self.width as u64 * self.height as u64
    }
}

/// A channel as a header lists it.
#[derive(Clone, Debug)]
pub(super) struct Channel {
    pub(super) name: String,
    pub(super) sample: SampleType,
    /// Whether lossy compressions treat the values as evenly spread, not as light.
    pub(super) linear: bool,
}

/// Tiles instead of scan lines: their size, and the levels that follow the picture itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tiles {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) levels: LevelMode,
    pub(super) round_up: bool,
}

/// One part of a file: a picture with its own window and channels.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) name: Option<String>,
    pub(super) window: Window,
    pub(super) display: Window,
    pub(super) channels: Vec<Channel>,
    pub(super) compression: Compression,
    pub(super) tiles: Option<Tiles>,
    pub(super) attributes: Vec<(String, String)>,
}

/// A rectangle of a part's data window that one chunk holds, and its number among its kind.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub(super) index: usize,
    pub(super) x: usize,
    pub(super) y: usize,
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Part {
    /// Bytes of one pixel before compression.
    pub(super) fn bytes_per_pixel(&self) -> usize {
        self.channels.iter().map(|c| c.sample.bytes_per_sample()).sum()
    }

    /// Width and height of a whole block.
    fn block_size(&self) -> (usize, usize) {
        match self.tiles {
            Some(tiles) => (tiles.width, tiles.height),
            None => (self.window.width, self.compression.scan_lines_per_block()),
        }
    }

    /// Blocks in a row and in a column.
    fn grid(&self) -> (usize, usize) {
        let (width, height) = self.block_size();
        (self.window.width.div_ceil(width), self.window.height.div_ceil(height))
    }

    /// Blocks of the picture itself, without its smaller levels.
    pub(super) fn block_count(&self) -> usize {
        let (columns, rows) = self.grid();
        columns * rows
    }

    /// The block in this column and row.
    pub(super) fn block(&self, column: usize, row: usize) -> Option<Block> {
        let (columns, rows) = self.grid();
        if column >= columns || row >= rows {
            return None;
        }
        let (width, height) = self.block_size();
        let (x, y) = (column * width, row * height);
        Some(Block {
            index: row * columns + column,
            x,
            y,
            width: width.min(self.window.width - x),
            height: height.min(self.window.height - y),
        })
    }

    /// The block of scan lines that begins at `y` of the canvas.
    pub(super) fn scan_line_block(&self, y: i64) -> Option<Block> {
        let lines = self.compression.scan_lines_per_block();
        let row =
            usize::try_from(y - self.window.y).ok().filter(|row| row.is_multiple_of(lines))?;
        self.block(0, row / lines)
    }

    /// Entries in this part's table of chunks: all blocks of all levels.
    pub(super) fn chunk_count(&self) -> usize {
        let Some(tiles) = self.tiles else { return self.block_count() };
        let across = levels(self.window.width, tiles.width, tiles.round_up);
        let down = levels(self.window.height, tiles.height, tiles.round_up);
        match tiles.levels {
            LevelMode::Singular => self.block_count(),
            LevelMode::RipMap => across.iter().sum::<usize>() * down.iter().sum::<usize>(),
            LevelMode::MipMap => {
                let level = |counts: &[usize], i: usize| counts.get(i).copied().unwrap_or(1);
                let count = across.len().max(down.len());
                (0..count).map(|i| level(&across, i) * level(&down, i)).sum()
            }
        }
    }

    /// What the compression library needs to know of this part.
    pub(super) fn library_header(&self) -> Header {
        let channel = |c: &Channel| {
            ChannelDescription::new(
                Text::from_slice_unchecked(c.name.as_bytes()),
                c.sample,
                c.linear,
            )
        };
        let size = Vec2(self.window.width, self.window.height);
        let blocks = self.tiles.map_or(BlockDescription::ScanLines, |tiles| {
            BlockDescription::Tiles(TileDescription {
                tile_size: Vec2(tiles.width, tiles.height),
                level_mode: LevelMode::Singular,
                rounding_mode: exr::math::RoundingMode::Down,
            })
        });
        Header::new(
            Text::from_slice_unchecked(b""),
            size,
            self.channels.iter().map(channel).collect(),
        )
        .with_encoding(self.compression, blocks, LineOrder::Increasing)
    }
}

/// Tiles along a side of each level, the level halving until it is one pixel.
fn levels(mut length: usize, tile: usize, round_up: bool) -> Vec<usize> {
    let mut counts = vec![length.div_ceil(tile)];
    while length > 1 {
        length = if round_up { length.div_ceil(2) } else { length / 2 };
        counts.push(length.div_ceil(tile));
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(width: usize, height: usize, tiles: Option<Tiles>) -> Part {
        let window = Window { x: 0, y: -5, width, height };
        Part {
            name: None,
            window,
            display: window,
            channels: vec![],
            compression: Compression::ZIP16,
            tiles,
            attributes: vec![],
        }
    }

    #[test]
    fn chunks_are_counted_as_the_library_counts_them() {
        for (width, height) in [(1, 1), (37, 20), (64, 64), (100, 3)] {
            for round_up in [false, true] {
                for levels in [LevelMode::Singular, LevelMode::MipMap, LevelMode::RipMap] {
                    let tiles = Tiles { width: 16, height: 8, levels, round_up };
                    let ours = part(width, height, Some(tiles));
                    let rounding_mode = match round_up {
                        true => exr::math::RoundingMode::Up,
                        false => exr::math::RoundingMode::Down,
                    };
                    let theirs = BlockDescription::Tiles(TileDescription {
                        tile_size: Vec2(16, 8),
                        level_mode: levels,
                        rounding_mode,
                    });
                    let header = ours.library_header().with_encoding(
                        Compression::ZIP16,
                        theirs,
                        LineOrder::Increasing,
                    );
                    assert_eq!(
                        ours.chunk_count(),
                        header.chunk_count,
                        "{width} {height} {tiles:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn scan_lines_are_found_from_the_window_on() {
        let part = part(10, 40, None);
        assert_eq!(part.block_count(), 3);
        let last = part.scan_line_block(27).unwrap();
        assert_eq!((last.index, last.y, last.width, last.height), (2, 32, 10, 8));
        assert!(part.scan_line_block(-6).is_none());
        assert!(part.scan_line_block(0).is_none());
        assert!(part.scan_line_block(43).is_none());
    }
}
