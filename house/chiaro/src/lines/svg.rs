//! Lines as SVG in millimetres: one layer a line type, one path a stroke, closed ones closed.
//!
//! A path's name is the stroke's type and id; parts of one line in one frame get a second number.

use super::picture::{dashes, frame, id_colour, polyline};
use super::{Job, Shot};
use chiaro_basis::Result;
use chiaro_ink::{Drawing, Layer, Mark, Path, Placement, Point, Polyline, simplified};
use chiaro_lines::{Kind, LineColour, Stroke};
use std::collections::BTreeMap;

/// Points that stray less than this from the line are left out, in millimetres.
const TOLERANCE: f64 = 0.02;

pub(super) fn svg(shot: &Shot, number: u32, job: &Job<'_>, recipe: String) -> Result<String> {
    let placement = job.print.sheet.place(shot.camera.size)?;
    let frame = frame(shot, number);
    let background = job.colours.background;
    let mut drawing = Drawing {
        page: placement.page,
        title: format!("{}, frame {number}", job.project.file_name()),
        recipe: Some(recipe),
        background: (background[3] > 0.0 && background != [1.0; 4]).then_some(background),
        layers: Vec::new(),
    };
    let pen = Pen { job, placement: &placement };
    for kind in Kind::ALL {
        drawing.layers.extend(pen.layer(kind.name(), &frame.strokes, kind, ""));
    }
    for kind in Kind::ALL {
        let name = format!("hidden {}", kind.name());
        drawing.layers.extend(pen.layer(&name, &frame.hidden, kind, "hidden-"));
    }
    Ok(drawing.to_svg())
}

struct Pen<'a> {
    job: &'a Job<'a>,
    placement: &'a Placement,
}

impl Pen<'_> {
    fn layer(&self, name: &str, strokes: &[Stroke], kind: Kind, prefix: &str) -> Option<Layer> {
        let mut parts: BTreeMap<u32, u32> = BTreeMap::new();
        let mut marks = Vec::new();
        for stroke in strokes.iter().filter(|s| s.kind == kind) {
            let lines = match stroke.visible {
                true => vec![polyline(stroke)],
                false => dashes(stroke, self.job.knobs.dash),
            };
            for line in lines {
                let part = parts.entry(stroke.id).or_insert(0);
                *part += 1;
                let name = match *part {
                    1 => format!("{prefix}{}-{}", kind.name(), stroke.id),
                    n => format!("{prefix}{}-{}-{n}", kind.name(), stroke.id),
                };
                marks.extend(self.mark(name, stroke.id, &line));
            }
        }
        (!marks.is_empty()).then(|| Layer { name: name.into(), marks })
    }

    fn mark(&self, name: String, id: u32, line: &Polyline) -> Option<Mark> {
        let on_page = |p: &[f32; 2]| self.placement.at(p.map(f64::from));
        let mut points: Vec<Point> = line.points.iter().map(on_page).collect();
        if line.closed {
            points.push(*points.first()?);
        }
        let mut points = simplified(&points, TOLERANCE);
        if line.closed {
            points.pop();
        }
        let path = Path::through(&points, line.closed)?;
        let own = f64::from(self.job.knobs.width) * self.placement.scale;
        let width = self.job.print.pen.unwrap_or(own);
        let colour = match self.job.knobs.colour {
            LineColour::Ink => self.job.colours.ink,
            LineColour::Id => {
                let [r, g, b] = id_colour(id);
                [r, g, b, 1.0]
            }
        };
        Some(Mark::Named { name, path, width, colour })
    }
}
