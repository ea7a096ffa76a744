//! Single solids: torus, bumpy torus, peanut, golf ball.
//!
//! Each is one closed surface, turning so that after two seconds it looks as at first.

use super::motion::turning;
use super::shape::{Form, ball, pointed, wrapped};
use super::stage::{Stage, moved, placed};
use crate::{Scene, Transform};
use chiaro_basis::math::{DQuat, DVec3, Vec3, vec3};
use std::f32::consts::{PI, TAU};
use std::f64::consts::PI as HALF_TURN;

/// A smooth ring that tumbles by half a turn.
pub(super) fn torus() -> Scene {
    let mut stage = Stage::default();
    let clay = stage.material("enamel", 0xc65a3a, 0.45, 0.0);
    let form = wrapped(256, 96, |u, v| ring(u, v, 0.4));
    let stand = stage.joint("stand", None, tilted(0.45, 0.25));
    let node = stage.thing("torus", Some(stand), moved(0.0, 0.0, 0.0), (form, clay));
    stage.animate(node, turning(|t| DQuat::from_rotation_x(HALF_TURN * t)));
    stage.finish()
}

/// A ring of 20 000 vertices whose bumps repeat five times round: it turns by 1.5 degrees a frame
/// and looks the same after 48.
pub(super) fn bumpy_torus() -> Scene {
    let mut stage = Stage::default();
    let clay = stage.matt("clay", 0xb9803f);
    let form = wrapped(200, 100, |u, v| ring(u, v, 0.40 * (1.0 + bumps(u, v))));
    let stand = stage.joint("stand", None, tilted(0.85, 0.3));
    let node = stage.thing("bumpy-torus", Some(stand), moved(0.0, 0.0, 0.0), (form, clay));
    stage.animate(node, turning(|t| DQuat::from_rotation_y(72f64.to_radians() * t)));
    stage.finish()
}

/// A point of a ring of radius 1 about the y axis, its tube of radius `tube`.
fn ring(u: f32, v: f32, tube: f32) -> Vec3 {
    let ((su, cu), (sv, cv)) = ((TAU * u).sin_cos(), (TAU * v).sin_cos());
    vec3((1.0 + tube * cv) * cu, tube * sv, (1.0 + tube * cv) * su)
}

/// Swellings and dents, the same in each fifth of the ring, in parts of the tube's radius.
fn bumps(u: f32, v: f32) -> f32 {
    // Place in a fifth of the ring, place round the tube, width, height.
    const SPOTS: [[f32; 4]; 11] = [
        [0.05, 0.02, 0.34, 0.30],
        [0.40, 0.10, 0.24, -0.20],
        [0.62, 0.94, 0.30, 0.26],
        [0.20, 0.22, 0.24, 0.22],
        [0.70, 0.26, 0.32, 0.30],
        [0.45, 0.40, 0.22, 0.20],
        [0.00, 0.48, 0.20, 0.16],
        [0.75, 0.58, 0.20, -0.14],
        [0.30, 0.64, 0.26, 0.24],
        [0.88, 0.78, 0.30, 0.28],
        [0.38, 0.84, 0.22, 0.18],
    ];
    let here = ring(u, v, 0.42);
    let spot = |fifth: usize, [along, round, width, height]: [f32; 4]| {
        let there = ring((fifth as f32 + along) / 5.0, round, 0.42);
        1.2 * height * (-here.distance_squared(there) / (0.6 * width * width)).exp()
    };
    (0..5).flat_map(|fifth| SPOTS.map(|s| spot(fifth, s))).sum()
}

/// A bent figure of revolution with a waist; half a turn about the vertical maps it on itself.
pub(super) fn peanut() -> Scene {
    let mut stage = Stage::default();
    let shell = stage.matt("shell", 0xc9a066);
    let node = stage.thing("peanut", None, moved(0.0, 0.0, 0.0), (peanut_form(192, 144), shell));
    let lean = DQuat::from_rotation_x(0.35);
    stage.animate(node, turning(|t| lean * DQuat::from_rotation_y(HALF_TURN * (t + 0.12))));
    stage.finish()
}

pub(super) fn peanut_form(around: usize, along: usize) -> Form {
    pointed(around, along, |u, v| {
        // Cassini's oval with a = 0.91 b, turned about the x axis.
        let (sin, cos) = (PI * v).sin_cos();
        let (double_sin, double_cos) = (2.0 * PI * v).sin_cos();
        let a = 0.91f32.powi(2);
        let r = (a * double_cos + (1.0 - (a * double_sin).powi(2)).sqrt()).sqrt();
        let (x, y) = (-r * cos, r * sin);
        let (s, c) = (TAU * u).sin_cos();
        vec3(x, y * c - 0.07 * x * x + 0.06, y * s)
    })
}

/// A ball with 362 dimples in the surface itself, laid out as an icosahedron: a fifth of a turn
/// about one of its corners maps it on itself.
pub(super) fn golf_ball() -> Scene {
    let mut stage = Stage::default();
    let white = stage.material("lacquer", 0xf4f2ea, 0.25, 0.0);
    let node = stage.thing("golf-ball", None, moved(0.0, 0.0, 0.0), (golf_ball_form(72), white));
    let axis = ball(1).positions[0].as_dvec3().normalize();
    let stand = DQuat::from_rotation_arc(axis, DVec3::new(0.3, 1.0, 0.2).normalize());
    let spin = |t: f64| DQuat::from_axis_angle(axis, 0.2 * std::f64::consts::TAU * t);
    stage.animate(node, turning(|t| stand * spin(t)));
    stage.finish()
}

/// The unit ball with dimples: caps with rounded rims about the vertices of a coarser ball.
pub(super) fn golf_ball_form(pieces: usize) -> Form {
    let centres = ball(6).positions;
    let spacing = (4.0 * PI / centres.len() as f32).sqrt();
    let dent = |p: Vec3| {
        let near = centres.iter().map(|c| p.distance_squared(*c)).fold(f32::INFINITY, f32::min);
        let bowl = 1.0 - near / (0.47 * spacing).powi(2);
        0.014 * (bowl + (bowl * bowl + 0.008).sqrt())
    };
    ball(pieces).swollen(|p, _| -dent(p))
}

/// Leaning by `x` and `z` radians.
fn tilted(x: f64, z: f64) -> Transform {
    placed(DVec3::ZERO, DQuat::from_rotation_x(x) * DQuat::from_rotation_z(z), 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::Quat;

    /// Whether a rotation maps the vertices on themselves, within a thousandth.
    fn symmetric(form: &Form, turn: Quat) -> bool {
        let cell = |p: Vec3| (p * 200.0).floor().to_array().map(|x| x as i32);
        let mut grid = std::collections::BTreeMap::<[i32; 3], Vec<Vec3>>::new();
        form.positions.iter().for_each(|&p| grid.entry(cell(p)).or_default().push(p));
        let near = |q: Vec3| {
            let c = cell(q);
            (0..27).any(|k| {
                let key = [c[0] + k % 3 - 1, c[1] + k / 3 % 3 - 1, c[2] + k / 9 - 1];
                grid.get(&key).is_some_and(|l| l.iter().any(|p| p.distance(q) < 1e-3))
            })
        };
        form.positions.iter().step_by(7).all(|&p| near(turn * p))
    }

    fn form_of(scene: Scene) -> Form {
        let mesh = scene.meshes.into_iter().next().unwrap();
        Form { positions: mesh.positions, normals: Vec::new(), triangles: mesh.triangles }
    }

    #[test]
    fn a_loop_ends_with_the_picture_it_began_with() {
        let fifth = TAU / 5.0;
        let axis = ball(1).positions[0];
        assert!(symmetric(&form_of(torus()), Quat::from_rotation_x(PI)));
        assert!(symmetric(&form_of(bumpy_torus()), Quat::from_rotation_y(fifth)));
        assert!(symmetric(&form_of(peanut()), Quat::from_rotation_y(PI)));
        assert!(symmetric(&form_of(golf_ball()), Quat::from_axis_angle(axis, fifth)));
        assert!(!symmetric(&form_of(bumpy_torus()), Quat::from_rotation_y(0.5 * fifth)));
    }

    #[test]
    fn the_bumpy_torus_has_twenty_thousand_vertices() {
        assert_eq!(form_of(bumpy_torus()).positions.len(), 20_000);
    }
}
