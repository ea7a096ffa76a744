//! `chiaro info`: what is in a scene.

use crate::project::Project;
use crate::record::Record;
use chiaro_basis::{Result, Run};
use serde_json::{Value, json};

/// Counts everything in a project's scene.
pub fn info(project: &Project, run: &Run) -> Result<Record> {
    let mut record = Record::new("info");
    let scene = &project.scene;
    let frame = project.pose(&project.poser(), 1, run);
    let drawn: u64 = frame
        .objects
        .iter()
        .map(|o| frame.shapes[o.shape].mesh_in(scene).triangles.len() as u64)
        .sum();
    let bounds = frame.bounds();
    record.setting("scene", project.file_name());
    for (name, value) in [
        ("triangles", scene.stored.triangles),
        ("triangles_drawn", drawn),
        ("vertices", scene.stored.vertices),
        ("meshes", scene.meshes.len() as u64),
        ("materials", scene.stored.materials),
        ("textures", scene.stored.textures),
        ("lights", scene.lights.len() as u64),
        ("cameras", scene.cameras.len() as u64),
        ("skins", scene.skins.len() as u64),
        ("morph_targets", scene.stored.morph_targets),
        ("nodes", scene.nodes.len() as u64),
    ] {
        record.count(name, value);
    }
    record.count("animations", animations(project));
    record.count("bounds", json!([bounds.min.to_array(), bounds.max.to_array()]));
    record.count("extensions_used", json!(scene.stored.extensions_used));
    record.count("missing_files", json!(scene.stored.missing_files));
    record.count("camera_names", json!(scene.cameras.iter().map(|c| &c.name).collect::<Vec<_>>()));
    Ok(record)
}

fn animations(project: &Project) -> Value {
    let fps = project.options.fps;
    let clips = project.scene.clips.iter().enumerate().map(|(i, clip)| {
        let ends = clip.channels.iter().filter_map(|c| c.track.times.last());
        let seconds = ends.fold(0.0f64, |a, &t| a.max(f64::from(t)));
        json!({
            "name": clip.name,
            "seconds": seconds,
            "channels": clip.channels.len(),
            "frames": (seconds * fps).floor() as u64 + 1,
            "plays": project.playback.clips.contains(&i),
        })
    });
    clips.collect()
}

/// The record as lines for people.
pub fn text(record: &Record) -> String {
    let mut lines = String::new();
    for (name, value) in &record.counts {
        match value {
            Value::Array(items) if name == "animations" => {
                for clip in items {
                    lines += &format!(
                        "animation        {} ({} s, {} frames, {} channels{})\n",
                        clip["name"].as_str().filter(|n| !n.is_empty()).unwrap_or("unnamed"),
                        clip["seconds"],
                        clip["frames"],
                        clip["channels"],
                        if clip["plays"] == true { ", plays" } else { "" },
                    );
                }
            }
            Value::Array(items) if items.is_empty() => {}
            Value::Array(items) => {
                let items: Vec<String> = items.iter().map(plain).collect();
                lines += &format!("{name:<16} {}\n", items.join(" "));
            }
            other => lines += &format!("{name:<16} {}\n", plain(other)),
        }
    }
    lines
}

fn plain(value: &Value) -> String {
    match value {
        Value::String(s) => s.clone(),
        other => other.to_string(),
    }
}
