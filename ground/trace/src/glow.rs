//! [`Glow`]: the surfaces of a frame that shine.
//!
//! 1. Every triangle whose material emits is listed with its area and its mean radiance, textures
//!    averaged by their mip maps; triangles without area, and those that are black, are left out.
//! 2. Points are drawn on them with a density proportional to power: a cumulative distribution over
//!    the triangles, low-discrepancy points inside. For a place that has light from them they are drawn by what
//!    it sees: a hierarchy (`bundle`) finds few triangles, solid angles one of these and a point on it (`seen`).
//! 3. For noise-free light the points are gathered into a few clusters ([`Glow::clusters`]), each a
//!    small lamp with a cosine, and near by a few pieces: the same points whatever the pixel. Pixels that share
//!    the work look at quarters of these (`quarter`).
//!
//! Single-sided materials shine from their front alone, double-sided ones from both sides.

mod bundle;
mod lambert;
mod open;
mod quarter;
mod seen;
mod shell;
mod spot;

use crate::light::{Lamp, Patch, Shown};
use crate::surface::Surfaces;
use crate::tracer::{Hit, Ray, Sides, Tracer};
use bundle::Bundles;
use chiaro_basis::math::Vec3;
use chiaro_image::colour::luminance;
use chiaro_scene::LightKind;
use open::Open;
pub(crate) use quarter::QUARTERS;
use spot::{Spot, Textured};

/// The shining triangles of a frame.
#[derive(Clone, Debug, Default)]
pub struct Glow {
    triangles: Vec<GlowTriangle>,
    /// Power up to and including each triangle, relative to the whole.
    cumulative: Vec<f64>,
    /// Power in lumens per pi: radiance's luminance times area, both sides counted.
    power: f64,
    /// To find those that a place has its light from.
    bundles: Bundles,
    /// Points on textures, if any shine.
    texture_spots: Option<Textured>,
    /// What they give where nothing stands between, unless they are very many or textured.
    open: Option<Open>,
}

/// A shining triangle in world space.
#[derive(Clone, Copy, Debug)]
pub struct GlowTriangle {
    /// Its corners.
    pub corners: [Vec3; 3],
    /// Unit vector to the side that shines.
    pub normal: Vec3,
    /// In scene units squared.
    pub area: f32,
    /// Mean radiance, linear RGB.
    pub radiance: [f32; 3],
    /// Whether the back shines too.
    pub two_sided: bool,
    /// Whether a texture makes radiance differ from point to point.
    pub textured: bool,
    /// Index into [`chiaro_scene::Frame::objects`].
    pub object: u32,
    /// Index into the mesh's triangles.
    pub face: u32,
}

/// A point on a shining triangle.
#[derive(Clone, Copy, Debug)]
pub struct GlowPoint {
    /// World position.
    pub position: Vec3,
    /// Index of its triangle.
    pub triangle: usize,
    /// Barycentric coordinates of the second and the third vertex.
    pub b: [f32; 2],
    /// Probability density per area, 1 / scene units squared.
    pub density: f32,
}

/// Triangles whose light is known in closed form, at most.
const MANY: usize = 10_000;
/// Pieces of a cluster.
const PIECES: usize = 32;

/// A part of what shines: from afar a small lamp, near by its pieces.
#[derive(Clone, Debug)]
pub struct Cluster {
    /// The whole as one lamp.
    pub lamp: Lamp,
    /// Root mean square distance of its points from the lamp, scene units.
    pub radius: f32,
    /// The whole as many lamps.
    pub pieces: Vec<Lamp>,
    /// Whether all pieces face one way.
    pub is_flat: bool,
}

impl Cluster {
    /// How much of its light comes from the pieces at a point: all within two radii, nothing beyond
    /// four, where they make no difference.
    pub fn nearness(&self, point: Vec3) -> f32 {
        let d = (self.lamp.position - point).length();
        (2.0 - d / (2.0 * self.radius).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0)
    }

    /// The lamp as a point sees it: a bulb is seen at the piece that faces the point most, and shines with the
    /// mean cosine of all.
    pub fn seen_from(&self, point: Vec3) -> Lamp {
        if self.is_flat {
            return self.lamp;
        }
        let towards = (point - self.lamp.position).normalize_or(self.lamp.direction);
        let shown = |l: &Lamp| l.patch.map_or(0.0, |p| p.shown.at(l.direction.dot(towards)));
        let facing = |best: (f32, Vec3), l: &Lamp| {
            let c = shown(l);
            if c > best.0 { (c, l.position) } else { best }
        };
        let (_, position) = self.pieces.iter().fold((0.0, self.lamp.position), facing);
        let power: f32 = self.pieces.iter().map(|l| l.strength * shown(l)).sum();
        let direction = (point - position).normalize_or(towards);
        let patch = self.lamp.patch.map(|p| Patch { shown: Shown::FRONT, ..p });
        Lamp { position, direction, strength: power, patch, ..self.lamp }
    }
}

impl Glow {
    /// The shining triangles of a tracer's frame.
    pub fn of(tracer: &Tracer, surfaces: &Surfaces) -> Self {
        let mut triangles = Vec::new();
        for (index, object) in tracer.frame.objects.iter().enumerate() {
            let mesh = tracer.frame.shapes[object.shape].mesh_in(tracer.scene);
            let faces = mesh.materials.iter().enumerate();
            let shining = faces.filter(|(_, m)| tracer.scene.materials[m.index()].shines());
            triangles.extend(shining.filter_map(|(face, _)| {
                GlowTriangle::of(tracer, surfaces, index as u32, face as u32)
            }));
        }
        shell::leave_insides_out(&mut triangles, tracer);
        let glow = Self::from_triangles(triangles);
        Self { texture_spots: Textured::of(&glow, tracer, surfaces), ..glow }
    }

    fn from_triangles(triangles: Vec<GlowTriangle>) -> Self {
        let mut power = 0.0;
        let mut cumulative: Vec<f64> = triangles
            .iter()
            .map(|t| {
                power += t.power();
                power
            })
            .collect();
        cumulative.iter_mut().for_each(|c| *c /= power);
        let known = triangles.len() <= MANY && !triangles.iter().any(|t| t.textured);
        let open = known.then(|| Open::new(&triangles));
        let bundles = Bundles::new(&triangles);
        Self { triangles, cumulative, power, bundles, texture_spots: None, open }
    }

    /// The triangles.
    pub fn triangles(&self) -> &[GlowTriangle] {
        &self.triangles
    }

    /// Whether nothing shines.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Luminance times area over all triangles and shining sides: lumens over pi.
    pub fn power(&self) -> f64 {
        self.power
    }

    /// A point for three numbers in [0, 1): the first chooses the triangle, by power. `None` when
    /// nothing shines.
    pub fn point(&self, [choice, u, v]: [f32; 3]) -> Option<GlowPoint> {
        let last = self.triangles.len().checked_sub(1)?;
        let index = self.cumulative.partition_point(|c| *c <= f64::from(choice)).min(last);
        let t = &self.triangles[index];
        Some(t.at(index, seen::barycentric([u, v]), self.density(index)))
    }

    /// The density, per area, with which [`Glow::point`] finds points of a triangle.
    pub fn density(&self, triangle: usize) -> f32 {
        let t = &self.triangles[triangle];
        (t.power() / self.power) as f32 / t.area
    }

    /// Which of the triangles was hit.
    pub fn find(&self, hit: &Hit) -> Option<usize> {
        listed(&self.triangles, hit)
    }

    /// Whether nothing stands on the way to a lamp. What shines does not shade itself: few rays would tell a
    /// ring's near side from its far one by chance.
    pub fn is_free(&self, tracer: &Tracer, ray: &Ray, lamp: &Lamp) -> bool {
        !tracer.occluded(ray) || lamp.patch.is_some_and(|p| self.is_met(tracer, ray, p.object))
    }

    /// Whether a ray ends on a shining triangle of an object.
    fn is_met(&self, tracer: &Tracer, ray: &Ray, object: u32) -> bool {
        let hit = tracer.hit(ray, Sides::Both).filter(|hit| hit.object == object);
        hit.is_some_and(|hit| self.find(&hit).is_some())
    }

    /// At most `count` small lamps in the place of the whole, spread over it by power.
    pub fn lamps(&self, count: usize) -> Vec<Lamp> {
        self.clusters(count).into_iter().map(|c| c.lamp).collect()
    }

    /// The same lamps with their pieces.
    pub fn clusters(&self, count: usize) -> Vec<Cluster> {
        let (points, share) = self.spots(spot::MOST / QUARTERS);
        let of = |members: &Vec<usize>| self.cluster(&points, members, share);
        parted(&points, count).iter().map(of).collect()
    }

    fn cluster(&self, points: &[Spot], members: &[usize], share: f32) -> Cluster {
        let lamp = self.lamp(points, members, share);
        let square = |i: &usize| (points[*i].position - lamp.position).length_squared();
        let radius = (members.iter().map(square).sum::<f32>() / members.len() as f32).sqrt();
        let part = share * members.len() as f32 / PIECES as f32;
        let piece = |i: usize| self.lamp(points, &[members[i * members.len() / PIECES]], part);
        let pieces: Vec<Lamp> = (0..PIECES).map(piece).collect();
        let is_flat = pieces.iter().all(|p| p.direction.dot(lamp.direction) > 0.99);
        Cluster { lamp, radius, pieces, is_flat }
    }

    /// One lamp for a cluster of points: at the member nearest to their mean, with the cluster's power, mean
    /// colour and, where its triangles face one way, their direction.
    fn lamp(&self, points: &[Spot], members: &[usize], share: f32) -> Lamp {
        let count = members.len() as f32;
        let mean = members.iter().map(|&i| points[i].position).sum::<Vec3>() / count;
        let distance = |i: usize| (points[i].position - mean).length_squared();
        let middle = members.iter().copied().min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        let middle = &points[middle.expect("a cluster has members")];
        let t = &self.triangles[middle.triangle];
        let sum = members
            .iter()
            .fold([0.0f32; 3], |sum, &i| std::array::from_fn(|k| sum[k] + points[i].colour[k]));
        let normals = || members.iter().map(|&i| self.triangles[points[i].triangle].normal);
        let facing = match t.two_sided {
            true => t.normal,
            false => normals().sum::<Vec3>() / count,
        };
        let direction = facing.normalize_or(t.normal);
        let square = normals().map(|n| n.dot(direction).powi(2)).sum::<f32>() / count;
        let shown = match t.two_sided {
            true => Shown::of_both(square),
            false => Shown::of_normals(facing.length(), square),
        };
        // A two-sided patch shines with half of its power to each side.
        let power = share * count * if t.two_sided { 0.5 } else { 1.0 };
        let area = power / luminance(t.radiance);
        Lamp {
            position: middle.position,
            direction,
            kind: LightKind::Point,
            strength: power,
            colour: sum.map(|c| c / count),
            range: f32::INFINITY,
            patch: Some(Patch { area, shown, object: t.object }),
        }
    }
}

impl GlowTriangle {
    fn of(tracer: &Tracer, surfaces: &Surfaces, object: u32, face: u32) -> Option<Self> {
        let corners = tracer.corners(object, face);
        let [a, b, c] = corners;
        let cross = (b - a).cross(c - a);
        let area = 0.5 * cross.length();
        if !(area > 0.0 && area.is_finite()) {
            return None;
        }
        let hit = Hit { t: 0.0, object, face, b: [1.0 / 3.0; 2] };
        let radiance = surfaces.emission(tracer, &hit, area.sqrt());
        let material = &tracer.scene.materials[tracer.mesh(&hit).materials[face as usize].index()];
        let outward = if tracer.object(&hit).mirrored { -cross } else { cross };
        let triangle = Self {
            corners,
            normal: outward / (2.0 * area),
            area,
            radiance,
            two_sided: material.double_sided,
            textured: material.emissive_texture.is_some(),
            object,
            face,
        };
        let power = triangle.power();
        (power > 0.0 && power.is_finite()).then_some(triangle)
    }

    fn power(&self) -> f64 {
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        sides * f64::from(luminance(self.radiance)) * f64::from(self.area)
    }
}

/// Compact clusters of points, at most `count`, none of them empty.
fn parted(points: &[Spot], count: usize) -> Vec<Vec<usize>> {
    if count == 0 || points.is_empty() {
        return Vec::new();
    }
    let positions: Vec<Vec3> = points.iter().map(|p| p.position).collect();
    let mut parts = clusters(&positions, count);
    parts.retain(|members| !members.is_empty());
    parts
}

/// Which of some triangles, in the order of objects and faces, was hit.
fn listed(triangles: &[GlowTriangle], hit: &Hit) -> Option<usize> {
    triangles.binary_search_by_key(&(hit.object, hit.face), |t| (t.object, t.face)).ok()
}

/// The members of `count` compact clusters of points: farthest-point seeds, then a few of Lloyd's
/// iterations; ties go to the lower index.
fn clusters(points: &[Vec3], count: usize) -> Vec<Vec<usize>> {
    let mut centres = vec![points[0]];
    let mut nearest: Vec<f32> = points.iter().map(|p| (*p - points[0]).length_squared()).collect();
    while centres.len() < count {
        let far = (0..points.len()).fold(0, |b, i| if nearest[i] > nearest[b] { i } else { b });
        if nearest[far] == 0.0 {
            break;
        }
        centres.push(points[far]);
        for (d, p) in nearest.iter_mut().zip(points) {
            *d = d.min((*p - points[far]).length_squared());
        }
    }
    let mut members = Vec::new();
    for _ in 0..8 {
        members = vec![Vec::new(); centres.len()];
        for (i, p) in points.iter().enumerate() {
            let d = |k: &usize| (centres[*k] - *p).length_squared();
            let best = (0..centres.len()).min_by(|a, b| d(a).total_cmp(&d(b)));
            members[best.unwrap_or(0)].push(i);
        }
        for (centre, m) in centres.iter_mut().zip(&members) {
            if !m.is_empty() {
                *centre = m.iter().map(|&i| points[i]).sum::<Vec3>() / m.len() as f32;
            }
        }
    }
    members
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use chiaro_basis::math::vec3;
    use chiaro_basis::random;

    pub(crate) fn square(radiance: f32) -> Glow {
        let [a, b, c, d] = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]
            .map(|[x, z]: [f32; 2]| vec3(x, 0.0, z));
        let triangle = |corners: [Vec3; 3]| GlowTriangle {
            corners,
            normal: -Vec3::Y,
            area: 2.0,
            radiance: [radiance; 3],
            two_sided: false,
            textured: false,
            object: 0,
            face: 0,
        };
        Glow::from_triangles(vec![triangle([a, b, c]), triangle([a, c, d])])
    }

    /// The form factor of a square of side 2 seen from below its centre at distance h, by the
    /// closed form of a corner rectangle, four times.
    fn form_factor(h: f32) -> f32 {
        let x = 1.0 / h;
        let s = (1.0 + x * x).sqrt();
        4.0 / (2.0 * std::f32::consts::PI) * (2.0 * x / s * (x / s).atan())
    }

    #[test]
    fn few_lamps_give_the_square_s_illuminance() {
        for h in [0.7, 1.0, 3.0, 10.0] {
            let below = vec3(1.0, -h, 1.0);
            let sum: f32 = square(5.0)
                .lamps(16)
                .iter()
                .filter_map(|l| l.arrival(below))
                .map(|a| a.strength * a.towards.y)
                .sum();
            let exact = 5.0 * std::f32::consts::PI * form_factor(h);
            assert!((sum / exact - 1.0).abs() < 0.05, "{h}: {sum} {exact}");
        }
    }

    #[test]
    fn pieces_give_it_near_by() {
        let clusters = square(5.0).clusters(16);
        for h in [0.1, 0.2, 0.7] {
            let exact = 5.0 * std::f32::consts::PI * form_factor(h);
            let sum: f32 = (0..16)
                .map(|i| {
                    let [u, v] = random::r2(i);
                    let below = vec3(0.8 + 0.4 * u, -h, 0.8 + 0.4 * v);
                    let light =
                        |l: &Lamp| l.arrival(below).map_or(0.0, |a| a.strength * a.towards.y);
                    let of = |c: &Cluster| {
                        let near = c.nearness(below);
                        let pieces: f32 = c.pieces.iter().map(light).sum();
                        near * pieces + (1.0 - near) * light(&c.lamp)
                    };
                    clusters.iter().map(of).sum::<f32>() / 16.0
                })
                .sum();
            assert!((sum / exact - 1.0).abs() < 0.1, "{h}: {sum} {exact}");
        }
    }

    #[test]
    fn a_bulb_shines_all_around() {
        // A cube, one lamp in all: from afar it gives what its sides that are seen give.
        let side = |axis: usize, sign: f32| {
            let at = |u: f32, v: f32| {
                let mut p = [0.5 * sign; 3];
                (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (u - 0.5, v - 0.5);
                Vec3::from(p)
            };
            let mut normal = Vec3::ZERO;
            normal[axis] = sign;
            let [a, b, c, d] = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
            [[a, b, c], [a, c, d]].map(|corners| GlowTriangle {
                corners,
                normal,
                area: 0.5,
                radiance: [1.0; 3],
                two_sided: false,
                textured: false,
                object: 0,
                face: 0,
            })
        };
        let sides = (0..3).flat_map(|k| [side(k, 1.0), side(k, -1.0)]).flatten().collect();
        let clusters = Glow::from_triangles(sides).clusters(1);
        for w in [Vec3::X, -Vec3::Y, vec3(-0.6, 0.0, 0.8)] {
            let lamp = clusters[0].seen_from(100.0 * w);
            let strength = lamp.arrival(100.0 * w).unwrap().strength * 1e4;
            let exact = w.abs().element_sum();
            assert!((strength / exact - 1.0).abs() < 0.15, "{w}: {strength} {exact}");
        }
    }

    #[test]
    fn nothing_is_seen_from_behind_and_power_is_kept() {
        let lamps = square(5.0).lamps(16);
        assert_eq!(lamps.len(), 16);
        assert!(lamps.iter().all(|l| l.arrival(vec3(1.0, 1.0, 1.0)).is_none()));
        let power: f32 = lamps.iter().map(|l| l.strength).sum();
        assert!((power - 20.0).abs() < 1e-3, "{power}");
    }

    #[test]
    fn points_are_uniform_over_equal_triangles() {
        let glow = square(1.0);
        let n = 4096;
        let mean = (0..n)
            .map(|i| {
                let [u, v] = random::r2(i);
                let p = glow.point([(i as f32 + 0.5) / n as f32, u, v]).unwrap();
                assert!((p.density - 0.25).abs() < 1e-6);
                p.position
            })
            .sum::<Vec3>()
            / n as f32;
        assert!((mean - vec3(1.0, 0.0, 1.0)).length() < 0.01, "{mean}");
    }
}
