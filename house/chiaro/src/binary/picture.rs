//! [`Picture`]: one view, cut and drawn, with all that files are made of.

use super::counts;
use crate::colours::Colours;
use chiaro_basis::{Result, Run};
use chiaro_binary::{
    BinaryKnobs, Coloured, Exposure, Features, Graph, Labels, Lines, Marks, Paint, Palette,
    Prepared, Steps, Tariff, View, colour_regions, compose, is_light, map_colours, outline,
    prepare, scaled, tint,
};
use chiaro_image::Plane;
use chiaro_image::colour::to_byte;
use serde_json::{Map, Value};
use std::borrow::Cow;

/// Draws one view: weights, cut, lines, colours; a map of lines on top, if there is one.
pub(crate) fn draw(
    (view, map): (View, Option<&Plane<bool>>),
    exposure: &Exposure,
    knobs: &BinaryKnobs,
    (colours, paint): (&Colours, Option<&Paint>),
    run: &Run,
) -> Result<Picture> {
    let paper = colours.paper_is_white();
    let palette = Palette::parse(&knobs.palette, colours.ink, colours.paper)?;
    let prepared = |view| -> Result<Prepared> {
        let mut prepared = prepare(view, exposure, knobs, paint, run)?;
        if let Some(map) = map {
            prepared.features = prepared.features.beside(map);
        }
        Ok(prepared)
    };
    let (mut labels, mut tariff) = (None, None);
    let (steps, tint) = match &palette {
        Palette::Two => (prepared(Cow::Owned(view))?.cut(paint, paper, knobs, run)?, None),
        palette => {
            let prepared = prepared(Cow::Borrowed(&view))?;
            let features = prepared.features.clone();
            let mut steps = prepared.cut(paint, paper, knobs, run)?;
            let pixels = view.buffer.covered.len() as u64;
            let mut coloured = run.stage("cut", pixels, || {
                colour_regions(palette, &view, &steps.graph, (exposure, knobs), paint)
            })?;
            coloured.labels = features.lightened(&coloured.labels, palette.lightest());
            let covered = &view.buffer.covered;
            let sheet = Tinted { palette, covered, features: &features, knobs, colours };
            let (white, region, lines, tint) = sheet.draw(&coloured, run);
            (steps.white, steps.region, steps.lines) = (white, region, lines);
            (labels, tariff) = (Some(coloured.labels), Some(coloured.tariff));
            (steps, Some(tint))
        }
    };
    let marks = run.stage("draw", steps.white.len() as u64, || {
        compose(&steps.region, &steps.graph.mask, &steps.lines, knobs)
    });
    let counts = counts::stepped(&steps);
    let Steps { white, shown, lines, graph, labels: cut, .. } = steps;
    let mut picture = Picture {
        covered: graph.mask.clone(),
        labels: labels.unwrap_or_else(|| shown.map(|w| u8::from(*w))),
        palette: palette.colours().iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect(),
        white,
        lines,
        map: None,
        marks,
        tint,
        tariff,
        graph,
        cut,
        counts,
    };
    if let Some(map) = map {
        picture.draw_map(map, colours, knobs);
    }
    Ok(picture)
}

/// What a labelled picture in its palette's colours is drawn with.
pub(super) struct Tinted<'a> {
    pub(super) palette: &'a Palette,
    pub(super) covered: &'a Plane<bool>,
    pub(super) features: &'a Features,
    pub(super) knobs: &'a BinaryKnobs,
    pub(super) colours: &'a Colours,
}

impl Tinted<'_> {
    /// Regions, white where their colour is light, the same with smooth borders, lines, and colours
    /// with lines drawn.
    pub(super) fn draw(
        &self,
        coloured: &Coloured,
        run: &Run,
    ) -> (Plane<bool>, Plane<f32>, Lines, Plane<[f32; 3]>) {
        let Self { palette, covered, features, knobs, colours } = *self;
        run.stage("draw", covered.len() as u64, || {
            let light = is_light(palette);
            let white = coloured.labels.map(|l| light[usize::from(*l)]);
            let paper = colours.paper_is_white();
            let (region, lines) = outline(features, &white, covered, paper, knobs);
            let (w, h) = covered.size();
            let over =
                |white: f32| compose(&Plane::filled(w, h, white), covered, &lines, knobs).white;
            let (on_white, on_black) = (over(1.0), over(0.0));
            let tint = tint(coloured, covered, palette, knobs);
            let tint = Plane::from_fn(w, h, |x, y| {
                let (one, zero, t) = (on_white[(x, y)], on_black[(x, y)], tint[(x, y)]);
                std::array::from_fn(|c| {
                    colours.ink[c] * (1.0 - one) + t[c] * (one - zero) + colours.paper[c] * zero
                })
            });
            (white, region, lines, tint)
        })
    }
}

/// A finished frame: all that files are made of.
pub struct Picture {
    /// Where there is geometry.
    pub covered: Plane<bool>,
    /// The regions: white where true.
    pub white: Plane<bool>,
    /// The lines on top.
    pub lines: Lines,
    /// A map of lines drawn over all: what each pixel's line is (0 none, 1 ink, 2 paper), and the
    /// sigma in pixels that smooths it.
    pub map: Option<(Plane<u8>, f32)>,
    /// Regions and lines, antialiased.
    pub marks: Marks,
    /// The place of each pixel's colour in the palette; of ink and paper, 1 where white.
    pub labels: Plane<u8>,
    /// The palette's colours where they are more than ink and paper.
    pub palette: Vec<[f32; 4]>,
    /// Its colours where the palette is more than ink and paper, lines drawn, sRGB-encoded.
    pub tint: Option<Plane<[f32; 3]>>,
    /// What labels of that palette cost.
    pub tariff: Option<Tariff>,
    /// The graph that was cut.
    pub graph: Graph,
    /// That graph's own minimal cut.
    pub cut: Labels,
    /// The measures of the record.
    pub counts: Map<String, Value>,
}

impl Picture {
    /// Draws the lines of a map over all.
    pub(crate) fn draw_map(&mut self, lines: &Plane<bool>, colours: &Colours, knobs: &BinaryKnobs) {
        let sigma = 0.5 * scaled(knobs.smooth, lines.height());
        let paper = colours.paper_is_white();
        let light = self.white.zip(&self.covered, |white, c| if *c { *white } else { paper });
        let map = map_colours(lines, &light.expect("one picture, one size"));
        let shares = self.marks.draw_map(&map, sigma);
        if let Some(tint) = &mut self.tint {
            for (share, colour) in shares.iter().zip([&colours.ink, &colours.paper]) {
                for (pixel, share) in tint.pixels_mut().iter_mut().zip(share.pixels()) {
                    *pixel = std::array::from_fn(|i| pixel[i] + share * (colour[i] - pixel[i]));
                }
            }
        }
        self.map = Some((map, sigma));
    }

    /// What a screen shows, transparency left out.
    pub fn displayed(&self, colours: &Colours) -> Plane<[u8; 3]> {
        self.coloured(colours).map(|[r, g, b, _]| [*r, *g, *b])
    }

    /// Ink and paper over the background, sRGB-encoded bytes. Shares are mixed as displayed: ink has no
    /// light of its own, and lines keep their optical width.
    pub(crate) fn coloured(&self, colours: &Colours) -> Plane<[u8; 4]> {
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let (w, h) = self.covered.size();
        Plane::from_fn(w, h, |x, y| {
            let (white, o) = (self.marks.white[(x, y)], self.marks.opacity[(x, y)]);
            let over: [f32; 4] = match &self.tint {
                Some(tint) => {
                    let [r, g, b] = tint[(x, y)];
                    [r, g, b, 1.0]
                }
                None => std::array::from_fn(|i| mix(colours.ink[i], colours.paper[i], white)),
            };
            let alpha = mix(colours.background[3], over[3], o);
            let channel = |i: usize| {
                let back = colours.background[i] * colours.background[3] * (1.0 - o);
                to_byte((back + over[i] * over[3] * o) / alpha.max(1e-6))
            };
            [channel(0), channel(1), channel(2), to_byte(alpha)]
        })
    }
}
