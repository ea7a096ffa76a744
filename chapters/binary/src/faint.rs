//! Lines that go on where what draws them gets fainter: with one threshold a step of nearly that size is
//! drawn in pieces. After Canny, *A computational approach to edge detection*, 1986.

/// A pixel's mark where a line may go on to its right; twice that, below.
pub(crate) const FAINT: u8 = 4;

/// A mark's pixel, and on which side: 0 to its right, 1 below.
type Mark = (usize, usize, usize);

/// Draws the faint marks that hang together with drawn ones (1: to the right, 2: below), and drops the
/// others. `marks` are rows of `width` pixels.
pub(crate) fn go_on(marks: &mut [u8], width: usize) {
    let height = marks.len() / width.max(1);
    let is = |marks: &[u8], (x, y, side): Mark, kind: u8| marks[y * width + x] & kind << side != 0;
    let mut open: Vec<Mark> = Vec::new();
    let all = (0..marks.len()).filter(|i| marks[*i] >= FAINT);
    for (x, y) in all.map(|i| (i % width, i / width)) {
        let faint = [(x, y, 0), (x, y, 1)].into_iter().filter(|m| is(marks, *m, FAINT));
        let meets = |m: &Mark| beside(*m, (width, height)).any(|other| is(marks, other, 1));
        open.extend(faint.filter(meets));
    }
    while let Some(mark) = open.pop() {
        let (x, y, side) = mark;
        if is(marks, mark, FAINT) {
            let pixel = &mut marks[y * width + x];
            *pixel = (*pixel | 1 << side) & !(FAINT << side);
            open.extend(beside(mark, (width, height)).filter(|other| is(marks, *other, FAINT)));
        }
    }
    marks.iter_mut().for_each(|mark| *mark &= FAINT - 1);
}

/// The marks that meet one at its two ends, itself among them.
fn beside((x, y, side): Mark, (w, h): (usize, usize)) -> impl Iterator<Item = Mark> {
    // A mark's ends are corners of pixels: the lower right one of its own, and the one above or left.
    let ends = [(x + 1, y + 1), if side == 0 { (x + 1, y) } else { (x, y + 1) }];
    ends.into_iter().flat_map(move |(x, y)| {
        let around = [(x, y, 0), (x, y + 1, 0), (x, y, 1), (x + 1, y, 1)];
        let inside = move |(x, y, _): &Mark| (1..=w).contains(x) && (1..=h).contains(y);
        around.into_iter().filter(inside).map(|(x, y, side)| (x - 1, y - 1, side))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faint_marks_are_drawn_where_they_hang_together_with_others() {
        // A line down between columns 1 and 2, that turns right under row 4; faint after row 1.
        let (w, h) = (6, 8);
        let mut marks = vec![0u8; w * h];
        for y in 0..5 {
            marks[y * w + 1] = if y < 2 { 1 } else { FAINT };
        }
        for x in 2..5 {
            marks[4 * w + x] = FAINT << 1;
        }
        // A faint one of its own.
        marks[6 * w + 3] = FAINT;
        go_on(&mut marks, w);
        let drawn = |x: usize, y: usize| match (x, y) {
            (1, 0..=4) => 1,
            (2..=4, 4) => 2,
            _ => 0,
        };
        for (i, mark) in marks.iter().enumerate() {
            assert_eq!(*mark, drawn(i % w, i / w), "{} {}", i % w, i / w);
        }
        go_on(&mut [], 0);
    }
}
