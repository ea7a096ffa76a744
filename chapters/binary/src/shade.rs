//! The chapter's main line: weights, cut, islands, lines.

use crate::appearance::Channels;
use crate::cut::{Border, Graph, Labels};
use crate::exposure::{Exposure, Sample, mixed_tone};
use crate::geometry::neighbour_factors;
use crate::island::without_islands;
use crate::knob::{BinaryKnobs, Model, scaled};
use crate::line::Lines;
use crate::terminal::terminal;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_ink::smooth_coverage;
use chiaro_trace::GBuffer;

/// One picture's input: geometry and appearance.
pub struct View {
    /// What the camera sees.
    pub buffer: GBuffer,
    /// How it looks.
    pub channels: Channels,
}

/// Everything between input and picture.
pub struct Steps {
    /// W - B (3.1).
    pub difference: Plane<f32>,
    /// Neighbour weights relative to N~ (3.2), to E, SE, S, SW.
    pub factors: Plane<[f32; 4]>,
    /// The graph in integers.
    pub graph: Graph,
    /// The minimal cut of that graph.
    pub labels: Labels,
    /// The labels after the smallest-island rule; white where true.
    pub white: Plane<bool>,
    /// What the rule added to the energy, in units of weight.
    pub island_energy: f64,
    /// How much of the border runs on features.
    pub border: Border,
    /// Lines on top.
    pub lines: Lines,
}

/// Black and white for one view. `paper_is_white` says what lines are drawn against outside.
pub fn shade(
    view: &View,
    exposure: &Exposure,
    knobs: &BinaryKnobs,
    paper_is_white: bool,
    run: &Run,
) -> Result<Steps> {
    let pixels = view.buffer.covered.len() as u64;
    let (difference, factors, graph) =
        run.stage("weights", pixels, || weigh(view, exposure, knobs));
    run.check()?;
    let labels = run.stage("cut", pixels, || graph.solve())?;
    run.check()?;
    let area = island_area(knobs, view.buffer.size().1);
    let white = without_islands(&labels.white, &graph.mask, area);
    let added = if area > 0.0 { graph.energy(&white) - labels.cut } else { 0 };
    let border = Border::measure(&white, &graph.mask, &factors);
    let lines = run.stage("lines", pixels, || {
        // Slivers that smoothing takes away need a line in their place.
        let sigma = scaled(knobs.smooth, view.buffer.size().1);
        let shown = smooth_coverage(&white, &graph.mask, sigma).map(|w| *w >= 0.5);
        Lines::find(&view.buffer, &shown, paper_is_white, knobs)
    });
    let island_energy = added as f64 / f64::from(graph.scale);
    Ok(Steps { difference, factors, graph, labels, white, island_energy, border, lines })
}

fn weigh(
    view: &View,
    exposure: &Exposure,
    knobs: &BinaryKnobs,
) -> (Plane<f32>, Plane<[f32; 4]>, Graph) {
    let covered = &view.buffer.covered;
    let difference = terminal(&view.channels, covered, exposure, knobs);
    let factors = neighbour_factors(&view.buffer, knobs);
    let graph = Graph::new(covered, &difference, &factors, knobs);
    (difference, factors, graph)
}

/// The smallest area that a piece keeps, in pixels of a picture of this height.
fn island_area(knobs: &BinaryKnobs, height: usize) -> f32 {
    knobs.island * scaled(1.0, height).powi(2)
}

/// The exposure of a shot from a few small views of it: levels and threshold by survey, then the
/// threshold moved as little as brings the share of black into the style's band.
pub fn expose(views: &[View], shadows: bool, knobs: &BinaryKnobs, run: &Run) -> Result<Exposure> {
    if knobs.model == Model::Thesis {
        return Ok(Exposure { shadows, ..Exposure::default() });
    }
    let samples: Vec<Sample> = views
        .iter()
        .map(|v| Sample {
            tone: mixed_tone(&v.channels, &v.buffer.covered, knobs),
            covered: v.buffer.covered.clone(),
        })
        .collect();
    let exposure = Exposure::survey(&samples, shadows, knobs);
    into_band(views, exposure, knobs, run)
}

/// Bisects the threshold until the share of black is within the style's band, or as near as it
/// gets.
fn into_band(
    views: &[View],
    exposure: Exposure,
    knobs: &BinaryKnobs,
    run: &Run,
) -> Result<Exposure> {
    let band = knobs.black_min..=knobs.black_max.max(knobs.black_min);
    let factors: Vec<_> = views.iter().map(|v| neighbour_factors(&v.buffer, knobs)).collect();
    let black = |e: &Exposure| -> Result<f32> {
        run.check()?;
        share_of_black(views, &factors, e, knobs)
    };
    let first = black(&exposure)?;
    if band.contains(&first) || first.is_nan() {
        return Ok(exposure);
    }
    let darker = first < *band.start();
    let (mut near, mut far) =
        (exposure.threshold, exposure.threshold + if darker { 1.5 } else { -1.5 });
    let mut best = exposure;
    for _ in 0..9 {
        best.threshold = 0.5 * (near + far);
        let share = black(&best)?;
        if band.contains(&share) {
            // Inside: come back as near to the first threshold as the band allows.
            far = best.threshold;
        } else if (share < *band.start()) == darker {
            near = best.threshold;
        } else {
            far = best.threshold;
        }
    }
    best.threshold = far;
    Ok(best)
}

/// The share of covered pixels that the cut leaves black, over all views; NaN without any.
fn share_of_black(
    views: &[View],
    factors: &[Plane<[f32; 4]>],
    exposure: &Exposure,
    knobs: &BinaryKnobs,
) -> Result<f32> {
    let (mut black, mut all) = (0usize, 0usize);
    for (view, factors) in views.iter().zip(factors) {
        let covered = &view.buffer.covered;
        let difference = terminal(&view.channels, covered, exposure, knobs);
        let labels = Graph::new(covered, &difference, factors, knobs).solve()?;
        let count = covered.pixels().iter().filter(|c| **c).count();
        all += count;
        black += count - labels.white.pixels().iter().filter(|w| **w).count();
    }
    Ok(black as f32 / all as f32)
}
