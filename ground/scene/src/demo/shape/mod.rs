//! The building blocks of procedural scenes: what makes [`Form`]s, and what spreads them.

mod ball;
mod block;
mod bundle;
pub(crate) mod field;
mod form;
mod isosurface;
mod lathe;
mod loft;
mod neighbours;
mod noise;
mod profile;
mod refine;
mod scatter;
mod sweep;
mod tube;

pub(crate) use ball::ball;
pub(crate) use block::{block, prism, superellipsoid};
pub(crate) use bundle::{Bundle, strand};
pub(crate) use form::Form;
pub(crate) use isosurface::{isosurface, polished};
pub(crate) use lathe::lathe;
pub(crate) use loft::{Join, loft, pointed, sheet, wrapped};
pub(crate) use noise::{cells, layers, noise, ridges};
pub(crate) use profile::Profile;
pub(crate) use scatter::{between, rotation, spiral};
pub(crate) use sweep::{Placed, ribbon, slab, swept};
pub(crate) use tube::{Station, curve, hoop, stations, tube};
