//! Figure `6.books`: does a book that learned elsewhere do as well as a scene's own (thesis, 6.7: one
//! table for several scenes)?
//!
//! Every scene is coded with the book of its own sparse surfels, with one that learned from all the
//! other scenes, and with one that learned from these turned at random and in random colours, so that its
//! words know every direction and hue. What differs is told in decibels of the displayed picture and in the
//! 99th percentile of a node's error.

use super::chart::table;
use super::lessons::{DENSE, SIZE, SPARSE};
use super::quantized::{Measured, name_of};
use crate::light::{nearness, still};
use chiaro_basis::{Result, Run};
use chiaro_image::sheet::Sheet;
use chiaro_pbgi::LightKnobs;
use chiaro_pbgi::code::{Book, Gains, Pen, Recipe};
use chiaro_pbgi::packed::Packed;
use chiaro_pbgi::stream::{self, Lesson};
use serde_json::{Value, json};

const SCENES: [&str; 6] = [
    "demo:cornell-box",
    "demo:courtyard",
    "demo:sphere-field",
    "demo:desk",
    "demo:head",
    "demo:rocks",
];

pub(super) const FIGURES: [Measured; 1] = [Measured {
    name: "6.books",
    title: "books of other scenes",
    message: "Decibels of the displayed picture to the same tree in floats, and the 99th percentile of a \
              node's relative error: the scene's own book; one of all the other scenes; one of these turned at \
              random and in random colours.",
    columns: 1,
    scenes: &SCENES,
    draw: books,
}];

/// Where a book's lessons come from.
const SOURCES: [&str; 3] = ["own", "others", "others, varied"];

fn recipes() -> [(&'static str, Recipe); 3] {
    [
        ("default, 9 bytes", Recipe::default()),
        ("gains of colours, 13 bytes", Recipe::residual(Gains::Colours, false, 4, 3)),
        ("colour times shape, 10 bytes", Recipe::shapes(4096, 4096)),
    ]
}

fn books(scenes: &[String], sheet: &mut Sheet, run: &Run) -> Result<Vec<Value>> {
    let knobs = LightKnobs { bounces: 1, edges: 2, ..LightKnobs::default() };
    let most = stream::LESSONS / scenes.len().saturating_sub(1).max(1);
    let lessons = scenes
        .iter()
        .map(|scene| {
            still(scene, SIZE, &knobs, run, |at| {
                let sparse = at.records(&at.points(SPARSE, run)?);
                Ok((stream::lessons(&sparse, stream::LESSONS), stream::lessons(&sparse, most)))
            })
        })
        .collect::<Result<Vec<_>>>()?;
    let mut values = Vec::new();
    let mut rows = vec![vec![String::from("scene"), "code".into()]];
    rows[0].extend(SOURCES.map(|s| format!("{s}: dB / p99 %")));
    for (i, scene) in scenes.iter().enumerate() {
        let others = lessons.iter().enumerate().filter(|(k, _)| *k != i);
        let others: Vec<Lesson> = others.flat_map(|(_, (_, few))| few).copied().collect();
        let varied: Vec<Lesson> =
            others.iter().enumerate().map(|(k, l)| l.varied(k as u64)).collect();
        let all = [&lessons[i].0, &others, &varied];
        still(scene, SIZE, &knobs, run, |at| {
            let mut points = at.points(DENSE, run)?;
            let (records, cube) = (at.records(&points), at.cube(DENSE));
            let exact = Packed::build(&records);
            let mut nodes = Vec::new();
            exact.each_node(|node, sums| {
                nodes.push(Lesson { area: node.area, axis: node.axis, sums: *sums });
            });
            points.tree = Box::new(exact);
            let truth = at.shown(&at.seen(&points, run)?, false);
            for (name, recipe) in recipes() {
                let mut row = vec![name_of(scene).to_owned(), name.to_owned()];
                for (source, lessons) in SOURCES.iter().zip(all) {
                    let book = stream::taught(lessons, &recipe, run)?;
                    points.tree = Box::new(stream::coded_in_memory(&records, cube, &book)?);
                    let near = nearness(&at.shown(&at.seen(&points, run)?, false), &truth)?;
                    let p99 = p99(&book, &nodes);
                    let psnr = near.psnr.map_or("same".into(), |p| format!("{p:.1}"));
                    row.push(format!("{psnr} / {:.1}", 100.0 * p99));
                    values.push(json!({
                        "scene": scene, "code": name, "book": source, "psnr_db": near.psnr,
                        "p99_node_error": p99,
                    }));
                }
                rows.push(row);
            }
            Ok(())
        })?;
    }
    sheet.add(table(&rows), "decibels / 99th percentile of a node's error");
    Ok(values)
}

/// The 99th percentile of a lit node's own error.
fn p99(book: &Book, nodes: &[Lesson]) -> f64 {
    let mut pen = Pen::default();
    let squares = nodes.iter().map(|n| book.error(&n.lobes(), &mut pen));
    let lit = squares.filter(|[_, there]| *there > 0.0);
    let mut own: Vec<f64> = lit.map(|[wrong, there]| (wrong / there).sqrt()).collect();
    own.sort_by(f64::total_cmp);
    own.get(own.len() * 99 / 100).copied().unwrap_or(0.0)
}
