//! Books for the figures of chapter 6, and how far they are from nodes.

use crate::light::Still;
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run, reduce};
use chiaro_pbgi::classic::{Classic, Leaf};
use chiaro_pbgi::code::{Book, Lobes, Pen, Recipe};
use chiaro_pbgi::{Exact, LightKnobs};
use rayon::prelude::*;

/// Pictures of a figure.
pub(super) const SIZE: (usize, usize) = (320, 240);
/// Surfels of the picture, and those that teach: a tenth.
pub(super) const DENSE: usize = 200_000;
pub(super) const SPARSE: usize = 20_000;

/// Nodes with their areas.
pub(super) type Nodes = Vec<(f32, Exact)>;

/// The thesis's settings: one bounce, 8 x 8 texels a face, nodes splatted by their series alone.
pub(super) fn knobs() -> LightKnobs {
    LightKnobs {
        bounces: 1,
        resolution: 8,
        solid_angle: 1.0,
        flat_nodes: false,
        edges: 2,
        ..LightKnobs::default()
    }
}

/// The inner nodes of an exact tree.
pub(super) fn nodes(tree: &Classic) -> Nodes {
    let mut nodes = Vec::new();
    tree.each_node(|area, lobes| nodes.push((area, *lobes)));
    nodes
}

/// The nodes of a tree over so many surfels, lit by themselves.
pub(super) fn of(at: &Still, surfels: usize, run: &Run) -> Result<Nodes> {
    let points = at.points(surfels, run)?;
    Ok(nodes(&Classic::exact(&at.sides(&points), Leaf::A)))
}

/// A book that nodes teach.
pub(super) fn train(nodes: &Nodes, recipe: &Recipe, run: &Run) -> Result<Book> {
    let lobes = |(area, sums)| Lobes { sums, area, axis: Vec3::ZERO, both: 0.0 };
    let lessons: Vec<Lobes> = nodes.iter().map(|(area, sums)| lobes((*area, sums))).collect();
    Book::train(&lessons, recipe, 1, run)
}

/// A book that so many surfels teach.
pub(super) fn book(at: &Still, surfels: usize, recipe: &Recipe, run: &Run) -> Result<Book> {
    train(&of(at, surfels, run)?, recipe, run)
}

/// The mean over all nodes of the mean absolute error of their 27 numbers, over the mean absolute
/// number.
pub(super) fn mean_error(nodes: &Nodes, book: &Book) -> f64 {
    let one = |pen: &mut Pen, (area, sums): &(f32, Exact)| {
        let mut code = Vec::new();
        book.encode(&Lobes { sums, area: *area, axis: Vec3::ZERO, both: 0.0 }, &mut code, pen);
        let own = book.decode(&code, (*area, Vec3::ZERO, 0.0)).lobes;
        let pairs = sums.light.as_flattened().iter().zip(own.light.as_flattened());
        pairs.fold([0.0f64; 2], |[wrong, there], (a, b)| {
            [wrong + f64::from((a - b).abs()), there + f64::from(a.abs())]
        })
    };
    let parts: Vec<[f64; 2]> = nodes.par_iter().map_init(Pen::default, one).collect();
    let sum = |k: usize| reduce::sum(parts.len(), |i| parts[i][k]);
    sum(0) / sum(1).max(f64::MIN_POSITIVE)
}

/// The 99th percentile of a lit node's own relative error.
pub(super) fn p99_error(nodes: &Nodes, book: &Book) -> f64 {
    let one = |pen: &mut Pen, (area, sums): &(f32, Exact)| {
        book.error(&Lobes { sums, area: *area, axis: Vec3::ZERO, both: 0.0 }, pen)
    };
    let squares: Vec<[f64; 2]> = nodes.par_iter().map_init(Pen::default, one).collect();
    let lit = squares.into_iter().filter(|[_, there]| *there > 0.0);
    let mut own: Vec<f64> = lit.map(|[wrong, there]| (wrong / there).sqrt()).collect();
    own.sort_by(f64::total_cmp);
    own.get(own.len() * 99 / 100).copied().unwrap_or(0.0)
}
