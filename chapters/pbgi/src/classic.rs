//! [`Classic`]: the thesis's own tree, binary, one surfel a leaf (6.5.2, 6.5.3, Algorithm 1).
//!
//! - Living sides of surfels ([`Record`]) along a Hilbert curve are the leaves; a range is halved down
//!   to single ones, so that which nodes are whose children follows from numbers and costs nothing.
//! - An inner node has a position, the mean of its children's, in single precision; a radius that
//!   bounds what is below it; and its lobes: 27 + 9 floats, or an index into a table of words and,
//!   unless the area has a table too, 9 floats.
//! - A leaf is 26 bytes in format A (position in floats, half floats for colour, normal and area)
//!   or 16 in format B (position in 15 bits relative to its parent, as in QSplat).
//!
//! Sums go up in post-order and are coded as soon as a node is done. Siblings wait on each level
//! of the path to the root: not arity + 1 vectors are alive, as the thesis has it, but one a level and two more
//! ([`Classic::alive`]). The thesis's table 6.1 counts positions, leaves and indices of light;
//! radii and the area's lobes are counted apart here ([`Classic::counted`]).
//!
//! The baseline of all else: nodes are splatted by their series alone, flat or not. Guaranteed: the
//! same bits for any number of threads.

use crate::bitrows::BitRows;
use crate::bits::{float16_above, from_float16};
use crate::code::{Book, Decoded, Lobes, Pen};
use crate::cut::{Chooser, Faces, Span, Splat, Verdict};
use crate::harmonic::Sh;
use crate::hierarchy::Hierarchy;
pub use crate::leaf::Leaf;
use crate::leaf::Scale;
use crate::packed::{Record, leaf_radius};
use crate::payload::Exact;
use crate::sight::Sight;
use crate::surfel::Surfel;
use crate::tree::Node;
use chiaro_basis::math::Vec3;

/// Larger ranges are built by two threads.
const ALONE: usize = 8192;
/// The first function of the basis, and a disc's first coefficient over its area.
const AREA_OF_FIRST: f32 = 1.0 / (std::f32::consts::PI * 0.282_094_8);

/// Bytes of a tree by what they hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counted {
    /// Leaves.
    pub leaves: usize,
    /// Positions of inner nodes.
    pub positions: usize,
    /// Lobes of light, or their indices.
    pub light: usize,
    /// Lobes of area or their indices, radii, and areas where a code needs them: not in the thesis.
    pub more: usize,
    /// Tables of words.
    pub tables: usize,
}

impl Counted {
    /// What the thesis counts.
    pub fn of_thesis(&self) -> usize {
        self.leaves + self.positions + self.light
    }

    /// Everything.
    pub fn all(&self) -> usize {
        self.of_thesis() + self.more + self.tables
    }
}

/// The tree.
#[derive(Debug)]
pub struct Classic {
    leaf: Leaf,
    leaves: Vec<u8>,
    /// Inner nodes in pre-order.
    positions: Vec<Vec3>,
    radii: Vec<u16>,
    stored: Stored,
    count: usize,
    scale: Scale,
    leaf_radius: f32,
    alive: usize,
}

/// Lobes of inner nodes.
#[derive(Debug)]
enum Stored {
    Exact(Vec<Exact>),
    Coded { book: Box<Book>, rows: BitRows, areas: Vec<u16>, lobes: Vec<Sh>, top_area: f32 },
}

/// The parts of a tree that a subtree fills.
struct Room<'a> {
    leaves: &'a mut [u8],
    positions: &'a mut [Vec3],
    radii: &'a mut [u16],
    exact: &'a mut [Exact],
    areas: &'a mut [u16],
    lobes: &'a mut [Sh],
}

/// What a subtree hands to its parent.
struct Done {
    position: Vec3,
    radius: f32,
    area: f32,
    lobes: Exact,
    /// Lobes that were alive at the same time.
    alive: usize,
}

struct Maker<'a> {
    records: &'a [Record],
    leaf: Leaf,
    scale: Scale,
    book: Option<(&'a Book, &'a BitRows, f32)>,
}

impl Classic {
    /// The tree over records along the curve, lobes in single precision: the thesis's ground truth.
    pub fn exact(records: &[Record], leaf: Leaf) -> Self {
        let inner = records.len().saturating_sub(1);
        let stored = Stored::Exact(vec![Exact::default(); inner]);
        Self::empty(records, leaf, stored).filled(records)
    }

    /// The tree whose lobes are coded on the fly (Algorithm 1).
    pub fn coded(records: &[Record], leaf: Leaf, book: &Book) -> Self {
        let inner = records.len().saturating_sub(1);
        let areas = if book.recipe.by_area { vec![0; inner] } else { Vec::new() };
        let area: f64 = records.iter().map(|r| f64::from(r.area)).sum();
        let lobes = if book.recipe.area.is_empty() { vec![[0.0; 9]; inner] } else { Vec::new() };
        let rows = BitRows::new(inner, book.recipe.widths());
        let (book, top_area) = (Box::new(book.clone()), area as f32);
        let stored = Stored::Coded { book, rows, areas, lobes, top_area };
        Self::empty(records, leaf, stored).filled(records)
    }

    fn empty(records: &[Record], leaf: Leaf, stored: Stored) -> Self {
        let (count, inner) = (records.len(), records.len().saturating_sub(1));
        let area: f64 = records.iter().map(|r| f64::from(r.area)).sum();
        Self {
            leaf,
            leaves: vec![0; count * leaf.size()],
            positions: vec![Vec3::ZERO; inner.max(count.min(1))],
            radii: vec![0; inner],
            stored,
            count,
            scale: Scale::of(records),
            leaf_radius: leaf_radius(area, count),
            alive: 0,
        }
    }

    fn filled(mut self, records: &[Record]) -> Self {
        let mut none = Vec::new();
        let (mut no_areas, mut no_lobes) = (Vec::new(), Vec::new());
        let (exact, areas, lobes, book) = match &mut self.stored {
            Stored::Exact(exact) => (exact, &mut no_areas, &mut no_lobes, None),
            Stored::Coded { book, rows, areas, lobes, top_area } => {
                (&mut none, areas, lobes, Some((&**book, &*rows, *top_area)))
            }
        };
        let maker = Maker { records, leaf: self.leaf, scale: self.scale, book };
        match records {
            [] => {}
            [one] => {
                self.positions[0] = one.position;
                self.leaf.write(one, (one.position, 0.0), &self.scale, &mut self.leaves);
            }
            _ => {
                let room = Room {
                    leaves: &mut self.leaves,
                    positions: &mut self.positions,
                    radii: &mut self.radii,
                    exact,
                    areas,
                    lobes,
                };
                self.alive = maker.grow(0, 0..records.len(), room, 0, &mut Pen::default()).alive;
            }
        }
        self
    }

    /// How many lobes that were not coded were alive at once for one worker.
    pub fn alive(&self) -> usize {
        self.alive
    }

    /// Inner nodes.
    pub fn nodes(&self) -> usize {
        self.count.saturating_sub(1)
    }

    /// Bytes by what they hold.
    pub fn counted(&self) -> Counted {
        let inner = self.nodes();
        let (light, more, tables) = match &self.stored {
            Stored::Exact(_) => (108 * inner, 36 * inner, 0),
            Stored::Coded { book, rows, areas, lobes, .. } => {
                let light = (book.recipe.light_bits() * inner).div_ceil(8);
                let more = rows.bytes().saturating_sub(light) + 2 * areas.len() + 36 * lobes.len();
                (light, more, book.size())
            }
        };
        Counted {
            leaves: self.leaves.len(),
            positions: size_of::<Vec3>() * self.positions.len(),
            light,
            more: more + 2 * self.radii.len(),
            tables,
        }
    }

    /// Calls `each` with the area and the lobes of every inner node of an exact tree.
    pub fn each_node(&self, mut each: impl FnMut(f32, &Exact)) {
        if let Stored::Exact(all) = &self.stored {
            all.iter().for_each(|lobes| each(lobes.area[0] * AREA_OF_FIRST, lobes));
        }
    }

    /// Root mean squares of the leaves' errors: position over the leaf's radius; colour over the
    /// brightest; normal; area, relative.
    pub fn leaf_errors(&self, records: &[Record]) -> [f64; 4] {
        let mut sums = [0.0; 4];
        self.each_leaf(|index, own| {
            let truth = &records[index];
            let radius = (truth.area / std::f32::consts::PI).sqrt();
            let colour = (0..3).map(|c| (own.radiance[0][c] - truth.radiance[0][c]).powi(2));
            let errors = [
                (own.position.distance(truth.position) / radius).powi(2),
                colour.sum::<f32>() / self.scale.brightest().powi(2),
                own.normal.distance_squared(truth.normal),
                (own.area / truth.area - 1.0).powi(2),
            ];
            sums.iter_mut().zip(errors).for_each(|(s, e)| *s += f64::from(e));
        });
        sums.map(|s| (s / self.count.max(1) as f64).sqrt())
    }

    /// Calls `each` with every leaf and its number.
    fn each_leaf(&self, mut each: impl FnMut(usize, Record)) {
        let mut open = vec![(0, 0, self.count)];
        while let Some((node, first, count)) = open.pop().filter(|(.., count)| *count > 1) {
            let (left, sphere) = (first_half(count), self.sphere(node));
            for (node, first, count) in
                [(node + left, first + left, count - left), (node + 1, first, left)]
            {
                match count {
                    1 => each(first, self.record(first, sphere)),
                    _ => open.push((node, first, count)),
                }
            }
        }
    }

    fn node(&self, index: usize) -> (Node, Decoded) {
        let decoded = match &self.stored {
            Stored::Exact(all) => Decoded { local_from_world: None, lobes: all[index] },
            Stored::Coded { book, rows, areas, lobes, top_area } => {
                let area = areas.get(index).map_or(0.0, |a| from_float16(*a, *top_area));
                let mut code = Vec::with_capacity(16);
                book.recipe.to_code(rows.read(index), &mut code);
                let mut decoded = book.decode(&code, (area, Vec3::ZERO, 0.0));
                if let Some(lobes) = lobes.get(index) {
                    decoded.lobes.area = *lobes;
                }
                decoded
            }
        };
        let area = (decoded.lobes.area[0] * AREA_OF_FIRST).max(0.0);
        (Node { mean: self.positions[index], area, ..Node::default() }, decoded)
    }

    fn sphere(&self, index: usize) -> (Vec3, f32) {
        (self.positions[index], from_float16(self.radii[index], self.scale.radius))
    }

    /// The surfel of a leaf whose parent is a sphere.
    fn record(&self, index: usize, parent: (Vec3, f32)) -> Record {
        let size = self.leaf.size();
        self.leaf.read(&self.leaves[index * size..(index + 1) * size], parent, &self.scale)
    }
}

/// Leaves of the first child of a node with so many.
fn first_half(count: usize) -> usize {
    count.div_ceil(2)
}

impl<'a> Room<'a> {
    /// The room of both children, behind the node's own place.
    fn children(&mut self, left: usize, leaf: usize) -> [Room<'_>; 2] {
        fn behind<T>(all: &mut [T], at: usize) -> (&mut [T], &mut [T]) {
            let all = if all.is_empty() { all } else { &mut all[1..] };
            let at = at.min(all.len());
            all.split_at_mut(at)
        }
        let (leaves, more_leaves) = self.leaves.split_at_mut(left * leaf);
        let (positions, more_positions) = behind(self.positions, left - 1);
        let (radii, more_radii) = behind(self.radii, left - 1);
        let (exact, more_exact) = behind(self.exact, left - 1);
        let (areas, more_areas) = behind(self.areas, left - 1);
        let (lobes, more_lobes) = behind(self.lobes, left - 1);
        [
            Room { leaves, positions, radii, exact, areas, lobes },
            Room {
                leaves: more_leaves,
                positions: more_positions,
                radii: more_radii,
                exact: more_exact,
                areas: more_areas,
                lobes: more_lobes,
            },
        ]
    }
}

impl Maker<'_> {
    /// Builds the subtree over a range of leaves, whose root is inner node `node`, while `held`
    /// lobes wait above.
    fn grow(
        &self,
        node: usize,
        range: std::ops::Range<usize>,
        mut room: Room,
        held: usize,
        pen: &mut Pen,
    ) -> Done {
        let left = first_half(range.len());
        let middle = range.start + left;
        let size = self.leaf.size();
        let [first, second] = room.children(left, size);
        let (before, after) = (range.start..middle, middle..range.end);
        let (l, r) = if range.len() > ALONE {
            rayon::join(
                || self.child(node + 1, before, first, held, &mut Pen::default()),
                || self.child(node + left, after, second, held + 1, &mut Pen::default()),
            )
        } else {
            let l = self.child(node + 1, before, first, held, pen);
            (l, self.child(node + left, after, second, held + 1, pen))
        };
        let mut done = joined(&l, &r);
        done.alive = l.alive.max(r.alive).max(held + 3);
        let radius = float16_above(done.radius, self.scale.radius);
        done.radius = from_float16(radius, self.scale.radius);
        room.positions[0] = done.position;
        room.radii[0] = radius;
        let sphere = (done.position, done.radius);
        if left == 1 {
            self.leaf.write(&self.records[range.start], sphere, &self.scale, room.leaves);
        }
        if range.len() - left == 1 {
            let rest = &mut room.leaves[left * size..];
            self.leaf.write(&self.records[middle], sphere, &self.scale, rest);
        }
        self.store(node, &done, &mut room, pen);
        done
    }

    fn child(
        &self,
        node: usize,
        range: std::ops::Range<usize>,
        room: Room,
        held: usize,
        pen: &mut Pen,
    ) -> Done {
        if range.len() > 1 {
            return self.grow(node, range, room, held, pen);
        }
        let record = &self.records[range.start];
        let mut lobes = Exact::default();
        lobes.add(record);
        Done { position: record.position, radius: 0.0, area: record.area, lobes, alive: held + 1 }
    }

    /// Stores a node's lobes: the sums themselves, or their code.
    fn store(&self, node: usize, done: &Done, room: &mut Room, pen: &mut Pen) {
        let Some((book, rows, top_area)) = self.book else {
            room.exact[0] = done.lobes;
            return;
        };
        if let Some(lobes) = room.lobes.first_mut() {
            *lobes = done.lobes.area;
        }
        let mut area = done.area;
        if let Some(stored) = room.areas.first_mut() {
            *stored = crate::bits::float16(done.area, top_area);
            area = from_float16(*stored, top_area);
        }
        let mut code = Vec::with_capacity(16);
        let lobes = Lobes { sums: &done.lobes, area, axis: Vec3::ZERO, both: 0.0 };
        book.encode(&lobes, &mut code, pen);
        rows.write(node, book.recipe.numbers(&code));
    }
}

/// A node over two.
fn joined(l: &Done, r: &Done) -> Done {
    let position = 0.5 * (l.position + r.position);
    let reach = |c: &Done| c.position.distance(position) + c.radius;
    Done {
        position,
        radius: reach(l).max(reach(r)),
        area: l.area + r.area,
        lobes: l.lobes.plus(&r.lobes),
        alive: 0,
    }
}

impl Hierarchy for Classic {
    fn cut(&self, chooser: &Chooser, splats: &mut Vec<Splat>) -> u64 {
        if self.count < 2 {
            let one = (self.count == 1).then(|| self.record(0, (self.positions[0], 0.0)));
            splats.extend(one.into_iter().flat_map(|r| chooser.surfel(&r)).flatten());
            return self.count as u64;
        }
        let mut visited = 0;
        // Inner nodes to visit with their first leaf and their leaves, the next one last.
        let mut open = vec![(0, 0, self.count)];
        while let Some((node, first, count)) = open.pop() {
            visited += 1;
            let (centre, radius) = self.sphere(node);
            match chooser.verdict(centre, radius) {
                Verdict::Leave => {}
                Verdict::Splat => {
                    let (node, lobes) = self.node(node);
                    // Nothing is known of its normals: it does not count as flat.
                    let splat =
                        |s: Sight| s.of_faces(node.area, |d| lobes.sent(d), &Faces::default());
                    splats.extend(chooser.sight(&node).and_then(splat));
                }
                Verdict::Open => {
                    let left = first_half(count);
                    let halves =
                        [(node + left, first + left, count - left), (node + 1, first, left)];
                    for (node, first, count) in halves {
                        if count > 1 {
                            open.push((node, first, count));
                        } else {
                            let record = self.record(first, (centre, radius));
                            splats.extend(chooser.surfel(&record).into_iter().flatten());
                        }
                    }
                }
            }
        }
        visited
    }

    /// None: a splat of it does not know its surfels.
    fn some(&self, _: Span, _: usize, _: &mut Vec<Surfel>) {}

    fn leaf_radius(&self) -> f32 {
        self.leaf_radius
    }

    fn is_empty(&self) -> bool {
        self.count == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::Recipe;
    use crate::packed::tests::sheet;
    use crate::packed::{Packed, records, sides};
    use chiaro_basis::Run;

    fn book(exact: &Classic, recipe: &Recipe) -> Book {
        let mut nodes = Vec::new();
        exact.each_node(|area, lobes| nodes.push((area, *lobes)));
        let lessons: Vec<Lobes> = nodes
            .iter()
            .step_by(3)
            .map(|(area, sums)| Lobes { sums, area: *area, axis: Vec3::ZERO, both: 0.0 })
            .collect();
        Book::train(&lessons, recipe, 1, &Run::default()).unwrap()
    }

    /// The light and the solid angle of a cut.
    fn light(tree: &dyn Hierarchy) -> [f32; 4] {
        let from = Vec3::new(0.5, 1.4, 0.5);
        let chooser =
            Chooser { from, threshold: 0.004, near: 0.1, mark: 0.1, above: None, flat: false };
        let mut splats = Vec::new();
        tree.cut(&chooser, &mut splats);
        splats.iter().fold([0.0; 4], |s, x| {
            let [r, g, b] = x.radiance.map(|c| c * x.solid_angle);
            [s[0] + r, s[1] + g, s[2] + b, s[3] + x.solid_angle]
        })
    }

    #[test]
    fn the_thesis_s_tree_sends_what_other_trees_send() {
        let all = sides(&records(&sheet(6000)));
        let truth = light(&Packed::build(&all));
        for leaf in [Leaf::A, Leaf::B] {
            let exact = Classic::exact(&all, leaf);
            let many = Classic::coded(&all, leaf, &book(&exact, &Recipe::clusters(1000)));
            for (tree, bound) in [(&exact, 0.06), (&many, 0.1)] {
                let own = light(tree);
                for i in 0..4 {
                    assert!((own[i] / truth[i] - 1.0).abs() < bound, "{own:?} {truth:?}");
                }
            }
        }
    }

    #[test]
    fn nodes_bound_and_sum_what_is_below_them_and_leaves_come_back() {
        let all = sides(&records(&sheet(777)));
        for leaf in [Leaf::A, Leaf::B] {
            let tree = Classic::exact(&all, leaf);
            let mut open = vec![(0usize, 0usize, all.len())];
            while let Some((node, first, count)) = open.pop() {
                let (centre, radius) = tree.sphere(node);
                let below = &all[first..first + count];
                assert!(
                    below.iter().all(|r| r.position.distance(centre) <= radius * 1.0001 + 1e-6)
                );
                let area: f32 = below.iter().map(|r| r.area).sum();
                assert!((tree.node(node).0.area / area - 1.0).abs() < 1e-3);
                let left = first_half(count);
                let halves = [(node + 1, first, left), (node + left, first + left, count - left)];
                for (node, first, count) in halves {
                    if count > 1 {
                        open.push((node, first, count));
                        continue;
                    }
                    let (a, b) = (&all[first], tree.record(first, (centre, radius)));
                    let step = if leaf == Leaf::A { 1e-6 } else { 0.06 * radius };
                    assert!(a.position.distance(b.position) <= step);
                    assert!(a.normal.distance(b.normal) < 1e-3);
                    assert!((a.area / b.area - 1.0).abs() < 1e-3);
                    let wrong = (0..3).map(|c| (a.radiance[0][c] - b.radiance[0][c]).abs());
                    assert!(wrong.fold(0.0, f32::max) < 2e-3);
                }
            }
        }
    }

    #[test]
    fn bytes_are_those_of_tables_6_1_and_6_2() {
        let all = sides(&records(&sheet(3000)));
        let exact = Classic::exact(&all, Leaf::A);
        let n = all.len();
        let words = Recipe::thesis(1000);
        for (leaf, bytes) in [(Leaf::A, 26), (Leaf::B, 16)] {
            let tree = Classic::coded(&all, leaf, &book(&exact, &words));
            let counted = tree.counted();
            assert_eq!(counted.leaves, bytes * n);
            assert_eq!(counted.positions, 12 * (n - 1));
            assert_eq!(counted.light, (10 * (n - 1)).div_ceil(8));
            // Radii, the area's lobes, and two words of slack.
            assert!(counted.more <= (2 + 36) * (n - 1) + 16);
        }
        assert_eq!(exact.counted().of_thesis(), 26 * n + (12 + 108) * (n - 1));
    }

    #[test]
    fn few_lobes_are_alive_and_threads_change_nothing() {
        let all = sides(&records(&sheet(20_000)));
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let exact = Classic::exact(&all, Leaf::B);
                let coded = Classic::coded(&all, Leaf::B, &book(&exact, &Recipe::thesis(64)));
                (coded.alive(), coded.leaves.clone(), light(&coded))
            })
        };
        let one = on(1);
        let levels = all.len().ilog2() as usize + 1;
        assert!(one.0 <= levels + 3, "{} {levels}", one.0);
        assert_eq!(one, on(3));
        assert!(Classic::exact(&[], Leaf::A).is_empty());
        let single = Classic::exact(&all[..1], Leaf::B);
        assert!((single.record(0, single_sphere(&single)).area / all[0].area - 1.0).abs() < 1e-3);
    }

    fn single_sphere(tree: &Classic) -> (Vec3, f32) {
        (tree.positions[0], 0.0)
    }
}
