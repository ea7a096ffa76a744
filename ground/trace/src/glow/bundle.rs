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
    /// Where each triangle stands among them.
    places: Vec<u32>,
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
    /// Its part of the order.
    members: Range<usize>,
    /// The second child, if it has any; the first follows its parent.
    second: Option<usize>,
}

impl Bundles {
    pub(super) fn new(triangles: &[GlowTriangle]) -> Self {
        let count = u32::try_from(triangles.len()).unwrap_or(u32::MAX);
        let order: Vec<u32> = (0..count).collect();
        let mut bundles = Self { places: order.clone(), order, nodes: Vec::new() };
        if count > 0 {
            bundles.add(triangles, 0..count as usize);
        }
        for (place, i) in (0..).zip(&bundles.order) {
            bundles.places[*i as usize] = place;
        }
        bundles
    }

    fn add(&mut self, triangles: &[GlowTriangle], range: Range<usize>) {
        let at = self.nodes.len();
        self.nodes.push(Node::over(triangles, &self.order, range.clone()));
        if range.len() <= FEW {
            return;
        }
        let half = range.start + range.len() / 2;
        halve(triangles, &mut self.order[range.clone()]);
        self.add(triangles, range.start..half);
        self.nodes[at].second = Some(self.nodes.len());
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
        while let Some(second) = self.nodes.get(at)?.second {
            let share = self.share([at + 1, second], from, normal)?;
            if number < share {
                (at, chosen, number) = (at + 1, chosen * share, number / share);
            } else {
                (at, chosen) = (second, chosen * (1.0 - share));
                number = (number - share) / (1.0 - share);
            }
            number = number.min(1.0 - f32::EPSILON);
        }
        Some((&self.order[self.nodes[at].members.clone()], chosen, number))
    }

    /// Those that [`Bundles::choose`] would choose a triangle with, and the probability that it does.
    pub(super) fn chance(&self, from: Vec3, normal: Vec3, triangle: usize) -> (&[u32], f32) {
        let place = self.places[triangle] as usize;
        let (mut at, mut chosen) = (0, 1.0);
        while let Some(second) = self.nodes[at].second {
            let share = self.share([at + 1, second], from, normal).unwrap_or(0.0);
            let is_first = place < self.nodes[second].members.start;
            chosen *= if is_first { share } else { 1.0 - share };
            at = if is_first { at + 1 } else { second };
        }
        (&self.order[self.nodes[at].members.clone()], chosen)
    }

    /// The first one's of what two nodes may give; `None` if that is nothing.
    fn share(&self, nodes: [usize; 2], from: Vec3, normal: Vec3) -> Option<f32> {
        let [a, b] = nodes.map(|k| self.nodes[k].at_most(from, normal));
        let share = a / (a + b);
        share.is_finite().then_some(share)
    }
}

impl Node {
    fn over(triangles: &[GlowTriangle], order: &[u32], members: Range<usize>) -> Self {
        let all = || order[members.clone()].iter().map(|i| &triangles[*i as usize]);
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
            members: members.clone(),
            second: None,
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
