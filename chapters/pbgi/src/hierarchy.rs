//! [`Hierarchy`]: what a gather needs to know of a tree, however it is stored.

use crate::cut::{Chooser, Span, Splat};
use crate::payload::Payload;
use crate::surfel::Surfel;
use crate::tree::Tree;

/// A tree over surfels from which a receiver's cut can be taken.
pub trait Hierarchy: Sync {
    /// Adds the splats of the cut, in the order of the tree; the number of nodes visited.
    fn cut(&self, chooser: &Chooser, splats: &mut Vec<Splat>) -> u64;

    /// Adds some of the surfels of a splat, about `most`.
    fn some(&self, span: Span, most: usize, surfels: &mut Vec<Surfel>);

    /// The radius of a disc of a surfel's mean area.
    fn leaf_radius(&self) -> f32;

    /// Whether there is no surfel.
    fn is_empty(&self) -> bool;
}

impl Hierarchy for Box<dyn Hierarchy> {
    fn cut(&self, chooser: &Chooser, splats: &mut Vec<Splat>) -> u64 {
        (**self).cut(chooser, splats)
    }

    fn some(&self, span: Span, most: usize, surfels: &mut Vec<Surfel>) {
        (**self).some(span, most, surfels);
    }

    fn leaf_radius(&self) -> f32 {
        (**self).leaf_radius()
    }

    fn is_empty(&self) -> bool {
        (**self).is_empty()
    }
}

impl<P: Payload> Hierarchy for Tree<P> {
    fn cut(&self, chooser: &Chooser, splats: &mut Vec<Splat>) -> u64 {
        chooser.cut(self, splats)
    }

    fn some(&self, span: Span, most: usize, surfels: &mut Vec<Surfel>) {
        let (first, all) = (span.first as usize, span.count as usize);
        let count = all.min(most);
        surfels.extend((0..count).map(|k| self.surfels[first + (2 * k + 1) * all / (2 * count)]));
    }

    fn leaf_radius(&self) -> f32 {
        self.leaf_radius
    }

    fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }
}
