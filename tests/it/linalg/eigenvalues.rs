//! Eigenvalues of real and complex matrices: closed forms, and another library.

use muspin::linalg::{Mat, c64, eigenvalues, eigenvalues_complex};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Largest distance of a value of one list from the nearest of the other, both ways.
fn gap(a: &[c64], b: &[c64]) -> f64 {
    let one_way = |a: &[c64], b: &[c64]| {
        let nearest = |v: &c64| b.iter().map(|w| (v - w).norm()).fold(f64::INFINITY, f64::min);
        a.iter().map(nearest).fold(0.0, f64::max)
    };
    assert_eq!(a.len(), b.len());
    one_way(a, b).max(one_way(b, a))
}

fn entry(i: usize, j: usize) -> c64 {
    let phase = (31 * i + 17 * j * j + 7 * i * j) as f64;
    c64::new(phase.sin(), (1.3 * phase).cos())
}

#[test]
fn a_circulant_matrix_has_the_transform_of_its_first_row() {
    for n in [1, 2, 3, 8, 31, 58, 140] {
        let row: Vec<c64> = (0..n).map(|j| entry(3, j)).collect();
        let a = Mat::from_fn(n, n, |i, j| row[(j + n - i) % n]);
        let value = |k: usize| {
            let turn = |j: usize| c64::from_polar(1.0, TAU * (j * k % n) as f64 / n as f64);
            row.iter().enumerate().map(|(j, r)| r * turn(j)).sum::<c64>()
        };
        let exact: Vec<c64> = (0..n).map(value).collect();
        let found = eigenvalues_complex(&a).unwrap();
        let size = exact.iter().map(|v| v.norm()).fold(0.0, f64::max);
        assert!(gap(&found, &exact) < 1e-13 * n as f64 * size, "order {n}");
    }
}

#[test]
fn eigenvalues_of_any_order_are_those_of_another_library() {
    for n in [2, 3, 5, 24, 60, 100, 160] {
        let a = Mat::from_fn(n, n, entry);
        let found = eigenvalues_complex(&a).unwrap();
        let apart = gap(&found, &a.eigenvalues().unwrap());
        assert!(apart < 1e-12 * a.norm_l2(), "order {n}: {apart:.1e}");
        assert!(found.is_sorted_by(|a, b| a.norm() <= b.norm()));
        let real = Mat::from_fn(n, n, |i, j| a[(i, j)].re);
        let found = eigenvalues(&real).unwrap();
        let other = nalgebra::DMatrix::from_fn(n, n, |i, j| real[(i, j)]);
        let other: Vec<c64> = other.complex_eigenvalues().iter().copied().collect();
        let apart = gap(&found, &other);
        assert!(apart < 1e-12 * real.norm_l2(), "real, order {n}: {apart:.1e}");
        // Complex ones come in pairs.
        let conjugates: Vec<c64> = found.iter().map(|v| v.conj()).collect();
        assert_eq!(gap(&found, &conjugates), 0.0);
    }
}

#[test]
fn a_real_matrix_of_known_blocks_has_their_eigenvalues() {
    // Blocks [d, w; −w, d] and single entries, seen through a reflection, which keeps the eigenvalues.
    for (blocks, singles) in [(0, 3), (1, 0), (4, 1), (30, 5), (60, 0)] {
        let n = 2 * blocks + singles;
        let damped = |k: usize| c64::new(-0.01 * (k + 1) as f64, 1.0 + (1.7 * k as f64).sin());
        let single = |k: usize| -2.0 - 0.25 * k as f64;
        let form = Mat::from_fn(n, n, |i, j| match (i / 2, j / 2) {
            (k, l) if k == l && k < blocks => match i as i64 - j as i64 {
                0 => damped(k).re,
                -1 => damped(k).im,
                _ => -damped(k).im,
            },
            _ if i == j => single(i - 2 * blocks),
            // Above the blocks anything may stand; little of it keeps the eigenvalues well conditioned.
            (k, l) if k < l => ((3 * i + 5 * j) as f64).sin() / (n * n) as f64,
            _ => 0.0,
        });
        let v = Mat::from_fn(n, 1, |i, _| 1.0 + (i as f64).cos());
        let square: f64 = v.norm_l2().powi(2);
        let mirror = Mat::<f64>::identity(n, n) - &v * v.transpose() * faer::Scale(2.0 / square);
        let found = eigenvalues(&(&mirror * &form * &mirror)).unwrap();
        let pairs = (0..blocks).flat_map(|k| [damped(k), damped(k).conj()]);
        let exact: Vec<c64> = pairs.chain((0..singles).map(|k| c64::from(single(k)))).collect();
        let apart = gap(&found, &exact);
        assert!(apart < 1e-10, "{n}: {apart:.1e}");
        let trace: c64 = found.iter().sum::<c64>() - exact.iter().sum::<c64>();
        assert!(trace.norm() < 1e-12 * n as f64 * form.norm_l2());
    }
}

#[test]
fn iterations_on_graded_matrices_and_hamiltonians_end() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for round in 0..300 {
        let n = 2 * rng.random_range(2..30);
        let spread = rng.random_range(0.0..14.0);
        let mut scale = || -> Vec<f64> { (0..n).map(|_| 10f64.powf(-spread * rng.random::<f64>())).collect() };
        let (rows, columns) = (scale(), scale());
        let mut drawn = |i: usize, j: usize| {
            let entry = 2.0 * rng.random::<f64>() - 1.0;
            rows[i] * columns[j] * entry
        };
        let graded = Mat::from_fn(n, n, &mut drawn);
        // [A, B; C, −Aᵀ] with symmetric B and C: eigenvalues in pairs λ, −λ.
        let h = n / 2;
        let hamiltonian = Mat::from_fn(n, n, |i, j| match (i < h, j < h) {
            (true, true) => graded[(i, j)],
            (false, false) => -graded[(j - h, i - h)],
            _ => graded[(i, j)] + graded[((j + h) % n, (i + h) % n)],
        });
        for a in [&graded, &hamiltonian] {
            let found = eigenvalues(a).unwrap();
            let complex = Mat::from_fn(n, n, |i, j| c64::from(a[(i, j)]));
            let other = eigenvalues_complex(&complex).unwrap();
            // Traces of powers hold for any condition of the eigenvalues.
            for values in [&found, &other] {
                let trace: c64 = values.iter().sum();
                let own: f64 = (0..n).map(|k| a[(k, k)]).sum();
                let square: c64 = values.iter().map(|v| v * v).sum();
                let squared = a * a;
                let own_square: f64 = (0..n).map(|k| squared[(k, k)]).sum();
                let norm = a.norm_l2();
                let tolerance = 1e-13 * n as f64;
                assert!((trace - own).norm() < tolerance * norm, "{round}");
                assert!((square - own_square).norm() < tolerance * norm * norm, "{round}");
            }
        }
    }
}

/// The sum of squares of a column overflows, that of its row does not: the values are right to the rounding of the norm.
#[test]
fn an_entry_whose_square_overflows_leaves_finite_eigenvalues() {
    let norm = 1e160;
    let a = faer::mat![[2.0, norm], [1.0, 3.0]];
    let found = eigenvalues(&a).unwrap();
    assert_eq!(found.len(), 2);
    // The exact values are ±√norm to rounding.
    for value in found {
        assert!((value.norm() - norm.sqrt()).abs() <= f64::EPSILON * norm);
    }
}

#[test]
fn the_size_of_the_entries_does_not_matter() {
    let n = 12;
    let a = Mat::from_fn(n, n, entry);
    let exact = eigenvalues_complex(&a).unwrap();
    for power in [-200, -150, -60, 60, 150, 200] {
        let scale = 10f64.powi(power);
        let scaled = Mat::from_fn(n, n, |i, j| a[(i, j)] * scale);
        let found = eigenvalues_complex(&scaled).unwrap();
        let found: Vec<c64> = found.iter().map(|v| v / scale).collect();
        assert!(gap(&found, &exact) < 1e-12, "1e{power}");
        let real = |scale: f64| Mat::from_fn(n, n, |i, j| a[(i, j)].re * scale);
        let found = eigenvalues(&real(scale)).unwrap();
        let found: Vec<c64> = found.iter().map(|v| v / scale).collect();
        let exact = eigenvalues(&real(1.0)).unwrap();
        assert!(gap(&found, &exact) < 1e-12, "real, 1e{power}");
    }
}

#[test]
fn eigenvalues_of_special_matrices() {
    let zero = c64::new(0.0, 0.0);
    assert!(eigenvalues_complex(&Mat::<c64>::zeros(0, 0)).unwrap().is_empty());
    assert_eq!(eigenvalues_complex(&Mat::<c64>::zeros(4, 4)).unwrap(), [zero; 4]);
    // A cycle, on which steps without shifts from outside stand still: the roots of unity.
    for n in [2, 3, 4, 16] {
        let cycle = Mat::from_fn(n, n, |i, j| c64::from(f64::from(i == (j + 1) % n)));
        let roots: Vec<c64> = (0..n).map(|k| c64::from_polar(1.0, TAU * k as f64 / n as f64)).collect();
        assert!(gap(&eigenvalues_complex(&cycle).unwrap(), &roots) < 1e-13);
        let real = Mat::from_fn(n, n, |i, j| cycle[(i, j)].re);
        assert!(gap(&eigenvalues(&real).unwrap(), &roots) < 1e-13);
    }
    // A Jordan block: rounding moves an eigenvalue of multiplicity m by ε to the power 1/m.
    let block = Mat::from_fn(4, 4, |i, j| match j.wrapping_sub(i) {
        0 => c64::new(2.0, 1.0),
        1 => c64::new(0.0, 1.0),
        _ => zero,
    });
    let values = eigenvalues_complex(&block).unwrap();
    assert!(gap(&values, &[c64::new(2.0, 1.0); 4]) < 1e-3);
    let trace: c64 = values.iter().sum();
    assert!((trace - c64::new(8.0, 4.0)).norm() < 1e-13);
    assert_eq!(eigenvalues(&Mat::zeros(4, 4)).unwrap(), [zero; 4]);
    assert!(eigenvalues(&Mat::zeros(0, 0)).unwrap().is_empty());
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(eigenvalues_complex(&Mat::from_fn(2, 2, |_, _| c64::new(1.0, bad))).is_err());
        assert!(eigenvalues(&Mat::from_fn(2, 2, |_, _| bad)).is_err());
    }
}
