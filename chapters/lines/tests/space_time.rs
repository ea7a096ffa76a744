//! The space-time surface: its slices are the zero sets of the frames, and its Euler characteristic
//! is that of an independent construction.

mod meshes;

use chiaro_basis::math::{Vec3, vec3};
use chiaro_basis::random;
use chiaro_lines::surface::NONE;
use chiaro_lines::track::{EventKind, Interval, Kinetic, Order};
use chiaro_lines::{Posed, Slice, Surface};
use meshes::*;
use std::collections::BTreeSet;

/// The Euler characteristic of the isosurface in mesh x interval, each prism cut into three
/// tetrahedra so that lower vertices go through time before higher ones: crossed edges - crossed triangles + crossed tetrahedra.
fn chi_of_prisms(s: &Surface, before: &[f64], after: &[f64]) -> i64 {
    let side = |v: (u32, bool)| if v.1 { after[v.0 as usize] } else { before[v.0 as usize] } >= 0.0;
    let mut cells: [BTreeSet<Vec<(u32, bool)>>; 3] = Default::default();
    for face in &s.faces {
        let mut f = *face;
        f.sort_unstable();
        let [a, b, c] = f;
        let tetrahedra = [
            [(c, false), (b, false), (a, false), (a, true)],
            [(c, false), (b, false), (b, true), (a, true)],
            [(c, false), (c, true), (b, true), (a, true)],
        ];
        for t in tetrahedra {
            for mask in 1u32..16 {
                let mut cell: Vec<(u32, bool)> =
                    (0..4).filter(|i| mask >> i & 1 == 1).map(|i| t[i]).collect();
                let crossed = cell.iter().any(|v| side(*v)) && cell.iter().any(|v| !side(*v));
                if cell.len() >= 2 && crossed {
                    cell.sort_unstable();
                    cells[cell.len() - 2].insert(cell);
                }
            }
        }
    }
    cells[0].len() as i64 - cells[1].len() as i64 + cells[2].len() as i64
}

fn noise(s: &Surface, seed: u64) -> Vec<f64> {
    (0..s.anchors.len()).map(|v| f64::from(random::unit(seed, v as u64)) - 0.5).collect()
}

fn step(s: &Surface, a: &[f64], b: &[f64], order: Order) -> (Interval, Slice, Slice, Vec<bool>) {
    let (first, second) = (Slice::of(s, a), Slice::of(s, b));
    let mut kinetic = Kinetic::new(s, a, &first, 0);
    let interval = kinetic.step(a, b, [&first, &second], order);
    let sides = kinetic.sides().to_vec();
    // Every chain of the later slice has one label, and no two share one.
    let mut labels = BTreeSet::new();
    for chain in &second.chains {
        let of: BTreeSet<u32> = chain.of(&second).iter().map(|c| kinetic.label(c.edge)).collect();
        assert_eq!(of.len(), 1);
        assert!(labels.insert(of.into_iter().next()), "a label twice");
    }
    (interval, first, second, sides)
}

fn open_arcs(slice: &Slice) -> i64 {
    slice.chains.iter().filter(|c| !c.closed).count() as i64
}

fn surfaces() -> Vec<Surface> {
    let (p, t) = torus(9, 7, 0.2);
    let (q, u) = sheet(6, 0.2);
    let (c, w) = cube();
    let (f, x) = torus(7, 5, 0.2);
    vec![
        faceted(&soup(&f, &x, true), 0),
        surface(&scene(p, t, false), &SMOOTH),
        surface(&scene(q, u, false), &SMOOTH),
        surface(&scene(c, w, true), &SHARP),
    ]
}

#[test]
fn flips_change_the_euler_characteristic_as_the_prisms_say() {
    for s in surfaces() {
        for seed in 0..40 {
            let (a, b) = (noise(&s, seed), noise(&s, seed + 1000));
            let (interval, first, _, _) = step(&s, &a, &b, Order::Vertex);
            assert_eq!(open_arcs(&first) + interval.euler, chi_of_prisms(&s, &a, &b), "{seed}");
        }
    }
}

#[test]
fn on_closed_surfaces_births_and_deaths_less_saddles_are_the_characteristic() {
    let (p, t) = torus(12, 9, 0.2);
    let s = surface(&scene(p, t, false), &SMOOTH);
    for seed in 0..40 {
        for order in [Order::Time, Order::Vertex] {
            let (a, b) = (noise(&s, seed), noise(&s, seed + 1000));
            let (interval, ..) = step(&s, &a, &b, order);
            let worth = |e: &chiaro_lines::track::Event| match e.kind {
                EventKind::Saddle => 1 - i64::from(e.arcs),
                _ => 1,
            };
            assert_eq!(interval.events.iter().map(worth).sum::<i64>(), interval.euler);
        }
    }
}

#[test]
fn states_are_the_frames_and_correspondence_stays_on_lines() {
    for s in surfaces() {
        for seed in 0..20 {
            let (a, b) = (noise(&s, seed), noise(&s, seed + 1000));
            let (interval, first, second, sides) = step(&s, &a, &b, Order::Time);
            assert!(sides.iter().zip(&b).all(|(side, v)| *side == (*v >= 0.0)));
            assert_eq!(interval.forward.len(), first.crossings.len());
            let inside = |j: &u32| *j == NONE || (*j as usize) < second.crossings.len();
            assert!(interval.forward.iter().all(inside));
            for (k, j) in interval.forward.iter().enumerate() {
                let kept = second.crossings.iter().position(|c| c.edge == first.crossings[k].edge);
                let ends = s.ends(first.crossings[k].edge);
                let still = ends.iter().all(|&v| (a[v as usize] >= 0.0) == (b[v as usize] >= 0.0));
                if still {
                    assert_eq!(kept, Some(*j as usize), "an edge that nothing touched is itself");
                }
            }
        }
    }
}

/// Events of a turn by `degrees` in `steps` frames.
fn events(
    s: &Surface,
    scene: &chiaro_scene::Scene,
    axis: Vec3,
    (steps, degrees): (u32, f32),
) -> Vec<EventKind> {
    let still = frame(scene);
    let view = flat_view(vec3(0.0, 0.0, 8.0));
    let g = |i: u32| {
        let angle = degrees * i as f32 / steps as f32;
        Posed::new(s, &turned(&still, axis, angle), 0).facing(&view)
    };
    let mut before = g(0);
    let mut slice = Slice::of(s, &before);
    let mut kinetic = Kinetic::new(s, &before, &slice, 0);
    let mut kinds = Vec::new();
    for i in 1..=steps {
        let (after, later) = (g(i), Slice::of(s, &g(i)));
        let interval = kinetic.step(&before, &after, [&slice, &later], Order::Time);
        kinds.extend(interval.events.iter().map(|e| e.kind));
        (before, slice) = (after, later);
    }
    kinds
}

#[test]
fn symmetric_solids_have_no_invented_events() {
    // A convex solid has one silhouette at all times.
    let (p, t) = cube();
    let scene = scene(p, t, true);
    for rule in [SHARP, SMOOTH] {
        let s = surface(&scene, &rule);
        let kinds = events(&s, &scene, Vec3::Y, (40, 90.0));
        let saddles = kinds.iter().filter(|k| **k == EventKind::Saddle).count();
        assert!(saddles <= 4, "{rule:?}: {kinds:?}");
    }
}

#[test]
fn a_torus_that_turns_to_edge_on_loses_a_loop_at_most() {
    let (p, t) = torus(60, 40, 0.0);
    let scene = scene(p, t, false);
    let s = surface(&scene, &SMOOTH);
    let kinds = events(&s, &scene, vec3(1.0, 0.2, 0.1), (40, 60.0));
    assert!(kinds.len() <= 8, "{kinds:?}");
}
