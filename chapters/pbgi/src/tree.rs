//! [`Tree`]: a hierarchy of bounding spheres over surfels (thesis, 6.3.2, Point Hierarchy).
//!
//! 1. Surfels are sorted along a Z-curve; in its cells, what faces different ways is told apart (`facing`).
//! 2. A range of the curve is halved where its highest differing bit changes, or, in an octree, cut
//!    wherever its highest differing three bits do: into the cells of a cube. So down to leaves of at most
//!    [`LEAF`] surfels.
//! 3. Sums go bottom-up, children in order, subtrees in parallel.
//! 4. Walks use the same nodes in groups of eight (`wide`); of flat nodes, what they
//!    send is solved once.
//!
//! Nodes lie in depth-first order; each knows the length of its subtree, so that subtrees built
//! apart are joined by being written one after the other. A node's sphere
//! bounds its surfels' centres and decides whether it is opened; its mean, weighted by area, is
//! where it is splatted. Guaranteed: the same bits for any number of threads.

use crate::curve;
use crate::cut::{Faces, Span};
use crate::facing;
use crate::knob::Division;
use crate::payload::{Exact, Payload};
use crate::surfel::Surfel;
use crate::wide::{self, Wide};
use chiaro_basis::math::Vec3;
use rayon::prelude::*;

/// Surfels in a leaf, at most.
pub const LEAF: usize = 8;
/// Smaller ranges are built by one thread.
const ALONE: usize = 8192;

/// A group of surfels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Node {
    /// The bounding sphere's centre.
    pub centre: Vec3,
    /// The bounding sphere's radius; holds the surfels' centres.
    pub radius: f32,
    /// The mean of the surfels' positions, weighted by area.
    pub mean: Vec3,
    /// Their summed area, whichever sides live.
    pub area: f32,
    /// The mean of their normals, weighted by area: of length 1 when they are flat.
    pub axis: Vec3,
    /// Nodes of the subtree, this one included.
    pub size: u32,
    /// The first surfel.
    pub first: u32,
    /// Surfels of a leaf; 0 in inner nodes.
    pub count: u32,
}

/// Surfels with the nodes over them.
#[derive(Clone, Debug)]
pub struct Tree<P: Payload = Exact> {
    /// In depth-first order.
    pub nodes: Vec<Node>,
    /// What each node stores.
    pub payload: Vec<P>,
    /// What all nodes share.
    pub book: P::Book,
    /// In the tree's order.
    pub surfels: Vec<Surfel>,
    /// The radius of a disc of a surfel's mean area.
    pub leaf_radius: f32,
    /// The nodes in groups.
    pub(crate) wide: Vec<Wide>,
    /// What each node sends as a flat one.
    pub(crate) faces: Vec<Faces>,
}

impl Tree<Exact> {
    /// Builds the binary tree over surfels.
    pub fn build(surfels: &[Surfel]) -> Self {
        Self::build_by(Division::Spheres, surfels)
    }

    /// Builds the tree over surfels, divided in a way.
    pub fn build_by(division: Division, surfels: &[Surfel]) -> Self {
        let surfels = sorted(surfels);
        let keys: Vec<u64> = surfels.iter().map(|(key, _)| *key).collect();
        let surfels: Vec<Surfel> = surfels.into_iter().map(|(_, s)| s).collect();
        let mut part = Part { division, ..Part::default() };
        if !surfels.is_empty() {
            part.grow(&keys, &surfels, 0);
        }
        let Part { nodes, payload, .. } = part;
        let area: f64 = surfels.iter().map(|s| f64::from(s.area)).sum();
        let mean = area / surfels.len().max(1) as f64;
        let leaf_radius = (mean / std::f64::consts::PI).sqrt() as f32;
        let wide = wide::groups(&nodes);
        let faces = nodes.par_iter().zip(&payload).map(|(n, p)| Faces::of_flat(n, p)).collect();
        Self { nodes, payload, book: (), surfels, leaf_radius, wide, faces }
    }
}

impl<P: Payload> Tree<P> {
    /// The surfels under a node.
    pub(crate) fn span(&self, index: usize) -> Span {
        let node = &self.nodes[index];
        let after = self.nodes.get(index + node.size as usize);
        let end = after.map_or(self.surfels.len() as u32, |n| n.first);
        Span { first: node.first, count: end.saturating_sub(node.first) }
    }

    /// Bytes of nodes, payload and surfels.
    pub fn bytes(&self) -> usize {
        size_of::<Node>() * self.nodes.capacity()
            + size_of::<P>() * self.payload.capacity()
            + size_of::<Wide>() * self.wide.capacity()
            + size_of::<Faces>() * self.faces.capacity()
            + size_of::<Surfel>() * self.surfels.capacity()
    }
}

/// The surfels with their keys, along the curve.
fn sorted(surfels: &[Surfel]) -> Vec<(u64, Surfel)> {
    let low = surfels.iter().fold(Vec3::INFINITY, |m, s| m.min(s.position));
    let high = surfels.iter().fold(Vec3::NEG_INFINITY, |m, s| m.max(s.position));
    let scale = ((1 << 21) - 1) as f32 / (high - low).max_element().max(f32::MIN_POSITIVE);
    let mut order: Vec<(u64, u32)> = surfels
        .par_iter()
        .enumerate()
        .map(|(i, s)| {
            let p = (s.position - low) * scale;
            (interleave(p.x) | interleave(p.y) << 1 | interleave(p.z) << 2, i as u32)
        })
        .collect();
    order.par_sort_unstable();
    let mut keyed: Vec<(u64, Surfel)> =
        order.into_par_iter().map(|(key, i)| (key, surfels[i as usize])).collect();
    facing::part(&mut keyed);
    keyed
}

/// 21 bits of a coordinate, two gaps after each.
fn interleave(coordinate: f32) -> u64 {
    let mut x = (coordinate.clamp(0.0, 2_097_151.0)) as u64;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// A subtree, its nodes in depth-first order.
#[derive(Default)]
struct Part {
    division: Division,
    nodes: Vec<Node>,
    payload: Vec<Exact>,
}

/// What a subtree hands to its parent.
#[derive(Default)]
struct Summary {
    low: Vec3,
    high: Vec3,
    node: Node,
    payload: Exact,
}

impl Part {
    /// Adds the subtree over a range of surfels.
    fn grow(&mut self, keys: &[u64], surfels: &[Surfel], first: u32) -> Summary {
        if surfels.len() <= LEAF && !facing::mixed(surfels) {
            let summary = leaf(surfels, first);
            self.nodes.push(summary.node);
            self.payload.push(summary.payload);
            return summary;
        }
        let place = self.nodes.len();
        self.nodes.push(Node::default());
        self.payload.push(Exact::default());
        let (ends, count) = match self.division {
            Division::Spheres => halves(keys),
            Division::Octree => cells(keys),
        };
        let range = |i: usize| if i == 0 { 0..ends[0] } else { ends[i - 1]..ends[i] };
        let below = |part: &mut Self, i: usize| {
            let range = range(i);
            let first = first + range.start as u32;
            part.grow(&keys[range.clone()], &surfels[range], first)
        };
        let (mut summary, mut spheres) = (Summary::default(), [(Vec3::ZERO, 0.0); 8]);
        let mut join = |i: usize, child: Summary| {
            spheres[i] = (child.node.centre, child.node.radius);
            summary = if i == 0 { child } else { inner(&summary, &child) };
        };
        if surfels.len() > ALONE {
            let apart = |i| {
                let mut part = Self { division: self.division, ..Self::default() };
                let summary = below(&mut part, i);
                (part, summary)
            };
            let parts: Vec<_> = (0..count).into_par_iter().map(apart).collect();
            for (i, (part, summary)) in parts.into_iter().enumerate() {
                self.nodes.extend(part.nodes);
                self.payload.extend(part.payload);
                join(i, summary);
            }
        } else {
            (0..count).for_each(|i| join(i, below(self, i)));
        }
        if count > 2 {
            (summary.node.centre, summary.node.radius) = around(&summary, &spheres[..count]);
        }
        summary.node =
            Node { size: (self.nodes.len() - place) as u32, first, count: 0, ..summary.node };
        self.nodes[place] = summary.node;
        self.payload[place] = summary.payload;
        summary
    }
}

/// Where the parts of a range end, and how many there are.
type Ends = ([usize; 8], usize);

/// Two parts: where the highest differing bit changes; the halves of equal keys.
fn halves(keys: &[u64]) -> Ends {
    let mut ends = [keys.len(); 8];
    ends[0] = curve::half(keys, |key| *key);
    (ends, 2)
}

/// Up to eight parts: the cells of the smallest cube of the curve that holds all keys.
fn cells(keys: &[u64]) -> Ends {
    let (first, last) = (keys[0], keys[keys.len() - 1]);
    if first == last {
        return halves(keys);
    }
    let shift = (63 - (first ^ last).leading_zeros()) / 3 * 3;
    let (mut ends, mut count, mut start) = ([keys.len(); 8], 0, 0);
    while start < keys.len() {
        let cell = keys[start] >> shift;
        start += keys[start..].partition_point(|k| k >> shift == cell);
        ends[count] = start;
        count += 1;
    }
    (ends, count)
}

fn leaf(surfels: &[Surfel], first: u32) -> Summary {
    let mut payload = Exact::default();
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (mut mean, mut axis, mut area) = (Vec3::ZERO, Vec3::ZERO, 0.0);
    for s in surfels {
        payload.add(s);
        low = low.min(s.position);
        high = high.max(s.position);
        mean += s.position * s.area;
        axis += s.normal * s.area;
        area += s.area;
    }
    let centre = 0.5 * (low + high);
    let radius = surfels.iter().map(|s| s.position.distance(centre)).fold(0.0, f32::max);
    let weight = if area > 0.0 { 1.0 / area } else { 0.0 };
    let node = Node {
        centre,
        radius,
        mean: if area > 0.0 { mean * weight } else { centre },
        area,
        axis: axis * weight,
        size: 1,
        first,
        count: surfels.len() as u32,
    };
    Summary { low, high, node, payload }
}

/// Two subtrees, side by side.
fn inner(left: &Summary, right: &Summary) -> Summary {
    let (low, high) = (left.low.min(right.low), left.high.max(right.high));
    let (l, r) = (&left.node, &right.node);
    let area = l.area + r.area;
    let t = if area > 0.0 { r.area / area } else { 0.5 };
    let (centre, radius) = sphere(l, r, low, high);
    let (mean, axis) = (l.mean.lerp(r.mean, t), l.axis.lerp(r.axis, t));
    let node = Node { centre, radius, mean, area, axis, ..Node::default() };
    Summary { low, high, node, payload: left.payload.plus(&right.payload) }
}

/// A sphere around the box of many subtrees, not larger than their own spheres ask.
fn around(all: &Summary, spheres: &[(Vec3, f32)]) -> (Vec3, f32) {
    let centre = 0.5 * (all.low + all.high);
    let reach = |(own, radius): &(Vec3, f32)| own.distance(centre) + radius;
    let radius = spheres.iter().map(reach).fold(0.0, f32::max);
    (centre, radius.min(0.5 * all.high.distance(all.low)))
}

/// The smaller of the sphere around two spheres and the sphere around the box.
fn sphere(l: &Node, r: &Node, low: Vec3, high: Vec3) -> (Vec3, f32) {
    let (box_centre, box_radius) = (0.5 * (low + high), 0.5 * high.distance(low));
    let (towards, distance) = (r.centre - l.centre).normalize_and_length();
    if distance + r.radius <= l.radius {
        return (l.centre, l.radius);
    }
    if distance + l.radius <= r.radius {
        return (r.centre, r.radius);
    }
    let radius = 0.5 * (distance + l.radius + r.radius);
    if radius < box_radius {
        (l.centre + towards * (radius - l.radius), radius)
    } else {
        (box_centre, box_radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random;

    fn cloud(n: u64) -> Vec<Surfel> {
        let unit = |k: u64, i: u64| random::unit(k, i) - 0.5;
        (0..n)
            .map(|i| Surfel {
                position: Vec3::new(unit(1, i), unit(2, i), unit(3, i)),
                normal: Vec3::new(unit(4, i), unit(5, i), unit(6, i)).normalize_or(Vec3::Y),
                area: 0.01 + 0.01 * random::unit(7, i),
                alive: [true, i % 3 == 0],
                albedo: [0.5; 3],
                radiance: [[1.0, 0.5, 0.2], [0.3; 3]],
            })
            .collect()
    }

    #[test]
    fn every_node_bounds_and_sums_what_is_below_it() {
        for division in [Division::Spheres, Division::Octree] {
            bounds_and_sums(&Tree::build_by(division, &cloud(3000)));
        }
    }

    fn bounds_and_sums(tree: &Tree) {
        for (i, node) in tree.nodes.iter().enumerate() {
            let below = &tree.nodes[i..i + node.size as usize];
            let leaves = below.iter().filter(|n| n.count > 0);
            let surfels: Vec<&Surfel> = leaves
                .flat_map(|n| &tree.surfels[n.first as usize..(n.first + n.count) as usize])
                .collect();
            let area: f32 = surfels.iter().map(|s| s.area).sum();
            assert!((area - node.area).abs() < 1e-3 * area);
            for s in surfels {
                assert!(s.position.distance(node.centre) <= node.radius * 1.0001 + 1e-5);
            }
        }
        assert_eq!(tree.nodes[0].size as usize, tree.nodes.len());
    }

    #[test]
    fn the_tree_has_the_same_bits_for_any_number_of_threads() {
        let surfels = cloud(30_000);
        for division in [Division::Spheres, Division::Octree] {
            let on = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| Tree::build_by(division, &surfels))
            };
            let (a, b) = (on(1), on(4));
            let same = |(a, b): (&Node, &Node)| a.mean == b.mean && a.size == b.size;
            assert_eq!(a.payload, b.payload);
            assert!(a.nodes.iter().zip(&b.nodes).all(same));
        }
    }

    #[test]
    fn an_octree_s_nodes_are_the_cells_of_cubes_and_sum_to_the_same() {
        let surfels = cloud(5000);
        let [binary, octree] =
            [Division::Spheres, Division::Octree].map(|d| Tree::build_by(d, &surfels));
        let places = |t: &Tree| t.surfels.iter().map(|s| s.position).collect::<Vec<_>>();
        assert_eq!(places(&binary), places(&octree));
        let light = |t: &Tree| t.payload[0].light[0];
        let both = light(&binary).into_iter().zip(light(&octree));
        both.for_each(|(a, b)| assert!((a - b).abs() < 1e-3 * a.abs().max(0.1), "{a} {b}"));
        // Eight children below the root, each in its own octant.
        let (mut children, mut at) = (Vec::new(), 1);
        while at < octree.nodes.len() {
            children.push(octree.nodes[at].mean);
            at += octree.nodes[at].size as usize;
        }
        let signs = |v: &Vec3| [0, 1, 2].map(|c| v[c] > 0.0);
        let mut octants: Vec<_> = children.iter().map(signs).collect();
        octants.sort_unstable();
        octants.dedup();
        assert_eq!((children.len(), octants.len()), (8, 8));
    }

    #[test]
    fn equal_places_and_no_surfels_make_trees_too() {
        let mut same = cloud(100);
        same.iter_mut().for_each(|s| s.position = Vec3::ONE);
        assert_eq!(Tree::build(&same).surfels.len(), 100);
        assert!(Tree::build(&[]).nodes.is_empty());
    }
}
