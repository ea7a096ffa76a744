//! Cuts through a packed tree.

use super::{BLOCK, FAN, Means, Packed, Places, Siblings, Stored};
use crate::bunch::Bunch;
use crate::cut::{Chooser, Span, Splat, Verdict, face};
use crate::hierarchy::Hierarchy;
use crate::surfel::Surfel;

/// How much larger than in a binary tree a node that is not opened may look: of eight children most
/// look far smaller than their parent, so that a cut at the same bound would be finer and slower
/// than asked for. At this factor pictures are as near to those of the finest cuts.
const WIDER: f32 = 1.5;

impl<S: Stored> Hierarchy for Packed<S> {
    fn cut(&self, chooser: &Chooser, splats: &mut Vec<Splat>) -> u64 {
        // What is summed looks no larger than what a binary tree would splat.
        let most = chooser.threshold;
        let chooser = &Chooser { threshold: WIDER * chooser.threshold, ..*chooser };
        let counts = self.store.counts();
        let Some(top) = counts.len().checked_sub(1) else { return 0 };
        let mut visited = 0;
        let mut bunch = Bunch::new(chooser, most);
        // Siblings to visit, the next ones last.
        let mut open = Vec::with_capacity(64);
        open.push((top, 0..1));
        while let Some((level, nodes)) = open.pop() {
            visited += nodes.len() as u64;
            let siblings = self.store.siblings(level, nodes.clone());
            let spheres = siblings.spheres();
            let verdicts = chooser.verdicts(&spheres.centre, &spheres.radius);
            let splatted = verdicts[..nodes.len()].contains(&Verdict::Splat);
            let means = if splatted { siblings.means(&spheres) } else { Means::default() };
            let sights = splatted.then(|| chooser.sights(&means));
            for (k, (index, verdict)) in nodes.zip(verdicts).enumerate() {
                match verdict {
                    Verdict::Leave => {}
                    Verdict::Splat => {
                        let Some(sights) = sights.as_ref().filter(|s| s.above >> k & 1 == 1) else {
                            continue;
                        };
                        if sights.behind >> k & 1 == 1 && siblings.is_one_sided(k) {
                            continue;
                        }
                        let area = means.area[k];
                        let sent = |d| siblings.lobes(k, &means).sent(d);
                        let face = |side| face(area, &siblings.along_axis(k, &means), side);
                        let sight = sights.one(k, means.axis(k));
                        if let Some(splat) = sight.splat(area, sent, face) {
                            let count = BLOCK * FAN.pow(level as u32);
                            let span = Span { first: (index * count) as u32, count: count as u32 };
                            bunch.add_node(&Splat { span, ..splat }, spheres.one(k), splats);
                        }
                    }
                    Verdict::Open if level == 0 => {
                        let seen = |places: &Places| chooser.seen_of(places);
                        let span = Span { first: (index * BLOCK) as u32, count: BLOCK as u32 };
                        self.store.records(index, seen, |r| bunch.add(r, span, splats));
                    }
                    Verdict::Open => {
                        let end = (FAN * index + FAN).min(counts[level - 1]);
                        open.push((level - 1, FAN * index..end));
                    }
                }
            }
        }
        bunch.splat(splats);
        visited
    }

    fn some(&self, span: Span, most: usize, surfels: &mut Vec<Surfel>) {
        let Some(blocks) = self.store.counts().first() else { return };
        let first = span.first as usize / BLOCK;
        let end = (first + (span.count as usize).div_ceil(BLOCK)).min(*blocks);
        let count = end.saturating_sub(first).min(most.div_ceil(BLOCK));
        for k in 0..count {
            let block = first + (2 * k + 1) * (end - first) / (2 * count);
            self.store.records(block, |_| u32::MAX, |r| surfels.push(*r));
        }
    }

    fn leaf_radius(&self) -> f32 {
        self.leaf_radius
    }

    fn is_empty(&self) -> bool {
        self.store.counts().is_empty()
    }
}
