//! Scene files that name paths outside their folder: none is opened.
#![allow(clippy::unwrap_used, reason = "a test may panic, also in its own functions")]

use chiaro::project::{Options, Project};
use chiaro_basis::Run;
use std::path::Path;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// Names that lead to `secret` beside the scene's folder, or try to.
fn tricks(secret: &Path) -> Vec<String> {
    let full = secret.to_string_lossy().into_owned();
    let encoded: String = full.bytes().map(|b| format!("%{b:02x}")).collect();
    let mut tricks: Vec<String> = [
        "../secret",
        "..\\secret",
        "./../secret",
        "a/../../secret",
        "%2e%2e/secret",
        "..%2fsecret",
        "%2e%2e%2fsecret",
        "..%5csecret",
        ".%2e/secret",
        "..//secret",
        "..///secret",
        "../scene/../secret",
        "link",
        "linkdir/secret",
        "./link",
        "a/../link",
        "~/secret",
        "~root/secret",
        "$HOME/secret",
        "file:../secret",
        "FILE:../secret",
        "C:\\secret",
        "\\\\host\\secret",
        "//host/secret",
        "http://host/secret",
        "..%00/secret",
        "../secret%00.bin",
        "..;/secret",
        "....//secret",
        "%252e%252e/secret",
        "..%c0%afsecret",
        "/proc/self/environ",
        "/dev/stdin",
    ]
    .map(String::from)
    .into();
    tricks.push(full.clone());
    tricks.push(encoded);
    tricks.push(format!("file://{full}"));
    tricks.push(format!("file://localhost{full}"));
    tricks.push(format!("//{full}"));
    tricks.push(format!("\\{full}"));
    tricks.push(format!("..{full}"));
    tricks
}

#[test]
fn no_trick_leads_outside_the_folder() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("scene");
    std::fs::create_dir_all(folder.join("a")).unwrap();
    // A buffer that would do: the positions of a triangle.
    let secret = dir.path().join("secret");
    let floats = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    std::fs::write(&secret, floats.map(f32::to_le_bytes).as_flattened()).unwrap();
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&secret, folder.join("link")).unwrap();
        std::os::unix::fs::symlink(dir.path(), folder.join("linkdir")).unwrap();
    }
    let tricks = tricks(&secret);
    assert!(tricks.len() >= 40, "{}", tricks.len());
    for trick in &tricks {
        let uri = serde_json::to_string(trick).unwrap();
        let gltf = format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
"bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36,"uri":{uri}}}]}}"#
        );
        let file = folder.join("a.gltf");
        std::fs::write(&file, gltf).unwrap();
        let open = |file: &Path, strict: bool| {
            let options = Options { strict, ..Options::default() };
            Project::open(&file.to_string_lossy(), options, &Run::default())
        };
        let said = open(&file, false).err().map(|e| e.to_string());
        assert!(said.as_ref().is_some_and(|s| s.lines().count() == 1), "{trick:?}: {said:?}");
        // The same as the material file of an OBJ: missing, whatever it is.
        let file = folder.join("a.obj");
        std::fs::write(&file, format!("mtllib {trick}\n{TRIANGLE}")).unwrap();
        assert!(open(&file, true).is_err(), "{trick:?} as mtllib");
    }
}
