//! Figure 4.4: the space-time surface S as a solid thing: picture across, time into the depth.
//!
//! Between two frames S is drawn as the bands between neighbouring crossings and what they become; at births,
//! deaths and saddles it is closed by fans round the event. Hidden parts of lines are parts of S.

use super::Figure;
use super::chapter4::{BLACK, Canvas, OBJECT, mark, shot};
use crate::lines::{Shot, picture};
use crate::project::{Options, Project};
use chiaro_basis::math::{DVec2, DVec3};
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_image::sheet::Sheet;
use chiaro_lines::track::EventKind;
use chiaro_lines::{Chain, FilmEvent, LinesKnobs, Slice};

pub(super) const FIGURES: [Figure; 1] = [Figure {
    name: "4.4",
    title: "the space-time surface",
    message: "S from the first frame (front) to the last, hidden parts too; one colour a chain, darker in every \
              fourth interval. Rings: births, dots: deaths, crosses: saddles, where they are not behind S.",
    columns: 2,
    draw: space_time,
}];

const FRAMES: u32 = 48;
const CANVAS: (usize, usize) = (720, 480);
/// Pixels of the model to a pixel of the sheet, along each side.
const FINE: usize = 2;
/// Where the light comes from, in the model.
const LIGHT: DVec3 = DVec3::new(-0.45, -0.65, -0.61);
/// Neighbours on a chain that become more than so many crossings apart are on its two sides.
const APART: u32 = 24;
/// A saddle closes gaps up to so far away, pixels.
const FAR: f64 = 40.0;
/// A mark may lie so far behind S and be seen, frames.
const BEHIND: f64 = 0.75;

/// A place in the model: on the sheet, and the time.
fn place(p: DVec2, time: f64) -> DVec3 {
    let t = time / f64::from(FRAMES - 1);
    DVec3::new(10.0 + 0.95 * p.x + 340.0 * t, 215.0 + 0.95 * p.y - 200.0 * t, time)
}

/// Where each crossing of each frame is.
type Places = Vec<Vec<Option<DVec3>>>;

fn space_time(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for scene in [OBJECT, "peanut"] {
        let shot = shot(scene, FRAMES, (360, 270), &LinesKnobs::default(), run)?;
        let places = places(scene, &shot, run)?;
        let mut model = Model::new();
        for i in 0..places.len().saturating_sub(1) {
            bands(&shot, &places, i, &mut model);
        }
        let fans = shot.film.events.iter().filter(|e| e.kind != EventKind::Saddle);
        fans.for_each(|event| fan(event, &shot, &places, &mut model));
        let mut canvas = Canvas::on(model.picture());
        for event in &shot.film.events {
            if let Some(at) = event.at.map(|p| place(p, event.time)).filter(|p| model.shows(*p)) {
                canvas.lines(&mark(event.kind, at.truncate(), 4.0), 1.5, BLACK);
            }
        }
        let count = |kind| shot.film.events.iter().filter(|e| e.kind == kind).count();
        let text = format!(
            "{scene}, {FRAMES} frames: {} births, {} deaths, {} saddles",
            count(EventKind::Birth),
            count(EventKind::Death),
            count(EventKind::Saddle)
        );
        sheet.add(canvas.done(), text);
    }
    Ok(())
}

fn places(scene: &str, shot: &Shot, run: &Run) -> Result<Places> {
    let project = Project::open(&format!("demo:{scene}"), Options::default(), run)?;
    let poser = project.poser();
    let Some(ground) = &shot.film.surface else { return Ok(Vec::new()) };
    let of_frame = |(i, frame): (usize, &chiaro_lines::FilmFrame)| {
        let posed = project.pose(&poser, i as u32 + 1, run);
        let positions = chiaro_lines::positions(&ground.surface, &posed);
        let at = |c: &chiaro_lines::Crossing| {
            let [a, b] = ground.surface.ends(c.edge).map(|v| positions[v as usize]);
            frame.view.see(a.lerp(b, c.at)).map(|s| place(s.at, i as f64))
        };
        frame.slice.crossings.iter().map(at).collect()
    };
    Ok(shot.film.frames.iter().enumerate().map(of_frame).collect())
}

/// The bands of the interval after a frame.
fn bands(shot: &Shot, places: &Places, i: usize, model: &mut Model) {
    let frame = &shot.film.frames[i];
    let later = Later { slice: &shot.film.frames[i + 1].slice, places: &places[i + 1] };
    let saddles = saddles(&shot.film.events, i);
    let forward = &frame.interval.forward;
    let mut covered = vec![false; later.places.len()];
    for (chain, label) in frame.slice.chains.iter().zip(&frame.labels) {
        let colour = shade(*label, i);
        for (a, b) in pairs(chain) {
            let next = [a, b].map(|k| forward.get(k).copied().unwrap_or(u32::MAX));
            let becomes = next.map(|j| later.places.get(j as usize).copied().flatten());
            let (Some(p), Some(q)) = (places[i][a], places[i][b]) else { continue };
            match becomes {
                [Some(r), Some(s)] => match later.between(next) {
                    Some(between) => {
                        let way: Vec<DVec3> =
                            between.iter().filter_map(|j| later.places[*j]).collect();
                        way.windows(2).for_each(|w| model.add([p, w[0], w[1]], colour));
                        model.add([p, s, q], colour);
                        let steps = between.len() - 1;
                        between[..steps].iter().for_each(|j| covered[*j] = true);
                    }
                    None => {
                        let tip = nearest(&saddles, p.midpoint(q), *label).unwrap_or(r.midpoint(s));
                        for corners in [[p, q, tip], [p, r, tip], [q, s, tip]] {
                            model.add(corners, colour);
                        }
                    }
                },
                [Some(r), None] | [None, Some(r)] => model.add([p, r, q], colour),
                [None, None] => {}
            }
        }
    }
    close(&later, &shot.film.frames[i + 1].labels, (&covered, &saddles), i, model);
}

/// Closes S between a saddle and the chains that leave it.
fn close(
    later: &Later<'_>,
    labels: &[u32],
    (covered, saddles): (&[bool], &[(DVec3, &[u32])]),
    i: usize,
    model: &mut Model,
) {
    for (chain, label) in later.slice.chains.iter().zip(labels) {
        for (a, b) in pairs(chain).filter(|(a, _)| !covered[*a]) {
            let (Some(r), Some(s)) = (later.places[a], later.places[b]) else { continue };
            if let Some(tip) = nearest(saddles, r.midpoint(s), *label) {
                model.add([r, s, tip], shade(*label, i));
            }
        }
    }
}

/// The colour of a chain in an interval.
fn shade(label: u32, i: usize) -> [f32; 3] {
    let shade = if i.is_multiple_of(4) { 0.8 } else { 1.0 };
    picture::id_colour(label).map(|c| c * shade)
}

/// Neighbours on a chain.
fn pairs(chain: &Chain) -> impl Iterator<Item = (usize, usize)> {
    let Chain { start, count, closed } = *chain;
    let ends = move |k: u32| ((start + k) as usize, (start + (k + 1) % count) as usize);
    (0..count - u32::from(!closed)).map(ends)
}

/// The saddles of an interval: where in the model, and the chains that take part.
fn saddles(events: &[FilmEvent], i: usize) -> Vec<(DVec3, &[u32])> {
    let here = |e: &&FilmEvent| e.kind == EventKind::Saddle && e.time.floor() as usize == i;
    let tips = events.iter().filter(here).flat_map(|e| {
        let at = e.at.map(|p| place(p, e.time));
        e.labels.iter().filter_map(move |l| Some((at?, l.as_slice())))
    });
    tips.collect()
}

/// The saddle nearest to a place on a chain, if one is near.
fn nearest(saddles: &[(DVec3, &[u32])], at: DVec3, label: u32) -> Option<DVec3> {
    let away = |p: &DVec3| p.truncate().distance(at.truncate());
    let own = saddles.iter().filter(|s| s.1.contains(&label)).map(|s| s.0);
    own.filter(|p| away(p) < FAR).min_by(|a, b| away(a).total_cmp(&away(b)))
}

/// The slice at the end of an interval.
struct Later<'a> {
    slice: &'a Slice,
    places: &'a [Option<DVec3>],
}

impl Later<'_> {
    /// The crossings from one to another along their chain, if they are near each other on one.
    fn between(&self, [from, to]: [u32; 2]) -> Option<Vec<usize>> {
        let index = self.slice.chains.partition_point(|c| c.start <= from).checked_sub(1)?;
        let chain = self.slice.chains[index];
        if to < chain.start || to >= chain.start + chain.count {
            return None;
        }
        let [a, b] = [from, to].map(|j| j - chain.start);
        let steps = match (a <= b, chain.closed) {
            (true, _) => b - a,
            (false, true) => b + chain.count - a,
            (false, false) => return None,
        };
        let at = |k: u32| (chain.start + (a + k) % chain.count) as usize;
        (steps <= APART).then(|| (0..=steps).map(at).collect())
    }
}

/// Closes S where a chain begins or ends.
fn fan(event: &FilmEvent, shot: &Shot, places: &Places, model: &mut Model) {
    let Some(tip) = event.at.map(|p| place(p, event.time)) else { return };
    let born = event.kind == EventKind::Birth;
    let index = event.time.floor() as usize + usize::from(born);
    let Some(frame) = shot.film.frames.get(index) else { return };
    for (chain, label) in frame.slice.chains.iter().zip(&frame.labels) {
        if !event.labels[usize::from(born)].contains(label) {
            continue;
        }
        for k in 0..chain.count - u32::from(!chain.closed) {
            let [a, b] = [k, (k + 1) % chain.count].map(|k| (chain.start + k) as usize);
            if let (Some(p), Some(q)) = (places[index][a], places[index][b]) {
                model.add([p, q, tip], picture::id_colour(*label));
            }
        }
    }
}

/// Triangles as they hide each other.
struct Model {
    colour: Plane<[f32; 3]>,
    /// The time of what is nearest.
    time: Plane<f64>,
}

impl Model {
    fn new() -> Self {
        let (w, h) = (FINE * CANVAS.0, FINE * CANVAS.1);
        Self { colour: Plane::filled(w, h, [1.0; 3]), time: Plane::filled(w, h, f64::INFINITY) }
    }

    fn add(&mut self, corners: [DVec3; 3], colour: [f32; 3]) {
        // Time measures as much as it is drawn long.
        let solid = corners.map(|p| p.with_z(p.z * 400.0 / f64::from(FRAMES)));
        let normal = (solid[1] - solid[0]).cross(solid[2] - solid[0]).normalize_or_zero();
        let light = 0.25 + 0.75 * normal.dot(LIGHT).abs() as f32;
        let lit = colour.map(|c| (0.15 + 0.85 * c).mul_add(light, 0.1 * light).min(1.0));
        let [a, b, c] = corners.map(|p| p.truncate() * FINE as f64 - 0.5);
        let area = (b - a).perp_dot(c - a);
        let (low, high) = (a.min(b).min(c).ceil(), a.max(b).max(c).floor());
        if area == 0.0 || high.x < 0.0 || high.y < 0.0 {
            return;
        }
        let (width, height) = self.colour.size();
        for y in low.y.max(0.0) as usize..(high.y as usize + 1).min(height) {
            for x in low.x.max(0.0) as usize..(high.x as usize + 1).min(width) {
                let p = DVec2::new(x as f64, y as f64);
                let weights = [(b - p).perp_dot(c - p), (c - p).perp_dot(a - p)].map(|w| w / area);
                let weights = [weights[0], weights[1], 1.0 - weights[0] - weights[1]];
                let time = (0..3).map(|i| weights[i] * corners[i].z).sum::<f64>();
                let k = y * width + x;
                if weights.iter().all(|w| *w >= 0.0) && time < self.time.pixels()[k] {
                    self.time.pixels_mut()[k] = time;
                    self.colour.pixels_mut()[k] = lit;
                }
            }
        }
    }

    /// Whether a place is not behind the surface.
    fn shows(&self, p: DVec3) -> bool {
        let fine = p.truncate() * FINE as f64;
        self.time.at(fine.x as isize, fine.y as isize).is_some_and(|t| p.z <= t + BEHIND)
    }

    fn picture(&self) -> Plane<[f32; 3]> {
        let mean = |x: usize, y: usize| {
            let fine = (0..FINE * FINE).map(|k| (FINE * x + k % FINE, FINE * y + k / FINE));
            let sum = fine.filter_map(|(x, y)| self.colour.at(x as isize, y as isize));
            let sum = sum.fold([0.0; 3], |s: [f32; 3], c| std::array::from_fn(|i| s[i] + c[i]));
            sum.map(|s| s / (FINE * FINE) as f32)
        };
        Plane::from_fn(CANVAS.0, CANVAS.1, mean)
    }
}
