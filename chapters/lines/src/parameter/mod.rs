//! Parameters: the texture's u along every line of a film (thesis, sections 4.6, 4.7 and 4.9).
//!
//! ```text
//!  Film ─seam::carry→ seams that last ─Net→ unknowns, links ─Energy→ rows, factored once
//!  rows ─cut::agreeing→ links that agree ─onward::agreeing→ lines tied behind what hides them
//!  rows ─monotone::solve→ u ─→ Stroke::u
//!  links that agree ─name::rename→ ids ─Parts→ lines parted where two ids meet
//! ```
//!
//! [`parameterize`] runs one of four methods: the global solution, or one of the baselines, which go
//! from frame to frame (`propagate`, `diffuse`) or know no time at all. [`Parameters`] keeps the
//! links and the factored pattern, so that another weight costs a solve alone.

pub(crate) mod chart;
pub(crate) mod cut;
pub mod diffuse;
mod energy;
mod fit;
mod grow;
mod live;
mod monotone;
mod name;
pub(crate) mod near;
pub(crate) mod net;
mod octave;
mod onward;
mod part;
mod propagate;
mod seam;
mod split;
mod texture;

pub use chart::Saved;
pub use diffuse::{Diffused, Diffuser, Gesture};
pub use energy::Weights;
pub use live::Live;
pub use part::{drawn, whole};

use crate::film::{Film, FilmFrame};
use crate::knob::{Cuts, LinesKnobs, Links, Method, Texture};
use chiaro_basis::{Error, Result, Run, Sets};
use cut::Kept;
use energy::{Energy, Setting};
use net::{Found, Net};
use part::{Parts, Whole};
use std::collections::BTreeMap;

/// How often strokes are cut where links contradict each other, or where lines of two ids meet.
const ROUNDS: usize = 4;
/// A loop whose longest slice is longer than its shortest by more than this closes with a seam.
const LOOP_GROWTH: f64 = 1.3;
/// Share of links left contradicting from which a film is cut at mergers and splits too.
const LEFT: f64 = 0.001;

/// What a parameterization took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Solved {
    /// Unknowns of the solve; for the baselines, samples.
    pub unknowns: usize,
    /// Links from frame to frame.
    pub links: usize,
    /// Links that were cut because they contradict others.
    pub cut: usize,
    /// Their length in pixels, over the film.
    pub cut_length: f64,
    /// Charts: lines of all frames that links join.
    pub charts: usize,
    /// Lines of all frames, each frame's counted.
    pub lines: usize,
    /// Segments that folded before they were mended.
    pub mended: usize,
    /// What cuts at events came to, where they are made.
    pub saved: Option<Saved>,
}

/// Parameterizes every stroke of a film by the method that the knobs name. `spacing`: seconds from
/// each frame to the next; the last one, or all that are missing, count as the one before, or 1/24.
pub fn parameterize(
    film: &mut Film,
    spacing: &[f64],
    knobs: &LinesKnobs,
    run: &Run,
) -> Result<Solved> {
    run.check()?;
    run.stage("solve", film.frames.len() as u64, || match knobs.method {
        Method::Global => {
            let parameters = Parameters::new(film, spacing, knobs, run)?;
            parameters.write(film, &Weights::of(knobs))
        }
        Method::Propagate => Ok(propagate::film(film, knobs)),
        Method::Diffuse => Ok(diffuse::film(film, knobs)),
        Method::Arclength => Ok(arc_length(film, knobs)),
    })
}

impl Weights {
    /// The weights that knobs ask for: those set by hand, else by coherence.
    pub fn of(knobs: &LinesKnobs) -> Self {
        let by_coherence = 10f64.powf(-4.0 + 4.0 * f64::from(knobs.coherence));
        let given = f64::from(knobs.w_projection);
        Self {
            projection: if given > 0.0 { given } else { by_coherence },
            distortion: f64::from(knobs.w_distortion),
            end: f64::from(knobs.w_end),
        }
    }
}

/// Every frame by itself: picture length.
fn arc_length(film: &mut Film, knobs: &LinesKnobs) -> Solved {
    let mut unknowns = 0;
    for frame in &mut film.frames {
        for stroke in frame.strokes.iter_mut().chain(&mut frame.hidden) {
            let scale = match knobs.texture {
                Texture::Periodic => f64::from(knobs.pattern_length),
                Texture::Stretched => stroke.total().max(1e-3),
            };
            unknowns += stroke.samples.len();
            let u = stroke.length.iter().map(|l| l / scale).collect();
            stroke.set_u(u, scale);
        }
    }
    Solved { unknowns, ..Solved::default() }
}

/// A film's problem with everything that does not depend on weights.
pub struct Parameters {
    net: Net,
    energy: Energy,
    kept: Kept,
    scale: Vec<f64>,
    period: Vec<Option<f64>>,
    /// The strokes of the film as parts of lines.
    parts: Parts,
    /// Of each stroke: whose texture it shows, and the period of that.
    textures: Vec<(u32, Option<f64>)>,
    saved: Option<Saved>,
}

impl Parameters {
    /// Carries seams, finds links, cuts, and factors the pattern. Seams move samples of closed lines,
    /// and cuts part strokes.
    pub fn new(film: &mut Film, spacing: &[f64], knobs: &LinesKnobs, run: &Run) -> Result<Self> {
        seam::carry(film);
        if knobs.cuts != Cuts::Auto {
            return Self::cut(film, spacing, knobs, run);
        }
        let cut_as = |cuts| LinesKnobs { cuts, ..knobs.clone() };
        let strokes = |f: &FilmFrame| (f.strokes.clone(), f.hidden.clone());
        let whole: Vec<_> = film.frames.iter().map(strokes).collect();
        let charts = Self::cut(film, spacing, &cut_as(Cuts::Charts), run)?;
        if charts.contradicting() <= LEFT {
            return Ok(charts);
        }
        drop(charts);
        for (frame, strokes) in film.frames.iter_mut().zip(whole) {
            (frame.strokes, frame.hidden) = strokes;
        }
        Self::cut(film, spacing, &cut_as(Cuts::Both), run)
    }

    /// The share of what links hold that contradicts the rest.
    fn contradicting(&self) -> f64 {
        let all: f64 = self.net.links.iter().map(|l| l.weight).sum();
        self.kept.cut_length / all.max(1e-9)
    }

    /// Finds links, cuts as the knobs say, and factors the pattern.
    fn cut(film: &mut Film, spacing: &[f64], knobs: &LinesKnobs, run: &Run) -> Result<Self> {
        let sigma = f64::from(knobs.sliding_limit);
        let mut found = Found::default();
        let mut linked = |film: &Film, anneal: &[f64], before: Option<&Self>| {
            Self::linked(film, spacing, knobs, (anneal, run), (&mut found, before))
        };
        let mut made = linked(film, &cut::ANNEAL, None)?;
        if matches!(knobs.cuts, Cuts::Both | Cuts::Events | Cuts::Unpaired) {
            let paired = knobs.cuts != Cuts::Unpaired;
            let (places, saved) = chart::events(&made.net, paired, sigma, None);
            split::split(film, &made.net, &places);
            made = Self { saved: Some(saved), ..linked(film, &cut::AGAIN, Some(&made))? };
        }
        let to_charts = matches!(knobs.cuts, Cuts::Charts | Cuts::Both);
        for _ in 0..if to_charts { ROUNDS } else { 0 } {
            let residual = |i: u32| made.kept.residual[i as usize];
            let places = chart::contradictions(&made.net, &residual, sigma);
            if split::split(film, &made.net, &places).0 == 0 {
                break;
            }
            made = Self { saved: made.saved, ..linked(film, &cut::AGAIN, Some(&made))? };
        }
        if knobs.texture == Texture::Periodic {
            made.carry_on(film, spacing, sigma);
        }
        let swept = knobs.links == Links::Swept;
        let carried = texture::carried(&made.net, &made.kept.trust, &made.period);
        let whole = made.whole(&carried);
        made.parts = Parts::of(film, &whole, to_charts.then_some(sigma), (swept, found));
        let period: Vec<Option<f64>> =
            made.parts.origins.iter().map(|o| carried[o.line as usize]).collect();
        made.textures = texture::shown(&made.parts.components, &period);
        Ok(made)
    }

    /// Ties lines to what they go on as behind what hides them, where that agrees with the links.
    fn carry_on(&mut self, film: &Film, spacing: &[f64], sigma: f64) {
        let Self { net, kept, scale, period, energy, .. } = self;
        let across = onward::agreeing(film, net, kept, (scale, period), sigma);
        let dt = intervals(film.frames.len(), spacing);
        let setting = Setting { scale, period, dt: &dt, stretched: false };
        if !across.is_empty() {
            *energy = Energy::of(net, &setting, &across, Some(&*energy));
        }
    }

    /// The lines as they were solved; `carried`: the period of each one's texture.
    fn whole<'a>(&'a self, carried: &'a [Option<f64>]) -> Whole<'a> {
        let Self { net, kept, scale, period, .. } = self;
        Whole { net, kept, scale, period, carried }
    }

    /// Finds links and judges them, anew where strokes changed since they were `found` and factored.
    fn linked(
        film: &Film,
        spacing: &[f64],
        knobs: &LinesKnobs,
        (anneal, run): (&[f64], &Run),
        (found, before): (&mut Found, Option<&Self>),
    ) -> Result<Self> {
        let mut net = Net::of(film, knobs.links == Links::Swept, found);
        let stretched = knobs.texture == Texture::Stretched;
        let (scale, period) = sizes(film, &net, knobs);
        let lines = &net.lines;
        net.links.retain(|l| !crosses_seam(lines, l, &period));
        let dt = intervals(film.frames.len(), spacing);
        let setting = Setting { scale: &scale, period: &period, dt: &dt, stretched };
        let energy = Energy::of(&net, &setting, &[], before.map(|b| &b.energy));
        let kept = match knobs.cuts {
            Cuts::None => cut::all(&net, &energy, &scale, &period),
            _ => {
                let sigma = f64::from(knobs.sliding_limit);
                let judged = before.map(|b| (&b.energy, &b.kept));
                let robust = cut::Robust { weights: Weights::of(knobs), anneal, sigma, run };
                robust.agreeing(&net, &energy, &scale, &period, judged)?
            }
        };
        let parts = Parts { origins: Vec::new(), components: Vec::new() };
        Ok(Self { net, energy, kept, scale, period, parts, textures: Vec::new(), saved: None })
    }

    /// Solves with some weights and writes u into the strokes of the film it was made from.
    pub fn write(&self, film: &mut Film, weights: &Weights) -> Result<Solved> {
        let links = (self.kept.trust.as_slice(), self.kept.wraps.as_slice());
        let (mut u, mended) =
            monotone::solve(&self.net, &self.energy, weights, links).map_err(failed)?;
        let mut own = Vec::with_capacity(self.net.lines.len());
        for (l, line) in self.net.lines.iter().enumerate() {
            let (scale, period) = (self.scale[l], self.period[l]);
            monotone::rising(line, &mut u, scale, period);
            let samples = &u[line.first as usize..(line.first + line.count) as usize];
            own.push(part::closed_up(line, samples, scale, period));
        }
        let strokes =
            film.frames.iter_mut().flat_map(|f| f.strokes.iter_mut().chain(&mut f.hidden));
        let parts = self.parts.origins.iter().zip(&self.textures);
        let mut count = vec![0; self.net.lines.len()];
        self.parts.origins.iter().for_each(|o| count[o.line as usize] += 1);
        for (stroke, (origin, texture)) in strokes.zip(parts) {
            let l = origin.line as usize;
            let closed = self.net.lines[l].closed;
            stroke.part =
                (count[l] > 1 || closed != stroke.closed).then_some((origin.line, closed));
            let u = part::values(&self.net.lines[l], &own[l], origin, &stroke.length);
            stroke.set_u(u, self.scale[l]);
            (stroke.component, stroke.repeats) = (Some(texture.0), texture.1);
        }
        Ok(Solved {
            unknowns: self.net.unknowns,
            links: self.net.links.len(),
            cut: self.kept.cut,
            cut_length: self.kept.cut_length,
            charts: self.textures.iter().enumerate().filter(|(l, t)| t.0 as usize == *l).count(),
            lines: self.textures.len(),
            mended,
            saved: self.saved,
        })
    }
}

fn failed(error: chiaro_solve::Singular) -> Error {
    let weights = "w_projection, w_distortion, w_end";
    Error::setting(weights, format!("weights for which {error}"), "weights nearer to the defaults")
}

/// Length of the interval after each frame in 24ths of a second.
fn intervals(frames: usize, spacing: &[f64]) -> Vec<f64> {
    let mut last = 1.0;
    (0..frames)
        .map(|i| {
            let given = spacing.get(i).map(|s| (24.0 * s).abs()).filter(|d| *d > 1e-3);
            last = given.unwrap_or(last);
            last
        })
        .collect()
}

/// Whether a link passes a loop's seam where the loop does not close.
fn crosses_seam(lines: &[net::Line], link: &net::Link, period: &[Option<f64>]) -> bool {
    let [a, b] = link.lines;
    let to = &lines[b as usize];
    if to.closed && period[b as usize].is_none() && link.around {
        return true;
    }
    let from = &lines[a as usize];
    if !(from.closed && to.closed) || (period[a as usize].is_some() && period[b as usize].is_some())
    {
        return false;
    }
    let at = |line: &net::Line, unknown: u32| {
        line.length[(unknown - line.first) as usize] / line.total()
    };
    (at(from, link.from) - at(to, link.to[0])).abs() > 0.5
}

/// Pixels a unit of u of every line, and the period of the closed ones that close without a seam.
fn sizes(film: &Film, net: &Net, knobs: &LinesKnobs) -> (Vec<f64>, Vec<Option<f64>>) {
    if knobs.texture == Texture::Stretched {
        let scale = net.lines.iter().map(|l| l.total().max(1e-3)).collect();
        let period = net.lines.iter().map(|l| l.closed.then_some(1.0)).collect();
        return (scale, period);
    }
    let zoom = if knobs.octaves { octave::zoom(film, net) } else { vec![1.0; film.frames.len()] };
    let pattern = f64::from(knobs.pattern_length);
    let scale: Vec<f64> = net.lines.iter().map(|l| pattern * zoom[l.frame as usize]).collect();
    let mut period = vec![None; net.lines.len()];
    for lines in loops(net).into_values() {
        let turns = |l: &u32| net.lines[*l as usize].total() / scale[*l as usize];
        let (low, high) =
            lines.iter().map(turns).fold((f64::INFINITY, 0.0f64), |a, t| (a.0.min(t), a.1.max(t)));
        if high <= LOOP_GROWTH * low {
            // As far from the shortest as from the longest, in octaves.
            let whole = (low * high).sqrt().round().max(1.0);
            lines.iter().for_each(|l| period[*l as usize] = Some(whole));
        }
    }
    (scale, period)
}

/// Closed lines of the film that links join, by the first of them.
fn loops(net: &Net) -> BTreeMap<u32, Vec<u32>> {
    let mut sets = Sets::new(net.lines.len());
    for link in &net.links {
        let [a, b] = link.lines.map(|l| l as usize);
        if net.lines[a].closed && net.lines[b].closed {
            sets.join(a, b);
        }
    }
    let mut groups: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for l in (0..net.lines.len() as u32).filter(|l| net.lines[*l as usize].closed) {
        groups.entry(sets.root(l as usize) as u32).or_default().push(l);
    }
    groups
}
