//! Scenes and knobs to jobs and files: the facade of chiaro.
//!
//! A job takes a [`Project`] (a scene on disk or a procedural one, with the view, the time and the
//! film) and writes files whole. Everything a surface offers (command line, desktop, bindings) goes
//! through here.

pub mod binary;
pub mod camera;
pub mod colours;
pub mod compare;
pub mod compare_films;
pub mod demo;
mod disk;
pub mod figures;
pub mod film;
mod frames;
pub mod gbuffer;
pub mod given;
mod growing;
pub mod info;
pub mod light;
mod lighting;
pub mod lines;
pub mod mincut;
mod movie;
pub mod number;
pub mod page;
pub mod painting;
mod pattern;
pub mod project;
pub mod record;
mod sequence;
pub mod style;
pub mod vector;
pub mod write;

pub use project::{Options, Project};
pub use record::{Record, Stopwatch};
