//! [`Ring`]: the spokes of a vertex in order.

use super::{NONE, Surface, next, previous};

/// The edges at a vertex, counter-clockwise seen from the front, with their far ends.
#[derive(Clone, Debug, Default)]
pub struct Ring {
    /// Edges out of the vertex.
    pub spokes: Vec<u32>,
    /// The vertices at their other ends.
    pub around: Vec<u32>,
    /// Whether the last spoke shares a face with the first.
    pub closed: bool,
}

impl Ring {
    /// Makes this the ring of `vertex`; its memory is used again.
    pub fn walk(&mut self, surface: &Surface, vertex: u32) {
        self.spokes.clear();
        self.around.clear();
        let start = surface.out[vertex as usize];
        let mut half = start;
        loop {
            self.spokes.push(surface.edge[half as usize]);
            self.around.push(surface.from(next(half)));
            let back = previous(half);
            let across = surface.mate[back as usize];
            if across == NONE {
                self.spokes.push(surface.edge[back as usize]);
                self.around.push(surface.from(back));
                self.closed = false;
                return;
            }
            if across == start {
                self.closed = true;
                return;
            }
            half = across;
        }
    }
}
