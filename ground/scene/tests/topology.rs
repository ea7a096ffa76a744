//! A bestiary of meshes whose topology is known.

use chiaro_basis::math::{Vec3, vec3};
use chiaro_scene::topology::{EdgeKind, Fans, Topology, crease};
use chiaro_scene::{Influences, MaterialId, Mesh, Morph, NormalSource};
use proptest::prelude::*;
use std::f32::consts::{FRAC_PI_4, PI, TAU};

fn mesh(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    let materials = vec![MaterialId::new(0); triangles.len()];
    Mesh { positions, triangles, materials, ..Mesh::default() }
}

/// Counts of boundary, interior and non-manifold edges.
fn kinds(t: &Topology) -> [usize; 3] {
    let count = |kind| (0..t.edges.len()).filter(|&e| t.kind(e) == kind).count();
    [EdgeKind::Boundary, EdgeKind::Interior, EdgeKind::NonManifold].map(count)
}

fn count(flags: &[bool]) -> usize {
    flags.iter().filter(|f| **f).count()
}

/// A unit cube with four vertices a face, as files with split normals have it.
fn cube() -> Mesh {
    let (mut positions, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut n = Vec3::ZERO;
            n[axis] = side;
            let mut u = Vec3::ZERO;
            u[(axis + 1) % 3] = side;
            let v = n.cross(u);
            let base = positions.len() as u32;
            for (s, t) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                positions.push(n + u * s + v * t);
                normals.push(n);
            }
            triangles.push([base, base + 1, base + 2]);
            triangles.push([base, base + 2, base + 3]);
        }
    }
    Mesh { normals: NormalSource::Given(normals), ..mesh(positions, triangles) }
}

/// A grid of quads over [0, 1]^2, split in two, mapped into space; `wrap` glues opposite borders.
fn sheet(nu: u32, nv: u32, wrap: [bool; 2], place: impl Fn(f32, f32) -> Vec3) -> Mesh {
    let (cu, cv) = (nu + u32::from(!wrap[0]), nv + u32::from(!wrap[1]));
    let at = |i: u32, j: u32| (j % cv) * cu + i % cu;
    let positions = (0..cu * cv)
        .map(|k| place((k % cu) as f32 / nu as f32, (k / cu) as f32 / nv as f32))
        .collect();
    let quads = (0..nu * nv).map(|k| (k % nu, k / nu));
    let triangles = quads.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    mesh(positions, triangles.collect())
}

fn torus(nu: u32, nv: u32) -> Mesh {
    sheet(nu, nv, [true, true], |u, v| {
        let ((su, cu), (sv, cv)) = ((u * TAU).sin_cos(), (v * TAU).sin_cos());
        vec3((2.0 + cv) * cu, (2.0 + cv) * su, sv)
    })
}

/// A sphere as a file stores it: the seam and the poles in many copies.
fn sphere(nu: u32, nv: u32) -> Mesh {
    sheet(nu, nv, [false, false], |u, v| {
        let turn = if u == 1.0 { 0.0 } else { u * TAU };
        let r = if v == 0.0 || v == 1.0 { 0.0 } else { (v * PI).sin() };
        vec3(r * turn.cos(), r * turn.sin(), -(v * PI).cos())
    })
}

fn tetrahedron(a: u32, b: u32, c: u32, d: u32) -> [[u32; 3]; 4] {
    [[a, c, b], [a, b, d], [b, c, d], [c, a, d]]
}

#[test]
fn a_cube_with_split_normals_is_one_box() {
    let cube = cube();
    let t = Topology::of(&cube);
    assert_eq!((t.weld.first.len(), t.edges.len()), (8, 18));
    assert_eq!(kinds(&t), [0, 18, 0]);
    assert!(t.is_closed() && t.is_oriented());
    assert_eq!(t.euler_characteristic(), 2);
    assert_eq!(count(&crease::by_angle(&t, &cube.positions, 0.5)), 12);
    assert_eq!(count(&crease::by_angle(&t, &cube.positions, 1.6)), 0);
    assert_eq!(count(&crease::by_normals(&t, &cube, 0.1)), 12);
    assert_eq!(count(&crease::by_normals(&t, &cube, 1.6)), 0);
    for (p, n) in t.weld.gather(&cube.positions).iter().zip(t.normals(&cube.positions)) {
        assert!(n.distance(p.normalize()) < 1e-6, "{n} at {p}");
    }
}

#[test]
fn creases_by_angle_and_by_normals_agree_on_a_cube() {
    let cube = cube();
    let t = Topology::of(&cube);
    let by_angle = crease::by_angle(&t, &cube.positions, 0.5);
    assert_eq!(by_angle, crease::by_normals(&t, &cube, 0.5));
    let groups = (0..24).map(|v| v / 4 * 4).collect();
    let grouped = Mesh { normals: NormalSource::Faces(groups), ..cube };
    assert_eq!(by_angle, crease::by_normals(&t, &grouped, 0.5));
}

#[test]
fn a_hard_edge_may_end_in_a_smooth_vertex() {
    // Two triangles whose normals differ at one end of their edge only.
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ZERO, Vec3::NEG_Y];
    let tilted = vec3(0.0, -1.0, 1.0).normalize();
    let normals = vec![Vec3::Z, Vec3::Z, Vec3::Z, tilted, tilted];
    let mesh = Mesh {
        normals: NormalSource::Given(normals),
        ..mesh(positions, vec![[0, 1, 2], [1, 3, 4]])
    };
    let t = Topology::of(&mesh);
    assert_eq!(kinds(&t), [4, 1, 0]);
    assert_eq!(count(&crease::by_normals(&t, &mesh, 0.5)), 1);
    assert_eq!(count(&crease::by_normals(&t, &mesh, FRAC_PI_4 + 0.01)), 0);
    assert_eq!(count(&crease::by_angle(&t, &mesh.positions, 0.5)), 0);
}

#[test]
fn a_moebius_strip_is_not_oriented() {
    let strip = |half_turns: u32| {
        let n = 24;
        let positions = (0..2 * n).map(|k| {
            let (turn, side) = ((k / 2) as f32 / n as f32 * TAU, (k % 2) as f32 - 0.5);
            let (s, c) = (0.5 * half_turns as f32 * turn).sin_cos();
            let r = 2.0 + side * c;
            vec3(r * turn.cos(), r * turn.sin(), side * s)
        });
        let triangles = (0..n).flat_map(|i| {
            let flip = if i + 1 == n { half_turns % 2 } else { 0 };
            let next = (i + 1) % n;
            let [a, b, c, d] = [2 * i, 2 * i + 1, 2 * next + flip, 2 * next + 1 - flip];
            [[a, b, c], [b, d, c]]
        });
        Topology::of(&mesh(positions.collect(), triangles.collect()))
    };
    for half_turns in 0..4 {
        let t = strip(half_turns);
        assert_eq!(t.euler_characteristic(), 0);
        assert_eq!(kinds(&t), [48, 48, 0]);
        assert_eq!(t.is_oriented(), half_turns % 2 == 0);
        assert!(!t.is_closed());
        let fans = Fans::of(&t);
        assert!(fans.pinched().is_empty());
        let around = (0..48).map(|v| fans.at(v).collect::<Vec<_>>());
        assert!(around.clone().all(|fans| fans.len() == 1 && !fans[0].is_closed()));
        assert_eq!(around.map(|fans| fans[0].corners.len()).sum::<usize>(), 3 * 48);
    }
}

#[test]
fn creases_do_not_mind_how_neighbours_wind() {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, vec3(0.5, -1.0, 0.1)];
    for second in [[1, 0, 3], [0, 1, 3]] {
        let t = Topology::of(&mesh(positions.clone(), vec![[0, 1, 2], second]));
        assert_eq!(count(&crease::by_angle(&t, &positions, 0.2)), 0);
        assert_eq!(count(&crease::by_angle(&t, &positions, 0.05)), 1);
    }
}

#[test]
fn an_open_fan_has_its_ring_in_order() {
    let n = 6;
    let rim = (0..n).map(|i| vec3((i as f32 * 0.5).cos(), (i as f32 * 0.5).sin(), 0.0));
    let positions: Vec<Vec3> = std::iter::once(Vec3::ZERO).chain(rim).collect();
    // Stored in no order, and each triangle from another corner.
    let triangles = vec![[0, 4, 5], [2, 0, 1], [0, 2, 3], [6, 0, 5], [3, 4, 0]];
    let t = Topology::of(&mesh(positions, triangles));
    assert_eq!(kinds(&t), [7, 4, 0]);
    assert_eq!(t.euler_characteristic(), 1);
    assert!(t.is_oriented() && !t.is_closed());
    let fans = Fans::of(&t);
    let around: Vec<_> = fans.at(0).collect();
    assert_eq!(around.len(), 1);
    assert_eq!(around[0].ring, [1, 2, 3, 4, 5, 6]);
    assert_eq!(around[0].corners.iter().map(|s| s.face()).collect::<Vec<_>>(), [1, 2, 4, 0, 3]);
    assert!(around[0].corners.iter().all(|s| t.start(*s) == 0));
}

#[test]
fn an_hourglass_is_pinched_at_its_waist() {
    let positions = vec![
        Vec3::ZERO,
        vec3(1.0, 0.0, 1.0),
        vec3(-1.0, 1.0, 1.0),
        vec3(-1.0, -1.0, 1.0),
        vec3(1.0, 0.0, -1.0),
        vec3(-1.0, 1.0, -1.0),
        vec3(-1.0, -1.0, -1.0),
    ];
    let (top, bottom) = (tetrahedron(0, 1, 2, 3), tetrahedron(0, 4, 6, 5));
    let t = Topology::of(&mesh(positions, [top, bottom].concat()));
    assert_eq!(kinds(&t), [0, 12, 0]);
    assert_eq!(t.euler_characteristic(), 3, "two spheres that share a point");
    let fans = Fans::of(&t);
    assert_eq!(fans.pinched(), [0]);
    assert!(fans.at(0).all(|f| f.is_closed() && f.ring.len() == 3));
    assert_eq!(fans.at(1).len(), 1);
}

#[test]
fn two_tetrahedra_on_one_edge_meet_four_at_a_time() {
    let positions = vec![
        Vec3::ZERO,
        Vec3::Z,
        vec3(1.0, 1.0, 0.0),
        vec3(1.0, -1.0, 0.0),
        vec3(-1.0, -1.0, 0.0),
        vec3(-1.0, 1.0, 0.0),
    ];
    let (right, left) = (tetrahedron(0, 1, 2, 3), tetrahedron(0, 1, 4, 5));
    let t = Topology::of(&mesh(positions.clone(), [right, left].concat()));
    assert_eq!(kinds(&t), [0, 10, 1]);
    let shared = t.edges.iter().position(|e| *e == [0, 1]).unwrap();
    assert_eq!(t.kind(shared), EdgeKind::NonManifold);
    assert_eq!(t.sides(shared).len(), 4);
    assert!(t.sides(shared).iter().all(|s| t.twin(*s).is_none()));
    assert!(t.is_closed() && t.is_oriented());
    assert_eq!(t.euler_characteristic(), 3);
    assert!(crease::by_angle(&t, &positions, PI)[shared]);
    let fans = Fans::of(&t);
    assert_eq!(fans.pinched(), [0, 1]);
    assert!(fans.at(0).all(|f| !f.is_closed() && f.corners.len() == 3));
}

#[test]
fn triangles_without_area_are_noted() {
    let positions =
        vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X, vec3(0.5, 0.5, 0.0), vec3(1.0, 1.0, 0.0)];
    // A good one, one that welding collapses, one along a line.
    let m = mesh(positions.clone(), vec![[0, 1, 2], [1, 3, 2], [1, 4, 2], [1, 5, 4], [4, 5, 2]]);
    let t = Topology::of(&m);
    assert_eq!(t.collapsed, [1]);
    assert_eq!(t.triangles[1], [1, 1, 2]);
    assert_eq!(crease::flat(&t, &positions), [1, 2]);
    // The sliver holds the surface together.
    assert_eq!(kinds(&t), [4, 4, 0]);
    assert_eq!(t.euler_characteristic(), 1);
    assert_eq!(count(&crease::by_angle(&t, &positions, 0.1)), 0);
}

#[test]
fn spheres_and_tori_have_the_characteristics_of_spheres_and_tori() {
    let ball = sphere(16, 8);
    let t = Topology::of(&ball);
    assert_eq!(t.weld.first.len(), 2 + 7 * 16);
    assert_eq!(t.collapsed.len(), 32);
    assert!(t.is_closed() && t.is_oriented());
    assert_eq!(t.euler_characteristic(), 2);
    let ring = Topology::of(&torus(16, 12));
    assert!(ring.is_closed() && ring.is_oriented());
    assert_eq!(ring.euler_characteristic(), 0);
    let fans = Fans::of(&ring);
    assert!((0..192).all(|v| fans.at(v).len() == 1 && fans.at(v).all(|f| f.is_closed())));
    assert_eq!(Topology::of(&Mesh::default()).euler_characteristic(), 0);
    assert!(!Topology::of(&Mesh::default()).is_closed());
}

#[test]
fn only_what_nothing_can_part_is_welded() {
    let two = |change: &dyn Fn(&mut Mesh)| {
        let mut m = mesh(vec![vec3(0.0, 1.0, 2.0), vec3(-0.0, 1.0, 2.0)], Vec::new());
        change(&mut m);
        Topology::of(&m).weld.welded
    };
    let influences = |a: ([u16; 4], [f32; 4]), b: ([u16; 4], [f32; 4])| Influences {
        joints: vec![vec![a.0, b.0]],
        weights: vec![vec![a.1, b.1]],
    };
    let morph = |d: [Vec3; 2]| vec![Morph { positions: d.to_vec(), ..Morph::default() }];
    assert_eq!(two(&|_| ()), [0, 0]);
    assert_eq!(two(&|m| m.positions[1].x = 1e-30), [0, 1]);
    assert_eq!(two(&|m| m.morphs = morph([Vec3::X, Vec3::X])), [0, 0]);
    assert_eq!(two(&|m| m.morphs = morph([Vec3::X, Vec3::Y])), [0, 1]);
    let half = ([3, 5, 0, 0], [0.5, 0.5, 0.0, 0.0]);
    let same = ([9, 5, 3, 3], [0.0, 0.5, 0.25, 0.25]);
    let other = ([3, 6, 0, 0], [0.5, 0.5, 0.0, 0.0]);
    assert_eq!(two(&|m| m.influences = influences(half, same)), [0, 0]);
    assert_eq!(two(&|m| m.influences = influences(half, other)), [0, 1]);
}

#[test]
fn poses_weld_what_coincides_in_all_of_them() {
    let m = mesh(vec![Vec3::ZERO; 3], Vec::new());
    let (a, b) = ([Vec3::ZERO; 3], [Vec3::X, Vec3::X, Vec3::Y]);
    assert_eq!(Topology::over(&m, &[&a]).weld.welded, [0, 0, 0]);
    assert_eq!(Topology::over(&m, &[&a, &b]).weld.welded, [0, 0, 1]);
    assert_eq!(Topology::over(&m, &[]).weld.welded, [0, 1, 2]);
}

proptest! {
    #[test]
    fn any_triangles_make_a_topology(
        triangles in proptest::collection::vec([0..9u32, 0..9, 0..9], 0..40),
        twins in 0..9usize,
    ) {
        let positions = (0..9).map(|i| Vec3::splat(i.max(twins) as f32)).collect();
        let m = mesh(positions, triangles);
        let t = Topology::of(&m);
        let whole = t.triangles.len() - t.collapsed.len();
        let on_edges: usize = (0..t.edges.len()).map(|e| t.sides(e).len()).sum();
        prop_assert_eq!(on_edges, 3 * whole);
        for edge in 0..t.edges.len() {
            for &side in t.sides(edge) {
                prop_assert_eq!(t.edge(side), Some(edge));
                prop_assert!(t.twin(side).is_none_or(|twin| t.twin(twin) == Some(side)));
            }
        }
        let fans = Fans::of(&t);
        let mut passed = vec![0; 3 * t.triangles.len()];
        for v in 0..t.weld.first.len() {
            for fan in fans.at(v) {
                prop_assert_eq!(fan.ring.len(), fan.corners.len() + usize::from(!fan.is_closed()));
                for (i, s) in fan.corners.iter().enumerate() {
                    passed[3 * s.face() + s.corner()] += 1;
                    let corners = t.triangles[s.face()];
                    let next = fan.ring[(i + 1) % fan.ring.len()];
                    for w in [v as u32, fan.ring[i], next] {
                        prop_assert!(corners.contains(&w));
                    }
                }
            }
        }
        prop_assert_eq!(passed.iter().filter(|p| **p == 1).count(), 3 * whole);
        prop_assert!(passed.iter().all(|p| *p <= 1));
    }
}
