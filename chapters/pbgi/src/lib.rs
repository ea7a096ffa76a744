//! Point-based global illumination (thesis, chapter 6): indirect light without noise.
//!
//! ```text
//! Frame --sites--> where surfels lie, the same in every frame of a shot
//!   --Surfels--> position, normal, the area of each living side, radiance by direct light
//!   --bounce--> radiance by light that was reflected before
//!   --Tree--> a node for every group: how much it covers and sends, direction by direction
//! GBuffer + Tree --tile (shared) | pixel (each by itself)--> irradiance of every pixel
//! ```
//!
//! 1. [`sites`] spreads surfels evenly over all triangles ([`site`]), or [`poisson_sites`] at a least distance.
//! 2. [`Surfels::light`] lights both sides of each and finds the dead ones: backs of walls, insides
//!    of closed bodies ([`surfel`], [`side`]). What the sky gives is smoothed ([`estimate`]); sides in
//!    narrow gaps show what covers them (`cover`).
//! 3. [`bounce`](bounce::bounce) lets surfels light each other, any number of times.
//! 4. [`Tree::build`] sums area and radiance lobes bottom-up as spherical harmonics ([`harmonic`],
//!    [`tree`]), surfaces that face different ways apart (`facing`); what a node stores is a type parameter ([`payload`]).
//! 5. [`cut`] chooses nodes by solid angle; they are splatted, nearest first, into a cube buffer
//!    ([`cube`]). The near field is rays on the triangles, not discs ([`near`]).
//! 6. [`indirect`] shares one buffer among the pixels of a tile ([`tile`]) and short rays among those
//!    of small blocks; with an error bound of 0 every pixel gathers by itself ([`pixel`]); or a few
//!    pixels look by rays and those between follow their gradients (`records`). The same
//!    sums tell how open the hemisphere is, in which direction, and how much of a sky comes in (`opening`).
//! 7. What is seen may be glossy: rays by its lobe see surfels, or the triangles in mirrors (`glossy`).
//!
//! Units: radiance is linear RGB in the units of the scene's lights (candela per square metre where
//! those are glTF's), irradiance is radiance times steradians, lengths are scene units.
//!
//! Guaranteed: the same bits for any number of threads; nothing depends on frames made before.
//! Not guaranteed: reflections of reflections (what lights others is Lambertian), and light through openings
//! smaller than the spacing of surfels beyond the near field.

mod band;
mod bitrows;
mod bits;
mod block;
pub mod bounce;
mod bright;
mod bunch;
pub mod chosen;
pub mod classic;
mod cluster;
pub mod code;
pub mod compact;
mod cover;
mod coverage;
mod crevice;
pub mod cube;
pub mod curve;
pub mod cut;
mod decode;
mod dimmed;
pub mod estimate;
mod facing;
mod field;
pub mod file;
mod focus;
mod glossy;
mod gradient;
pub mod grid;
pub mod harmonic;
pub mod hierarchy;
mod indirect;
mod knob;
mod leaf;
mod links;
pub mod near;
mod opening;
mod pack;
pub mod packed;
pub mod payload;
pub mod pixel;
mod poisson;
mod pool;
mod receiver;
mod recipe;
mod records;
pub mod resolve;
mod rival;
pub mod side;
mod sight;
pub mod site;
pub mod spread;
pub mod stream;
pub mod surfel;
pub mod tile;
pub mod tree;
mod veil;
pub mod wide;

pub use coverage::coverage;
pub use focus::Focus;
pub use hierarchy::Hierarchy;
pub use indirect::{Indirect, Points, Prepared, Wanted, indirect, indirect_of, prepare};
pub use knob::{Division, LightKnobs, OwnSky, Sampling, Sharing, Storage, Teaching};
pub use opening::Openings;
pub use payload::{Exact, Payload};
pub use poisson::poisson_sites;
pub use rival::pooled_paths;
pub use site::{Site, sites, sites_by};
pub use spread::Spread;
pub use surfel::{Lit, Surfel, Surfels};
pub use tree::{Node, Tree};
