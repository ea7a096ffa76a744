//! Lines as SVG in millimetres: one layer a line type, one path a stroke, closed ones closed.

use super::{Shot, picture};
use crate::binary::Colours;
use chiaro_lines::{Kind, LinesKnobs, Stroke};
use std::fmt::Write;

/// Millimetres of a pixel where no paper is chosen: 96 to an inch.
const PIXEL: f64 = 25.4 / 96.0;

pub(super) fn svg(
    shot: &Shot,
    number: u32,
    knobs: &LinesKnobs,
    colours: &Colours,
    recipe: &str,
) -> String {
    let frame = picture::frame(shot, number);
    let (w, h) = (shot.camera.size.0 as f64 * PIXEL, shot.camera.size.1 as f64 * PIXEL);
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" \
         xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" \
         width=\"{w:.3}mm\" height=\"{h:.3}mm\" viewBox=\"0 0 {w:.3} {h:.3}\">\n\
         <metadata>{}</metadata>\n",
        recipe.replace('&', "&amp;").replace('<', "&lt;")
    );
    if colours.background[3] > 0.0 && colours.background != [1.0; 4] {
        let _ = writeln!(
            text,
            "<rect width=\"{w:.3}\" height=\"{h:.3}\" fill=\"{}\"/>",
            hex(colours.background)
        );
    }
    for kind in Kind::ALL {
        let strokes: Vec<&Stroke> = frame.strokes.iter().filter(|s| s.kind == kind).collect();
        if !strokes.is_empty() {
            layer(&mut text, kind, &strokes, knobs, colours);
        }
    }
    text += "</svg>\n";
    text
}

fn layer(
    text: &mut String,
    kind: Kind,
    strokes: &[&Stroke],
    knobs: &LinesKnobs,
    colours: &Colours,
) {
    let _ = writeln!(
        text,
        "<g id=\"{0}\" inkscape:groupmode=\"layer\" inkscape:label=\"{0}\" fill=\"none\" \
         stroke=\"{1}\" stroke-width=\"{2:.3}\" stroke-linecap=\"round\" stroke-linejoin=\"round\">",
        kind.name(),
        hex(colours.ink),
        f64::from(knobs.width) * PIXEL
    );
    for stroke in strokes {
        let _ = write!(text, "<path id=\"{}-{}\" d=\"", kind.name(), stroke.id);
        for (i, s) in stroke.samples.iter().enumerate() {
            let command = if i == 0 { "M" } else { "L" };
            let _ = write!(text, "{command}{:.3} {:.3}", s.at.x * PIXEL, s.at.y * PIXEL);
        }
        *text += if stroke.closed { "Z\"/>\n" } else { "\"/>\n" };
    }
    *text += "</g>\n";
}

fn hex(c: [f32; 4]) -> String {
    let byte = |x: f32| (x * 255.0).round() as u8;
    format!("#{:02x}{:02x}{:02x}", byte(c[0]), byte(c[1]), byte(c[2]))
}
