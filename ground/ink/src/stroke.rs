//! Lines of constant width, as antialiased coverage.

use crate::Polyline;
use chiaro_image::Plane;

/// Coverage in [0, 1] of lines `width` pixels wide, in a `size` picture: where lines overlap the
/// greater counts, so that joints do not darken.
pub fn draw(lines: &[Polyline], size: (usize, usize), width: f32) -> Plane<f32> {
    let mut plane = Plane::filled(size.0, size.1, 0.0f32);
    for line in lines {
        for (a, b) in segments(line) {
            capsule(&mut plane, a, b, 0.5 * width);
        }
    }
    plane
}

fn segments(line: &Polyline) -> impl Iterator<Item = ([f32; 2], [f32; 2])> + '_ {
    let p = &line.points;
    let around = (line.closed && p.len() > 1).then(|| (p[p.len() - 1], p[0]));
    p.windows(2).map(|s| (s[0], s[1])).chain(around)
}

/// Raises the coverage of pixels within `radius` of a segment. A line thinner than a pixel covers
/// its width's share.
fn capsule(plane: &mut Plane<f32>, a: [f32; 2], b: [f32; 2], radius: f32) {
    let (w, h) = plane.size();
    let reach = radius + 0.5;
    let span = |i: usize, size: usize| {
        let low = (a[i].min(b[i]) - reach - 0.5).floor().clamp(0.0, size as f32) as usize;
        let high = (a[i].max(b[i]) + reach + 0.5).ceil().clamp(0.0, size as f32) as usize;
        low..high
    };
    let full = (2.0 * radius).min(1.0);
    for y in span(1, h) {
        for x in span(0, w) {
            let d = distance([x as f32 + 0.5, y as f32 + 0.5], a, b);
            let cover = (reach - d).clamp(0.0, full);
            let pixel = &mut plane[(x, y)];
            *pixel = pixel.max(cover);
        }
    }
}

/// From a point to a segment.
pub(crate) fn distance(p: [f32; 2], a: [f32; 2], b: [f32; 2]) -> f32 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let (px, py) = (p[0] - a[0], p[1] - a[1]);
    let length2 = dx * dx + dy * dy;
    let t = if length2 > 0.0 { ((px * dx + py * dy) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (px - t * dx).hypot(py - t * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_covers_its_width() {
        let line = Polyline { points: vec![[-10.0, 8.3], [50.0, 8.3]], closed: false };
        for width in [0.5, 1.0, 1.5, 3.0] {
            let plane = draw(std::slice::from_ref(&line), (40, 16), width);
            let column: f32 = (0..16).map(|y| plane[(20, y)]).sum();
            assert!((column - width).abs() < 0.3, "{width}: {column}");
        }
    }
}
