//! Procedural scenes, built in code.
