//! Lines as SVG in millimetres: one layer a line type, one path a stroke.
//!
//! Strokes are filled outlines of their width, as smooth curves; with a pen, or where the brush's
//! `outline` is off, they are paths of constant width through their middles. A path's name is the
//! stroke's type and id; parts of one line in one frame get a second number. Its data attributes
//! hold type, id, u at both ends, the period of closed strokes, and the brush's mark; where lines of
//! several ids became one, `data-parts` has each part's id and the u at which it begins.
//!
//! What a pen draws is ordered and reversed, layer by layer, for little travel; nothing is joined, since
//! each stroke has its id.
//!
//! Grain, torn edges and pictures of strokes are filled outlines too, as a path for each tone (`-tone-2`
//! and on): two for specks and streaks, four for washes and pictures. Where near lines part far ones by
//! their haloes, paths end. Rims are shapes of paper beneath the strokes. Pictures beneath are embedded,
//! unless a pen draws.

use super::beneath::Beneath;
use super::picture::frame;
use super::ready::{Drawn, ready};
use super::{Job, Shot};
use chiaro_basis::Result;
use chiaro_image::codec;
use chiaro_image::colour::to_byte;
use chiaro_ink::brush::{Halos, Rib, Ribbon, Tone, ribbons, rim, tones};
use chiaro_ink::{
    Drawing, Fit, Layer, Mark, Path, Picture, Placement, Point, Segment, Travel, fit, route,
};
use chiaro_lines::{FilmFrame, Kind};
use std::collections::BTreeMap;

/// How far curves may stray from the stroke's border, in millimetres.
const TOLERANCE: f64 = 0.02;
/// Turns that stay corners, radians.
const CORNER: f64 = 0.7;

/// A frame's strokes, over the layers of what is beneath, and the pen's way along them where all of a
/// layer is drawn by one.
pub(super) fn svg(
    (shot, number): (&Shot, u32),
    job: &Job<'_>,
    beneath: Option<Beneath>,
    recipe: String,
) -> Result<(String, Travel)> {
    let placement = job.look.print.sheet.place(shot.camera.size)?;
    let colours = &job.look.colours;
    let background = colours.background;
    let mut drawing = Drawing {
        picture: beneath.as_ref().map(|b| embedded(b, job, &placement)).transpose()?.flatten(),
        page: placement.page,
        title: format!("{}, frame {number}", job.project.file_name()),
        recipe: Some(recipe),
        background: (background[3] > 0.0 && background != [1.0; 4]).then_some(background),
        layers: match beneath {
            Some(Beneath::Layers(layers)) => layers,
            _ => Vec::new(),
        },
    };
    let drawn = ready(shot, frame(shot, number), &job.look.lines, colours);
    let frame = frame(shot, number);
    let halos = Halos::of(drawn.iter().map(|d| d.inked(&job.look.lines)));
    let mut pen = Pen { job, placement: &placement, frame, halos, parts: BTreeMap::new() };
    let mut travel = Travel::default();
    let rims: Vec<Mark> = drawn.iter().enumerate().filter_map(|(i, d)| pen.rim(i, d)).collect();
    if !rims.is_empty() {
        drawing.layers.push(Layer { name: "rims".into(), marks: rims });
    }
    for (visible, prefix) in [(false, "hidden "), (true, "")] {
        for kind in Kind::ALL {
            let of_kind =
                drawn.iter().filter(|d| d.stroke.kind == kind && d.stroke.visible == visible);
            let marks: Vec<Mark> = of_kind.flat_map(|d| pen.marks(d)).collect();
            if !marks.is_empty() {
                let (marks, way) = routed(marks);
                travel = travel + way;
                drawing.layers.push(Layer { name: format!("{prefix}{}", kind.name()), marks });
            }
        }
    }
    Ok((drawing.to_svg(), travel))
}

/// The picture beneath, where pens do not draw.
fn embedded(beneath: &Beneath, job: &Job<'_>, place: &Placement) -> Result<Option<Picture>> {
    let Beneath::Pixels(plate) = beneath else { return Ok(None) };
    if job.look.print.pen.is_some() {
        return Ok(None);
    }
    let png = codec::write_png_rgba(&plate.map(|p| p.map(to_byte)), None)?;
    let (w, h) = plate.size();
    let size = [w as f64 * place.scale, h as f64 * place.scale];
    Ok(Some(Picture { png, corner: place.at([0.0; 2]), size }))
}

struct Pen<'a> {
    job: &'a Job<'a>,
    placement: &'a Placement,
    frame: &'a FilmFrame,
    halos: Halos,
    parts: BTreeMap<(Kind, bool, u32), u32>,
}

impl Pen<'_> {
    fn marks(&mut self, drawn: &Drawn<'_>) -> Vec<Mark> {
        let pen = self.job.look.print.pen;
        let filled = pen.is_none() && drawn.brush.outline;
        let inked = drawn.inked(&self.job.look.lines);
        if let Some(tones) = filled.then(|| tones(&inked, &self.halos)).flatten() {
            return self.toned(drawn, tones);
        }
        let marks = self.halos.part(ribbons(&drawn.brush, &drawn.spine));
        let paths = |of: &dyn Fn(&Ribbon) -> Vec<Path>| -> Vec<Path> {
            marks.iter().flat_map(of).collect()
        };
        let outline = match filled {
            true => paths(&|r| self.outline(r)),
            false => paths(&|r| self.middle(r)),
        };
        if outline.is_empty() {
            return Vec::new();
        }
        let (name, data) = (self.name(drawn), data(drawn, self.frame));
        let colour = ink(drawn, 0.0, 1.0);
        vec![match filled {
            true => Mark::Shape { name, outline, colour, data },
            false => {
                let width = pen.unwrap_or_else(|| self.mean_width(&marks));
                Mark::Named { name, paths: outline, width, colour, data }
            }
        }]
    }

    /// A shape for each tone; the first has the stroke's name and what is known of it.
    fn toned(&mut self, drawn: &Drawn<'_>, tones: Vec<Tone>) -> Vec<Mark> {
        let name = if tones.is_empty() { String::new() } else { self.name(drawn) };
        let mut before = 0.0;
        let shape = |(i, tone): (usize, Tone)| {
            let page = |o: Vec<Point>| {
                let points: Vec<Point> = o.into_iter().map(|p| self.placement.at(p)).collect();
                Path::through(&points, true)
            };
            let colour = ink(drawn, before, tone.ink);
            before = tone.ink;
            let (name, data) = match i {
                0 => (name.clone(), data(drawn, self.frame)),
                _ => (format!("{name}-tone-{}", i + 1), Vec::new()),
            };
            let outline = tone.outlines.into_iter().filter_map(page).collect();
            Mark::Shape { name, outline, colour, data }
        };
        tones.into_iter().enumerate().map(shape).collect()
    }

    /// The band of paper beside a stroke that hides others; a plotter has no paper to draw with.
    fn rim(&self, index: usize, drawn: &Drawn<'_>) -> Option<Mark> {
        let inked = drawn.inked(&self.job.look.lines);
        let wanted = inked.hides && self.job.look.print.pen.is_none();
        let band = rim(&drawn.brush, &drawn.spine, inked.right).filter(|_| wanted)?;
        let colour = self.job.look.colours.paper;
        let (name, data) = (format!("rim-{}", index + 1), Vec::new());
        Some(Mark::Shape { name, outline: self.outline(&band), colour, data })
    }

    fn mean_width(&self, marks: &[Ribbon]) -> f64 {
        let widths: Vec<f64> = marks.iter().map(|r| f64::from(r.mean_width())).collect();
        self.placement.scale * widths.iter().sum::<f64>() / widths.len().max(1) as f64
    }

    fn name(&mut self, drawn: &Drawn<'_>) -> String {
        let stroke = &*drawn.stroke;
        let prefix = if stroke.visible { "" } else { "hidden-" };
        let part = self.parts.entry((stroke.kind, stroke.visible, stroke.id)).or_insert(0);
        *part += 1;
        match *part {
            1 => format!("{prefix}{}-{}", stroke.kind.name(), stroke.id),
            n => format!("{prefix}{}-{}-{n}", stroke.kind.name(), stroke.id),
        }
    }

    /// The border of a ribbon on the page.
    fn outline(&self, ribbon: &Ribbon) -> Vec<Path> {
        let smooth = |points: Vec<Point>| self.smooth(&points, true);
        let mut outlines = ribbon.outlines();
        if ribbon.erases {
            // Against the winding of what it takes away from.
            outlines.iter_mut().for_each(|o| o.reverse());
        }
        outlines.into_iter().filter_map(smooth).collect()
    }

    /// The middle of a ribbon on the page. What is taken away has none; a disc is a dot.
    fn middle(&self, ribbon: &Ribbon) -> Vec<Path> {
        if ribbon.erases {
            return Vec::new();
        }
        let mut points: Vec<Point> = ribbon.ribs.iter().map(place).collect();
        if ribbon.closed {
            points.pop();
        }
        self.smooth(&points, ribbon.closed).into_iter().collect()
    }

    fn smooth(&self, points: &[Point], closed: bool) -> Option<Path> {
        let on_page: Vec<Point> = points.iter().map(|p| self.placement.at(*p)).collect();
        let how = Fit {
            tolerance: TOLERANCE,
            corner: CORNER,
            blur: 0.5 * self.placement.scale,
            rounds: 0,
        };
        fit(&on_page, closed, &how)
    }
}

/// The colour by which a stroke has one share of its ink where it had another before.
fn ink(drawn: &Drawn<'_>, before: f32, wanted: f32) -> [f32; 4] {
    let [r, g, b, a] = drawn.colour;
    let full = a * drawn.brush.opacity;
    let missing = (1.0 - full * before).max(1e-6);
    [r, g, b, (full * (wanted - before) / missing).clamp(0.0, 1.0)]
}

fn place(rib: &Rib) -> Point {
    [f64::from(rib.at.x), f64::from(rib.at.y)]
}

/// What other programs may want to know of a stroke.
fn data(drawn: &Drawn<'_>, frame: &FilmFrame) -> Vec<(&'static str, String)> {
    let stroke = &*drawn.stroke;
    let number = |x: f64| format!("{}", (x * 1e4).round() / 1e4 + 0.0);
    let mut data = vec![("type", stroke.kind.name().to_owned()), ("id", stroke.id.to_string())];
    if let (Some(first), Some(last)) = (stroke.u.first(), stroke.u.last()) {
        data.push(("u0", number(*first)));
        data.push(("u1", number(*last)));
    }
    let all = if stroke.visible { &frame.strokes } else { &frame.hidden };
    let parts = all.iter().filter(|s| s.part.is_some() && s.part == stroke.part);
    let begins = |s: &chiaro_lines::Stroke| s.u.first().copied().unwrap_or(0.0);
    let parts: Vec<String> = parts.map(|s| format!("{}@{}", s.id, number(begins(s)))).collect();
    if parts.len() > 1 {
        data.push(("parts", parts.join(" ")));
    }
    if let Some(period) = stroke.begins_anew() {
        data.push(("u-period", number(period)));
    }
    data.push(("pixels-per-u", number(stroke.pixels_per_u)));
    if let chiaro_basis::Value::Word(word) = chiaro_basis::KnobValue::to_value(&drawn.brush.mark) {
        data.push(("mark", word));
    }
    data
}

/// Marks in an order and direction that spares a pen travel, where all are drawn by one, and its way.
fn routed(marks: Vec<Mark>) -> (Vec<Mark>, Travel) {
    // A mark of several paths is drawn from the first to the last, as if it were one line.
    let way = |m: &Mark| match m {
        Mark::Named { paths, .. } => match &paths[..] {
            [one] => Some(one.clone()),
            [first, .., last] => Some(Path {
                start: first.start,
                segments: vec![Segment::Line(last.end())],
                closed: false,
            }),
            [] => None,
        },
        _ => None,
    };
    let ways: Vec<Path> = marks.iter().filter_map(way).collect();
    if ways.len() < marks.len() {
        return (marks, Travel::default());
    }
    let mut marks: Vec<Option<Mark>> = marks.into_iter().map(Some).collect();
    let (order, travel) = route(ways.clone());
    let marks = order
        .into_iter()
        .filter_map(|(i, path)| {
            let back = !path.closed && path != ways[i];
            marks[i].take().map(|m| if back { reversed(m) } else { m })
        })
        .collect();
    (marks, travel)
}

/// A mark drawn from its end.
fn reversed(mark: Mark) -> Mark {
    match mark {
        Mark::Named { name, paths, width, colour, mut data } => {
            for (key, _) in &mut data {
                *key = match *key {
                    "u0" => "u1",
                    "u1" => "u0",
                    other => other,
                };
            }
            let paths = paths.iter().rev().map(Path::reversed).collect();
            Mark::Named { name, paths, width, colour, data }
        }
        other => other,
    }
}
