//! The grid as planes of plain rows, the form the pre-pass sweeps.
//!
//! Every picture row is nine rows of values: the excess, then for each link (east, south-east,
//! south, south-west) the capacity, then for each link the flow over it. They live at the end of
//! the memory of the records that [`crate::residual`] makes of them: records are written from the
//! front, a record has ten values to a pixel's nine, and so no row is overwritten before it is read.

use crate::capacity::Capacity;
use crate::grid::Grid;
use crate::parts;
use crate::residual::framed;
use std::ops::Range;

/// Values of a record: eight residuals, the excess, the incoming arcs.
pub(crate) const RECORD: usize = 10;
/// Values of a pixel in the planes.
pub(crate) const PLANES: usize = 9;

/// The planes at the end of a framed grid of records.
pub(crate) struct Planes<C> {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) records: Vec<[C; RECORD]>,
    /// Where in the values of `records` the planes begin.
    pub(crate) start: usize,
    /// What no cut avoids: the smaller terminal of each pixel.
    pub(crate) direct: i64,
    /// All positive excess.
    pub(crate) supply: i64,
}

/// One picture row of the planes.
pub(crate) struct Row<'a, C> {
    pub(crate) excess: &'a mut [C],
    pub(crate) capacity: [&'a mut [C]; 4],
    pub(crate) flow: [&'a mut [C]; 4],
}

/// Splits the values of a picture row, `width` a plane.
pub(crate) fn split<C>(values: &mut [C], width: usize) -> Row<'_, C> {
    let mut planes = values.chunks_exact_mut(width);
    let mut next = || planes.next().expect("a row holds nine planes");
    let excess = next();
    let capacity = [next(), next(), next(), next()];
    Row { excess, capacity, flow: [next(), next(), next(), next()] }
}

impl<C: Capacity> Planes<C> {
    /// Reads a checked grid; `None` if it holds larger capacities than the type takes.
    pub(crate) fn read(grid: &Grid, threads: usize) -> Option<Self> {
        let (width, height) = (grid.width, grid.height);
        let framed = framed(width, height);
        let records = vec![[C::default(); RECORD]; framed];
        let start = framed * RECORD - width * height * PLANES;
        let mut planes = Self { width, height, records, start, direct: 0, supply: 0 };
        let read = |(rows, values)| read_rows(grid, rows, values);
        for sums in parts::each(planes.bands(threads, 1), read) {
            let [direct, supply] = sums?;
            planes.direct += direct;
            planes.supply += supply;
        }
        Some(planes)
    }

    /// The picture rows in one band a thread, each a multiple of `step` high, and their values.
    pub(crate) fn bands(&mut self, threads: usize, step: usize) -> Vec<(Range<usize>, &mut [C])> {
        let (length, ranges) = (self.width * PLANES, parts::ranges(self.height, threads, step));
        let mut rest = self.values();
        let band = |rows: Range<usize>| {
            let (values, others) = std::mem::take(&mut rest).split_at_mut(rows.len() * length);
            rest = others;
            (rows, values)
        };
        ranges.into_iter().map(band).collect()
    }

    /// All values, picture row by picture row.
    pub(crate) fn values(&mut self) -> &mut [C] {
        &mut self.records.as_flattened_mut()[self.start..]
    }
}

/// Reads some rows into their values; the sums of what no cut avoids and of positive excess.
fn read_rows<C: Capacity>(grid: &Grid, rows: Range<usize>, values: &mut [C]) -> Option<[i64; 2]> {
    let length = grid.width * PLANES;
    let mut nodes = [vec![C::default(); grid.width + 2], vec![C::default(); grid.width + 2]];
    read_nodes(grid, rows.start, &mut nodes[1]);
    let mut sums = [0; 2];
    for (y, values) in rows.zip(values.chunks_exact_mut(length.max(1))) {
        nodes.swap(0, 1);
        read_nodes(grid, y + 1, &mut nodes[1]);
        let row = read_row(grid, y, &nodes, split(values, grid.width))?;
        sums = [sums[0] + row[0], sums[1] + row[1]];
    }
    Some(sums)
}

fn read_row<C: Capacity>(
    grid: &Grid,
    y: usize,
    nodes: &[Vec<C>; 2],
    row: Row<C>,
) -> Option<[i64; 2]> {
    let pixels = y * grid.width..(y + 1) * grid.width;
    let (terminal, neighbour) = (&grid.terminal[pixels.clone()], &grid.neighbour[pixels]);
    read_capacities(neighbour, nodes, row.capacity)?;
    let mut sums = [0; 2];
    for (x, (excess, &[white, black])) in row.excess.iter_mut().zip(terminal).enumerate() {
        if nodes[0][x + 1] == C::default() {
            continue;
        }
        let difference = bounded::<C>(grid, x, y, white - black)?;
        sums[0] += i64::from(white.min(black));
        sums[1] += i64::from(difference.max(0));
        *excess = C::of(difference);
    }
    Some(sums)
}

/// The difference of the terminals of pixel (x, y), kept to what may ever flow through the pixel and
/// one more if the type does not take it; `None` if it does not take that either.
pub(crate) fn bounded<C: Capacity>(
    grid: &Grid,
    x: usize,
    y: usize,
    difference: i32,
) -> Option<i32> {
    if difference.abs() <= C::LIMIT {
        return Some(difference);
    }
    let reach = reach(grid, x, y) + 1;
    (reach <= C::LIMIT).then(|| difference.clamp(-reach, reach))
}

/// Marks the pixels of row `y` with all bits set if they are nodes, framed by one pixel; a row
/// below the picture has none.
fn read_nodes<C: Capacity>(grid: &Grid, y: usize, nodes: &mut [C]) {
    let start = y * grid.width;
    let nodes = &mut nodes[1..=grid.width];
    match grid.mask.get(start..start + grid.width) {
        Some(mask) => nodes.iter_mut().zip(mask).for_each(|(n, &m)| *n = C::of(-i32::from(m))),
        None => nodes.fill(C::default()),
    }
}

/// Reads the four capacities of each pixel of a row, zero where a link has no node on one side.
fn read_capacities<C: Capacity>(
    neighbour: &[[i32; 4]],
    nodes: &[Vec<C>; 2],
    [east, south_east, south, south_west]: [&mut [C]; 4],
) -> Option<()> {
    let width = neighbour.len();
    let (here, below) = (&nodes[0][..width + 2], &nodes[1][..width + 2]);
    let (east, south_east) = (&mut east[..width], &mut south_east[..width]);
    let (south, south_west) = (&mut south[..width], &mut south_west[..width]);
    let mut bits = 0;
    for x in 0..width {
        let [e, se, s, sw] = neighbour[x];
        bits |= e | se | s | sw;
        east[x] = C::of(e) & here[x + 1] & here[x + 2];
        south_east[x] = C::of(se) & here[x + 1] & below[x + 2];
        south[x] = C::of(s) & here[x + 1] & below[x + 1];
        south_west[x] = C::of(sw) & here[x + 1] & below[x];
    }
    (bits <= C::LIMIT).then_some(())
}

/// The sum of all neighbour capacities that pixel (x, y) may have: no more can flow through it.
fn reach(grid: &Grid, x: usize, y: usize) -> i32 {
    let at = |dx: isize, dy: isize, link: usize| {
        let (x, y) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
        let inside = x < grid.width && y < grid.height;
        if inside { grid.neighbour[y * grid.width + x][link] } else { 0 }
    };
    let away = (0..4).map(|link| at(0, 0, link)).sum::<i32>();
    away + at(-1, 0, 0) + at(-1, -1, 1) + at(0, -1, 2) + at(1, -1, 3)
}
