//! Gathers from a tree, stored as the knobs say, and from its oracle.

use super::baked;
use super::book;
use super::shot::Shot;
use crate::growing::Growing;
use chiaro_basis::{Result, Run};
use chiaro_pbgi::compact::{Builder, Compact};
use chiaro_pbgi::curve::Cube;
use chiaro_pbgi::packed::Packed;
use chiaro_pbgi::{
    Indirect, LightKnobs, Lit, Prepared, Wanted, coverage, indirect, indirect_of, prepare, stream,
};
use chiaro_trace::GBuffer;
use serde_json::{Map, Value, json};
use std::sync::PoisonError;

/// What was gathered.
pub(super) struct Gathered {
    /// From the tree as it is stored.
    pub(super) found: Indirect,
    /// From the same tree before it was coded, where that was asked for.
    pub(super) exact: Option<Indirect>,
    /// Measures of the tree.
    pub(super) counts: Map<String, Value>,
}

/// Lights a frame, builds its tree and gathers what is wanted from it at a buffer's pixels; with `oracle`
/// also from the tree that was not coded.
pub(super) fn gather(
    shot: &Shot,
    lit: &Lit,
    buffer: &GBuffer,
    knobs: &LightKnobs,
    (wanted, oracle): (Wanted, bool),
    run: &Run,
) -> Result<Gathered> {
    let dark = LightKnobs { bounces: 0, ..knobs.clone() };
    let knobs = if shot.black { &dark } else { knobs };
    let files = &shot.files;
    if let Some(cap) = &files.cap {
        cap.check(knobs, files.baked.is_some() || files.bake.is_some(), files.baked.is_some())?;
    }
    if !knobs.is_compact() {
        let sparse = shot.kept.prepare(*lit, (&shot.sites, &shot.focus), knobs, run)?;
        let dead = sparse.surfels.dead_sides();
        let (surfels, bytes) = (sparse.surfels.all.len() as u64, sparse.tree.bytes());
        let nodes = sparse.tree.nodes.len();
        let covered = coverage(lit, &sparse.surfels, &sparse.reflected.grid);
        let found = indirect_of(&sparse, buffer, wanted, run)?;
        let mut counts = measures([surfels, nodes as u64, 0, bytes as u64], dead, &found);
        counts.insert("surfel_coverage".into(), json!(covered));
        shot.kept.keep(sparse);
        return Ok(Gathered { found, exact: None, counts });
    }
    let sparse = prepare(*lit, &shot.sites, knobs, run)?;
    let dead = sparse.surfels.dead_sides();
    let cube = stream::cube(lit, &shot.spread);
    let (tree, told) = match &files.baked {
        Some(baked) => (baked.tree.clone(), Map::new()),
        None => built(shot, &sparse, cube, knobs, run)?,
    };
    let words = tree.store.format.book.words();
    let (bytes, nodes, records) = (tree.store.bytes(), tree.store.nodes(), tree.store.records);
    let sides = tree.store.sides();
    let (scene, _) = sparse.with_tree(tree);
    let found = indirect_of(&scene, buffer, wanted, run)?;
    let numbers = [shot.spread.count, nodes as u64, words as u64, bytes as u64];
    let mut counts = measures(numbers, dead, &found);
    counts.insert("records".into(), json!(records));
    counts.insert("living_sides".into(), json!(sides));
    counts.extend(told);
    if let Some(cap) = &files.cap {
        counts.insert("memory_cap".into(), json!(cap.bytes()));
        counts.insert("pages_given_back".into(), json!(cap.given_back()));
    }
    let exact = match oracle {
        true => {
            let tree = stream::build_exact(&scene, &shot.spread, cube, run)?;
            Some(indirect(&scene.with_tree(tree).0, buffer, run)?)
        }
        false => None,
    };
    Ok(Gathered { found, exact, counts })
}

/// Codes the tree, with the shot's book or one of its own, in memory or into a file that is then
/// mapped; and what is told of the book.
fn built(
    shot: &Shot,
    sparse: &Prepared,
    cube: Cube,
    knobs: &LightKnobs,
    run: &Run,
) -> Result<(Packed<Compact>, Map<String, Value>)> {
    let files = &shot.files;
    let records = stream::sorted(&sparse.surfels.all, &cube);
    let mut taught = match &files.book {
        Some(taught) => taught.clone(),
        None => book::taught(&stream::lessons(&records, knobs.lessons()), knobs, run)?,
    };
    if taught.foreign {
        taught.examine(&records, run);
    }
    drop(records);
    let told = taught.counts;
    let format = stream::format(taught.book, cube, &shot.spread, &sparse.surfels);
    let Some(path) = &files.bake else {
        let tree = stream::build(sparse, &shot.spread, Builder::new(format), "", run)?;
        return Ok((tree, told));
    };
    let mut file = Growing::create(path)?;
    let builder = Builder::into_file(format, Box::new(|bytes| file.write(bytes)))?;
    stream::build(sparse, &shot.spread, builder, &files.origin, run)?;
    let written = run.stage("write", 1, || file.finish())?;
    files.written.lock().unwrap_or_else(PoisonError::into_inner).push(written);
    Ok((baked::open(path, &files.origin, files.cap.as_ref(), run)?.tree, told))
}

fn measures(
    [surfels, nodes, words, bytes]: [u64; 4],
    dead: usize,
    found: &Indirect,
) -> Map<String, Value> {
    let mut counts = Map::new();
    for (name, value) in [
        ("surfels", json!(surfels)),
        ("dead_sides", json!(dead)),
        ("nodes", json!(nodes)),
        ("lut_entries", json!(words)),
        ("tree_bytes", json!(bytes)),
        ("bytes_per_surfel", json!(bytes as f64 / surfels.max(1) as f64)),
        ("gathers", json!(found.gathers)),
        ("visited_nodes", json!(found.visited)),
    ] {
        counts.insert(name.into(), value);
    }
    counts
}
