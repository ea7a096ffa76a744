//! What a file asks of its reader: a version of glTF, and extensions.
//!
//! A required extension that is not supported is an error with the way around it. Optional ones are
//! ignored with a note: one line for those that only refine the looks, one for all others.

use super::context::Context;
use super::json::Value;
use chiaro_basis::{Error, Result};

/// Read in full, or as far as scenes here go.
const SUPPORTED: [&str; 11] = [
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Refine the looks of materials, or hold data that no picture shows.
const REFINEMENTS: [&str; 16] = [
    "EXT_materials_bump",
    "FB_ngon_encoding",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_transmission",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_materials_volume_scatter",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "MSFT_texture_dds",
];

/// Told where they are met, with what is read in their place.
const TOLD_IN_PLACE: [&str; 7] = [
    "EXT_meshopt_compression",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
];

/// Checks version and extensions; returns the extensions that the file says it uses.
pub(super) fn check(root: &Value, cx: &mut Context) -> Result<Vec<String>> {
    version(root, cx)?;
    let used = names(root, "extensionsUsed");
    let required = names(root, "extensionsRequired");
    let unknown = |name: &&String| !SUPPORTED.contains(&name.as_str());
    if let Some(name) = required.iter().find(unknown) {
        return Err(unsupported(cx, name));
    }
    let told = |list: &[&str]| {
        let names = used.iter().filter(unknown).map(String::as_str);
        names.filter(|n| list.contains(n)).map(str::to_owned).collect::<Vec<_>>()
    };
    let refinements = told(&REFINEMENTS);
    if !refinements.is_empty() {
        cx.remark(format!("ignored, for they only refine the looks: {}", refinements.join(", ")));
    }
    let known = |n: &String| [&REFINEMENTS[..], &TOLD_IN_PLACE].concat().contains(&n.as_str());
    let others: Vec<_> = used.iter().filter(unknown).filter(|n| !known(n)).cloned().collect();
    if !others.is_empty() {
        cx.remark(format!("ignored, for they are not known here: {}", others.join(", ")));
    }
    Ok(used)
}

fn version(root: &Value, cx: &Context) -> Result<()> {
    let asset = root.get("asset");
    let Some(version) = asset.text("version") else {
        let why = "this is no glTF file (it has no asset.version); export the scene again";
        return Err(cx.door.error("", why));
    };
    let needed = asset.text("minVersion").unwrap_or(version);
    let exact = asset.text("minVersion").is_some();
    if version.split('.').next() == Some("2") && !(exact && needed != "2.0") {
        return Ok(());
    }
    let why = format!(
        "this is glTF {needed:?}, and 2.0 is read; open it in Blender or another tool and export \
         it as glTF 2.0"
    );
    Err(cx.door.error("asset.version", why))
}

/// The texts of a list, sorted and each once.
fn names(root: &Value, key: &str) -> Vec<String> {
    let texts = root.list(key).iter().filter_map(Value::as_text);
    let clean = texts.map(|t| t.chars().filter(|c| !c.is_control()).take(100).collect());
    let mut names: Vec<String> = clean.collect();
    names.sort();
    names.dedup();
    names
}

/// The error for what only the extension `name` could read.
pub(super) fn unsupported(cx: &Context, name: &str) -> Error {
    cx.door.error(name, format!("this extension is not supported; {}", way_around(name)))
}

/// How to export without an extension.
fn way_around(name: &str) -> &'static str {
    match name {
        "KHR_draco_mesh_compression" => {
            "export without Draco compression (in Blender untick Compression in the glTF export \
             panel, with gltfpack or gltf-transform leave out Draco)"
        }
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "export without meshopt compression (run gltfpack without -c, -cc and -cz; with \
             gltf-transform use --compress false)"
        }
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" | "MSFT_texture_dds" => {
            "export textures as PNG or JPEG (in Blender choose Images: Automatic or JPEG in the \
             glTF export panel, run gltfpack without -tc and -tw; with gltf-transform use \
             --texture-compress false)"
        }
        _ if name.starts_with("KHR_materials_") => {
            "export plain metallic-roughness materials, or take it out of the file's list \
             extensionsRequired to see the scene without it"
        }
        _ => "export without it (switch it off in the exporter's options)",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::gltf::json::parse;
    use crate::load::{Budget, Door};

    fn outcome(text: &str) -> (Result<Vec<String>>, Vec<String>) {
        let mut door = Door::new("a.gltf", &(), Budget::default());
        let root = parse(text, &door).unwrap();
        let mut cx = Context::new(&mut door);
        let used = check(&root, &mut cx);
        (used, cx.into_warnings().0)
    }

    #[test]
    fn required_extensions_are_named_with_the_way_around() {
        for (name, hint) in [
            ("KHR_draco_mesh_compression", "untick Compression"),
            ("EXT_meshopt_compression", "gltfpack without -c"),
            ("KHR_texture_basisu", "PNG or JPEG"),
            ("KHR_materials_clearcoat", "extensionsRequired"),
            ("ACME_cubes", "export without it"),
        ] {
            let text = format!(
                r#"{{"asset": {{"version": "2.0"}}, "extensionsRequired": ["KHR_materials_unlit", "{name}"]}}"#
            );
            let why = outcome(&text).0.unwrap_err().to_string();
            assert!(why.contains(name) && why.contains(hint), "{why}");
        }
    }

    #[test]
    fn optional_extensions_are_ignored_in_two_lines() {
        let (used, warnings) = outcome(
            r#"{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_materials_sheen",
                "ACME_cubes", "KHR_lights_punctual", "KHR_materials_ior", "ACME_cubes"]}"#,
        );
        assert_eq!(used.unwrap().len(), 4);
        assert_eq!(warnings.len(), 2);
        assert!(warnings[0].ends_with(": KHR_materials_ior, KHR_materials_sheen"));
        assert!(warnings[1].ends_with(": ACME_cubes"));
    }

    #[test]
    fn versions_after_two_pass_unless_they_say_that_two_is_too_little() {
        let version = |text: &str| outcome(&format!(r#"{{"asset": {text}}}"#)).0;
        assert!(version(r#"{"version": "2.0"}"#).is_ok());
        assert!(version(r#"{"version": "2.7"}"#).is_ok());
        assert!(version(r#"{"version": "2.7", "minVersion": "2.0"}"#).is_ok());
        assert!(version(r#"{"version": "2.1", "minVersion": "2.1"}"#).is_err());
        for text in [r#"{"version": "1.0"}"#, r#"{"version": "3.0"}"#, r#"{"version": 2}"#, "1"] {
            assert!(version(text).is_err(), "{text}");
        }
    }
}
