//! Painting (section 3.6.2): strokes that bind pixels to white or black, and what they teach.
//!
//! 1. [`Strokes`] are lines of text: a label, a radius, points. Drawn in order, they bind pixels; an
//!    eraser frees them again.
//! 2. Each appearance channel's values under the strokes of one label make a density: a sum of hats
//!    of half-width 0.1 (3.10, 3.11), scaled to unit area over [0, 1] (3.12, 3.13). Without strokes
//!    of a label its density is uniform.
//! 3. W is the mean over the channels of -log p(value | black), B that of -log p(value | white), p
//!    being at least 1e-3; what both share is taken away, and the rest is divided by -log 1e-3: W - B
//!    lies in [-1, 1], as the sliders' does. The print allows negative weights, as densities exceed 1.
//! 4. Both differences are mixed, and what is painted is bound by more than all its neighbours.
//!
//! In a film strokes may belong to a frame. What they teach holds for the whole shot: a [`Lesson`]
//! gathers values over as many frames as there are strokes on. Strokes that teach nothing, such as
//! those beside all objects, leave the sliders as they are.

use crate::appearance::{Channel, Channels};
use crate::cut::Graph;
use crate::geometry::EDGES;
use chiaro_basis::{Error, Result};
use chiaro_image::Plane;

/// Half the width of a hat.
const HAT: f32 = 0.1;
/// The least density.
const LEAST: f32 = 1e-3;
/// Values at which densities are kept: 0 to 1 in equal steps.
const LEVELS: usize = 256;
/// The most strokes and points of a file.
const MOST_POINTS: usize = 200_000;

/// One stroke.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// White, black, or (none) erased.
    pub label: Option<bool>,
    /// In pixels of the picture that the strokes are stated for.
    pub radius: f32,
    /// The frame that it belongs to; `None`: every one.
    pub frame: Option<u32>,
    /// Pixels from the upper left corner, pixel centres at + 0.5.
    pub points: Vec<[f32; 2]>,
}

/// Strokes in the order in which they were drawn.
///
/// ```text
/// # A comment. Coordinates are those of a picture of this size; it may be drawn at any other.
/// size 640 480
/// white 6 120,80 140,90 150,110
/// black 4 frame 12 300,200
/// erase 10 140,90
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strokes {
    /// The size of the picture that they are stated for; `None`: any picture's own.
    pub size: Option<[f32; 2]>,
    /// The strokes.
    pub list: Vec<Stroke>,
}

impl Strokes {
    /// Reads a stroke file called `name`.
    ///
    /// # Errors
    /// [`Error::Input`] with the line that is wrong, [`Error::Limit`] for too many points.
    pub fn parse(name: &str, text: &str) -> Result<Self> {
        let mut strokes = Self::default();
        let mut points = 0;
        for (i, line) in text.lines().enumerate() {
            let line = line.split('#').next().unwrap_or_default();
            let wrong = |why: &str| Error::input(name, format!("line {}", i + 1), why);
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.as_slice() {
                [] => {}
                ["size", w, h] => {
                    let side = |t: &str| number(t).filter(|n| *n >= 1.0);
                    let size = side(w).zip(side(h));
                    let (w, h) =
                        size.ok_or_else(|| wrong("a size is two numbers, as in size 640 480"))?;
                    strokes.size = Some([w, h]);
                }
                [label, radius, rest @ ..] => {
                    let stroke = stroke(label, radius, rest).map_err(|why| wrong(&why))?;
                    points += stroke.points.len();
                    strokes.list.push(stroke);
                }
                _ => {
                    return Err(wrong(
                        "a stroke is a label, a radius and points, as in white 6 120,80 140,90",
                    ));
                }
            }
            if points > MOST_POINTS {
                let have = format!("{MOST_POINTS} points");
                return Err(Error::limit(format!("{name} (draw fewer strokes)"), "more", have));
            }
        }
        Ok(strokes)
    }

    /// The file's text; reads back as the same strokes.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        if let Some([w, h]) = self.size {
            text += &format!("size {w} {h}\n");
        }
        for stroke in &self.list {
            text += match stroke.label {
                Some(true) => "white",
                Some(false) => "black",
                None => "erase",
            };
            text += &format!(" {}", stroke.radius);
            if let Some(frame) = stroke.frame {
                text += &format!(" frame {frame}");
            }
            stroke.points.iter().for_each(|[x, y]| text += &format!(" {x},{y}"));
            text.push('\n');
        }
        text
    }

    /// The frames that single strokes belong to, in order, and whether any belong to all.
    pub fn frames(&self) -> (Vec<u32>, bool) {
        let mut frames: Vec<u32> = self.list.iter().filter_map(|s| s.frame).collect();
        frames.sort_unstable();
        frames.dedup();
        (frames, self.list.iter().any(|s| s.frame.is_none()))
    }

    /// Takes the last stroke back.
    pub fn undo(&mut self) -> Option<Stroke> {
        self.list.pop()
    }

    /// What is painted in a frame of `size` pixels: white, black, or nothing. What lies outside the
    /// picture is no matter.
    pub fn drawn(&self, size: (usize, usize), frame: u32) -> Plane<Option<bool>> {
        let mut plane = Plane::filled(size.0, size.1, None);
        let [w, h] = self.size.unwrap_or([size.0 as f32, size.1 as f32]);
        let scale = [size.0 as f32 / w, size.1 as f32 / h];
        let mine = |s: &&Stroke| s.frame.is_none_or(|f| f == frame);
        for stroke in self.list.iter().filter(mine) {
            let place = |p: &[f32; 2]| [p[0] * scale[0], p[1] * scale[1]];
            let radius = stroke.radius * scale[0].min(scale[1]);
            let points: Vec<[f32; 2]> = stroke.points.iter().map(place).collect();
            let only = points.first().map(|p| [*p, *p]);
            let pairs = points.windows(2).map(|w| [w[0], w[1]]).chain(only);
            pairs.for_each(|[a, b]| dab(&mut plane, a, b, radius, stroke.label));
        }
        plane
    }
}

fn number(text: &str) -> Option<f32> {
    text.parse::<f32>().ok().filter(|v| v.is_finite() && v.abs() <= 1e6)
}

fn stroke(label: &str, radius: &str, rest: &[&str]) -> std::result::Result<Stroke, String> {
    let label = match label {
        "white" => Some(true),
        "black" => Some(false),
        "erase" => None,
        other => return Err(format!("{other} is no label; write white, black, erase or size")),
    };
    let radius = number(radius).filter(|r| (0.0..=10_000.0).contains(r));
    let radius = radius.ok_or("a radius is a number of pixels from 0 to 10000")?;
    let (frame, points) = match rest {
        ["frame", n, points @ ..] => {
            let n: u32 = n.parse().map_err(|_| format!("{n} is no frame number"))?;
            (Some(n), points)
        }
        points => (None, points),
    };
    let point = |text: &&str| {
        let (x, y) = text.split_once(',')?;
        Some([number(x)?, number(y)?])
    };
    let all: Option<Vec<[f32; 2]>> = points.iter().map(point).collect();
    match all {
        Some(points) if !points.is_empty() => Ok(Stroke { label, radius, frame, points }),
        _ => Err("points are pairs of numbers up to a million, as in 120,80 140.5,90".into()),
    }
}

/// Sets the pixels within a radius of a segment; the pixel that it lies in always.
fn dab(
    plane: &mut Plane<Option<bool>>,
    a: [f32; 2],
    b: [f32; 2],
    radius: f32,
    label: Option<bool>,
) {
    let reach = radius.max(0.71);
    let (w, h) = plane.size();
    let span = |i: usize, n: usize| within(a[i].min(b[i]) - reach, a[i].max(b[i]) + reach, n);
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length2 = (dx * dx + dy * dy).max(f32::MIN_POSITIVE);
    for y in span(1, h) {
        for x in row(a, b, reach, y as f32 + 0.5, w) {
            let (px, py) = (x as f32 + 0.5 - a[0], y as f32 + 0.5 - a[1]);
            let t = ((px * dx + py * dy) / length2).clamp(0.0, 1.0);
            if (px - t * dx).hypot(py - t * dy) <= reach {
                plane[(x, y)] = label;
            }
        }
    }
}

/// The pixels of a row that may be within `reach` of a segment.
fn row(a: [f32; 2], b: [f32; 2], reach: f32, y: f32, width: usize) -> std::ops::Range<usize> {
    let rise = b[1] - a[1];
    // Where the segment comes within reach of the row's height.
    let at = |side: f32| {
        let t = (y + side * reach * rise.signum() - a[1]) / rise;
        a[0] + t.clamp(0.0, 1.0) * (b[0] - a[0])
    };
    let (p, q) = if rise == 0.0 { (a[0], b[0]) } else { (at(-1.0), at(1.0)) };
    within(p.min(q) - reach, p.max(q) + reach, width)
}

fn within(low: f32, high: f32, count: usize) -> std::ops::Range<usize> {
    let end = high.ceil().clamp(0.0, count as f32) as usize;
    low.floor().clamp(0.0, count as f32) as usize..end
}

/// What strokes teach: how often each value of each channel lies under strokes of a label.
#[derive(Clone, Debug)]
pub struct Lesson {
    /// For each channel the counts by level, under white and under black.
    counts: Vec<[Vec<u64>; 2]>,
}

impl Default for Lesson {
    fn default() -> Self {
        Self { counts: vec![[vec![0; LEVELS], vec![0; LEVELS]]; Channel::ALL.len()] }
    }
}

impl Lesson {
    /// Adds what is `drawn` over the channels of a picture.
    pub fn add(&mut self, drawn: &Plane<Option<bool>>, channels: &Channels, covered: &Plane<bool>) {
        for (counts, channel) in self.counts.iter_mut().zip(Channel::ALL) {
            let Some(plane) = channels.get(channel) else { continue };
            let seen = drawn.pixels().iter().zip(covered.pixels()).zip(plane.pixels());
            for ((drawn, _), value) in seen.filter(|((_, covered), _)| **covered) {
                if let Some(white) = drawn {
                    counts[usize::from(!white)][level(*value)] += 1;
                }
            }
        }
    }

    /// Whether nothing was under any stroke.
    pub fn is_empty(&self) -> bool {
        self.counts.iter().flatten().flatten().all(|n| *n == 0)
    }

    /// W - B of a picture as the strokes teach it.
    fn difference(&self, channels: &Channels, covered: &Plane<bool>) -> Plane<f32> {
        let taught = self.counts.iter().zip(Channel::ALL);
        let parts: Vec<(&Plane<f32>, [Vec<f32>; 2])> = taught
            .filter_map(|([white, black], channel)| {
                Some((channels.get(channel)?, [density(white), density(black)]))
            })
            .collect();
        let least = -LEAST.ln();
        let (w, h) = covered.size();
        Plane::from_fn(w, h, |x, y| {
            if !covered[(x, y)] || parts.is_empty() {
                return 0.0;
            }
            let cost = |label: usize| -> f32 {
                let log = |(plane, densities): &(&Plane<f32>, [Vec<f32>; 2])| {
                    -densities[label][level(plane[(x, y)])].max(LEAST).ln()
                };
                parts.iter().map(log).sum::<f32>() / parts.len() as f32
            };
            // W is paid when black, B when white; subtracting what both share leaves W - B as it is.
            ((cost(1) - cost(0)) / least).clamp(-1.0, 1.0)
        })
    }
}

/// Strokes on one picture, and what is known about the rest of it.
#[derive(Clone, Debug)]
pub struct Paint {
    drawn: Plane<Option<bool>>,
    /// W - B as strokes teach it, if they teach anything.
    learned: Option<Plane<f32>>,
    blend: f32,
}

impl Paint {
    /// Learns from what is `drawn` over the channels of a picture. `blend` is the share of what is
    /// learned in the terminal weights: 0 = sliders alone, 1 = paint alone.
    pub fn learn(
        drawn: Plane<Option<bool>>,
        channels: &Channels,
        covered: &Plane<bool>,
        blend: f32,
    ) -> Self {
        let mut lesson = Lesson::default();
        lesson.add(&drawn, channels, covered);
        Self::taught(drawn, &lesson, (channels, covered), blend)
    }

    /// What is `drawn` on a picture, with a lesson that was learned elsewhere as well.
    pub fn taught(
        drawn: Plane<Option<bool>>,
        lesson: &Lesson,
        (channels, covered): (&Channels, &Plane<bool>),
        blend: f32,
    ) -> Self {
        let learned = (!lesson.is_empty()).then(|| lesson.difference(channels, covered));
        Self { drawn, learned, blend }
    }

    /// W - B from sliders and strokes.
    pub(crate) fn mixed(&self, sliders: &Plane<f32>) -> Plane<f32> {
        let Some(learned) = &self.learned else { return sliders.clone() };
        let t = self.blend;
        sliders.zip(learned, |s, l| s + t * (l - s)).expect("one picture, one size")
    }

    /// Binds painted pixels: their own terminal outweighs all their neighbours, the other is 0.
    pub(crate) fn bind(&self, graph: &mut Graph) {
        for (p, white) in self.bound(graph) {
            let own = self.bond(graph, p);
            graph.terminal[p] = if white { [own, 0] } else { [0, own] };
        }
    }

    /// The nodes that are painted, and whether white.
    pub(crate) fn bound(&self, graph: &Graph) -> Vec<((usize, usize), bool)> {
        let (w, h) = self.drawn.size();
        let all = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
        all.filter_map(|p| Some((p, self.drawn[p].filter(|_| graph.mask[p])?))).collect()
    }

    /// What outweighs all neighbours of a pixel.
    pub(crate) fn bond(&self, graph: &Graph, p: (usize, usize)) -> i32 {
        around(&graph.neighbour, p).saturating_add(1)
    }

    /// The labels that are painted.
    pub fn drawn(&self) -> &Plane<Option<bool>> {
        &self.drawn
    }

    /// Labels with what is painted as it is painted.
    pub(crate) fn kept(&self, white: &Plane<bool>, mask: &Plane<bool>) -> Plane<bool> {
        let painted = self.drawn.zip(mask, |d, m| d.filter(|_| *m)).expect("one size");
        white.zip(&painted, |w, p| p.unwrap_or(*w)).expect("one size")
    }
}

/// The capacities of all edges of a pixel.
fn around(neighbour: &Plane<[i32; 4]>, (x, y): (usize, usize)) -> i32 {
    let ahead: i32 = neighbour[(x, y)].iter().sum();
    let behind = EDGES
        .iter()
        .enumerate()
        .filter_map(|(e, (dx, dy))| neighbour.at(x as isize - dx, y as isize - dy).map(|n| n[e]));
    ahead.saturating_add(behind.sum())
}

fn level(value: f32) -> usize {
    (value.clamp(0.0, 1.0) * (LEVELS - 1) as f32).round() as usize
}

/// The density of values that occur so often, at each level (3.10 to 3.13); uniform without any.
fn density(samples: &[u64]) -> Vec<f32> {
    if samples.iter().all(|n| *n == 0) {
        return vec![1.0; LEVELS];
    }
    normalized(&hats(samples))
}

/// The sum of a hat around each sample (3.11).
fn hats(samples: &[u64]) -> Vec<f32> {
    let step = 1.0 / (LEVELS - 1) as f32;
    let reach = (HAT / step).ceil() as usize;
    let hat = |i: usize, j: usize| (1.0 - i.abs_diff(j) as f32 * step / HAT).max(0.0);
    let at = |i: usize| {
        let near = i.saturating_sub(reach)..(i + reach + 1).min(LEVELS);
        near.map(|j| samples[j] as f32 * hat(i, j)).sum()
    };
    (0..LEVELS).map(at).collect()
}

/// Divided by the integral over [0, 1], by the trapezoidal rule (3.12, 3.13).
fn normalized(values: &[f32]) -> Vec<f32> {
    let inner: f32 = values.iter().sum::<f32>() - 0.5 * (values[0] + values[LEVELS - 1]);
    let area = inner / (LEVELS - 1) as f32;
    values.iter().map(|v| v / area.max(f32::MIN_POSITIVE)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn densities_have_unit_area_and_the_shape_of_a_hat() {
        let mut samples = vec![0; LEVELS];
        samples[level(0.5)] = 3;
        let p = density(&samples);
        let area: f32 = (1..LEVELS).map(|i| 0.5 * (p[i] + p[i - 1])).sum::<f32>() / 255.0;
        assert!((area - 1.0).abs() < 1e-4);
        // A hat of half-width 0.1 and area 1 is 10 high, 5 at half its width, 0 outside.
        assert!((p[level(0.5)] - 10.0).abs() < 0.1);
        assert!((p[level(0.55)] - 5.0).abs() < 0.3);
        assert_eq!(p[level(0.7)], 0.0);
        // Without strokes: uniform.
        assert!(density(&[0; LEVELS]).iter().all(|v| *v == 1.0));
    }

    #[test]
    fn strokes_teach_the_rest_of_the_picture() {
        let plane = Plane::from_fn(20, 1, |x, _| x as f32 / 19.0);
        let mask = Plane::filled(20, 1, true);
        let drawn = Plane::from_fn(20, 1, |x, _| match x {
            2 => Some(false),
            17 => Some(true),
            _ => None,
        });
        let paint = Paint::learn(drawn, &Channels::single(Channel::Diffuse, plane), &mask, 1.0);
        let w = paint.mixed(&Plane::filled(20, 1, 0.0));
        assert!(w[(2, 0)] < -0.9 && w[(1, 0)] < -0.5 && w[(17, 0)] > 0.9 && w[(18, 0)] > 0.5);
        assert_eq!(w[(10, 0)], 0.0);
        assert!(w.pixels().iter().all(|v| (-1.0..=1.0).contains(v)));
    }

    #[test]
    fn lessons_hold_for_other_pictures_and_empty_ones_change_nothing() {
        let mask = Plane::filled(20, 1, true);
        let ramp = |turned: bool| {
            let value = move |x: usize| if turned { 19 - x } else { x } as f32 / 19.0;
            Channels::single(Channel::Diffuse, Plane::from_fn(20, 1, |x, _| value(x)))
        };
        let at = |place: usize| Plane::from_fn(20, 1, |x, _| (x == place).then_some(true));
        let mut lesson = Lesson::default();
        let sliders = Plane::filled(20, 1, 0.3);
        let nothing = Plane::filled(20, 1, None);
        let mix = |lesson: &Lesson| {
            Paint::taught(nothing.clone(), lesson, (&ramp(true), &mask), 0.5).mixed(&sliders)
        };
        assert_eq!(mix(&lesson), sliders);
        lesson.add(&at(17), &ramp(false), &mask.map(|_| false));
        assert!(lesson.is_empty(), "strokes beside all objects");
        lesson.add(&at(17), &ramp(false), &mask);
        let mixed = mix(&lesson);
        assert!(mixed[(2, 0)] > 0.3 && mixed[(17, 0)] < 0.0, "{mixed:?}");
    }

    #[test]
    fn files_read_back_and_say_what_is_wrong() {
        let text =
            "# test\nsize 64 48\nwhite 3 1,2 3.5,4\nblack 0 frame 7 9,9 # dot\nerase 2 1,2\n";
        let mut strokes = Strokes::parse("a.strokes", text).unwrap();
        assert_eq!(strokes.list.len(), 3);
        assert_eq!(Strokes::parse("b", &strokes.to_text()).unwrap(), strokes);
        let seven = strokes.drawn((64, 48), 7);
        assert_eq!((seven[(9, 9)], strokes.drawn((64, 48), 8)[(9, 9)]), (Some(false), None));
        assert_eq!((seven[(0, 2)], seven[(5, 4)]), (None, Some(true)));
        assert_eq!(strokes.drawn((128, 96), 7)[(18, 18)], Some(false));
        assert_eq!(strokes.undo().unwrap().label, None);
        assert_eq!(strokes.drawn((64, 48), 7)[(0, 2)], Some(true));
        for wrong in [
            "grey 3 1,2",
            "white",
            "white x 1,2",
            "white 3",
            "white 3 1;2",
            "white 3 nan,1",
            "white 3 frame x 1,2",
            "size 0 3",
            "size 3",
            "white 3 1e9,1",
        ] {
            let error = Strokes::parse("a.strokes", wrong).unwrap_err().to_string();
            assert!(error.starts_with("a.strokes: line 1: "), "{error}");
        }
    }

    #[test]
    fn strokes_outside_the_picture_are_harmless() {
        let text = "white 5 -900000,3 -5,900000\nblack 9000 500000,500000\n";
        let strokes = Strokes::parse("a", text).unwrap();
        for size in [(1, 1), (1, 400), (0, 0)] {
            assert!(strokes.drawn(size, 1).pixels().iter().all(Option::is_none));
        }
    }

    #[test]
    fn painted_pixels_cannot_flip() {
        let mask = Plane::filled(9, 9, true);
        let drawn = Plane::from_fn(9, 9, |x, y| ((x, y) == (4, 4)).then_some(false));
        let channels = Channels::single(Channel::Diffuse, Plane::filled(9, 9, 1.0));
        let paint = Paint::learn(drawn, &channels, &mask, 0.0);
        let knobs = crate::BinaryKnobs { neighbour: 3.0, ..Default::default() };
        let factors = Plane::filled(9, 9, [1.0; 4]);
        let mut graph = Graph::new(&mask, &Plane::filled(9, 9, 0.9), &factors, &knobs);
        paint.bind(&mut graph);
        let labels = graph.solve().unwrap();
        let black = labels.white.pixels().iter().filter(|w| !**w).count();
        assert!(!labels.white[(4, 4)] && black < 81);
        assert_eq!(labels.flow, labels.cut);
    }
}
