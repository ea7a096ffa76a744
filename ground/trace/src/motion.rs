//! Motion vectors: where the surface in a pixel was one frame before.

use crate::gbuffer::GBuffer;
use chiaro_basis::math::Vec3;
use chiaro_image::Plane;
use chiaro_scene::{Frame, Pose, Scene};

/// The previous picture position of each pixel's material point minus its present one, in pixels,
/// x right and y down. Exact for any deformation: the point keeps its triangle and its barycentric
/// coordinates. Zero where there is no geometry, or where the point was behind the camera.
pub fn motion(
    buffer: &GBuffer,
    scene: &Scene,
    frame: &Frame,
    previous: &Frame,
    previous_pose: &Pose,
) -> Plane<[f32; 2]> {
    let (w, h) = buffer.size();
    let (wf, hf) = (w as f32, h as f32);
    buffer.over_covered(|x, y| {
        let hit = buffer.hit((x, y));
        let here = buffer.pose.project(Vec3::from(buffer.position[(x, y)]), wf, hf);
        let there = material_point(scene, frame, previous, &hit)
            .and_then(|p| previous_pose.project(p, wf, hf));
        match (here, there) {
            (Some(a), Some(b)) => [b[0] - a[0], b[1] - a[1]],
            _ => [0.0, 0.0],
        }
    })
}

/// The world position in `previous` of the material point that was hit in `frame`; `None` where
/// connectivity has changed.
pub(crate) fn material_point(
    scene: &Scene,
    frame: &Frame,
    previous: &Frame,
    hit: &crate::Hit,
) -> Option<Vec3> {
    let object = frame.objects.get(hit.object as usize)?;
    let mesh = frame.shapes[object.shape].mesh_in(scene);
    let before = previous.objects.get(hit.object as usize)?;
    let shape = &previous.shapes[before.shape];
    if shape.remade.is_some() {
        return None;
    }
    let corners = mesh.triangles[hit.face as usize].map(|v| shape.positions[v as usize]);
    let [b, c] = hit.b;
    let p = corners[0] * (1.0 - b - c) + corners[1] * b + corners[2] * c;
    Some(before.world_from_shape.transform_point3(p))
}
