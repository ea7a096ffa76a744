//! Charts and tables as pictures.

use super::chapter4::{BLACK, Canvas, Colour, GREY};
use chiaro_image::Plane;
use chiaro_image::text::{LINE_HEIGHT, draw_text, text_width};
use chiaro_ink::Polyline;

/// Room around the plot: left, right of it for names, above, below.
const ROOM: [f32; 4] = [64.0, 190.0, 26.0, 40.0];
const INK: [u8; 3] = [46, 46, 48];
/// Colours of series, told apart in grey too.
pub(super) const COLOURS: [Colour; 8] = [
    [0.82, 0.16, 0.1],
    [0.12, 0.32, 0.75],
    [0.1, 0.55, 0.25],
    [0.85, 0.55, 0.05],
    [0.5, 0.2, 0.6],
    [0.1, 0.6, 0.65],
    [0.45, 0.3, 0.15],
    [0.05, 0.05, 0.05],
];

/// How numbers lie along an axis.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Scale {
    Linear,
    Log,
}

/// An axis: what it says, and how.
pub(super) struct Axis {
    pub(super) name: &'static str,
    pub(super) scale: Scale,
}

/// Points with a name, joined by a line or not.
pub(super) struct Series {
    pub(super) name: String,
    pub(super) colour: Colour,
    pub(super) points: Vec<[f64; 2]>,
    pub(super) joined: bool,
}

/// A chart.
pub(super) struct Chart {
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) series: Vec<Series>,
}

impl Axis {
    fn put(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value,
            Scale::Log => value.max(1e-12).log10(),
        }
    }

    /// The least and the greatest value, rounded outwards, as they are put.
    fn range(&self, values: impl Iterator<Item = f64>) -> [f64; 2] {
        let (low, high) = values
            .map(|v| self.put(v))
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            return [0.0, 1.0];
        }
        let room = (0.06 * (high - low)).max(if high > low { 0.0 } else { 0.5 });
        let floor = if self.scale == Scale::Linear && low >= 0.0 { 0.0 } else { f64::MIN };
        [(low - room).max(floor), high + room]
    }

    /// Values to be marked.
    fn ticks(&self, [low, high]: [f64; 2]) -> Vec<f64> {
        match self.scale {
            Scale::Linear => even_ticks([low, high]),
            // Between neighbouring digits.
            Scale::Log if high - low < 0.2 => even_ticks([low, high].map(|v| 10f64.powf(v))),
            Scale::Log => {
                let digits: &[f64] = match high - low {
                    r if r < 0.4 => &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
                    r if r < 2.0 => &[1.0, 2.0, 5.0],
                    _ => &[1.0],
                };
                let decades = low.floor() as i32..=high.ceil() as i32;
                let all = decades.flat_map(|d| digits.iter().map(move |m| m * 10f64.powi(d)));
                all.filter(|v| (low..=high).contains(&v.log10())).collect()
            }
        }
    }
}

/// Round numbers in a range, the same apart.
fn even_ticks([low, high]: [f64; 2]) -> Vec<f64> {
    let rough = (high - low) / 6.0;
    let unit = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|s| s * unit).into_iter().find(|s| *s >= rough);
    let step = step.unwrap_or(10.0 * unit);
    let first = (low / step).ceil() as i64;
    (first..).map(|i| i as f64 * step).take_while(|v| *v <= high + 1e-9).collect()
}

fn short(value: f64) -> String {
    match value.abs() {
        v if v >= 1e4 => format!("{:.0}k", value / 1e3),
        v if v >= 100.0 || v.fract() == 0.0 => format!("{value:.0}"),
        v if v >= 0.1 => format!("{value:.1}"),
        _ => format!("{value:.0e}"),
    }
}

impl Chart {
    /// The chart as a picture.
    pub(super) fn draw(&self, (width, height): (usize, usize)) -> Plane<[u8; 3]> {
        let values =
            |i: usize| self.series.iter().flat_map(move |s| s.points.iter().map(move |p| p[i]));
        let (xs, ys) = (self.x.range(values(0)), self.y.range(values(1)));
        let [left, right, above, below] = ROOM;
        let (w, h) = (width as f32 - left - right, height as f32 - above - below);
        let place = |x: f64, y: f64| {
            let share = |v: f64, [low, high]: [f64; 2]| ((v - low) / (high - low)) as f32;
            [left + w * share(x, xs), above + h * (1.0 - share(y, ys))]
        };
        let at = |p: &[f64; 2]| place(self.x.put(p[0]), self.y.put(p[1]));
        let line = |points: Vec<[f32; 2]>| Polyline { points, closed: false };
        let mut canvas = Canvas::new((width, height));
        let (x_ticks, y_ticks) = (self.x.ticks(xs), self.y.ticks(ys));
        let upright =
            |v: &f64| line(vec![place(self.x.put(*v), ys[0]), place(self.x.put(*v), ys[1])]);
        let level =
            |v: &f64| line(vec![place(xs[0], self.y.put(*v)), place(xs[1], self.y.put(*v))]);
        let grid: Vec<Polyline> =
            x_ticks.iter().map(upright).chain(y_ticks.iter().map(level)).collect();
        canvas.lines(&grid, 0.6, GREY);
        let axes = [line(vec![place(xs[0], ys[1]), place(xs[0], ys[0]), place(xs[1], ys[0])])];
        canvas.lines(&axes, 1.4, BLACK);
        for s in &self.series {
            if s.joined {
                canvas.lines(&[line(s.points.iter().map(at).collect())], 2.0, s.colour);
            }
            if !s.joined || s.points.len() < 40 {
                let dot = |p: &[f64; 2]| {
                    let [x, y] = at(p);
                    line(vec![[x, y], [x + 0.01, y]])
                };
                canvas.lines(&s.points.iter().map(dot).collect::<Vec<_>>(), 7.0, s.colour);
            }
        }
        for (i, s) in self.series.iter().enumerate() {
            let y = above + 8.0 + 16.0 * i as f32;
            let x = left + w + 12.0;
            canvas.lines(&[line(vec![[x, y], [x + 14.0, y]])], 4.0, s.colour);
        }
        let mut picture = canvas.done();
        let mut write = |x: f32, y: f32, text: &str| {
            draw_text(&mut picture, (x.max(0.0) as usize, y.max(0.0) as usize), text, 1, INK);
        };
        for v in &x_ticks {
            let text = short(*v);
            let [x, y] = place(self.x.put(*v), ys[0]);
            write(x - 0.5 * text_width(&text, 1) as f32, y + 6.0, &text);
        }
        for v in &y_ticks {
            let text = short(*v);
            let [x, y] = place(xs[0], self.y.put(*v));
            write(x - 6.0 - text_width(&text, 1) as f32, y - 4.0, &text);
        }
        write(left - 40.0, 6.0, self.y.name);
        let x = left + w - text_width(self.x.name, 1) as f32;
        write(x, height as f32 - 14.0, self.x.name);
        for (i, s) in self.series.iter().enumerate() {
            write(left + w + 32.0, above + 4.0 + 16.0 * i as f32, &s.name);
        }
        picture
    }
}

/// Rows of cells as a picture; the first row is the head.
pub(super) fn table(rows: &[Vec<String>]) -> Plane<[u8; 3]> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let cell = |row: &Vec<String>, c: usize| row.get(c).map_or(0, |t| text_width(t, 1));
    let widths: Vec<usize> =
        (0..columns).map(|c| rows.iter().map(|r| cell(r, c)).max().unwrap_or(0) + 18).collect();
    let line = LINE_HEIGHT + 7;
    let size = (widths.iter().sum::<usize>() + 20, rows.len() * line + 26);
    let mut canvas = Canvas::new(size);
    let y = 10.0 + line as f32;
    let rule = vec![[8.0, y], [size.0 as f32 - 8.0, y]];
    canvas.lines(&[Polyline { points: rule, closed: false }], 1.0, GREY);
    let mut picture = canvas.done();
    for (i, row) in rows.iter().enumerate() {
        let y = 12 + i * line + if i > 0 { 4 } else { 0 };
        let mut x = 12;
        for (text, width) in row.iter().zip(&widths) {
            draw_text(&mut picture, (x, y), text, 1, INK);
            x += width;
        }
    }
    picture
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        let linear = Axis { name: "", scale: Scale::Linear };
        assert_eq!(linear.ticks([0.0, 11.0]), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        let log = Axis { name: "", scale: Scale::Log };
        assert_eq!(log.ticks([0.9, 4.1]), [10.0, 100.0, 1000.0, 10_000.0]);
        let near = log.ticks([0.93, 0.96]);
        assert!(near.len() >= 3 && near.iter().all(|v| (8.5..9.13).contains(v)), "{near:?}");
        assert_eq!(log.range(std::iter::empty()), [0.0, 1.0]);
    }

    #[test]
    fn a_chart_draws_its_series_and_a_table_its_rows() {
        let series = Series {
            name: "a".into(),
            colour: COLOURS[0],
            points: vec![[16.0, 0.5], [65_536.0, 0.01]],
            joined: true,
        };
        let axis = |name| Axis { name, scale: Scale::Log };
        let picture =
            Chart { x: axis("k"), y: axis("error"), series: vec![series] }.draw((500, 300));
        let red = |p: &[u8; 3]| p[0] > 150 && p[1] < 90;
        assert!(picture.pixels().iter().filter(|p| red(p)).count() > 300);
        let cells = |t: &str| vec![t.to_owned(), "12".to_owned()];
        assert!(table(&[cells("head"), cells("row")]).pixels().contains(&INK));
    }
}
