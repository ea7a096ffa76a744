//! The chiaro command line.
fn main() {}
