//! Poses of hand-built scenes against what a pencil gives.

use chiaro_basis::math::{Affine3A, DAffine3, DMat3, DQuat, DVec3, Mat4, Vec3, Vec4, dvec3, vec3};
use chiaro_scene::{
    Camera, Channel, Clip, Frame, Influences, Interpolation, Light, LightKind, MaterialId, Mesh,
    MeshId, Morph, Node, NodeId, NormalSource, Playback, Poser, Projection, Property, Remake,
    Scene, Skin, SkinId, Track, Transform,
};
use proptest::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

fn triangle() -> Mesh {
    Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        normals: NormalSource::Given(vec![Vec3::Z; 3]),
        triangles: vec![[0, 1, 2]],
        materials: vec![MaterialId::new(0)],
        ..Mesh::default()
    }
}

fn parts(translation: DVec3, rotation: DQuat, scale: DVec3) -> Transform {
    Transform::Parts { translation, rotation, scale }
}

fn moved(translation: DVec3) -> Transform {
    parts(translation, DQuat::IDENTITY, DVec3::ONE)
}

fn scaled(scale: DVec3) -> Transform {
    parts(DVec3::ZERO, DQuat::IDENTITY, scale)
}

fn node(parent: Option<usize>, transform: Transform, mesh: Option<usize>) -> Node {
    let (parent, mesh) = (parent.map(NodeId::new), mesh.map(MeshId::new));
    Node { parent, transform, mesh, ..Node::default() }
}

fn channel(node: usize, property: Property, width: usize, values: &[f32]) -> Channel {
    let times = (0..values.len() / width).map(|i| i as f32).collect();
    let interpolation = Interpolation::Linear;
    let track = Track { times, values: values.to_vec(), width, interpolation };
    Channel { node: NodeId::new(node), property, track }
}

fn clip(channels: Vec<Channel>) -> Clip {
    Clip { name: String::new(), channels }
}

fn at(scene: &Scene, time: f64) -> Frame {
    let clips = (0..scene.clips.len()).collect();
    scene.frame(time, &Playback { clips })
}

fn world(frame: &Frame, object: usize) -> Vec<Vec3> {
    frame.world_positions(&frame.objects[object]).collect()
}

#[track_caller]
fn assert_near(a: Vec3, b: Vec3) {
    assert!(a.distance(b) < 1e-6, "{a} is not {b}");
}

#[test]
fn a_turned_parent_moves_its_children() {
    let turn = parts(DVec3::X, DQuat::from_rotation_y(FRAC_PI_2), DVec3::ONE);
    let nodes = vec![node(None, turn, None), node(Some(0), turn, Some(0))];
    let scene = Scene { meshes: vec![triangle()], nodes, ..Scene::default() };
    let frame = at(&scene, 0.0);
    assert_near(frame.shapes[0].positions[0], vec3(1.0, 0.0, -1.0));
    assert_near(frame.shapes[0].positions[1], vec3(0.0, 0.0, -1.0));
    assert_near(frame.shapes[0].normals[0], Vec3::NEG_Z);
}

#[test]
fn clips_move_nodes_and_what_hangs_on_them() {
    let lift = channel(0, Property::Translation, 3, &[0.0, 0.0, 0.0, 0.0, 2.0, 0.0]);
    let grow = channel(1, Property::Scale, 3, &[1.0, 1.0, 1.0, 3.0, 1.0, 1.0]);
    let scene = Scene {
        meshes: vec![triangle()],
        nodes: vec![
            node(None, Transform::default(), None),
            node(Some(0), moved(DVec3::Z), Some(0)),
        ],
        clips: vec![clip(vec![lift, grow])],
        ..Scene::default()
    };
    assert_near(at(&scene, 0.5).shapes[0].positions[1], vec3(2.0, 1.0, 1.0));
    let rest = scene.frame(0.5, &Playback::still());
    assert_near(rest.shapes[0].positions[1], vec3(1.0, 0.0, 1.0));
}

#[test]
fn a_matrix_node_moves_like_its_parts() {
    let rotation = DQuat::from_rotation_z(0.7);
    let (scale, translation) = (dvec3(1.0, 2.0, 3.0), dvec3(4.0, 5.0, 6.0));
    let matrix = DAffine3::from_scale_rotation_translation(scale, rotation, translation);
    let pose = |transform| {
        let lift = channel(0, Property::Translation, 3, &[7.0, 8.0, 9.0]);
        let scene = Scene {
            meshes: vec![triangle()],
            nodes: vec![node(None, transform, Some(0))],
            clips: vec![clip(vec![lift])],
            ..Scene::default()
        };
        world(&at(&scene, 0.0), 0)
    };
    let want = pose(parts(translation, rotation, scale));
    for (got, want) in pose(Transform::Matrix(matrix)).into_iter().zip(want) {
        assert_near(got, want);
    }
}

/// A bar along y with a joint at 0 and one at 1, which is turned a quarter about z.
fn bent_bar(normals: NormalSource) -> Scene {
    let mesh = Mesh {
        positions: vec![Vec3::X, vec3(1.0, 1.0, 0.0), vec3(0.0, 2.0, 0.0)],
        normals,
        influences: Influences {
            joints: vec![vec![[0, 1, 0, 0]; 3]],
            weights: vec![vec![[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]],
        },
        ..triangle()
    };
    let quarter = parts(DVec3::Y, DQuat::from_rotation_z(FRAC_PI_2), DVec3::ONE);
    // The skinned node's own place does not count.
    let far = parts(dvec3(9.0, 9.0, 9.0), DQuat::from_rotation_x(1.0), DVec3::splat(-5.0));
    let shown = Node { skin: Some(SkinId::new(0)), ..node(None, far, Some(0)) };
    Scene {
        meshes: vec![mesh],
        nodes: vec![node(None, Transform::default(), None), node(Some(0), quarter, None), shown],
        skins: vec![Skin {
            joints: vec![NodeId::new(0), NodeId::new(1)],
            inverse_bind: vec![Mat4::IDENTITY, Mat4::from_translation(Vec3::NEG_Y)],
        }],
        ..Scene::default()
    }
}

#[test]
fn a_bar_of_two_joints_bends_as_computed_by_hand() {
    let frame = at(&bent_bar(NormalSource::Given(vec![Vec3::X; 3])), 0.0);
    let shape = &frame.shapes[0];
    assert_near(shape.positions[0], Vec3::X);
    assert_near(shape.positions[1], vec3(0.5, 1.5, 0.0));
    assert_near(shape.positions[2], vec3(-1.0, 1.0, 0.0));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert_near(shape.normals[0], Vec3::X);
    assert_near(shape.normals[1], vec3(half, half, 0.0));
    assert_near(shape.normals[2], Vec3::Y);
    assert!(!frame.objects[0].mirrored, "the node's mirror does not count");
    assert_eq!(frame.objects[0].world_from_shape, Affine3A::IDENTITY);
}

#[test]
fn normals_from_faces_follow_the_joints() {
    let frame = at(&bent_bar(NormalSource::Faces(vec![0, 1, 2])), 0.0);
    assert_near(frame.shapes[0].normals[2], Vec3::Z);
}

#[test]
fn a_skin_under_a_mirror_is_mirrored_with_its_normals_outside() {
    for normals in [NormalSource::Given(vec![Vec3::Z; 3]), NormalSource::Faces(vec![0, 1, 2])] {
        let mut scene = bent_bar(normals);
        scene.nodes[0].transform = scaled(dvec3(1.0, -1.0, 1.0));
        let frame = at(&scene, 0.0);
        assert!(frame.objects[0].mirrored);
        assert_near(frame.shapes[0].normals[2], Vec3::Z);
    }
}

#[test]
fn morphs_come_before_skins() {
    let mut scene = bent_bar(NormalSource::Given(vec![Vec3::X; 3]));
    let morph = Morph { positions: vec![Vec3::Y; 3], ..Morph::default() };
    scene.meshes[0].morphs = vec![morph];
    scene.nodes[2].weights = vec![2.0];
    // (0, 4, 0) is (0, 3, 0) in the joint's space, which a quarter turn lays along -x.
    assert_near(at(&scene, 0.0).shapes[0].positions[2], vec3(-3.0, 1.0, 0.0));
}

#[test]
fn morph_weights_add_positions_normals_and_tangents() {
    let morphs = vec![
        Morph { positions: vec![Vec3::Z; 3], ..Morph::default() },
        Morph {
            positions: vec![Vec3::X; 3],
            normals: vec![Vec3::X; 3],
            tangents: vec![Vec3::NEG_Z; 3],
        },
    ];
    let mesh = Mesh { morphs, tangents: vec![Vec4::new(1.0, 0.0, 0.0, -1.0); 3], ..triangle() };
    let weights = channel(0, Property::Weights, 2, &[0.0, 0.0, 2.0, 1.0]);
    let scene = Scene {
        meshes: vec![mesh],
        nodes: vec![node(None, Transform::default(), Some(0))],
        clips: vec![clip(vec![weights])],
        ..Scene::default()
    };
    let shape = &at(&scene, 1.0).shapes[0];
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert_near(shape.positions[0], vec3(1.0, 0.0, 2.0));
    assert_near(shape.normals[0], vec3(half, 0.0, half));
    assert_near(shape.tangents[0].truncate(), vec3(half, 0.0, -half));
    assert_eq!(shape.tangents[0].w, -1.0);
    assert_near(at(&scene, 0.5).shapes[0].positions[0], vec3(0.5, 0.0, 1.0));
    assert_near(at(&scene, 0.0).shapes[0].normals[0], Vec3::Z);
}

#[test]
fn normals_from_faces_follow_the_morphs() {
    let lean = Morph { positions: vec![Vec3::ZERO, Vec3::Z, Vec3::ZERO], ..Morph::default() };
    let mesh =
        Mesh { morphs: vec![lean], normals: NormalSource::Faces(vec![0, 1, 2]), ..triangle() };
    let shown = Node { weights: vec![1.0], ..node(None, Transform::default(), Some(0)) };
    let scene = Scene { meshes: vec![mesh], nodes: vec![shown], ..Scene::default() };
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert_near(at(&scene, 0.0).shapes[0].normals[0], vec3(-half, 0.0, half));
}

#[test]
fn mirrored_nodes_keep_their_normals_outside() {
    for normals in [NormalSource::Given(vec![Vec3::Z; 3]), NormalSource::Faces(vec![0, 1, 2])] {
        for copies in 1..3 {
            let mirror = node(None, scaled(dvec3(-1.0, 1.0, 1.0)), Some(0));
            let meshes = vec![Mesh { normals: normals.clone(), ..triangle() }];
            let scene = Scene { meshes, nodes: vec![mirror; copies], ..Scene::default() };
            let frame = at(&scene, 0.0);
            let object = &frame.objects[0];
            assert!(object.mirrored);
            assert_near(world(&frame, 0)[1], Vec3::NEG_X);
            assert_near(object.normal_from_shape() * frame.shapes[0].normals[0], Vec3::Z);
        }
    }
}

#[test]
fn two_mirrors_make_none() {
    let mirror = scaled(dvec3(-1.0, 1.0, 1.0));
    let nodes = vec![node(None, mirror, None), node(Some(0), mirror, Some(0))];
    let scene = Scene { meshes: vec![triangle()], nodes, ..Scene::default() };
    assert!(!at(&scene, 0.0).objects[0].mirrored);
}

#[test]
fn meshes_drawn_twice_share_a_shape_between_objects_and_frames() {
    let spin = channel(0, Property::Translation, 3, &[0.0, 0.0, 0.0, 5.0, 0.0, 0.0]);
    let scene = Scene {
        meshes: vec![triangle(), triangle()],
        nodes: vec![
            node(None, Transform::default(), Some(0)),
            node(None, moved(DVec3::Y), Some(0)),
            node(None, Transform::default(), Some(1)),
            node(Some(0), Transform::default(), Some(1)),
        ],
        clips: vec![clip(vec![spin])],
        ..Scene::default()
    };
    let poser = Poser::new(&scene);
    let frames = [0.0, 1.0].map(|t| poser.frame(t, &Playback { clips: vec![0] }));
    assert_eq!((frames[0].shapes.len(), frames[0].objects.len()), (2, 4));
    assert_near(world(&frames[1], 0)[1], vec3(6.0, 0.0, 0.0));
    assert_near(world(&frames[1], 1)[1], vec3(1.0, 1.0, 0.0));
    for shape in 0..2 {
        let [a, b] = frames.each_ref().map(|f| &f.shapes[shape]);
        assert!(Arc::ptr_eq(&a.positions, &b.positions) && Arc::ptr_eq(&a.normals, &b.normals));
    }
}

#[test]
fn what_stands_still_is_made_once_and_what_moves_is_not_shared() {
    let walk = channel(1, Property::Translation, 3, &[0.0, 0.0, 0.0, 5.0, 0.0, 0.0]);
    let scene = Scene {
        meshes: vec![triangle(), triangle()],
        nodes: vec![
            node(None, moved(DVec3::Y), Some(0)),
            node(None, Transform::default(), Some(1)),
        ],
        clips: vec![clip(vec![walk])],
        ..Scene::default()
    };
    let poser = Poser::new(&scene);
    let [a, b] = [0.0, 1.0].map(|t| poser.frame(t, &Playback { clips: vec![0] }));
    assert!(Arc::ptr_eq(&a.shapes[0].positions, &b.shapes[0].positions));
    assert_near(a.shapes[1].positions[0], Vec3::ZERO);
    assert_near(b.shapes[1].positions[0], vec3(5.0, 0.0, 0.0));
}

#[test]
fn weights_that_differ_or_move_keep_shapes_apart() {
    let morph = Morph { positions: vec![Vec3::Z; 3], ..Morph::default() };
    let shown = |w: f32| Node { weights: vec![w], ..node(None, Transform::default(), Some(0)) };
    let mut scene = Scene {
        meshes: vec![Mesh { morphs: vec![morph], ..triangle() }],
        nodes: vec![shown(0.5), shown(0.5), shown(1.0)],
        ..Scene::default()
    };
    let shapes =
        |scene: &Scene| -> Vec<usize> { at(scene, 0.0).objects.iter().map(|o| o.shape).collect() };
    assert_eq!(shapes(&scene), [0, 0, 1]);
    assert_near(world(&at(&scene, 0.0), 1)[0], vec3(0.0, 0.0, 0.5));
    scene.clips = vec![clip(vec![channel(1, Property::Weights, 1, &[0.0, 1.0])])];
    assert_eq!(shapes(&scene), [0, 1, 2]);
    assert_near(world(&at(&scene, 0.25), 1)[0], vec3(0.0, 0.0, 0.25));
}

#[test]
fn instances_stand_below_their_node() {
    let instances = vec![moved(DVec3::X), scaled(dvec3(2.0, -2.0, 2.0))];
    let shown = Node { instances, ..node(None, moved(DVec3::Y), Some(0)) };
    let scene = Scene { meshes: vec![triangle()], nodes: vec![shown], ..Scene::default() };
    let frame = at(&scene, 0.0);
    assert_eq!((frame.shapes.len(), frame.objects.len()), (1, 2));
    assert_near(world(&frame, 0)[2], vec3(1.0, 2.0, 0.0));
    assert_near(world(&frame, 1)[2], vec3(0.0, -1.0, 0.0));
    assert_eq!([0, 1].map(|i| frame.objects[i].mirrored), [false, true]);
}

#[test]
fn meshes_made_anew_are_made_at_the_frames_time() {
    let remake = |t: f64| Mesh { positions: vec![Vec3::X * t as f32; 3], ..triangle() };
    let mesh = Mesh { remake: Some(Remake(Arc::new(remake))), ..Mesh::default() };
    let scene = Scene {
        meshes: vec![mesh],
        nodes: vec![node(None, moved(DVec3::Y), Some(0))],
        ..Scene::default()
    };
    let frame = at(&scene, 2.5);
    let shape = &frame.shapes[0];
    assert_near(shape.positions[0], vec3(2.5, 1.0, 0.0));
    assert_eq!(shape.mesh_in(&scene).triangles.len(), 1);
    assert_eq!(shape.normals.len(), 3);
}

fn camera_at(transform: Transform) -> chiaro_scene::Pose {
    let projection = Projection::Perspective { fov_y: 1.0 };
    let camera = Camera { name: String::new(), node: NodeId::new(0), projection, aspect: None };
    let nodes = vec![node(None, transform, None)];
    at(&Scene { cameras: vec![camera], nodes, ..Scene::default() }, 0.0).cameras[0]
}

#[test]
fn cameras_look_along_minus_z_whatever_their_scale() {
    for scale in [DVec3::ONE, DVec3::splat(1e-12), dvec3(-2.0, 3.0, 5.0), dvec3(0.0, 1.0, 1.0)] {
        let place = dvec3(1.0, 2.0, 3.0);
        let pose = camera_at(parts(place, DQuat::from_rotation_y(FRAC_PI_2), scale));
        assert_near(pose.position, vec3(1.0, 2.0, 3.0));
        assert_near(pose.forward, Vec3::NEG_X);
        assert_near(pose.up, Vec3::Y);
        assert_near(pose.right, Vec3::NEG_Z);
    }
}

#[test]
fn degenerate_cameras_still_have_axes() {
    let shear = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Z);
    let matrices = [DMat3::ZERO, DMat3::from_diagonal(DVec3::NAN), shear];
    let matrices = matrices.map(|m| Transform::Matrix(DAffine3::from_mat3(m)));
    for transform in matrices.into_iter().chain([moved(DVec3::INFINITY)]) {
        let pose = camera_at(transform);
        assert!(pose.position.is_finite());
        assert_near(pose.right.cross(pose.forward), pose.up);
        for axis in [pose.right, pose.up, pose.forward] {
            assert!((axis.length() - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn lights_move_with_their_nodes() {
    let light = Light {
        name: String::new(),
        node: NodeId::new(1),
        kind: LightKind::Point,
        colour: [1.0; 3],
        intensity: 1.0,
        range: f32::INFINITY,
    };
    let nodes = vec![node(None, moved(DVec3::X), None), node(Some(0), moved(DVec3::Y), None)];
    let frame = at(&Scene { lights: vec![light], nodes, ..Scene::default() }, 0.0);
    assert_near(frame.lights[0].1.translation.into(), vec3(1.0, 1.0, 0.0));
}

#[test]
fn nothing_is_infinite_whatever_the_matrices() {
    let extremes = [0.0, 1e-30, 1e30, 1e300, f64::INFINITY, f64::NAN];
    for x in extremes {
        let mut scene = bent_bar(NormalSource::Given(vec![Vec3::X; 3]));
        scene.nodes[0].transform = scaled(dvec3(x, 1.0, -x));
        scene.nodes.push(node(Some(0), moved(DVec3::splat(x)), Some(1)));
        for _ in 0..2 {
            scene.nodes.push(node(Some(0), scaled(DVec3::splat(x)), Some(2)));
        }
        scene.meshes.extend([triangle(), triangle()]);
        let frame = at(&scene, 0.0);
        for (i, object) in frame.objects.iter().enumerate() {
            assert!(world(&frame, i).iter().all(|p| p.is_finite()), "{x}");
            let normals = &frame.shapes[object.shape].normals;
            assert!(normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5), "{x}: {normals:?}");
            assert!(object.normal_from_shape().is_finite(), "{x}");
        }
    }
}

/// A scene with a bit of everything, large enough to be cut into pieces.
fn fair() -> Scene {
    let n = 20_000;
    let random = |seed: u64, i: usize| chiaro_basis::random::unit(seed, i as u64);
    let point = |seed: u64, i: usize| {
        vec3(random(seed, 3 * i), random(seed, 3 * i + 1), random(seed, 3 * i + 2))
    };
    let mesh = Mesh {
        positions: (0..n).map(|i| point(1, i)).collect(),
        normals: NormalSource::Faces((0..n as u32).map(|i| i / 3).collect()),
        triangles: (0..n as u32 - 2).map(|i| [i, i + 1, i + 2]).collect(),
        materials: vec![MaterialId::new(0); n - 2],
        morphs: vec![Morph {
            positions: (0..n).map(|i| point(2, i)).collect(),
            ..Morph::default()
        }],
        influences: Influences {
            joints: vec![vec![[0, 1, 0, 0]; n]],
            weights: vec![(0..n).map(|i| [random(3, i), 1.0 - random(3, i), 0.0, 0.0]).collect()],
        },
        ..Mesh::default()
    };
    let mut scene = bent_bar(NormalSource::default());
    scene.meshes = vec![mesh];
    scene.nodes.push(node(Some(1), Transform::default(), Some(0)));
    let turn = [0.0, 0.0, 0.0, 1.0, 0.6, 0.0, 0.8, 0.0];
    let weights = |n| channel(n, Property::Weights, 1, &[0.0, 1.0]);
    let turning = channel(1, Property::Rotation, 4, &turn);
    scene.clips = vec![clip(vec![turning, weights(2), weights(3)])];
    scene
}

#[test]
fn frames_are_the_same_bits_for_any_threads_and_any_order() {
    let scene = fair();
    let playback = Playback { clips: vec![0] };
    let posed = |threads: usize, times: &[f64]| -> Vec<Vec<u32>> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let poser = Poser::new(&scene);
        let bits = |t: &f64| {
            let frame = poser.frame(*t, &playback);
            let shapes = frame.shapes.iter().flat_map(|s| s.positions.iter().chain(&*s.normals));
            shapes.flat_map(|v| v.to_array().map(f32::to_bits)).collect()
        };
        pool.install(|| times.iter().map(bits).collect())
    };
    let one = posed(1, &[0.25, 0.75]);
    assert_ne!(one[0], one[1], "the scene moves");
    assert_eq!(one, posed(2, &[0.25, 0.75]));
    let other = posed(5, &[0.75, 0.75, 0.25]);
    assert_eq!([&one[0], &one[1]], [&other[2], &other[1]]);
}

fn any_rotation() -> impl Strategy<Value = DQuat> {
    [-1.0..1.0f64, -1.0..1.0, -1.0..1.0, -1.0..1.0]
        .prop_filter("long enough", |q| q.iter().map(|x| x * x).sum::<f64>() > 0.01)
        .prop_map(|q| DQuat::from_array(q).normalize())
}

fn any_vector(limit: f64) -> impl Strategy<Value = DVec3> {
    [-limit..limit, -limit..limit, -limit..limit].prop_map(DVec3::from_array)
}

proptest! {
    #[test]
    fn a_quarter_turn_of_the_root_turns_everything_that_hangs_on_it(
        axis in any_rotation(),
        places in proptest::collection::vec((any_vector(5.0), any_rotation(), any_vector(2.0)), 1..5),
    ) {
        let quarter = axis * DQuat::from_rotation_x(FRAC_PI_2) * axis.inverse();
        let pose = |root: DQuat| {
            let mut nodes = vec![node(None, parts(DVec3::ZERO, root, DVec3::ONE), None)];
            for (i, (t, r, s)) in places.iter().enumerate() {
                nodes.push(node(Some(i), parts(*t, *r, *s), Some(i)));
            }
            let meshes = vec![triangle(); places.len()];
            at(&Scene { meshes, nodes, ..Scene::default() }, 0.0)
        };
        let (before, after) = (pose(DQuat::IDENTITY), pose(quarter));
        for (i, (a, b)) in before.shapes.iter().zip(&after.shapes).enumerate() {
            for (a, b) in a.positions.iter().zip(&*b.positions) {
                let want = (quarter * a.as_dvec3()).as_vec3();
                prop_assert!(b.distance(want) < 1e-5 * (1.0 + want.length()), "node {i}");
            }
            prop_assert_eq!(before.objects[i].mirrored, after.objects[i].mirrored);
        }
    }

    #[test]
    fn drawn_once_or_twice_a_mesh_is_at_the_same_place(
        t in any_vector(5.0), r in any_rotation(), s in any_vector(2.0),
    ) {
        let shown = node(None, parts(t, r, s), Some(0));
        let pose = |copies: usize| {
            let nodes = vec![shown.clone(); copies];
            at(&Scene { meshes: vec![triangle()], nodes, ..Scene::default() }, 0.0)
        };
        let (once, twice) = (pose(1), pose(2));
        for (a, b) in world(&once, 0).into_iter().zip(world(&twice, 1)) {
            prop_assert!(a.distance(b) < 1e-5);
        }
        let shared = &twice.objects[1];
        let normal = (shared.normal_from_shape() * twice.shapes[0].normals[0]).normalize();
        prop_assert!(normal.distance(once.shapes[0].normals[0]) < 1e-4);
    }
}
