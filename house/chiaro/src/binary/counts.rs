//! What records say of a labelled picture.

use chiaro_binary::{Border, Graph, Labels, REFERENCE_HEIGHT, Steps};
use chiaro_image::Plane;
use chiaro_image::labels::components;
use serde_json::{Map, Value, json};

/// The measures of a picture for the record.
pub(crate) fn stepped(steps: &Steps) -> Map<String, Value> {
    let mut counts =
        labelled(&steps.white, &steps.graph, &steps.labels, steps.island_energy, &steps.border);
    counts.insert("round_energy".into(), json!(steps.round_energy));
    counts
}

/// The measures of a labelled frame: its regions, its graph and that graph's own cut, what the
/// labels cost beyond it, and their border.
pub(crate) fn labelled(
    white: &Plane<bool>,
    graph: &Graph,
    cut: &Labels,
    beyond: f64,
    border: &Border,
) -> Map<String, Value> {
    let mut counts = shape(white, &graph.mask);
    let mut put = |name: &str, value: Value| counts.insert(name.into(), value);
    put("flow", json!(cut.flow));
    put("cut", json!(cut.cut));
    put("capacity_units", json!(graph.scale));
    put("island_energy", json!(beyond));
    put("boundary_px", json!(border.pairs));
    put("feature_share", json!(border.on_features));
    put("feature_share_by_chance", json!(border.by_chance));
    counts
}

/// What is counted on the regions alone.
pub(crate) fn shape(white: &Plane<bool>, covered: &Plane<bool>) -> Map<String, Value> {
    let nodes = covered.pixels().iter().filter(|c| **c).count();
    let whites = white.pixels().iter().filter(|w| **w).count();
    let pieces = components(white, covered).pieces;
    let small = 30.0 * (covered.height() as f32 / REFERENCE_HEIGHT).powi(2);
    let islands = pieces.iter().filter(|p| p.touches_other && (p.area as f32) < small).count();
    let share = if nodes == 0 { 0.0 } else { whites as f64 / nodes as f64 };
    let mut counts = Map::new();
    let mut put = |name: &str, value: Value| counts.insert(name.into(), value);
    put("pixels", json!(covered.len()));
    put("nodes", json!(nodes));
    put("white_fraction", json!(share));
    put("components", json!(pieces.len()));
    put("islands_under_30px", json!(islands));
    counts
}
