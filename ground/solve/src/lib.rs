//! Solvers that know nothing of pictures, lines or light.
//!
//! - [`Normal`]: sparse least squares whose pattern stays and whose weights change.
//! - [`k_means`]: few centres that stand for many points.
//! - [`Nearest`]: the nearest of many centres, exactly.
//!
//! [`Rows`] are linear equations in a few unknowns each. [`Normal`] finds which unknowns hang
//! together, and factors the pattern of the normal equations of each part once; every
//! [`Normal::solve`] after that costs the numbers alone. So a weight behind a slider, or one that a
//! robust fit changes from round to round, is cheap to move.
//!
//! ```
//! use chiaro_solve::{Normal, Rows};
//!
//! // x = 1, y - x = 2, y = 4, the last trusted as much as the other two together.
//! let mut rows = Rows::new(2);
//! rows.push(&[(0, 1.0)]);
//! rows.push(&[(0, -1.0), (1, 1.0)]);
//! rows.push(&[(1, 1.0)]);
//! let normal = Normal::new(&rows);
//! let x = normal.solve(&[1.0, 1.0, 2.0], &[1.0, 2.0, 4.0])?;
//! assert!((x[0] - 1.4).abs() < 1e-12 && (x[1] - 3.8).abs() < 1e-12);
//! # Ok::<(), chiaro_solve::Singular>(())
//! ```
//!
//! ```
//! use chiaro_basis::Run;
//! use chiaro_solve::{KMeans, Nearest, Scratch, Start, k_means};
//!
//! let points = [0.0, 0.1, 0.2, 9.0, 9.1, 9.2];
//! let how = KMeans { count: 2, rounds: 10, seed: 1, start: Start::Spread };
//! let found = k_means(&points, 1, how, &Run::default())?;
//! let index = Nearest::new(&found.centres, 1);
//! let near = index.find(&[8.0], None, &mut Scratch::default()).map(|f| f.index);
//! assert!((found.centres[near.unwrap_or(0) as usize] - 9.1).abs() < 1e-6);
//! # Ok::<(), chiaro_basis::Error>(())
//! ```
//!
//! Guaranteed: the same bits for any number of threads. Not guaranteed: anything where rows leave an
//! unknown free; that is an error that names it.

mod kmeans;
mod nearest;
mod normal;
mod rows;

pub use kmeans::{Clusters, KMeans, Start, k_means};
pub use nearest::{Found, Nearest, Scratch};
pub use normal::{Normal, Singular};
pub use rows::Rows;
