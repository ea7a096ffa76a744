//! Families of chains: those along which one stroke runs in some frame.
//!
//! Where an outline passes from loop to loop in one frame and is parted there in the next, its pieces are still one
//! line, and may share an id.

use crate::film::{Film, FilmFrame};
use crate::path::Kind;
use crate::stroke::Stroke;

impl Film {
    /// A number that the strokes of a frame share if they may have one id: parts of one line, or of
    /// lines that run on into each other in some frame.
    pub(crate) fn line_of(&self, frame: &FilmFrame, stroke: &Stroke) -> u32 {
        let line = match stroke.kind {
            Kind::Silhouette => self.families[frame.labels[stroke.chain as usize] as usize],
            _ => stroke.chain,
        };
        line * Kind::ALL.len() as u32 + stroke.kind as u32
    }
}

/// One more than the greatest label.
fn last_label(frames: &[FilmFrame]) -> u32 {
    frames.iter().flat_map(|f| &f.labels).max().map_or(0, |l| l + 1)
}

/// For each label the least one of those whose chains run on into each other; `count`: how many labels
/// there are at least.
pub(crate) fn families(frames: &[FilmFrame], count: u32) -> Vec<u32> {
    let count = count.max(last_label(frames));
    let mut least: Vec<u32> = (0..count).collect();
    let root = |least: &[u32], mut label: u32| {
        while least[label as usize] != label {
            label = least[label as usize];
        }
        label
    };
    for frame in frames {
        for stroke in frame.strokes.iter().filter(|s| s.kind == Kind::Silhouette) {
            let labels = stroke.samples.iter().map(|s| frame.labels[s.chain as usize]);
            let own = frame.labels[stroke.chain as usize];
            for label in labels.filter(|l| *l != own) {
                let [a, b] = [own, label].map(|l| root(&least, l));
                least[a.max(b) as usize] = a.min(b);
            }
        }
    }
    (0..count).map(|l| root(&least, l)).collect()
}
