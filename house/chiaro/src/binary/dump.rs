//! `--dump-graph`: the very graph of a picture and its cut as NumPy arrays, so that anyone may cut
//! it again with another solver.
//!
//! | file | shape, type | holds |
//! |---|---|---|
//! | `terminal.npy` | (H, W, 2) int32 | capacities to white (paid when black), to black (paid when white) |
//! | `neighbour.npy` | (H, W, 4) int32 | capacities to E, SE, S, SW, either way |
//! | `mask.npy` | (H, W) uint8 | 1 where a pixel is a node |
//! | `labels.npy` | (H, W) uint8 | 1 white, 0 black or no node; the cut's own, before the island rule |
//!
//! What leaves the picture or touches no node is 0.

use crate::film::Target;
use crate::record::Output;
use crate::write;
use chiaro_basis::{Error, Result};
use chiaro_binary::{EDGES, Graph, Labels};
use chiaro_image::Plane;
use chiaro_image::codec::{write_npy, write_npy_labels};
use std::path::{Path, PathBuf};

/// Says early that a folder cannot be.
pub(crate) fn check(folder: Option<&Path>) -> Result<()> {
    match folder.filter(|f| f.exists() && !f.is_dir()) {
        Some(file) => Err(Error::output(file.display().to_string(), "is a file; name a folder")),
        None => Ok(()),
    }
}

/// Writes the graph of a picture into `folder`, which is made if missing.
pub(crate) fn graph(folder: &Path, graph: &Graph, cut: &Labels) -> Result<Vec<Output>> {
    let (mask, terminal) = (&graph.mask, &graph.terminal);
    let terminal = terminal.zip(mask, |t, m| if *m { *t } else { [0; 2] })?;
    let neighbour = between_nodes(&graph.neighbour, mask);
    let files = [
        ("terminal.npy", write_npy(&terminal)),
        ("neighbour.npy", write_npy(&neighbour)),
        ("mask.npy", write_npy_labels(mask)),
        ("labels.npy", write_npy_labels(&cut.white)),
    ];
    files.iter().map(|(name, bytes)| write::whole(&folder.join(name), bytes)).collect()
}

/// The folder for the graph of a frame: `folder` itself for one picture, a numbered folder in it
/// for a frame of a film.
pub(crate) fn folder(folder: &Path, target: &Target, frame: u32) -> PathBuf {
    match target {
        Target::Single(_) => folder.into(),
        Target::Pattern(_) | Target::Animation(_) => folder.join(format!("{frame:04}")),
    }
}

/// The capacities of the edges that have a node at both ends; 0 for the others.
fn between_nodes(neighbour: &Plane<[i32; 4]>, mask: &Plane<bool>) -> Plane<[i32; 4]> {
    let (width, height) = mask.size();
    let node = |x: usize, y: usize, (dx, dy): (isize, isize)| {
        mask.at(x as isize + dx, y as isize + dy) == Some(&true)
    };
    Plane::from_fn(width, height, |x, y| {
        let there = |e: usize| node(x, y, (0, 0)) && node(x, y, EDGES[e]);
        std::array::from_fn(|e| if there(e) { neighbour[(x, y)][e] } else { 0 })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_that_leave_the_picture_or_the_mask_are_zero() {
        let mask = Plane::from_pixels(2, 2, vec![true, true, true, false]);
        let dumped = between_nodes(&Plane::filled(2, 2, [5, 6, 7, 8]), &mask);
        assert_eq!(dumped.pixels(), [[5, 0, 7, 0], [0, 0, 0, 8], [0; 4], [0; 4]]);
    }
}
