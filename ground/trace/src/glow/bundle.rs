//! [`Bundles`]: a hierarchy over shining triangles, to find those that a place has its light from.
//!
//! A node bounds its triangles' places and directions; what it could give at most by power, distance and both cosines
//! chooses between two of them (Conty Estevez and Kulla 2018). Leaves are few triangles, told apart by what they are
//! seen to give. Where all are few there is one leaf.

use super::GlowTriangle;
use chiaro_basis::math::Vec3;
use chiaro_scene::Bounds;
use std::f32::consts::{FRAC_PI_2, PI};
use std::ops::Range;

/// Triangles of a leaf, at most.
pub(super) const FEW: usize = 16;

/// The hierarchy.
#[derive(Clone, Debug, Default)]
pub(super) struct Bundles {
    /// Indices of triangles, those of a leaf one after the other.
    order: Vec<u32>,
    /// Parents before children, the first the root.
    nodes: Vec<Node>,
}

#[derive(Clone, Debug)]
struct Node {
    middle: Vec3,
    radius: f32,
    /// Luminance times area of all sides that shine.
    power: f32,
    /// All normals lie within an angle of the axis.
    axis: Vec3,
    spread: f32,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    Leaf(Range<usize>),
    /// The second child; the first follows its parent.
    Inner(usize),
}

impl Bundles {
    pub(super) fn new(triangles: &[GlowTriangle]) -> Self {
        let count = u32::try_from(triangles.len()).unwrap_or(u32::MAX);
        let mut bundles = Self { order: (0..count).collect(), nodes: Vec::new() };
        if count > 0 {
            bundles.add(triangles, 0..count as usize);
        }
        bundles
    }

    fn add(&mut self, triangles: &[GlowTriangle], range: Range<usize>) {
        let at = self.nodes.len();
        let kind = Kind::Leaf(range.clone());
        self.nodes.push(Node::over(triangles, &self.order[range.clone()], kind));
        if range.len() <= FEW {
            return;
        }
        let half = range.start + range.len() / 2;
        halve(triangles, &mut self.order[range.clone()]);
        self.add(triangles, range.start..half);
        self.nodes[at].kind = Kind::Inner(self.nodes.len());
        self.add(triangles, half..range.end);
    }

    /// Whether all are told apart.
    #[cfg(test)]
    pub(super) fn is_one(&self) -> bool {
        self.nodes.len() <= 1
    }

    /// Triangles that may give most at a place on a surface with a normal, the probability that they are chosen, and
    /// the number in [0, 1) that chose them, stretched to [0, 1) again. `None` where nothing is seen.
    pub(super) fn choose(
        &self,
        from: Vec3,
        normal: Vec3,
        mut number: f32,
    ) -> Option<(&[u32], f32, f32)> {
        let (mut at, mut chosen) = (0, 1.0);
        loop {
            let second = match &self.nodes.get(at)?.kind {
                Kind::Leaf(range) => return Some((&self.order[range.clone()], chosen, number)),
                Kind::Inner(second) => *second,
            };
            let first = at + 1;
            let [a, b] = [first, second].map(|k| self.nodes[k].at_most(from, normal));
            let share = a / (a + b);
            if !share.is_finite() {
                return None;
            }
            if number < share {
                (at, chosen, number) = (first, chosen * share, number / share);
            } else {
                (at, chosen) = (second, chosen * (1.0 - share));
                number = (number - share) / (1.0 - share);
            }
            number = number.min(1.0 - f32::EPSILON);
        }
    }
}

impl Node {
    fn over(triangles: &[GlowTriangle], members: &[u32], kind: Kind) -> Self {
        let all = || members.iter().map(|i| &triangles[*i as usize]);
        let bounds = Bounds::of(all().flat_map(|t| t.corners));
        let weighed: Vec3 = all().map(|t| t.normal * t.area).sum();
        let axis = weighed.normalize_or(Vec3::Y);
        let angle = |t: &GlowTriangle| match t.two_sided {
            true => PI,
            false => axis.dot(t.normal).clamp(-1.0, 1.0).acos(),
        };
        Self {
            middle: 0.5 * (bounds.min + bounds.max),
            radius: bounds.radius(),
            power: all().map(|t| t.power() as f32).sum(),
            axis,
            spread: all().map(angle).fold(0.0, f32::max),
            kind,
        }
    }

    /// A bound of what it gives at a place on a surface with a normal, but for how near its parts may be.
    fn at_most(&self, from: Vec3, normal: Vec3) -> f32 {
        let (towards, distance) = (self.middle - from).normalize_and_length();
        let far = distance.max(self.radius).max(f32::MIN_POSITIVE);
        let power = self.power / (far * far);
        if distance <= self.radius {
            return power;
        }
        let size = (self.radius / distance).asin();
        let angle = |cosine: f32| cosine.clamp(-1.0, 1.0).acos();
        let here = angle(normal.dot(towards)) - size;
        let there = angle(-self.axis.dot(towards)) - self.spread - size;
        if here >= FRAC_PI_2 || there >= FRAC_PI_2 {
            return 0.0;
        }
        power * here.max(0.0).cos() * there.max(0.0).cos()
    }
}

/// Parts triangles at the median of their middles along the axis of largest extent.
fn halve(triangles: &[GlowTriangle], members: &mut [u32]) {
    let middle = |i: u32| triangles[i as usize].corners.iter().sum::<Vec3>();
    let low = members.iter().map(|i| middle(*i)).fold(Vec3::INFINITY, Vec3::min);
    let high = members.iter().map(|i| middle(*i)).fold(Vec3::NEG_INFINITY, Vec3::max);
    let axis = (high - low).max_position();
    let half = members.len() / 2;
    members.select_nth_unstable_by(half, |a, b| {
        middle(*a)[axis].total_cmp(&middle(*b)[axis]).then(a.cmp(b))
    });
}
