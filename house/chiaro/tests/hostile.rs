//! Hostile input: mutated files of every format, and degenerate meshes, through reading, posing
//! and drawing. None may panic or take long; each ends in a result or in one sentence.
//!
//! `CHIARO_MUTANTS=200000 cargo test -p chiaro --release --test hostile` tries that many.
#![allow(clippy::unwrap_used, reason = "a test may panic, also in its own functions")]

use chiaro::binary::{Job, Look};
use chiaro::film::Target;
use chiaro::project::{Options, Project};
use chiaro::style::Style;
use chiaro_basis::{Error, Result, Run, random};
use chiaro_scene::load::{Budget, Door, Source, Up, read_scene};
use chiaro_scene::{Playback, Poser, Scene};
use chiaro_trace::{Ray, Sides, Tracer};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::panic::catch_unwind;
use std::path::Path;
use std::time::{Duration, Instant};

const OBJ: &[u8] = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 1 0.5 0.25\nv 0.5 0.5 1\n\
vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nvn 0 1 0\no first\ng a b\nusemtl red\ns 1\nf 1/1/1 2/2/1 3/3/1 4\n\
s off\nf -5//2 -1//2 -4//2\nf 2 3 5\nl 1 2\np 1\nusemtl glow\nf 3 4 5 \\\n 1\n";
const MTL: &[u8] = b"newmtl red\nKd 0.8 0.1 0.1\nKs 0.5\nNs 20\nd 0.9\nmap_Kd -s 2 2 1 a.png\n\
bump -bm 0.4 a.png\nnewmtl glow\nKe 5 5 5\nillum 2\n";
const PLY: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 3\n\
property list uchar int vertex_indices\nend_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n\
0 0 1 9 9 9\n3 0 1 2\n3 0 1 3\n4 0 2 3 1\n";
const STL: &[u8] = b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
vertex 0 1 0\nendloop\nendfacet\nfacet normal 0 1 0\nouter loop\nvertex 0 0 0\nvertex 1e3 0 0\n\
vertex 0 0 1\nendloop\nendfacet\nendsolid a\n";

fn binary_ply() -> Vec<u8> {
    let mut bytes = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty double x\n\
property double y\nproperty double z\nelement face 1\nproperty list uchar uint vertex_index\n\
end_header\n"
        .to_vec();
    for x in [0.0f64, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.5] {
        bytes.extend(x.to_le_bytes());
    }
    bytes.push(3);
    bytes.extend([0u32, 1, 2].iter().flat_map(|i| i.to_le_bytes()));
    bytes
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(2u32.to_le_bytes());
    for k in 0..2 {
        let corners = [[0.0, 0.0, 1.0], [0.0; 3], [1.0, 0.0, k as f32], [0.0, 1.0, 0.0]];
        bytes.extend(corners.as_flattened().iter().flat_map(|x: &f32| x.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

/// A glTF with inline buffer: an animated, indexed triangle under a chain of nodes, a skin, a
/// morph target, a camera and a light.
fn gltf() -> Vec<u8> {
    br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"children":[1,2],"translation":[0,1,0]},{"mesh":0,"skin":0,"weights":[0.5]},
{"rotation":[0,0,0.7071,0.7071],"camera":0,"extensions":{"KHR_lights_punctual":{"light":0}}}],
"extensionsUsed":["KHR_lights_punctual"],
"extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","intensity":50,"spot":{"outerConeAngle":0.7}}]}},
"cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.1}}],
"materials":[{"doubleSided":true,"alphaMode":"MASK","alphaCutoff":0.5,"emissiveFactor":[1,0.5,0]}],
"skins":[{"joints":[0,2]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":2,"WEIGHTS_0":3},"indices":1,"material":0,
"targets":[{"POSITION":0}]}]}],
"animations":[{"channels":[{"sampler":0,"target":{"node":2,"path":"translation"}}],
"samplers":[{"input":4,"output":0,"interpolation":"LINEAR"}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"},
{"bufferView":2,"componentType":5121,"count":3,"type":"VEC4"},
{"bufferView":3,"componentType":5121,"normalized":true,"count":3,"type":"VEC4"},
{"bufferView":4,"componentType":5126,"count":3,"type":"SCALAR","min":[0],"max":[2]}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6},
{"buffer":0,"byteOffset":44,"byteLength":12},{"buffer":0,"byteOffset":56,"byteLength":12},
{"buffer":0,"byteOffset":68,"byteLength":12}],
"buffers":[{"byteLength":80,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAAAAQAAAAEAAAABAACAfwAAgH8AAIB/AAAAAAAAAAAAAIA/AAAAQA=="}]}"#
        .to_vec()
}

/// Files beside a scene, in memory.
struct Beside(BTreeMap<&'static str, Vec<u8>>);

impl Source for Beside {
    fn read(&self, path: &str, limit: u64) -> Result<Vec<u8>> {
        let bytes = self.0.get(path).filter(|b| b.len() as u64 <= limit);
        bytes.cloned().ok_or_else(|| Error::input(path, "", "not found"))
    }
}

fn read(name: &str, bytes: &[u8], beside: &Beside) -> Result<Scene> {
    read_scene(name, bytes, Up::Auto, &mut Door::new(name, beside, Budget::default()))
}

/// Poses and traces what was read.
fn use_up(scene: &Scene) {
    let poser = Poser::new(scene);
    let playback = Playback { clips: (0..scene.clips.len()).collect() };
    for time in [0.0, 0.7, 1e6] {
        let frame = poser.frame(time, &playback);
        let tracer = Tracer::new(scene, &frame);
        for i in 0..8 {
            let [u, v] = random::r2(i);
            let direction = chiaro_basis::math::Vec3::new(u - 0.5, v - 0.5, -0.4).normalize();
            let ray = Ray { origin: -3.0 * direction, direction, t_max: f32::INFINITY };
            let hit = tracer.hit(&ray, Sides::Both);
            assert!(hit.is_none_or(|h| h.t.is_finite()));
            tracer.occluded(&ray);
        }
    }
}

/// Draws from a seeded sequence.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) as usize) % n.max(1)
    }
}

/// One to four changes: bits, bytes, cuts, doubled and dropped pieces, odd numbers.
fn mutate(bytes: &[u8], dice: &mut Dice) -> Vec<u8> {
    const WORDS: [u32; 8] =
        [0, 1, 0x7fff_ffff, 0xffff_ffff, 0x7f80_0000, 0x7fc0_0000, 1000, 1 << 30];
    const TEXTS: [&str; 10] =
        ["-1", "1e39", "nan", "999999999", "0", "1e-45", "[]", "null", "\"x\"", "-2147483648"];
    let mut out = bytes.to_vec();
    for _ in 0..1 + dice.below(4) {
        if out.is_empty() {
            break;
        }
        let at = dice.below(out.len());
        let end = (at + 1 + dice.below(40)).min(out.len());
        match dice.below(8) {
            0 => out[at] ^= 1 << dice.below(8),
            1 => out[at] = dice.below(256) as u8,
            2 => out.truncate(at),
            3 => drop(out.drain(at..end)),
            4 => {
                let piece = out[at..end].to_vec();
                out.splice(at..at, piece);
            }
            5 => {
                let word = WORDS[dice.below(WORDS.len())].to_le_bytes();
                let end = (at + 4).min(out.len());
                out[at..end].copy_from_slice(&word[..end - at]);
            }
            _ => {
                // A number of the text becomes another.
                let is_digit = |b: &u8| b.is_ascii_digit() || matches!(b, b'-' | b'.');
                let start = (at..out.len()).find(|&i| is_digit(&out[i])).unwrap_or(at);
                let stop = (start..out.len()).find(|&i| !is_digit(&out[i])).unwrap_or(out.len());
                out.splice(start..stop, TEXTS[dice.below(TEXTS.len())].bytes());
            }
        }
    }
    out
}

fn seeds() -> Vec<(String, Vec<u8>)> {
    let mut seeds: Vec<(String, Vec<u8>)> = vec![
        ("a.obj".into(), OBJ.to_vec()),
        ("a.ply".into(), PLY.to_vec()),
        ("b.ply".into(), binary_ply()),
        ("a.stl".into(), STL.to_vec()),
        ("b.stl".into(), binary_stl()),
        ("a.gltf".into(), gltf()),
    ];
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    for file in [
        "anim/RiggedSimple/RiggedSimple.gltf",
        "anim/AnimatedMorphCube/AnimatedMorphCube.gltf",
        "awkward/Lights.glb",
        "awkward/simple-instancing.glb",
        "gi/CornellBox_bevy.glb",
        "mesh/spot_control_quads.obj",
    ] {
        match std::fs::read(data.join(file)) {
            Ok(bytes) => seeds.push((file.rsplit('/').next().unwrap_or(file).into(), bytes)),
            Err(_) => eprintln!("skipped: {file} is not there"),
        }
    }
    seeds
}

#[test]
fn the_seeds_themselves_can_be_read() {
    let beside = Beside([("a.mtl", MTL.to_vec())].into());
    for (name, bytes) in seeds().into_iter().take(6) {
        let scene = read(&name, &bytes, &beside).unwrap_or_else(|e| panic!("{name}: {e}"));
        use_up(&scene);
    }
}

#[test]
fn mutated_files_end_quickly_in_a_scene_or_a_sentence() {
    let count = std::env::var("CHIARO_MUTANTS").ok().and_then(|n| n.parse().ok()).unwrap_or(4000);
    let seeds = seeds();
    let failures: Vec<String> = (0..count as u64)
        .into_par_iter()
        .filter_map(|i| {
            let mut dice = Dice(i.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 77);
            let (name, bytes) = &seeds[i as usize % seeds.len()];
            let in_mtl = name.ends_with("a.obj") && dice.below(3) == 0;
            let mtl = if in_mtl { mutate(MTL, &mut dice) } else { MTL.to_vec() };
            let bytes = if in_mtl { bytes.clone() } else { mutate(bytes, &mut dice) };
            let beside = Beside([("a.mtl", mtl)].into());
            let start = Instant::now();
            let result = catch_unwind(|| match read(name, &bytes, &beside) {
                Ok(scene) => {
                    use_up(&scene);
                    true
                }
                Err(e) => e.to_string().lines().count() == 1,
            });
            let slow = start.elapsed() > Duration::from_secs(2);
            (slow || !matches!(result, Ok(true)))
                .then(|| format!("mutant {i} of {name}: {result:?}, slow: {slow}"))
        })
        .collect();
    assert!(failures.is_empty(), "{failures:#?}");
}

/// Twelve defects, each in a mesh of some triangles made from a seed.
fn defective(defect: usize, seed: u64) -> String {
    let mut dice = Dice(seed * 31 + defect as u64);
    let mut unit = || dice.below(2001) as f64 / 1000.0 - 1.0;
    let scale = match defect {
        0 => 1e30,
        1 => 1e-30,
        2 => 1e38,
        _ => 1.0,
    };
    let offset = if defect == 3 { 1e7 } else { 0.0 };
    let mut text = String::new();
    for i in 0..30 {
        let mut p = [unit(), unit(), unit()].map(|c| c * scale + offset);
        match defect {
            4 => p[2] = 0.0,
            5 => (p[1], p[2]) = (p[0], p[0]),
            6 => p = [0.5; 3],
            7 if i % 5 == 0 => p[1] = f64::NAN,
            8 if i % 7 == 0 => p[0] = f64::INFINITY,
            _ => {}
        }
        text += &format!("v {} {} {}\n", p[0], p[1], p[2]);
    }
    for i in 0..10 {
        let [a, b, c] = [3 * i + 1, 3 * i + 2, 3 * i + 3];
        text += &match defect {
            9 => format!("f {a} {a} {b}\n"),
            10 => format!("f {a} {b} {c}\nf {a} {b} {c}\nf {c} {b} {a}\n"),
            11 => format!("f 1 2 {c}\n"),
            _ => format!("f {a} {b} {c}\n"),
        };
    }
    text
}

#[test]
fn degenerate_meshes_end_in_a_picture_or_a_sentence() {
    let dir = tempfile::tempdir().unwrap();
    let style = Style::find("ink").unwrap();
    for defect in 0..12 {
        for seed in 0..4 {
            let file = dir.path().join(format!("{defect}-{seed}.obj"));
            std::fs::write(&file, defective(defect, seed)).unwrap();
            let options = Options { size: Some((40, 30)), ..Options::default() };
            let run = Run::default();
            let out = dir.path().join("out.png");
            let result =
                Project::open(&file.to_string_lossy(), options, &run).and_then(|project| {
                    let target = Target::Single(out.clone());
                    let look = Look::of(&style);
                    let job = Job { project: &project, look, target, dump_graph: None };
                    job.run(&run)
                });
            if let Err(e) = result {
                assert_eq!(e.to_string().lines().count(), 1, "defect {defect}: {e}");
            }
        }
    }
}
