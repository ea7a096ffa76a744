//! `chiaro compare A B --motion FILES`: how much two films of black and white flicker.
//!
//! A film is a folder of numbered pictures or a pattern such as `a/####.png`; the motion is one of
//! EXR files with the layers `motion.X`, `motion.Y` and `depth.Z`, as `chiaro gbuffer` writes them.
//! A pixel is followed to where its motion vector points one frame before, if the depth there is
//! within 2 % of its own.

use crate::disk;
use crate::record::Record;
use crate::sequence::numbered;
use chiaro_basis::{Error, Result, Run};
use chiaro_binary::{Flicker, Shown};
use chiaro_image::Plane;
use chiaro_image::codec::{ExrImage, Format, Limits, read_components, read_exr, read_pbm};
use chiaro_trace::UNLINKED;
use serde_json::{Value, json};
use std::path::Path;

/// Share of a pixel's depth within which the depth one frame before counts as the same surface.
const SAME_DEPTH: f32 = 0.02;

/// Whether a path names a film.
pub fn is_film(path: &Path) -> bool {
    path.is_dir() || path.to_string_lossy().contains('#')
}

/// Measures both films along the motion of the frames that all three have.
pub fn compare_films(a: &Path, b: &Path, motion: &Path, run: &Run) -> Result<Record> {
    let (of_a, of_b, flow) = (numbered(a)?, numbered(b)?, numbered(motion)?);
    let shared: Vec<u32> =
        of_a.keys().copied().filter(|n| of_b.contains_key(n) && flow.contains_key(n)).collect();
    if shared.len() < 2 {
        let why = "the two films and the motion share fewer than two frame numbers";
        return Err(Error::input(a.display().to_string(), "", why));
    }
    let mut sums = [Flicker::default(), Flicker::default()];
    let mut depth_before = None;
    for &n in &shared {
        run.check()?;
        let layers = run.stage("load", 1, || Layers::read(&flow[&n]))?;
        let links = layers.links(depth_before.as_ref());
        for (sum, file) in sums.iter_mut().zip([&of_a[&n], &of_b[&n]]) {
            let labels = run.stage("load", 1, || labels(file))?;
            if labels.size() != layers.depth.size() {
                let why = "its size is not that of the motion; render both at one size";
                return Err(Error::input(file.display().to_string(), "", why));
            }
            let covered = layers.depth.map(|z| is_seen(*z));
            let shown = Shown {
                labels: &labels,
                covered: &covered,
                links: &links,
                alone: &labels,
                tone: &labels,
                energy: [0; 2],
            };
            sum.add(n as usize, &shown);
        }
        depth_before = Some((n, layers.depth));
    }
    let mut record = Record::new("compare");
    record.count("frames", shared.len());
    for (name, sum) in ["a", "b"].into_iter().zip(&sums) {
        record.count(name, measures(sum));
    }
    let [a, b] = sums.map(|s| s.reversals_per_pixel());
    record.count("reversals_a_over_b", if b > 0.0 { json!(a / b) } else { Value::Null });
    Ok(record)
}

fn measures(flicker: &Flicker) -> Value {
    json!({
        "flips_per_pixel": flicker.flips_per_pixel(),
        "reversals_per_pixel": flicker.reversals_per_pixel(),
        "pop_p99_px": flicker.pop_p99(),
        "visible_pixels": flicker.visible,
    })
}

/// 1, white, where the displayed luminance is at least one half.
fn labels(file: &Path) -> Result<Plane<u8>> {
    let bytes = disk::read(file)?;
    let name = file.display().to_string();
    if Format::of(&bytes) == Some(Format::Pbm) {
        return Ok(read_pbm(&bytes, &name, &Limits::default())?.map(|white| u8::from(*white)));
    }
    let picture = read_components(&bytes, &name, &Limits::default())?;
    Ok(picture.map(|[r, g, b, a]| {
        let value = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        u8::from(value * a + 1.0 - a >= 0.5)
    }))
}

struct Layers {
    motion: [Plane<f32>; 2],
    depth: Plane<f32>,
}

impl Layers {
    fn read(file: &Path) -> Result<Self> {
        let name = file.display().to_string();
        let image = read_exr(&disk::read(file)?, &name, &Limits::default())?;
        let layer = |image: &ExrImage, layer: &str| {
            image.f32(layer).cloned().ok_or_else(|| {
                let why = "has no such layer; write it with chiaro gbuffer";
                Error::input(name.clone(), layer.to_owned(), why)
            })
        };
        let motion = [layer(&image, "motion.X")?, layer(&image, "motion.Y")?];
        Ok(Self { motion, depth: layer(&image, "depth.Z")? })
    }

    /// Where each pixel was in a frame of such depths.
    fn links(&self, before: Option<&(u32, Plane<f32>)>) -> Plane<u32> {
        let (w, h) = self.depth.size();
        Plane::from_fn(w, h, |x, y| {
            let (Some((_, before)), true) = (before, is_seen(self.depth[(x, y)])) else {
                return UNLINKED;
            };
            let (mx, my) = (self.motion[0][(x, y)], self.motion[1][(x, y)]);
            let (u, v) = (x as f32 + 0.5 + mx, y as f32 + 0.5 + my);
            let (bw, bh) = before.size();
            if !(u >= 0.0 && v >= 0.0 && u < bw as f32 && v < bh as f32) || (bw, bh) != (w, h) {
                return UNLINKED;
            }
            let at = (u as usize, v as usize);
            let (here, there) = (self.depth[(x, y)], before[at]);
            let same = is_seen(there) && (there - here).abs() <= SAME_DEPTH * here;
            if same { (at.1 * w + at.0) as u32 } else { UNLINKED }
        })
    }
}

/// Whether a depth is one of geometry.
fn is_seen(depth: f32) -> bool {
    depth > 0.0 && depth < 1e9
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_image::codec::{ExrChannel, write_exr, write_pbm};
    use std::collections::BTreeMap;

    /// A square that moves a pixel to the right each frame; in film `b` it also blinks.
    fn write(folder: &Path) {
        for n in 1..=6u32 {
            let inside = |x: usize, y: usize| {
                (4 + n as usize..12 + n as usize).contains(&x) && (4..12).contains(&y)
            };
            let depth = Plane::from_fn(24, 16, |x, y| if inside(x, y) { 2.0 } else { 0.0 });
            let layers = vec![
                ("motion.X".into(), ExrChannel::F32(Plane::filled(24, 16, -1.0))),
                ("motion.Y".into(), ExrChannel::F32(Plane::filled(24, 16, 0.0))),
                ("depth.Z".into(), ExrChannel::F32(depth)),
            ];
            let image = ExrImage { size: (24, 16), layers, attributes: BTreeMap::new() };
            let file = |kind: &str| folder.join(format!("{kind}{n:04}"));
            std::fs::write(file("m").with_extension("exr"), write_exr(&image).unwrap()).unwrap();
            let still = Plane::from_fn(24, 16, |x, y| inside(x, y) && y < 8);
            let blinks = Plane::from_fn(24, 16, |x, y| inside(x, y) && n % 2 == 0);
            std::fs::write(file("a").with_extension("pbm"), write_pbm(&still)).unwrap();
            std::fs::write(file("b").with_extension("pbm"), write_pbm(&blinks)).unwrap();
        }
    }

    #[test]
    fn a_film_that_blinks_flickers_and_one_that_moves_does_not() {
        let dir = tempfile::tempdir().unwrap();
        write(dir.path());
        let at = |name: &str| dir.path().join(name);
        let (a, b, m) = (at("a####.pbm"), at("b####.pbm"), at("m####.exr"));
        let record = compare_films(&a, &b, &m, &Run::default()).unwrap();
        assert_eq!(record.counts["a"]["flips_per_pixel"], 0.0);
        assert_eq!(record.counts["b"]["flips_per_pixel"], 1.0);
        assert_eq!(record.counts["b"]["reversals_per_pixel"], 0.8);
        assert_eq!(record.counts["a"]["visible_pixels"], 5 * 64);
        let error = compare_films(&a, &b, &at("x####.exr"), &Run::default()).unwrap_err();
        assert!(error.to_string().contains("no numbered file"), "{error}");
    }
}
