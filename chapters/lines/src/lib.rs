//! Animated lines (thesis, chapter 4): every silhouette, crease and border of a film, found on one
//! surface for all frames, with identity through time.
//!
//! ```text
//!  per frame, in parallel   Frame ─Posed→ g at the vertices ─Slice→ chains ─Path, Visible→ Strokes
//!  once over the film       g, Slices ─Kinetic→ S: flips, events, correspondence ─Identity→ ids
//!  per frame                Strokes + ids
//! ```
//!
//! 1. [`Surface`]: everything drawn as one oriented manifold whose ids never change; a crease is a
//!    strip of no width, so that silhouettes pass along sharp edges and stay closed.
//! 2. [`Slice`]: the zero set of n . V as chains; [`Features`]: lines that are edges of the mesh;
//!    suggestive contours, ridges, valleys, apparent ridges and terminators are further zero sets.
//! 3. [`visible`]: stretches between cusps and crossings vote on what hides them ([`Sight`]).
//! 4. [`Stroke`]: visible runs, joined where one goes on with the next ([`Line`]), as samples, each with its material point one frame later.
//! 5. [`track::Kinetic`]: the space-time surface S as the history of its vertices' flips; births,
//!    deaths, saddles; where each crossing is one frame later.
//! 6. [`track::Identity`]: one id a line, whatever passes in front of it.
//! 7. [`Film`] runs all of it; [`measure`] says what came out.
//!
//! ```
//! use chiaro_basis::Run;
//! use chiaro_lines::{Film, LinesKnobs, Reel, View};
//! use chiaro_scene::{Choice, Pose, Poser, Projection, demo};
//!
//! let scene = demo::scene("peanut")?;
//! let (playback, _) = scene.playback(&Choice::Auto)?;
//! let poser = Poser::new(&scene);
//! let eye = chiaro_basis::math::vec3(0.0, 2.0, 6.0);
//! let zero = chiaro_basis::math::Vec3::ZERO;
//! let up = chiaro_basis::math::Vec3::Y;
//! let pose = Pose::look_at(eye, zero, up, Projection::Perspective { fov_y: 0.6 });
//! let at = |i: usize| (poser.frame(i as f64 / 24.0, &playback), View::new(pose, (320, 240)));
//! let reel = Reel { scene: &scene, count: 2, at: &at };
//! let film = Film::of(&reel, &LinesKnobs::default(), &Run::default())?;
//! assert!(film.frames[0].slice.chains.iter().all(|c| c.closed));
//! assert_eq!(film.frames[0].strokes[0].id, film.frames[1].strokes[0].id);
//! # chiaro_basis::Result::Ok(())
//! ```
//!
//! Not guaranteed: contacts one or two triangles wide may be shown or hidden wrongly; a surface of more
//! than 100 000 faces shows no line where a piece of it passes through itself.

mod beside;
mod bit;
pub mod check;
pub mod contour;
mod cover;
mod crossing;
mod curvature;
mod depth;
mod extract;
mod family;
mod feature;
mod film;
mod fringe;
mod further;
mod gap;
mod intersect;
mod join;
mod knob;
mod mask;
mod measure;
mod overlap;
pub mod parameter;
mod partner;
mod path;
mod posed;
mod preview;
mod quality;
mod refine;
mod sight;
mod slice;
mod solid;
mod strands;
mod stroke;
pub mod surface;
pub mod track;
mod view;
mod visibility;
mod vote;
mod whole;
mod zeroset;

pub use extract::{Lines, Moment, Stage};
pub use feature::{FeatureChain, Features};
pub use film::{Film, FilmEvent, FilmFrame, Ground, Reel};
pub use fringe::{Fringe, Spot};
pub use further::Further;
pub use gap::Gap;
pub use join::Line;
pub use knob::{Cuts, Hidden, LinesKnobs, Links, Method, Texture};
pub use mask::Masks;
pub use measure::{Measures, distance, measure};
pub use overlap::overlap;
pub use partner::Partner;
pub use path::{Kind, Path, Place, Point, Segment};
pub use posed::{Posed, positions};
pub use quality::{Quality, quality};
pub use sight::Sight;
pub use slice::{Chain, Crossing, Slice};
pub use stroke::{Owner, Sample, Stroke};
pub use surface::{CreaseRule, Detail, Source, Surface};
pub use view::{Seen, View};
pub use visibility::{Limits, Run as VisibleRun, Visible, visible};
