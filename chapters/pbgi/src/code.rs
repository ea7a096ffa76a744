//! [`Book`]: few bytes that stand for a node's lobes (thesis, 6.5.1).
//!
//! A node's 27 numbers of light and 9 of area are coded in the same few steps, which a [`Recipe`]
//! chooses:
//!
//! 1. *Scale*: the thesis clusters the sums themselves; they grow with the subtree, so that a
//!    clustering sees the large nodes alone. Divided by the node's area, which is kept, they do not.
//! 2. *Frame*: lobes are turned so that the node's mean normal is the z axis. Nodes that differ by
//!    where they face alone become the same. Turning the direction of a query undoes it.
//! 3. *Gains*: the length of the light, or of each colour's, as 16-bit floating-point numbers.
//! 4. *Stages*: the nearest of a table's words; the nearest of a second table's words to what is
//!    left; and so on. Tables come from k-means on the nodes of a sparse tree. One stage without the rest is
//!    the thesis's look-up table; several are residual vector quantization. Words without gains are
//!    learned from darker copies of nodes too (`dimmed.rs`).
//!
//! Light and area have tables of their own. Black is coded without error. Of the area over the node's area
//! only what its mean normal does not tell ([`harmonic::expected`]) is coded: it is nothing where the
//! node is flat, and always nothing in bands 0 and 1.

use crate::bits::float16;
pub use crate::decode::Decoded;
use crate::dimmed::dimmed;
use crate::harmonic::{self, Sh};
use crate::payload::Exact;
use crate::recipe::word_bytes;
pub use crate::recipe::{Gains, Recipe, Words};
use chiaro_basis::math::{Mat3, Vec3};
use chiaro_basis::random::hash;
use chiaro_basis::{Result, Run};
use chiaro_solve::{KMeans, Nearest, Scratch, Start, k_means};
use std::sync::OnceLock;

/// Numbers of a node's area, and of its light.
pub(crate) const AREA: usize = 9;
pub(crate) const LIGHT: usize = 3 * AREA;
/// Rounds of k-means.
const ROUNDS: usize = 10;
/// Copies of training nodes at other gains for each word that has none.
const COPIES: usize = 2;
/// How much brighter than all training nodes others may be.
pub const HEADROOM: f32 = 4096.0;

/// A node to be coded.
#[derive(Clone, Copy, Debug)]
pub struct Lobes<'a> {
    /// The sums.
    pub sums: &'a Exact,
    /// The summed area, whichever sides live.
    pub area: f32,
    /// The mean normal, as the decoder will know it.
    pub axis: Vec3,
    /// The share of the area both of whose sides live, as the decoder will know it.
    pub both: f32,
}

impl<'a> Lobes<'a> {
    /// A node whose decoder will know all of it exactly.
    pub fn new(sums: &'a Exact, area: f32, axis: Vec3) -> Self {
        Self { sums, area, axis, both: both(sums, area) }
    }
}

/// The share of an area both of whose sides live, by its lobe.
pub(crate) fn both(sums: &Exact, area: f32) -> f32 {
    let sides = sums.area[0] / harmonic::disc(Vec3::Z, 1.0)[0];
    if area > 0.0 { (sides / area - 1.0).clamp(0.0, 1.0) } else { 0.0 }
}

/// The words of one stage. Numbers are the upper halves of floats: what rounding takes is left for the
/// next stage.
#[derive(Clone, Debug)]
pub struct Table {
    numbers: Vec<u16>,
    dim: usize,
    /// Words.
    len: usize,
    /// Made when a word is first searched for.
    index: OnceLock<Nearest>,
}

impl Table {
    /// Words of `dim` numbers, rounded.
    pub fn new(words: &[f32], dim: usize) -> Self {
        Self::of_halves(words.iter().map(|v| upper(*v)).collect(), dim)
    }

    /// Words of `dim` upper halves.
    pub(crate) fn of_halves(numbers: Vec<u16>, dim: usize) -> Self {
        let len = numbers.len() / dim.max(1);
        Self { numbers, dim, len, index: OnceLock::new() }
    }

    /// All words, one after the other.
    pub(crate) fn halves(&self) -> &[u16] {
        &self.numbers
    }

    /// The word nearest to a vector.
    fn find(&self, vector: &[f32], hint: Option<u32>, scratch: &mut Scratch) -> Option<u32> {
        let index = self.index.get_or_init(|| {
            let words: Vec<f32> = self.numbers.iter().map(|n| whole(*n)).collect();
            Nearest::new(&words, self.dim)
        });
        index.find(vector, hint, scratch).map(|found| found.index)
    }

    fn word(&self, index: usize) -> &[u16] {
        let at = index.min(self.len.saturating_sub(1)) * self.dim;
        self.numbers.get(at..at + self.dim).unwrap_or(&[])
    }

    /// Adds a word to a sum that is as long or longer.
    #[inline]
    pub(crate) fn add<const N: usize>(&self, index: usize, sum: &mut [f32; N]) {
        let word = self.word(index);
        match word.first_chunk::<N>() {
            Some(word) => {
                // Eight at a time, so that the compiler uses vectors.
                let ((sums, last), (words, rest)) =
                    (sum.as_chunks_mut::<8>(), word.as_chunks::<8>());
                for (sums, words) in sums.iter_mut().zip(words) {
                    (0..8).for_each(|k| sums[k] += whole(words[k]));
                }
                last.iter_mut().zip(rest).for_each(|(s, w)| *s += whole(*w));
            }
            None => sum.iter_mut().zip(word).for_each(|(s, w)| *s += whole(*w)),
        }
    }

    /// Takes a word from a vector.
    fn take(&self, index: usize, vector: &mut [f32]) {
        vector.iter_mut().zip(self.word(index)).for_each(|(v, w)| *v -= whole(*w));
    }

    /// Words.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no word.
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// Bytes; what searches is as large as the words in floats.
    fn size(&self) -> usize {
        let searched = if self.index.get().is_some() { 4 } else { 0 };
        (2 + searched) * self.numbers.len()
    }
}

/// The upper half of a float that is nearest to it.
fn upper(value: f32) -> u16 {
    let bits = value.to_bits();
    ((bits.saturating_add(0x7fff + (bits >> 16 & 1))) >> 16) as u16
}

/// The float of an upper half.
#[inline]
pub(crate) fn whole(upper: u16) -> f32 {
    f32::from_bits(u32::from(upper) << 16)
}

/// Tables of words for the lobes of nodes.
#[derive(Clone, Debug)]
pub struct Book {
    /// How it codes.
    pub recipe: Recipe,
    /// The greatest gain, in the units of the light.
    pub top: f32,
    /// The stages of light.
    pub light: Vec<Table>,
    /// The stages of area.
    pub area: Vec<Table>,
}

/// Memory that encoding uses again and again.
#[derive(Default)]
pub struct Pen {
    scratch: Scratch,
    hints: Vec<Option<u32>>,
}

impl Book {
    /// A book trained on nodes; `seed` chooses where k-means begins.
    pub fn train(nodes: &[Lobes], recipe: &Recipe, seed: u64, run: &Run) -> Result<Self> {
        let parts: Vec<Parts> = nodes.iter().map(|n| Parts::of(n, recipe)).collect();
        let top = parts.iter().flat_map(|p| p.gains).fold(0.0, f32::max);
        let lit = parts.iter().filter(|p| p.light.iter().any(|l| *l != 0.0));
        let dim = recipe.gains.dim();
        let mut light: Vec<f32> = lit.flat_map(|p| p.light.into_iter().take(dim)).collect();
        if recipe.gains == Gains::None && recipe.words == Words::Clustered {
            let copies = COPIES * recipe.light.iter().sum::<usize>();
            light.extend(dimmed(&light, dim, copies, seed));
        }
        let mut area: Vec<f32> = parts.iter().flat_map(|p| p.area).collect();
        drop(parts);
        let zero = recipe.gains == Gains::None;
        Ok(Self {
            recipe: recipe.clone(),
            top: if top > 0.0 { HEADROOM * top } else { 1.0 },
            light: stages(&mut light, dim, &recipe.light, zero, recipe.words, seed, run)?,
            area: stages(&mut area, AREA, &recipe.area, false, recipe.words, !seed, run)?,
        })
    }

    /// Writes the code of a node, [`Recipe::bytes`] long.
    pub fn encode(&self, node: &Lobes, code: &mut Vec<u8>, pen: &mut Pen) {
        let mut parts = Parts::of(node, &self.recipe);
        for gain in &parts.gains[..self.recipe.gains.count()] {
            code.extend(float16(*gain, self.top).to_le_bytes());
        }
        pen.hints.resize(self.light.len() + self.area.len(), None);
        let Pen { scratch, hints } = pen;
        let (of_light, of_area) = hints.split_at_mut(self.light.len());
        let light = &mut parts.light[..self.recipe.gains.dim()];
        staged(&self.light, &self.recipe.light, light, code, of_light, scratch);
        staged(&self.area, &self.recipe.area, &mut parts.area, code, of_area, scratch);
    }

    /// Squares of a node's error and of its light, over all directions and colours.
    pub fn error(&self, node: &Lobes, pen: &mut Pen) -> [f64; 2] {
        let mut code = Vec::with_capacity(32);
        self.encode(node, &mut code, pen);
        let own = self.decode(&code, (node.area, node.axis, node.both));
        let mut truth = node.sums.light;
        if own.local_from_world.is_some() {
            let frame = frame(node.axis);
            truth.iter_mut().for_each(|sh| *sh = turned(sh, &frame));
        }
        let pairs = own.lobes.light.as_flattened().iter().zip(truth.as_flattened());
        pairs.fold([0.0; 2], |[wrong, there], (a, b)| {
            [wrong + f64::from(a - b).powi(2), there + f64::from(*b).powi(2)]
        })
    }

    /// Words of all tables.
    pub fn words(&self) -> usize {
        self.light.iter().chain(&self.area).map(Table::len).sum()
    }

    /// Bytes of the tables.
    pub fn size(&self) -> usize {
        self.light.iter().chain(&self.area).map(Table::size).sum()
    }

    /// The same without what searches for words.
    #[must_use]
    pub fn to_be_read(&self) -> Self {
        let bare = |t: &Table| Table::of_halves(t.numbers.clone(), t.dim);
        let all = |tables: &[Table]| tables.iter().map(bare).collect();
        let (recipe, top) = (self.recipe.clone(), self.top);
        Self { recipe, top, light: all(&self.light), area: all(&self.area) }
    }
}

/// The tables of all stages; `points` become what the last stage leaves.
fn stages(
    points: &mut [f32],
    dim: usize,
    words: &[usize],
    zero: bool,
    source: Words,
    seed: u64,
    run: &Run,
) -> Result<Vec<Table>> {
    let mut tables = Vec::new();
    for (stage, &count) in words.iter().enumerate() {
        let start = match source {
            Words::FromRandom => Start::Random,
            _ => Start::Spread,
        };
        let how = KMeans { count: count - usize::from(zero), rounds: ROUNDS, seed, start };
        let mut centres = if zero { vec![0.0; dim] } else { Vec::new() };
        centres.extend(match source {
            Words::Drawn => drawn(points, dim, how.count, seed),
            _ => k_means(points, dim, how, run)?.centres,
        });
        if centres.is_empty() {
            centres = vec![0.0; dim];
        }
        let table = Table::new(&centres, dim);
        if stage + 1 < words.len() {
            let mut scratch = Scratch::default();
            for point in points.chunks_exact_mut(dim) {
                if let Some(found) = table.find(point, None, &mut scratch) {
                    table.take(found as usize, point);
                }
            }
        }
        tables.push(table);
    }
    Ok(tables)
}

/// Points drawn with repetition.
fn drawn(points: &[f32], dim: usize, count: usize, seed: u64) -> Vec<f32> {
    let there = (points.len() / dim).max(1) as u64;
    let point = |i: usize| {
        let at = (hash(seed, i as u64) % there) as usize * dim;
        points.get(at..at + dim).unwrap_or(&[]).to_vec()
    };
    (0..count.min(points.len() / dim)).flat_map(point).collect()
}

/// Codes a vector stage by stage; it becomes what is left.
fn staged(
    tables: &[Table],
    words: &[usize],
    vector: &mut [f32],
    code: &mut Vec<u8>,
    hints: &mut [Option<u32>],
    scratch: &mut Scratch,
) {
    for ((table, words), hint) in tables.iter().zip(words).zip(hints) {
        *hint = table.find(vector, *hint, scratch);
        let index = hint.unwrap_or(0);
        table.take(index as usize, vector);
        code.extend(&index.to_le_bytes()[..word_bytes(*words)]);
    }
}

/// A node's lobes as they are clustered.
struct Parts {
    gains: [f32; 3],
    light: [f32; LIGHT],
    area: [f32; AREA],
}

impl Parts {
    fn of(node: &Lobes, recipe: &Recipe) -> Self {
        let scale = match recipe.by_area {
            true if node.area > 0.0 => 1.0 / node.area,
            true => 0.0,
            false => 1.0,
        };
        let turn = recipe.turned.then(|| frame(node.axis));
        let put = |sh: &Sh| turn.as_ref().map_or(*sh, |t| turned(sh, t)).map(|v| v * scale);
        let colours = node.sums.light.each_ref().map(put);
        let told = expected(recipe, node.axis, node.both, turn.as_ref());
        let mut area = put(&node.sums.area);
        area.iter_mut().zip(told).for_each(|(a, t)| *a -= t);
        let square = |sh: &Sh| sh.iter().map(|v| v * v).sum::<f32>();
        let gains = match recipe.gains {
            Gains::None => [1.0; 3],
            Gains::One => [colours.iter().map(square).sum::<f32>().sqrt(); 3],
            Gains::Colours => colours.each_ref().map(|c| square(c).sqrt()),
            Gains::Shape => {
                let (light, gains) = shape(&colours);
                return Self { gains, light, area };
            }
        };
        let mut light = [0.0; LIGHT];
        for c in 0..3 {
            let over = if gains[c] > 0.0 { 1.0 / gains[c] } else { 0.0 };
            (0..9).for_each(|i| light[9 * c + i] = colours[c][i] * over);
        }
        Self { gains, light, area }
    }
}

/// What is known of a node's lobe of area over its area; nothing where sums are coded as they are.
pub(crate) fn expected(
    recipe: &Recipe,
    axis: Vec3,
    both: f32,
    world_from_local: Option<&Mat3>,
) -> Sh {
    if !recipe.by_area {
        return [0.0; AREA];
    }
    let axis = world_from_local.map_or(axis, |f| f.transpose() * axis);
    harmonic::expected(axis, both)
}

/// The shape of length 1 that colours share, and the part of each along it, never negative.
fn shape(colours: &[Sh; 3]) -> ([f32; LIGHT], [f32; 3]) {
    let mut light = [0.0; LIGHT];
    let sum: Sh = std::array::from_fn(|i| colours.iter().map(|c| c[i]).sum());
    let length = sum.iter().map(|v| v * v).sum::<f32>().sqrt();
    if length > 0.0 {
        (0..AREA).for_each(|i| light[i] = sum[i] / length);
    }
    let along = |c: &Sh| c.iter().zip(&light).map(|(a, b)| a * b).sum::<f32>().max(0.0);
    let gains = colours.each_ref().map(along);
    (light, gains)
}

/// A frame whose z axis is a direction, without branches (Duff et al. 2017); the world's where there is none.
pub(crate) fn frame(axis: Vec3) -> Mat3 {
    let Some(n) = axis.try_normalize() else { return Mat3::IDENTITY };
    let sign = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    let x = Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    let y = Vec3::new(b, sign + n.y * n.y * a, -n.y);
    Mat3::from_cols(x, y, n)
}

/// The series in a frame: band by band, as a number, a vector and a symmetric matrix.
pub(crate) fn turned(sh: &Sh, world_from_local: &Mat3) -> Sh {
    const A: f32 = 1.092_548_4;
    const B: f32 = 0.315_391_57;
    let m = world_from_local.transpose();
    let v = m * Vec3::new(sh[3], sh[1], sh[2]);
    let (xy, yz, xz) = (0.5 * A * sh[4], 0.5 * A * sh[5], 0.5 * A * sh[7]);
    let (zz, d) = (2.0 * B * sh[6], 0.5 * A * sh[8]);
    let q = Mat3::from_cols(
        Vec3::new(d - 0.5 * zz, xy, xz),
        Vec3::new(xy, -d - 0.5 * zz, yz),
        Vec3::new(xz, yz, zz),
    );
    let q = m * q * *world_from_local;
    let [x, y, z] = [q.x_axis, q.y_axis, q.z_axis];
    [
        sh[0],
        v.y,
        v.z,
        v.x,
        2.0 * x.y / A,
        2.0 * y.z / A,
        z.z / (2.0 * B),
        2.0 * x.z / A,
        (x.x - y.y) / A,
    ]
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use chiaro_basis::random::unit;

    /// Nodes of a few discs each.
    pub(crate) fn nodes(count: u64) -> Vec<(Exact, f32, Vec3)> {
        let v = |k: u64, i: u64| {
            Vec3::new(unit(k, i) - 0.5, unit(k + 1, i) - 0.5, unit(k + 2, i) - 0.5)
        };
        let node = |i: u64| {
            let mut sums = Exact::default();
            let (mut area, mut axis) = (0.0, Vec3::ZERO);
            let about = v(10, i).normalize_or(Vec3::Z);
            for j in 0..4 {
                let normal = (about + 0.4 * v(20, 4 * i + j)).normalize_or(Vec3::Z);
                let a = 0.5 + unit(30, 4 * i + j);
                let black = i.is_multiple_of(4);
                let light = [1, 2, 3].map(|c| if black { 0.0 } else { unit(c + 40, i) * 3.0 });
                let surfel = crate::Surfel {
                    normal,
                    area: a,
                    alive: [true, false],
                    radiance: [light, [0.0; 3]],
                    ..Default::default()
                };
                sums.add(&surfel);
                area += a;
                axis += normal * a;
            }
            (sums, area, axis / area)
        };
        (0..count).map(node).collect()
    }

    pub(crate) fn lobes(all: &[(Exact, f32, Vec3)]) -> Vec<Lobes<'_>> {
        all.iter().map(|(sums, area, axis)| Lobes::new(sums, *area, *axis)).collect()
    }

    fn error(book: &Book, all: &[Lobes]) -> f64 {
        let (mut wrong, mut there) = (0.0, 0.0);
        let mut pen = Pen::default();
        for node in all {
            let mut code = Vec::new();
            book.encode(node, &mut code, &mut pen);
            assert_eq!(code.len(), book.recipe.bytes());
            let back = book.decode(&code, (node.area, node.axis, node.both));
            for i in 0..20 {
                let d = Vec3::new(unit(7, i) - 0.5, unit(8, i) - 0.5, unit(9, i) - 0.5).normalize();
                let (a, b) =
                    (back.sent(d), crate::Payload::sent(node.sums, &(), &harmonic::basis(d)));
                wrong += f64::from((a.light[1] - b.light[1]).powi(2) + (a.area - b.area).powi(2));
                there += f64::from(b.light[1].powi(2) + b.area.powi(2));
            }
        }
        (wrong / there).sqrt()
    }

    #[test]
    fn more_words_and_more_stages_are_nearer() {
        let all = nodes(1500);
        let all = lobes(&all);
        let of =
            |recipe: &Recipe| error(&Book::train(&all, recipe, 1, &Run::default()).unwrap(), &all);
        let few = of(&Recipe::clusters(16));
        let many = of(&Recipe::clusters(300));
        let random = of(&Recipe { words: Words::Drawn, ..Recipe::clusters(300) });
        let staged = of(&Recipe::residual(Gains::One, false, 2, 2));
        let turned = of(&Recipe::residual(Gains::Colours, true, 2, 2));
        let shapes = of(&Recipe::shapes(300, 300));
        assert!(many < few && many < random, "{few} {many} {random}");
        assert!(staged < many && turned < staged, "{many} {staged} {turned}");
        assert!(shapes < many, "{shapes}");
    }

    #[test]
    fn black_stays_black() {
        let all = nodes(400);
        let all = lobes(&all);
        for recipe in [Recipe::clusters(64), Recipe::residual(Gains::One, true, 2, 2)] {
            let book = Book::train(&all, &recipe, 1, &Run::default()).unwrap();
            let mut code = Vec::new();
            book.encode(&all[0], &mut code, &mut Pen::default());
            assert_eq!(
                book.decode(&code, (all[0].area, all[0].axis, all[0].both)).lobes.light,
                [[0.0; 9]; 3]
            );
        }
    }

    #[test]
    fn a_turned_series_has_the_same_values_in_turned_directions() {
        let sh: Sh = std::array::from_fn(|i| (i as f32 * 1.7).sin());
        for i in 0..20 {
            let v = |k| Vec3::new(unit(k, i) - 0.5, unit(k + 1, i) - 0.5, unit(k + 2, i) - 0.5);
            let (world, local) = (frame(v(1)), v(5).normalize());
            assert!((world.determinant() - 1.0).abs() < 1e-5);
            let there = harmonic::evaluate(&turned(&sh, &world), &harmonic::basis(local));
            let here = harmonic::evaluate(&sh, &harmonic::basis(world * local));
            assert!((there - here).abs() < 1e-5, "{there} {here}");
        }
    }
}
