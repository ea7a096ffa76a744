//! [`Packed`]: a tree without pointers, eight children a node (thesis, 6.5.2 and 6.5.3).
//!
//! 1. Surfels are sorted along a Hilbert curve ([`Cube`](crate::curve::Cube)). Those without a living side are left out;
//!    a [`Record`] is one with one or two, its front alive.
//! 2. Sixteen records in a row are a *block*; eight blocks are a node, eight nodes another, up to
//!    one. Where a node's children lie follows from its number.
//! 3. 8192 records are a *part*: four levels over their blocks, built by one thread. Sums go up
//!    from child to parent as each is done, and are replaced by what is stored as soon as the node is: a running sum a level
//!    is alive, never the sums of a whole tree (Alg. 1). Levels above the parts are built last.
//!
//! How nodes and records are stored is a [`Store`]: [`Floats`] keeps them as they are, and is the
//! oracle for [`Compact`](crate::compact::Compact), which keeps some nine bytes a surfel. Both have the same nodes and make the
//! same cuts. Guaranteed: the same bits for any number of threads.

mod walk;

use crate::code::{self, Decoded};
use crate::harmonic::basis;
use crate::payload::{Exact, Sent};
use crate::surfel::Surfel;
use crate::tree::Node;
use chiaro_basis::math::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// Records of a block.
pub const BLOCK: usize = 16;
/// Children of a node.
pub const FAN: usize = 8;
/// Levels inside a part: blocks are level 0.
pub const PART_LEVELS: usize = 4;
/// Records of a part.
pub const PART: usize = BLOCK * FAN * FAN * FAN;

/// A surfel with a living side: its front lives.
pub type Record = Surfel;

/// The surfels that have a living side, in their order; those whose front is dead are turned over.
pub fn records(surfels: &[Surfel]) -> Vec<Record> {
    let there = |s: &&Surfel| s.area > 0.0 && s.alive != [false; 2];
    let fronted = |s: &Surfel| if s.alive[0] { *s } else { side(s, 1) };
    surfels.iter().filter(there).map(fronted).collect()
}

/// The living sides of records, each as a record of its own.
pub fn sides(records: &[Record]) -> Vec<Record> {
    let living = |r: &'_ Record| r.alive.into_iter().enumerate().filter(|(_, a)| *a);
    let one = |r: &Record| living(r).map(|(k, _)| side(r, k)).collect::<Vec<_>>();
    records.iter().flat_map(one).collect()
}

/// A side of a surfel, alone.
fn side(s: &Surfel, side: usize) -> Surfel {
    Surfel {
        normal: if side == 0 { s.normal } else { -s.normal },
        alive: [true, false],
        radiance: [s.radiance[side], [0.0; 3]],
        ..*s
    }
}

/// A node with its sums, as it is before it is stored.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    /// Sphere, mean, area and axis.
    pub node: Node,
    /// The lobes.
    pub lobes: Exact,
    low: Vec3,
    high: Vec3,
}

/// Where nodes and records go when they are done.
pub trait Store: Sync + Send {
    /// Stores the next block.
    fn block(&mut self, sums: &Sums, records: &[Record]);
    /// Stores the next node of a level; blocks are stored as nodes of level 0 too.
    fn node(&mut self, level: usize, sums: &Sums);
}

/// What a gather reads of a store. Levels count from the blocks up.
pub trait Stored: Sync + Send {
    /// The number of nodes of each level; the last has one.
    fn counts(&self) -> &[usize];
    /// Nodes that share a parent.
    type Siblings<'a>: Siblings
    where
        Self: 'a;

    /// The nodes of a level that share a parent.
    fn siblings(&self, level: usize, nodes: Range<usize>) -> Self::Siblings<'_>;
    /// Calls `each` with the records of a block that `wanted` names in a mask of bits.
    fn records(&self, block: usize, wanted: impl Fn(&Places) -> u32, each: impl FnMut(&Record));
}

/// Nodes that share a parent, by their places among them.
pub trait Siblings {
    /// Their bounding spheres.
    fn spheres(&self) -> Spheres;
    /// Their means and what goes with these.
    fn means(&self, spheres: &Spheres) -> Means;
    /// The lobes of one.
    fn lobes(&self, k: usize, means: &Means) -> Decoded;
    /// What a flat one sends along its mean normal and against it.
    fn along_axis(&self, k: usize, means: &Means) -> [Sent; 2];
    /// Whether nothing of one's area lives on its back.
    fn is_one_sided(&self, k: usize) -> bool;
}

/// Where the records of a block lie and face, side by side.
#[derive(Clone, Copy, Debug, Default)]
pub struct Places {
    /// Coordinates of their positions.
    pub position: [[f32; BLOCK]; 3],
    /// Those of their normals, of any length.
    pub normal: [[f32; BLOCK]; 3],
    /// Which have two living sides, in a mask of bits.
    pub both: u32,
}

/// Bounding spheres of siblings, side by side.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spheres {
    /// Coordinates of their centres.
    pub centre: [[f32; FAN]; 3],
    /// Their radii.
    pub radius: [f32; FAN],
}

/// Means of siblings, side by side.
#[derive(Clone, Copy, Debug, Default)]
pub struct Means {
    /// Coordinates of the means of their surfels.
    pub mean: [[f32; FAN]; 3],
    /// Those of their mean normals.
    pub axis: [[f32; FAN]; 3],
    /// Their areas.
    pub area: [f32; FAN],
}

impl Means {
    /// The mean normal of one.
    pub(crate) fn axis(&self, k: usize) -> Vec3 {
        Vec3::new(self.axis[0][k], self.axis[1][k], self.axis[2][k])
    }

    /// Sets one.
    fn set(&mut self, k: usize, node: &Node) {
        (0..3).for_each(|i| self.mean[i][k] = node.mean[i]);
        (0..3).for_each(|i| self.axis[i][k] = node.axis[i]);
        self.area[k] = node.area;
    }
}

impl Spheres {
    /// One's centre and radius.
    fn one(&self, k: usize) -> (Vec3, f32) {
        let [x, y, z] = &self.centre;
        (Vec3::new(x[k], y[k], z[k]), self.radius[k])
    }

    /// Sets one.
    pub(crate) fn set(&mut self, k: usize, centre: Vec3, radius: f32) {
        (0..3).for_each(|i| self.centre[i][k] = centre[i]);
        self.radius[k] = radius;
    }
}

/// A tree that is stored as `S` says.
#[derive(Clone, Debug, Default)]
pub struct Packed<S> {
    /// Nodes and records.
    pub store: S,
    /// The radius of a disc of a record's mean area.
    pub leaf_radius: f32,
}

/// The numbers of nodes of all levels over so many records.
pub fn counts(records: usize) -> Vec<usize> {
    if records == 0 {
        return Vec::new();
    }
    let mut counts = vec![records.div_ceil(BLOCK)];
    while counts.len() < PART_LEVELS || counts.last().is_some_and(|c| *c > 1) {
        let below = counts.last().copied().unwrap_or(1);
        counts.push(below.div_ceil(FAN));
    }
    counts
}

/// Stores a part: its blocks, and its nodes up to its root, whose sums it returns.
pub fn part(records: &[Record], store: &mut impl Store) -> Sums {
    grow(PART_LEVELS - 1, records, store)
}

fn grow(level: usize, records: &[Record], store: &mut impl Store) -> Sums {
    if level == 0 {
        let sums = Sums::of_records(records);
        store.block(&sums, records);
        store.node(0, &sums);
        return sums;
    }
    let mut gathered = Gathered::default();
    for child in records.chunks(BLOCK * FAN.pow(level as u32 - 1)) {
        gathered.add(&grow(level - 1, child, store));
    }
    let sums = gathered.done();
    store.node(level, &sums);
    sums
}

/// Stores the levels above the parts.
pub fn crown(roots: &[Sums], store: &mut impl Store) {
    let mut level = PART_LEVELS;
    let mut below = roots.to_vec();
    while below.len() > 1 {
        below = below
            .chunks(FAN)
            .map(|children| {
                let mut gathered = Gathered::default();
                children.iter().for_each(|c| gathered.add(c));
                let sums = gathered.done();
                store.node(level, &sums);
                sums
            })
            .collect();
        level += 1;
    }
}

/// The running sum of a node's children.
#[derive(Default)]
struct Gathered {
    sums: Sums,
    /// Bounding spheres of the children.
    spheres: Vec<(Vec3, f32)>,
}

impl Gathered {
    fn add(&mut self, child: &Sums) {
        let (all, c) = (&mut self.sums, &child.node);
        if self.spheres.is_empty() {
            (all.low, all.high) = (child.low, child.high);
        }
        all.low = all.low.min(child.low);
        all.high = all.high.max(child.high);
        all.node.area += c.area;
        all.node.mean += c.area * c.mean;
        all.node.axis += c.area * c.axis;
        all.lobes = all.lobes.plus(&child.lobes);
        self.spheres.push((c.centre, c.radius));
    }

    fn done(self) -> Sums {
        let mut sums = self.sums;
        let centre = 0.5 * (sums.low + sums.high);
        let over_children =
            self.spheres.iter().map(|(c, r)| c.distance(centre) + r).fold(0.0, f32::max);
        let weight = if sums.node.area > 0.0 { 1.0 / sums.node.area } else { 0.0 };
        sums.node.centre = centre;
        sums.node.radius = over_children.min(0.5 * sums.high.distance(sums.low));
        sums.node.mean = if weight > 0.0 { sums.node.mean * weight } else { centre };
        sums.node.axis *= weight;
        sums
    }
}

impl Sums {
    /// The node over records that lie together.
    pub fn of_records(records: &[Record]) -> Self {
        let mut sums = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, ..Self::default() };
        let node = &mut sums.node;
        for r in records {
            sums.lobes.add(r);
            sums.low = sums.low.min(r.position);
            sums.high = sums.high.max(r.position);
            node.mean += r.area * r.position;
            node.axis += r.area * r.normal;
            node.area += r.area;
        }
        let centre = 0.5 * (sums.low + sums.high);
        let weight = if node.area > 0.0 { 1.0 / node.area } else { 0.0 };
        node.centre = centre;
        node.radius = records.iter().map(|r| r.position.distance(centre)).fold(0.0, f32::max);
        node.mean = if weight > 0.0 { node.mean * weight } else { centre };
        node.axis *= weight;
        node.count = records.len() as u32;
        sums
    }
}

/// Everything in single precision.
#[derive(Clone, Debug, Default)]
pub struct Floats {
    levels: Vec<Vec<(Node, Exact)>>,
    records: Vec<Record>,
    counts: Vec<usize>,
}

impl Store for Floats {
    fn block(&mut self, _: &Sums, records: &[Record]) {
        self.records.extend(records);
    }

    fn node(&mut self, level: usize, sums: &Sums) {
        if self.levels.len() <= level {
            self.levels.resize(level + 1, Vec::new());
        }
        self.levels[level].push((sums.node, sums.lobes));
    }
}

impl Stored for Floats {
    fn counts(&self) -> &[usize] {
        &self.counts
    }

    type Siblings<'a> = &'a [(Node, Exact)];

    fn siblings(&self, level: usize, nodes: Range<usize>) -> &[(Node, Exact)] {
        &self.levels[level][nodes]
    }

    fn records(&self, block: usize, wanted: impl Fn(&Places) -> u32, each: impl FnMut(&Record)) {
        let end = (BLOCK * block + BLOCK).min(self.records.len());
        let records = &self.records[BLOCK * block..end];
        let mut places = Places::default();
        for (k, r) in records.iter().enumerate() {
            (0..3).for_each(|i| places.position[i][k] = r.position[i]);
            (0..3).for_each(|i| places.normal[i][k] = r.normal[i]);
            places.both |= u32::from(r.alive[1]) << k;
        }
        let mask = wanted(&places);
        (0..records.len()).filter(|k| mask >> k & 1 == 1).map(|k| &records[k]).for_each(each);
    }
}

impl Siblings for &[(Node, Exact)] {
    fn spheres(&self) -> Spheres {
        let mut spheres = Spheres::default();
        for (k, (node, _)) in self.iter().enumerate() {
            spheres.set(k, node.centre, node.radius);
        }
        spheres
    }

    fn means(&self, _: &Spheres) -> Means {
        let mut means = Means::default();
        self.iter().enumerate().for_each(|(k, (node, _))| means.set(k, node));
        means
    }

    fn lobes(&self, k: usize, _: &Means) -> Decoded {
        Decoded { local_from_world: None, lobes: self[k].1 }
    }

    fn along_axis(&self, k: usize, means: &Means) -> [Sent; 2] {
        self[k].1.sent_both(&basis(means.axis(k).normalize_or(Vec3::Z)))
    }

    fn is_one_sided(&self, k: usize) -> bool {
        let (node, lobes) = &self[k];
        code::both(lobes, node.area) < 0.5 / 255.0
    }
}

impl Packed<Floats> {
    /// The tree over records in the order of the curve.
    pub fn build(records: &[Record]) -> Self {
        let parts: Vec<(Floats, Sums)> = records
            .par_chunks(PART)
            .map(|records| {
                let mut store = Floats::default();
                let root = part(records, &mut store);
                (store, root)
            })
            .collect();
        let mut store = Floats { counts: counts(records.len()), ..Floats::default() };
        let roots: Vec<Sums> = parts.iter().map(|p| p.1).collect();
        for (part, _) in parts {
            store.records.extend(part.records);
            store.levels.resize(store.levels.len().max(part.levels.len()), Vec::new());
            store.levels.iter_mut().zip(part.levels).for_each(|(all, more)| all.extend(more));
        }
        crown(&roots, &mut store);
        let area: f64 = records.iter().map(|r| f64::from(r.area)).sum();
        Self { store, leaf_radius: leaf_radius(area, records.len()) }
    }

    /// Calls `each` with every node and its lobes.
    pub fn each_node(&self, mut each: impl FnMut(&Node, &Exact)) {
        self.store.levels.iter().flatten().for_each(|(node, lobes)| each(node, lobes));
    }

    /// The same tree with other lobes.
    pub fn with_lobes(&self, lobes: impl Fn(&Node, &Exact) -> Exact + Sync) -> Self {
        let mut other = self.clone();
        other.store.levels.par_iter_mut().flatten().for_each(|(node, own)| *own = lobes(node, own));
        other
    }

    /// Bytes of nodes and records.
    pub fn bytes(&self) -> usize {
        let nodes: usize = self.store.levels.iter().map(Vec::capacity).sum();
        nodes * size_of::<(Node, Exact)>() + self.store.records.capacity() * size_of::<Record>()
    }
}

/// The radius of a disc of a record's mean area.
pub fn leaf_radius(area: f64, records: usize) -> f32 {
    (area / records.max(1) as f64 / std::f64::consts::PI).sqrt() as f32
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::Tree;
    use crate::curve::Cube;
    use crate::cut::Chooser;
    use crate::hierarchy::Hierarchy;
    use crate::sight::Sight;
    use chiaro_basis::random;

    /// Surfels on a bent sheet, along the curve.
    pub(crate) fn sheet(n: u64) -> Vec<Surfel> {
        let surfel = |i: u64| {
            let [u, v] = random::r2(i);
            let bend = (6.0 * u).sin();
            Surfel {
                position: Vec3::new(u, 0.2 * bend, v),
                normal: Vec3::new(-1.2 * (6.0 * u).cos(), 1.0, 0.0).normalize(),
                area: 1.0 / n as f32,
                alive: [!i.is_multiple_of(7), i.is_multiple_of(3)],
                albedo: [0.5; 3],
                radiance: [[1.0 + u, v, 0.2], [0.3, 0.0, v]],
            }
        };
        let mut all: Vec<Surfel> = (0..n).map(surfel).collect();
        let cube = Cube::around(Vec3::new(0.0, -0.2, 0.0), Vec3::ONE);
        all.sort_by_key(|s| cube.index(s.position));
        all
    }

    /// A node of a store.
    pub(crate) fn node(store: &impl Stored, level: usize, index: usize) -> Node {
        let siblings = store.siblings(level, index..index + 1);
        let spheres = siblings.spheres();
        let means = siblings.means(&spheres);
        let (centre, radius) = spheres.one(0);
        let mean = Vec3::from(means.mean.map(|c| c[0]));
        Node { centre, radius, mean, area: means.area[0], axis: means.axis(0), ..Node::default() }
    }

    #[test]
    fn siblings_are_seen_as_each_by_itself() {
        let tree = Packed::build(&records(&sheet(2000)));
        let from = Vec3::new(0.4, 0.3, 0.2);
        for (above, flat) in [(None, true), (Some(Vec3::new(0.6, -0.8, 0.0)), true), (None, false)]
        {
            let chooser = Chooser { from, threshold: 0.005, near: 0.1, mark: 0.1, above, flat };
            let siblings = tree.store.siblings(0, 8..16);
            let means = siblings.means(&siblings.spheres());
            let sights = chooser.sights(&means);
            for k in 0..FAN {
                let own = node(&tree.store, 0, 8 + k);
                let seen = (sights.above >> k & 1 == 1).then(|| sights.one(k, own.axis));
                let alone = chooser.sight(&own);
                assert_eq!(seen.is_some(), alone.is_some());
                let bits = |s: Option<Sight>| s.map(|s| format!("{s:?}"));
                assert_eq!(bits(seen), bits(alone));
            }
        }
    }

    #[test]
    fn the_cut_of_a_packed_tree_sends_what_that_of_a_binary_tree_sends() {
        let surfels = sheet(20_000);
        let (packed, binary) = (Packed::build(&records(&surfels)), Tree::build(&surfels));
        for from in [Vec3::new(0.5, 1.5, 0.5), Vec3::new(0.2, 0.6, 0.1), Vec3::new(0.9, 1.2, 0.8)] {
            let chooser =
                Chooser { from, threshold: 0.005, near: 0.1, mark: 0.1, above: None, flat: true };
            let light = |tree: &dyn Hierarchy| {
                let mut splats = Vec::new();
                tree.cut(&chooser, &mut splats);
                splats.iter().fold([0.0; 4], |s, x| {
                    let r = x.radiance.map(|c| c * x.solid_angle);
                    [s[0] + r[0], s[1] + r[1], s[2] + r[2], s[3] + x.solid_angle]
                })
            };
            let (a, b) = (light(&packed), light(&binary));
            for i in 0..4 {
                assert!((a[i] / b[i] - 1.0).abs() < 0.04, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn levels_hold_what_is_below_them() {
        let all = records(&sheet(30_000));
        let tree = Packed::build(&all);
        let (counts, top) = (tree.store.counts(), tree.store.levels.len() - 1);
        assert_eq!(counts, tree.store.levels.iter().map(Vec::len).collect::<Vec<_>>());
        let root = &tree.store.levels[top][0].0;
        let area: f32 = all.iter().map(|r| r.area).sum();
        assert!((root.area / area - 1.0).abs() < 1e-3);
        for level in 1..=top {
            for (i, (parent, _)) in tree.store.levels[level].iter().enumerate() {
                let end = (FAN * i + FAN).min(counts[level - 1]);
                for (child, _) in &tree.store.levels[level - 1][FAN * i..end] {
                    let corner = child.centre.distance(parent.centre) - child.radius;
                    assert!(corner <= parent.radius * 1.001);
                }
            }
        }
        for (i, r) in all.iter().enumerate() {
            for level in 0..=top {
                let node = &tree.store.levels[level][i / BLOCK / FAN.pow(level as u32)].0;
                assert!(r.position.distance(node.centre) <= node.radius * 1.0001 + 1e-6);
            }
        }
        assert!(Packed::build(&[]).is_empty());
    }
}
