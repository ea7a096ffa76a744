//! Large subtrees that lost their root: every node settles once.
//!
//! Settled one by one, the nodes of a cut-off subtree lean on each other: each moves above its
//! neighbours, which then move above it, again and again until the true distance is reached. After
//! the three passes of Goldberg, Hed, Kaplan, Kohli, Tarjan and Werneck, "Faster and more dynamic
//! maximum flow by incremental breadth-first search" (ESA 2015), the subtree is first taken out
//! whole:
//!
//! 1. Orphans, lowest first, adopt a parent of a lower label; who finds none is lost, and its
//!    children are orphans too.
//! 2. Every lost node looks for the lowest grown neighbour that is not lost.
//! 3. Lost nodes come back by distance, lowest first, and offer themselves to their lost neighbours:
//!    labels are then exact distances from what was left of the tree. Whom nobody reaches is free.
//!
//! A lost node keeps its label with the sign turned: no look for a parent finds it, and its label
//! can be kept from falling.

use crate::capacity::Capacity;
use crate::network::{Network, Side};
use crate::search::Search;

impl<N: Network> Search<N> {
    /// Finds orphan `v` a new parent below it, or gives it up for lost with all that hangs from it.
    pub(crate) fn lose<T: Side>(&mut self, v: usize) {
        let old = self.distance::<T>(v);
        if let Some((lowest, a)) = self.network.lowest::<T>(&self.label, v)
            && lowest < old
        {
            self.parent[v] = a;
            return;
        }
        self.set_distance::<T>(v, -old);
        self.parent[v] = N::LOST;
        self.trees[T::INDEX].lost.push(v as u32);
        self.release::<T>(v, i32::MAX);
    }

    /// Brings lost nodes back to the tree, and sets those free that it does not reach.
    pub(crate) fn recover<T: Side>(&mut self) {
        let lost = std::mem::take(&mut self.trees[T::INDEX].lost);
        for &v in &lost {
            if let Some((distance, _)) = self.return_of::<T>(v as usize) {
                self.trees[T::INDEX].orphans.push(v as usize, distance as usize);
            }
        }
        while let Some(v) = self.trees[T::INDEX].orphans.pop() {
            if self.parent[v] == N::LOST {
                self.bring_back::<T>(v);
            }
        }
        self.trees[T::INDEX].lost = self.set_free(lost);
    }

    /// The distance at which lost `v` can come back, and the arc to its parent.
    #[inline(always)]
    fn return_of<T: Side>(&self, v: usize) -> Option<(i32, N::Arc)> {
        let (lowest, a) = self.network.lowest::<T>(&self.label, v)?;
        let grown = self.trees[T::INDEX].grown;
        (lowest <= grown).then(|| ((lowest + 1).max(-self.distance::<T>(v)), a))
    }

    fn bring_back<T: Side>(&mut self, v: usize) {
        let old = -self.distance::<T>(v);
        let (distance, a) = self.return_of::<T>(v).expect("who waits was offered a parent");
        self.set_distance::<T>(v, distance);
        self.parent[v] = a;
        let tree = &mut self.trees[T::INDEX];
        if distance <= tree.grown {
            let (label, orphans) = (&self.label, &mut tree.orphans);
            self.network.each_lost::<T>(&self.parent, v, |w| {
                let old = -T::distance(label[w].get());
                orphans.push(w, (distance + 1).max(old) as usize);
            });
        } else if distance > old {
            tree.activate(v, distance);
        }
    }

    /// Frees those of `lost` that still are; the emptied list.
    fn set_free(&mut self, mut lost: Vec<u32>) -> Vec<u32> {
        for v in lost.drain(..) {
            let v = v as usize;
            if self.parent[v] == N::LOST {
                self.label[v] = N::Label::default();
                self.parent[v] = N::NONE;
            }
        }
        lost
    }
}

#[cfg(test)]
mod tests {
    use crate::noise::Noise;

    #[test]
    fn the_cut_does_not_depend_on_who_is_lost() {
        for rare in [1, 4, 20, 100] {
            let noise = Noise::new(rare);
            let one_by_one = noise.cut(|search| search.patience = usize::MAX);
            assert!(one_by_one.0.contains(&true) && one_by_one.1 > 0, "{rare}");
            for patience in [0, 1, 7, 50] {
                let lost = noise.cut(|search| search.patience = patience);
                assert_eq!(lost, one_by_one, "{rare} {patience}");
            }
        }
    }
}
