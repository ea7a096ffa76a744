//! What the search asks of a residual graph.
//!
//! The search is written once. A network answers for its nodes: where they lie, what their arcs
//! still carry, and which of a node's neighbours come next in a tree. A network of fixed shape
//! answers from vector registers, one of any shape from lists.
//!
//! Every node has an *excess*: what the white terminal can still send into it (positive) or the
//! black one still take from it (negative). Arcs come in pairs, there and back; the capacity that
//! is left on an arc is its *residual*.

use crate::capacity::Capacity;

/// One of the two trees. The white one follows arcs forwards, away from its terminal; the black one
/// follows them backwards. Labels are distances, positive in the white tree, negative in the black
/// one, zero for a free node.
pub(crate) trait Side {
    const WHITE: bool;
    const INDEX: usize;
    type Other: Side;

    /// The distance in this tree that a label states, zero or less if the node is not in it.
    #[inline(always)]
    fn distance(label: i32) -> i32 {
        if Self::WHITE { label } else { -label }
    }
}

/// The tree of the white terminal.
pub(crate) struct White;
/// The tree of the black terminal.
pub(crate) struct Black;

impl Side for White {
    const WHITE: bool = true;
    const INDEX: usize = 0;
    type Other = Black;
}

impl Side for Black {
    const WHITE: bool = false;
    const INDEX: usize = 1;
    type Other = White;
}

/// A residual graph.
pub(crate) trait Network: Send {
    /// How a node names an arc to a neighbour, and so how a tree keeps a node's parent.
    type Arc: Copy + PartialEq + Send;
    /// The integer of the labels; distances beyond it end the search.
    type Label: Capacity;

    /// The parent of a node that hangs from its terminal.
    const ROOT: Self::Arc;
    /// The parent of a free node or an orphan.
    const NONE: Self::Arc;

    /// The parent of a node that lost its tree for a while.
    const LOST: Self::Arc;

    /// The number of nodes, those of a frame included.
    fn len(&self) -> usize;

    /// The excess of `v`.
    fn excess(&self, v: usize) -> i64;

    /// Takes `amount` of the excess of `v` towards zero; whether nothing is left.
    fn drain(&mut self, v: usize, amount: i64) -> bool;

    /// The node to which the arc `a` of `v` leads.
    fn head(&self, v: usize, a: Self::Arc) -> usize;

    /// The arc that leads back from the head of the arc `a` of `v`.
    fn back(&self, v: usize, a: Self::Arc) -> Self::Arc;

    /// What the arc `a` of `v` still carries.
    fn residual(&self, v: usize, a: Self::Arc) -> i64;

    /// Moves `amount` from `v` over its arc `a`; whether that closes the arc.
    fn push(&mut self, v: usize, a: Self::Arc, amount: i64) -> bool;

    /// Starts to fetch what a step at `v` will read.
    #[inline(always)]
    fn prefetch(&self, _label: &[Self::Label], _v: usize) {}

    /// The lowest distance among the nodes of the tree that could be the parent of `v`, and the arc
    /// of `v` to that node.
    fn lowest<T: Side>(&self, label: &[Self::Label], v: usize) -> Option<(i32, Self::Arc)>;

    /// The arc of `v` to the lowest node of the other tree to which the tree can grow from `v`.
    fn contact<T: Side>(&self, label: &[Self::Label], v: usize) -> Option<Self::Arc>;

    /// Calls `take` with every free node to which the tree can grow from `v` and the arc back from
    /// it to `v`; `take` gives it a label.
    fn each_free<T: Side>(
        &self,
        label: &mut [Self::Label],
        v: usize,
        take: impl FnMut(&mut [Self::Label], usize, Self::Arc),
    );

    /// Calls `visit` with every lost node to which the tree can grow from `v`.
    fn each_lost<T: Side>(&self, parent: &[Self::Arc], v: usize, visit: impl FnMut(usize));

    /// Calls `visit` with every node that has `v` as its parent.
    fn each_child(
        &self,
        parent: &mut [Self::Arc],
        v: usize,
        visit: impl FnMut(&mut [Self::Arc], usize),
    );
}
