//! Lines that go on where what draws them gets fainter: with one threshold a step or a bend of nearly that
//! size is drawn in pieces. After Canny, *A computational approach to edge detection*, 1986.
//!
//! A faint step goes on from any line that it meets. A faint crease goes on from a crease that ends there,
//! and from nothing else: sides of a prism end at the edges of its caps, and at what stands before them.

/// A pixel's mark where a line may go on to its right along a step; twice that, below.
pub(crate) const FAINT: u8 = 4;

/// The same along a crease.
pub(crate) const FAINT_CREASE: u8 = 16;

/// A crease that is drawn.
pub(crate) const CREASE: u8 = DRAWN | 64;

/// What is drawn.
const DRAWN: u8 = 1;

/// A mark's pixel, and on which side: 0 to its right, 1 below.
pub(crate) type Mark = (usize, usize, usize);

/// Draws the faint marks that hang together with drawn ones (1: to the right, 2: below), and drops the
/// others. `marks` are rows of `width` pixels.
pub(crate) fn go_on(marks: &mut [u8], width: usize) {
    let size = (width, marks.len() / width.max(1));
    let mut open: Vec<Mark> = Vec::new();
    let faint = |mark: u8| mark & (3 * (FAINT | FAINT_CREASE)) != 0;
    let all = (0..marks.len()).filter(|i| faint(marks[*i]));
    for (x, y) in all.map(|i| (i % width, i / width)) {
        let sides = [(x, y, 0), (x, y, 1)].into_iter();
        open.extend(sides.filter(|m| goes_on(marks, *m, size)));
    }
    while let Some(mark) = open.pop() {
        let (x, y, side) = mark;
        if is(marks, width, mark, FAINT | FAINT_CREASE) {
            let drawn = if is(marks, width, mark, FAINT_CREASE) { CREASE } else { DRAWN };
            let pixel = &mut marks[y * width + x];
            *pixel = (*pixel | drawn << side) & !((FAINT | FAINT_CREASE) << side);
            let next = ends(mark, size).into_iter().flatten().flatten();
            open.extend(next.filter(|other| goes_on(marks, *other, size)));
        }
    }
    marks.iter_mut().for_each(|mark| *mark &= FAINT - 1);
}

/// Whether a mark is of one of some kinds.
fn is(marks: &[u8], width: usize, (x, y, side): Mark, kinds: u8) -> bool {
    marks[y * width + x] & kinds << side != 0
}

/// Whether a mark is faint and goes on from a drawn one.
fn goes_on(marks: &[u8], mark: Mark, size: (usize, usize)) -> bool {
    let is = |m: &Mark, kinds| is(marks, size.0, *m, kinds);
    let around = ends(mark, size).map(|end| end.into_iter().flatten().filter(|m| *m != mark));
    if is(&mark, FAINT) {
        return around.into_iter().flatten().any(|m| is(&m, DRAWN));
    }
    let any = DRAWN | FAINT | FAINT_CREASE;
    is(&mark, FAINT_CREASE)
        && around.into_iter().any(|end| {
            let met: Vec<Mark> = end.filter(|m| is(m, any)).collect();
            met.len() == 1 && is(&met[0], CREASE - DRAWN)
        })
}

/// The marks that meet one at each of its two ends, itself among them.
pub(crate) fn ends((x, y, side): Mark, (w, h): (usize, usize)) -> [[Option<Mark>; 4]; 2] {
    // A mark's ends are corners of pixels: the lower right one of its own, and the one above or left.
    let corners = [(x + 1, y + 1), if side == 0 { (x + 1, y) } else { (x, y + 1) }];
    corners.map(|(x, y)| {
        let around = [(x, y, 0), (x, y + 1, 0), (x, y, 1), (x + 1, y, 1)];
        around.map(|(x, y, side)| {
            let inside = (1..=w).contains(&x) && (1..=h).contains(&y);
            inside.then(|| (x - 1, y - 1, side))
        })
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

    #[test]
    fn a_faint_crease_goes_on_from_a_crease_that_ends_and_from_nothing_else() {
        // A line along rows 2 and 3 that gets faint after column 4, and a faint one down from it.
        let (w, h) = (10, 8);
        for drawn in [CREASE, DRAWN] {
            let mut marks = vec![0u8; w * h];
            for x in 0..8 {
                marks[2 * w + x] = if x < 5 { drawn << 1 } else { FAINT_CREASE << 1 };
            }
            for y in 3..7 {
                marks[y * w + 1] = FAINT_CREASE;
            }
            go_on(&mut marks, w);
            let along = (0..8).filter(|x| marks[2 * w + x] == 2).count();
            assert_eq!(along, if drawn == CREASE { 8 } else { 5 });
            assert!((3..7).all(|y| marks[y * w + 1] == 0));
        }
    }
}
