//! More colours than two (section 3.9): palettes, and what each pixel pays for each colour.
//!
//! - *Tones* are ordered from dark to light. Tone l or more is white in the binary problem whose
//!   W - B is lowered by the l-th step, so the price of a tone is convex, the cuts are nested, and
//!   the minimum is exact.
//! - *Spots* are unordered colours. A pixel pays for the difference between a colour and its own,
//!   which is the base colour under the picture's tone; borders cost the same between any two. The
//!   labelling is found by expansions, whose energy never rises, within a factor 2 of the best.
//!
//! Borders follow the geometry as in two colours, and the smallest island holds. White paint means the
//! lightest colour, black paint the darkest.

use crate::cel::{Cel, Layer, expanded, label_grid, too_large};
use crate::cut::Graph;
use crate::exposure::{Exposure, MOST_STEPS, mixed_tone};
use crate::island::without_islands;
use crate::knob::{BinaryKnobs, scaled};
use crate::mend::Costs;
use crate::paint::Paint;
use crate::round::reach;
use crate::shade::View;
use crate::tariff::Tariff;
use crate::terminal::terminal;
use chiaro_basis::{Error, Result};
use chiaro_image::Plane;
use chiaro_image::colour::{parse_colour, srgb_decode};
use chiaro_ink::smooth_coverage;
use chiaro_mincut::{Distance, Labelling, MAX_PRICE, solve_ordered};

/// The colours of a picture, sRGB-encoded.
#[derive(Clone, Debug, PartialEq)]
pub enum Palette {
    /// Ink and paper.
    Two,
    /// Ordered from dark to light.
    Tones(Vec<[f32; 3]>),
    /// Unordered.
    Spots(Vec<[f32; 3]>),
}

const RANGE: &str = "a number of tones from 1 to 8, or colours from dark to light as in #222,#888,#fff, \
                     or spot colours as in spot:black,#c22,white";

impl Palette {
    /// Reads a palette: a number of tones from `ink` to `paper`, a list of colours from dark to
    /// light, or `spot:` and a list.
    pub fn parse(text: &str, ink: [f32; 4], paper: [f32; 4]) -> Result<Self> {
        let fail = || Error::setting("palette", text, RANGE);
        let text = text.trim();
        if text.is_empty() || text == "2" {
            return Ok(Self::Two);
        }
        if let Ok(count) = text.parse::<usize>() {
            let last = count.saturating_sub(1).max(1) as f32;
            let ramp = |i: usize| std::array::from_fn(|c| mix(ink[c], paper[c], i as f32 / last));
            let known = (1..=MOST_STEPS + 1).contains(&count);
            return known.then(|| Self::Tones((0..count).map(ramp).collect())).ok_or_else(fail);
        }
        let (list, spots) = match text.strip_prefix("spot:") {
            Some(list) => (list, true),
            None => (text, false),
        };
        let colours = list
            .split(',')
            .map(|c| parse_colour(c.trim()).map(|[r, g, b, _]| [r, g, b]))
            .collect::<Result<Vec<_>>>()
            .map_err(|_| fail())?;
        match (spots, colours.len()) {
            (true, 1..=64) => Ok(Self::Spots(colours)),
            (false, n) if (1..=MOST_STEPS + 1).contains(&n) => Ok(Self::Tones(colours)),
            _ => Err(fail()),
        }
    }

    /// Its colours, sRGB-encoded; none for ink and paper.
    pub fn colours(&self) -> &[[f32; 3]] {
        match self {
            Self::Two => &[],
            Self::Tones(colours) | Self::Spots(colours) => colours,
        }
    }
}

impl Palette {
    /// The place of its lightest colour; 1, paper, of ink and paper.
    pub fn lightest(&self) -> u8 {
        self.paint()[1]
    }

    /// The places of its darkest and its lightest colour, of ink and paper of those.
    pub(crate) fn paint(&self) -> [u8; 2] {
        let lightness = |c: &[f32; 3]| oklab(c.map(srgb_decode))[0];
        let by_lightness = |a: &(usize, f32), b: &(usize, f32)| a.1.total_cmp(&b.1);
        let all = || self.colours().iter().map(lightness).enumerate();
        let darkest = all().min_by(by_lightness).map_or(0, |(i, _)| i as u8);
        [darkest, all().max_by(by_lightness).map_or(1, |(i, _)| i as u8)]
    }

    /// What black and white paint mean in its labels. Tones lie in the order that they are given in.
    fn painted(&self) -> [u8; 2] {
        match self {
            Self::Tones(colours) => [0, colours.len().saturating_sub(1) as u8],
            _ => self.paint(),
        }
    }
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// A picture's labels, one colour of the palette a pixel.
#[derive(Clone, Debug)]
pub struct Coloured {
    /// Place in the palette; 0 where there is no geometry.
    pub labels: Plane<u8>,
    /// The energy of the cut, in units of capacity, before islands are removed.
    pub energy: i64,
    /// What any labels of the picture cost.
    pub tariff: Tariff,
}

/// The best labels in order, each a step from the next.
fn ordered(graph: &Graph, data: &[i32], count: usize) -> Result<Labelling> {
    let steps: Vec<i32> = (0..count as i32).collect();
    solve_ordered(&label_grid(graph, data, count, Distance::Tones(&steps))).map_err(too_large)
}

/// Labels a view with a palette of tones or spots. `graph` is the picture's in two colours, `paint`
/// what is painted on it.
pub fn colour_regions(
    palette: &Palette,
    view: &View,
    graph: &Graph,
    (exposure, knobs): (&Exposure, &BinaryKnobs),
    paint: Option<&Paint>,
) -> Result<Coloured> {
    let (width, height) = graph.mask.size();
    let count = palette.colours().len().max(1);
    let mut data = match palette {
        Palette::Spots(colours) => spot_prices(colours, view, exposure, knobs, graph),
        _ => tone_prices(
            count,
            &tone_difference(count, view, exposure, knobs, paint),
            exposure,
            graph,
        ),
    };
    if let Some(paint) = paint {
        paint.bind_prices(&mut data, palette, graph);
    }
    let found = match palette {
        Palette::Spots(_) => expanded(graph, &data, count)?,
        _ => ordered(graph, &data, count)?,
    };
    let labels = Plane::from_pixels(width, height, found.labels);
    let mut labels = match palette {
        Palette::Spots(_) => graph.costs(&data, count).finished(&labels, knobs)?,
        _ => {
            let costs = Costs { by_step: true, ..graph.costs(&data, count) };
            let round = costs.rounded(&labels, reach(knobs, height))?;
            without_islands(&round, &graph.mask, knobs.island_area(height))
        }
    };
    if let Some(paint) = paint {
        labels = keep(labels, &graph.mask, paint.drawn(), palette);
    }
    let tariff = Tariff::new(data, count, !matches!(palette, Palette::Spots(_)));
    Ok(Coloured { labels, energy: found.energy, tariff })
}

/// Labels with what is painted as it is painted.
fn keep(
    labels: Plane<u8>,
    mask: &Plane<bool>,
    drawn: &Plane<Option<bool>>,
    palette: &Palette,
) -> Plane<u8> {
    let paint = palette.painted();
    let (w, h) = labels.size();
    Plane::from_fn(w, h, |x, y| match drawn[(x, y)].filter(|_| mask[(x, y)]) {
        Some(white) => paint[usize::from(white)],
        None => labels[(x, y)],
    })
}

impl Paint {
    /// Binds painted pixels to the palette's darkest or lightest colour, tones by as much for each
    /// step that they are off.
    fn bind_prices(&self, data: &mut [i32], palette: &Palette, graph: &Graph) {
        let count = palette.colours().len().max(1);
        for (p, white) in self.bound(graph) {
            let own = self.bond(graph, p);
            let label = palette.painted()[usize::from(white)];
            let at = (p.1 * graph.mask.width() + p.0) * count;
            for (l, price) in data[at..at + count].iter_mut().enumerate() {
                let off = l.abs_diff(label.into());
                let steps = if matches!(palette, Palette::Spots(_)) { off.min(1) } else { off };
                *price = own.saturating_mul(steps as i32).min(MAX_PRICE);
            }
        }
    }
}

/// W - B for so many tones, strokes mixed in.
fn tone_difference(
    count: usize,
    view: &View,
    exposure: &Exposure,
    knobs: &BinaryKnobs,
    paint: Option<&Paint>,
) -> Plane<f32> {
    let difference = terminal(view, exposure, &knobs.for_tones(count));
    match paint {
        Some(paint) => paint.mixed(&difference),
        None => difference,
    }
}

/// What a frame of a film is labelled by instead of its graph in two colours: for tones a layer for
/// each step, for spots one layer; none for ink and paper, or for one tone.
pub fn film_layers(
    palette: &Palette,
    view: &View,
    graph: &Graph,
    (exposure, knobs): (&Exposure, &BinaryKnobs),
    paint: Option<&Paint>,
) -> Result<Vec<Layer>> {
    let count = palette.colours().len();
    match palette {
        Palette::Two => Ok(Vec::new()),
        Palette::Tones(_) => {
            let difference = tone_difference(count, view, exposure, knobs, paint);
            let layer = |step: &f32| {
                let mut graph =
                    Graph { terminal: stepped(&difference, *step, graph), ..graph.clone() };
                if let Some(paint) = paint {
                    paint.bind(&mut graph);
                }
                let terminal = graph.terminal.clone();
                Layer::step(&graph, terminal)
            };
            exposure.steps(count).iter().map(layer).collect()
        }
        Palette::Spots(colours) => {
            let mut prices = spot_prices(colours, view, exposure, knobs, graph);
            if let Some(paint) = paint {
                paint.bind_prices(&mut prices, palette, graph);
            }
            Ok(vec![Layer::unordered(graph, prices, count, palette.painted())?])
        }
    }
}

/// Terminals of two colours whose W - B is lowered by a step.
fn stepped(difference: &Plane<f32>, step: f32, graph: &Graph) -> Plane<[i32; 2]> {
    let pair = |d: &f32, covered: &bool| {
        let units = ((d - step).clamp(-4.0, 4.0) * graph.scale).round() as i32;
        if *covered { [units.max(0), (-units).max(0)] } else { [0; 2] }
    };
    difference.zip(&graph.mask, pair).expect("one picture, one size")
}

/// The colours of a frame whose layers are labelled: of tones as many steps as are white.
pub fn labelled(
    layers: &[Plane<u8>],
    cel: &Cel,
    palette: &Palette,
    knobs: &BinaryKnobs,
) -> Coloured {
    let mask = &cel.graph.mask;
    let energy = (0..cel.layers.len()).map(|l| cel.energy(l, &layers[l])).sum();
    if let (Palette::Spots(_), [labels]) = (palette, layers) {
        return Coloured { labels: labels.clone(), energy, tariff: Tariff::of(cel, false) };
    }
    let mut labels = mask.map(|_| 0);
    for white in layers.iter().take(cel.layers.len()) {
        labels = labels.zip(white, |l, w| l + w).expect("one picture, one size");
    }
    let mut labels = without_islands(&labels, mask, knobs.island_area(mask.height()));
    if let Some(drawn) = &cel.painted {
        labels = keep(labels, mask, drawn, palette);
    }
    Coloured { labels, energy, tariff: Tariff::of(cel, true) }
}

/// The price of tone l: what the binary problems pay whose step is passed, and those whose is not.
fn tone_prices(
    count: usize,
    difference: &Plane<f32>,
    exposure: &Exposure,
    graph: &Graph,
) -> Vec<i32> {
    let steps = exposure.steps(count);
    let mut data = Vec::with_capacity(count * difference.len());
    for d in difference.pixels() {
        let pull = |s: &f32| (d - s).clamp(-4.0, 4.0);
        for l in 0..count {
            let white: f32 = steps[..l].iter().map(|s| (-pull(s)).max(0.0)).sum();
            let black: f32 = steps[l..].iter().map(|s| pull(s).max(0.0)).sum();
            data.push(((white + black) * graph.scale).round() as i32);
        }
    }
    data
}

/// The price of a spot colour: its perceptual difference to the pixel's own colour.
fn spot_prices(
    colours: &[[f32; 3]],
    view: &View,
    exposure: &Exposure,
    knobs: &BinaryKnobs,
    graph: &Graph,
) -> Vec<i32> {
    let covered = &view.buffer.covered;
    let tone = mixed_tone(&view.channels, covered, knobs);
    let spots: Vec<[f32; 3]> = colours.iter().map(|c| oklab(c.map(srgb_decode))).collect();
    let mut data = Vec::with_capacity(spots.len() * covered.len());
    let pixels = view.buffer.base_colour.pixels().iter().zip(tone.pixels());
    for (base, tone) in pixels {
        let [lightness, a, b] = oklab(*base);
        // The tone is the light; what has no hue of its own takes any colour of its lightness.
        let lightness = 0.25 * lightness + 0.75 * exposure.stretch(*tone);
        let chroma = a.hypot(b);
        let hue = (chroma / 0.04).min(1.0);
        for s in &spots {
            let apart = (hue * (s[1] - a)).hypot(hue * (s[2] - b));
            let price = (s[0] - lightness).hypot(2.0 * apart);
            data.push((0.8 * price * graph.scale).round() as i32);
        }
    }
    data
}

/// Oklab (Ottosson 2020) of linear sRGB.
fn oklab([r, g, b]: [f32; 3]) -> [f32; 3] {
    let l = (0.412_221_46 * r + 0.536_332_55 * g + 0.051_445_995 * b).max(0.0).cbrt();
    let m = (0.211_903_5 * r + 0.680_699_5 * g + 0.107_396_96 * b).max(0.0).cbrt();
    let s = (0.088_302_46 * r + 0.281_718_85 * g + 0.629_978_7 * b).max(0.0).cbrt();
    [
        0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_047 * s,
        1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
        0.025_904_037 * l + 0.782_771_77 * m - 0.808_675_77 * s,
    ]
}

/// The regions in their colours with smooth borders, sRGB-encoded; what has no geometry takes the
/// colour that is nearest.
pub fn tint(
    coloured: &Coloured,
    covered: &Plane<bool>,
    palette: &Palette,
    knobs: &BinaryKnobs,
) -> Plane<[f32; 3]> {
    let (w, h) = covered.size();
    let sigma = scaled(knobs.smooth, h);
    let mut sum = Plane::filled(w, h, [0.0f32; 4]);
    for (l, colour) in palette.colours().iter().enumerate() {
        let label = coloured.labels.map(|n| usize::from(*n) == l);
        let share = smooth_coverage(&label, covered, sigma);
        sum = sum
            .zip(&share, |s, w| {
                [s[0] + w * colour[0], s[1] + w * colour[1], s[2] + w * colour[2], s[3] + w]
            })
            .expect("shares have the picture's size");
    }
    let nothing = palette.colours().first().copied().unwrap_or([0.0; 3]);
    sum.map(|[r, g, b, w]| if *w > 0.0 { [r / w, g / w, b / w] } else { nothing })
}

/// Whether each colour counts as white, for lines: lines in it are black.
pub fn is_light(palette: &Palette) -> Vec<bool> {
    let lightness = |c: &[f32; 3]| oklab(c.map(srgb_decode))[0];
    palette.colours().iter().map(|c| lightness(c) >= 0.45).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cel::cheapest;

    #[test]
    fn palettes_are_read_or_explained() {
        let (ink, paper) = ([0.0, 0.0, 0.0, 1.0], [1.0; 4]);
        let read = |text: &str| Palette::parse(text, ink, paper);
        assert_eq!(read("").unwrap(), Palette::Two);
        assert_eq!(read("3").unwrap().colours()[1], [0.5; 3]);
        assert_eq!(read("#000, #fff").unwrap().colours().len(), 2);
        assert_eq!(read("white").unwrap(), Palette::Tones(vec![[1.0; 3]]));
        assert!(
            matches!(read("spot:black,#f00,white").unwrap(), Palette::Spots(c) if c.len() == 3)
        );
        for wrong in ["0", "99", "spot:", "blackish", "#000,,#fff"] {
            let error = read(wrong).unwrap_err().to_string();
            assert!(error.contains("palette") && error.contains("spot:"), "{error}");
        }
    }

    #[test]
    fn oklab_has_white_at_one_and_greys_without_hue() {
        let white = oklab([1.0; 3]);
        assert!((white[0] - 1.0).abs() < 1e-3 && white[1].abs() < 1e-3 && white[2].abs() < 1e-3);
        assert!(oklab([0.2, 0.0, 0.0])[1] > 0.1);
    }

    #[test]
    fn tone_prices_are_convex() {
        let graph = Graph::new(
            &Plane::filled(3, 1, true),
            &Plane::filled(3, 1, 0.0),
            &Plane::filled(3, 1, [0.0; 4]),
            &BinaryKnobs::default(),
        );
        let difference = Plane::from_pixels(3, 1, vec![-0.4, 0.02, 0.3]);
        let mut exposure = Exposure::default();
        exposure.set_steps(4, &[-0.2, 0.0, 0.15]);
        let data = tone_prices(4, &difference, &exposure, &graph);
        let best = cheapest(&data, 4);
        assert_eq!(best, [0, 2, 3]);
        for prices in data.chunks_exact(4) {
            assert!(prices.windows(3).all(|p| p[2] - p[1] >= p[1] - p[0]));
        }
    }
}
