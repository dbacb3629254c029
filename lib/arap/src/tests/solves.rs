use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::tube;
use crate::cholesky::{Cholesky, order};
use crate::one_ring::OneRings;

/// The matrix with the same entries, dense.
fn dense(rings: &OneRings, kept: &[bool]) -> DMatrix<f64> {
    let count = rings.len();
    let mut matrix = DMatrix::zeros(count, count);
    for row in 0..count {
        matrix[(row, row)] = diagonal(row);
        for (column, weight) in rings
            .of(row)
            .filter(|&(column, _)| kept[row] && kept[column])
        {
            matrix[(row, column)] = -weight.min(1.0);
        }
    }
    matrix
}

fn diagonal(row: usize) -> f64 {
    7.0 + row as f64 / 100.0
}

#[test]
fn the_sparse_solve_is_that_of_the_dense_matrix() {
    let mesh = tube(41, 13, 17);
    let rings = OneRings::new(&mesh).unwrap();
    let rings = rings.renamed(&order(&rings).unwrap());
    let mut random = Pcg64Mcg::seed_from_u64(42);
    let kept: Vec<bool> = (0..rings.len()).map(|_| random.random_bool(0.9)).collect();
    let factor =
        Cholesky::new(&rings, |row| kept[row], diagonal, |weight| -weight.min(1.0)).unwrap();
    let right: Vec<[f64; 4]> = (0..rings.len()).map(|_| random.random()).collect();
    let mut solved = right.clone();
    factor.solve_lower(&mut solved);
    factor.solve_upper(&mut solved);
    let right = DMatrix::from_fn(rings.len(), 4, |row, column| right[row][column]);
    let expected = dense(&rings, &kept).cholesky().unwrap().solve(&right);
    for (row, lane) in solved.iter().enumerate() {
        for (column, value) in lane.iter().enumerate() {
            assert!(
                (value - expected[(row, column)]).abs() < 1e-14,
                "{row}, {column}"
            );
        }
    }
}

#[test]
fn the_order_names_each_vertex_once_and_keeps_factors_sparse() {
    let rings = OneRings::new(&tube(43, 60, 60)).unwrap();
    let order = order(&rings).unwrap();
    let mut sorted = order.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, (0..rings.len()).collect::<Vec<_>>());
    let entries = |rings: &OneRings| {
        Cholesky::new(rings, |_| true, diagonal, |_| -1.0)
            .unwrap()
            .entries()
    };
    let (before, after) = (entries(&rings), entries(&rings.renamed(&order)));
    println!("{before} entries, in that order {after}");
    assert!(after < 30 * rings.len() && 2 * after < before);
}

#[test]
fn an_indefinite_matrix_is_refused() {
    let rings = OneRings::new(&tube(44, 6, 5)).unwrap();
    assert!(Cholesky::new(&rings, |_| true, |_| 1.0, |_| -1.0).is_err());
}
