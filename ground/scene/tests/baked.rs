//! Positions of animated files, as another program baked them: one that shares no code with this
//! one, reads the files by itself, works in double precision throughout, and plays the same clips.
//! Skipped, with a message, where the data is not there.

use chiaro_basis::math::Vec3;
use chiaro_basis::{Error, Result};
use chiaro_scene::load::{Budget, Door, Source, Up, read_scene};
use chiaro_scene::{Choice, Frame, Playback, Scene};
use std::path::{Path, PathBuf};

/// File, seconds, node, corner of its triangles in the order of the file, position.
type Corner = (&'static str, f64, &'static str, usize, [f32; 3]);

/// The corners that have moved farthest, of the nodes that have moved farthest.
const CORNERS: &[Corner] = &[
    ("anim/CesiumMan/CesiumMan.gltf", 0.3, "", 30, [0.107803, 0.505183, 0.286342]),
    ("anim/CesiumMan/CesiumMan.gltf", 1.234, "", 30, [0.225447, 0.494126, 0.212786]),
    ("anim/Fox.glb", 0.3, "fox", 56, [-0.806536, 13.1189, -83.6458]),
    ("anim/Fox.glb", 1.234, "fox", 8, [25.5976, 50.3764, 55.3903]),
    ("anim/RiggedFigure/RiggedFigure.gltf", 0.3, "", 284, [0.329684, 0.561617, 0.184782]),
    ("anim/RiggedFigure/RiggedFigure.gltf", 1.234, "", 284, [0.570060, 0.755952, 0.149216]),
    ("anim/robot.glb", 0.3, "Head", 107, [-0.0865083, 4.44544, 0.740416]),
    ("anim/robot.glb", 0.3, "Torso", 1052, [0.0, 2.87821, 0.419990]),
    ("anim/robot.glb", 0.3, "Hand.R", 571, [-1.09846, 0.0639754, 0.624851]),
    ("anim/robot.glb", 1.234, "Hand.L", 416, [1.07460, 0.698817, -0.551605]),
    ("anim/robot.glb", 1.234, "Hand.R", 422, [-0.991948, 0.648709, -0.0693149]),
    ("anim/robot.glb", 1.234, "Arm.L", 87, [1.30719, 2.43592, -0.0679075]),
    ("anim/Knight.glb", 0.3, "2H_Sword", 888, [-0.769216, 3.01608, 0.438162]),
    ("anim/Knight.glb", 0.3, "1H_Sword", 602, [-0.685851, 2.46780, 0.418194]),
    ("anim/Knight.glb", 0.3, "Knight_ArmRight", 139, [-0.488857, 1.12926, 0.432184]),
    ("anim/Knight.glb", 1.234, "Knight_Body", 0, [-0.0743398, 0.625920, 0.303163]),
    ("anim/Knight.glb", 1.234, "Knight_Head", 0, [-0.117521, 1.21418, 0.215146]),
    ("anim/Knight.glb", 1.234, "Knight_ArmRight", 0, [-0.435837, 1.06128, -0.0734653]),
    (
        "anim/AnimatedMorphSphere/AnimatedMorphSphere.gltf",
        0.3,
        "AnimatedMorphSphere",
        1878,
        [-0.519744, 0.831470, 0.308658],
    ),
    (
        "anim/AnimatedMorphSphere/AnimatedMorphSphere.gltf",
        1.234,
        "AnimatedMorphSphere",
        1878,
        [-1.08521, 0.831470, 0.308658],
    ),
    ("anim/MorphStressTest.gltf", 0.3, "Main", 37, [-1.70248, 0.999570, 0.250000]),
    ("anim/MorphStressTest.gltf", 1.234, "Main", 937, [-1.17601, 0.470114, 0.250000]),
    (
        "anim/InterpolationTest/InterpolationTest.gltf",
        0.3,
        "Cube.008",
        0,
        [2.30518, 10.3573, 1.00000],
    ),
    (
        "anim/InterpolationTest/InterpolationTest.gltf",
        0.3,
        "Cube.009",
        0,
        [-4.29758, 10.0539, 1.00000],
    ),
    (
        "anim/InterpolationTest/InterpolationTest.gltf",
        0.3,
        "Cube.004",
        0,
        [3.15199, 4.75873, 1.00000],
    ),
    (
        "anim/InterpolationTest/InterpolationTest.gltf",
        1.234,
        "Cube.008",
        0,
        [2.30518, 10.9828, 1.00000],
    ),
    (
        "anim/InterpolationTest/InterpolationTest.gltf",
        1.234,
        "Cube.009",
        0,
        [-4.29758, 10.8464, 1.00000],
    ),
    (
        "anim/InterpolationTest/InterpolationTest.gltf",
        1.234,
        "Cube.004",
        7,
        [1.92117, 3.38665, -1.00000],
    ),
];

/// File, and the box of everything at [`BOX_TIME`].
const BOXES: &[(&str, [f32; 3], [f32; 3])] = &[
    (
        "anim/CesiumMan/CesiumMan.gltf",
        [-0.486900, -0.0135818, -0.193071],
        [0.46011, 1.46793, 0.22753],
    ),
    ("anim/Fox.glb", [-11.5961, -0.130878, -84.4445], [16.65525, 76.66754, 67.20664]),
    (
        "anim/RiggedFigure/RiggedFigure.gltf",
        [-0.492827, -4.25578e-08, -0.124841],
        [0.48529, 1.46381, 0.21212],
    ),
    ("anim/robot.glb", [-2.24768, -0.0203044, -0.887024], [2.20376, 4.61130, 1.72889]),
    ("anim/Knight.glb", [-0.802805, -0.000472333, -0.770729], [1.44327, 2.31424, 2.33049]),
    (
        "anim/AnimatedMorphSphere/AnimatedMorphSphere.gltf",
        [-1.17594, -1.00000, -0.999999],
        [1.17594, 1.00000, 1.00000],
    ),
    ("anim/MorphStressTest.gltf", [-2.00000, -0.100000, -0.500000], [2.00000, 1.03948, 0.50000]),
    (
        "anim/InterpolationTest/InterpolationTest.gltf",
        [-4.47421, -2.15946, -1.00000],
        [4.37790, 11.00000, 1.00367],
    ),
    (
        "anim/BoxAnimated/BoxAnimated.gltf",
        [-0.500000, -0.500000, -0.500000],
        [0.50000, 2.05232, 0.50000],
    ),
];

/// In seconds.
const BOX_TIME: f64 = 0.77;

/// The numbers above are rounded; this is far below what a wrong rule would change.
const TOLERANCE: f32 = 1e-5;

struct Folder(PathBuf);

impl Source for Folder {
    fn read(&self, path: &str, _: u64) -> Result<Vec<u8>> {
        std::fs::read(self.0.join(path)).map_err(|e| Error::input(path, "", e.to_string()))
    }
}

/// A scene of the test data with what plays by default.
fn open(file: &str) -> Option<(Scene, Playback)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(file);
    let Ok(bytes) = std::fs::read(&path) else {
        eprintln!("skipped: there is no {file} in the test data beside the workspace");
        return None;
    };
    let folder = Folder(path.parent().expect("in a folder").to_owned());
    let mut door = Door::new(file, &folder, Budget::default());
    let scene = read_scene(file, &bytes, Up::Auto, &mut door).expect("a sound file");
    let (playback, _) = scene.playback(&Choice::Auto).expect("the default always plays");
    Some((scene, playback))
}

fn corner(scene: &Scene, frame: &Frame, node: &str, corner: usize) -> Vec3 {
    let object = frame.objects.iter().find(|o| scene.nodes[o.node.index()].name == node);
    let object = object.expect("the node is drawn");
    let triangles = &frame.shapes[object.shape].mesh_in(scene).triangles;
    let vertex = triangles[corner / 3][corner % 3];
    frame.world_positions(object).nth(vertex as usize).expect("indices are in range")
}

#[test]
fn corners_are_where_another_program_puts_them() {
    for &(file, time, node, index, want) in CORNERS {
        let Some((scene, playback)) = open(file) else { continue };
        let frame = scene.frame(time, &playback);
        let got = corner(&scene, &frame, node, index);
        let off = got.distance(Vec3::from_array(want)) / frame.bounds().radius();
        assert!(off < TOLERANCE, "{file} at {time}: {node} {index} is at {got}, not at {want:?}");
    }
}

#[test]
fn boxes_are_as_another_program_has_them() {
    for &(file, min, max) in BOXES {
        let Some((scene, playback)) = open(file) else { continue };
        let bounds = scene.frame(BOX_TIME, &playback).bounds();
        for (got, want) in [(bounds.min, min), (bounds.max, max)] {
            let off = got.distance(Vec3::from_array(want)) / bounds.radius();
            assert!(off < TOLERANCE, "{file}: {got} is not {want:?}");
        }
    }
}
