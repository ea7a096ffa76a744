//! Solvers that know nothing of pictures, lines or light.
//!
//! - [`k_means`]: few centres that stand for many points.
//! - [`Nearest`]: the nearest of many centres, exactly.
//!
//! ```
//! use chiaro_basis::Run;
//! use chiaro_solve::{KMeans, Nearest, Scratch, k_means};
//!
//! let points = [0.0, 0.1, 0.2, 9.0, 9.1, 9.2];
//! let how = KMeans { count: 2, rounds: 10, seed: 1 };
//! let found = k_means(&points, 1, how, &Run::default())?;
//! let index = Nearest::new(&found.centres, 1);
//! let near = index.find(&[8.0], None, &mut Scratch::default()).map(|f| f.index);
//! assert!((found.centres[near.unwrap_or(0) as usize] - 9.1).abs() < 1e-6);
//! # Ok::<(), chiaro_basis::Error>(())
//! ```
//!
//! Guaranteed: the same bits for any number of threads.

mod kmeans;
mod nearest;

pub use kmeans::{Clusters, KMeans, k_means};
pub use nearest::{Found, Nearest, Scratch};
