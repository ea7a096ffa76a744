//! Lines as JSON, for other programs.
//!
//! Pixels to a thousandth, y down; world coordinates as they round to seven digits. Lines are followed a
//! margin out of the picture; what is there is not `visible`. The first sample
//! of a closed stroke is not repeated. `partner` is the correspondence along S of each sample: index of
//! a stroke of the next frame, of a sample of it, and the share of the way from that to the one after.
//! `u_period` is u once round a closed stroke, else null; `repeats` is after how much of u the texture begins
//! anew, on parts of lines that close too.

use super::ready::{Names, subject};
use super::style::{LineStyle, brush_settings};
use super::{Look, Shot};
use chiaro_basis::math::{DVec2, DVec3};
use chiaro_ink::brush::Brush;
use chiaro_lines::{FilmEvent, FilmFrame, Kind, Owner, Partner, Stroke, View};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write;

/// Writes the frames `wanted` of a shot, with the events between them; frame by frame, so that a long
/// film is never in memory as text.
pub(super) fn write(
    shot: &Shot,
    wanted: &[u32],
    look: &Look<'_>,
    sink: &mut dyn Write,
) -> std::io::Result<()> {
    let mut brushes = Brushes::default();
    let mut text = String::from("{\"frames\":[");
    let frames = shot.numbers.iter().zip(&shot.film.frames).enumerate();
    let chosen = frames.filter(|(_, (n, _))| wanted.contains(n));
    for (k, (i, (number, f))) in chosen.enumerate() {
        text.push_str(if k > 0 { "," } else { "" });
        let partners = shot.film.partners(i);
        frame(&mut text, *number, f, &partners, |s| brushes.of(&look.lines, &shot.names, s));
        sink.write_all(text.as_bytes())?;
        text.clear();
    }
    text += "\n],\"events\":[";
    let events = shot.film.events.iter().map(|e| (number_of(&shot.numbers, e.time), e));
    let (low, high) = (wanted.iter().min(), wanted.iter().max());
    let inside = |t: f64| {
        low.is_some_and(|l| t >= f64::from(*l)) && high.is_some_and(|h| t <= f64::from(*h))
    };
    join(&mut text, events.filter(|(t, _)| inside(*t)), |text, (time, e)| event(text, time, e));
    let style = json!(look.style.name);
    let _ = write!(text, "\n],\"style\":{style},\"brushes\":{}}}\n", brushes.json());
    sink.write_all(text.as_bytes())
}

/// The brushes that occur, in the order in which they do.
#[derive(Default)]
struct Brushes {
    list: Vec<Brush>,
    known: BTreeMap<(Kind, bool, Option<Owner>), usize>,
}

impl Brushes {
    /// The place of a stroke's brush among them.
    fn of(&mut self, style: &LineStyle, names: &Names, stroke: &Stroke) -> usize {
        let list = &mut self.list;
        *self.known.entry((stroke.kind, stroke.visible, stroke.owner)).or_insert_with(|| {
            let brush = style.brush_for(&subject(stroke, stroke.owner, names));
            let same = list.iter().position(|b| *b == brush);
            same.unwrap_or_else(|| {
                list.push(brush);
                list.len() - 1
            })
        })
    }

    fn json(&self) -> Value {
        self.list.iter().map(brush_settings).collect()
    }
}

/// The frame number at a fractional index of the shot.
fn number_of(numbers: &[u32], index: f64) -> f64 {
    let i = (index as usize).min(numbers.len() - 1);
    let next = numbers.get(i + 1).map_or(f64::from(numbers[i]) + 1.0, |n| f64::from(*n));
    f64::from(numbers[i]) + (index - i as f64) * (next - f64::from(numbers[i]))
}

fn join<T>(text: &mut String, items: impl Iterator<Item = T>, mut put: impl FnMut(&mut String, T)) {
    for (i, item) in items.enumerate() {
        if i > 0 {
            text.push(',');
        }
        put(text, item);
    }
}

fn frame(
    text: &mut String,
    number: u32,
    frame: &FilmFrame,
    partners: &[Vec<Option<Partner>>],
    mut brush: impl FnMut(&Stroke) -> usize,
) {
    let view = &frame.view;
    let aspect = view.size.0 as f32 / view.size.1 as f32;
    let matrix = view.pose.clip_from_world(aspect).transpose().to_cols_array();
    let _ = write!(text, "\n{{\"frame\":{number},\"clip_from_world\":[");
    join(text, matrix.into_iter(), |t, x| float(t, f64::from(x)));
    text.push_str("],\"strokes\":[");
    // Hidden parts have none.
    let partners = partners.iter().map(Vec::as_slice).chain(std::iter::repeat(&[][..]));
    let strokes = frame.strokes.iter().chain(&frame.hidden).zip(partners);
    join(text, strokes, |t, (s, partners)| stroke(t, s, view, partners, brush(s)));
    text.push_str("]}");
}

fn stroke(text: &mut String, s: &Stroke, view: &View, partners: &[Option<Partner>], brush: usize) {
    let _ = write!(
        text,
        "\n{{\"id\":{},\"type\":\"{}\",\"brush\":{brush},\"closed\":{},\"points\":[",
        s.id,
        s.kind.name(),
        s.closed
    );
    join(text, s.samples.iter(), |t, p| point(t, p.at));
    text.push_str("],\"visible\":[");
    join(text, s.samples.iter(), |t, p| {
        t.push(if s.visible && view.holds(p.at, 0.0) { '1' } else { '0' });
    });
    text.push_str("],\"u\":[");
    join(text, s.u.iter().take(s.samples.len()), |t, u| parameter(t, *u));
    text.push_str("],\"pixels_per_u\":");
    float(text, s.pixels_per_u);
    let _ = write!(text, ",\"component\":{}", s.texture());
    text.push_str(",\"part_of\":");
    option(text, s.part, |t, (line, _)| _ = write!(t, "{line}"));
    text.push_str(",\"u_period\":");
    option(text, s.u_period.filter(|_| s.closed), parameter);
    text.push_str(",\"repeats\":");
    option(text, s.begins_anew(), parameter);
    text.push_str(",\"next\":[");
    join(text, s.samples.iter(), |t, p| option(t, p.next_at, point));
    text.push_str("],\"world\":[");
    join(text, s.samples.iter(), |t, p| place(t, p.world));
    text.push_str("],\"next_world\":[");
    let next = s.samples.iter().map(|p| p.next_at.and(p.next_world));
    join(text, next, |t, p| option(t, p, place));
    text.push_str("],\"partner\":[");
    let partners = (0..s.samples.len()).map(|i| partners.get(i).copied().flatten());
    join(text, partners, |t, p| {
        option(t, p, |t, p| _ = write!(t, "[{},{},{}]", p.stroke, p.segment, p.share as f32));
    });
    text.push_str("],\"depth\":[");
    join(text, s.samples.iter(), |t, p| float(t, p.depth));
    text.push_str("]}");
}

fn event(text: &mut String, time: f64, e: &FilmEvent) {
    let _ = write!(text, "\n{{\"frame\":{time:.6},\"kind\":\"{}\",\"x\":", e.kind.name());
    option(text, e.at.map(|p| p.x), pixels);
    text.push_str(",\"y\":");
    option(text, e.at.map(|p| p.y), pixels);
    text.push_str(",\"world\":");
    place(text, e.world);
    text.push_str(",\"strokes\":[");
    join(text, e.strokes.iter(), |t, id| {
        let _ = write!(t, "{id}");
    });
    text.push_str("]}");
}

fn option<T>(text: &mut String, value: Option<T>, put: impl Fn(&mut String, T)) {
    match value {
        Some(value) => put(text, value),
        None => text.push_str("null"),
    }
}

fn point(text: &mut String, p: DVec2) {
    text.push('[');
    pixels(text, p.x);
    text.push(',');
    pixels(text, p.y);
    text.push(']');
}

fn place(text: &mut String, p: DVec3) {
    text.push('[');
    join(text, p.to_array().into_iter(), float);
    text.push(']');
}

fn pixels(text: &mut String, x: f64) {
    let _ = write!(text, "{}", (x * 1000.0).round() / 1000.0 + 0.0);
}

/// To a millionth: u may count patterns of many pixels.
fn parameter(text: &mut String, u: f64) {
    let _ = write!(text, "{}", (u * 1e6).round() / 1e6 + 0.0);
}

/// As many digits as single precision holds.
fn float(text: &mut String, x: f64) {
    let _ = write!(text, "{}", x as f32);
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::Vec3;
    use chiaro_lines::{Sample, surface::NONE};
    use chiaro_scene::{Pose, Projection};

    /// What is written of a stroke in a picture of 100 by 80 pixels.
    fn written(s: &Stroke) -> Value {
        let projection = Projection::Orthographic { half_height: 1.0 };
        let pose = Pose::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, projection);
        let mut text = String::new();
        stroke(&mut text, s, &View::new(pose, (100, 80)), &[], 0);
        serde_json::from_str(&text).unwrap()
    }

    #[test]
    fn what_is_out_of_the_picture_is_not_visible() {
        let sample = |x: f64| Sample {
            at: DVec2::new(x, 40.0),
            depth: 1.0,
            world: DVec3::ZERO,
            next_world: None,
            next_at: None,
            chain: 0,
            on_chain: x,
            normal: DVec3::Z,
            faces: [NONE; 2],
        };
        let across = [-3.0, 0.0, 50.0, 100.0, 103.0].map(sample);
        let seen = Stroke::through(Kind::Crease, false, across.to_vec());
        assert_eq!(written(&seen)["visible"], json!([0, 1, 1, 1, 0]));
        assert_eq!(written(&Stroke { visible: false, ..seen })["visible"], json!([0, 0, 0, 0, 0]));
    }

    #[test]
    fn open_strokes_have_no_period_but_may_repeat() {
        let open =
            Stroke { repeats: Some(2.0), ..Stroke::through(Kind::Crease, false, Vec::new()) };
        let value = written(&open);
        assert_eq!((&value["u_period"], &value["repeats"]), (&Value::Null, &json!(2)));
        let closed = Stroke { closed: true, u_period: Some(2.0), repeats: None, ..open };
        let value = written(&closed);
        assert_eq!((&value["u_period"], &value["repeats"]), (&json!(2), &json!(2)));
    }
}
