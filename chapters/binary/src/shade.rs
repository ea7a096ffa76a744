//! The chapter's main line: weights, cut, islands, lines.

use crate::appearance::Channels;
use crate::cut::{Border, FeaturePairs, Graph, Labels};
use crate::exposure::{Exposure, MOST_STEPS, Sample, mixed_tone};
use crate::geometry::neighbour_factors;
use crate::knob::{BinaryKnobs, Model, scaled};
use crate::line::{Features, Lines};
use crate::paint::Paint;
use crate::plateau::{self, off_plateaus};
use crate::terminal::terminal;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_ink::smooth_coverage;
use chiaro_trace::GBuffer;
use std::borrow::Cow;
use std::ops::RangeInclusive;

/// One picture's input: geometry and appearance.
#[derive(Clone)]
pub struct View {
    /// What the camera sees.
    pub buffer: GBuffer,
    /// How it looks.
    pub channels: Channels,
}

/// What the cut and the lines need of a view.
pub struct Prepared {
    /// The graph in integers, painted pixels bound.
    pub graph: Graph,
    /// Which pairs of pixels are features.
    pub pairs: FeaturePairs,
    /// Where lines may run.
    pub features: Features,
}

/// Everything between the cut and the picture.
pub struct Steps {
    /// The graph in integers.
    pub graph: Graph,
    /// The minimal cut of that graph.
    pub labels: Labels,
    /// The labels with round borders and after the smallest-island rule; white where true.
    pub white: Plane<bool>,
    /// What round borders added to the energy by eight neighbours, in units of weight.
    pub round_energy: f64,
    /// What the rule added to the energy, in units of weight.
    pub island_energy: f64,
    /// How much of the border runs on features.
    pub border: Border,
    /// What is shown of them: white, too, in the haloes of what occludes.
    pub shown: Plane<bool>,
    /// How white each pixel is once the borders are smooth.
    pub region: Plane<f32>,
    /// Lines on top.
    pub lines: Lines,
}

/// The weights of one view.
pub struct Weights {
    /// W - B (3.1).
    pub difference: Plane<f32>,
    /// The graph in integers.
    pub graph: Graph,
    /// Which pairs of pixels are features.
    pub pairs: FeaturePairs,
}

impl Weights {
    /// Mixes in what strokes teach, and binds what they paint.
    pub fn paint(&mut self, paint: &Paint) {
        self.difference = paint.mixed(&self.difference);
        self.graph.set_difference(&self.difference);
        paint.bind(&mut self.graph);
    }
}

/// Black and white for one view. `paper_is_white` says what lines are drawn against outside.
pub fn shade(
    view: &View,
    exposure: &Exposure,
    knobs: &BinaryKnobs,
    paper_is_white: bool,
    run: &Run,
) -> Result<Steps> {
    let prepared = prepare(Cow::Borrowed(view), exposure, knobs, None, run)?;
    prepared.cut(None, paper_is_white, knobs, run)
}

/// Weights, graph and features of a view, with strokes painted on it. An owned view is let go as
/// soon as each part has served, so that large pictures need memory for the geometry or for the
/// cut, not for both.
pub fn prepare(
    view: Cow<'_, View>,
    exposure: &Exposure,
    knobs: &BinaryKnobs,
    paint: Option<&Paint>,
    run: &Run,
) -> Result<Prepared> {
    let pixels = view.buffer.covered.len() as u64;
    let difference = run.stage("weights", pixels, || terminal(&view, exposure, knobs));
    run.check()?;
    let view = without_channels(view);
    let features = run.stage("lines", pixels, || Features::find(&view.buffer, knobs));
    let view = without_lines(view);
    run.stage("weights", pixels, || {
        let buffer = match view {
            Cow::Owned(view) => Cow::Owned(view.buffer),
            Cow::Borrowed(view) => Cow::Borrowed(&view.buffer),
        };
        let difference = || match paint {
            Some(paint) => Cow::Owned(paint.mixed(&difference)),
            None => Cow::Borrowed(&difference),
        };
        let (mut graph, pairs) = Graph::of(buffer, difference, knobs);
        if let Some(paint) = paint {
            paint.bind(&mut graph);
        }
        Ok(Prepared { graph, pairs, features })
    })
}

fn without_channels(view: Cow<'_, View>) -> Cow<'_, View> {
    match view {
        Cow::Owned(view) => Cow::Owned(View { buffer: view.buffer, channels: Channels::default() }),
        borrowed => borrowed,
    }
}

/// Lets go of what only lines need of the geometry.
fn without_lines(view: Cow<'_, View>) -> Cow<'_, View> {
    match view {
        Cow::Owned(mut view) => {
            view.buffer.smooth_normal = Plane::default();
            view.buffer.depth = Plane::default();
            Cow::Owned(view)
        }
        borrowed => borrowed,
    }
}

impl Prepared {
    /// Cuts, removes islands, draws lines.
    pub fn cut(
        self,
        paint: Option<&Paint>,
        paper_is_white: bool,
        knobs: &BinaryKnobs,
        run: &Run,
    ) -> Result<Steps> {
        let Self { graph, pairs, features } = self;
        let pixels = graph.mask.len() as u64;
        let labels = run.stage("cut", pixels, || graph.solve())?;
        run.check()?;
        let area = knobs.island_area(graph.mask.height());
        let round = run.stage("round", pixels, || graph.rounded(&labels.white, knobs))?;
        let rounded = graph.energy(&round);
        let mut white = graph.without_islands(&round, area);
        if let Some(paint) = paint {
            white = paint.kept(&white, &graph.mask);
        }
        let weight = |units: i64| units as f64 / f64::from(graph.scale);
        let round_energy = weight(rounded - labels.cut);
        let island_energy = if area > 0.0 { weight(graph.energy(&white) - rounded) } else { 0.0 };
        let border = Border::measure(&white, &graph.mask, &pairs);
        let (shown, (region, lines)) = run.stage("lines", pixels, || {
            let outlined = outline(&features, &white, &graph.mask, paper_is_white, knobs);
            (features.haloed(&white), outlined)
        });
        Ok(Steps {
            graph,
            labels,
            white,
            round_energy,
            island_energy,
            border,
            shown,
            region,
            lines,
        })
    }
}

/// Terminal and neighbour weights, and the graph that they make.
pub fn weigh(view: &View, exposure: &Exposure, knobs: &BinaryKnobs, run: &Run) -> Result<Weights> {
    let covered = &view.buffer.covered;
    let weights = run.stage("weights", covered.len() as u64, || {
        let difference = terminal(view, exposure, knobs);
        let (graph, pairs) =
            Graph::of(Cow::Borrowed(&view.buffer), || Cow::Borrowed(&difference), knobs);
        Weights { difference, graph, pairs }
    });
    run.check()?;
    Ok(weights)
}

/// The regions with smooth borders, and the lines between what they show: slivers that smoothing
/// takes away need a line in their place.
pub fn outline(
    features: &Features,
    white: &Plane<bool>,
    covered: &Plane<bool>,
    paper_is_white: bool,
    knobs: &BinaryKnobs,
) -> (Plane<f32>, Lines) {
    let white = features.haloed(white);
    let region = smooth_coverage(&white, covered, scaled(knobs.smooth, covered.height()));
    let shown = region.map(|w| *w >= 0.5);
    let lines = Lines::between(features, &shown, covered, paper_is_white, knobs);
    (region, lines)
}

/// The exposure of a shot from a few small views of it: levels and threshold by survey, then the
/// threshold moved as little as brings the share of black into the style's band, and the steps of
/// palettes. The thesis's model, which knows no exposure, is helped out only where all or nothing
/// would be black.
pub fn expose(views: &[View], shadows: bool, knobs: &BinaryKnobs, run: &Run) -> Result<Exposure> {
    let survey = Survey {
        views,
        factors: views.iter().map(|v| neighbour_factors(&v.buffer, knobs)).collect(),
        knobs,
        run,
    };
    let mut exposure = match knobs.model {
        Model::Thesis => {
            let printed = Exposure { shadows, ..Exposure::default() };
            survey.within_band(printed, 0.02..=0.98)?
        }
        Model::Tone => {
            let samples = |v: &View| Sample {
                tone: mixed_tone(&v.channels, &v.buffer.covered, knobs),
                covered: v.buffer.covered.clone(),
            };
            let samples: Vec<Sample> = views.iter().map(samples).collect();
            let exposure = Exposure::survey(&samples, shadows, knobs);
            let band = knobs.black_min..=knobs.black_max.max(knobs.black_min);
            off_plateaus(views, &survey.factors, survey.within_band(exposure, band)?, knobs)
        }
    };
    if !knobs.palette.is_empty() {
        for tones in 3..=MOST_STEPS + 1 {
            let steps = plateau::steps(views, &survey.factors, &exposure, knobs, tones);
            exposure.set_steps(tones, &steps);
        }
    }
    Ok(exposure)
}

/// The views that a shot is exposed on.
struct Survey<'a> {
    views: &'a [View],
    factors: Vec<Plane<[f32; 4]>>,
    knobs: &'a BinaryKnobs,
    run: &'a Run,
}

impl Survey<'_> {
    /// Bisects the threshold until the share of black is within the band. Where it jumps over the
    /// band, as on one flat tone, the side that is nearer is taken, and of two alike the lighter.
    fn within_band(&self, exposure: Exposure, band: RangeInclusive<f32>) -> Result<Exposure> {
        let off = |share: f32| (band.start() - share).max(share - band.end()).max(0.0);
        let first = self.share_of_black(&exposure)?;
        if first.is_nan() || off(first) == 0.0 {
            return Ok(exposure);
        }
        let darker = first < *band.start();
        let (mut near, mut far) =
            (exposure.threshold, exposure.threshold + if darker { 1.5 } else { -1.5 });
        let mut best = (off(first), first, exposure);
        for _ in 0..9 {
            let middle = Exposure { threshold: 0.5 * (near + far), ..exposure };
            let share = self.share_of_black(&middle)?;
            if (off(share), share) <= (best.0, best.1) || off(share) == 0.0 {
                best = (off(share), share, middle);
            }
            // Inside the band it comes back, as near to the first threshold as the band allows.
            let too_far = off(share) == 0.0 || (share < *band.start()) != darker;
            if too_far { far = middle.threshold } else { near = middle.threshold }
        }
        Ok(best.2)
    }

    /// The share of covered pixels that the cut leaves black, over all views; NaN without any.
    fn share_of_black(&self, exposure: &Exposure) -> Result<f32> {
        let (mut black, mut all) = (0usize, 0usize);
        for (view, factors) in self.views.iter().zip(&self.factors) {
            self.run.check()?;
            let covered = &view.buffer.covered;
            let difference = terminal(view, exposure, self.knobs);
            let labels = Graph::new(covered, &difference, factors, self.knobs).solve()?;
            let count = covered.pixels().iter().filter(|c| **c).count();
            all += count;
            black += count - labels.white.pixels().iter().filter(|w| **w).count();
        }
        Ok(black as f32 / all as f32)
    }
}
