//! SVG in millimetres: one Inkscape layer a pen, the recipe in the metadata.
//!
//! Coordinates are absolute and rounded to a thousandth of a millimetre, so that a border that two
//! regions share has the same numbers in both. The same drawing gives the same bytes.

use crate::drawing::{Colour, Drawing, Layer, Mark, Picture};
use crate::{Path, Point, Segment};
use std::fmt::Write;

impl Drawing {
    /// The whole file.
    pub fn to_svg(&self) -> String {
        let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        let [w, h] = self.page.map(number);
        out += "<svg xmlns=\"http://www.w3.org/2000/svg\" \
                xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\"";
        push(
            &mut out,
            format_args!(" width=\"{w}mm\" height=\"{h}mm\" viewBox=\"0 0 {w} {h}\">\n"),
        );
        if !self.title.is_empty() {
            push(&mut out, format_args!("<title>{}</title>\n", escaped(&self.title)));
        }
        if let Some(recipe) = &self.recipe {
            push(
                &mut out,
                format_args!("<metadata id=\"chiaro\">{}</metadata>\n", escaped(recipe)),
            );
        }
        if let Some(colour) = self.background.filter(|c| c[3] > 0.0) {
            let fill = paint("fill", colour);
            push(&mut out, format_args!("<rect width=\"{w}\" height=\"{h}\"{fill}/>\n"));
        }
        if let Some(picture) = &self.picture {
            write_picture(&mut out, picture);
        }
        for (i, layer) in self.layers.iter().enumerate() {
            write_layer(&mut out, i + 1, layer);
        }
        out += "</svg>\n";
        out
    }
}

fn push(out: &mut String, text: std::fmt::Arguments<'_>) {
    out.write_fmt(text).expect("a string takes all text");
}

/// A layer with an embedded picture.
fn write_picture(out: &mut String, picture: &Picture) {
    let ([x, y], [w, h]) = (picture.corner.map(number), picture.size.map(number));
    push(
        out,
        format_args!(
            "<g id=\"beneath\" inkscape:groupmode=\"layer\" inkscape:label=\"picture\">\n\
             <image x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" \
             preserveAspectRatio=\"none\" href=\"data:image/png;base64,"
        ),
    );
    base64(out, &picture.png);
    out.push_str("\"/>\n</g>\n");
}

/// Bytes as text (RFC 4648, section 4).
fn base64(out: &mut String, bytes: &[u8]) {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for three in bytes.chunks(3) {
        let byte = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i)) as usize & 63];
            out.push(if i <= three.len() { char::from(digit) } else { '=' });
        }
    }
}

fn write_layer(out: &mut String, number: usize, layer: &Layer) {
    let name = escaped(&layer.name);
    push(
        out,
        format_args!(
            "<g id=\"layer{number}\" inkscape:groupmode=\"layer\" inkscape:label=\"{name}\">\n"
        ),
    );
    for mark in &layer.marks {
        match mark {
            Mark::Fill { outline, colour } => {
                out.push_str("<path");
                out.push_str(&paint("fill", *colour));
                out.push_str(" fill-rule=\"evenodd\" d=\"");
                outline.iter().for_each(|path| write_path(out, path));
            }
            Mark::Stroke { path, width, colour } => {
                write_stroke(out, "", std::slice::from_ref(path), *width, *colour);
            }
            Mark::Named { name, paths, width, colour, data } => {
                write_stroke(out, &named(name, data), paths, *width, *colour);
            }
            Mark::Shape { name, outline, colour, data } => {
                push(out, format_args!("<path{}{}", named(name, data), paint("fill", *colour)));
                out.push_str(" d=\"");
                outline.iter().for_each(|path| write_path(out, path));
            }
        }
        out.push_str("\"/>\n");
    }
    out.push_str("</g>\n");
}

/// A name and what is known, as attributes.
fn named(name: &str, data: &[(&'static str, String)]) -> String {
    let mut text = format!(" id=\"{}\"", escaped(name));
    for (key, value) in data {
        text += &format!(" data-{key}=\"{}\"", escaped(value));
    }
    text
}

fn write_stroke(out: &mut String, id: &str, paths: &[Path], width: f64, colour: Colour) {
    push(
        out,
        format_args!("<path{id} fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\""),
    );
    out.push_str(&paint("stroke", colour));
    push(out, format_args!(" stroke-width=\"{}\" d=\"", number(width)));
    paths.iter().for_each(|path| write_path(out, path));
}

/// `M x y L x y C x y x y x y Z`.
fn write_path(out: &mut String, path: &Path) {
    point(out, 'M', path.start);
    for segment in &path.segments {
        match *segment {
            Segment::Line(p) => point(out, 'L', p),
            Segment::Cubic(a, b, p) => {
                point(out, 'C', a);
                point(out, ' ', b);
                point(out, ' ', p);
            }
        }
    }
    if path.closed {
        out.push('Z');
    } else if path.segments.is_empty() {
        // A dot: round ends need a line to end.
        point(out, 'L', path.start);
    }
}

fn point(out: &mut String, command: char, [x, y]: Point) {
    push(out, format_args!("{command}{} {}", number(x), number(y)));
}

/// A number to three places, without trailing zeros.
fn number(x: f64) -> String {
    let thousandths = (x * 1000.0).round();
    let value = if thousandths == 0.0 { 0.0 } else { thousandths / 1000.0 };
    format!("{value}")
}

/// An attribute such as ` fill="#102030"`, with opacity where it is not 1.
fn paint(attribute: &str, [r, g, b, a]: Colour) -> String {
    let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
    let mut text = format!(" {attribute}=\"#{:02x}{:02x}{:02x}\"", byte(r), byte(g), byte(b));
    if a < 1.0 {
        text += &format!(" {attribute}-opacity=\"{}\"", number(f64::from(a)));
    }
    text
}

/// Text for XML; characters that XML cannot hold are left out.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\t' | '\n' | '\r' => out.push(c),
            '\u{FFFE}' | '\u{FFFF}' => {}
            c if c < ' ' => {}
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drawing_is_one_readable_file() {
        let square = Path::through(&[[1.0, 1.0], [9.0, 1.0], [9.0, 9.0]], true).unwrap();
        let line = Path::through(&[[0.0, 5.0], [10.0, 5.00049]], false).unwrap();
        let black = [0.0, 0.0, 0.0, 1.0];
        let marks = vec![
            Mark::Fill { outline: vec![square], colour: black },
            Mark::Stroke { path: line, width: 0.3, colour: [1.0, 0.0, 0.0, 0.5] },
        ];
        let drawing = Drawing {
            page: [10.0, 20.0],
            title: "a < b".into(),
            recipe: Some("{\"x\":\"\u{1}&\"}".into()),
            background: None,
            picture: Some(Picture {
                png: b"light".to_vec(),
                corner: [1.0, 2.0],
                size: [8.0, 16.0],
            }),
            layers: vec![Layer { name: "1 ink".into(), marks }],
        };
        let svg = drawing.to_svg();
        assert!(svg.contains("width=\"10mm\" height=\"20mm\" viewBox=\"0 0 10 20\""));
        assert!(svg.contains("inkscape:label=\"1 ink\""));
        assert!(svg.contains("width=\"8\" height=\"16\" preserve"));
        assert!(svg.contains("data:image/png;base64,bGlnaHQ=\"/>"));
        assert!(svg.contains("M1 1L9 1L9 9Z"));
        assert!(svg.contains("stroke=\"#ff0000\" stroke-opacity=\"0.5\" stroke-width=\"0.3\""));
        assert!(svg.contains("M0 5L10 5\""));
        assert!(svg.contains("{&quot;x&quot;:&quot;&amp;&quot;}"));
        let tree = resvg::usvg::Tree::from_str(&svg, &resvg::usvg::Options::default()).unwrap();
        assert!((tree.size().width() - 37.795).abs() < 1e-2);
    }
}
