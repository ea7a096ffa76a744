//! Error and processor seconds of indirect light at 512 x 512, one bounce: tiles, every pixel by
//! itself, and path tracing; how much tiles change when the pattern of near rays is moved.
//!
//! `cargo bench -p chiaro --bench light -- SCENE... [way=NAME...] [knob=value...]`. Scenes are paths
//! or procedural ones; without any, those that need no file. Ways: tiles, shifted (by another pattern),
//! records, rearranged (records by another pattern), pixel, octree (pixel by that), pathsN, and pooledN (paths with the pools of tiles; movedN by another pattern).
//! `size=N`, `paths=N` (half of the reference's), `pictures=FOLDER`.

#![allow(clippy::print_stdout)]

use chiaro::light::{Outcome, Truth, Way, trial};
use chiaro::{Options, Project};
use chiaro_basis::{Knobs, Run};
use chiaro_image::sheet::Sheet;
use chiaro_image::{Plane, codec, metric};
use chiaro_pbgi::{Division, LightKnobs, OwnSky, Sharing};
use std::path::Path;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|w| !w.starts_with("--")).collect();
    let value = |key: &str| {
        words.iter().filter_map(|w| w.split_once('=')).find(|(k, _)| *k == key).map(|(_, v)| v)
    };
    let number =
        |key: &str, default: usize| value(key).map_or(default, |v| v.parse().expect("a number"));
    let mut scenes: Vec<&str> =
        words.iter().filter(|w| !w.contains('=')).map(|w| w.as_str()).collect();
    if scenes.is_empty() {
        scenes = vec!["demo:cornell-box", "demo:sphere-field"];
    }
    let mut knobs = LightKnobs { bounces: 1, sky: OwnSky::None, ..LightKnobs::default() };
    for (key, v) in words.iter().filter_map(|w| w.split_once('=')) {
        if !["way", "size", "paths", "pictures"].contains(&key) {
            knobs.set(key, v).expect("a knob");
        }
    }
    let ways: Vec<Way> =
        words.iter().filter_map(|w| w.strip_prefix("way=")).map(|name| way(name, &knobs)).collect();
    let ways =
        if ways.is_empty() { vec![way("tiles", &knobs), way("shifted", &knobs)] } else { ways };
    let size = number("size", 512);
    println!(
        "{:<22} {:<10} {:>8} {:>8} {:>9} {:>9} {:>9} {:>9}",
        "scene", "way", "error %", "bias %", "CPU s", "prepare", "gather", "buffers"
    );
    for name in scenes {
        let run = Run::default();
        let options = Options { size: Some((size, size)), ..Options::default() };
        let project = Project::open(name, options, &run).expect("the scene opens");
        let kept = Path::new(env!("CARGO_TARGET_TMPDIR"));
        let (truth, found) =
            trial(&project, &ways, number("paths", 24) as u32, Some(kept), &run).expect("light");
        for (way, o) in ways.iter().zip(&found) {
            let short = name.rsplit('/').next().unwrap_or(name);
            println!(
                "{short:<22} {:<10} {:>8.2} {:>8.2} {:>9.2} {:>9.2} {:>9.2} {:>9}",
                way.name,
                100.0 * o.error,
                100.0 * o.bias,
                o.seconds[0] + o.seconds[1],
                o.seconds[0],
                o.seconds[1],
                o.gathers
            );
            if let Some(folder) = value("pictures") {
                let file = format!("{}-{}.png", short.replace(':', "-"), way.name);
                show(&truth, o, &Path::new(folder).join(file));
            }
        }
        let named =
            |name: &str| ways.iter().position(|w| w.name.starts_with(name)).map(|i| &found[i]);
        for pair in [["tiles", "shifted"], ["records", "rearranged"], ["pooled", "moved"]] {
            if let [Some(a), Some(b)] = pair.map(named) {
                let change = metric::rmse_relative(&b.irradiance, &a.irradiance, &truth.covered);
                let change = 100.0 * change.expect("sizes agree").unwrap_or(0.0);
                println!("{name}, {}: {change:.2} % change with the pattern", pair[0]);
            }
        }
    }
}

fn way(name: &str, knobs: &LightKnobs) -> Way {
    let per_pixel = LightKnobs {
        error_bound: 0.0,
        resolution: 8,
        solid_angle: 1.0,
        surfels: 1_000_000,
        ..knobs.clone()
    };
    let (knobs, paths) = match name {
        "pixel" => (per_pixel, None),
        "octree" => (LightKnobs { hierarchy: Division::Octree, ..per_pixel }, None),
        "records" | "rearranged" => {
            (LightKnobs { sharing: Sharing::Records, ..knobs.clone() }, None)
        }
        _ => {
            let number = ["paths", "pooled", "moved"].iter().find_map(|w| name.strip_prefix(w));
            (knobs.clone(), number.map(|n| n.parse().expect("paths")))
        }
    };
    let moved = name.starts_with("moved");
    let pooled = moved || name.starts_with("pooled");
    let shift = u32::from(moved || ["shifted", "rearranged"].contains(&name));
    Way { name: name.into(), knobs, paths, pooled, shift }
}

/// The truth, the picture, and ten times their difference round grey, side by side.
fn show(truth: &Truth, found: &Outcome, path: &Path) {
    let mean = truth.mean();
    let grey = |c: &[f32; 3]| (c[0] + c[1] + c[2]) / 3.0;
    let lit = mean.pixels().iter().map(|c| f64::from(grey(c))).sum::<f64>();
    let covered = truth.covered.pixels().iter().filter(|c| **c).count();
    let scale = 0.4 / (lit / covered.max(1) as f64) as f32;
    let byte = |v: f32| (255.0 * v.clamp(0.0, 1.0)) as u8;
    let shown =
        |p: &Plane<[f32; 3]>| p.map(|c| c.map(|v| byte((scale * v).max(0.0).powf(1.0 / 2.2))));
    let (w, h) = mean.size();
    let difference = Plane::from_fn(w, h, |x, y| {
        let d = scale * (grey(&found.irradiance[(x, y)]) - grey(&mean[(x, y)]));
        [byte(0.5 + 5.0 * d); 3]
    });
    let mut sheet = Sheet::new(3);
    sheet.add(shown(&mean), "truth");
    sheet.add(shown(&found.irradiance), "picture");
    sheet.add(difference, "ten times the difference");
    let bytes = codec::write_png_rgb(&sheet.draw(), None).expect("a picture");
    std::fs::write(path, bytes).expect("the picture is written");
}
