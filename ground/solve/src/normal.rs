//! [`Normal`]: normal equations A'WA x = A'Wb of sparse rows, by Cholesky factorization.
//!
//! 1. Unknowns that share a row belong to one part; parts are solved on their own, in parallel.
//! 2. Each part's lower triangle is laid out by columns once, and every product of two coefficients
//!    of a row knows its place there.
//! 3. The factor's pattern (a library's, ordered by minimum degree) is found once. Each factorization
//!    runs on one thread, so that sums have one order.

use crate::rows::Rows;
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
    /// Lower triangle by columns, in local numbers.
    starts: Vec<usize>,
    below: Vec<usize>,
    /// For each row in turn, the local numbers of its unknowns.
    numbers: Vec<u32>,
    /// For each row in turn, for each pair of its entries (i, j <= i), the place of their product.
    places: Vec<u32>,
    symbolic: Option<Arc<SymbolicCholesky<usize>>>,
}

impl Normal {
    /// Lays out and factors the pattern of some equations.
    pub fn new(rows: &Rows) -> Self {
        Self::after(rows, None)
    }

    /// The same where equations like these were factored `before`: parts whose pattern they share are not
    /// factored again. Solutions are those that [`Normal::new`] leads to, bit for bit.
    pub fn after(rows: &Rows, before: Option<&Self>) -> Self {
        let (members, equations, local) = parts_of(rows);
        let mut known: BTreeMap<[usize; 2], Vec<&Part>> = BTreeMap::new();
        for part in before.into_iter().flat_map(|b| &b.parts) {
            known.entry(part.size()).or_default().push(part);
        }
        let parts = members.into_par_iter().zip(equations);
        let part = |(unknowns, own)| Part::new(rows, (unknowns, own), &local, &known);
        Self { rows: rows.clone(), parts: parts.map(part).collect() }
    }

    /// The equations.
    pub fn rows(&self) -> &Rows {
        &self.rows
    }

    /// How many independent problems there are.
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// The unknowns that minimize the sum of weight times (left side - right side) squared.
    pub fn solve(&self, weights: &[f64], right: &[f64]) -> Result<Vec<f64>, Singular> {
        assert!(weights.len() == self.rows.len() && right.len() == self.rows.len());
        let solve = |part: &Part| part.solve(&self.rows, weights, right);
        let solved: Vec<Result<Vec<f64>, Singular>> = self.parts.par_iter().map(solve).collect();
        let mut x = vec![0.0; self.rows.unknowns()];
        for (part, values) in self.parts.iter().zip(solved) {
            for (unknown, value) in part.unknowns.iter().zip(values?) {
                x[*unknown as usize] = value;
            }
        }
        Ok(x)
    }
}

/// Unknowns and rows of each part, and each unknown's number within its part.
fn parts_of(rows: &Rows) -> (Vec<Vec<u32>>, Vec<Vec<u32>>, Vec<u32>) {
    let mut parent: Vec<u32> = (0..rows.unknowns() as u32).collect();
    for r in 0..rows.len() {
        for pair in rows.row(r).windows(2) {
            let (a, b) = (root(&mut parent, pair[0].0), root(&mut parent, pair[1].0));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let (mut part, mut local) = (vec![u32::MAX; parent.len()], vec![0; parent.len()]);
    let mut members: Vec<Vec<u32>> = Vec::new();
    for i in 0..parent.len() as u32 {
        let r = root(&mut parent, i) as usize;
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

fn root(parent: &mut [u32], mut x: u32) -> u32 {
    while parent[x as usize] != x {
        parent[x as usize] = parent[parent[x as usize] as usize];
        x = parent[x as usize];
    }
    x
}

/// The pairs of entries of a row, each as (column, row) of the lower triangle.
fn pairs<'a>(
    row: &'a [(u32, f64)],
    local: &'a [u32],
) -> impl Iterator<Item = (usize, usize, f64)> + 'a {
    row.iter().enumerate().flat_map(move |(k, (i, a))| {
        row[..=k].iter().map(move |(j, b)| {
            let (i, j) = (local[*i as usize] as usize, local[*j as usize] as usize);
            (i.min(j), i.max(j), a * b)
        })
    })
}

/// Where the columns of a lower triangle start and what rows they hold, the diagonal and some pairs
/// of (column, row), each once.
fn triangle<I: Iterator<Item = (usize, usize)>>(
    n: usize,
    pairs: impl Fn() -> I,
) -> (Vec<usize>, Vec<usize>) {
    // Room for all of a column's pairs first.
    let mut ends = vec![1; n];
    pairs().for_each(|(column, _)| ends[column] += 1);
    let mut total = 0;
    for end in &mut ends {
        total += std::mem::replace(end, total);
    }
    let first = ends.clone();
    let mut room = vec![0; total];
    for (column, row) in (0..n).map(|i| (i, i)).chain(pairs()) {
        room[ends[column]] = row;
        ends[column] += 1;
    }
    let (mut starts, mut below) = (vec![0], Vec::with_capacity(total / 2));
    for (from, to) in first.into_iter().zip(ends) {
        room[from..to].sort_unstable();
        let start = below.len();
        for &row in &room[from..to] {
            if below.len() == start || below[below.len() - 1] != row {
                below.push(row);
            }
        }
        starts.push(below.len());
    }
    (starts, below)
}

/// The pattern of the factor of a lower triangle.
fn factored(n: usize, starts: &[usize], below: &[usize]) -> Option<SymbolicCholesky<usize>> {
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, starts, None, below);
    let params = CholeskySymbolicParams::default();
    factorize_symbolic_cholesky(pattern, Side::Lower, SymmetricOrdering::Amd, params).ok()
}

impl Part {
    /// Unknowns and entries.
    fn size(&self) -> [usize; 2] {
        [self.unknowns.len(), self.below.len()]
    }

    fn new(
        rows: &Rows,
        (unknowns, own): (Vec<u32>, Vec<u32>),
        local: &[u32],
        known: &BTreeMap<[usize; 2], Vec<&Self>>,
    ) -> Self {
        let n = unknowns.len();
        let all = || own.iter().flat_map(|r| pairs(rows.row(*r as usize), local));
        let (starts, below) = triangle(n, || all().map(|(column, row, _)| (column, row)));
        let place = |(column, row, _): (usize, usize, f64)| {
            let column = starts[column]..starts[column + 1];
            let k = below[column.clone()].binary_search(&row);
            (column.start + k.expect("the pattern holds every pair")) as u32
        };
        let places = all().map(place).collect();
        let entries = own.iter().flat_map(|r| rows.row(*r as usize));
        let numbers = entries.map(|(i, _)| local[*i as usize]).collect();
        let same = |p: &&&Self| p.starts == starts && p.below == below;
        let known = known.get(&[n, below.len()]).and_then(|parts| parts.iter().find(same));
        let symbolic = match known {
            Some(part) => part.symbolic.clone(),
            None => factored(n, &starts, &below).map(Arc::new),
        };
        Self { unknowns, rows: own, starts, below, numbers, places, symbolic }
    }

    fn solve(&self, rows: &Rows, weights: &[f64], right: &[f64]) -> Result<Vec<f64>, Singular> {
        let singular = Singular { unknown: self.unknowns[0] as usize };
        let (values, mut x) = self.assembled(rows, weights, right);
        let finite = values.iter().chain(&x).all(|v| v.is_finite());
        let symbolic = self.symbolic.as_ref().filter(|_| finite).ok_or(singular)?;
        let n = x.len();
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &self.starts, None, &self.below);
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
        let mut values = vec![0.0; self.below.len()];
        let mut x = vec![0.0; self.unknowns.len()];
        let (mut places, mut numbers) = (self.places.iter(), self.numbers.iter());
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
