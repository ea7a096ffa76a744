//! Adjacency of a mesh welded over its whole animation.
