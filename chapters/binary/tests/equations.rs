//! Each equation of the chapter on pictures whose answer is known.

use chiaro_basis::math::{Vec3, vec3};
use chiaro_binary::{
    BinaryKnobs, Channel, Channels, CurvatureForm, DepthForm, Exposure, Graph, Model, View, angle,
    depth_step, local_contrast, neighbour_factors, terminal,
};
use chiaro_image::Plane;
use chiaro_scene::{Pose, Projection};
use chiaro_trace::GBuffer;

/// A buffer of one object over the whole picture, from a position and a normal a pixel.
fn buffer(
    (width, height): (usize, usize),
    surface: impl Fn(f32, f32) -> Option<(Vec3, Vec3)> + Sync,
) -> GBuffer {
    let projection = Projection::Orthographic { half_height: 0.5 * height as f32 };
    let eye = vec3(0.0, 0.0, 100.0);
    let pose = Pose::look_at(eye, Vec3::ZERO, Vec3::Y, projection);
    let at = |x: usize, y: usize| {
        surface(x as f32 + 0.5 - 0.5 * width as f32, 0.5 * height as f32 - y as f32 - 0.5)
    };
    let covered = Plane::from_fn(width, height, |x, y| at(x, y).is_some());
    let part = |f: &(dyn Fn((Vec3, Vec3)) -> [f32; 3] + Sync)| {
        Plane::from_fn(width, height, |x, y| at(x, y).map(f).unwrap_or_default())
    };
    let normal = part(&|s| s.1.to_array());
    GBuffer {
        pose,
        radius: 0.5 * (width as f32).hypot(height as f32),
        face: Plane::filled(width, height, 0),
        barycentric: Plane::filled(width, height, [0.0; 2]),
        depth: Plane::from_fn(width, height, |x, y| at(x, y).map_or(0.0, |s| 100.0 - s.0.z)),
        position: part(&|s| s.0.to_array()),
        smooth_normal: normal.clone(),
        geometric_normal: normal.clone(),
        normal,
        object: covered.map(|c| u32::from(*c)),
        material: covered.map(|c| u32::from(*c)),
        base_colour: Plane::filled(width, height, [0.5; 3]),
        roughness: Plane::filled(width, height, 1.0),
        metallic: Plane::filled(width, height, 0.0),
        emissive: Plane::filled(width, height, [0.0; 3]),
        covered,
    }
}

fn sphere(radius: f32) -> GBuffer {
    let side = (2.0 * radius) as usize + 8;
    buffer((side, side), move |x, y| {
        let z2 = radius * radius - x * x - y * y;
        (z2 > 0.0).then(|| {
            let p = vec3(x, y, z2.sqrt());
            (p, p / radius)
        })
    })
}

fn roof(degrees: f32) -> GBuffer {
    let slope = (0.5 * degrees.to_radians()).tan();
    buffer((64, 64), move |x, y| {
        Some((vec3(x, y, -slope * x.abs()), vec3(slope * x.signum(), 0.0, 1.0).normalize()))
    })
}

#[test]
fn the_thesis_sum_is_w_times_tone_minus_b_times_shade() {
    let tone = Plane::from_fn(8, 1, |x, _| x as f32 / 7.0);
    let flat = buffer((8, 1), |x, y| Some((vec3(x, y, 0.0), Vec3::Z)));
    let knobs = BinaryKnobs {
        model: Model::Thesis,
        diffuse_w: 1.5,
        diffuse_b: 0.5,
        diffuse_g: 1.0,
        ..BinaryKnobs::default()
    };
    let view = View { buffer: flat, channels: Channels::single(Channel::Diffuse, tone.clone()) };
    let difference = terminal(&view, &Exposure::default(), &knobs);
    for (a, d) in tone.pixels().iter().zip(difference.pixels()) {
        assert!((d - (1.5 * a - 0.5 * (1.0 - a))).abs() < 1e-6);
    }
    // With g = 0 only the sign of the local contrast counts.
    let local = BinaryKnobs { diffuse_g: 0.0, diffuse_w: 1.0, diffuse_b: 1.0, ..knobs };
    let difference = terminal(&view, &Exposure::default(), &local);
    assert!(difference[(0, 0)] < 0.0 && difference[(7, 0)] > 0.0);
}

#[test]
fn raising_w_whitens_monotonically() {
    let tone = Plane::from_fn(40, 40, |x, y| ((x * 7 + y * 13) % 40) as f32 / 40.0);
    let covered = Plane::filled(40, 40, true);
    let flat = buffer((40, 40), |x, y| Some((vec3(x, y, 0.0), Vec3::Z)));
    let view = View { buffer: flat, channels: Channels::single(Channel::Diffuse, tone) };
    let mut before = Plane::filled(40, 40, false);
    for w in [0.2, 0.4, 0.6, 0.8, 1.2] {
        let knobs = BinaryKnobs {
            model: Model::Thesis,
            diffuse_w: w,
            diffuse_b: 0.5,
            ..BinaryKnobs::default()
        };
        let difference = terminal(&view, &Exposure::default(), &knobs);
        let factors = neighbour_factors(&view.buffer, &knobs);
        let labels = Graph::new(&covered, &difference, &factors, &knobs).solve().unwrap();
        assert_eq!(labels.flow, labels.cut);
        let pairs = before.pixels().iter().zip(labels.white.pixels());
        assert!(pairs.clone().all(|(a, b)| !a | b), "what was white stays white at w = {w}");
        before = labels.white;
    }
}

#[test]
fn local_contrast_of_a_constant_is_nothing() {
    let covered =
        Plane::from_fn(50, 30, |x, y| (x as i32 - 20).pow(2) + (y as i32 - 15).pow(2) < 150);
    let plane = covered.map(|c| if *c { 0.7 } else { 0.0 });
    let local = local_contrast(&plane, &covered, 16.0);
    let worst = local.pixels().iter().zip(covered.pixels()).filter(|(_, c)| **c);
    assert!(worst.map(|(d, _)| d.abs()).fold(0.0, f32::max) < 1e-5);
}

#[test]
fn angles_are_exact_when_small_and_when_opposite() {
    for a in [1e-5f32, 1e-3, 0.1, 1.0, 3.0] {
        let b = vec3(a.sin(), 0.0, a.cos());
        assert!((angle(Vec3::Z, b) / a - 1.0).abs() < 1e-2, "{a}: {}", angle(Vec3::Z, b));
    }
    assert!((angle(Vec3::Z, -Vec3::Z) - std::f32::consts::PI).abs() < 1e-6);
    assert_eq!(angle(Vec3::Z, Vec3::Z), 0.0);
}

#[test]
fn a_featureless_sphere_has_no_features() {
    for form in [CurvatureForm::Fast, CurvatureForm::Exact] {
        let knobs = BinaryKnobs { curvature_form: form, floor: 0.0, ..BinaryKnobs::default() };
        for radius in [20.0, 40.0, 90.0] {
            let ball = sphere(radius);
            let middle = ball.size().0 / 2;
            let factor = neighbour_factors(&ball, &knobs)[(middle, middle)];
            assert!(factor.iter().all(|f| *f > 0.95), "{form:?}, radius {radius}: {factor:?}");
        }
    }
}

#[test]
fn a_crease_is_a_feature() {
    for form in [CurvatureForm::Fast, CurvatureForm::Exact] {
        let knobs = BinaryKnobs { curvature_form: form, floor: 0.0, ..BinaryKnobs::default() };
        let factors = neighbour_factors(&roof(30.0), &knobs);
        assert!(factors[(31, 32)][0] < 0.1, "{form:?}: across {}", factors[(31, 32)][0]);
        assert!(factors[(10, 32)][0] > 0.95, "{form:?}: beside {}", factors[(10, 32)][0]);
    }
}

#[test]
fn a_slanted_floor_has_no_depth_steps() {
    let n = vec3(0.0, 4.0, 1.0).normalize();
    let floor = buffer((32, 32), move |x, y| Some((vec3(x, y, -4.0 * y), n)));
    assert!(depth_step(&floor, (5, 5), (5, 6), DepthForm::Plane) < 1e-3);
    assert!(depth_step(&floor, (5, 5), (5, 6), DepthForm::Raw) > 3.0);
}

#[test]
fn geometry_lowers_weights_only_at_features() {
    let step =
        buffer((32, 32), |x, y| Some((vec3(x, y, if x < 0.0 { 0.0 } else { 8.0 }), Vec3::Z)));
    let knobs = BinaryKnobs::default();
    let factors = neighbour_factors(&step, &knobs);
    assert!((factors[(15, 10)][0] - knobs.floor).abs() < 1e-3);
    assert!(factors[(8, 10)][0] > 0.99);
    assert_eq!(factors[(31, 10)][0], 0.0, "an edge that leaves the picture");
    let plain = BinaryKnobs { use_geometry: false, ..knobs };
    assert_eq!(neighbour_factors(&step, &plain)[(15, 10)][0], 1.0);
}
