//! [`Playback`]: which clips play together.

use crate::Scene;

/// What the user asked for.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub enum Choice {
    /// Clips that touch disjoint properties play together; of clips that fight over a property the
    /// first plays.
    #[default]
    Auto,
    /// Every clip; where they fight, later ones win.
    All,
    /// One clip, by name or by index.
    One(String),
}

/// Which clips of a scene play, later ones winning.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Playback {
    /// Indices into [`Scene::clips`].
    pub clips: Vec<usize>,
}

impl Playback {
    /// The rest pose.
    pub fn still() -> Self {
        Self::default()
    }

    /// Seconds from time 0 to the last key of the clips that play; 0 when nothing moves.
    pub fn seconds(&self, scene: &Scene) -> f64 {
        let clips = self.clips.iter().map(|&c| &scene.clips[c]);
        let ends = clips.flat_map(|c| &c.channels).filter_map(|c| c.track.times.last());
        ends.fold(0.0, |a, &t| a.max(f64::from(t)))
    }
}
