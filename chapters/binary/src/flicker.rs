//! Flicker: how much the labels of a film change, measured along the motion of material points.
//!
//! A *flip* is a change of label along a link; a *reversal* is a flip that undoes another within
//! [`REVERSAL`] frames at the same material point; a *tone flip* is a change of the sign of W - B
//! along the same links; a *pop* is a connected group of flipped pixels near which nothing had the
//! new colour before. Of more than two labels the tone's side is the one that the pixel alone would
//! take.
//!
//! Flips that the tone makes too are true, and so are reversals of which it makes both flips: they
//! are counted apart. Links are to whole pixels, so along a crease that turns a border that keeps to
//! it crosses pixels back and forth as they happen to fall on either side; what is left is flicker.

use chiaro_image::Plane;
use chiaro_image::labels::components;
use chiaro_trace::UNLINKED;

/// Frames within which a flip that is undone counts as a reversal.
pub const REVERSAL: u8 = 4;

/// How far the new colour may have been, in pixels, for a flip to be a border's motion and no pop.
const NEAR: isize = 2;

/// How far a border is looked for, in pixels, when its lag is measured.
const REACH: isize = 8;

/// One frame as the measures need it; all planes have the picture's size.
pub struct Shown<'a> {
    /// Its labels.
    pub labels: &'a Plane<u8>,
    /// Where there is geometry.
    pub covered: &'a Plane<bool>,
    /// For each pixel the pixel of the frame before that shows the same material point.
    pub links: &'a Plane<u32>,
    /// The labels of the frame's own minimal cut; equal to `labels` where there is none to compare.
    pub alone: &'a Plane<u8>,
    /// The label that the pixel's own terminals want.
    pub tone: &'a Plane<u8>,
    /// The spatial energy of its labels and of its own cut.
    pub energy: [i64; 2],
}

/// Counts over a film.
#[derive(Clone, Debug, Default)]
pub struct Flicker {
    /// Pixels that were seen in the frame before too.
    pub visible: u64,
    /// Of those, label changes.
    pub flips: u64,
    /// Flips that undo another.
    pub reversals: u64,
    /// Of those, such that the tone made both flips.
    pub tone_reversals: u64,
    /// Changes of the tone's side.
    pub tone_flips: u64,
    /// The largest pop of each pair of frames, in pixels.
    pub pops: Vec<u32>,
    /// Spatial energy of the film's labels and of the frames' own cuts.
    pub energy: [i64; 2],
    /// What the island rule adds to the energy of the frames' own cuts, for whoever adds it up.
    pub islands: i64,
    /// Sum of signed distances by which moving borders trail those of the frames' own cuts, pixels,
    /// and how many border pixels were looked at.
    pub lag: (f64, u64),
    before: Option<Before>,
}

#[derive(Clone, Debug)]
struct Before {
    number: usize,
    labels: Plane<u8>,
    alone: Plane<u8>,
    tone: Plane<u8>,
    last: Plane<Flip>,
}

/// A material point's last flip.
#[derive(Clone, Copy, Debug)]
struct Flip {
    /// Frames since; 255 for long.
    age: u8,
    /// Whether the tone flipped with it.
    by_tone: bool,
}

impl Flip {
    const NEVER: Self = Self { age: u8::MAX, by_tone: false };
}

impl Flicker {
    /// Adds frame `number` of a shot; frames that do not follow each other are not compared.
    pub fn add(&mut self, number: usize, shown: &Shown) {
        for (sum, e) in self.energy.iter_mut().zip(shown.energy) {
            *sum += e;
        }
        let before = self.before.take().filter(|b| b.number + 1 == number);
        let last = match &before {
            Some(before) => self.compare(before, shown),
            None => shown.labels.map(|_| Flip::NEVER),
        };
        self.before = Some(Before {
            number,
            labels: shown.labels.clone(),
            alone: shown.alone.clone(),
            tone: shown.tone.clone(),
            last,
        });
    }

    /// Adds the counts of another film, such as that of another step between tones.
    pub fn join(&mut self, other: &Self) {
        self.visible += other.visible;
        self.flips += other.flips;
        self.reversals += other.reversals;
        self.tone_reversals += other.tone_reversals;
        self.tone_flips += other.tone_flips;
        self.pops.extend(&other.pops);
        self.energy = [self.energy[0] + other.energy[0], self.energy[1] + other.energy[1]];
        self.islands += other.islands;
        self.lag = (self.lag.0 + other.lag.0, self.lag.1 + other.lag.1);
    }

    /// Flips per visible pixel.
    pub fn flips_per_pixel(&self) -> f64 {
        self.per_pixel(self.flips)
    }

    /// Reversals per visible pixel.
    pub fn reversals_per_pixel(&self) -> f64 {
        self.per_pixel(self.reversals)
    }

    /// Reversals per visible pixel of which the tone made both flips.
    pub fn tone_reversals_per_pixel(&self) -> f64 {
        self.per_pixel(self.tone_reversals)
    }

    /// Reversals per visible pixel that the tone did not make.
    pub fn flicker_per_pixel(&self) -> f64 {
        self.per_pixel(self.reversals - self.tone_reversals)
    }

    /// Tone flips per visible pixel.
    pub fn tone_flips_per_pixel(&self) -> f64 {
        self.per_pixel(self.tone_flips)
    }

    fn per_pixel(&self, count: u64) -> f64 {
        count as f64 / self.visible.max(1) as f64
    }

    /// The 99th percentile over frames of the largest pop, pixels.
    pub fn pop_p99(&self) -> u32 {
        let mut pops = self.pops.clone();
        pops.sort_unstable();
        let last = pops.len().saturating_sub(1);
        pops.get((0.99 * last as f64).ceil() as usize).copied().unwrap_or(0)
    }

    /// Spatial energy beyond that of the frames' own cuts, as a share.
    pub fn energy_excess(&self) -> f64 {
        let [film, alone] = self.energy;
        if alone == 0 { 0.0 } else { film as f64 / alone as f64 - 1.0 }
    }

    /// The share of that which frames on their own have too, by the island rule.
    pub fn island_excess(&self) -> f64 {
        let alone = self.energy[1];
        if alone == 0 { 0.0 } else { self.islands as f64 / alone as f64 }
    }

    /// Spatial energy beyond that of the frames' own labels after the same island rule, as a share:
    /// what coherence alone costs.
    pub fn coherence_excess(&self) -> f64 {
        let alone = self.energy[1] + self.islands;
        if alone == 0 { 0.0 } else { self.energy[0] as f64 / alone as f64 - 1.0 }
    }

    /// The mean distance by which moving borders trail, in pixels.
    pub fn lag_px(&self) -> f64 {
        if self.lag.1 == 0 { 0.0 } else { self.lag.0 / self.lag.1 as f64 }
    }

    /// Counts what changed; the last flips after it.
    fn compare(&mut self, before: &Before, shown: &Shown) -> Plane<Flip> {
        let (w, h) = shown.labels.size();
        let mut last = Plane::filled(w, h, Flip::NEVER);
        let mut popped = Plane::filled(w, h, false);
        let mut moved = Plane::filled(w, h, false);
        for i in 0..w * h {
            let link = shown.links.pixels()[i];
            if link == UNLINKED {
                continue;
            }
            let from = link as usize;
            let (label, former) = (shown.labels.pixels()[i], before.labels.pixels()[from]);
            let (tone, tone_before) = (shown.tone.pixels()[i], before.tone.pixels()[from]);
            self.visible += 1;
            self.tone_flips += u64::from(tone != tone_before);
            moved.pixels_mut()[i] = shown.alone.pixels()[i] != before.alone.pixels()[from];
            let older = before.last.pixels()[from];
            let age = older.age.saturating_add(1);
            last.pixels_mut()[i] = Flip { age, ..older };
            if label != former {
                let by_tone = (tone, tone_before) == (label, former);
                self.flips += 1;
                self.reversals += u64::from(age <= REVERSAL);
                self.tone_reversals += u64::from(age <= REVERSAL && by_tone && older.by_tone);
                last.pixels_mut()[i] = Flip { age: 0, by_tone };
                popped.pixels_mut()[i] = !is_near(&before.labels, from, label);
            }
        }
        let groups = components(shown.labels, &popped).pieces;
        self.pops.push(groups.iter().map(|p| p.area as u32).max().unwrap_or(0));
        self.measure_lag(shown, before, &moved);
        last
    }

    /// Compares each border of the film, where the frame's own cut has one that just moved nearby,
    /// with that one.
    fn measure_lag(&mut self, shown: &Shown, before: &Before, moved: &Plane<bool>) {
        if shown.labels == shown.alone {
            self.lag.1 += moved.pixels().iter().filter(|m| **m).count() as u64;
            return;
        }
        let (w, h) = shown.labels.size();
        for y in 0..h {
            for x in 0..w {
                for (dx, dy) in [(1, 0), (0, 1)] {
                    let q = (x + dx, y + dy);
                    let inside = q.0 < w && q.1 < h && shown.covered[(x, y)] && shown.covered[q];
                    if inside
                        && shown.labels[(x, y)] != shown.labels[q]
                        && let Some(distance) = lag_at(shown, before, moved, (x, y), (dx, dy))
                    {
                        self.lag.0 += distance;
                        self.lag.1 += 1;
                    }
                }
            }
        }
    }
}

/// Whether a label occurs within [`NEAR`] pixels of a place.
fn is_near(labels: &Plane<u8>, at: usize, label: u8) -> bool {
    let (x, y) = ((at % labels.width()) as isize, (at / labels.width()) as isize);
    (-NEAR..=NEAR).any(|v| (-NEAR..=NEAR).any(|u| labels.at(x + u, y + v) == Some(&label)))
}

/// The signed distance along an axis from a border of the film between `p` and its neighbour to
/// the border of the frame's own cut of the same sense, where that one moved: positive where the
/// film still shows what the cut has left.
fn lag_at(
    shown: &Shown,
    before: &Before,
    moved: &Plane<bool>,
    p: (usize, usize),
    (dx, dy): (usize, usize),
) -> Option<f64> {
    let (here, there) = (shown.labels[p], shown.labels[(p.0 + dx, p.1 + dy)]);
    let at = |n: isize| (p.0 as isize + n * dx as isize, p.1 as isize + n * dy as isize);
    let alone = |n: isize| shown.alone.at(at(n).0, at(n).1).copied();
    let is_border = |n: isize| alone(n) == Some(here) && alone(n + 1) == Some(there);
    let n = (0..=REACH).find_map(|d| [d, -d].into_iter().find(|n| is_border(*n)))?;
    let near = |m: isize| moved.at(at(m).0, at(m).1) == Some(&true);
    if !(n.min(0) - 1..=n.max(0) + 2).any(near) {
        return None;
    }
    if n == 0 {
        return Some(0.0);
    }
    // Between the two borders film and cut disagree; it trails if the film has the label of before.
    let middle = if n > 0 { at(1) } else { at(0) };
    let pixel = (middle.0 as usize, middle.1 as usize);
    let link = shown.links[pixel];
    if link == UNLINKED {
        return None;
    }
    let trails = before.alone.pixels()[link as usize] == shown.labels[pixel];
    Some(if trails { n.abs() as f64 } else { -(n.abs() as f64) })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Films of a still object, drawn as rows of `.` for white.
    fn measured(frames: &[(&str, &str)]) -> Flicker {
        let mut flicker = Flicker::default();
        let plane =
            |text: &str| Plane::from_fn(text.len(), 1, |x, _| u8::from(text.as_bytes()[x] == b'.'));
        for (i, (film, alone)) in frames.iter().enumerate() {
            let (labels, alone) = (plane(film), plane(alone));
            let links = Plane::from_fn(film.len(), 1, |x, _| x as u32);
            let covered = Plane::filled(film.len(), 1, true);
            let shown = Shown {
                labels: &labels,
                covered: &covered,
                links: &links,
                alone: &alone,
                tone: &alone,
                energy: [11, 10],
            };
            flicker.add(i, &shown);
        }
        flicker
    }

    #[test]
    fn a_flip_that_is_undone_is_a_reversal() {
        let film = measured(&[("..##", "..##"), (".###", ".###"), ("..##", "..##")]);
        assert_eq!((film.flips, film.reversals, film.tone_flips, film.visible), (2, 1, 2, 8));
        let slow = ["..##", ".###", ".###", ".###", ".###", ".###", "..##"];
        let film = measured(&slow.map(|f| (f, f)));
        assert_eq!((film.flips, film.reversals), (2, 0));
        assert!((film.energy_excess() - 0.1).abs() < 1e-9);
        let islands = Flicker { islands: 7, ..film };
        assert!((islands.coherence_excess()).abs() < 1e-9);
    }

    #[test]
    fn reversals_that_the_tone_makes_are_told_apart() {
        let tones = ["..##", ".###", "..##"];
        let same = measured(&tones.map(|t| (t, t)));
        assert_eq!((same.reversals, same.tone_reversals), (1, 1));
        let other =
            measured(&[("..##", "..##"), ("..##", ".###"), (".###", ".###"), ("..##", "..##")]);
        assert_eq!((other.reversals, other.tone_reversals), (1, 0));
        assert!(other.flicker_per_pixel() > 0.0 && same.flicker_per_pixel() == 0.0);
    }

    #[test]
    fn what_appears_far_from_its_colour_pops() {
        let film = measured(&[("......##", "......##"), (".##...##", ".##...##")]);
        assert_eq!(film.pop_p99(), 2);
        let film = measured(&[("......##", "......##"), ("....####", "....####")]);
        assert_eq!(film.pop_p99(), 0);
    }

    #[test]
    fn a_border_that_stays_behind_lags() {
        let film = measured(&[("...#####", "...#####"), ("...#####", ".....###")]);
        assert_eq!(film.lag_px(), 2.0);
        let film = measured(&[("...#####", "...#####"), (".......#", ".....###")]);
        assert_eq!(film.lag_px(), -2.0);
    }
}
