//! [`Sets`]: numbers that belong together, by Tarjan's disjoint sets.

/// Disjoint sets of the numbers from 0 on, each named by its least member, whatever the order in which they were
/// joined.
#[derive(Clone, Debug, Default)]
pub struct Sets {
    /// An earlier member of the same set, or the number itself.
    parent: Vec<u32>,
}

impl Sets {
    /// Each of so many numbers by itself.
    pub fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// How many numbers there are.
    pub fn len(&self) -> usize {
        self.parent.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.parent.is_empty()
    }

    /// Adds a number by itself.
    pub fn add(&mut self) -> usize {
        self.parent.push(self.parent.len() as u32);
        self.parent.len() - 1
    }

    /// The least member of a number's set.
    pub fn root(&mut self, number: usize) -> usize {
        let mut at = number;
        while self.parent[at] as usize != at {
            self.parent[at] = self.parent[self.parent[at] as usize];
            at = self.parent[at] as usize;
        }
        at
    }

    /// Joins the sets of two numbers; whether they were apart.
    pub fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b)] = a.min(b) as u32;
        a != b
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::unit;

    /// Against labels that are all written anew at every join.
    #[test]
    fn sets_are_named_by_their_least_member() {
        let count = 60;
        let (mut sets, mut labels) = (Sets::new(count - 1), (0..count).collect::<Vec<_>>());
        assert_eq!(sets.add(), count - 1);
        for k in 0..50 {
            let [a, b] = [0, 1].map(|c| (unit(c, k) * count as f32) as usize);
            let (least, other) = (labels[a].min(labels[b]), labels[a].max(labels[b]));
            assert_eq!(sets.join(a, b), least != other);
            labels.iter_mut().filter(|l| **l == other).for_each(|l| *l = least);
            assert!((0..count).all(|i| sets.root(i) == labels[i]));
        }
        assert!(sets.len() == count && !sets.is_empty());
    }
}
