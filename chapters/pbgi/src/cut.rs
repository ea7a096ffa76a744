//! The cut through the tree that a receiver sees, as splats (thesis, 6.3.2, Rendering).
//!
//! A node whose bounding sphere looks smaller than a threshold is splatted from its mean; any other
//! is opened. Surfels nearer than the near field's radius are left out: rays look there. What a
//! splat sends and how large it looks come from the node's own lobes:
//! - radiance is light over area, the area not below a thousandth of the node's, both clamped at 0,
//!   since a short series is negative in places and positive straight behind a disc;
//! - flat nodes use the exact cosine and the two radiances of their front and back, solved from the
//!   series ahead and behind; between flat and not, both are blended, so that nothing flips.

use crate::harmonic::{basis, front_of_flat};
use crate::payload::{Payload, Sent};
use crate::surfel::Surfel;
use crate::tree::{Node, Tree};
use chiaro_basis::math::Vec3;

/// What a receiver sees of a node or a surfel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat {
    /// Unit vector from the receiver.
    pub direction: Vec3,
    /// Distance, scene units.
    pub distance: f32,
    /// Steradians that it covers.
    pub solid_angle: f32,
    /// Linear RGB.
    pub radiance: [f32; 3],
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

/// The least share of a node's area that its light is divided by.
const LEAST_AREA: f32 = 1e-3;
/// Lengths of a node's mean normal between which it turns from not flat to flat.
const FLAT: [f32; 2] = [0.985, 0.995];

impl Chooser {
    /// The splats of the cut, in the order of the tree; the number of nodes visited.
    pub fn cut<P: Payload>(&self, tree: &Tree<P>, splats: &mut Vec<Splat>) -> u64 {
        let mut visited = 0;
        let mut index = 0;
        while let Some(node) = tree.nodes.get(index) {
            visited += 1;
            match self.verdict(node.centre, node.radius) {
                Verdict::Leave => {
                    index += node.size as usize;
                    continue;
                }
                Verdict::Splat => {
                    let payload = &tree.payload[index];
                    let sent = |d: Vec3| payload.sent(&tree.book, &basis(d));
                    let both = |d: Vec3| payload.both(&tree.book, &basis(d));
                    splats.extend(self.node(node, sent, both));
                    index += node.size as usize;
                    continue;
                }
                Verdict::Open => {}
            }
            let (first, count) = (node.first as usize, node.count as usize);
            let surfels = &tree.surfels[first..first + count];
            splats.extend(surfels.iter().filter_map(|s| self.surfel(s)));
            index += 1;
        }
        visited
    }

    /// What to do with a node of this bounding sphere.
    pub(crate) fn verdict(&self, centre: Vec3, radius: f32) -> Verdict {
        let offset = centre - self.from;
        if self.above.is_some_and(|n| offset.dot(n) + radius < 0.0) {
            return Verdict::Leave;
        }
        let square = offset.length_squared();
        let small = std::f32::consts::PI * radius * radius <= self.threshold * square;
        let clear = square > (self.near + radius).powi(2);
        if small && clear { Verdict::Splat } else { Verdict::Open }
    }

    /// What is seen of a node that sends this in a direction, and in one and its opposite.
    pub(crate) fn node(
        &self,
        node: &Node,
        sent: impl Fn(Vec3) -> Sent,
        both: impl Fn(Vec3) -> [Sent; 2],
    ) -> Option<Splat> {
        let (direction, distance) = (node.mean - self.from).normalize_and_length();
        if self.above.is_some_and(|n| direction.dot(n) <= 0.0) {
            return None;
        }
        let length = node.axis.length();
        let flatness = if self.flat { smooth(FLAT, length) } else { 0.0 };
        let (mut area, mut radiance) = (0.0, [0.0; 3]);
        if flatness < 1.0 {
            let towards = sent(-direction);
            let least = LEAST_AREA * node.area;
            area = towards.area.max(0.0);
            radiance = towards.light.map(|l| l.max(0.0) / towards.area.max(least));
        }
        if flatness > 0.0 {
            let axis = node.axis / length;
            let cosine = -axis.dot(direction);
            let facing = if cosine > 0.0 { axis } else { -axis };
            let [ahead, behind] = both(facing);
            let own = front_of_flat(ahead.area, behind.area);
            let mix = |a: f32, b: f32| a + (b - a) * flatness;
            let flat = [0, 1, 2].map(|c| match own > 1e-6 * node.area {
                true => front_of_flat(ahead.light[c], behind.light[c]) / own,
                false => 0.0,
            });
            area = mix(area, own * cosine.abs());
            radiance = std::array::from_fn(|c| mix(radiance[c], flat[c]));
        }
        let solid_angle = area / (distance * distance);
        (solid_angle > 0.0).then_some(Splat { direction, distance, solid_angle, radiance })
    }

    /// What is seen of a surfel: its exact cosine, and nothing of a dead side.
    pub(crate) fn surfel(&self, surfel: &Surfel) -> Option<Splat> {
        let (direction, distance) = (surfel.position - self.from).normalize_and_length();
        if distance <= self.near || self.above.is_some_and(|n| direction.dot(n) <= 0.0) {
            return None;
        }
        let cosine = -surfel.normal.dot(direction);
        let side = usize::from(cosine < 0.0);
        let solid_angle = surfel.side_area(side) * cosine.abs() / (distance * distance);
        let radiance = surfel.radiance[side];
        (solid_angle > 0.0).then_some(Splat { direction, distance, solid_angle, radiance })
    }
}

fn smooth([low, high]: [f32; 2], x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
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
        let chooser = Chooser { from, threshold: 0.01, near: 0.0, above: None, flat };
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
        Chooser { from, threshold: 0.01, near, above: None, flat: true }.cut(&tree, &mut splats);
        assert!(!splats.is_empty() && splats.iter().all(|s| s.distance > near));
        splats.clear();
        let above = Some(Vec3::Z);
        Chooser { from, threshold: 0.01, near: 0.0, above, flat: true }.cut(&tree, &mut splats);
        assert!(splats.is_empty());
    }
}
