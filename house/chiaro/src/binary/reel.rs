//! A film of ink: frames are rendered or read in order, labelled in windows along the motion, and
//! written.
//!
//! 1. The shot's blocks that hold a frame yet to be written are walked in order; a frame becomes a
//!    [`Take`] (its graph, its links, what lines need) and its geometry is let go once the next
//!    frame is linked to it.
//! 2. [`chiaro_binary::Film`] labels the takes; a labelled take is drawn, measured and written.
//!
//! Memory: two frames of geometry and at most `window` + `window` / 2 + 2 takes, some 60 bytes a
//! pixel each, whatever the film's length. A part of a film renders, beyond its own frames, those of
//! its blocks and of half a window around each key.

use super::counts;
use super::picture::{Picture, Tinted};
use super::shot::Shot;
use crate::colours::Colours;
use chiaro_basis::{Result, Run};
use chiaro_binary::{
    BinaryKnobs, Border, Cel, Exposure, FeaturePairs, Features, Film, Flicker, Graph, Lines, Paint,
    Palette, Plan, Shown, Tariff, View, Weights, compose, film_layers, labelled, outline, scaled,
    weigh,
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
pub(crate) struct Take {
    number: u32,
    cel: Cel,
    /// Links for the measures.
    sight: Plane<u32>,
    features: Features,
    pairs: FeaturePairs,
    /// Where a map draws lines on top.
    map: Option<Plane<bool>>,
}

impl AsRef<Cel> for Take {
    fn as_ref(&self) -> &Cel {
        &self.cel
    }
}

/// How the frames of a film are made of what is seen.
pub(crate) struct Setting<'a> {
    pub(crate) knobs: &'a BinaryKnobs,
    pub(crate) exposure: &'a Exposure,
    pub(crate) colours: &'a Colours,
    pub(crate) palette: Palette,
}

impl Setting<'_> {
    /// Frame `number`, a view that is linked to the one before: as the cut needs it, and as the
    /// measures do.
    pub(crate) fn take(
        &self,
        number: u32,
        (view, map): (&View, Option<Plane<bool>>),
        [close, sight]: [Plane<u32>; 2],
        paint: Option<Paint>,
        run: &Run,
    ) -> Result<Take> {
        let Self { knobs, exposure, palette, .. } = self;
        let mut weights = weigh(view, exposure, knobs, run)?;
        if let Some(paint) = &paint {
            weights.paint(paint);
        }
        let Weights { graph, pairs, .. } = weights;
        let pixels = graph.mask.len() as u64;
        let features = run.stage("lines", pixels, || {
            let found = Features::find(&view.buffer, knobs);
            match &map {
                Some(map) => found.beside(map),
                None => found,
            }
        });
        let how = (*exposure, *knobs);
        let cel = run.stage("cut", pixels, || -> Result<Cel> {
            let layers = film_layers(palette, view, &graph, how, paint.as_ref())?;
            let mut cel = Cel::new(graph, close)?;
            cel.layers = layers;
            cel.painted = paint.as_ref().map(|p| p.drawn().clone());
            Ok(cel)
        })?;
        Ok(Take { number, cel, sight, features, pairs, map })
    }
}

/// What makes the frames of a film.
pub(crate) trait Source {
    /// Frame `index` of the shot, linked to the one before if that was the last one taken.
    fn take(&mut self, index: usize, setting: &Setting<'_>, run: &Run) -> Result<Take>;
}

/// Renders the frames of a shot in order.
struct Camera<'a, 's> {
    shot: &'s Shot<'a>,
    poser: Poser<'a>,
    numbers: Vec<u32>,
    before: Option<(usize, Frame, GBuffer)>,
}

impl Source for Camera<'_, '_> {
    fn take(&mut self, index: usize, setting: &Setting<'_>, run: &Run) -> Result<Take> {
        run.check()?;
        let number = self.numbers[index];
        let shot = self.shot;
        let frame = shot.project.pose(&self.poser, number, run);
        let view = shot.view(&frame, number, shot.camera.size, shot.exposure.shadows, run)?;
        let before = self.before.take().filter(|(i, ..)| i + 1 == index);
        let linked = |rule: Match| match &before {
            Some((_, previous, buffer)) => {
                links(&view.buffer, buffer, &shot.project.scene, (&frame, previous), rule)
            }
            None => view.buffer.covered.map(|_| UNLINKED),
        };
        let linked = run.stage("track", view.buffer.covered.len() as u64, || {
            [linked(Match::Plane(OFF_PLANE)), linked(Match::Depth(SAME_DEPTH))]
        });
        let paint = shot.painted(&view, number);
        let take = setting.take(number, (&view, None), linked, paint, run)?;
        self.before = Some((index, frame, view.buffer));
        Ok(take)
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
    let is_wanted: Vec<bool> = numbers.iter().map(|n| wanted.contains(n)).collect();
    let poser = shot.project.poser();
    let mut camera = Camera { shot, poser, numbers, before: None };
    let setting = Setting {
        knobs: &shot.knobs,
        exposure: &shot.exposure,
        colours,
        palette: shot.palette(colours)?,
    };
    label(&mut camera, &setting, (&is_wanted, labelling), deliver, run)
}

/// Labels the frames of a film, of which those that are wanted are handed over; its measures.
pub(crate) fn label(
    source: &mut dyn Source,
    setting: &Setting<'_>,
    (is_wanted, labelling): (&[bool], Labelling),
    deliver: &mut dyn FnMut(u32, Picture) -> Result<()>,
    run: &Run,
) -> Result<Map<String, Value>> {
    let knobs = setting.knobs;
    let plan = Plan { frames: is_wanted.len(), window: knobs.window as usize };
    let mut flicker: Vec<Flicker> = Vec::new();
    if labelling != Labelling::Windows {
        for index in (0..plan.frames).filter(|i| is_wanted[*i]) {
            let take = source.take(index, setting, run)?;
            let layers = alone(&take.cel, labelling, knobs)?;
            measure(&mut flicker, index, &take, &layers, knobs)?;
            deliver(take.number, setting.picture(&take, &layers, run))?;
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
            &mut |index| source.take(index, setting, run),
            &mut |index, take, layers| {
                measure(&mut flicker, index, take, layers, knobs)?;
                if !is_wanted[index] {
                    return Ok(());
                }
                deliver(take.number, setting.picture(take, layers, run))
            },
            run,
        )?;
    }
    Ok(flicker_counts(&flicker))
}

/// The labels of a frame's layers by itself.
fn alone(cel: &Cel, labelling: Labelling, knobs: &BinaryKnobs) -> Result<Vec<Plane<u8>>> {
    if labelling == Labelling::Blurred {
        return Ok(vec![blurred(&cel.graph)]);
    }
    (0..cel.depth()).map(|layer| cel.finished(layer, knobs)).collect()
}

/// The sign of W - B after a Gaussian of 3 pixels at 480.
fn blurred(graph: &Graph) -> Plane<u8> {
    let pull = graph.terminal.map(|[white, black]| (white - black) as f32);
    let sigma = scaled(3.0, graph.mask.height());
    let soft = filter::gaussian_covered(&pull, &graph.mask, sigma);
    soft.zip(&graph.mask, |p, m| u8::from(*m && *p > 0.0)).expect("a filter keeps the size")
}

/// Measures the layers of a frame, each as a film of its own: as it is, and the energy that round
/// borders and the island rule alone would add.
fn measure(
    flicker: &mut Vec<Flicker>,
    index: usize,
    take: &Take,
    layers: &[Plane<u8>],
    knobs: &BinaryKnobs,
) -> Result<()> {
    flicker.resize_with(flicker.len().max(layers.len()), Flicker::default);
    let cel = &take.cel;
    for (layer, (flicker, labels)) in flicker.iter_mut().zip(layers).enumerate() {
        let (alone, energy) = cel.own(layer);
        let shown = Shown {
            labels,
            covered: &cel.graph.mask,
            links: &take.sight,
            alone,
            tone: &cel.wanted(layer),
            energy: [cel.energy(layer, labels), energy],
        };
        flicker.add(index, &shown);
        flicker.islands += cel.energy(layer, &cel.finished(layer, knobs)?) - energy;
    }
    Ok(())
}

impl Setting<'_> {
    /// A labelled frame, drawn.
    fn picture(&self, take: &Take, layers: &[Plane<u8>], run: &Run) -> Picture {
        match self.palette {
            Palette::Two => self.inked(take, &layers[0].map(|l| *l == 1), run),
            _ => self.coloured(take, layers, run),
        }
    }

    fn inked(&self, take: &Take, white: &Plane<bool>, run: &Run) -> Picture {
        let (graph, knobs) = (&take.cel.graph, self.knobs);
        let (region, lines) = run.stage("lines", white.len() as u64, || {
            outline(&take.features, white, &graph.mask, self.colours.paper_is_white(), knobs)
        });
        let labels = take.features.haloed(white).map(|w| u8::from(*w));
        self.finished(take, (labels, None, None), (white.clone(), &region, lines), run)
    }

    fn coloured(&self, take: &Take, layers: &[Plane<u8>], run: &Run) -> Picture {
        let Self { palette, colours, knobs, .. } = self;
        let mut coloured = labelled(layers, &take.cel, palette, knobs);
        let (covered, features) = (&take.cel.graph.mask, &take.features);
        coloured.labels = features.lightened(&coloured.labels, palette.lightest());
        let (white, region, lines, tint) =
            Tinted { palette, covered, features, knobs, colours }.draw(&coloured, run);
        let labels = (coloured.labels, Some(tint), Some(coloured.tariff));
        self.finished(take, labels, (white, &region, lines), run)
    }

    fn finished(
        &self,
        take: &Take,
        (labels, tint, tariff): (Plane<u8>, Option<Plane<[f32; 3]>>, Option<Tariff>),
        (white, region, lines): (Plane<bool>, &Plane<f32>, Lines),
        run: &Run,
    ) -> Picture {
        let Cel { graph, alone, .. } = &take.cel;
        let marks = run
            .stage("draw", white.len() as u64, || compose(region, &graph.mask, &lines, self.knobs));
        let border = Border::measure(&white, &graph.mask, &take.pairs);
        let cost = (graph.energy(&white) - alone.cut) as f64 / f64::from(graph.scale);
        let counts = counts::labelled(&white, graph, alone, cost, &border);
        let mut picture = Picture {
            covered: graph.mask.clone(),
            labels,
            palette: self.palette.colours().iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect(),
            white,
            lines,
            map: None,
            marks,
            tint,
            tariff,
            graph: graph.clone(),
            cut: alone.clone(),
            counts,
        };
        if let Some(map) = &take.map {
            picture.draw_map(map, self.colours, self.knobs);
        }
        picture
    }
}

fn flicker_counts(layers: &[Flicker]) -> Map<String, Value> {
    let mut flicker = Flicker::default();
    layers.iter().for_each(|layer| flicker.join(layer));
    let mut counts = Map::new();
    let mut put = |name: &str, value: Value| counts.insert(name.into(), value);
    put("flips_per_pixel", json!(flicker.flips_per_pixel()));
    put("reversals_per_pixel", json!(flicker.reversals_per_pixel()));
    put("tone_reversals_per_pixel", json!(flicker.tone_reversals_per_pixel()));
    put("tone_flips_per_pixel", json!(flicker.tone_flips_per_pixel()));
    put("pop_p99_px", json!(flicker.pop_p99()));
    put("energy_excess", json!(flicker.energy_excess()));
    put("island_excess", json!(flicker.island_excess()));
    put("coherence_excess", json!(flicker.coherence_excess()));
    put("lag_px", json!(flicker.lag_px()));
    counts
}
