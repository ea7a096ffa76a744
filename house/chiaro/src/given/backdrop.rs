//! The plain backdrop of a photograph that brings no mask: things on a white table, a bust before black.
//!
//! 1. The backdrop's colour is the median of the picture's frame, if half of the frame is like it.
//! 2. The backdrop is what is like it and connected to the frame. It must be a good part of the
//!    picture, and most of its frame, and not all of it.
//! 3. A lamp that stands aside and a lens that darkens its corners shade it: a cubic over what was
//!    found takes the median's place, and what is like that is found in its turn. What is burnt
//!    white says only that the cubic is as bright there.
//! 4. Grain and walls are no backdrop: what is found must not be ragged, and be flat where normals are
//!    known. Normals that go on across its border tell shadows that fall on it: what is darker in its
//!    own hue and faces as it does is part of it. Where they still go on, in one hue, it is no backdrop,
//!    but a floor or a thing. Specks in it are part of it. What is darker by itself, touches no thing that
//!    could cast it and has a sharp edge lies on it: a grey card.
//!
//! Left out, it is paper, and light and shade are divided over the things themselves. Where nothing
//! but colours is known, dark backdrops stay: they may be the night.

use chiaro_basis::Sets;
use chiaro_image::Plane;
use chiaro_image::colour::{srgb_decode, srgb_encode};
use chiaro_image::labels::components;
use chiaro_solve::{Normal, Rows};

/// Difference of displayed colour, at most, of what is like the backdrop.
const ALIKE: f32 = 0.12;
/// Share of the frame that is like the backdrop, at least: like its median, and in all.
const OF_FRAME: [f32; 2] = [0.5, 0.7];
/// Share of the picture that the backdrop takes, at least and at most.
const OF_PICTURE: [f32; 2] = [0.15, 0.98];
/// Sides of a backdrop's pixels that are border, at most.
const RAGGED: f32 = 0.25;
/// Share of a backdrop whose normals differ by no more than this from their median, at least.
const FLAT: [f32; 2] = [0.8, 0.3];
/// Normals that differ by no more than this go on from pixel to pixel.
const GOES_ON: f32 = 0.1;
/// The share of a backdrop's border where they do, at most, before shadows are looked for and after.
const GONE_ON: [f32; 2] = [0.12, 0.4];
/// The light that a shadow leaves, at least, and how much that may differ from channel to channel.
const SHADOW: [f32; 2] = [0.1, 0.2];
/// The share of a shadow's border along which it meets what casts it, at least, and the area of that in
/// areas of the shadow.
const CAST: [f32; 2] = [0.1, 0.1];
/// Pixels that a sharp edge takes, and how much of its step may lie in what it bounds.
const EDGE: isize = 3;
const SOFT: f32 = 0.25;
/// Shares of light that differ by more, as a factor, are those of two pieces.
const STEP: f32 = 1.3;
/// The share of a card's border that is such an edge, at least, and the smallest card in pixels of a
/// picture of 480 rows.
const BOUND: f32 = 0.3;
const CARD: f32 = 60.0;
/// How far the normals of a shadow may be from those of what it falls on, which stereo by shading bends there.
const FACES: f32 = 0.5;
/// Smaller pieces within a backdrop are specks, in pixels of a picture of 480 rows.
const SPECK: f32 = 8.0;
/// Displayed brightness from which a backdrop is paper.
const LIGHT: f32 = 0.6;
/// How often the shade of the backdrop is fitted, by about how many pixels.
const FITS: usize = 6;
const FITTED: usize = 4096;
/// How far the fitted colour may be from the median.
const SHADED: f32 = 0.5;
/// A channel is burnt from here on, and then counts so much where no fit says more.
const BURNT: f32 = 0.985;
const BURNT_WEIGHT: f64 = 0.05;

/// Where a picture in linear colour, opaque throughout, shows a plain backdrop. Normals are of no length where
/// there is nothing.
pub(super) fn backdrop(
    colour: &Plane<[f32; 4]>,
    normals: Option<&Plane<[f32; 3]>>,
) -> Option<Plane<bool>> {
    if colour.is_empty() || colour.pixels().iter().any(|p| p[3] < 1.0) {
        return None;
    }
    let shown = colour.map(|p| [p[0], p[1], p[2]].map(srgb_encode));
    let frame = frame(shown.size());
    let median = median(frame.iter().map(|p| shown[*p]));
    let brightness = median.iter().sum::<f32>() / 3.0;
    let alike = shown.map(|p| p.iter().zip(median).all(|(value, m)| (value - m).abs() <= ALIKE));
    let share = |count: usize, of: usize| count as f32 / of.max(1) as f32;
    let of_frame =
        |found: &Plane<bool>| share(frame.iter().filter(|p| found[**p]).count(), frame.len());
    if of_frame(&alike) < OF_FRAME[0] || normals.is_none() && brightness < LIGHT {
        return None;
    }
    let mut reached = reached(&alike, &frame);
    if is_ragged(&reached) {
        return None;
    }
    let mut shade: Option<Shade> = None;
    for _ in 0..FITS {
        let Some(fitted) = Shade::fitted(&shown, &reached, median, shade.as_ref()) else { break };
        let alike = Plane::from_fn(shown.width(), shown.height(), |x, y| {
            reached[(x, y)] || fitted.is_like((x, y), shown[(x, y)])
        });
        reached = self::reached(&alike, &frame);
        shade = Some(fitted);
    }
    if is_ragged(&reached) || !normals.is_none_or(|normals| is_flat(normals, &reached)) {
        return None;
    }
    fill_specks(&mut reached);
    let mut shadows = None;
    if let Some(normals) = normals.filter(|normals| gone_on(normals, &shown, &reached) > GONE_ON[0])
    {
        let shaded = Shadows { shade: shade.as_ref(), median, normal: facing(normals, &reached)? };
        let marks = Plane::from_fn(shown.width(), shown.height(), |x, y| {
            let p = (x, y);
            reached[p] || shaded.hold(p, shown[p], normals[p])
        });
        let plain = std::mem::replace(&mut reached, self::reached(&marks, &frame));
        fill_specks(&mut reached);
        if gone_on(normals, &shown, &reached) > GONE_ON[1] {
            return None;
        }
        shadows = Some((shaded, plain));
    }
    let of_picture = share(reached.pixels().iter().filter(|r| **r).count(), reached.len());
    let is_part = (OF_PICTURE[0]..=OF_PICTURE[1]).contains(&of_picture);
    if !is_part || of_frame(&reached) < OF_FRAME[1] {
        return None;
    }
    if let Some((shaded, plain)) = shadows {
        shaded.leave_cards(&mut reached, &plain, &shown);
    }
    Some(reached)
}

/// The outermost pixels.
fn frame((w, h): (usize, usize)) -> Vec<(usize, usize)> {
    let rows = (0..w).flat_map(|x| [(x, 0), (x, h - 1)]);
    rows.chain((0..h).flat_map(|y| [(0, y), (w - 1, y)])).collect()
}

/// The median of each channel.
fn median(colours: impl Iterator<Item = [f32; 3]>) -> [f32; 3] {
    let all: Vec<[f32; 3]> = colours.collect();
    std::array::from_fn(|c| {
        let mut values: Vec<f32> = all.iter().map(|p| p[c]).collect();
        values.sort_by(f32::total_cmp);
        values[values.len() / 2]
    })
}

/// The marked pixels that are connected to some by their sides.
fn reached(marks: &Plane<bool>, from: &[(usize, usize)]) -> Plane<bool> {
    let mut reached = marks.map(|_| false);
    let mut open = from.to_vec();
    while let Some((x, y)) = open.pop() {
        if !marks[(x, y)] || std::mem::replace(&mut reached[(x, y)], true) {
            continue;
        }
        let beside = [(x + 1, y), (x, y + 1), (x.wrapping_sub(1), y), (x, y.wrapping_sub(1))];
        open.extend(beside.into_iter().filter(|q| q.0 < marks.width() && q.1 < marks.height()));
    }
    reached
}

/// Whether a good part of the sides of some pixels are border.
fn is_ragged(marks: &Plane<bool>) -> bool {
    let (w, h) = marks.size();
    let (mut pixels, mut sides) = (0u32, 0u32);
    for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
        pixels += u32::from(marks[(x, y)]);
        let right = x + 1 < w && marks[(x, y)] != marks[(x + 1, y)];
        let below = y + 1 < h && marks[(x, y)] != marks[(x, y + 1)];
        sides += u32::from(right) + u32::from(below);
    }
    sides as f32 > RAGGED * pixels as f32
}

/// Whether most of the marked pixels that have normals face one way.
fn is_flat(normals: &Plane<[f32; 3]>, marks: &Plane<bool>) -> bool {
    let Some(middle) = facing(normals, marks) else { return true };
    let is_near = |n: &[f32; 3]| n.iter().zip(middle).all(|(a, m)| (a - m).abs() <= FLAT[1]);
    let pairs = normals.pixels().iter().zip(marks.pixels());
    let known = pairs.filter(|(n, m)| **m && **n != [0.0; 3]).map(|(n, _)| is_near(n));
    let (near, all) =
        known.fold((0, 0), |(near, all), is_near| (near + u32::from(is_near), all + 1));
    near as f32 >= FLAT[0] * all as f32
}

/// The median normal of the marked pixels that have some.
fn facing(normals: &Plane<[f32; 3]>, marks: &Plane<bool>) -> Option<[f32; 3]> {
    let pairs = normals.pixels().iter().zip(marks.pixels());
    let known: Vec<[f32; 3]> =
        pairs.filter(|(n, m)| **m && **n != [0.0; 3]).map(|(n, _)| *n).collect();
    (!known.is_empty()).then(|| median(known.into_iter()))
}

/// What is darker than the backdrop in its own hue, and faces as it does.
struct Shadows<'a> {
    shade: Option<&'a Shade>,
    median: [f32; 3],
    normal: [f32; 3],
}

impl Shadows<'_> {
    fn hold(&self, pixel: (usize, usize), colour: [f32; 3], normal: [f32; 3]) -> bool {
        let ground = self.shade.map_or(self.median, |shade| shade.at(pixel));
        let faces = normal.iter().zip(self.normal).all(|(n, m)| (n - m).abs() <= FACES);
        faces && shade_of(colour, ground).is_some_and(|share| (SHADOW[0]..1.5).contains(&share))
    }
}

impl Shadows<'_> {
    /// The share of the backdrop's light at a pixel.
    fn share(&self, pixel: (usize, usize), colour: [f32; 3]) -> f32 {
        let ground = self.shade.map_or(self.median, |shade| shade.at(pixel));
        let sum = |colour: [f32; 3]| colour.map(srgb_decode).iter().sum::<f32>();
        (sum(colour) / sum(ground).max(1e-3)).max(1e-3)
    }

    /// Takes back from what was reached beyond the plain backdrop what no thing casts: it touches
    /// neither things nor the frame, and its edge is sharp.
    fn leave_cards(&self, reached: &mut Plane<bool>, plain: &Plane<bool>, shown: &Plane<[f32; 3]>) {
        let (w, h) = reached.size();
        let kind = Plane::from_fn(w, h, |x, y| match (plain[(x, y)], reached[(x, y)]) {
            (true, _) => Kind::Plain,
            (_, true) => Kind::Darker(self.share((x, y), shown[(x, y)])),
            _ => Kind::Thing,
        });
        let ids = joined(&kind);
        let mut area = vec![0.0; w * h];
        ids.pixels().iter().for_each(|id| area[*id] += 1.0);
        let mut pieces = vec![Piece::default(); w * h];
        for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
            let Kind::Darker(share) = kind[(x, y)] else { continue };
            let id = ids[(x, y)];
            let piece = &mut pieces[id];
            piece.light += share;
            for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let at = |k: isize| {
                    let q = (x.checked_add_signed(k * dx)?, y.checked_add_signed(k * dy)?);
                    (q.0 < w && q.1 < h).then_some(q)
                };
                piece.is_framed |= at(1).is_none();
                if at(1).is_none_or(|q| ids[q] == id) {
                    continue;
                }
                // Darker pixels between are of the edge itself, or noise.
                let beyond = (1..=EDGE).filter_map(at).map(|q| (ids[q], kind[q]));
                match beyond.into_iter().find(|(_, kind)| !matches!(kind, Kind::Darker(_))) {
                    Some((_, Kind::Plain)) => {
                        piece.edge += share;
                        piece.edges += 1.0;
                    }
                    Some((other, _)) if area[other] >= CAST[1] * area[id] => piece.cast += 1.0,
                    Some(_) => piece.slivers += 1.0,
                    None => {}
                }
            }
        }
        let smallest = CARD * (h as f32 / 480.0).powi(2);
        let is_card: Vec<bool> = pieces
            .iter()
            .zip(&area)
            .map(|(piece, area)| *area >= smallest && piece.is_card(*area))
            .collect();
        for (reached, id) in reached.pixels_mut().iter_mut().zip(ids.pixels()) {
            *reached &= !is_card[*id];
        }
    }
}

/// Pixels of one piece by one number.
fn joined(kind: &Plane<Kind>) -> Plane<usize> {
    let (w, h) = kind.size();
    let mut sets = Sets::new(w * h);
    for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
        for (u, v) in [(x + 1, y), (x, y + 1)].into_iter().filter(|q| q.0 < w && q.1 < h) {
            if kind[(x, y)].goes_on(kind[(u, v)]) {
                sets.join(y * w + x, v * w + u);
            }
        }
    }
    Plane::from_pixels(w, h, (0..w * h).map(|i| sets.root(i)).collect())
}

/// What a pixel may be.
#[derive(Clone, Copy)]
enum Kind {
    /// The backdrop itself.
    Plain,
    /// Of its hue and with this share of its light: shadow on it, or a thing that lies on it.
    Darker(f32),
    /// Anything else.
    Thing,
}

impl Kind {
    /// Whether a pixel beside is of the same piece.
    fn goes_on(self, other: Self) -> bool {
        match (self, other) {
            (Self::Darker(a), Self::Darker(b)) => a.max(b) <= STEP * a.min(b),
            (Self::Plain, Self::Plain) | (Self::Thing, Self::Thing) => true,
            _ => false,
        }
    }
}

/// What is found of a piece that may be shadow.
#[derive(Clone, Default)]
struct Piece {
    /// The sum of its shares of light.
    light: f32,
    /// Sides of its border with large things, and with small ones.
    cast: f32,
    slivers: f32,
    /// Those with the plain backdrop, and the sum of shares of light there.
    edges: f32,
    edge: f32,
    /// Whether it touches the picture's frame.
    is_framed: bool,
}

impl Piece {
    fn is_card(&self, area: f32) -> bool {
        let mean = self.light / area;
        let is_sharp = self.edge <= self.edges * (mean + SOFT * (1.0 - mean));
        let border = self.cast + self.slivers + self.edges;
        let is_apart = self.cast < CAST[0] * border;
        let is_bound = self.edges >= BOUND * border && area >= border;
        self.light > 0.0 && !self.is_framed && is_apart && is_bound && is_sharp
    }
}

/// The share of light that one displayed colour has of another of the same hue.
fn shade_of(colour: [f32; 3], of: [f32; 3]) -> Option<f32> {
    let (colour, of) = (colour.map(srgb_decode), of.map(srgb_decode));
    let shares: [f32; 3] = std::array::from_fn(|c| colour[c].max(1e-3) / of[c].max(1e-3));
    let mean = shares.iter().sum::<f32>() / 3.0;
    shares.iter().all(|share| (share - mean).abs() <= SHADOW[1] * mean).then_some(mean)
}

/// The share of the border of the marked pixels across which normals go on in one hue.
fn gone_on(normals: &Plane<[f32; 3]>, shown: &Plane<[f32; 3]>, marks: &Plane<bool>) -> f32 {
    let (w, h) = marks.size();
    let pixels = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
    let pairs = pixels.flat_map(|(x, y)| [((x, y), (x + 1, y)), ((x, y), (x, y + 1))]);
    let (mut all, mut near) = (0u32, 0u32);
    for (p, q) in pairs.filter(|(_, q)| q.0 < w && q.1 < h) {
        let (n, m) = (normals[p], normals[q]);
        if marks[p] != marks[q] && n != [0.0; 3] && m != [0.0; 3] {
            all += 1;
            let faces = n.iter().zip(m).all(|(a, b)| (a - b).abs() <= GOES_ON);
            near += u32::from(faces && shade_of(shown[p], shown[q]).is_some());
        }
    }
    near as f32 / all.max(1) as f32
}

/// Marks small pieces of what is not marked.
fn fill_specks(marks: &mut Plane<bool>) {
    let area = SPECK * (marks.height() as f32 / 480.0).powi(2);
    let pieces = components(marks, &marks.map(|_| true));
    let small: Vec<bool> =
        pieces.pieces.iter().map(|p| !p.label && (p.area as f32) < area).collect();
    for (mark, id) in marks.pixels_mut().iter_mut().zip(pieces.ids.pixels()) {
        *mark |= small[*id as usize];
    }
}

/// How a backdrop's colour changes over the picture: a cubic for each channel.
struct Shade {
    size: (usize, usize),
    channels: [Vec<f64>; 3],
    median: [f32; 3],
}

impl Shade {
    /// The least-squares fit to the marked pixels; `None` where they do not determine it. What the fit
    /// before says tells which burnt pixels are darker in it.
    fn fitted(
        shown: &Plane<[f32; 3]>,
        marks: &Plane<bool>,
        median: [f32; 3],
        before: Option<&Self>,
    ) -> Option<Self> {
        let (w, h) = shown.size();
        let step = ((w * h) as f64 / FITTED as f64).sqrt().ceil().max(1.0) as usize;
        let grid = (0..h).step_by(step).flat_map(|y| (0..w).step_by(step).map(move |x| (x, y)));
        let pixels: Vec<(usize, usize)> = grid.filter(|p| marks[*p]).collect();
        let mut rows = Rows::new(TERMS);
        for p in &pixels {
            let terms = terms(*p, (w, h)).into_iter().enumerate();
            rows.push(&terms.map(|(i, t)| (i as u32, t)).collect::<Vec<_>>());
        }
        let equations = Normal::new(&rows);
        let solved = |channel: usize| {
            let weight = |p: &(usize, usize)| match before {
                _ if shown[*p][channel] < BURNT => 1.0,
                None => BURNT_WEIGHT,
                Some(fit) => f64::from(u8::from(fit.at(*p)[channel] < BURNT)),
            };
            let weights: Vec<f64> = pixels.iter().map(weight).collect();
            let right: Vec<f64> = pixels.iter().map(|p| f64::from(shown[*p][channel])).collect();
            equations.solve(&weights, &right).ok()
        };
        let channels = [solved(0)?, solved(1)?, solved(2)?];
        Some(Self { size: (w, h), channels, median })
    }

    /// The fitted colour at a pixel.
    fn at(&self, pixel: (usize, usize)) -> [f32; 3] {
        let terms = terms(pixel, self.size);
        let value = |fit: &Vec<f64>| fit.iter().zip(terms).map(|(a, t)| a * t).sum::<f64>() as f32;
        [0, 1, 2].map(|c| value(&self.channels[c]).min(1.0))
    }

    fn is_like(&self, pixel: (usize, usize), colour: [f32; 3]) -> bool {
        let near = |(c, fitted): (usize, f32)| {
            (colour[c] - fitted).abs() <= ALIKE && (fitted - self.median[c]).abs() <= SHADED
        };
        self.at(pixel).into_iter().enumerate().all(near)
    }
}

const TERMS: usize = 10;

/// The terms of a cubic over the picture, its sides from -1 to 1.
fn terms((x, y): (usize, usize), (w, h): (usize, usize)) -> [f64; TERMS] {
    let along = |at: usize, of: usize| (2 * at + 1) as f64 / of as f64 - 1.0;
    let (x, y) = (along(x, w), along(y, h));
    [1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y]
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_image::colour;

    /// A disc of a tone on a ground of another, with a hole in it.
    fn disc(ground: f32, tone: f32) -> Plane<[f32; 4]> {
        Plane::from_fn(40, 30, |x, y| {
            let r = (x as f32 - 20.0).hypot(y as f32 - 15.0);
            let v = if (3.0..10.0).contains(&r) { tone } else { ground };
            [v, v, v, 1.0]
        })
    }

    #[test]
    fn plain_backdrops_are_found_and_holes_stay() {
        let found = backdrop(&disc(0.95, 0.2), None).unwrap();
        assert!(found[(0, 0)] && !found[(25, 15)] && !found[(20, 15)]);
        assert!(backdrop(&disc(0.0, 0.5), None).is_none(), "night");
        let normals =
            disc(0.0, 0.5).map(|p| if p[0] > 0.2 { [0.6, 0.0, 0.8] } else { [0.0, 0.0, 1.0] });
        assert!(backdrop(&disc(0.0, 0.5), Some(&normals)).is_some());
    }

    #[test]
    fn walls_and_grain_are_no_backdrop_and_specks_are_part_of_it() {
        let corner =
            Plane::from_fn(40, 30, |x, _| if x < 16 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] });
        assert!(backdrop(&disc(0.95, 0.2), Some(&corner)).is_none(), "two walls");
        let grain = |share: f32| {
            let disc = disc(0.95, 0.2);
            Plane::from_fn(400, 300, |x, y| {
                let dark = chiaro_basis::random::unit(7, (y * 400 + x) as u64) < share;
                if dark { [0.5, 0.5, 0.5, 1.0] } else { disc[(x / 10, y / 10)] }
            })
        };
        assert!(backdrop(&grain(0.2), None).is_none(), "grain");
        let found = backdrop(&grain(0.01), None).unwrap();
        let ground = |i: usize| (i % 400 < 80 || i % 400 > 320) && i / 400 > 0;
        assert!((0..120_000).filter(|i| ground(*i)).all(|i| found.pixels()[i]), "specks");
    }

    #[test]
    fn shadows_are_part_of_a_backdrop_and_what_goes_on_into_things_is_none() {
        let disc = disc(0.95, 0.2);
        let is_thing = |p: (usize, usize)| disc[p][0] < 0.9;
        let floor = disc.map(|p| if p[0] < 0.9 { [0.6, 0.0, 0.8] } else { [0.0, 0.0, 1.0] });
        // A strip to its right, which lies on the floor.
        let strip = |colour: [f32; 3]| {
            Plane::from_fn(40, 30, |x, y| {
                let is_strip = (24..36).contains(&x) && (12..18).contains(&y) && !is_thing((x, y));
                let [r, g, b] = colour;
                if is_strip { [r, g, b, 1.0] } else { disc[(x, y)] }
            })
        };
        let paper = backdrop(&disc, Some(&floor)).unwrap();
        assert_eq!(backdrop(&strip([0.25; 3]), Some(&floor)).unwrap(), paper);
        let found = backdrop(&strip([0.5, 0.05, 0.05]), Some(&floor)).unwrap();
        assert!(!found[(33, 15)] && found[(38, 15)], "a red sheet of paper");
        // A grey card that lies apart, and a soft blot.
        let apart = |soft: f32| {
            Plane::from_fn(80, 30, |x, y| {
                let to = (x as f32 - 60.0).abs().max((y as f32 - 15.0).abs());
                let v = 0.4 + 0.55 * ((to - 4.0) / soft).clamp(0.0, 1.0);
                if x < 40 { disc[(x, y)] } else { [v, v, v, 1.0] }
            })
        };
        let wide = Plane::from_fn(80, 30, |x, y| floor[(x.min(39), y)]);
        let found = |soft| backdrop(&apart(soft), Some(&wide)).unwrap();
        assert!(!found(0.1)[(60, 15)] && found(0.1)[(70, 15)], "a grey card");
        assert!(found(9.0)[(60, 15)], "a soft blot");
        // A ball of the floor's own colour, lit from the left.
        let ball = Plane::from_fn(40, 30, |x, y| {
            let v = if is_thing((x, y)) { 0.95 - 0.04 * (x as f32 - 10.0) } else { 0.95 };
            [v, v, v, 1.0]
        });
        let smooth = Plane::from_fn(40, 30, |x, y| {
            if is_thing((x, y)) { [0.05 * (x as f32 - 20.0), 0.0, 0.8] } else { [0.0, 0.0, 1.0] }
        });
        assert!(backdrop(&ball, Some(&smooth)).is_none());
    }

    #[test]
    fn backdrops_that_a_lamp_shades_are_found_whole() {
        // From bright on one side to as dark on the other as no median tolerates.
        let shaded = Plane::from_fn(60, 40, |x, y| {
            let light = 0.97 - 0.2 * (1.0 - x as f32 / 60.0).powi(2);
            let is_thing = (x as f32 - 30.0).hypot(y as f32 - 20.0) < 9.0;
            let v = colour::srgb_decode(if is_thing { light - 0.3 } else { light });
            [v, v, v, 1.0]
        });
        let found = backdrop(&shaded, None).unwrap();
        for (i, found) in found.pixels().iter().enumerate() {
            let (x, y) = (i % 60, i / 60);
            let is_thing = (x as f32 - 30.0).hypot(y as f32 - 20.0) < 9.0;
            assert_eq!(*found, !is_thing, "{x} {y}");
        }
    }

    #[test]
    fn full_pictures_and_masks_are_left_alone() {
        let ramp = Plane::from_fn(40, 30, |x, y| [x as f32 / 40.0, y as f32 / 30.0, 0.5, 1.0]);
        let flat = ramp.map(|_| [0.0, 0.0, 1.0]);
        assert!(backdrop(&ramp, Some(&flat)).is_none());
        assert!(backdrop(&disc(0.9, 0.9), Some(&flat)).is_none(), "nothing but backdrop");
        let masked = disc(0.95, 0.2).map(|p| [p[0], p[1], p[2], 0.5]);
        assert!(backdrop(&masked, Some(&flat)).is_none());
        assert!(backdrop(&Plane::default(), None).is_none());
        assert!(backdrop(&Plane::filled(1, 1, [1.0; 4]), None).is_none());
    }
}
