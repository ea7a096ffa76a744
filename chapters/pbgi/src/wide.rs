//! [`Wide`]: nodes of a tree in groups of eight, side by side, for walks that test eight
//! spheres at once.
//!
//! A group holds the nodes below one node, then those below the largest of these that still have room,
//! and so on. Groups lie in breadth-first order; the nodes of a group in the tree's.
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
    let mut count = insert(nodes, root, &mut members, 0);
    let mut opened = [false; LANES];
    loop {
        let node = |i: usize| &nodes[members[i] as usize];
        let fits = |i: usize| {
            !opened[i] && node(i).count == 0 && count + children(nodes, members[i]).count() <= LANES
        };
        let all = (0..count).filter(|&i| fits(i));
        let Some(largest) = all.max_by(|&a, &b| node(a).radius.total_cmp(&node(b).radius)) else {
            return (members, count);
        };
        let (mut tail, mut tail_opened, rest) = (members, opened, count - largest - 1);
        tail.copy_within(largest + 1..count, 0);
        tail_opened.copy_within(largest + 1..count, 0);
        opened[largest] = true;
        let end = insert(nodes, members[largest], &mut members, largest + 1);
        members[end..end + rest].copy_from_slice(&tail[..rest]);
        opened[largest + 1..end].fill(false);
        opened[end..end + rest].copy_from_slice(&tail_opened[..rest]);
        count = end + rest;
    }
}

/// Writes the nodes below a node from a place on; the place after them.
fn insert(nodes: &[Node], of: u32, members: &mut [u32; LANES], from: usize) -> usize {
    children(nodes, of).fold(from, |place, child| {
        members[place] = child;
        place + 1
    })
}

/// The nodes below a node.
fn children(nodes: &[Node], of: u32) -> impl Iterator<Item = u32> {
    let end = of + nodes[of as usize].size;
    let next = move |child: &u32| {
        let next = child + nodes[*child as usize].size;
        (next < end).then_some(next)
    };
    std::iter::successors(Some(of + 1), next)
}
