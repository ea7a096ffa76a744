//! Outlines that go on where a region leaves them no room: beside a row of windows they would be drawn
//! in dashes.
//!
//! Marks that draw a line are *drawn*, those that might are *open*. A stretch of open marks is drawn that
//! is short and has a drawn mark at both ends, or that is not long and has a line there: from a mark or two
//! nothing goes on far.

use crate::faint::{Mark, ends};
use crate::knob::scaled;
use chiaro_image::Plane;

/// A pixel's mark to its right, drawn and open; twice that, below. None is both.
pub(crate) const DRAWN: u8 = 1;
pub(crate) const OPEN: u8 = 4;

/// Looked at.
const SEEN: u8 = 16;

/// The longest stretches between drawn marks and between lines, and the shortest line; pixels at 480.
const SHORT: f32 = 12.0;
const LONG: f32 = 24.0;
const LINE: f32 = 4.0;

/// Draws the stretches of open marks that connect what is drawn.
pub(crate) fn bridge(marks: &mut Plane<u8>) {
    let [short, long, line] =
        [SHORT, LONG, LINE].map(|l| scaled(l, marks.height()).ceil() as usize);
    let (w, h) = marks.size();
    let mut bridges = Vec::new();
    for start in (0..w * h).flat_map(|i| [(i % w, i / w, 0), (i % w, i / w, 1)]) {
        if is(marks, start, OPEN) && !is(marks, start, SEEN) {
            let stretch = connected(start, marks);
            let least = if stretch.len() <= short { 1 } else { line };
            if stretch.len() <= long && lines_met(&stretch, marks, least) > 1 {
                bridges.extend(stretch);
            }
        }
    }
    bridges.into_iter().for_each(|m| set(marks, m, DRAWN));
}

/// At how many ends of a stretch at least so many drawn marks go on.
fn lines_met(stretch: &[Mark], marks: &Plane<u8>, least: usize) -> usize {
    let goes_on = |end: &[Option<Mark>; 4]| {
        let drawn = end.iter().flatten().filter(|m| is(marks, **m, DRAWN));
        drawn.map(|m| line(*m, marks, least)).sum::<usize>() >= least
    };
    stretch.iter().flat_map(|mark| ends(*mark, marks.size())).filter(goes_on).count()
}
/// The open marks that hang together with one, itself the first; they have been seen then.
fn connected(start: Mark, marks: &mut Plane<u8>) -> Vec<Mark> {
    let mut found = vec![start];
    set(marks, start, SEEN);
    let mut next = 0;
    while let Some(&mark) = found.get(next) {
        next += 1;
        for other in ends(mark, marks.size()).into_iter().flatten().flatten() {
            if is(marks, other, OPEN) && !is(marks, other, SEEN) {
                set(marks, other, SEEN);
                found.push(other);
            }
        }
    }
    found
}

/// How many drawn marks hang together with one, counted up to `enough`.
fn line(start: Mark, marks: &Plane<u8>, enough: usize) -> usize {
    let mut found = vec![start];
    let mut next = 0;
    while next < found.len() && found.len() < enough {
        for other in ends(found[next], marks.size()).into_iter().flatten().flatten() {
            if is(marks, other, DRAWN) && !found.contains(&other) {
                found.push(other);
            }
        }
        next += 1;
    }
    found.len()
}

fn is(marks: &Plane<u8>, (x, y, side): Mark, kind: u8) -> bool {
    marks[(x, y)] & kind << side != 0
}

fn set(marks: &mut Plane<u8>, (x, y, side): Mark, kind: u8) {
    marks[(x, y)] |= kind << side;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How much of a row of marks is drawn, of `-` drawn, `o` open and ` ` none.
    fn drawn(row: &str) -> String {
        let kind = |x: usize| match row.as_bytes()[x] {
            b'-' => DRAWN << 1,
            b'o' => OPEN << 1,
            _ => 0,
        };
        let mut marks = Plane::from_fn(row.len(), 480, |x, y| if y == 9 { kind(x) } else { 0 });
        bridge(&mut marks);
        marks.row(9).iter().map(|m| if m & DRAWN << 1 != 0 { '-' } else { ' ' }).collect()
    }

    #[test]
    fn what_stands_between_drawn_marks_is_drawn() {
        let row = |parts: &[(char, usize)]| -> String {
            parts.iter().map(|(mark, n)| mark.to_string().repeat(*n)).collect()
        };
        for (parts, is_bridged) in [
            ([('-', 9), ('o', 9), ('-', 9)], true),
            ([('-', 1), ('o', 9), ('-', 1)], true),
            ([('-', 9), ('o', 20), ('-', 9)], true),
            ([('-', 9), ('o', 20), ('-', 1)], false),
            ([('-', 9), ('o', 30), ('-', 9)], false),
            ([('-', 9), ('o', 9), (' ', 1)], false),
            ([(' ', 9), ('o', 9), (' ', 9)], false),
        ] {
            let row = row(&parts);
            let wanted = row.replace('o', if is_bridged { "-" } else { " " });
            assert_eq!(drawn(&row), wanted, "{row}");
        }
        bridge(&mut Plane::filled(0, 0, 0));
    }
}
