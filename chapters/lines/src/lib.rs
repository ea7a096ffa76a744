//! Animated lines (thesis, chapter 4): every silhouette, crease and border of a film, with identity.

pub mod contour;
mod curvature;
mod extract;
mod feature;
mod film;
mod knob;
mod measure;
mod path;
mod posed;
mod sight;
mod slice;
mod stroke;
pub mod surface;
pub mod track;
mod view;
mod visibility;
mod vote;
mod zeroset;

pub use extract::{Lines, Moment, Stage};
pub use feature::{FeatureChain, Features};
pub use film::{Film, FilmEvent, FilmFrame, Ground, Reel};
pub use knob::{Hidden, LinesKnobs};
pub use measure::{Measures, distance, measure};
pub use path::{Kind, Path, Place, Point, Segment};
pub use posed::{Posed, positions};
pub use sight::Sight;
pub use slice::{Chain, Crossing, Slice};
pub use stroke::{Sample, Stroke};
pub use surface::{CreaseRule, Surface};
pub use view::{Seen, View};
pub use visibility::{Limits, Run as VisibleRun, Visible, visible};
