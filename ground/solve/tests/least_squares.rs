//! Sparse solutions against dense ones, closed forms, and every number of threads.

#![allow(clippy::unwrap_used, reason = "a test may fail")]

use chiaro_solve::{Normal, Rows};
use proptest::prelude::*;

/// The dense solution, by elimination with pivots.
fn dense(rows: &Rows, weights: &[f64], right: &[f64]) -> Vec<f64> {
    let n = rows.unknowns();
    let mut m = vec![vec![0.0; n + 1]; n];
    for r in 0..rows.len() {
        for (i, a) in rows.row(r) {
            for (j, b) in rows.row(r) {
                m[*i as usize][*j as usize] += weights[r] * a * b;
            }
            m[*i as usize][n] += weights[r] * a * right[r];
        }
    }
    for k in 0..n {
        let pivot = (k..n).max_by(|a, b| m[*a][k].abs().total_cmp(&m[*b][k].abs())).unwrap();
        m.swap(k, pivot);
        for i in (0..n).filter(|i| *i != k) {
            let f = m[i][k] / m[k][k];
            let pivot = m[k].clone();
            m[i].iter_mut().zip(&pivot).for_each(|(x, p)| *x -= f * p);
        }
    }
    (0..n).map(|i| m[i][n] / m[i][i]).collect()
}

/// Rows that hold every unknown down, and random ones.
fn problem() -> impl Strategy<Value = (Rows, Vec<f64>, Vec<f64>)> {
    let entry = (0u32..12, -2.0f64..2.0);
    let row = proptest::collection::vec(entry, 0..4);
    let numbers = proptest::collection::vec((0.1f64..3.0, -5.0f64..5.0), 42);
    (proptest::collection::vec(row, 30), numbers).prop_map(|(list, numbers)| {
        let mut rows = Rows::new(12);
        (0..12).for_each(|i| {
            rows.push(&[(i, 1.0)]);
        });
        list.iter().for_each(|r| {
            rows.push(r);
        });
        let (weights, right) = numbers.into_iter().unzip();
        (rows, weights, right)
    })
}

proptest! {
    #[test]
    fn sparse_is_dense((rows, weights, right) in problem()) {
        let normal = Normal::new(&rows);
        let expected = dense(&rows, &weights, &right);
        let found = normal.solve(&weights, &right).unwrap();
        for (a, b) in found.iter().zip(&expected) {
            prop_assert!((a - b).abs() < 1e-9 * (1.0 + b.abs()), "{a} {b}");
        }
        // What was factored before serves again where patterns are the same, bit for bit.
        let mut more = rows.clone();
        more.push(&[(0, 1.0), (11, -1.0)]);
        for before in [&normal, &Normal::new(&more)] {
            let again = Normal::after(rows.clone(), Some(before)).solve(&weights, &right).unwrap();
            prop_assert_eq!(&again, &found);
        }
        // The pattern serves other weights.
        let other: Vec<f64> = weights.iter().map(|w| w * w + 0.5).collect();
        let (found, expected) = (normal.solve(&other, &right).unwrap(), dense(&rows, &other, &right));
        for (a, b) in found.iter().zip(&expected) {
            prop_assert!((a - b).abs() < 1e-9 * (1.0 + b.abs()), "{a} {b}");
        }
    }
}

/// A chain whose ends are held: steps share the error evenly.
fn chain(n: u32) -> (Rows, Vec<f64>, Vec<f64>) {
    let mut rows = Rows::new(n as usize);
    rows.push(&[(0, 1.0)]);
    (1..n).for_each(|i| {
        rows.push(&[(i - 1, -1.0), (i, 1.0)]);
    });
    rows.push(&[(n - 1, 1.0)]);
    let mut weights = vec![1.0; rows.len()];
    (weights[0], weights[n as usize]) = (1e9, 1e9);
    let mut right = vec![1.0; rows.len()];
    (right[0], right[n as usize]) = (0.0, 2.0 * f64::from(n - 1));
    (rows, weights, right)
}

#[test]
fn a_stretched_chain_stretches_evenly() {
    let (rows, weights, right) = chain(5000);
    let x = Normal::new(&rows).solve(&weights, &right).unwrap();
    for (i, x) in x.iter().enumerate() {
        assert!((x - 2.0 * i as f64).abs() < 1e-3, "{i}: {x}");
    }
}

#[test]
fn parts_are_solved_on_their_own() {
    let mut rows = Rows::new(6);
    for i in 0..3 {
        rows.push(&[(i, 1.0)]);
        rows.push(&[(i, 1.0), (i + 3, -1.0)]);
    }
    let normal = Normal::new(&rows);
    assert_eq!(normal.parts(), 3);
    let x = normal.solve(&[1.0; 6], &[1.0, 0.0, 2.0, 0.0, 3.0, 0.0]).unwrap();
    assert!((x[5] - 3.0).abs() < 1e-12);
    // The others stay.
    let mut some = vec![7.0; 6];
    let right = [1.0, 0.0, 5.0, 0.0, 3.0, 0.0];
    normal.solve_some(&[1.0; 6], &right, &[false, true, false], &mut some).unwrap();
    assert_eq!((normal.unknowns_of(1), normal.rows_of(1)), (&[1, 4][..], &[2, 3][..]));
    for (x, expected) in some.iter().zip([7.0, 5.0, 7.0, 7.0, 5.0, 7.0]) {
        assert!((x - expected).abs() < 1e-12, "{some:?}");
    }
}

#[test]
fn parts_are_known_again_by_their_left_sides() {
    let of = |slope: f64| {
        let mut rows = Rows::new(5);
        for (i, a) in [(0, 2.0), (2, slope)] {
            rows.push(&[(i, 1.0)]);
            rows.push(&[(i, 1.0), (i + 1, a)]);
        }
        rows.push(&[(4, 1.0)]);
        rows
    };
    let before = Normal::new(&of(3.0));
    let same = |rows: Rows| {
        let normal = Normal::after(rows, Some(&before));
        [0, 1, 2].map(|part| normal.same_before(part))
    };
    assert_eq!(same(of(3.0)), [Some(0), Some(1), Some(2)]);
    assert_eq!(same(of(2.0)), [Some(0), Some(0), Some(2)]);
    assert_eq!(same(of(5.0)), [Some(0), None, Some(2)]);
}

#[test]
fn free_unknowns_and_bad_weights_are_errors() {
    let mut rows = Rows::new(3);
    rows.push(&[(0, 1.0)]);
    rows.push(&[(1, 1.0), (2, -1.0)]);
    let normal = Normal::new(&rows);
    assert_eq!(normal.solve(&[1.0, 1.0], &[0.0, 0.0]).unwrap_err().unknown, 1);
    rows.push(&[(2, 1.0)]);
    let normal = Normal::new(&rows);
    assert!(normal.solve(&[1.0, f64::NAN, 1.0], &[0.0; 3]).is_err());
    assert!(normal.solve(&[1.0; 3], &[0.0; 3]).is_ok());
    assert_eq!(Normal::new(&Rows::new(0)).solve(&[], &[]).unwrap(), vec![]);
}

#[test]
fn threads_change_no_bit() {
    let (rows, weights, right) = chain(3000);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Normal::new(&rows).solve(&weights, &right).unwrap())
    };
    let one = on(1);
    assert!([2, 3, 8].into_iter().all(|n| on(n) == one));
}
