//! Figures 6.1 and 6.5 to 6.10: the thesis's quantization on our scenes, as pictures and curves.

use super::chart::{Axis, COLOURS, Chart, Scale, Series};
use super::lessons::{self, DENSE, SIZE, SPARSE};
use super::{books, measured};
use crate::light::{AnyTree, Still, nearness, still};
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_image::colour::to_byte;
use chiaro_image::sheet::Sheet;
use chiaro_pbgi::Prepared;
use chiaro_pbgi::classic::{Classic, Leaf};
use chiaro_pbgi::code::{Book, Recipe, Words};
use chiaro_pbgi::packed::Record;
use serde_json::{Value, json};

/// A figure that takes scenes and hands out its measures.
pub(super) struct Measured {
    pub(super) name: &'static str,
    pub(super) title: &'static str,
    pub(super) message: &'static str,
    pub(super) columns: usize,
    /// Scenes where none is named.
    pub(super) scenes: &'static [&'static str],
    pub(super) draw: fn(&[String], &mut Sheet, &Run) -> Result<Vec<Value>>,
}

/// The figures and tables of chapter 6.
pub(super) fn all() -> impl Iterator<Item = &'static Measured> {
    FIGURES.iter().chain(&measured::FIGURES).chain(&books::FIGURES)
}

const ROOM: [&str; 1] = ["demo:cornell-box"];
const SCENES: [&str; 3] = ["demo:cornell-box", "demo:courtyard", "demo:sphere-field"];
const COMPLEX: [&str; 1] = ["demo:courtyard:8"];

const FIGURES: [Measured; 6] = [
    Measured {
        name: "6.1",
        title: "the unquantized tree and 10 000 words",
        message: "Left: lobes of 3 bands in floats, 108 bytes a node. Right: an index of 14 bits a node. The \
                  thesis prints 66 dB for its scene.",
        columns: 2,
        scenes: &ROOM,
        draw: visual,
    },
    Measured {
        name: "6.5",
        title: "sparse and dense sampling",
        message: "Surfels from whose tree words are learned, and those of the picture; a tenth as many. Each \
                  disc in the light that it sends, drawn at 0.7 of its radius on grey.",
        columns: 2,
        scenes: &SCENES,
        draw: sampling,
    },
    Measured {
        name: "6.7",
        title: "error over the number of words",
        message: "Mean over every fourth inner node of the mean absolute error of their 27 numbers, over the mean \
                  absolute number. Random words against k-means on raw sums (the thesis's), and k-means on \
                  sums over area. The thesis's curves are of another scene and have no printed numbers: \
                  what must agree is that k-means lies below random words and both fall with k.",
        columns: 2,
        scenes: &SCENES,
        draw: errors,
    },
    Measured {
        name: "6.8",
        title: "indirect light by 100, 1000 and 10 000 words",
        message: "Truth: the thesis's tree with lobes in floats, leaf A. Below each picture where an eye \
                  sees a difference (Yee 2004), blue. First rows: k-means from random vectors; last rows: \
                  random words. Gathers are shared by tiles; the thesis gathers at every pixel.",
        columns: 4,
        scenes: &SCENES,
        draw: comparison,
    },
    Measured {
        name: "6.9",
        title: "learning from 0.1, 1 and 10 % of the surfels",
        message: "1000 words, or as many as there are nodes to learn from. The thesis sees no difference \
                  from 10 to 1 %, and wrong colours at 0.1 %.",
        columns: 4,
        scenes: &SCENES,
        draw: fractions,
    },
    Measured {
        name: "6.10",
        title: "a larger scene by 10 000 words",
        message: "All light; the thesis's tree with leaf B.",
        columns: 1,
        scenes: &COMPLEX,
        draw: larger,
    },
];

/// A scene's records, and the tree whose lobes are in floats with its picture.
struct Truth<'a> {
    points: Prepared<'a, AnyTree>,
    records: Vec<Record>,
    shown: Plane<[f32; 3]>,
}

fn truth<'a>(at: &'a Still, run: &Run) -> Result<Truth<'a>> {
    let mut points = at.points(DENSE, run)?;
    let records = at.sides(&points);
    points.tree = Box::new(Classic::exact(&records, Leaf::A));
    let shown = at.shown(&at.seen(&points, run)?, true);
    Ok(Truth { points, records, shown })
}

impl Truth<'_> {
    /// The picture by a tree that is coded with a book.
    fn coded(&mut self, at: &Still, book: &Book, run: &Run) -> Result<Plane<[f32; 3]>> {
        self.points.tree = Box::new(Classic::coded(&self.records, Leaf::A, book));
        Ok(at.shown(&at.seen(&self.points, run)?, true))
    }
}

fn bytes(picture: &Plane<[f32; 3]>) -> Plane<[u8; 3]> {
    picture.map(|p| p.map(to_byte))
}

fn decibels(psnr: Option<f64>) -> String {
    psnr.map_or("equal".into(), |p| format!("{p:.1} dB"))
}

pub(super) fn name_of(scene: &str) -> &str {
    scene.rsplit(['/', ':']).find(|p| p.parse::<u32>().is_err()).unwrap_or(scene)
}

/// The thesis's recipe, with words of a kind.
fn words(count: usize, kind: Words) -> Recipe {
    Recipe { words: kind, ..Recipe::thesis(count) }
}

fn visual(scenes: &[String], sheet: &mut Sheet, run: &Run) -> Result<Vec<Value>> {
    let mut rows = Vec::new();
    for scene in scenes {
        still(scene, SIZE, &lessons::knobs(), run, |at| {
            let mut truth = truth(at, run)?;
            let all = at.shown(&at.seen(&truth.points, run)?, false);
            let book = lessons::book(at, SPARSE, &words(10_000, Words::FromRandom), run)?;
            truth.coded(at, &book, run)?;
            let own = at.shown(&at.seen(&truth.points, run)?, false);
            let near = nearness(&own, &all)?;
            sheet.add(bytes(&all), format!("{}: unquantized", name_of(scene)));
            let text = format!("10 000 words: {} (thesis 66 dB)", decibels(near.psnr));
            sheet.add(bytes(&own), text);
            rows.push(json!({
                "scene": scene, "words": 10_000, "psnr_db": near.psnr, "thesis_psnr_db": 66.0,
                "different_share": near.different,
            }));
            Ok(())
        })?;
    }
    Ok(rows)
}

fn sampling(scenes: &[String], sheet: &mut Sheet, run: &Run) -> Result<Vec<Value>> {
    let mut rows = Vec::new();
    for scene in scenes {
        still(scene, SIZE, &lessons::knobs(), run, |at| {
            // Fewer than in other figures, so that discs can be seen.
            for count in [SPARSE / 4, 5 * SPARSE / 2] {
                let points = at.points(count, run)?;
                let text = format!("{}: {count} surfels", name_of(scene));
                sheet.add(bytes(&at.discs(&points)), text);
                rows.push(json!({ "scene": scene, "surfels": count }));
            }
            Ok(())
        })?;
    }
    Ok(rows)
}

fn errors(scenes: &[String], sheet: &mut Sheet, run: &Run) -> Result<Vec<Value>> {
    let mut rows = Vec::new();
    for scene in scenes {
        let mut series: Vec<Series> = Vec::new();
        still(scene, SIZE, &lessons::knobs(), run, |at| {
            let dense = at.points(DENSE, run)?;
            let all = lessons::nodes(&Classic::exact(&at.sides(&dense), Leaf::A));
            let nodes = all.into_iter().step_by(4).collect();
            let taught = lessons::of(at, SPARSE, run)?;
            let by_area = Recipe { words: Words::FromRandom, ..Recipe::clusters(1) };
            for (name, colour, way) in [
                ("random words", COLOURS[1], words(1, Words::Drawn)),
                ("k-means, raw sums", COLOURS[0], words(1, Words::FromRandom)),
                ("k-means, over area", COLOURS[2], by_area),
            ] {
                let mut points = Vec::new();
                for k in [16, 64, 256, 1024, 4096, 16_384, 65_536] {
                    // A table cannot have more words than there are nodes to learn from.
                    if k > taught.len() {
                        continue;
                    }
                    let recipe = Recipe { light: vec![k], area: Vec::new(), ..way.clone() };
                    let book = lessons::train(&taught, &recipe, run)?;
                    let error = lessons::mean_error(&nodes, &book);
                    points.push([k as f64, error]);
                    rows.push(json!({ "scene": scene, "words": k, "way": name, "error": error }));
                }
                series.push(Series { name: name.into(), colour, points, joined: true });
            }
            Ok(())
        })?;
        let x = Axis { name: "words", scale: Scale::Log };
        let y = Axis { name: "relative error", scale: Scale::Log };
        sheet.add(Chart { x, y, series }.draw((680, 400)), name_of(scene));
    }
    Ok(rows)
}

/// Where an eye sees a difference: blue on black.
fn seen_map(map: &Plane<bool>) -> Plane<[u8; 3]> {
    map.map(|d| if *d { [40, 90, 255] } else { [0; 3] })
}

fn comparison(scenes: &[String], sheet: &mut Sheet, run: &Run) -> Result<Vec<Value>> {
    let mut rows = Vec::new();
    for scene in scenes {
        still(scene, SIZE, &lessons::knobs(), run, |at| {
            let mut truth = truth(at, run)?;
            let taught = lessons::of(at, SPARSE, run)?;
            for (kind, title) in [(Words::FromRandom, "k-means"), (Words::Drawn, "random")] {
                let mut pictures = Vec::new();
                for k in [100, 1000, 10_000] {
                    let book = lessons::train(&taught, &words(k, kind), run)?;
                    let picture = truth.coded(at, &book, run)?;
                    let near = nearness(&picture, &truth.shown)?;
                    let text = format!(
                        "{k} {title}: {} / {:.2} %",
                        decibels(near.psnr),
                        100.0 * near.different
                    );
                    rows.push(json!({
                        "scene": scene, "words": k, "kind": title, "psnr_db": near.psnr,
                        "different_share": near.different,
                    }));
                    pictures.push((picture, near.map, text));
                }
                sheet.add(bytes(&truth.shown), format!("{}: truth", name_of(scene)));
                for (picture, _, text) in &pictures {
                    sheet.add(bytes(picture), text.clone());
                }
                let none = Plane::filled(SIZE.0, SIZE.1, [255; 3]);
                sheet.add(none, "PSNR / pixels that an eye tells apart");
                for (_, map, _) in &pictures {
                    sheet.add(seen_map(map), "");
                }
            }
            Ok(())
        })?;
    }
    Ok(rows)
}

fn fractions(scenes: &[String], sheet: &mut Sheet, run: &Run) -> Result<Vec<Value>> {
    let mut rows = Vec::new();
    for scene in scenes {
        still(scene, SIZE, &lessons::knobs(), run, |at| {
            let mut truth = truth(at, run)?;
            sheet.add(bytes(&truth.shown), format!("{}: truth", name_of(scene)));
            for share in [0.001, 0.01, 0.1] {
                let count = (share * DENSE as f64) as usize;
                let book = lessons::book(at, count, &words(1000, Words::FromRandom), run)?;
                let picture = truth.coded(at, &book, run)?;
                let near = nearness(&picture, &truth.shown)?;
                let text = format!(
                    "{} %: {} / {:.2} %",
                    100.0 * share,
                    decibels(near.psnr),
                    100.0 * near.different
                );
                sheet.add(bytes(&picture), text);
                rows.push(json!({
                    "scene": scene, "share": share, "psnr_db": near.psnr,
                    "different_share": near.different,
                }));
            }
            Ok(())
        })?;
    }
    Ok(rows)
}

fn larger(scenes: &[String], sheet: &mut Sheet, run: &Run) -> Result<Vec<Value>> {
    let mut rows = Vec::new();
    for scene in scenes {
        still(scene, (2 * SIZE.0, 2 * SIZE.1), &lessons::knobs(), run, |at| {
            let mut points = at.points(2 * DENSE, run)?;
            let records = at.sides(&points);
            let book = lessons::book(at, SPARSE, &words(10_000, Words::FromRandom), run)?;
            let tree = Classic::coded(&records, Leaf::B, &book);
            let (counted, leaves) = (tree.counted(), records.len());
            points.tree = Box::new(tree);
            let picture = at.shown(&at.seen(&points, run)?, false);
            let text = format!("{}: {leaves} leaves", name_of(scene));
            sheet.add(bytes(&picture), text);
            rows.push(json!({
                "scene": scene, "leaves": leaves, "bytes_as_thesis": counted.of_thesis(),
                "bytes": counted.all(),
            }));
            Ok(())
        })?;
    }
    Ok(rows)
}
