//! Refined surfaces are manifolds through the same points; smooth ones come nearer to what they
//! stand for, creases stay sharp.

mod meshes;

use chiaro_basis::Run;
use chiaro_basis::math::{Vec3, vec3};
use chiaro_lines::check::check;
use chiaro_lines::surface::NONE;
use chiaro_lines::{Detail, LinesKnobs, Reel, Surface, positions};
use chiaro_scene::Scene;
use meshes::*;

fn refined(scene: &Scene, levels: u8) -> (Surface, Vec<chiaro_basis::math::DVec3>) {
    let frame = frame(scene);
    let surface = Surface::refined(scene, &frame, &SHARP, &[Detail { levels, facets: false }]);
    let positions = positions(&surface, &frame);
    (surface, positions)
}

#[test]
fn a_coarse_torus_becomes_rounder() {
    let (p, t) = torus(16, 10, 0.0);
    let scene = scene(p, t, false);
    let error = |levels: u8| {
        let (surface, positions) = refined(&scene, levels);
        assert_eq!(surface.euler_characteristic(), 0);
        assert!(surface.mate.iter().all(|m| *m != NONE));
        assert_eq!(surface.real_faces, 320 << (2 * levels));
        // Distance of the faces' centres from the torus: what the outline is wrong by.
        let off = |f: &[u32; 3]| {
            let c = f.map(|v| positions[v as usize]).into_iter().sum::<chiaro_basis::math::DVec3>()
                / 3.0;
            let ring = (c.x.hypot(c.z) - 1.0).hypot(c.y);
            (ring - 0.4).abs()
        };
        surface.faces.iter().map(off).fold(0.0, f64::max)
    };
    let errors = [error(0), error(1), error(2)];
    assert!(errors[1] < 0.4 * errors[0] && errors[2] < 0.25 * errors[0], "{errors:?}");
}

#[test]
fn a_refined_cube_stays_one() {
    let (p, t) = cube();
    let (surface, positions) = refined(&scene(p, t, true), 2);
    assert_eq!(surface.euler_characteristic(), 2);
    assert!(surface.mate.iter().all(|m| *m != NONE));
    assert_eq!(surface.creases.len(), 12 * 4);
    for p in positions {
        let most = p.abs().max_element();
        assert!((most - 1.0).abs() < 1e-9, "{p} has left the cube");
    }
}

#[test]
fn borders_of_a_disc_become_round_and_stay_borders() {
    let n = 12;
    let rim = |i: u32| {
        let a = std::f32::consts::TAU * i as f32 / n as f32;
        vec3(a.cos(), 0.0, a.sin())
    };
    let mut p = vec![Vec3::ZERO];
    p.extend((0..n).map(rim));
    let t = (0..n).map(|i| [0, 1 + (i + 1) % n, 1 + i]).collect();
    let (surface, positions) = refined(&scene(p, t, false), 2);
    let border: Vec<u32> =
        (0..surface.mate.len() as u32).filter(|h| surface.mate[*h as usize] == NONE).collect();
    assert_eq!(border.len(), 4 * n as usize);
    for h in border {
        let r = positions[surface.from(h) as usize].length();
        assert!((r - 1.0).abs() < 4e-3, "{r}");
    }
}

#[test]
fn a_rim_that_runs_along_a_sliver_folds_nothing_over() {
    // A flat fan from a far point to the rim of a hole; its outer triangles are tangent to the rim.
    let far = vec3(30.0, 0.0, 0.02);
    let rim = |k: i32| {
        let a = std::f32::consts::TAU * k as f32 / 96.0;
        vec3(a.cos(), 0.0, a.sin())
    };
    let mut p = vec![far];
    p.extend((-23..=24).map(rim));
    let t: Vec<[u32; 3]> = (1..48).map(|k| [0, k, k + 1]).collect();
    let up = |c: [Vec3; 3]| (c[1] - c[0]).cross(c[2] - c[0]).y;
    let sense = up(t[20].map(|v| p[v as usize])).signum();
    assert!(t.iter().all(|t| sense * up(t.map(|v| p[v as usize])) > 0.0));
    for levels in [1, 2] {
        let (surface, positions) = refined(&scene(p.clone(), t.clone(), false), levels);
        for f in &surface.faces[..surface.real_faces] {
            let [a, b, c] = f.map(|v| positions[v as usize]);
            let up = (b - a).cross(c - a).y;
            assert!(f64::from(sense) * up > 0.0, "{f:?} is folded over");
        }
    }
}

#[test]
fn triangles_there_twice_are_one_seen_from_both_sides() {
    let (p, mut t) = sheet(3, 0.0);
    let single = t.len();
    // The back has vertices of its own, and one triangle is there a third time.
    let mut positions = p.clone();
    positions.extend(&p);
    let base = p.len() as u32;
    t.extend(t.clone().iter().map(|[a, b, c]| [a + base, c + base, b + base]));
    t.push(t[0]);
    let s = surface(&scene(positions, t, false), &SMOOTH);
    assert_eq!(s.real_faces, single);
    assert_eq!(s.mate.iter().filter(|m| **m == NONE).count(), 12, "the rim alone is a border");
    assert!(s.sources.iter().all(|f| f.two_sided));
    assert!(s.notes.is_empty(), "{:?}", s.notes);
}

#[test]
fn visibility_agrees_with_a_finer_surface() {
    let (p, t) = torus(80, 40, 0.1);
    let scene = scene(p, t, false);
    let still = frame(&scene);
    let at = |i: usize| {
        let angle = 0.026 * i as f32;
        (still.clone(), view(vec3(4.0 * angle.sin(), 2.5, 4.0 * angle.cos())))
    };
    let reel = Reel { scene: &scene, count: 3, at: &at };
    let errors = check(&reel, &LinesKnobs::default(), &Run::default()).expect("nothing stops it");
    assert!(errors.visible > 1000.0, "{errors:?}");
    assert!(errors.hidden < 0.005 && errors.shown < 0.005 && errors.apart < 0.01, "{errors:?}");
    assert!(errors.flickers[0] <= 2.0 * errors.flickers[1] + 1.0, "{errors:?}");
}
