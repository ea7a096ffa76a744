//! [`Open`]: irradiance from many shining triangles where nothing stands between.
//!
//! A tree of balls over the triangles: near ones, and those that cross the horizon, give what they do in closed form
//! (`lambert`); what looks small is seen from its middle, each triangle by its own cosine.

use super::GlowTriangle;
use chiaro_basis::math::Vec3;
use chiaro_scene::Bounds;

/// Triangles of a leaf, at most.
const LEAF: usize = 4;
/// Radii of a ball from which on it is seen from its middle.
const FAR: f32 = 12.0;

/// A tree over shining triangles.
#[derive(Clone, Debug, Default)]
pub(super) struct Open {
    nodes: Vec<Node>,
    /// Triangles in the order of the leaves, and what is seen of them from afar.
    triangles: Vec<GlowTriangle>,
    facets: Vec<Facet>,
}

#[derive(Clone, Debug)]
struct Node {
    centre: Vec3,
    radius: f32,
    first: usize,
    count: usize,
    /// Nodes of its subtree; 1 for a leaf.
    size: usize,
}

/// A triangle from afar: the side that shines, the share of the other one, and radiance times area.
#[derive(Clone, Copy, Debug)]
struct Facet {
    normal: Vec3,
    back: f32,
    power: [f32; 3],
}

impl Open {
    pub(super) fn new(triangles: &[GlowTriangle]) -> Self {
        let mut open = Self { triangles: triangles.to_vec(), ..Self::default() };
        if !triangles.is_empty() {
            open.grow(0, triangles.len());
        }
        let facet = |t: &GlowTriangle| Facet {
            normal: t.normal,
            back: if t.two_sided { 1.0 } else { 0.0 },
            power: t.radiance.map(|r| r * t.area),
        };
        open.facets = open.triangles.iter().map(facet).collect();
        open
    }

    /// Adds the nodes over some triangles, parted at the middle of their longest extent.
    fn grow(&mut self, first: usize, count: usize) {
        let some = &mut self.triangles[first..first + count];
        let bounds = Bounds::of(some.iter().flat_map(|t| t.corners));
        let area: f32 = some.iter().map(|t| t.area).sum();
        let centre = some.iter().map(|t| middle(t) * (t.area / area)).sum::<Vec3>();
        let far = some.iter().flat_map(|t| t.corners).map(|p| p.distance(centre));
        let radius = far.fold(0.0, f32::max);
        let index = self.nodes.len();
        if count > LEAF {
            let axis = (bounds.max - bounds.min).max_position();
            some.sort_by(|a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
        }
        self.nodes.push(Node { centre, radius, first, count, size: 1 });
        if count > LEAF {
            self.grow(first, count / 2);
            self.grow(first + count / 2, count - count / 2);
            self.nodes[index].size = self.nodes.len() - index;
        }
    }

    /// Irradiance of a place that faces `normal`, linear RGB.
    pub(super) fn irradiance(&self, from: Vec3, normal: Vec3) -> [f32; 3] {
        let mut sum = [0.0f32; 3];
        let mut add = |e: [f32; 3]| (0..3).for_each(|i| sum[i] += e[i]);
        let mut index = 0;
        while let Some(node) = self.nodes.get(index) {
            let offset = node.centre - from;
            let (distance, height) = (offset.length(), offset.dot(normal));
            let range = node.first..node.first + node.count;
            if height < -node.radius {
                index += node.size;
            } else if height > node.radius && distance > FAR * node.radius {
                let scale = height / (distance * distance * distance);
                add(seen(&self.facets[range], -offset / distance).map(|p| scale * p));
                index += node.size;
            } else {
                if node.size == 1 {
                    for t in &self.triangles[range] {
                        let e = t.form(from, normal);
                        add(t.radiance.map(|r| r * e));
                    }
                }
                index += 1;
            }
        }
        sum
    }
}

fn middle(t: &GlowTriangle) -> Vec3 {
    (t.corners[0] + t.corners[1] + t.corners[2]) / 3.0
}

/// Radiance times the area that triangles show in a direction.
fn seen(facets: &[Facet], towards: Vec3) -> [f32; 3] {
    facets.iter().fold([0.0; 3], |sum, f| {
        let cosine = f.normal.dot(towards);
        let shown = cosine.max(-f.back * cosine);
        std::array::from_fn(|i| sum[i] + shown.max(0.0) * f.power[i])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::{math::vec3, random};
    use std::f32::consts::{PI, TAU};

    /// A ball of triangles about the origin.
    fn ball(rings: usize, radius: f32) -> Vec<GlowTriangle> {
        let at = |i: usize, j: usize| {
            let (a, b) = (PI * i as f32 / rings as f32, TAU * j as f32 / rings as f32);
            radius * vec3(a.sin() * b.cos(), a.cos(), a.sin() * b.sin())
        };
        let mut all = Vec::new();
        for (i, j) in (0..rings).flat_map(|i| (0..rings).map(move |j| (i, j))) {
            let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            for corners in [[p, q, r], [p, r, s]] {
                let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                let outward = cross * cross.dot(corners[0] + corners[1] + corners[2]).signum();
                if cross.length() > 1e-9 {
                    all.push(GlowTriangle {
                        corners,
                        normal: outward.normalize(),
                        area: 0.5 * cross.length(),
                        radiance: [1.0, 2.0, 0.0],
                        two_sided: false,
                        textured: false,
                        object: 0,
                        face: all.len() as u32,
                    });
                }
            }
        }
        all
    }

    /// Light of a ball falls off as a point's does.
    #[test]
    fn a_ball_lights_as_a_point_does() {
        let open = Open::new(&ball(48, 0.5));
        for (i, distance) in [0.8f32, 1.5, 2.9, 3.1, 8.0].into_iter().enumerate() {
            let [u, v] = random::r2(i as u64);
            let (z, a) = (2.0 * u - 1.0, TAU * v);
            let way = vec3((1.0 - z * z).sqrt() * a.cos(), (1.0 - z * z).sqrt() * a.sin(), z);
            let e = open.irradiance(way * distance, -way);
            let exact = PI * (0.5 / distance).powi(2);
            assert!((e[0] / exact - 1.0).abs() < 0.01, "{distance}: {} {exact}", e[0]);
            assert!((e[1] - 2.0 * e[0]).abs() < 1e-4 * e[1] && e[2] == 0.0);
        }
    }

    /// Wherever a place lies, and whichever way it faces, the tree says what all triangles one by one do.
    #[test]
    fn it_is_what_all_triangles_give_in_closed_form() {
        let triangles = ball(24, 0.5);
        let open = Open::new(&triangles);
        for i in 0..200 {
            let [u, v] = random::r2(i);
            let place = vec3(3.0 * u - 1.5, 0.6 + 2.0 * v, 4.0 * random::r2(i + 500)[0] - 2.0);
            let turned = vec3(v - 0.5, -u, 0.3 - v).normalize();
            let one_by_one: f32 = triangles.iter().map(|t| t.form(place, turned)).sum();
            let e = open.irradiance(place, turned)[0];
            assert!((e - one_by_one).abs() < 0.01 * one_by_one + 1e-4, "{place}: {e} {one_by_one}");
        }
    }
}
