//! [`Wide`]: nodes of a binary tree in groups of eight, side by side, for walks that test eight
//! spheres at once.
//!
//! A group holds the two nodes below one node, then those below the largest of these, and so on
//! until there are eight. Groups lie in breadth-first order; the nodes of a group in the tree's.
//! Every node but the root is in one group, so that a walk judges the nodes that it would judge one by
//! one, and some below those that it does not open. Made once from a tree, from nothing else.

use crate::tree::Node;

/// Nodes in a group.
pub const LANES: usize = 8;
/// No node, or no group.
pub const NONE: u32 = u32::MAX;

/// Up to eight nodes.
#[derive(Clone, Copy, Debug)]
pub struct Wide {
    /// Coordinates of the centres of their spheres.
    pub centre: [[f32; LANES]; 3],
    /// Radii.
    pub radius: [f32; LANES],
    /// Their indices in the tree, [`NONE`] after the last.
    pub node: [u32; LANES],
    /// The groups below them; [`NONE`] below leaves and below what has its children in this group.
    pub below: [u32; LANES],
    /// How many of the nodes that follow are below each.
    pub within: [u8; LANES],
}

/// The groups of a tree; the first holds what is below the root, or the root where that is a leaf.
pub(crate) fn groups(nodes: &[Node]) -> Vec<Wide> {
    if nodes.is_empty() {
        return Vec::new();
    }
    let mut roots = vec![0u32];
    let mut all = Vec::new();
    while let Some(&root) = roots.get(all.len()) {
        let (members, count) = members(nodes, root);
        let mut wide = Wide {
            centre: [[0.0; LANES]; 3],
            radius: [0.0; LANES],
            node: [NONE; LANES],
            below: [NONE; LANES],
            within: [0; LANES],
        };
        for (lane, &index) in members[..count].iter().enumerate() {
            let node = &nodes[index as usize];
            (0..3).for_each(|c| wide.centre[c][lane] = node.centre[c]);
            wide.radius[lane] = node.radius;
            wide.node[lane] = index;
            let rest = &members[lane + 1..count];
            wide.within[lane] = rest.iter().filter(|m| **m < index + node.size).count() as u8;
            if node.count == 0 && wide.within[lane] == 0 {
                wide.below[lane] = roots.len() as u32;
                roots.push(index);
            }
        }
        all.push(wide);
    }
    all
}

/// The nodes of the group below a node, in the tree's order, and their number; a leaf by itself.
fn members(nodes: &[Node], root: u32) -> ([u32; LANES], usize) {
    let mut members = [root; LANES];
    if nodes[root as usize].count > 0 {
        return (members, 1);
    }
    let children = |of: u32| [of + 1, of + 1 + nodes[of as usize + 1].size];
    members[..2].copy_from_slice(&children(root));
    let mut count = 2;
    let mut opened = [false; LANES];
    while count + 2 <= LANES {
        let node = |i: usize| &nodes[members[i] as usize];
        let inner = (0..count).filter(|&i| !opened[i] && node(i).count == 0);
        let Some(largest) = inner.max_by(|&a, &b| node(a).radius.total_cmp(&node(b).radius)) else {
            break;
        };
        let below = children(members[largest]);
        members.copy_within(largest + 1..count, largest + 3);
        opened.copy_within(largest + 1..count, largest + 3);
        members[largest + 1..largest + 3].copy_from_slice(&below);
        opened[largest..largest + 3].copy_from_slice(&[true, false, false]);
        count += 2;
    }
    (members, count)
}
