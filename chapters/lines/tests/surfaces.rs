//! Surfaces are oriented manifolds, whatever comes in.

mod meshes;

use chiaro_basis::math::{Vec3, vec3};
use chiaro_lines::surface::{NONE, Ring, next};
use chiaro_lines::{Slice, Surface};
use meshes::*;
use proptest::prelude::*;

/// Every edge has one or two faces that wind alike, and every vertex one fan.
fn assert_manifold(s: &Surface) {
    for h in 0..s.mate.len() as u32 {
        let mate = s.mate[h as usize];
        if mate != NONE {
            assert_eq!(s.mate[mate as usize], h);
            assert_eq!((s.from(h), s.to(h)), (s.to(mate), s.from(mate)), "half-edge {h}");
            assert_eq!(s.edge[h as usize], s.edge[mate as usize]);
        }
        assert_eq!(s.to(h), s.from(next(h)));
    }
    let mut corners = vec![0; s.anchors.len()];
    s.faces.iter().flatten().for_each(|v| corners[*v as usize] += 1);
    let mut ring = Ring::default();
    for v in (0..s.anchors.len()).filter(|v| corners[*v] > 0) {
        ring.walk(s, v as u32);
        assert_eq!(ring.spokes.len(), corners[v] + usize::from(!ring.closed), "vertex {v}");
    }
}

#[test]
fn creases_keep_a_cube_closed() {
    let (positions, triangles) = cube();
    let s = surface(&scene(positions, triangles, true), &SHARP);
    assert_manifold(&s);
    assert_eq!(s.creases.len(), 12);
    assert_eq!(s.real_faces, 12);
    // Two triangles a crease, one at each corner where three strips meet.
    assert_eq!(s.faces.len(), 12 + 24 + 8);
    assert_eq!(s.euler_characteristic(), 2);
    assert!(s.mate.iter().all(|m| *m != NONE));
}

#[test]
fn the_silhouette_of_a_cube_runs_along_its_edges() {
    let (positions, triangles) = cube();
    let scene = scene(positions, triangles, true);
    let s = surface(&scene, &SHARP);
    let frame = frame(&scene);
    let posed = chiaro_lines::Posed::new(&s, &frame, 0);
    let slice = Slice::of(&s, &posed.facing(&view(chiaro_basis::math::vec3(3.0, 4.0, 5.0))));
    assert_eq!(slice.chains.len(), 1);
    assert!(slice.chains[0].closed);
    // A hexagon: six corners, each with crossings that lie on cube edges.
    for c in &slice.crossings {
        let [a, b] = s.ends(c.edge).map(|v| posed.positions[v as usize]);
        let p = a.lerp(b, c.at);
        let on = p.to_array().iter().filter(|x| (x.abs() - 1.0).abs() < 1e-9).count();
        assert!(on >= 2, "{p} is on no edge of the cube");
    }
}

#[test]
fn silhouettes_of_facets_run_along_their_edges() {
    let (positions, triangles) = torus(12, 8, 0.1);
    let scene = soup(&positions, &triangles, true);
    // Nothing in it is round, so that nothing is made rounder.
    let s = faceted(&scene, 2);
    assert_manifold(&s);
    assert_eq!((s.real_faces, s.euler_characteristic()), (triangles.len(), 0));
    let posed = chiaro_lines::Posed::new(&s, &frame(&scene), 0);
    for k in 0..20 {
        let from = chiaro_basis::math::Quat::from_rotation_y(0.3 * k as f32)
            * chiaro_basis::math::vec3(1.0, 3.0 - 0.2 * k as f32, 4.0);
        let slice = Slice::of(&s, &posed.facing(&view(from)));
        assert!(!slice.chains.is_empty() && slice.chains.iter().all(|c| c.closed));
        assert!(slice.crossings.iter().all(|c| s.is_strip(c.face as usize)));
    }
}

#[test]
fn seams_of_a_smooth_mesh_are_no_facets() {
    let (positions, triangles) = torus(12, 8, 0.1);
    let s = faceted(&soup(&positions, &triangles, false), 1);
    assert_eq!((s.creases.len(), s.real_faces), (0, 4 * triangles.len()));
    // Facets that bend little are opened, but are no lines of their own.
    let flat = faceted(&soup(&positions, &triangles, true), 0);
    let sharp = flat.creases.iter().filter(|c| c.sharp).count();
    assert!(sharp > 0 && 2 * sharp < flat.creases.len(), "{sharp} of {}", flat.creases.len());
    let (positions, triangles) = cube();
    let cube = faceted(&soup(&positions, &triangles, true), 0);
    assert_eq!(cube.creases.len(), 12, "the halves of a square are one facet");
}

#[test]
fn what_a_pose_alone_folds_is_no_crease() {
    let positions = (0..9).map(|i| vec3(i as f32 % 3.0 - 1.0, 0.0, (i / 3) as f32 - 1.0));
    let positions: Vec<Vec3> = positions.collect();
    let square = |i: u32| [[i, i + 3, i + 4], [i, i + 4, i + 1]];
    let triangles: Vec<[u32; 3]> = [0, 1, 3, 4].into_iter().flat_map(square).collect();
    let fold = |p: Vec3| if p.x > 0.0 { vec3(-0.2 * p.x, p.x, p.z) } else { p };
    let sharp = |rest: Vec<Vec3>| {
        let scene = scene(rest, triangles.clone(), false);
        let mut folded = frame(&scene);
        folded.shapes[0].positions = positions.iter().map(|p| fold(*p)).collect();
        let s = Surface::of(&scene, &folded, &SHARP);
        s.creases.iter().filter(|c| c.sharp).count()
    };
    assert_eq!(sharp(positions.clone()), 0);
    assert_eq!(sharp(positions.iter().map(|p| fold(*p)).collect()), 2);
}

#[test]
fn a_torus_stays_one_and_a_sheet_keeps_its_border() {
    let (positions, triangles) = torus(24, 16, 0.2);
    let s = surface(&scene(positions, triangles, false), &SMOOTH);
    assert_manifold(&s);
    assert_eq!(s.euler_characteristic(), 0);
    let (positions, triangles) = sheet(6, 0.2);
    let s = surface(&scene(positions, triangles, false), &SMOOTH);
    assert_manifold(&s);
    assert_eq!(s.mate.iter().filter(|m| **m == NONE).count(), 24);
}

#[test]
fn a_book_of_three_pages_is_cut_at_its_spine() {
    let v = chiaro_basis::math::vec3;
    let positions = vec![
        v(0.0, 0.0, 0.0),
        v(0.0, 1.0, 0.0),
        v(1.0, 0.0, 0.0),
        v(-1.0, 0.0, 0.3),
        v(0.0, 0.0, 1.0),
    ];
    let s = surface(&scene(positions, vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]], false), &SMOOTH);
    assert_manifold(&s);
    assert_eq!(s.half.len(), 9);
    assert!(s.notes.iter().any(|n| n.contains("more than two")), "{:?}", s.notes);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn any_triangles_make_a_manifold(
        triangles in prop::collection::vec([0u32..9, 0u32..9, 0u32..9], 0..24),
        hard: bool,
    ) {
        let positions = (0..9).map(|i| {
            let r = |k: u64| chiaro_basis::random::unit(k, i);
            chiaro_basis::math::vec3(r(1), r(2), r(3))
        });
        let scene = scene(positions.collect(), triangles, hard);
        let s = surface(&scene, if hard { &SHARP } else { &SMOOTH });
        assert_manifold(&s);
        let posed = chiaro_lines::Posed::new(&s, &frame(&scene), 1);
        let g = posed.facing(&view(chiaro_basis::math::vec3(3.0, 4.0, 5.0)));
        let slice = Slice::of(&s, &g);
        for chain in &slice.chains {
            let ends = [chain.of(&slice)[0], chain.of(&slice)[chain.count as usize - 1]];
            prop_assert!(chain.closed || ends.iter().all(|c| s.is_border(c.edge)));
        }
    }
}
