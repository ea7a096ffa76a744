//! The cut through the tree that a receiver sees, as splats (thesis, 6.3.2, Rendering).
//!
//! A node whose bounding sphere looks smaller than a threshold is splatted from its mean; any other
//! is opened. Surfels nearer than the near field's radius are left out: rays look there; where they are
//! to be marked, nodes in that shell that look small mark as a whole. What a splat sends and how large it looks come from the node's own lobes:
//! - radiance is light over area, the area not below a thousandth of the node's, both clamped at 0,
//!   since a short series is negative in places and positive straight behind a disc;
//! - flat nodes use the exact cosine and the two radiances of their front and back, solved from the
//!   series ahead and behind; between flat and not, both are blended, so that nothing flips.

use crate::harmonic::{basis, front_of_flat};
use crate::packed::{BLOCK, Places};
use crate::payload::{Exact, Payload, Sent};
use crate::surfel::Surfel;
use crate::tree::{Node, Tree};
use crate::wide::{LANES, NONE};
use chiaro_basis::math::Vec3;
use chiaro_basis::prefetch;
use std::f32::consts::FRAC_1_PI;

/// What a receiver sees of a node or a surfel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Splat {
    /// Unit vector from the receiver.
    pub direction: Vec3,
    /// Distance, scene units.
    pub distance: f32,
    /// Steradians that it covers.
    pub solid_angle: f32,
    /// Linear RGB.
    pub radiance: [f32; 3],
    /// The mean normal of the side that is seen; shorter than 1 where it is not flat.
    pub axis: Vec3,
    /// Whether it only marks where something nearer than the near field's radius is.
    pub marks: bool,
    /// The surfels that it stands for, or the most of them.
    pub span: Span,
}

/// Surfels that follow each other in a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// The first.
    pub first: u32,
    /// How many.
    pub count: u32,
}

/// How a cut is chosen.
#[derive(Clone, Copy, Debug)]
pub struct Chooser {
    /// The receiver.
    pub from: Vec3,
    /// Nodes whose sphere looks larger are opened, steradians.
    pub threshold: f32,
    /// Nothing nearer is splatted, scene units.
    pub near: f32,
    /// What is nearer than that but farther than this is marked, scene units.
    pub mark: f32,
    /// The tangent plane's normal; what lies under it is left out.
    pub above: Option<Vec3>,
    /// Whether flat nodes use the exact cosine.
    pub flat: bool,
}

/// What a cut does with a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Nothing of it is seen.
    Leave,
    /// It is splatted.
    Splat,
    /// What is below it is looked at.
    Open,
}

/// What of a cut is looked at when its memory has come.
#[derive(Clone, Copy, Debug)]
enum Chosen {
    /// A node that is splatted.
    Node(u32),
    /// A leaf whose surfels are.
    Surfels(u32),
}

/// So many at once.
const CHOSEN: usize = 64;

/// What a flat node sends to the side of its axis and to the other.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Faces {
    pub area: [f32; 2],
    pub radiance: [[f32; 3]; 2],
}

impl Faces {
    /// Those of a node, where it is at all flat.
    pub(crate) fn of_flat(node: &Node, payload: &Exact) -> Self {
        let length = node.axis.length();
        if length <= FLAT[0] {
            return Self::default();
        }
        let both = payload.both(&(), &basis(node.axis / length));
        let [front, back] = [0, 1].map(|side| face(node.area, &both, side));
        Self { area: [front.0, back.0], radiance: [front.1, back.1] }
    }
}

/// Area and radiance of a flat node's side, solved from what it sends along its axis and against it.
#[inline]
pub(crate) fn face(node_area: f32, both: &[Sent; 2], side: usize) -> (f32, [f32; 3]) {
    let (ahead, behind) = (&both[side], &both[1 - side]);
    let area = front_of_flat(ahead.area, behind.area);
    let light: [f32; 3] = std::array::from_fn(|c| front_of_flat(ahead.light[c], behind.light[c]));
    (area, if area > 1e-6 * node_area { light.map(|l| l / area) } else { [0.0; 3] })
}

/// The least share of a node's area that its light is divided by.
pub(crate) const LEAST_AREA: f32 = 1e-3;
/// Lengths of a node's mean normal between which it turns from not flat to flat.
pub(crate) const FLAT: [f32; 2] = [0.985, 0.995];

impl Chooser {
    /// The splats of the cut; the number of nodes visited.
    pub fn cut<P: Payload>(&self, tree: &Tree<P>, splats: &mut Vec<Splat>) -> u64 {
        let mut visited = 0;
        let mut chosen = Vec::with_capacity(CHOSEN + LANES);
        let mut groups: Vec<u32> = Vec::with_capacity(64);
        groups.extend((!tree.wide.is_empty()).then_some(0));
        while let Some(group) = groups.pop() {
            let wide = &tree.wide[group as usize];
            let verdicts = self.verdicts(&wide.centre, &wide.radius);
            let mut lane = 0;
            while lane < LANES && wide.node[lane] != NONE {
                visited += 1;
                let (index, within) = (wide.node[lane], wide.within[lane]);
                match verdicts[lane] {
                    Verdict::Leave => {}
                    Verdict::Splat => {
                        prefetch(&tree.nodes, index as usize);
                        prefetch(&tree.faces, index as usize);
                        chosen.push(Chosen::Node(index));
                    }
                    Verdict::Open if wide.below[lane] != NONE => {
                        prefetch(&tree.wide, wide.below[lane] as usize);
                        groups.push(wide.below[lane]);
                    }
                    Verdict::Open if within == 0 => {
                        prefetch(&tree.nodes, index as usize);
                        chosen.push(Chosen::Surfels(index));
                    }
                    Verdict::Open => {}
                }
                let skipped = if verdicts[lane] == Verdict::Open { 0 } else { within };
                lane += usize::from(skipped) + 1;
            }
            if chosen.len() >= CHOSEN {
                self.splat(tree, &mut chosen, splats);
            }
        }
        self.splat(tree, &mut chosen, splats);
        visited
    }

    /// Adds the splats of what was chosen, and forgets it.
    fn splat<P: Payload>(&self, tree: &Tree<P>, chosen: &mut Vec<Chosen>, splats: &mut Vec<Splat>) {
        let surfels = |index: u32| {
            let node = &tree.nodes[index as usize];
            node.first as usize..(node.first + node.count) as usize
        };
        for one in chosen.iter() {
            match *one {
                Chosen::Surfels(index) => {
                    surfels(index).for_each(|i| prefetch(&tree.surfels, i));
                }
                Chosen::Node(index) => {
                    let flat =
                        tree.nodes[index as usize].axis.length_squared() >= FLAT[1] * FLAT[1];
                    if !(flat && self.flat) {
                        prefetch(&tree.payload, index as usize);
                    }
                }
            }
        }
        for one in chosen.drain(..) {
            match one {
                Chosen::Node(index) => {
                    let index = index as usize;
                    let node = &tree.nodes[index];
                    let sent = |d: Vec3| tree.payload[index].sent(&tree.book, &basis(d));
                    if let Some(sight) = self.sight(node)
                        && let Some(splat) = sight.of_faces(node.area, sent, &tree.faces[index])
                    {
                        splats.push(Splat { span: tree.span(index), ..splat });
                    }
                }
                Chosen::Surfels(index) => {
                    for i in surfels(index) {
                        let span = Span { first: i as u32, count: 1 };
                        for part in self.surfel(&tree.surfels[i]).into_iter().flatten() {
                            splats.push(Splat { span, ..part });
                        }
                    }
                }
            }
        }
    }

    /// What to do with each node of a group: the same as [`verdict`](Self::verdict), all at once.
    #[allow(clippy::needless_range_loop, reason = "lanes are vectors of the processor")]
    pub(crate) fn verdicts(
        &self,
        [x, y, z]: &[[f32; LANES]; 3],
        radius: &[f32; LANES],
    ) -> [Verdict; LANES] {
        let (from, normal) = (self.from, self.above.unwrap_or(Vec3::ZERO));
        let (mut leave, mut splat) = ([0u32; LANES], [0u32; LANES]);
        let hidden = self.hidden();
        for k in 0..LANES {
            let (dx, dy, dz) = (x[k] - from.x, y[k] - from.y, z[k] - from.z);
            let r = radius[k];
            let below = dx * normal.x + dy * normal.y + dz * normal.z + r < 0.0;
            let square = dx * dx + dy * dy + dz * dz;
            let small = std::f32::consts::PI * r * r <= self.threshold * square;
            let [within, shell, clear] = self.parts(hidden, square, r);
            leave[k] = u32::from(below | within);
            splat[k] = u32::from(small & (clear | shell));
        }
        std::array::from_fn(|k| match (leave[k], splat[k]) {
            (1, _) => Verdict::Leave,
            (_, 1) => Verdict::Splat,
            _ => Verdict::Open,
        })
    }

    /// What to do with a node of this bounding sphere.
    pub(crate) fn verdict(&self, centre: Vec3, radius: f32) -> Verdict {
        let offset = centre - self.from;
        if self.above.is_some_and(|n| offset.dot(n) + radius < 0.0) {
            return Verdict::Leave;
        }
        let square = offset.length_squared();
        let small = std::f32::consts::PI * radius * radius <= self.threshold * square;
        match self.parts(self.hidden(), square, radius) {
            [true, ..] => Verdict::Leave,
            [_, shell, clear] if small && (shell || clear) => Verdict::Splat,
            _ => Verdict::Open,
        }
    }

    /// The radius within which nothing is splatted or marked.
    fn hidden(&self) -> f32 {
        self.near.min(self.mark)
    }

    /// Whether a sphere of a radius at a squared distance lies within that radius, between it and the near
    /// field's where that is marked, and beyond both.
    #[inline(always)]
    fn parts(&self, hidden: f32, square: f32, radius: f32) -> [bool; 3] {
        let (inner, outer) = (hidden + radius, self.near + radius);
        let (deep, wide) = (hidden - radius, self.near - radius);
        let within = (deep > 0.0) & (square <= deep * deep);
        let marked = (hidden > 0.0) & (wide > 0.0);
        [
            within,
            marked & (square > inner * inner) & (square <= wide * wide),
            square > outer * outer,
        ]
    }

    /// The records of which anything is seen, in a mask of bits.
    #[allow(clippy::needless_range_loop, reason = "lanes are vectors of the processor")]
    pub(crate) fn seen_of(&self, places: &Places) -> u32 {
        let from = self.from;
        let near = self.hidden().powi(2);
        let (Places { position: [x, y, z], normal: [nx, ny, nz], both }, up) = (places, self.above);
        let up = up.unwrap_or(Vec3::ZERO);
        let least = if self.above.is_some() { 0.0 } else { -1.0 };
        let (mut seen, mut faces) = ([0u32; BLOCK], [0u32; BLOCK]);
        for k in 0..BLOCK {
            let (dx, dy, dz) = (x[k] - from.x, y[k] - from.y, z[k] - from.z);
            let front = dx * nx[k] + dy * ny[k] + dz * nz[k] < 0.0;
            let far = dx * dx + dy * dy + dz * dz > near;
            let above = dx * up.x + dy * up.y + dz * up.z > least;
            seen[k] = u32::from(far & above) << k;
            faces[k] = u32::from(front) << k;
        }
        let mask = |bits: &[u32; BLOCK]| bits.iter().fold(0, |mask, bit| mask | bit);
        mask(&seen) & (mask(&faces) | both)
    }

    /// What is seen of a surfel by its exact cosine, and nothing of a dead side: the part of its disc beyond the near
    /// field, and the part that marks.
    pub(crate) fn surfel(&self, surfel: &Surfel) -> [Option<Splat>; 2] {
        let (direction, distance) = (surfel.position - self.from).normalize_and_length();
        if distance <= self.hidden() || self.above.is_some_and(|n| direction.dot(n) <= 0.0) {
            return [None; 2];
        }
        let cosine = -surfel.normal.dot(direction);
        let side = usize::from(cosine < 0.0);
        let solid_angle = surfel.side_area(side) * cosine.abs() / (distance * distance);
        let radiance = surfel.radiance[side];
        let axis = if side == 0 { surfel.normal } else { -surfel.normal };
        let far = self.beyond(distance, surfel.area, cosine);
        [(far, false), (1.0 - far, true)].map(|(share, marks)| {
            let solid_angle = share * solid_angle;
            let span = Span::default();
            let splat = Splat { direction, distance, solid_angle, radiance, axis, marks, span };
            (solid_angle > 0.0).then_some(splat)
        })
    }

    /// The share of a disc of an area beyond the near field's sphere, which it crosses on its slant: so
    /// that nothing flips where a surfel moves a little.
    fn beyond(&self, distance: f32, area: f32, cosine: f32) -> f32 {
        let half = (area * (1.0 - cosine * cosine).max(0.0) * FRAC_1_PI).sqrt();
        let past = distance - self.near;
        if past.abs() >= half { f32::from(past > 0.0) } else { 0.5 + 0.5 * past / half }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(alive: [bool; 2]) -> Vec<Surfel> {
        (0..32 * 32)
            .map(|i| Surfel {
                position: Vec3::new((i % 32) as f32 / 32.0, (i / 32) as f32 / 32.0, 0.0),
                normal: Vec3::Z,
                area: 1.0 / 1024.0,
                alive,
                albedo: [1.0; 3],
                radiance: [[1.0, 2.0, 3.0], [5.0; 3]],
            })
            .collect()
    }

    fn seen(from: Vec3, alive: [bool; 2], flat: bool) -> (f32, [f32; 3]) {
        let tree = Tree::build(&wall(alive));
        let chooser = Chooser { from, threshold: 0.01, near: 0.0, mark: 0.0, above: None, flat };
        let mut splats = Vec::new();
        chooser.cut(&tree, &mut splats);
        let omega = splats.iter().map(|s| s.solid_angle).sum();
        let light = [0, 1, 2].map(|c| splats.iter().map(|s| s.solid_angle * s.radiance[c]).sum());
        (omega, light)
    }

    #[test]
    fn a_wall_is_seen_in_its_solid_angle_from_both_sides() {
        for (z, radiance) in [(3.0, [1.0, 2.0, 3.0]), (-3.0, [5.0; 3])] {
            let from = Vec3::new(1.5, 0.5, z);
            let exact: f32 = wall([true; 2])
                .iter()
                .map(|s| {
                    let d = from - s.position;
                    s.area * d.normalize().z.abs() / d.length_squared()
                })
                .sum();
            let (omega, light) = seen(from, [true; 2], true);
            assert!((omega / exact - 1.0).abs() < 0.01, "{omega} {exact}");
            for c in 0..3 {
                assert!((light[c] / (omega * radiance[c]) - 1.0).abs() < 0.01);
            }
        }
    }

    #[test]
    fn eight_nodes_at_once_are_judged_as_each_by_itself() {
        let tree = Tree::build(&wall([true; 2]));
        let from = Vec3::new(0.3, 0.4, 0.05);
        let chooser = Chooser {
            from,
            threshold: 0.01,
            near: 0.2,
            mark: 0.1,
            above: Some(Vec3::new(0.8, 0.0, -0.6)),
            flat: true,
        };
        let (mut fast, mut slow) = (Vec::new(), Vec::new());
        chooser.cut(&tree, &mut fast);
        let mut index = 0;
        while let Some(node) = tree.nodes.get(index) {
            let verdict = chooser.verdict(node.centre, node.radius);
            index += if verdict == Verdict::Open { 1 } else { node.size as usize };
            match verdict {
                Verdict::Leave => {}
                Verdict::Splat => {
                    let payload = &tree.payload[index - node.size as usize];
                    let sent = |d: Vec3| payload.sent(&(), &basis(d));
                    let faces = Faces::of_flat(node, payload);
                    let sight = chooser.sight(node);
                    slow.extend(sight.and_then(|s| s.of_faces(node.area, sent, &faces)));
                }
                Verdict::Open => {
                    let range = node.first as usize..(node.first + node.count) as usize;
                    slow.extend(
                        tree.surfels[range].iter().flat_map(|s| chooser.surfel(s)).flatten(),
                    );
                }
            }
        }
        let sorted = |mut splats: Vec<Splat>| {
            splats.sort_by(|a, b| {
                let key = |s: &Splat| [s.distance, s.direction.x, s.direction.y];
                key(a).partial_cmp(&key(b)).unwrap()
            });
            splats.iter_mut().for_each(|s| s.span = Span::default());
            splats
        };
        assert!(fast.iter().any(|s| s.marks) && fast.iter().any(|s| !s.marks));
        assert_eq!(sorted(fast), sorted(slow));
    }

    #[test]
    fn a_near_field_full_of_surfels_is_marked_by_few_nodes() {
        let tree = Tree::build(&wall([true; 2]));
        let from = Vec3::new(0.5, 0.5, 0.3);
        let marked = |mark: f32| {
            let chooser =
                Chooser { from, threshold: 0.05, near: 1.0, mark, above: None, flat: true };
            let mut splats = Vec::new();
            chooser.cut(&tree, &mut splats);
            assert!(splats.iter().all(|s| s.marks));
            (splats.len(), splats.iter().map(|s| s.solid_angle).sum::<f32>())
        };
        let ((few, omega), (all, exact)) = (marked(0.01), marked(0.0));
        assert!(all == 1024 && few < all / 2, "{few} {all}");
        assert!((omega / exact - 1.0).abs() < 0.01, "{omega} {exact}");
        assert_eq!(marked(1.0).0, 0);
    }

    #[test]
    fn a_surfel_comes_out_of_the_near_field_by_and_by() {
        let normal = Vec3::new(0.6, 0.0, 0.8);
        let chooser = |near: f32| {
            let (from, threshold, mark) = (Vec3::ZERO, 0.01, 0.5 * near);
            Chooser { from, threshold, near, mark, above: None, flat: true }
        };
        let surfel = Surfel {
            position: Vec3::Z,
            normal,
            area: 0.03,
            alive: [true; 2],
            albedo: [0.5; 3],
            radiance: [[1.0; 3]; 2],
        };
        let omega = |near: f32| {
            chooser(near).surfel(&surfel).map(|s| s.map_or(0.0, |splat| splat.solid_angle))
        };
        let all = omega(0.0)[0];
        let reach = 0.6 * (surfel.area * FRAC_1_PI).sqrt();
        assert_eq!(
            (omega(1.0 - 1.01 * reach), omega(1.0 + 1.01 * reach)),
            ([all, 0.0], [0.0, all])
        );
        for k in 0..200 {
            let near = 0.9 + 1e-3 * k as f32;
            let [[far, marks], [then, _]] = [omega(near), omega(near + 1e-3)];
            assert!((far + marks - all).abs() < 1e-6 && (0.0..0.02 * all).contains(&(far - then)));
        }
    }

    #[test]
    fn nothing_is_seen_of_a_dead_side() {
        let (omega, _) = seen(Vec3::new(0.5, 0.5, -3.0), [true, false], true);
        assert!(omega < 1e-4, "{omega}");
    }

    #[test]
    fn the_near_field_and_what_lies_under_the_plane_are_left_out() {
        let tree = Tree::build(&wall([true; 2]));
        let from = Vec3::new(0.5, 0.5, 0.1);
        let mut splats = Vec::new();
        let near = 0.3;
        Chooser { from, threshold: 0.01, near, mark: near, above: None, flat: true }
            .cut(&tree, &mut splats);
        assert!(!splats.is_empty() && splats.iter().all(|s| s.distance > near));
        splats.clear();
        let above = Some(Vec3::Z);
        Chooser { from, threshold: 0.01, near: 0.0, mark: 0.0, above, flat: true }
            .cut(&tree, &mut splats);
        assert!(splats.is_empty());
    }
}
