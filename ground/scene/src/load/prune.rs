//! What a mesh has no use for: triangles without a place, vertices without a triangle.

use crate::Mesh;
use crate::mesh::is_in_reach;

/// Drops triangles with a corner that is not finite or out of reach, then vertices that no triangle uses; the
/// others keep their order. Hands back how many triangles it dropped. Everything is expected to be
/// as long as [`Mesh`] says, with `polygons` empty or as long as `triangles`.
pub(super) fn prune(mesh: &mut Mesh) -> u64 {
    let finite: Vec<bool> = mesh.positions.iter().map(|p| is_in_reach(*p)).collect();
    let keep: Vec<bool> =
        mesh.triangles.iter().map(|t| t.iter().all(|v| finite[*v as usize])).collect();
    let dropped = keep.iter().filter(|kept| !**kept).count();
    if dropped > 0 {
        retain(&mut mesh.triangles, &keep);
        retain(&mut mesh.materials, &keep);
        retain(&mut mesh.polygons, &keep);
    }
    drop_unused(mesh);
    dropped as u64
}

/// What to say about triangles that [`prune`] dropped, if any.
pub(super) fn warning(dropped: u64, file: &str) -> Option<String> {
    let what = "triangles have corners that are not finite or out of reach, and are left out";
    (dropped > 0).then(|| format!("{file}: {dropped} {what}"))
}

fn retain<T>(values: &mut Vec<T>, keep: &[bool]) {
    let mut kept = keep.iter();
    values.retain(|_| *kept.next().unwrap_or(&true));
}

fn drop_unused(mesh: &mut Mesh) {
    const UNUSED: u32 = u32::MAX;
    let mut new = vec![UNUSED; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|v| new[*v as usize] = 0);
    if !new.contains(&UNUSED) {
        return;
    }
    let mut used = Vec::new();
    for (old, new) in new.iter_mut().enumerate().filter(|(_, new)| **new != UNUSED) {
        *new = used.len() as u32;
        used.push(old as u32);
    }
    mesh.pick(&used);
    mesh.triangles.iter_mut().flatten().for_each(|v| *v = new[*v as usize]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MaterialId;
    use chiaro_basis::math::Vec3;

    #[test]
    fn only_what_can_be_drawn_stays() {
        let mut mesh = Mesh {
            positions: vec![
                Vec3::X,
                Vec3::new(0.0, f32::NAN, 1.0),
                Vec3::Y,
                Vec3::ONE,
                Vec3::Z,
                Vec3::ZERO,
            ],
            triangles: vec![[0, 1, 2], [5, 4, 2]],
            materials: vec![MaterialId::new(0), MaterialId::new(1)],
            polygons: vec![0, 1],
            ..Mesh::default()
        };
        assert_eq!(prune(&mut mesh), 1);
        assert_eq!(mesh.positions, [Vec3::Y, Vec3::Z, Vec3::ZERO]);
        assert_eq!(mesh.triangles, [[2, 1, 0]]);
        assert_eq!((mesh.materials.len(), mesh.polygons.len()), (1, 1));
        assert_eq!(prune(&mut mesh), 0);
    }

    #[test]
    fn a_mesh_without_triangles_has_no_vertices() {
        let mut mesh = Mesh { positions: vec![Vec3::X], ..Mesh::default() };
        prune(&mut mesh);
        assert!(mesh.positions.is_empty());
    }
}
