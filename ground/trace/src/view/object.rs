//! The three-quarter view: azimuth 30, elevation 15 degrees, in a picture 28 degrees high that the
//! shape fills but for a margin.
//!
//! A ground that reaches far beyond what stands on it is left out of the framing: it runs out of
//! the picture, and what stands on it is seen large.

use chiaro_basis::math::{Quat, Vec3};
use chiaro_scene::{Bounds, Frame, Pose, Projection};
use rayon::prelude::*;
use std::f32::consts::TAU;

/// The share of the picture's height or width that the shape fills.
const FILL: f32 = 0.92;

/// Views of what is turned; between two of them a point sways by less than the margin.
const TURNS: usize = 24;

/// Points that frame as the whole shape does, over the shot.
pub(super) struct Outline {
    points: Vec<Vec3>,
}

impl Outline {
    pub(super) fn of(frames: &[Frame]) -> Self {
        let ground = grounds(&frames[0]);
        Self { points: frames.iter().flat_map(|f| extremes(f, &ground)).collect() }
    }

    pub(super) fn bounds(&self) -> Bounds {
        Bounds::of(self.points.iter().copied())
    }

    /// The points as they are passed on the way round the vertical through their middle.
    pub(super) fn turned(&self) -> Self {
        let centre = self.bounds().centre();
        let turn = |k: usize| Quat::from_rotation_y(TAU * k as f32 / TURNS as f32);
        let all = |k| self.points.iter().map(move |p| centre + turn(k) * (*p - centre));
        Self { points: (0..TURNS).flat_map(all).collect() }
    }

    /// Width over height of the shape in the view, between 3:4 and 4:3.
    pub(super) fn aspect(&self, orbit: f32) -> f32 {
        let pose = three_quarter(self.bounds().centre(), 1.0, orbit);
        let extent = Bounds::of(self.points.iter().map(|p| pose.view(*p)));
        let size = extent.max - extent.min;
        (size.x / size.y.max(f32::MIN_POSITIVE)).clamp(0.75, 4.0 / 3.0)
    }

    /// The three-quarter view in which the points fill the picture but for a margin.
    pub(super) fn view(&self, aspect: f32, orbit: f32) -> Pose {
        let centre = self.bounds().centre();
        let mut pose = three_quarter(centre, 1.0, orbit);
        let Projection::Perspective { fov_y } = pose.projection else { return pose };
        let ty = (0.5 * fov_y).tan() * FILL;
        let tx = ty * aspect;
        // Each side plane of the frustum touches the points: the two distances to them per axis
        // meet in the camera's position, and the farther of the two axes decides.
        let flat: Vec<Vec3> = self.points.iter().map(|p| pose.view(*p)).collect();
        let most = |f: &dyn Fn(&Vec3) -> f32| flat.iter().map(f).fold(f32::NEG_INFINITY, f32::max);
        let (right, left) = (most(&|v| v.x - tx * v.z), most(&|v| -v.x - tx * v.z));
        let (top, bottom) = (most(&|v| v.y - ty * v.z), most(&|v| -v.y - ty * v.z));
        let back = ((right + left) / (2.0 * tx)).max((top + bottom) / (2.0 * ty));
        let shift = pose.right * (0.5 * (right - left)) + pose.up * (0.5 * (top - bottom));
        pose.position += shift - pose.forward * back;
        if !pose.position.is_finite() {
            pose.position = centre - pose.forward;
        }
        pose
    }
}

fn three_quarter(target: Vec3, distance: f32, orbit: f32) -> Pose {
    let turn = Quat::from_rotation_y((30.0 + orbit).to_radians())
        * Quat::from_rotation_x(-15f32.to_radians());
    let from = target + turn * Vec3::Z * distance;
    Pose::look_at(from, target, Vec3::Y, Projection::Perspective { fov_y: 28f32.to_radians() })
}

/// Which objects are a ground: flat and level, under everything else, and reaching over more than
/// four times the area of the rest.
fn grounds(frame: &Frame) -> Vec<bool> {
    let boxes: Vec<Bounds> =
        frame.objects.par_iter().map(|o| Bounds::of(frame.world_positions(o))).collect();
    let is_level = |b: &Bounds| {
        let size = b.max - b.min;
        size.y <= 0.02 * size.x.min(size.z)
    };
    let level: Vec<bool> = boxes.iter().map(is_level).collect();
    let rest = boxes.iter().zip(&level).filter(|(_, l)| !**l).map(|(b, _)| *b);
    let rest = Bounds::of(rest.flat_map(|b| [b.min, b.max]));
    if rest.is_empty() {
        return vec![false; boxes.len()];
    }
    let area = |b: &Bounds| (b.max.x - b.min.x) * (b.max.z - b.min.z);
    let height = rest.max.y - rest.min.y;
    let is_under = |b: &Bounds| b.max.y < rest.min.y + 0.1 * height;
    let pairs = boxes.iter().zip(&level);
    pairs.map(|(b, l)| *l && is_under(b) && area(b) > 4.0 * area(&rest)).collect()
}

/// The vertices farthest in evenly spread directions, of all objects but the grounds. What they
/// leave out of a view is under a hundredth of its size.
fn extremes(frame: &Frame, ground: &[bool]) -> Vec<Vec3> {
    const FEW: usize = 2000;
    const NEAR_BY: usize = 32;
    let objects = || frame.objects.iter().zip(ground).filter(|(_, g)| !**g).map(|(o, _)| o);
    let count: usize = objects().map(|o| frame.shapes[o.shape].positions.len()).sum();
    let points: Vec<Vec3> =
        objects().flat_map(|o| frame.world_positions(o)).filter(|p| p.is_finite()).collect();
    if count <= FEW {
        return points;
    }
    let axes = [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|a| [a, -a]);
    let directions: Vec<Vec3> = axes.chain(super::room::sphere(320)).collect();
    let near_by: Vec<(Bounds, &[Vec3])> =
        points.chunks(NEAR_BY).map(|p| (Bounds::of(p.iter().copied()), p)).collect();
    let farthest = |d: &Vec3| {
        let mut best = (f32::NEG_INFINITY, Vec3::ZERO);
        for (bounds, points) in &near_by {
            // No point of a box is farther than this, rounded as theirs are.
            if (bounds.min * *d).max(bounds.max * *d).dot(Vec3::ONE) > best.0 {
                best = points.iter().fold(best, |best, p| {
                    let reach = p.dot(*d);
                    if reach > best.0 { (reach, *p) } else { best }
                });
            }
        }
        best
    };
    let found: Vec<(f32, Vec3)> = directions.par_iter().map(farthest).collect();
    found.into_iter().filter(|(reach, _)| reach.is_finite()).map(|(_, p)| p).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_scene::{
        Material, MaterialId, Mesh, MeshId, Node, NormalSource, Playback, Poser, Scene, Transform,
    };

    /// A slab between two corners.
    fn slab(min: Vec3, max: Vec3) -> Mesh {
        let corner = |i: usize| {
            let pick = |k: usize| if i >> k & 1 == 0 { min[k] } else { max[k] };
            Vec3::new(pick(0), pick(1), pick(2))
        };
        let triangles = vec![[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7]];
        Mesh {
            positions: (0..8).map(corner).collect(),
            normals: NormalSource::Given(vec![Vec3::Y; 8]),
            materials: vec![MaterialId::new(0); triangles.len()],
            triangles,
            ..Mesh::default()
        }
    }

    fn frame_of(meshes: Vec<Mesh>) -> Frame {
        let nodes = (0..meshes.len()).map(|i| Node {
            transform: Transform::default(),
            mesh: Some(MeshId::new(i)),
            ..Node::default()
        });
        let scene = Scene {
            nodes: nodes.collect(),
            meshes,
            materials: vec![Material::default()],
            ..Scene::default()
        };
        Poser::new(&scene).frame(0.0, &Playback::default())
    }

    #[test]
    fn of_many_points_the_farthest_are_found() {
        let ball = super::super::room::sphere(3000).enumerate();
        let positions: Vec<Vec3> =
            ball.map(|(i, p)| p * (1.0 + 0.1 * (i as f32).sin()) + Vec3::Y).collect();
        let triangles = (0..1000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect::<Vec<_>>();
        let mesh = Mesh {
            normals: NormalSource::Given(vec![Vec3::Y; positions.len()]),
            materials: vec![MaterialId::new(0); triangles.len()],
            positions: positions.clone(),
            triangles,
            ..Mesh::default()
        };
        let found = extremes(&frame_of(vec![mesh]), &[false]);
        let axes = [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|a| [a, -a]);
        for (d, found) in axes.chain(super::super::room::sphere(320)).zip(found) {
            let most = positions.iter().map(|p| p.dot(d)).fold(f32::NEG_INFINITY, f32::max);
            assert_eq!(found.dot(d), most, "{d}");
        }
    }

    #[test]
    fn the_shape_fills_the_picture_but_for_a_margin() {
        let frame = frame_of(vec![slab(Vec3::new(-3.0, 0.0, 1.0), Vec3::new(5.0, 1.0, 2.0))]);
        let outline = Outline::of(std::slice::from_ref(&frame));
        let pose = outline.view(4.0 / 3.0, 0.0);
        let seen: Vec<[f32; 2]> =
            outline.points.iter().map(|p| pose.project(*p, 640.0, 480.0).unwrap()).collect();
        let side =
            |i: usize, f: fn(f32, f32) -> f32, start: f32| seen.iter().map(|p| p[i]).fold(start, f);
        let wide = side(0, f32::max, 0.0) - side(0, f32::min, 1e9);
        assert!((wide - FILL * 640.0).abs() < 1.0, "{wide}");
        assert!(side(1, f32::min, 1e9) > 0.0 && side(1, f32::max, 0.0) < 480.0);
    }

    #[test]
    fn what_is_turned_stays_in_the_picture() {
        let frame = frame_of(vec![slab(Vec3::new(-3.0, 0.0, 1.0), Vec3::new(5.0, 1.0, 2.0))]);
        let outline = Outline::of(std::slice::from_ref(&frame));
        let outside = |framed: &Outline| {
            let pose = framed.view(4.0 / 3.0, 0.0);
            let centre = framed.bounds().centre();
            let turned =
                |k: usize, p: Vec3| centre + Quat::from_rotation_y(0.01 * k as f32) * (p - centre);
            let places = (0..629).flat_map(|k| outline.points.iter().map(move |p| turned(k, *p)));
            let seen = places.map(|p| pose.project(p, 640.0, 480.0).unwrap_or([-1.0; 2]));
            seen.filter(|[x, y]| !(0.0..640.0).contains(x) || !(0.0..480.0).contains(y)).count()
        };
        assert!(outside(&outline) > 0);
        assert_eq!(outside(&outline.turned()), 0);
    }

    #[test]
    fn a_wide_ground_runs_out_of_the_picture() {
        let ground = slab(Vec3::new(-90.0, -0.1, -50.0), Vec3::new(10.0, 0.0, 50.0));
        let thing = slab(Vec3::ZERO, Vec3::ONE);
        let outline = Outline::of(&[frame_of(vec![ground.clone(), thing])]);
        assert_eq!(outline.bounds().max, Vec3::ONE);
        // A ground alone is what there is to see.
        let outline = Outline::of(&[frame_of(vec![ground])]);
        assert_eq!(outline.bounds().min.x, -90.0);
    }

    #[test]
    fn a_corner_that_one_vertex_holds_is_not_lost() {
        let mut mesh = slab(Vec3::ZERO, Vec3::ONE);
        let crowd = super::super::room::sphere(5000).map(|d| Vec3::splat(0.5) + 0.2 * d);
        mesh.positions.extend(crowd);
        mesh.positions.push(Vec3::new(9.0, 0.5, 0.5));
        mesh.normals = NormalSource::Given(vec![Vec3::Y; mesh.positions.len()]);
        assert_eq!(Outline::of(&[frame_of(vec![mesh])]).bounds().max.x, 9.0);
    }
}
