//! [`Film`]: the lines of a shot, tracked: the three loops of the method.
//!
//! 1. *Per frame, in parallel*: pose, silhouettes, edge lines, visibility, strokes ([`Lines`]).
//! 2. *Once over the film*: the flips between frames make S and its events ([`Kinetic`]); links along
//!    S make identities ([`Identity`]).
//! 3. *Per frame*: strokes get their ids, events their strokes.
//!
//! Frames are worked on in chunks; poses and values of a chunk are forgotten once it is tracked, so
//! that memory holds S and the strokes alone. Results do not depend on chunks or threads.

use crate::extract::{Lines, Moment, Stage};
use crate::family::families;
use crate::feature::Features;
use crate::further::{Follower, Further};
use crate::gap::Gap;
use crate::knob::LinesKnobs;
use crate::mask::Masks;
use crate::path::{Kind, Path};
use crate::posed::Posed;
use crate::slice::Slice;
use crate::strands::{in_parts, strands};
use crate::stroke::Stroke;
use crate::surface::{CreaseRule, Detail, Surface};
use crate::track::{EventKind, Identity, Interval, Kinetic, Order, Strands};
use crate::view::View;
use chiaro_basis::math::{DVec2, DVec3};
use chiaro_basis::{Result, Run};
use chiaro_scene::{Frame, Scene};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A shot: a scene, and its frame and camera at each of a number of times.
pub struct Reel<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// How many frames.
    pub count: usize,
    /// The frame of an index, and the camera's view of it.
    pub at: &'a (dyn Fn(usize) -> (Frame, View) + Sync),
}

/// A shot's lines, tracked.
#[derive(Clone, Debug, Default)]
pub struct Film {
    /// The frames.
    pub frames: Vec<FilmFrame>,
    /// Births, deaths and saddles of silhouettes, in their order.
    pub events: Vec<FilmEvent>,
    /// For each label of a chain the least label of its family: chains that one stroke runs along in
    /// some frame are a family, and their strokes may share an id.
    pub families: Vec<u32>,
    /// The surface, unless meshes are made anew in every frame.
    pub surface: Option<Arc<Ground>>,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// One frame of a film.
#[derive(Clone, Debug)]
pub struct FilmFrame {
    /// The camera.
    pub view: View,
    /// The slice of S: all silhouettes, hidden ones too.
    pub slice: Slice,
    /// The label of each chain of the slice, the same through the film.
    pub labels: Vec<u32>,
    /// What happens until the next frame; empty at the last one and before a cut.
    pub interval: Interval,
    /// Whether the frame begins a new block of space-time: the first one, and after a camera cut.
    pub begins: bool,
    /// Zero sets of further line types, hidden parts too.
    pub further: Vec<Further>,
    /// What is seen.
    pub strokes: Vec<Stroke>,
    /// What is hidden, where that is drawn; ids go on after those of what is seen.
    pub hidden: Vec<Stroke>,
    /// What lies between strokes of one line.
    pub gaps: Vec<Gap>,
    /// Stretches that voted on visibility, and those that did not agree.
    pub stretches: [u64; 2],
}

/// A birth, death or saddle in a film.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmEvent {
    /// Index of the frame before, and the share of the way to the next.
    pub time: f64,
    /// What.
    pub kind: EventKind,
    /// Arcs that meet, for saddles.
    pub arcs: u32,
    /// Where, in world space.
    pub world: DVec3,
    /// Where in the picture, if it is in front of the camera.
    pub at: Option<DVec2>,
    /// Ids of the strokes that take part: those of the chains involved that pass near.
    pub strokes: Vec<u32>,
    /// Labels of the chains before and after.
    pub labels: [Vec<u32>; 2],
}

/// A surface with its edge lines.
#[derive(Clone, Debug, Default)]
pub struct Ground {
    /// The surface.
    pub surface: Surface,
    /// Its edge lines.
    pub features: Features,
    /// Its faces with holes.
    pub masks: Masks,
}

impl Ground {
    /// The surface of a frame, with its edge lines; each shape followed as closely as `details` says.
    pub fn of(scene: &Scene, frame: &Frame, knobs: &LinesKnobs, details: &[Detail]) -> Self {
        let rule = CreaseRule {
            angle: knobs.crease_angle.to_radians(),
            smooth_angle: knobs.smooth_crease_angle.max(knobs.crease_angle).to_radians(),
        };
        let surface = Surface::refined(scene, frame, &rule, details);
        let features = Features::of(&surface, &crate::posed::positions(&surface, frame));
        let masks = Masks::of(scene, frame, &surface);
        Self { surface, features, masks }
    }
}

/// A frame, posed.
struct Ready {
    view: View,
    posed: Posed,
    /// Where meshes are made anew: this frame's own.
    own: Option<Arc<Ground>>,
}

/// Pixels within which an event finds its strokes.
const NEAR_EVENT: f64 = 40.0;
/// Visible length that an id must reach in some frame, in parts of what is pruned.
const BRIEF: f64 = 0.5;
/// Length of a chain of edges that bends no more than is usual, in parts of its extent.
const STRAIGHT: f64 = 1.3;
/// A camera that turns by more than this between frames may have been cut, radians.
const CUT: f64 = 0.5;
/// It has if it turned this many times less before.
const SUDDEN: f64 = 4.0;

impl Film {
    /// Finds and tracks the lines of a shot.
    pub fn of(reel: &Reel<'_>, knobs: &LinesKnobs, run: &Run) -> Result<Self> {
        Self::on(reel, reel.ground(knobs, 0, run), knobs, run)
    }

    /// The same on a surface that is there already.
    pub(crate) fn on(
        reel: &Reel<'_>,
        fixed: Option<Arc<Ground>>,
        knobs: &LinesKnobs,
        run: &Run,
    ) -> Result<Self> {
        let mut tracking = Tracking::new(knobs, fixed.as_deref());
        let chunk = 2 * rayon::current_num_threads().max(1);
        let mut ready: Vec<Ready> = Vec::new();
        let mut done = 0;
        while done < reel.count {
            run.check()?;
            let until = (done + chunk).min(reel.count);
            let wanted = done + ready.len()..(until + 1).min(reel.count);
            let posed: Vec<Ready> = run.stage("frame", wanted.len() as u64, || {
                wanted.into_par_iter().map(|i| reel.prepare(i, fixed.as_deref(), knobs)).collect()
            });
            ready.extend(posed);
            let lines: Vec<Lines> = run.stage("lines", (until - done) as u64, || {
                (0..until - done).into_par_iter().map(|k| tracking.find(&ready, k)).collect()
            });
            run.stage("track", (until - done) as u64, || {
                for (k, lines) in lines.into_iter().enumerate() {
                    tracking.take(&ready[k], lines);
                }
            });
            ready.drain(..until - done);
            done = until;
        }
        let mut film = run.stage("track", 0, || tracking.finish());
        film.notes = fixed.as_ref().map_or_else(Vec::new, |g| g.surface.notes.clone());
        film.surface = fixed;
        Ok(film)
    }
}

impl Film {
    /// Finds the strokes of events again, after ids changed.
    pub(crate) fn settle_events(&mut self) {
        for event in &mut self.events {
            event.strokes = taking_part(event, &self.frames);
        }
    }
}

impl Reel<'_> {
    /// The surface of the shot, refined as the knobs ask and `more` times more; `None` where some
    /// mesh is made anew in every frame.
    pub(crate) fn ground(&self, knobs: &LinesKnobs, more: u8, run: &Run) -> Option<Arc<Ground>> {
        if self.count == 0 {
            return None;
        }
        run.stage("lines", 0, || {
            let (frame, _) = (self.at)(0);
            if frame.shapes.iter().any(|s| s.remade.is_some()) {
                return None;
            }
            let ground = Ground::of(self.scene, &frame, knobs, &[]);
            let mut details = crate::refine::details(self, &ground, knobs);
            crate::refine::finer(&mut details, &frame, &ground, more);
            let as_it_is = details.iter().all(|d| *d == Detail::default());
            let mut ground =
                if as_it_is { ground } else { Ground::of(self.scene, &frame, knobs, &details) };
            if knobs.border {
                ground.features.fringes = crate::fringe::fringes(self, &ground);
            }
            Some(Arc::new(ground))
        })
    }

    fn prepare(&self, index: usize, fixed: Option<&Ground>, knobs: &LinesKnobs) -> Ready {
        let (frame, view) = (self.at)(index);
        let own = fixed.is_none().then(|| Arc::new(Ground::of(self.scene, &frame, knobs, &[])));
        let ground = fixed.or(own.as_deref()).expect("one of them is there");
        let posed = Posed::new(&ground.surface, &frame, knobs.smooth_normals);
        Ready { view, posed, own }
    }
}

/// A film in the making.
struct Tracking<'a> {
    knobs: &'a LinesKnobs,
    fixed: Option<&'a Ground>,
    film: Film,
    identity: Identity,
    last: Option<Last>,
    kinetic: Option<Kinetic<'a>>,
    follower: Follower<'a>,
    next_label: u32,
    turned: f64,
    /// The greatest picture length of each line: silhouettes by label, edges by chain; endless for what goes round a
    /// small object.
    lengths: BTreeMap<(Kind, u32), f64>,
}

/// What tracking needs of the frame before.
struct Last {
    g: Vec<f64>,
    positions: Vec<DVec3>,
    view: View,
}

impl<'a> Tracking<'a> {
    fn new(knobs: &'a LinesKnobs, fixed: Option<&'a Ground>) -> Self {
        Self {
            knobs,
            fixed,
            film: Film::default(),
            identity: Identity::default(),
            last: None,
            kinetic: None,
            follower: Follower::default(),
            next_label: 0,
            turned: 0.0,
            lengths: BTreeMap::new(),
        }
    }

    /// The lines of the `k`-th frame that is ready.
    fn find(&self, ready: &[Ready], k: usize) -> Lines {
        let here = &ready[k];
        let ground = self.fixed.or(here.own.as_deref()).expect("a frame has a surface");
        let next = ready.get(k + 1).filter(|_| self.fixed.is_some());
        let moment = Moment {
            posed: &here.posed,
            view: &here.view,
            next: next.map(|n| (n.posed.positions.as_slice(), &n.view)),
        };
        let stage = Stage {
            surface: &ground.surface,
            features: &ground.features,
            masks: &ground.masks,
            knobs: self.knobs,
        };
        Lines::find(&stage, &moment)
    }

    /// Takes the next frame's lines.
    fn take(&mut self, ready: &Ready, mut lines: Lines) {
        let begins = self.is_cut(&ready.view);
        let (labels, interval) = match self.fixed {
            Some(ground) => self.track(ground, &lines, begins),
            None => (self.fresh_labels(lines.slice.chains.len()), None),
        };
        let further = self.follow(ready, &mut lines, begins);
        self.identify(ready, &lines, begins, (interval.as_ref(), &further));
        if let Some(before) = self.film.frames.last_mut() {
            let pairs = before.further.iter_mut().zip(further);
            pairs.for_each(|(set, forward)| set.forward = forward.unwrap_or_default());
        }
        if let Some(interval) = interval {
            self.locate(&interval, &ready.posed.positions, &ready.view);
            self.film.frames.last_mut().expect("an interval ends a frame").interval = interval;
        }
        for (path, whole) in lines.paths.iter().zip(&lines.whole) {
            if let Some(line) = lasting(path.kind, path.chain, &labels) {
                let longest = self.lengths.entry((path.kind, line)).or_insert(0.0);
                *longest = longest.max(if *whole { f64::INFINITY } else { spread(path) });
            }
        }
        let stretches = [lines.visible.stretches, lines.visible.split];
        self.film.frames.push(FilmFrame {
            view: ready.view,
            slice: lines.slice,
            labels,
            interval: Interval::default(),
            begins,
            further: lines.further,
            strokes: lines.strokes,
            hidden: lines.hidden,
            gaps: lines.gaps,
            stretches,
        });
        self.last =
            Some(Last { g: lines.g, positions: ready.posed.positions.clone(), view: ready.view });
    }

    fn fresh_labels(&mut self, count: usize) -> Vec<u32> {
        let first = self.next_label;
        self.next_label += count as u32;
        (first..self.next_label).collect()
    }

    /// Whether the camera jumped: much, and much more than before.
    fn is_cut(&mut self, view: &View) -> bool {
        let Some(last) = &self.last else { return true };
        let turn = f64::from(last.view.pose.forward.angle_between(view.pose.forward));
        let before = std::mem::replace(&mut self.turned, turn);
        self.film.frames.len() > 1 && turn > CUT && turn > SUDDEN * before
    }

    /// Moves the kinetic structure on; labels of the chains, and what happened since the frame
    /// before.
    fn track(
        &mut self,
        ground: &'a Ground,
        lines: &Lines,
        begins: bool,
    ) -> (Vec<u32>, Option<Interval>) {
        let mut interval = None;
        match (&mut self.kinetic, &self.last, self.film.frames.last()) {
            (Some(kinetic), Some(last), Some(before)) if !begins => {
                let slices = [&before.slice, &lines.slice];
                interval = Some(kinetic.step(&last.g, &lines.g, slices, Order::Time));
            }
            _ => {
                self.kinetic =
                    Some(Kinetic::new(&ground.surface, &lines.g, &lines.slice, self.next_label));
            }
        }
        let kinetic = self.kinetic.as_ref().expect("it was made just now");
        self.next_label = kinetic.next_label();
        let label = |c: &crate::slice::Chain| kinetic.label(c.of(&lines.slice)[0].edge);
        (lines.slice.chains.iter().map(label).collect(), interval)
    }

    /// Follows the further zero sets; what the crossings of the frame before become.
    fn follow(&mut self, ready: &Ready, lines: &mut Lines, begins: bool) -> Vec<Option<Vec<u32>>> {
        let Some(ground) = self.fixed else { return vec![None; lines.further.len()] };
        let before = self.film.frames.last().filter(|_| !begins).map(|f| f.further.as_slice());
        let place = (ready.posed.positions.as_slice(), &ready.view);
        self.follower.advance(&ground.surface, before, &mut lines.further, place)
    }

    fn identify(
        &mut self,
        ready: &Ready,
        lines: &Lines,
        begins: bool,
        (interval, further): (Option<&Interval>, &[Option<Vec<u32>>]),
    ) {
        let strands = strands(lines, self.fixed.map(|g| &g.features));
        let mut forward: Vec<Option<Vec<u32>>> = vec![interval.map(|i| in_parts(&i.forward))];
        // Edges stay where they are.
        forward.push((!begins).then(|| (0..strands[1].stroke.len() as u32).collect()));
        forward.extend(further.iter().map(|f| f.as_deref().map(in_parts)));
        let families: Vec<(&Strands, Option<&[u32]>)> =
            strands.iter().zip(&forward).map(|(s, f)| (s, f.as_deref())).collect();
        self.identity.advance(lines.strokes.len(), &families);
        if let (Some(before), false) = (self.film.frames.last(), begins) {
            let number = self.film.frames.len();
            let counts = |kind: Kind| self.fixed.is_none() || kind.is_voted();
            let strokes = [&before.strokes, &lines.strokes];
            for (a, b, weight) in crate::vote::votes(strokes, counts, &ready.view) {
                let nodes = [(number - 1, a), (number, b)].map(|(f, s)| self.identity.node(f, s));
                self.identity.link(nodes[0], nodes[1], weight);
            }
        }
    }

    /// Writes down the interval's events, which ended at a pose.
    fn locate(&mut self, interval: &Interval, positions: &[DVec3], view: &View) {
        let Some(last) = &self.last else { return };
        let frame = (self.film.frames.len() - 1) as f64;
        for event in &interval.events {
            let v = event.vertex as usize;
            let world = last.positions[v].lerp(positions[v], event.time);
            let seen = [&last.view, view].map(|view| view.see(world));
            let at = match seen {
                [Some(a), Some(b)] => Some(a.at.lerp(b.at, event.time)),
                [a, b] => a.or(b).map(|s| s.at),
            };
            self.film.events.push(FilmEvent {
                time: frame + event.time,
                kind: event.kind,
                arcs: event.arcs,
                world,
                at,
                strokes: Vec::new(),
                labels: [event.before.clone(), event.after.clone()],
            });
        }
    }

    fn finish(self) -> Film {
        let mut film = self.film;
        film.families = families(&film.frames, self.next_label);
        let lines = |f: &FilmFrame| f.strokes.iter().map(|s| film.line_of(f, s)).collect();
        let lines: Vec<Vec<u32>> = film.frames.iter().map(lines).collect();
        let ids = self.identity.ids(&lines.concat());
        for (frame, ids) in film.frames.iter_mut().zip(ids) {
            frame.strokes.iter_mut().zip(ids).for_each(|(s, id)| s.id = id);
        }
        name_hidden(&mut film);
        prune(&mut film, &self.lengths, f64::from(self.knobs.prune));
        drop_brief(&mut film, &self.lengths, BRIEF * f64::from(self.knobs.prune));
        for event in &mut film.events {
            event.strokes = taking_part(event, &film.frames);
        }
        film
    }
}

/// Gives hidden strokes one id a line, after those of visible strokes.
fn name_hidden(film: &mut Film) {
    let visible = film.frames.iter().flat_map(|f| &f.strokes).map(|s| s.id + 1).max();
    let mut ids = BTreeMap::new();
    for frame in &mut film.frames {
        for stroke in &mut frame.hidden {
            let line = match stroke.kind {
                Kind::Silhouette => frame.labels[stroke.chain as usize],
                _ => stroke.chain,
            };
            let next = visible.unwrap_or(0) + ids.len() as u32;
            stroke.id = *ids.entry((stroke.kind, line)).or_insert(next);
        }
    }
}

/// What stays the same of a line through the film, if it is followed: the label of a silhouette's
/// chain, the index of a chain of edges.
fn lasting(kind: Kind, chain: u32, labels: &[u32]) -> Option<u32> {
    match kind {
        Kind::Silhouette => Some(labels[chain as usize]),
        kind if kind.is_edge() => Some(chain),
        _ => None,
    }
}

/// How long a line is that is not to be pruned: an open chain of edges that goes to and fro, as rifts of
/// scans do, is no longer than the part of the picture that it takes.
fn spread(path: &Path) -> f64 {
    match path.kind.is_edge() && !path.closed {
        true => path.total().min(STRAIGHT * path.extent()),
        false => path.total(),
    }
}

/// Drops closed silhouettes and chains of edges that never grow longer than `longest` pixels: what
/// noise makes. It is decided once over the life of a line, so that nothing flickers.
fn prune(film: &mut Film, lengths: &BTreeMap<(Kind, u32), f64>, longest: f64) {
    for frame in &mut film.frames {
        let (labels, chains) = (&frame.labels, &frame.slice.chains);
        let stays = |s: &Stroke| {
            let open = s.kind == Kind::Silhouette && !chains[s.chain as usize].closed;
            let line = lasting(s.kind, s.chain, labels).filter(|_| !open);
            line.and_then(|l| lengths.get(&(s.kind, l))).is_none_or(|l| *l >= longest)
        };
        frame.strokes.retain(stays);
        frame.hidden.retain(stays);
    }
}

/// Drops the ids of which no frame shows as much as `least` pixels: specks at the ends of lines. What is left to
/// be seen of one long edge is none, nor is what goes round a small object.
fn drop_brief(film: &mut Film, lengths: &BTreeMap<(Kind, u32), f64>, least: f64) {
    let mut most: BTreeMap<u32, f64> = BTreeMap::new();
    for frame in &film.frames {
        let mut here: BTreeMap<u32, f64> = BTreeMap::new();
        for s in &frame.strokes {
            let [first, last] = [s.samples[0], s.samples[s.samples.len() - 1]].map(|p| p.on_chain);
            let is_bit = !s.closed && first.floor() == (last - 1e-9).floor();
            let line = lasting(s.kind, s.chain, &frame.labels);
            let is_whole = line.is_some_and(|l| lengths.get(&(s.kind, l)) == Some(&f64::INFINITY));
            *here.entry(s.id).or_insert(0.0) += if is_bit || is_whole { least } else { s.total() };
        }
        for (id, length) in here {
            let longest = most.entry(id).or_insert(0.0);
            *longest = longest.max(length);
        }
    }
    for frame in &mut film.frames {
        frame.strokes.retain(|s| most[&s.id] >= least);
    }
}

/// Ids of the strokes near an event on the chains that take part in it.
fn taking_part(event: &FilmEvent, frames: &[FilmFrame]) -> Vec<u32> {
    let Some(at) = event.at else { return Vec::new() };
    let first = event.time.floor() as usize;
    let mut ids = Vec::new();
    for (frame, labels) in frames[first..].iter().zip(&event.labels) {
        let is_near = |s: &&Stroke| {
            s.kind == Kind::Silhouette
                && labels.contains(&frame.labels[s.chain as usize])
                && s.samples.iter().any(|p| p.at.distance(at) < NEAR_EVENT)
        };
        ids.extend(frame.strokes.iter().filter(is_near).map(|s| s.id));
    }
    ids.sort_unstable();
    ids.dedup();
    ids
}
