//! Row L6: errors of visibility against a surface 16 times finer.
//!
//! `cargo bench -p chiaro-lines --bench visibility` draws dented tori from the same formula with
//! 200 x 100 and with 800 x 400 quads, from several views, and prints two shares of the visible line:
//! what is wrongly hidden (visible on the fine surface, no visible line within 3 px on the coarse
//! one) and what is wrongly shown.

#![allow(clippy::print_stdout)]

#[path = "../tests/meshes/mod.rs"]
mod meshes;

use chiaro_basis::Run;
use chiaro_basis::math::{Vec3, vec3};
use chiaro_lines::{Film, LinesKnobs, Reel, Stroke, View, distance};
use chiaro_scene::{Pose, Projection};

/// Lines further apart than this are not the same, pixels.
const APART: f64 = 3.0;

fn main() {
    for dents in [0.0, 0.1, 0.25] {
        let (mut hidden, mut shown, mut length) = (0.0, 0.0, 0.0);
        for k in 0..12 {
            let angle = 0.5 * k as f32;
            let from = vec3(angle.sin() * 4.0, 0.8 + 0.3 * k as f32, angle.cos() * 4.0);
            let coarse = strokes(200, 100, dents, from);
            let fine = strokes(800, 400, dents, from);
            hidden += unmatched(&fine, &coarse);
            shown += unmatched(&coarse, &fine);
            length += fine.iter().map(Stroke::total).sum::<f64>();
        }
        println!(
            "torus, dents {dents}: wrongly hidden {:.3} %, wrongly shown {:.3} % of {length:.0} px",
            100.0 * hidden / length,
            100.0 * shown / length
        );
    }
}

fn strokes(n: u32, m: u32, dents: f32, from: Vec3) -> Vec<Stroke> {
    let (positions, triangles) = meshes::torus(n, m, dents);
    let scene = meshes::scene(positions, triangles, false);
    let frame = meshes::frame(&scene);
    let projection = Projection::Perspective { fov_y: 0.8 };
    let view = View::new(Pose::look_at(from, Vec3::ZERO, Vec3::Y, projection), (960, 540));
    let at = |_: usize| (frame.clone(), view);
    let reel = Reel { scene: &scene, count: 1, at: &at };
    let mut film =
        Film::of(&reel, &LinesKnobs::default(), &Run::default()).expect("nothing stops it");
    film.frames.pop().map(|f| f.strokes).unwrap_or_default()
}

/// Length of lines that none of `others` is near.
fn unmatched(lines: &[Stroke], others: &[Stroke]) -> f64 {
    let alone = |s: &Stroke| {
        let far = |at| others.iter().all(|o| distance(o, at) > APART);
        let count = s.samples.iter().filter(|p| far(p.at)).count();
        s.total() * count as f64 / s.samples.len() as f64
    };
    lines.iter().map(alone).sum()
}
