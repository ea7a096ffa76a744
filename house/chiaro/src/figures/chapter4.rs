//! Figures 4.1, 4.2 and 4.5, and the lines of every scene.

use super::Figure;
use crate::lines::{Shot, camera, picture};
use crate::project::{Options, Project};
use chiaro_basis::math::DVec2;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_image::sheet::Sheet;
use chiaro_ink::{Polyline, draw};
use chiaro_lines::track::EventKind;
use chiaro_lines::{FilmEvent, FilmFrame, Kind, LinesKnobs, View};
use chiaro_scene::{Pose, demo};

const SIZE: (usize, usize) = (560, 420);
/// Frames between an event and the frames that show it.
const BESIDE: usize = 2;
/// How much closer events are shown, and what is near them, pixels.
const CLOSER: f64 = 4.0;
const AROUND: f64 = 40.0;
pub(super) const OBJECT: &str = "bumpy-torus";

pub(super) const FIGURES: [Figure; 4] = [
    Figure {
        name: "4.1",
        title: "the contour, and the same contour from elsewhere",
        message: "On a closed surface silhouettes are closed loops: what one view hides, another shows.",
        columns: 2,
        draw: contour,
    },
    Figure {
        name: "4.2",
        title: "material points",
        message: "A turning ring: each sample of a line, and where its material point goes in four frames.",
        columns: 2,
        draw: material_points,
    },
    Figure {
        name: "4.5",
        title: "events",
        message: "Three frames before and after a birth, a death and a saddle, from near; hidden lines in grey.",
        columns: 2,
        draw: events,
    },
    Figure {
        name: "4.lines",
        title: "the lines of every scene",
        message: "Silhouettes, creases, borders and material borders above, with suggestive contours below.",
        columns: 4,
        draw: every_scene,
    },
];

pub(super) type Colour = [f32; 3];
pub(super) const BLACK: Colour = [0.0; 3];
pub(super) const GREY: Colour = [0.62; 3];
pub(super) const RED: Colour = [0.82, 0.16, 0.1];

/// A picture under construction.
pub(super) struct Canvas(Plane<[f32; 3]>);

impl Canvas {
    pub(super) fn new(size: (usize, usize)) -> Self {
        Self(Plane::filled(size.0, size.1, [1.0; 3]))
    }

    /// On a picture.
    pub(super) fn on(picture: Plane<[f32; 3]>) -> Self {
        Self(picture)
    }

    pub(super) fn lines(&mut self, lines: &[Polyline], width: f32, colour: Colour) {
        let cover = draw(lines, self.0.size(), width);
        let over = |p: &[f32; 3], c: &f32| std::array::from_fn(|i| p[i] + (colour[i] - p[i]) * c);
        self.0 = self.0.zip(&cover, over).expect("both have the canvas's size");
    }

    pub(super) fn done(self) -> Plane<[u8; 3]> {
        self.0.map(|p| p.map(chiaro_image::colour::to_byte))
    }
}

pub(super) fn shot(
    scene: &str,
    frames: u32,
    size: (usize, usize),
    knobs: &LinesKnobs,
    run: &Run,
) -> Result<Shot> {
    let options =
        Options { size: Some(size), frames: Some((1..=frames).collect()), ..Options::default() };
    let project = Project::open(&format!("demo:{scene}"), options, run)?;
    let camera = camera(&project, run)?;
    Shot::track(&project, camera, knobs, run)
}

/// Silhouettes in full, hidden parts too, as a view sees them.
fn whole(
    shot: &Shot,
    frame: &FilmFrame,
    positions: &[chiaro_basis::math::DVec3],
    view: &View,
) -> Vec<Polyline> {
    let Some(ground) = &shot.film.surface else { return Vec::new() };
    let chains = frame.slice.chains.iter().map(|chain| {
        let place = |c: &chiaro_lines::Crossing| {
            let [a, b] = ground.surface.ends(c.edge).map(|v| positions[v as usize]);
            view.see(a.lerp(b, c.at)).map(|s| s.at.as_vec2().to_array())
        };
        let points: Vec<[f32; 2]> = chain.of(&frame.slice).iter().filter_map(place).collect();
        Polyline { points, closed: chain.closed }
    });
    chains.filter(|l| l.points.len() > 1).collect()
}

fn contour(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for scene in [OBJECT, "peanut"] {
        let knobs = LinesKnobs::default();
        let shot = shot(scene, 1, SIZE, &knobs, run)?;
        let frame = &shot.film.frames[0];
        let mut seen = Canvas::new(SIZE);
        let strokes: Vec<Polyline> = frame.strokes.iter().map(picture::polyline).collect();
        seen.lines(&strokes, 2.0, BLACK);
        sheet.add(seen.done(), format!("{scene}: what is seen"));
        let project = Project::open(&format!("demo:{scene}"), Options::default(), run)?;
        let posed = project.pose(&project.poser(), 1, run);
        let Some(ground) = &shot.film.surface else { continue };
        let positions = chiaro_lines::positions(&ground.surface, &posed);
        let elsewhere = turned(&frame.view, 75.0);
        let mut canvas = Canvas::new(SIZE);
        canvas.lines(&whole(&shot, frame, &positions, &elsewhere), 1.5, GREY);
        let visible = frame.strokes.iter().filter(|s| s.kind == Kind::Silhouette).map(|s| {
            let at = |p: &chiaro_lines::Sample| {
                elsewhere.see(p.world).map(|s| s.at.as_vec2().to_array())
            };
            Polyline { points: s.samples.iter().filter_map(at).collect(), closed: s.closed }
        });
        canvas.lines(&visible.collect::<Vec<_>>(), 2.2, BLACK);
        sheet.add(canvas.done(), "the same lines, whole, from the side; black: seen before");
    }
    Ok(())
}

/// A view turned about the vertical through what it looks at.
fn turned(view: &View, degrees: f32) -> View {
    let pose = view.pose;
    // The demo solids stand at the origin.
    let q = chiaro_basis::math::Quat::from_rotation_y(degrees.to_radians());
    let pose = Pose {
        position: q * pose.position,
        right: q * pose.right,
        up: q * pose.up,
        forward: q * pose.forward,
        ..pose
    };
    View::new(pose, view.size)
}

fn material_points(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let shot = shot(OBJECT, 8, SIZE, &LinesKnobs::default(), run)?;
    for start in [0, 4] {
        let mut canvas = Canvas::new(SIZE);
        let lines = |i: usize| -> Vec<Polyline> {
            shot.film.frames[i].strokes.iter().map(picture::polyline).collect()
        };
        canvas.lines(&lines(start + 3), 1.5, GREY);
        let samples =
            shot.film.frames[start].strokes.iter().flat_map(|s| s.samples.iter().step_by(5));
        let link = |s: &chiaro_lines::Sample| {
            let to = s.at + (s.next_at? - s.at) * 3.0;
            let points = vec![s.at.as_vec2().to_array(), to.as_vec2().to_array()];
            Some(Polyline { points, closed: false })
        };
        canvas.lines(&samples.filter_map(link).collect::<Vec<_>>(), 1.0, RED);
        canvas.lines(&lines(start), 2.0, BLACK);
        sheet.add(canvas.done(), format!("frame {} in black, {} in grey", start + 1, start + 4));
    }
    Ok(())
}

/// A mark in the picture: its strokes, all small.
pub(super) fn mark(kind: EventKind, at: DVec2, radius: f64) -> Vec<Polyline> {
    let ring = |r: f64| Polyline {
        points: (0..16)
            .map(|i| {
                let a = std::f64::consts::TAU * f64::from(i) / 16.0;
                (at + DVec2::new(a.cos(), a.sin()) * r).as_vec2().to_array()
            })
            .collect(),
        closed: true,
    };
    let bar = |d: DVec2| Polyline {
        points: vec![(at - d).as_vec2().to_array(), (at + d).as_vec2().to_array()],
        closed: false,
    };
    match kind {
        EventKind::Birth => vec![ring(radius)],
        EventKind::Death => (1..=4).map(|i| ring(radius * 0.2 * f64::from(i))).collect(),
        EventKind::Saddle => {
            vec![bar(DVec2::splat(radius)), bar(DVec2::new(radius, -radius))]
        }
    }
}

fn events(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let knobs = LinesKnobs { hidden: chiaro_lines::Hidden::Dashed, ..LinesKnobs::default() };
    let shot = shot(OBJECT, 48, SIZE, &knobs, run)?;
    for kind in [EventKind::Birth, EventKind::Death, EventKind::Saddle] {
        let of_kind = shot.film.events.iter().filter(|e| e.kind == kind);
        let told = of_kind.map(|e| (shown(&shot, e), e));
        let Some((_, event)) = told.max_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
        for after in [false, true] {
            sheet.add(event_picture(&shot, event, after), caption(event, after));
        }
    }
    Ok(())
}

/// The frame by which an event is shown.
fn side(shot: &Shot, event: &FilmEvent, after: bool) -> usize {
    let first = event.time.floor() as usize;
    let frame = if after { first + 1 + BESIDE } else { first.saturating_sub(BESIDE) };
    frame.min(shot.film.frames.len() - 1)
}

/// How much is seen near an event of the chains that take part, pixels.
fn shown(shot: &Shot, event: &FilmEvent) -> f64 {
    let Some(at) = event.at else { return 0.0 };
    let of = |after: bool| {
        let frame = &shot.film.frames[side(shot, event, after)];
        let labels = &event.labels[usize::from(after)];
        let strokes = frame.strokes.iter().filter(|s| s.kind == Kind::Silhouette);
        let samples = strokes.flat_map(|s| &s.samples).filter(|p| {
            labels.contains(&frame.labels[p.chain as usize]) && p.at.distance(at) < AROUND
        });
        samples.count() as f64
    };
    // Where both sides show lines an event is told by both.
    match event.kind {
        EventKind::Saddle => of(false).min(of(true)),
        _ => of(false).max(of(true)),
    }
}

fn caption(event: &FilmEvent, after: bool) -> String {
    let side = if after { "after" } else { "before" };
    format!("{} at frame {:.2}: {side}", event.kind.name(), event.time + 1.0)
}

fn event_picture(shot: &Shot, event: &FilmEvent, after: bool) -> Plane<[u8; 3]> {
    let frame = &shot.film.frames[side(shot, event, after)];
    let mut canvas = Canvas::new(SIZE);
    let Some(at) = event.at else { return canvas.done() };
    let middle = DVec2::new(SIZE.0 as f64, SIZE.1 as f64) * 0.5;
    let near = |stroke: &chiaro_lines::Stroke| {
        let mut line = picture::polyline(stroke);
        let place = |p: &[f32; 2]| {
            let p = DVec2::new(f64::from(p[0]), f64::from(p[1]));
            (middle + (p - at) * CLOSER).as_vec2().to_array()
        };
        line.points = line.points.iter().map(place).collect();
        line
    };
    canvas.lines(&frame.hidden.iter().map(near).collect::<Vec<_>>(), 1.2, GREY);
    // Lines that are parted in name alone are drawn in one piece.
    let seen = chiaro_lines::parameter::whole(&frame.strokes);
    canvas.lines(&seen.iter().map(|s| near(s)).collect::<Vec<_>>(), 2.0, BLACK);
    canvas.lines(&mark(EventKind::Birth, middle, 14.0), 1.5, RED);
    canvas.done()
}

fn every_scene(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let size = (360, 300);
    for suggestive in [false, true] {
        for scene in demo::names() {
            let knobs = LinesKnobs { suggestive, ..LinesKnobs::default() };
            let shot = shot(scene, 1, size, &knobs, run)?;
            let mut canvas = Canvas::new(size);
            let strokes = shot.film.frames[0].strokes.iter();
            canvas.lines(&strokes.map(picture::polyline).collect::<Vec<_>>(), 1.2, BLACK);
            let more = if suggestive { ", suggestive contours too" } else { "" };
            sheet.add(canvas.done(), format!("{scene}{more}"));
        }
    }
    Ok(())
}
