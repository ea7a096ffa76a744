//! [`Normal`]: normal equations A'WA x = A'Wb of sparse rows, by Cholesky factorization.
//!
//! 1. Unknowns that share a row belong to one part; parts are solved on their own, in parallel.
//! 2. Each part's lower triangle is laid out by columns once, and every product of two coefficients
//!    of a row knows its place there.
//! 3. The factor's pattern (a library's, ordered by minimum degree) is found once. Each factorization
//!    runs on one thread, so that sums have one order.

use crate::rows::Rows;
use chiaro_basis::Sets;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The rows leave an unknown free, or a weight is no finite number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the equations do not determine unknown {unknown}")]
pub struct Singular {
    /// One of the unknowns of the part that has no solution.
    pub unknown: usize,
}

/// The pattern of a problem, factored.
pub struct Normal {
    rows: Rows,
    parts: Vec<Part>,
}

/// Unknowns that hang together.
struct Part {
    /// Its unknowns, rising: local to global.
    unknowns: Vec<u32>,
    /// Its rows.
    rows: Vec<u32>,
    pattern: Arc<Pattern>,
    /// The part that was factored before and has the same left sides.
    same: Option<u32>,
}

/// Where the numbers of some unknowns and rows go.
struct Pattern {
    /// Lower triangle by columns, in local numbers.
    starts: Vec<u32>,
    below: Vec<u32>,
    /// For each row in turn, the local numbers of its unknowns.
    numbers: Vec<u32>,
    /// For each row in turn, for each pair of its entries (i, j <= i), the place of their product.
    places: Vec<u32>,
    symbolic: Option<SymbolicCholesky<u32>>,
}

impl Normal {
    /// Lays out and factors the pattern of some equations.
    pub fn new(rows: &Rows) -> Self {
        Self::after(rows.clone(), None)
    }

    /// The same where equations like these were factored `before`: parts whose pattern they share are not
    /// factored again. Solutions are those that [`Normal::new`] leads to, bit for bit.
    pub fn after(rows: Rows, before: Option<&Self>) -> Self {
        let (members, equations, local) = parts_of(&rows);
        let mut known = Known { rows: before.map(|b| &b.rows), parts: BTreeMap::new() };
        for part in (0..).zip(before.into_iter().flat_map(|b| &b.parts)) {
            known.parts.entry(part.1.size()).or_default().push(part);
        }
        let parts = members.into_par_iter().zip(equations);
        let part = |(unknowns, own)| Part::new(&rows, (unknowns, own), &local, &known);
        let parts = parts.map(part).collect();
        Self { rows, parts }
    }

    /// The equations.
    pub fn rows(&self) -> &Rows {
        &self.rows
    }

    /// How many independent problems there are.
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// Unknowns of one of the independent problems, rising.
    pub fn unknowns_of(&self, part: usize) -> &[u32] {
        &self.parts[part].unknowns
    }

    /// Equations of one of the independent problems, rising.
    pub fn rows_of(&self, part: usize) -> &[u32] {
        &self.parts[part].rows
    }

    /// The independent problem among those `before` whose left sides are those of this one, bit for bit,
    /// its unknowns and equations in the same order.
    pub fn same_before(&self, part: usize) -> Option<usize> {
        self.parts[part].same.map(|p| p as usize)
    }

    /// The unknowns that minimize the sum of weight times (left side - right side) squared.
    pub fn solve(&self, weights: &[f64], right: &[f64]) -> Result<Vec<f64>, Singular> {
        let mut x = vec![0.0; self.rows.unknowns()];
        self.solve_some(weights, right, &vec![true; self.parts.len()], &mut x)?;
        Ok(x)
    }

    /// The same for some of the independent problems; the unknowns of the others stay as they are.
    pub fn solve_some(
        &self,
        weights: &[f64],
        right: &[f64],
        which: &[bool],
        x: &mut [f64],
    ) -> Result<(), Singular> {
        assert!(weights.len() == self.rows.len() && right.len() == self.rows.len());
        assert!(which.len() == self.parts.len() && x.len() == self.rows.unknowns());
        let some: Vec<&Part> =
            self.parts.iter().zip(which).filter(|(_, which)| **which).map(|(p, _)| p).collect();
        let solve = |part: &&Part| part.solve(&self.rows, weights, right);
        let solved: Vec<Result<Vec<f64>, Singular>> = some.par_iter().map(solve).collect();
        for (part, values) in some.into_iter().zip(solved) {
            for (unknown, value) in part.unknowns.iter().zip(values?) {
                x[*unknown as usize] = value;
            }
        }
        Ok(())
    }
}

/// What was factored before: parts with their numbers, by size.
struct Known<'a> {
    rows: Option<&'a Rows>,
    parts: BTreeMap<[usize; 2], Vec<(u32, &'a Part)>>,
}

/// Unknowns and rows of each part, and each unknown's number within its part.
fn parts_of(rows: &Rows) -> (Vec<Vec<u32>>, Vec<Vec<u32>>, Vec<u32>) {
    let mut sets = Sets::new(rows.unknowns());
    for r in 0..rows.len() {
        for pair in rows.row(r).windows(2) {
            sets.join(pair[0].0 as usize, pair[1].0 as usize);
        }
    }
    let (mut part, mut local) = (vec![u32::MAX; sets.len()], vec![0; sets.len()]);
    let mut members: Vec<Vec<u32>> = Vec::new();
    for i in 0..sets.len() as u32 {
        let r = sets.root(i as usize);
        if part[r] == u32::MAX {
            part[r] = members.len() as u32;
            members.push(Vec::new());
        }
        part[i as usize] = part[r];
        let own = &mut members[part[r] as usize];
        local[i as usize] = own.len() as u32;
        own.push(i);
    }
    let mut equations = vec![Vec::new(); members.len()];
    for r in 0..rows.len() {
        if let Some((unknown, _)) = rows.row(r).first() {
            equations[part[*unknown as usize] as usize].push(r as u32);
        }
    }
    (members, equations, local)
}

/// The pairs of entries of a row, each as (column, row) of the lower triangle.
fn pairs<'a>(row: &'a [(u32, f64)], local: &'a [u32]) -> impl Iterator<Item = (u32, u32)> + 'a {
    row.iter().enumerate().flat_map(move |(k, (i, _))| {
        row[..=k].iter().map(move |(j, _)| {
            let (i, j) = (local[*i as usize], local[*j as usize]);
            (i.min(j), i.max(j))
        })
    })
}

/// Where the columns of a lower triangle start and what rows they hold, the diagonal and some pairs
/// of (column, row), each once.
fn triangle<I: Iterator<Item = (u32, u32)>>(
    n: usize,
    pairs: impl Fn() -> I,
) -> (Vec<u32>, Vec<u32>) {
    // Room for all of a column's pairs first.
    let mut ends = vec![1; n];
    pairs().for_each(|(column, _)| ends[column as usize] += 1);
    let mut total = 0;
    for end in &mut ends {
        total += std::mem::replace(end, total);
    }
    let first = ends.clone();
    let mut room = vec![0; total];
    for (column, row) in (0..n as u32).map(|i| (i, i)).chain(pairs()) {
        let end = &mut ends[column as usize];
        room[*end] = row;
        *end += 1;
    }
    let (mut starts, mut below) = (vec![0], Vec::new());
    for (from, to) in first.into_iter().zip(ends) {
        room[from..to].sort_unstable();
        let start = below.len();
        for &row in &room[from..to] {
            if below.len() == start || below[below.len() - 1] != row {
                below.push(row);
            }
        }
        starts.push(below.len() as u32);
    }
    below.shrink_to_fit();
    (starts, below)
}

/// The pattern of the factor of a lower triangle.
fn factored(n: usize, starts: &[u32], below: &[u32]) -> Option<SymbolicCholesky<u32>> {
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, starts, None, below);
    let params = CholeskySymbolicParams::default();
    factorize_symbolic_cholesky(pattern, Side::Lower, SymmetricOrdering::Amd, params).ok()
}

impl Pattern {
    /// Of `n` unknowns and some rows.
    fn new(rows: &Rows, own: &[u32], local: &[u32], n: usize) -> Self {
        let all = || own.iter().flat_map(|r| pairs(rows.row(*r as usize), local));
        let (starts, below) = triangle(n, all);
        let place = |(column, row): (u32, u32)| {
            let [from, to] = [column, column + 1].map(|c| starts[c as usize] as usize);
            let k = below[from..to].binary_search(&row);
            (from + k.expect("the pattern holds every pair")) as u32
        };
        let places = all().map(place).collect();
        let numbers = numbers(rows, own, local).collect();
        let symbolic = factored(n, &starts, &below);
        Self { starts, below, numbers, places, symbolic }
    }
}

/// The local numbers of the unknowns of some rows, one after the other.
fn numbers<'a>(rows: &'a Rows, own: &'a [u32], local: &'a [u32]) -> impl Iterator<Item = u32> + 'a {
    own.iter().flat_map(|r| rows.row(*r as usize)).map(|(i, _)| local[*i as usize])
}

impl Part {
    /// Unknowns and rows.
    fn size(&self) -> [usize; 2] {
        [self.unknowns.len(), self.rows.len()]
    }

    fn new(
        rows: &Rows,
        (unknowns, own): (Vec<u32>, Vec<u32>),
        local: &[u32],
        known: &Known<'_>,
    ) -> Self {
        let of_size = known.parts.get(&[unknowns.len(), own.len()]).map_or(&[][..], Vec::as_slice);
        let alike = |p: &Self| {
            let lengths = own.iter().zip(&p.rows);
            let others = known.rows;
            lengths.into_iter().all(|(r, s)| {
                others.is_some_and(|o| rows.row(*r as usize).len() == o.row(*s as usize).len())
            }) && numbers(rows, &own, local).eq(p.pattern.numbers.iter().copied())
        };
        let equal = |p: &Self| {
            let coefficients = |rows: &Rows, own: &[u32]| -> Vec<f64> {
                own.iter().flat_map(|r| rows.row(*r as usize)).map(|e| e.1).collect()
            };
            known.rows.is_some_and(|o| coefficients(rows, &own) == coefficients(o, &p.rows))
        };
        let alike: Vec<&(u32, &Self)> = of_size.iter().filter(|(_, p)| alike(p)).collect();
        let same = alike.iter().find(|(_, p)| equal(p)).map(|(number, _)| *number);
        let pattern = match alike.first() {
            Some((_, part)) => part.pattern.clone(),
            None => Arc::new(Pattern::new(rows, &own, local, unknowns.len())),
        };
        Self { unknowns, rows: own, pattern, same }
    }

    fn solve(&self, rows: &Rows, weights: &[f64], right: &[f64]) -> Result<Vec<f64>, Singular> {
        let singular = Singular { unknown: self.unknowns[0] as usize };
        let (values, mut x) = self.assembled(rows, weights, right);
        let finite = values.iter().chain(&x).all(|v| v.is_finite());
        let Pattern { starts, below, symbolic, .. } = &*self.pattern;
        let symbolic = symbolic.as_ref().filter(|_| finite).ok_or(singular)?;
        let n = x.len();
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, starts, None, below);
        let matrix = SparseColMatRef::new(pattern, values.as_slice());
        let mut factor = vec![0.0; symbolic.len_val()];
        let request = symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let mut memory = MemBuffer::try_new(request).map_err(|_| singular)?;
        let stack = MemStack::new(&mut memory);
        let llt = symbolic
            .factorize_numeric_llt(
                &mut factor,
                matrix,
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                stack,
                Default::default(),
            )
            .map_err(|_| singular)?;
        let column = MatMut::from_column_major_slice_mut(&mut x, n, 1);
        llt.solve_in_place_with_conj(Conj::No, column, Par::Seq, stack);
        if x.iter().all(|v| v.is_finite()) { Ok(x) } else { Err(singular) }
    }

    /// The lower triangle of A'WA, and A'Wb.
    fn assembled(&self, rows: &Rows, weights: &[f64], right: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let Pattern { below, places, numbers, .. } = &*self.pattern;
        let mut values = vec![0.0; below.len()];
        let mut x = vec![0.0; self.unknowns.len()];
        let (mut places, mut numbers) = (places.iter(), numbers.iter());
        for &r in &self.rows {
            let (row, weight) = (rows.row(r as usize), weights[r as usize]);
            for ((k, (_, a)), number) in row.iter().enumerate().zip(numbers.by_ref()) {
                for ((_, b), place) in row[..=k].iter().zip(places.by_ref()) {
                    values[*place as usize] += weight * a * b;
                }
                x[*number as usize] += weight * a * right[r as usize];
            }
        }
        (values, x)
    }
}
