//! Default views of films.

use chiaro::camera::Camera;
use chiaro::{Options, Project};
use chiaro_basis::Run;
use std::fs;
use std::path::Path;

/// A triangle that stands still but for frames 13 to 17 of 48, when it leaps aside by eight times its
/// size and comes back.
fn leaping(folder: &Path) -> std::path::PathBuf {
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let times = [0.0f32, 12.0 / 24.0, 14.0 / 24.0, 16.0 / 24.0, 47.0 / 24.0];
    let still = [0.0f32; 3];
    let places = [still, still, [8.0, 0.0, 0.0], still, still];
    let numbers = corners.as_flattened().iter().chain(&times).chain(places.as_flattened());
    let bytes: Vec<u8> = numbers.flat_map(|n| n.to_le_bytes()).collect();
    fs::write(folder.join("leap.bin"), bytes).expect("the folder is there");
    let scene = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"buffers":[{"uri":"leap.bin","byteLength":116}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},
{"buffer":0,"byteOffset":36,"byteLength":20},{"buffer":0,"byteOffset":56,"byteLength":60}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5126,"count":5,"type":"SCALAR","min":[0],"max":[1.9583334]},
{"bufferView":2,"componentType":5126,"count":5,"type":"VEC3"}],
"animations":[{"samplers":[{"input":1,"output":2}],
"channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}]}]}"#;
    let file = folder.join("leap.gltf");
    fs::write(&file, scene).expect("the folder is there");
    file
}

#[test]
fn what_leaps_for_a_moment_stays_in_the_picture() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = leaping(folder.path());
    let run = Run::default();
    let frames: Vec<u32> = (1..=48).collect();
    let options = Options { frames: Some(frames.clone()), ..Options::default() };
    let project = Project::open(&file.to_string_lossy(), options, &run).expect("it opens");
    let poser = project.poser();
    // What a film is begun with: a few of its frames, at none of which it is aside.
    let few: Vec<_> =
        project.sampled_shot(5).iter().map(|n| project.pose(&poser, *n, &run)).collect();
    let camera = Camera::choose(&project, &few, &run).expect("there is a view");
    let (w, h) = (camera.size.0 as f32, camera.size.1 as f32);
    for number in frames {
        let frame = project.pose(&poser, number, &run);
        let pose = camera.pose(&frame, number);
        for point in frame.shapes[0].positions.iter() {
            let [x, y] = pose.project(*point, w, h).expect("it is before the eye");
            assert!((0.0..w).contains(&x) && (0.0..h).contains(&y), "frame {number}: {x} {y}");
        }
    }
}
