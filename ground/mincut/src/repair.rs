//! Re-solving: mends the trees of a solved problem after its capacities changed.
//!
//! After Kohli and Torr, "Dynamic graph cuts for efficient inference in Markov random fields"
//! (PAMI 2007), on the trees of [`crate::search`].
//!
//! A change is first made in the residual graph alone, in numbers:
//!
//! * A terminal: the excess of the node moves by the difference.
//! * A link: its flow stays if the new capacity still carries it. Else the flow is cut down, and
//!   what the tail now sends in vain becomes its excess, what the head lacks its deficit. This is
//!   the same flow in a graph whose every cut costs the same, less a constant.
//!
//! Then every node that a change touched is mended, once:
//!
//! * Whoever has excess of the tree's sign is a root and keeps its label, for a label need only be
//!   lower than those of the children.
//! * Whoever has excess of the other sign leaves its tree, orphans its children, and is a root of
//!   the other tree, above all grown levels.
//! * A root without excess, or a node whose arc from its parent closed, is an orphan.
//!
//! The search's invariant (no open arc from a grown white node out of the white tree) can fail only
//! at the touched nodes, where arcs opened, and at the neighbours of those that changed sides. All
//! of these grow again before the next level does. The rest is the search as always: its cost
//! follows what the change sets moving.

use crate::network::{Black, Network, Side, White};
use crate::search::Search;

/// A network whose capacities can be changed.
pub(crate) trait Mutable: Network {
    /// An excess that no flow uses up.
    const BOUND: i64;

    /// The node of a pixel.
    fn node(&self, pixel: usize) -> usize;

    /// The arc of the node `v` that is link `link`, the one after the last neighbour's being that
    /// in time; `None` if there is no such link.
    fn arc(&self, v: usize, link: usize) -> Option<Self::Arc>;

    /// Adds to the excess of `v`.
    fn add_excess(&mut self, v: usize, amount: i64);

    /// Sets what is left on the arc `a` of `v` and on the one back.
    fn set_residuals(&mut self, v: usize, a: Self::Arc, residuals: [i64; 2]);

    /// Calls `visit` with every neighbour of `v`.
    fn each_neighbour(&self, v: usize, visit: impl FnMut(usize));
}

impl<N: Mutable> Search<N> {
    /// Adds to the excess of `v`, which has to be mended.
    pub(crate) fn change_excess(&mut self, v: usize, amount: i64) {
        self.left -= self.network.excess(v).max(0);
        self.network.add_excess(v, amount);
        self.left += self.network.excess(v).max(0);
    }

    /// Moves the arc `a` of `v` and the one back from the capacities `old` to `new`; both ends have
    /// to be mended.
    pub(crate) fn change_capacities(&mut self, v: usize, a: N::Arc, old: [i64; 2], new: [i64; 2]) {
        let flow = old[0] - self.network.residual(v, a);
        let kept = flow.clamp(-new[1], new[0]);
        self.network.set_residuals(v, a, [new[0] - kept, new[1] + kept]);
        if kept != flow {
            self.change_excess(v, flow - kept);
            self.change_excess(self.network.head(v, a), kept - flow);
        }
    }

    /// Mends the trees around the `touched` nodes; none may appear before its change is made.
    pub(crate) fn mend(&mut self, touched: &[u32]) {
        for &v in touched {
            let v = v as usize;
            match self.network.excess(v) {
                1.. => self.mend_root::<White>(v),
                ..0 => self.mend_root::<Black>(v),
                0 if self.distance::<White>(v) > 0 => self.mend_child::<White>(v),
                0 if self.distance::<Black>(v) > 0 => self.mend_child::<Black>(v),
                0 => {}
            }
        }
        self.adopt::<White>();
        self.adopt::<Black>();
    }

    /// Makes a node with excess a root of its tree.
    fn mend_root<T: Side>(&mut self, v: usize) {
        let distance = self.distance::<T>(v);
        if distance <= 0 {
            if distance < 0 {
                self.desert::<T::Other>(v);
            }
            let first = self.trees[T::INDEX].grown + 1;
            self.set_distance::<T>(v, first);
            self.trees[T::INDEX].activate(v, first);
        } else {
            self.trees[T::INDEX].again.push(v as u32);
        }
        self.parent[v] = N::ROOT;
    }

    /// Takes `v` out of the tree: its children are orphans, and what grew around it grows again.
    fn desert<T: Side>(&mut self, v: usize) {
        self.release::<T>(v, i32::MAX);
        let again = &mut self.trees[T::INDEX].again;
        self.network.each_neighbour(v, |w| again.push(w as u32));
    }

    /// Makes an orphan of a node without excess whose parent sends it nothing.
    fn mend_child<T: Side>(&mut self, v: usize) {
        self.trees[T::INDEX].again.push(v as u32);
        let a = self.parent[v];
        if a == N::NONE {
            return;
        }
        if a == N::ROOT || self.is_cut_off::<T>(v, a) {
            self.orphan::<T>(v);
        }
    }

    fn is_cut_off<T: Side>(&self, v: usize, a: N::Arc) -> bool {
        let (u, back) = (self.network.head(v, a), self.network.back(v, a));
        let (tail, arc) = if T::WHITE { (u, back) } else { (v, a) };
        self.network.residual(tail, arc) == 0
    }
}
