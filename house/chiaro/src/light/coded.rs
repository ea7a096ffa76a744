//! Gathers from a tree, stored as the knobs say, and from its oracle.

use super::shot::Shot;
use chiaro_basis::{Result, Run};
use chiaro_pbgi::compact::Builder;
use chiaro_pbgi::{Indirect, LightKnobs, Lit, indirect, prepare, stream};
use chiaro_trace::GBuffer;
use serde_json::{Map, Value, json};

/// What was gathered.
pub(super) struct Gathered {
    /// From the tree as it is stored.
    pub(super) found: Indirect,
    /// From the same tree before it was coded, where that was asked for.
    pub(super) exact: Option<Indirect>,
    /// Measures of the tree.
    pub(super) counts: Map<String, Value>,
}

/// Lights a frame, builds its tree and gathers from it at a buffer's pixels; with `oracle` also from the
/// tree that was not coded.
pub(super) fn gather(
    shot: &Shot,
    lit: &Lit,
    buffer: &GBuffer,
    knobs: &LightKnobs,
    oracle: bool,
    run: &Run,
) -> Result<Gathered> {
    let sparse = prepare(*lit, &shot.sites, knobs, run)?;
    let dead = sparse.surfels.dead_sides();
    if !knobs.is_compact() {
        let (surfels, bytes) = (sparse.surfels.all.len() as u64, sparse.tree.bytes());
        let nodes = sparse.tree.nodes.len();
        let found = indirect(&sparse, buffer, run)?;
        let counts = measures([surfels, nodes as u64, 0, bytes as u64], dead, &found);
        return Ok(Gathered { found, exact: None, counts });
    }
    let cube = stream::cube(lit, &shot.spread);
    let lessons = stream::sorted(&sparse.surfels.all, &cube);
    let book =
        run.stage("book", lessons.len() as u64, || stream::book(&lessons, &knobs.recipe(), run))?;
    drop(lessons);
    let words = book.words();
    let format = stream::format(book, cube, &shot.spread, &sparse.surfels);
    let tree = stream::build(&sparse, &shot.spread, Builder::new(format), "", run)?;
    let (bytes, nodes, records) = (tree.store.bytes(), tree.store.nodes(), tree.store.records);
    let (scene, _) = sparse.with_tree(tree);
    let found = indirect(&scene, buffer, run)?;
    let numbers = [shot.spread.count, nodes as u64, words as u64, bytes as u64];
    let mut counts = measures(numbers, dead, &found);
    counts.insert("records".into(), json!(records));
    let exact = match oracle {
        true => {
            let tree = stream::build_exact(&scene, &shot.spread, cube, run)?;
            Some(indirect(&scene.with_tree(tree).0, buffer, run)?)
        }
        false => None,
    };
    Ok(Gathered { found, exact, counts })
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
