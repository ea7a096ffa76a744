//! [`Playback`]: which clips play together.

use crate::{NodeId, Property, Scene};
use chiaro_basis::{Error, Result, nearest};
use std::collections::BTreeMap;

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

    /// Seconds of frame `frame` (from 1) at `fps` frames a second. With `looped`, time starts again
    /// after the last key.
    pub fn time(&self, scene: &Scene, frame: u32, fps: f64, looped: bool) -> f64 {
        let time = f64::from(frame.saturating_sub(1)) / fps;
        let period = self.seconds(scene);
        if looped && period > 0.0 { time % period } else { time }
    }
}

impl Scene {
    /// The clips that play by a choice, with notes for the user. [`Error::Setting`] when no clip has
    /// that name or index.
    pub fn playback(&self, choice: &Choice) -> Result<(Playback, Vec<String>)> {
        match choice {
            Choice::All => Ok((Playback { clips: (0..self.clips.len()).collect() }, Vec::new())),
            Choice::One(name) => Ok((Playback { clips: vec![self.clip(name)?] }, Vec::new())),
            Choice::Auto => {
                let groups = self.fighting_clips();
                let mut clips: Vec<usize> = groups.iter().map(|g| g[0]).collect();
                clips.sort_unstable();
                let notes = groups.iter().filter(|g| g.len() > 1).map(|g| self.note(g)).collect();
                Ok((Playback { clips }, notes))
            }
        }
    }

    fn clip(&self, name: &str) -> Result<usize> {
        let named = self.clips.iter().position(|c| c.name == name);
        let index = || name.parse::<usize>().ok().filter(|i| *i < self.clips.len());
        named.or_else(index).ok_or_else(|| {
            if self.clips.is_empty() {
                return Error::setting("--animation", name, "a scene with animations");
            }
            let names: Vec<&str> = self.clips.iter().map(|c| c.name.as_str()).collect();
            let hint = nearest(name, names.iter().copied().filter(|n| !n.is_empty()));
            let hint = hint.map(|n| format!("; did you mean {n}?")).unwrap_or_default();
            let count = names.len();
            Error::setting(
                "--animation",
                name,
                format!("all, an index below {count}, or one of {}{hint}", names.join(", ")),
            )
        })
    }

    /// Groups of clips that are tied by animating the same property of the same node, directly or
    /// through others; each sorted, in the order of their first clips.
    fn fighting_clips(&self) -> Vec<Vec<usize>> {
        let mut tied: Vec<usize> = (0..self.clips.len()).collect();
        let mut owner: BTreeMap<(NodeId, Property), usize> = BTreeMap::new();
        for (i, clip) in self.clips.iter().enumerate() {
            for channel in &clip.channels {
                let first = *owner.entry((channel.node, channel.property)).or_insert(i);
                let (a, b) = (leader(&mut tied, first), leader(&mut tied, i));
                tied[a.max(b)] = a.min(b);
            }
        }
        let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for i in 0..tied.len() {
            groups.entry(leader(&mut tied, i)).or_default().push(i);
        }
        groups.into_values().collect()
    }

    fn note(&self, group: &[usize]) -> String {
        let name = |i: &usize| match self.clips[*i].name.as_str() {
            "" => format!("clip {i}"),
            name => name.to_owned(),
        };
        let others: Vec<String> = group[1..].iter().map(name).collect();
        format!(
            "{} plays; {} would move the same parts (choose with --animation)",
            name(&group[0]),
            others.join(", ")
        )
    }
}

/// The first clip that `i` is tied to; shortens the way there.
fn leader(tied: &mut [usize], mut i: usize) -> usize {
    while tied[i] != i {
        tied[i] = tied[tied[i]];
        i = tied[i];
    }
    i
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Channel, Clip, Interpolation, Track};

    fn scene(clips: &[(&str, usize, Property)]) -> Scene {
        let track = Track {
            times: vec![0.0, 2.0],
            values: vec![0.0; 8],
            width: 4,
            interpolation: Interpolation::Step,
        };
        let clip = |&(name, node, property): &(&str, usize, Property)| Clip {
            name: name.into(),
            channels: vec![Channel { node: NodeId::new(node), property, track: track.clone() }],
        };
        Scene { clips: clips.iter().map(clip).collect(), ..Scene::default() }
    }

    #[test]
    fn disjoint_clips_play_together_and_of_rivals_the_first() {
        use Property::{Rotation, Scale};
        let scene = scene(&[
            ("walk", 0, Rotation),
            ("door", 1, Rotation),
            ("run", 0, Rotation),
            ("grow", 0, Scale),
        ]);
        let (playback, notes) = scene.playback(&Choice::Auto).unwrap();
        assert_eq!(playback.clips, [0, 1, 3]);
        assert_eq!(notes.len(), 1);
        assert!(notes[0].contains("walk plays; run"), "{}", notes[0]);
    }

    #[test]
    fn clips_that_fight_through_others_are_one_group() {
        use Property::{Rotation, Scale, Translation};
        let mut scene = scene(&[
            ("stand", 7, Scale),
            ("low", 0, Rotation),
            ("high", 1, Translation),
            ("both", 0, Rotation),
        ]);
        let high = scene.clips[2].channels[0].clone();
        scene.clips[3].channels.push(high);
        let (playback, notes) = scene.playback(&Choice::Auto).unwrap();
        assert_eq!(playback.clips, [0, 1]);
        assert_eq!(notes.len(), 1);
        assert!(notes[0].contains("low plays; high, both"), "{}", notes[0]);
        let (playback, notes) = scene.playback(&Choice::All).unwrap();
        assert_eq!((playback.clips, notes), (vec![0, 1, 2, 3], Vec::new()));
    }

    #[test]
    fn an_unknown_clip_is_answered_with_the_nearest() {
        let scene = scene(&[("walk", 0, Property::Scale)]);
        let error = scene.playback(&Choice::One("wolk".into())).unwrap_err().to_string();
        assert!(error.contains("did you mean walk?"), "{error}");
        assert_eq!(scene.playback(&Choice::One("0".into())).unwrap().0.clips, [0]);
    }

    #[test]
    fn time_wraps_where_asked() {
        let scene = scene(&[("walk", 0, Property::Scale)]);
        let (playback, _) = scene.playback(&Choice::Auto).unwrap();
        assert_eq!(playback.time(&scene, 49, 24.0, false), 2.0);
        assert_eq!(playback.time(&scene, 61, 24.0, true), 0.5);
    }
}
