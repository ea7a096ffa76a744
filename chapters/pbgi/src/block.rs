//! Blocks: sixteen surfels in some seven bytes each, and two more for a second side.
//!
//! ```text
//! head, 11 bytes    gain of colours (2), their range (1), that of areas (1), half a box's sides over
//!                   the sphere's radius (3), which surfels have two living sides (2), where
//!                   their second colours begin among the part's (2)
//! surfel, 6 bytes   position in the box 18 bits, normal 2 x 6 (octahedral), area 1,
//!                   colour 17: sum 7, shares of red and green 5 each
//! second, 2 bytes   colour of the other side: sum 6, shares 5 each
//! ```
//!
//! The box is sheared: along the axis that the normals are nearest to it holds heights over the plane across
//! their mean, and the bits of positions go to the sides that are long. So what is flat stays flat in
//! any direction, and has eight or nine bits a coordinate.
//!
//! A surfel whose front is dead is turned over. Sums of colours lie in even steps between the block's least
//! and greatest, in octaves, and so do areas. What rounding takes from a normal, an area or a colour goes to the
//! next surfel, so that a block as a whole keeps its light though each surfel is some percent off.

use crate::bits::{Carry, Hue, float16_above, from_float16, from_grid, grid, octahedral};
use crate::packed::{BLOCK, Places, Record};
use chiaro_basis::math::{Vec3, vec3};
use std::sync::LazyLock;

/// Bytes of a surfel, and of a second side.
pub(crate) const RECORD: usize = 6;
pub(crate) const SECOND: usize = 2;
const HEAD: usize = 11;
/// Bytes of a block without second sides.
pub(crate) const BLOCK_BYTES: usize = HEAD + BLOCK * RECORD;

/// Bits of a position, of a normal's coordinate, of an area, and of a front's sum and a back's.
const PLACE: u32 = 18;
const NORMAL: u32 = 6;
const AREA: u32 = 1;
const SUM: u32 = 7;
const SECOND_SUM: u32 = 6;
/// Where a surfel's bits begin.
const NORMAL_AT: u32 = PLACE;
const AREA_AT: u32 = NORMAL_AT + 2 * NORMAL;
const COLOUR_AT: u32 = AREA_AT + AREA;
/// Units of a sum to a sixteenth of an octave: twice the steps from 1 to the last.
const UNITS: u32 = 252;
/// The last step of a front's sum. A back's goes half as far.
const LAST: u32 = (1 << SUM) - 1;
/// From the middle of the steps of area to the last.
const HALF_AREAS: f32 = 0.5 * ((1 << AREA) - 1) as f32;
/// Steps to an octave between areas, and to one between the ranges of colours.
const AREA_STEPS: f32 = 32.0;
const RANGE_STEPS: f32 = 16.0;
/// Ten octaves: what is darker by more is black, or as bright as that.
const MOST_RANGE: f32 = 10.0 * RANGE_STEPS;
/// How much of the octahedron's radius the mean of normals has to be to make a plane.
const LEAST_MEAN: f32 = 0.25;
/// What a normal may owe the next.
const OWED: f32 = 0.1;

/// How hues are coded.
static HUE: Hue = Hue::new(5);

/// What the records of a block share.
#[derive(Clone, Copy, Debug)]
struct Head {
    gain: f32,
    /// Sixteenths of an octave.
    range: u32,
    areas: f32,
    grid: Grid,
    both: u32,
    second: usize,
}

/// The grid of a block's positions.
#[derive(Clone, Copy, Debug)]
struct Grid {
    bits: [u32; 3],
    step: [f32; 3],
}

/// How the bits of positions are shared out by the lengths in bits of a box's sides.
static SPLITS: LazyLock<[[[[u8; 3]; 9]; 9]; 9]> = LazyLock::new(|| {
    std::array::from_fn(|x| std::array::from_fn(|y| std::array::from_fn(|z| split([x, y, z]))))
});

/// Each bit to the axis whose steps are longest.
fn split(sides: [usize; 3]) -> [u8; 3] {
    let mut bits = [0; 3];
    for _ in 0..PLACE {
        let step = |i: usize| (sides[i] > 0, sides[i] as i32 - i32::from(bits[i]));
        let longest = (1..3).fold(0, |m, i| if step(i) > step(m) { i } else { m });
        bits[longest] += 1;
    }
    bits
}

impl Grid {
    /// By half a box's sides, in `unit`s.
    fn new(sides: [u8; 3], unit: f32) -> Self {
        let [x, y, z] = sides.map(|s| (u8::BITS - s.leading_zeros()) as usize);
        let bits = SPLITS[x][y][z].map(u32::from);
        let step = |i: usize| 2.0 * unit * f32::from(sides[i]) / ((1 << bits[i]) - 1).max(1) as f32;
        Self { bits, step: std::array::from_fn(step) }
    }

    /// The middle of an axis, in steps.
    fn middle(self, axis: usize) -> f32 {
        0.5 * ((1 << self.bits[axis]) - 1) as f32
    }

    /// Where the bits of an axis begin.
    fn at(self, axis: usize) -> u32 {
        self.bits[..axis].iter().sum()
    }

    fn encode(self, place: [f32; 3]) -> u64 {
        (0..3).fold(0, |code, i| {
            let steps = place[i] / self.step[i].max(f32::MIN_POSITIVE) + self.middle(i);
            code | (steps.round().clamp(0.0, 2.0 * self.middle(i)) as u64) << self.at(i)
        })
    }
}

/// The plane through the middle of a block, across the mean of its normals: heights over it along an axis take the
/// place of that axis.
#[derive(Clone, Copy, Debug)]
struct Plane {
    axis: usize,
    /// Along the next axis and the one after it.
    slope: [f32; 2],
}

impl Plane {
    fn new(normal: &[[f32; BLOCK]; 3]) -> Self {
        let mean = normal.map(|mut lanes| {
            let mut half = BLOCK / 2;
            while half > 0 {
                (0..half).for_each(|k| lanes[k] += lanes[k + half]);
                half /= 2;
            }
            lanes[0]
        });
        let axis = (1..3).fold(0, |m, i| if mean[i].abs() > mean[m].abs() { i } else { m });
        let along = |i: usize| -mean[(axis + i) % 3] / mean[axis];
        let agree = mean[axis].abs() > LEAST_MEAN * BLOCK as f32;
        Self { axis, slope: if agree { [along(1), along(2)] } else { [0.0; 2] } }
    }

    fn others(self) -> [usize; 2] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3]
    }

    fn height(self, offset: Vec3) -> [f32; 3] {
        let mut place = offset.to_array();
        let [u, v] = self.others();
        place[self.axis] -= self.slope[0] * place[u] + self.slope[1] * place[v];
        place
    }
}

/// Sums over the gain, by octaves: parts of the range in units.
static COARSE: LazyLock<[f32; 1024]> = LazyLock::new(|| std::array::from_fn(|i| power(64 * i)));
static FINE: LazyLock<[f32; 64]> = LazyLock::new(|| std::array::from_fn(power));

fn power(units: usize) -> f32 {
    (-(units as f64) / f64::from(UNITS) / f64::from(RANGE_STEPS)).exp2() as f32
}

impl Head {
    fn read(bytes: &[u8], radius: f32, top_light: f32) -> Self {
        let two = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        Self {
            gain: from_float16(two(0), top_light),
            range: u32::from(bytes[2]) + 1,
            areas: f32::from(bytes[3]) / AREA_STEPS,
            grid: Grid::new([bytes[4], bytes[5], bytes[6]], radius / 255.0),
            both: two(7).into(),
            second: two(9).into(),
        }
    }

    /// The sum of a step; 0 is black.
    fn sum(&self, step: u32) -> f32 {
        if step == 0 {
            return 0.0;
        }
        // Under 1024 x 64 for any byte.
        let units = (2 * self.range * (LAST - step)) as usize;
        self.gain * COARSE[(units >> 6) & 1023] * FINE[units & 63]
    }

    /// The step of a sum, `by` apart.
    fn step_of(&self, sum: f32, by: u32) -> u32 {
        if sum <= 0.0 || self.gain <= 0.0 {
            return 0;
        }
        let units = -(sum / self.gain).log2() * RANGE_STEPS * UNITS as f32;
        let down = (units / (2 * by * self.range) as f32).round().max(0.0) as u32;
        (LAST / by).saturating_sub(down).max(1)
    }

    fn area(&self, base: f32, step: u32) -> f32 {
        base * (self.areas * (step as f32 - HALF_AREAS)).exp2()
    }
}

fn sum(colour: [f32; 3]) -> f32 {
    colour.iter().sum()
}

/// Writes a block in a sphere, of an area in all; second sides go to `seconds`.
pub(crate) fn encode(
    (centre, radius, area): (Vec3, f32, f32),
    top_light: f32,
    records: &[Record],
    bytes: &mut Vec<u8>,
    seconds: &mut Vec<u8>,
) {
    let start = bytes.len();
    let both = (0..records.len()).filter(|k| records[*k].alive[1]).fold(0, |m, k| m | 1u32 << k);
    let base = area / records.len().max(1) as f32;
    let sides =
        |r: &Record| [sum(r.radiance[0]), if r.alive[1] { sum(r.radiance[1]) } else { 0.0 }];
    let lit = || records.iter().flat_map(sides).filter(|s| *s > 0.0);
    let gain = float16_above(lit().fold(0.0, f32::max), top_light);
    let octaves = (from_float16(gain, top_light) / lit().fold(f32::INFINITY, f32::min)).log2();
    let range = (RANGE_STEPS * octaves).ceil().clamp(1.0, MOST_RANGE) - 1.0;
    let apart = records.iter().map(|r| (r.area / base).log2().abs()).fold(0.0, f32::max);
    // Sums of areas are rounded: what differs by less than that does not differ.
    let areas =
        if apart < 2e-3 { 0.0 } else { (AREA_STEPS * apart / HALF_AREAS).ceil().min(255.0) };
    let normals = normals(records);
    let plane = Plane::new(&unfolded_lanes(&normals.map(|code| code as u32)));
    let height = |r: &Record| Vec3::from(plane.height(r.position - centre));
    let half = records.iter().fold(Vec3::ZERO, |m, r| m.max(height(r).abs()));
    let sides_of_box = half * (255.0 / radius.max(f32::MIN_POSITIVE));
    bytes.extend(gain.to_le_bytes());
    bytes.extend([range as u8, areas as u8]);
    bytes.extend(sides_of_box.to_array().map(|s| s.ceil().clamp(0.0, 255.0) as u8));
    bytes.extend((both as u16).to_le_bytes());
    bytes.extend(((seconds.len() / SECOND) as u16).to_le_bytes());
    let head = Head::read(&bytes[start..], radius, top_light);
    let mut owed = Owed::default();
    for (r, normal) in records.iter().zip(normals) {
        let place = head.grid.encode(height(r).to_array());
        let code = place | normal << NORMAL_AT | owed.encode(&head, base, r);
        bytes.extend(&code.to_le_bytes()[..RECORD]);
        if r.alive[1] {
            let (step, value) = (|sum| head.step_of(sum, 2), |step| head.sum(of_half(step)));
            let code = owed.back.encode(r.radiance[1], (&HUE, SECOND_SUM), step, value);
            seconds.extend((code as u16).to_le_bytes());
        }
    }
    let rest = (normals[BLOCK - 1] << NORMAL_AT).to_le_bytes();
    (records.len()..BLOCK).for_each(|_| bytes.extend(&rest[..RECORD]));
}

/// The front's step that is a back's.
fn of_half(step: u32) -> u32 {
    if step == 0 { 0 } else { 2 * step + 1 }
}

/// The codes of normals. What is missing has the last one.
fn normals(records: &[Record]) -> [u64; BLOCK] {
    let mut owed = Vec3::ZERO;
    let mut last = 0;
    std::array::from_fn(|k| {
        if let Some(r) = records.get(k) {
            let square = octahedral(r.normal + owed).map(|c| grid(c, NORMAL));
            let coded = unfolded(square.map(|c| from_grid(c, NORMAL))).normalize_or(Vec3::Z);
            owed = (owed + r.normal - coded).clamp_length_max(OWED);
            let [x, y] = square.map(u64::from);
            last = x | y << NORMAL;
        }
        last
    })
}

/// What rounding took from the surfels before.
#[derive(Default)]
struct Owed {
    area: f32,
    front: Carry,
    back: Carry,
}

impl Owed {
    /// The bits of an area and a colour.
    fn encode(&mut self, head: &Head, base: f32, r: &Record) -> u64 {
        let wanted = ((r.area + self.area) / base).max(f32::MIN_POSITIVE).log2();
        let step = if head.areas > 0.0 { wanted / head.areas } else { 0.0 };
        let step = (step + HALF_AREAS).round().clamp(0.0, 2.0 * HALF_AREAS) as u32;
        self.area = (self.area + r.area - head.area(base, step)).clamp(-r.area, r.area);
        let (step_of, value) = (|sum| head.step_of(sum, 1), |step| head.sum(step));
        let colour = self.front.encode(r.radiance[0], (&HUE, SUM), step_of, value);
        u64::from(step) << AREA_AT | colour << COLOUR_AT
    }
}

/// The vector of a place on the octahedron's square, of any length.
fn unfolded([x, y]: [f32; 2]) -> Vec3 {
    let z = 1.0 - x.abs() - y.abs();
    let under = (-z).max(0.0);
    vec3(x - under.copysign(x), y - under.copysign(y), z)
}

/// A block's bytes, to be read.
pub(crate) struct Block<'a> {
    bytes: &'a [u8; BLOCK_BYTES],
    head: Head,
    count: usize,
    base: f32,
    places: Places,
    seconds: &'a [u8],
}

impl<'a> Block<'a> {
    /// A block of `count` records in a sphere, of an area in all.
    pub(crate) fn new(
        bytes: &'a [u8],
        seconds: &'a [u8],
        count: usize,
        (centre, radius, area): (Vec3, f32, f32),
        top_light: f32,
    ) -> Self {
        // Of a length that is known, so that places in it need no checks.
        let bytes: &[u8; BLOCK_BYTES] = first(bytes);
        let head = Head::read(bytes, radius, top_light);
        let mut low = [0; BLOCK];
        for (k, code) in low.iter_mut().enumerate() {
            *code = u32::from_le_bytes(*first(&bytes[HEAD + k * RECORD..]));
        }
        let base = area / count.max(1) as f32;
        let places = places(&low, centre, head.grid, head.both);
        Self { bytes, head, count, base, places, seconds }
    }

    /// Calls `each` with the records that `wanted` names in a mask of bits.
    #[inline]
    pub(crate) fn records(&self, wanted: impl Fn(&Places) -> u32, mut each: impl FnMut(&Record)) {
        let mut left = wanted(&self.places) & ((1 << self.count) - 1);
        while left != 0 {
            let k = left.trailing_zeros() as usize;
            left &= left - 1;
            each(&self.record(k));
        }
    }

    fn record(&self, k: usize) -> Record {
        // The last four bytes hold all behind the position.
        let code = u32::from_le_bytes(*first(&self.bytes[HEAD + k * RECORD + 2..]));
        let colour = code >> (COLOUR_AT - 16);
        let two = self.head.both >> k & 1 == 1;
        let lane = |axes: &[[f32; BLOCK]; 3]| vec3(axes[0][k], axes[1][k], axes[2][k]);
        let area = match self.head.areas > 0.0 {
            true => self.head.area(self.base, code >> (AREA_AT - 16) & ((1 << AREA) - 1)),
            false => self.base,
        };
        let front = HUE.colour(colour >> SUM, self.head.sum(colour & LAST));
        let back = if two { self.second(k) } else { [0.0; 3] };
        Record {
            position: lane(&self.places.position),
            normal: lane(&self.places.normal).normalize_or(Vec3::Z),
            area,
            alive: [true, two],
            albedo: [0.0; 3],
            radiance: [front, back],
        }
    }

    fn second(&self, k: usize) -> [f32; 3] {
        let before = (self.head.both & ((1 << k) - 1)).count_ones() as usize;
        let at = SECOND * (self.head.second + before);
        // Forged bytes may name what is not there.
        let code = self.seconds.get(at..at + SECOND).map_or(0, |b| u16::from_le_bytes(*first(b)));
        HUE.colour(
            u32::from(code) >> SECOND_SUM,
            self.head.sum(of_half(u32::from(code) & (LAST >> 1))),
        )
    }
}

/// The first bytes of some; zeros where there are fewer.
#[inline]
fn first<const N: usize>(bytes: &[u8]) -> &[u8; N] {
    bytes.first_chunk().unwrap_or(&[0; N])
}

/// Positions and normals of the records of a block.
#[allow(clippy::needless_range_loop, reason = "lanes are vectors of the processor")]
fn places(codes: &[u32; BLOCK], centre: Vec3, grid: Grid, both: u32) -> Places {
    let normal = unfolded_lanes(&codes.map(|code| code >> NORMAL_AT));
    let plane = Plane::new(&normal);
    let mut position = [[0.0; BLOCK]; 3];
    for (i, lanes) in position.iter_mut().enumerate() {
        let (at, mask, middle, step) =
            (grid.at(i), (1 << grid.bits[i]) - 1, grid.middle(i), grid.step[i]);
        for k in 0..BLOCK {
            lanes[k] = ((codes[k] >> at & mask) as i32 as f32 - middle) * step;
        }
    }
    let [u, v] = plane.others().map(|i| position[i]);
    for k in 0..BLOCK {
        position[plane.axis][k] += plane.slope[0] * u[k] + plane.slope[1] * v[k];
    }
    for (i, lanes) in position.iter_mut().enumerate() {
        lanes.iter_mut().for_each(|x| *x += centre[i]);
    }
    Places { position, normal, both }
}

/// The vectors of codes of normals, of any length.
#[allow(clippy::needless_range_loop, reason = "lanes are vectors of the processor")]
fn unfolded_lanes(codes: &[u32; BLOCK]) -> [[f32; BLOCK]; 3] {
    let [mut nx, mut ny, mut nz] = [[0.0; BLOCK]; 3];
    let half = ((1 << (NORMAL - 1)) - 1) as f32;
    for k in 0..BLOCK {
        let at = |shift: u32| (codes[k] >> shift & ((1 << NORMAL) - 1)) as i32 as f32;
        let x = (at(0) - half) * half.recip();
        let y = (at(NORMAL) - half) * half.recip();
        let z = 1.0 - x.abs() - y.abs();
        let under = (-z).max(0.0);
        nx[k] = x - under.copysign(x);
        ny[k] = y - under.copysign(y);
        nz[k] = z;
    }
    [nx, ny, nz]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packed::{records, tests::sheet};

    /// Records, coded and read.
    fn again(records: &[Record], areas: f32) -> Vec<Record> {
        let low = records.iter().fold(Vec3::INFINITY, |m, r| m.min(r.position));
        let high = records.iter().fold(Vec3::NEG_INFINITY, |m, r| m.max(r.position));
        let ball = (0.5 * (low + high), 0.51 * low.distance(high), areas);
        let (mut bytes, mut seconds) = (Vec::new(), Vec::new());
        encode(ball, 8.0, records, &mut bytes, &mut seconds);
        assert_eq!(bytes.len(), BLOCK_BYTES);
        assert_eq!(seconds.len(), SECOND * records.iter().filter(|r| r.alive[1]).count());
        let block = Block::new(&bytes, &seconds, records.len(), ball, 8.0);
        let mut all = Vec::new();
        block.records(|_| u32::MAX, |r| all.push(*r));
        all
    }

    fn area(records: &[Record]) -> f32 {
        records.iter().map(|r| r.area).sum()
    }

    #[test]
    fn what_a_block_shares_is_exact() {
        let mut all = records(&sheet(16));
        for r in &mut all {
            r.position.y = 0.25;
            r.normal = Vec3::Y;
            r.radiance = [[3.0, 0.0, 0.0], [0.5; 3]];
        }
        for (a, b) in all.iter().zip(again(&all, area(&all))) {
            assert!(
                (a.position.y - b.position.y).abs() < 1e-6 && b.normal.distance(Vec3::Y) < 1e-6
            );
            assert!((a.area / b.area - 1.0).abs() < 1e-3 && b.radiance[0][1] == 0.0);
            let [r, g, b] = b.radiance[1];
            assert!((r - b).abs() < 1e-6 && (r - g).abs() < 1e-6);
        }
    }

    #[test]
    fn what_is_flat_stays_flat_and_finely_placed_in_any_direction() {
        for i in 0..50 {
            let [a, b, c] =
                [0, 1, 2].map(|k| 2.0 * chiaro_basis::random::unit(11, 3 * i + k) - 1.0);
            let normal = vec3(a, b, c).normalize();
            let (across, along) = normal.any_orthonormal_pair();
            let mut all = records(&sheet(16));
            for (k, r) in all.iter_mut().enumerate() {
                let [u, v] = chiaro_basis::random::r2(k as u64);
                r.position = vec3(3.0, -2.0, 5.0) + u * across + v * along;
                r.normal = normal;
                r.alive[0] = true;
            }
            for (a, b) in all.iter().zip(again(&all, area(&all))) {
                let apart = b.position - a.position;
                assert!(apart.dot(normal).abs() < 6e-3, "{normal}: {}", apart.dot(normal));
                assert!(apart.length() < 0.012, "{normal}: {apart}");
            }
        }
    }

    #[test]
    fn bits_go_to_long_sides() {
        assert_eq!(split([8, 8, 8]), [6, 6, 6]);
        assert_eq!(split([8, 1, 8]), [9, 1, 8]);
        assert_eq!(split([0, 8, 0]), [0, 18, 0]);
    }

    #[test]
    fn darkness_stays_dark_and_areas_that_differ_are_right_together() {
        let mut all = records(&sheet(16));
        for (k, r) in all.iter_mut().enumerate() {
            r.area *= if k < 8 { 1.0 } else { 4.0 };
            r.alive = [true; 2];
            let light = if k % 2 == 0 { 0.0 } else { 1.0 + k as f32 };
            r.radiance = [[light; 3], [0.1 * light; 3]];
        }
        let back = again(&all, area(&all));
        assert_eq!(back.len(), all.len());
        for (k, b) in back.iter().enumerate() {
            assert!(k % 2 == 1 || b.radiance == [[0.0; 3]; 2]);
        }
        assert!((area(&all) / area(&back) - 1.0).abs() < 0.15);
    }

    #[test]
    fn any_bytes_are_some_records() {
        let bytes: Vec<u8> =
            (0..BLOCK_BYTES).map(|i| chiaro_basis::random::hash(3, i as u64) as u8).collect();
        for seconds in [&[][..], &[7; 5], &[255; 64]] {
            let block = Block::new(&bytes, seconds, BLOCK, (Vec3::ONE, 2.0, 5.0), 1.0);
            block.records(
                |_| u32::MAX,
                |r| {
                    assert!(
                        r.normal.is_normalized()
                            && r.radiance.as_flattened().iter().all(|l| l.is_finite())
                    )
                },
            );
        }
    }
}
