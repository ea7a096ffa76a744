//! Triangles of an implicit surface.
//!
//! 1. Marching tetrahedra on the body-centred cubic lattice, whose tetrahedra are all alike and
//!    nearly regular (Labelle and Shewchuk 2007 mesh on it, too). No case is ambiguous: the result
//!    is always a closed manifold, if the surface stays inside the box.
//! 2. Cut points keep away from lattice points, so that no triangle starts as a sliver; then
//!    vertices move to the mean of their neighbours and back to the surface, a few times.
//! 3. Normals are the field's gradient, or at thin rims the faces' mean.
//!
//! The field must grow by at most `STEEPEST` a unit, since far blocks are left out on its word.
//! Features finer than a cell may be lost. The result does not depend on threads.

use super::field::value_and_gradient;
use super::form::{Form, angle_weighted_normals};
use super::neighbours::Neighbours;
use crate::Bounds;
use chiaro_basis::math::Vec3;
use rayon::prelude::*;

/// A field: negative inside.
pub(crate) type Field<'a> = &'a (dyn Fn(Vec3) -> f32 + Sync);

/// The greatest slope a field may have.
const STEEPEST: f32 = 1.6;
/// Cells along the edge of a block.
const BLOCK: i32 = 8;
/// How near a cut point may come to a lattice point, in parts of the edge.
const KEEP: f32 = 0.2;

/// Lattice points in halves of a cell: corners are even, centres odd.
type Place = [i32; 3];
/// A cut edge: its two lattice points, in order.
type Cut = (Place, Place);

/// The surface where `field` is 0, inside `bounds`, with triangles about 0.6 `cell` wide.
pub(crate) fn isosurface(bounds: Bounds, cell: f32, field: Field) -> Form {
    let lattice = Lattice { origin: bounds.min, half: 0.5 * cell, field };
    let size = ((bounds.max - bounds.min) / cell).ceil().to_array().map(|n| n as i32 / BLOCK + 1);
    let blocks: Vec<Place> = (0..size[0] * size[1] * size[2])
        .map(|i| [i % size[0], i / size[0] % size[1], i / (size[0] * size[1])])
        .collect();
    let cuts: Vec<Vec<[Cut; 3]>> = blocks.par_iter().map(|&b| lattice.block(b)).collect();
    let cuts = cuts.concat();
    let form = polished(lattice.form(&cuts), field, 0.3 * cell, 3, |_| true);
    form.with_gradient_normals(field, 0.2 * cell)
}

/// Vertices evened out on the surface: `rounds` times to the mean of their neighbours within the
/// tangent plane, and back to the surface. `reach` bounds a step; only points in `zone` move.
pub(crate) fn polished(
    mut form: Form,
    field: Field,
    reach: f32,
    rounds: usize,
    zone: impl Fn(Vec3) -> bool + Sync,
) -> Form {
    let neighbours = Neighbours::of(form.positions.len(), &form.triangles);
    for round in 0..rounds {
        let old = &form.positions;
        let normals = angle_weighted_normals(old, &form.triangles);
        let step = |v: usize| {
            if !zone(old[v]) {
                return old[v];
            }
            let around = neighbours.around(v);
            let mean = around.iter().map(|&n| old[n as usize]).sum::<Vec3>() / around.len() as f32;
            let shift = mean - old[v];
            let slid = old[v] + (shift - normals[v] * shift.dot(normals[v])) * 0.7;
            let near = settled(field, slid, reach);
            if round + 1 == rounds { settled(field, near, reach) } else { near }
        };
        form.positions = (0..old.len()).into_par_iter().map(step).collect();
    }
    form
}

/// A point nearer to the surface than `p`: a step of Newton's method, at most `reach` long.
fn settled(field: Field, p: Vec3, reach: f32) -> Vec3 {
    let (value, slope) = value_and_gradient(field, p, 0.1 * reach);
    let step = slope * (value / slope.length_squared().max(0.05));
    p - step.clamp_length_max(reach)
}

impl Form {
    /// With the field's gradient as normals, taken over `step`; at rims thinner than that, where the
    /// gradient leaves the side of the faces, with the faces' mean.
    pub(crate) fn with_gradient_normals(mut self, field: Field, step: f32) -> Self {
        let faces = angle_weighted_normals(&self.positions, &self.triangles);
        let normal = |(p, face): (&Vec3, &Vec3)| {
            let slope = value_and_gradient(field, *p, step).1.normalize_or(Vec3::Y);
            if slope.dot(*face) > 0.5 { slope } else { *face }
        };
        self.normals = self.positions.par_iter().zip(&faces).map(normal).collect();
        self
    }
}

/// The lattice and what is sampled on it.
struct Lattice<'a> {
    origin: Vec3,
    half: f32,
    field: Field<'a>,
}

impl Lattice<'_> {
    fn at(&self, p: Place) -> Vec3 {
        self.origin + self.half * Vec3::from(p.map(|x| x as f32))
    }

    /// The triangles of one block, as triples of cut edges.
    fn block(&self, block: Place) -> Vec<[Cut; 3]> {
        let first = block.map(|b| 2 * b * BLOCK);
        let middle = self.at(first.map(|f| f + BLOCK + 1));
        let radius = 3f32.sqrt() * self.half * (BLOCK + 2) as f32;
        if (self.field)(middle).abs() > STEEPEST * radius {
            return Vec::new();
        }
        let samples = Samples::of(self, first);
        let mut triangles = Vec::new();
        for i in 0..BLOCK * BLOCK * BLOCK {
            let cell = [i % BLOCK, i / BLOCK % BLOCK, i / (BLOCK * BLOCK)];
            let centre: Place = std::array::from_fn(|k| first[k] + 2 * cell[k] + 1);
            for axis in 0..3 {
                for tetrahedron in four_around(centre, axis) {
                    march(&tetrahedron, &tetrahedron.map(|p| samples.value(p)), &mut triangles);
                }
            }
        }
        triangles
    }

    /// Triples of cut edges as triangles that wind outwards.
    fn form(&self, cuts: &[[Cut; 3]]) -> Form {
        let mut known: Vec<Cut> = cuts.as_flattened().to_vec();
        known.par_sort_unstable();
        known.dedup();
        let point = |&(a, b): &Cut| {
            let (p, q) = (self.at(a), self.at(b));
            let (fp, fq) = ((self.field)(p), (self.field)(q));
            p.lerp(q, (fp / (fp - fq)).clamp(KEEP, 1.0 - KEEP))
        };
        let positions: Vec<Vec3> = known.par_iter().map(point).collect();
        let index = |c: &Cut| known.binary_search(c).expect("every cut is known") as u32;
        let triangles = cuts.par_iter().map(|t| std::array::from_fn(|k| index(&t[k]))).collect();
        Form { positions, normals: Vec::new(), triangles }
    }
}

/// The four tetrahedra round the edge from a centre to the next centre along an axis.
fn four_around(centre: Place, axis: usize) -> [[Place; 4]; 4] {
    let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut next = centre;
    next[axis] += 2;
    let corner = |k: usize| {
        const ROUND: [[i32; 2]; 4] = [[1, 1], [-1, 1], [-1, -1], [1, -1]];
        let mut p = centre;
        p[axis] += 1;
        p[b] += ROUND[k % 4][0];
        p[c] += ROUND[k % 4][1];
        p
    };
    std::array::from_fn(|k| [centre, next, corner(k), corner(k + 1)])
}

/// The field at the lattice points of one block.
struct Samples {
    first: Place,
    values: Vec<f32>,
}

impl Samples {
    /// Corners and centres along each axis.
    const SIDE: i32 = BLOCK + 2;

    fn of(lattice: &Lattice, first: Place) -> Self {
        let n = Self::SIDE;
        let value = |i: i32| {
            let (odd, i) = (i / (n * n * n), i % (n * n * n));
            let cell = [i % n, i / n % n, i / (n * n)];
            let place = std::array::from_fn(|k| first[k] + 2 * cell[k] + odd);
            (lattice.field)(lattice.at(place))
        };
        Self { first, values: (0..2 * n * n * n).map(value).collect() }
    }

    fn value(&self, p: Place) -> f32 {
        let (n, odd) = (Self::SIDE, (p[0] - self.first[0]) & 1);
        let [x, y, z]: [i32; 3] = std::array::from_fn(|k| (p[k] - self.first[k] - odd) / 2);
        self.values[(((odd * n + z) * n + y) * n + x) as usize]
    }
}

/// The one or two triangles in which the surface crosses a tetrahedron.
fn march(places: &[Place; 4], values: &[f32; 4], triangles: &mut Vec<[Cut; 3]>) {
    let (inside, outside): (Vec<usize>, Vec<usize>) = (0..4).partition(|&k| values[k] < 0.0);
    // An even permutation (inside first) keeps the tetrahedron's orientation.
    let order: Vec<usize> = inside.iter().chain(&outside).copied().collect();
    let swaps = (0..4).flat_map(|i| (0..i).map(move |j| (j, i)));
    let odd = swaps.filter(|&(j, i)| order[j] > order[i]).count() % 2 == 1;
    let cut = |a: usize, b: usize| {
        let (p, q) = (places[order[a]], places[order[b]]);
        if p < q { (p, q) } else { (q, p) }
    };
    let polygon: &[(usize, usize)] = match inside.len() {
        1 => &[(0, 1), (0, 2), (0, 3)],
        2 => &[(0, 2), (0, 3), (1, 3), (1, 2)],
        3 => &[(0, 3), (1, 3), (2, 3)],
        _ => return,
    };
    let corners: Vec<Cut> = polygon.iter().map(|&(a, b)| cut(a, b)).collect();
    for k in 1..corners.len() - 1 {
        let [a, b, c] = [corners[0], corners[k], corners[k + 1]];
        triangles.push(if odd { [a, c, b] } else { [a, b, c] });
    }
}
