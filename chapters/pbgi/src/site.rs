//! [`Site`]: where surfels lie, as places on triangles (thesis, 6.3.2, Sampling).
//!
//! The cumulative areas of all triangles are cut into equal parts, one surfel in each; inside its
//! triangle a surfel lies at a point of a low-discrepancy sequence. A site keeps its triangle and
//! its barycentric coordinates, so that a deforming surface carries its surfels along: chosen once
//! a shot, they do not swim.

use crate::focus::Focus;
use crate::knob::{LightKnobs, Sampling};
use crate::poisson::poisson_sites;
use chiaro_basis::random;
use chiaro_scene::{Frame, Mesh, Scene};

/// A place on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// Index into [`Frame::objects`].
    pub object: u32,
    /// Index into the mesh's triangles.
    pub face: u32,
    /// Barycentric coordinates of the second and the third vertex.
    pub b: [f32; 2],
    /// The share of its triangle's area that it stands for.
    pub share: f32,
}

/// About `count` sites, evenly over the area of everything drawn; none when there is no area.
pub fn sites(scene: &Scene, frame: &Frame, count: usize) -> Vec<Site> {
    let total: f64 = areas(scene, frame).map(|p| p.area).sum();
    if !(total > 0.0 && total.is_finite()) || count == 0 {
        return Vec::new();
    }
    let spacing = total / count as f64;
    let mut sites: Vec<Site> = Vec::with_capacity(count + 1);
    let mut before = 0.0;
    for Piece { object, face, area, triangle } in areas(scene, frame) {
        // The sites at (i + 1/2) spacings that fall into this triangle.
        let first = (before / spacing + 0.5).floor() as u64;
        before += area;
        let end = ((before / spacing + 0.5).floor() as u64).min(count as u64);
        for index in first..end {
            let [u, v] = random::r2(index);
            let b = if u < v { [0.5 * u, v - 0.5 * u] } else { [u - 0.5 * v, 0.5 * v] };
            let share = (spacing / triangle) as f32;
            sites.push(Site { object, face, b, share });
        }
    }
    sites
}

/// The sites that the knobs ask for, denser where a shot's cameras see them: those that are lit in full. Those
/// from which a coded tree learns are even, as its own are.
pub fn sites_by(knobs: &LightKnobs, scene: &Scene, frame: &Frame, focus: &Focus) -> Vec<Site> {
    let count = knobs.kept_surfels() as usize;
    let even = || sites(scene, frame, count);
    match knobs.sampling {
        Sampling::Sequence if knobs.is_compact() || !knobs.focus => even(),
        Sampling::Sequence => focus.sites(scene, frame, count).unwrap_or_else(even),
        Sampling::Poisson => poisson_sites(scene, frame, count),
    }
}

/// A triangle that surfels lie on.
pub(crate) struct Piece {
    pub(crate) object: u32,
    pub(crate) face: u32,
    /// The area that it stands for: its own, or that of the point whose disc it is a part of.
    pub(crate) area: f64,
    /// Its own area.
    pub(crate) triangle: f64,
}

/// Every triangle drawn that has an area; of the disc of a point that which holds the point.
pub(crate) fn areas<'a>(scene: &'a Scene, frame: &'a Frame) -> impl Iterator<Item = Piece> + 'a {
    frame.objects.iter().enumerate().flat_map(move |(index, object)| {
        let shape = &frame.shapes[object.shape];
        let m = object.world_from_shape;
        let mesh = shape.mesh_in(scene);
        let step = if mesh.is_cloud() { Mesh::DISC } else { 1 };
        let triangles = mesh.triangles.iter().enumerate().step_by(step);
        triangles.filter_map(move |(face, t)| {
            let [a, b, c] = t.map(|v| m.transform_point3(shape.positions[v as usize]).as_dvec3());
            let triangle = 0.5 * (b - a).cross(c - a).length();
            let share = mesh.discs.get(face / step).copied().unwrap_or(1.0);
            let area = triangle * f64::from(share);
            let (object, face) = (index as u32, face as u32);
            (area > 0.0 && area.is_finite()).then_some(Piece { object, face, area, triangle })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_scene::{Poser, demo};

    #[test]
    fn sites_are_as_dense_on_every_surface() {
        let scene = demo::scene("cornell-box").unwrap();
        let (playback, _) = scene.playback(&Default::default()).unwrap();
        let frame = Poser::new(&scene).frame(0.0, &playback);
        let all = sites(&scene, &frame, 20_000);
        assert!((all.len() as i64 - 20_000).abs() <= 1);
        let total: f64 = areas(&scene, &frame).map(|p| p.area).sum();
        for object in 0..frame.objects.len() as u32 {
            let area: f64 =
                areas(&scene, &frame).filter(|p| p.object == object).map(|p| p.area).sum();
            let count = all.iter().filter(|s| s.object == object).count() as f64;
            assert!((count - area / total * 20_000.0).abs() <= 1.0, "{object}: {count}");
        }
    }
}
