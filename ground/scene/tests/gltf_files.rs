//! Real and broken glTF files: counts as the index of the test data has them, and no panic.
//! Skipped, with a message, where the data is not there.

use chiaro_basis::{Error, Result};
use chiaro_scene::load::{Budget, Door, Source, Up, read_scene};
use chiaro_scene::{NormalSource, Scene};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A folder on disk.
struct Folder(PathBuf);

impl Source for Folder {
    fn read(&self, path: &str, limit: u64) -> Result<Vec<u8>> {
        let bytes = std::fs::read(self.0.join(path))
            .map_err(|_| Error::input(path, "", "not found beside the scene"))?;
        if bytes.len() as u64 > limit {
            return Err(Error::limit(path, "more bytes", "fewer"));
        }
        Ok(bytes)
    }
}

fn data() -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    if path.join("INDEX.md").exists() {
        return Some(path);
    }
    eprintln!("skipped: there is no test data beside the workspace");
    None
}

fn read(path: &Path) -> Result<Scene> {
    let name = path.file_name().expect("a file").to_string_lossy().into_owned();
    let folder = Folder(path.parent().expect("in a folder").to_owned());
    let bytes = std::fs::read(path).expect("a readable file");
    read_scene(&name, &bytes, Up::Auto, &mut Door::new(&name, &folder, Budget::default()))
}

/// A line of the index: file, triangles, vertices, and what it says of animation and extensions.
struct Line {
    file: String,
    triangles: u64,
    vertices: u64,
    notes: String,
}

fn index(data: &Path) -> Vec<Line> {
    let text = std::fs::read_to_string(data.join("INDEX.md")).expect("a readable index");
    let line = |line: &str| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let file = cells.get(1).filter(|f| f.ends_with(".gltf") || f.ends_with(".glb"))?;
        let (triangles, rest) = cells[5].split_once(" / ")?;
        let vertices = rest.split(' ').next()?;
        Some(Line {
            file: (*file).to_owned(),
            triangles: triangles.parse().ok()?,
            vertices: vertices.parse().ok()?,
            notes: cells[6].to_owned(),
        })
    };
    text.lines().filter_map(line).collect()
}

/// The number before `what` in the notes of a line.
fn noted(notes: &str, what: &str) -> Option<u64> {
    notes
        .split(&format!(" {what}"))
        .next()
        .filter(|before| before.len() < notes.len())?
        .split(' ')
        .next_back()?
        .parse()
        .ok()
}

#[test]
fn counts_are_those_of_the_index() {
    let Some(data) = data() else { return };
    let lines = index(&data);
    assert!(lines.len() > 45, "the index has {} glTF files", lines.len());
    for line in lines.iter().filter(|l| !l.file.contains("/compressed/")) {
        let scene = read(&data.join(&line.file)).unwrap_or_else(|e| panic!("{}: {e}", line.file));
        eprintln!("{}: {:?}", line.file, scene.warnings);
        assert_eq!(scene.stored.triangles, line.triangles, "triangles of {}", line.file);
        assert_eq!(scene.stored.vertices, line.vertices, "vertices of {}", line.file);
        if let Some(clips) = noted(&line.notes, "clips") {
            assert_eq!(scene.clips.len() as u64, clips, "{}", line.file);
        }
        if let Some(targets) = noted(&line.notes, "morph targets") {
            assert_eq!(scene.stored.morph_targets, targets, "{}", line.file);
        }
        if let Some(joints) = noted(&line.notes, "joints") {
            assert_eq!(scene.skins[0].joints.len() as u64, joints, "{}", line.file);
        }
        is_sound(&line.file, &scene);
    }
}
/// What every scene promises.
fn is_sound(file: &str, scene: &Scene) {
    for mesh in &scene.meshes {
        let n = mesh.positions.len();
        assert!(mesh.triangles.iter().flatten().all(|v| (*v as usize) < n), "{file}");
        assert_eq!(mesh.materials.len(), mesh.triangles.len(), "{file}");
        assert!(mesh.materials.iter().all(|m| m.index() < scene.materials.len()), "{file}");
        let full = |len: usize| len == n;
        let column = |len: usize| len == 0 || len == n;
        match &mesh.normals {
            NormalSource::Given(normals) => {
                assert!(full(normals.len()), "{file}");
                assert!(normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-3), "{file}");
            }
            NormalSource::Faces(groups) => {
                assert!(full(groups.len()) && groups.iter().all(|g| (*g as usize) < n), "{file}");
            }
        }
        assert!(column(mesh.tangents.len()) && column(mesh.colours.len()), "{file}");
        assert!(mesh.uvs.iter().all(|uvs| full(uvs.len())), "{file}");
        for morph in &mesh.morphs {
            let lengths = [morph.positions.len(), morph.normals.len(), morph.tangents.len()];
            assert!(lengths.into_iter().all(column), "{file}");
        }
        let influences = &mesh.influences;
        assert_eq!(influences.joints.len(), influences.weights.len(), "{file}");
        assert!(influences.joints.iter().all(|j| full(j.len())), "{file}");
        for v in 0..if influences.weights.is_empty() { 0 } else { n } {
            let sum: f32 = influences.weights.iter().flat_map(|w| w[v]).sum();
            assert!((sum - 1.0).abs() < 1e-4, "{file}: {sum}");
        }
        assert!(mesh.positions.iter().all(|p| p.is_finite()), "{file}");
    }
    for (i, node) in scene.nodes.iter().enumerate() {
        assert!(node.parent.is_none_or(|p| p.index() < i), "{file}");
        if let Some(mesh) = node.mesh {
            assert_eq!(node.weights.len(), scene.meshes[mesh.index()].morphs.len(), "{file}");
        }
        if let (Some(mesh), Some(skin)) = (node.mesh, node.skin) {
            let joints = scene.skins[skin.index()].joints.len();
            let used = scene.meshes[mesh.index()].influences.joints.iter().flatten().flatten();
            assert!(used.copied().all(|j| usize::from(j) < joints), "{file}");
        }
    }
    for channel in scene.clips.iter().flat_map(|c| &c.channels) {
        let track = &channel.track;
        let parts =
            if track.interpolation == chiaro_scene::Interpolation::CubicSpline { 3 } else { 1 };
        assert!(!track.times.is_empty() && track.width > 0, "{file}");
        assert_eq!(track.values.len(), track.times.len() * track.width * parts, "{file}");
        assert!(track.times.is_sorted(), "{file}");
        assert!(channel.node.index() < scene.nodes.len(), "{file}");
    }
    let textures = scene.materials.iter().flat_map(|m| {
        [m.base_texture, m.normal_texture, m.metallic_roughness_texture, m.emissive_texture]
    });
    assert!(textures.flatten().all(|t| t.texture.index() < scene.textures.len()), "{file}");
    assert!(scene.textures.iter().all(|t| !t.pixels.is_empty()), "{file}");
}

#[test]
fn compressed_files_name_the_extension_and_the_way_around() {
    let Some(data) = data() else { return };
    for (file, extension, hint) in [
        ("BoxDraco.gltf", "KHR_draco_mesh_compression", "untick Compression"),
        ("heart_draco.glb", "KHR_draco_mesh_compression", "untick Compression"),
        ("BoxMeshopt.glb", "EXT_meshopt_compression", "gltfpack without -c"),
        ("BoxMeshopt.gltf", "EXT_meshopt_compression", "gltfpack without -c"),
        ("pirate_quantized.glb", "EXT_meshopt_compression", "gltfpack without -c"),
    ] {
        let why = read(&data.join("awkward/compressed").join(file)).unwrap_err().to_string();
        assert!(why.contains(file) && why.contains(extension) && why.contains(hint), "{why}");
    }
}

#[test]
fn invalid_files_end_quickly_in_a_scene_or_a_sentence() {
    let Some(data) = data() else { return };
    let start = Instant::now();
    let mut files: Vec<PathBuf> = std::fs::read_dir(data.join("invalid/magnum_gltf"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "gltf" || e == "glb"))
        .collect();
    files.sort();
    assert!(files.len() > 100);
    for file in files {
        let name = file.file_name().unwrap().to_string_lossy();
        match read(&file) {
            Ok(scene) => {
                eprintln!("{name}: ok {:?}", scene.warnings);
                is_sound(&name, &scene);
            }
            Err(why) => {
                eprintln!("{why}");
                assert!(why.to_string().contains(name.as_ref()), "{why}");
            }
        }
    }
    assert!(start.elapsed().as_secs() < 10);
}
