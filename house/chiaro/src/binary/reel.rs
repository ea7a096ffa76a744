//! A film of ink: frames are rendered in order, labelled in windows along the motion, and written.
//!
//! 1. The shot's blocks that hold a frame yet to be written are walked in order; a frame becomes a
//!    [`Take`] (its graph, its links, what lines need) and its geometry is let go once the next
//!    frame is linked to it.
//! 2. [`chiaro_binary::Film`] labels the takes; a labelled take is drawn, measured and written.
//!
//! Memory: two frames of geometry and at most `window` + `window` / 2 + 1 takes, some 60 bytes a
//! pixel each, whatever the film's length. A part of a film renders, beyond its own frames, those of
//! its blocks and of half a window around each key.

use super::counts;
use super::picture::Picture;
use super::shot::Shot;
use crate::colours::Colours;
use chiaro_basis::{Result, Run};
use chiaro_binary::{
    BinaryKnobs, Border, Cel, FeaturePairs, Features, Film, Flicker, Graph, Plan, Shown, Weights,
    compose, outline, scaled, weigh, without_islands,
};
use chiaro_image::{Plane, filter};
use chiaro_scene::{Frame, Poser};
use chiaro_trace::{GBuffer, Match, UNLINKED, links};
use serde_json::{Map, Value, json};

/// Pixels that a surface may be off the plane that was seen, for a link.
const OFF_PLANE: f32 = 2.0;

/// Share of the expected depth within which a point counts as seen, for the measures.
const SAME_DEPTH: f32 = 0.02;

/// How the frames of a film are labelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Labelling {
    /// In windows along the motion.
    Windows,
    /// Each by its own cut.
    Alone,
    /// Each by the sign of its blurred W - B, for comparison.
    Blurred,
}

impl Labelling {
    /// What the knobs ask for.
    pub(crate) fn of(knobs: &BinaryKnobs) -> Self {
        if knobs.coherence > 0.0 { Self::Windows } else { Self::Alone }
    }
}

/// A frame between rendering and writing.
struct Take {
    number: u32,
    cel: Cel,
    /// Links for the measures.
    sight: Plane<u32>,
    features: Features,
    pairs: FeaturePairs,
}

impl AsRef<Cel> for Take {
    fn as_ref(&self) -> &Cel {
        &self.cel
    }
}

/// Renders the frames of a shot in order.
struct Camera<'a, 's> {
    shot: &'s Shot<'a>,
    poser: Poser<'a>,
    numbers: Vec<u32>,
    before: Option<(usize, Frame, GBuffer)>,
}

impl Camera<'_, '_> {
    /// Frame `index` of the shot, linked to the one before if that was the last one taken.
    fn take(&mut self, index: usize, run: &Run) -> Result<Take> {
        run.check()?;
        let number = self.numbers[index];
        let shot = self.shot;
        let frame = shot.project.pose(&self.poser, number, run);
        let view = shot.view(&frame, number, shot.camera.size, shot.exposure.shadows, run)?;
        let Weights { factors, graph, .. } = weigh(&view, &shot.exposure, &shot.knobs, run)?;
        let pixels = graph.mask.len() as u64;
        let features = run.stage("lines", pixels, || Features::find(&view.buffer, &shot.knobs));
        let before = self.before.take().filter(|(i, ..)| i + 1 == index);
        let linked = |rule: Match| match &before {
            Some((_, previous, buffer)) => {
                links(&view.buffer, buffer, &shot.project.scene, (&frame, previous), rule)
            }
            None => graph.mask.map(|_| UNLINKED),
        };
        let (close, sight) = run.stage("track", pixels, || {
            (linked(Match::Plane(OFF_PLANE)), linked(Match::Depth(SAME_DEPTH)))
        });
        self.before = Some((index, frame, view.buffer));
        let pairs = FeaturePairs::of(&factors);
        let cel = run.stage("cut", pixels, || Cel::new(graph, close))?;
        Ok(Take { number, cel, sight, features, pairs })
    }
}

/// Labels the frames of a shot and hands the `wanted` ones over, drawn; the measures of the film
/// as far as it was labelled.
pub(crate) fn shoot(
    shot: &Shot<'_>,
    colours: &Colours,
    (wanted, labelling): (&[u32], Labelling),
    deliver: &mut dyn FnMut(u32, Picture) -> Result<()>,
    run: &Run,
) -> Result<Map<String, Value>> {
    let numbers = shot.project.shot();
    let knobs = &shot.knobs;
    let plan = Plan { frames: numbers.len(), window: knobs.window as usize };
    let is_wanted: Vec<bool> = numbers.iter().map(|n| wanted.contains(n)).collect();
    let mut camera = Camera { shot, poser: shot.project.poser(), numbers, before: None };
    let mut flicker = Flicker::default();
    if labelling != Labelling::Windows {
        for index in (0..plan.frames).filter(|i| is_wanted[*i]) {
            let take = camera.take(index, run)?;
            let white = match labelling {
                Labelling::Blurred => blurred(&take.cel.graph),
                _ => {
                    let mask = &take.cel.graph.mask;
                    without_islands(&take.cel.alone.white, mask, knobs.island_area(mask.height()))
                }
            };
            measure(&mut flicker, index, &take, &white);
            deliver(take.number, picture(&take, &white, colours, knobs, run))?;
        }
        return Ok(flicker_counts(&flicker));
    }
    let mut film: Film<'_, Take> = Film::new(plan, knobs);
    let mut start = 0;
    while start < plan.frames {
        let block = plan.block(start);
        start = block.end;
        if !is_wanted[block.clone()].contains(&true) {
            continue;
        }
        film.label(
            &block,
            &mut |index| camera.take(index, run),
            &mut |index, take, white| {
                measure(&mut flicker, index, take, white);
                if !is_wanted[index] {
                    return Ok(());
                }
                deliver(take.number, picture(take, white, colours, knobs, run))
            },
            run,
        )?;
    }
    Ok(flicker_counts(&flicker))
}

/// The sign of W - B after a Gaussian of 3 pixels at 480.
fn blurred(graph: &Graph) -> Plane<bool> {
    let pull = graph.terminal.map(|[white, black]| (white - black) as f32);
    let sigma = scaled(3.0, graph.mask.height());
    let soft = filter::gaussian_masked(&pull, &graph.mask, sigma);
    soft.zip(&graph.mask, |p, m| *m && *p > 0.0).expect("a filter keeps the size")
}

fn measure(flicker: &mut Flicker, index: usize, take: &Take, white: &Plane<bool>) {
    let graph = &take.cel.graph;
    flicker.add(
        index,
        &Shown {
            white,
            covered: &graph.mask,
            links: &take.sight,
            alone: &take.cel.alone.white,
            tone: &graph.terminal.map(|[white, black]| white > black),
            energy: [graph.energy(white), take.cel.alone.cut],
        },
    );
}

/// A labelled frame, drawn.
fn picture(
    take: &Take,
    white: &Plane<bool>,
    colours: &Colours,
    knobs: &BinaryKnobs,
    run: &Run,
) -> Picture {
    let graph = &take.cel.graph;
    let pixels = white.len() as u64;
    let (region, lines) = run.stage("lines", pixels, || {
        outline(&take.features, white, &graph.mask, colours.paper_is_white(), knobs)
    });
    let marks = run.stage("draw", pixels, || compose(&region, &graph.mask, &lines, knobs));
    let border = Border::measure(white, &graph.mask, &take.pairs);
    let cost = (graph.energy(white) - take.cel.alone.cut) as f64 / f64::from(graph.scale);
    let counts = counts::labelled(white, graph, &take.cel.alone, cost, &border);
    Picture {
        covered: graph.mask.clone(),
        labels: white.map(|w| u8::from(*w)),
        palette: Vec::new(),
        white: white.clone(),
        lines,
        marks,
        tint: None,
        graph: graph.clone(),
        cut: take.cel.alone.clone(),
        counts,
    }
}

fn flicker_counts(flicker: &Flicker) -> Map<String, Value> {
    let mut counts = Map::new();
    let mut put = |name: &str, value: Value| counts.insert(name.into(), value);
    put("flips_per_pixel", json!(flicker.flips_per_pixel()));
    put("reversals_per_pixel", json!(flicker.reversals_per_pixel()));
    put("tone_flips_per_pixel", json!(flicker.tone_flips_per_pixel()));
    put("pop_p99_px", json!(flicker.pop_p99()));
    put("energy_excess", json!(flicker.energy_excess()));
    put("lag_px", json!(flicker.lag_px()));
    counts
}
