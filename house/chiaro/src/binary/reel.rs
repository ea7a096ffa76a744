//! A film of ink: frames are rendered in order, labelled in windows along the motion, and written.
//!
//! 1. The shot's blocks that hold a frame yet to be written are walked in order; a frame becomes a
//!    [`Take`] (its graph, its links, what lines need) and its geometry is let go once the next
//!    frame is linked to it.
//! 2. [`chiaro_binary::Film`] labels the takes, painted ones and those of tones too; a labelled take is drawn, measured and written.
//!
//! Memory: two frames of geometry and at most `window` + `window` / 2 + 1 takes, some 60 bytes a
//! pixel each, whatever the film's length. A part of a film renders, beyond its own frames, those of
//! its blocks and of half a window around each key.

use super::counts;
use super::picture::{Picture, Tinted};
use super::shot::Shot;
use crate::colours::Colours;
use chiaro_basis::{Result, Run};
use chiaro_binary::{
    BinaryKnobs, Border, Cel, FeaturePairs, Features, Film, Flicker, Graph, Lines, Palette, Plan,
    Shown, Weights, compose, outline, scaled, step_terminals, toned, weigh,
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
    palette: Palette,
}

impl Camera<'_, '_> {
    /// Frame `index` of the shot, linked to the one before if that was the last one taken.
    fn take(&mut self, index: usize, run: &Run) -> Result<Take> {
        run.check()?;
        let number = self.numbers[index];
        let shot = self.shot;
        let frame = shot.project.pose(&self.poser, number, run);
        let view = shot.view(&frame, number, shot.camera.size, shot.exposure.shadows, run)?;
        let mut weights = weigh(&view, &shot.exposure, &shot.knobs, run)?;
        let paint = shot.painting.as_ref().map(|p| p.paint(&view, number));
        if let Some(paint) = &paint {
            weights.paint(paint, &shot.knobs);
        }
        let Weights { factors, graph, .. } = weights;
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
        let pairs = FeaturePairs::of(&factors);
        let tones = self.palette.colours().len();
        let terminals = match self.palette {
            Palette::Tones(_) if tones > 1 => {
                step_terminals(tones, &view, &shot.exposure, &shot.knobs, graph.scale)
            }
            _ => Vec::new(),
        };
        self.before = Some((index, frame, view.buffer));
        let mut cel = run.stage("cut", pixels, || Cel::new(graph, close)?.in_tones(terminals))?;
        cel.painted = paint.map(|p| p.drawn().clone());
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
    let palette = shot.palette(colours)?;
    let poser = shot.project.poser();
    let mut camera = Camera { shot, poser, numbers, before: None, palette: palette.clone() };
    let mut flicker = vec![Flicker::default(); palette.colours().len().saturating_sub(1).max(1)];
    let look = Sheet { palette: &palette, colours, knobs };
    if labelling != Labelling::Windows {
        for index in (0..plan.frames).filter(|i| is_wanted[*i]) {
            let take = camera.take(index, run)?;
            let white = match labelling {
                Labelling::Blurred => blurred(&take.cel.graph),
                _ => {
                    let Cel { graph, alone, .. } = &take.cel;
                    graph.without_islands(&alone.white, knobs.island_area(graph.mask.height()))
                }
            };
            let white = [white];
            measure(&mut flicker, index, &take, &white);
            deliver(take.number, look.picture(&take, &white, run))?;
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
            &mut |index, take, layers| {
                measure(&mut flicker, index, take, layers);
                if !is_wanted[index] {
                    return Ok(());
                }
                deliver(take.number, look.picture(take, layers, run))
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

/// Measures the layers of a frame, each as a film of its own.
fn measure(flicker: &mut [Flicker], index: usize, take: &Take, layers: &[Plane<bool>]) {
    for (layer, (flicker, white)) in flicker.iter_mut().zip(layers).enumerate() {
        let cel = &take.cel;
        let step = cel.steps.get(layer);
        let (graph, alone) = match step {
            Some(step) => {
                let terminal = step.terminal.clone();
                (&Graph { terminal, ..cel.graph.clone() }, &step.alone)
            }
            None => (&cel.graph, &cel.alone.white),
        };
        let own = if step.is_some() { graph.energy(alone) } else { cel.alone.cut };
        let shown = Shown {
            white,
            covered: &graph.mask,
            links: &take.sight,
            alone,
            tone: &graph.terminal.map(|[white, black]| white > black),
            energy: [graph.energy(white), own],
        };
        flicker.add(index, &shown);
    }
}

/// What labelled frames are drawn with.
struct Sheet<'a> {
    palette: &'a Palette,
    colours: &'a Colours,
    knobs: &'a BinaryKnobs,
}

impl Sheet<'_> {
    /// A labelled frame, drawn.
    fn picture(&self, take: &Take, layers: &[Plane<bool>], run: &Run) -> Picture {
        if take.cel.steps.is_empty() {
            self.inked(take, &layers[0], run)
        } else {
            self.toned(take, layers, run)
        }
    }

    fn inked(&self, take: &Take, white: &Plane<bool>, run: &Run) -> Picture {
        let (graph, knobs) = (&take.cel.graph, self.knobs);
        let (region, lines) = run.stage("lines", white.len() as u64, || {
            outline(&take.features, white, &graph.mask, self.colours.paper_is_white(), knobs)
        });
        let labels = take.features.haloed(white).map(|w| u8::from(*w));
        self.finished(take, (labels, None), (white.clone(), &region, lines), run)
    }

    fn toned(&self, take: &Take, layers: &[Plane<bool>], run: &Run) -> Picture {
        let Self { palette, colours, knobs } = *self;
        let mut coloured = toned(layers, &take.cel, knobs);
        let (covered, features) = (&take.cel.graph.mask, &take.features);
        coloured.labels = features.lightened(&coloured.labels, palette.lightest());
        let (white, region, lines, tint) =
            Tinted { palette, covered, features, knobs, colours }.draw(&coloured, run);
        self.finished(take, (coloured.labels, Some(tint)), (white, &region, lines), run)
    }

    fn finished(
        &self,
        take: &Take,
        (labels, tint): (Plane<u8>, Option<Plane<[f32; 3]>>),
        (white, region, lines): (Plane<bool>, &Plane<f32>, Lines),
        run: &Run,
    ) -> Picture {
        let Cel { graph, alone, .. } = &take.cel;
        let marks = run
            .stage("draw", white.len() as u64, || compose(region, &graph.mask, &lines, self.knobs));
        let border = Border::measure(&white, &graph.mask, &take.pairs);
        let cost = (graph.energy(&white) - alone.cut) as f64 / f64::from(graph.scale);
        let counts = counts::labelled(&white, graph, alone, cost, &border);
        Picture {
            covered: graph.mask.clone(),
            labels,
            palette: self.palette.colours().iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect(),
            white,
            lines,
            map: None,
            marks,
            tint,
            graph: graph.clone(),
            cut: alone.clone(),
            counts,
        }
    }
}

fn flicker_counts(layers: &[Flicker]) -> Map<String, Value> {
    let mut flicker = Flicker::default();
    layers.iter().for_each(|layer| flicker.join(layer));
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
