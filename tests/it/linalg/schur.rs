//! Real Schur forms: orthogonal, of blocks, and the same matrix, whatever the size of its entries.

use muspin::linalg::schur::schur;
use muspin::linalg::{Mat, eigenvalues};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Asserts that the Schur form of A is one: Z orthogonal, T of 1×1 blocks and 2×2 blocks of complex pairs, A Z = Z T.
fn holds(a: &Mat<f64>, what: &str) {
    let n = a.nrows();
    let form = schur(a).unwrap();
    let (z, t) = (&form.z, &form.t);
    let turned = z.transpose() * z - Mat::<f64>::identity(n, n);
    let tolerance = 1e-14 * (n as f64 + 10.0);
    assert!(turned.norm_max() < tolerance, "{what}: not orthogonal");
    let apart = (a * z - z * t).norm_l2();
    assert!(apart <= tolerance * a.norm_l2(), "{what}: {apart:.1e}");
    // A smaller block is zero to rounding, or has lost its digits to underflow.
    let least = 1e-138 * a.norm_max().max(1e-150);
    for j in 0..n {
        for i in j + 1..n {
            let (below, next) = (t[(i, j)], i > 1 && t[(i - 1, i - 2)] != 0.0);
            assert!(below == 0.0 || i == j + 1 && !next, "{what}: a block larger than 2×2");
            if below.abs().min(t[(j, i)].abs()) > least {
                let half = 0.5 * (t[(j, j)] - t[(i, i)]);
                let above = t[(j, i)];
                let unit = half.abs().max(below.abs()).max(above.abs());
                let square = (half / unit).powi(2) + below / unit * (above / unit);
                assert!(square < 0.0, "{what}: a block with real eigenvalues");
            }
        }
    }
    let (found, trace) = (form.eigenvalues(), (0..n).map(|k| a[(k, k)]).sum::<f64>());
    assert_eq!(found.len(), n);
    let sum: f64 = found.iter().map(|v| v.re).sum();
    assert!((sum - trace).abs() <= tolerance * a.norm_l2(), "{what}");
}

fn drawn(rng: &mut ChaCha8Rng, n: usize) -> Mat<f64> {
    Mat::from_fn(n, n, |_, _| 2.0 * rng.random::<f64>() - 1.0)
}

#[test]
fn schur_forms_of_any_order_hold() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for n in [0, 1, 2, 3, 4, 5, 9, 28, 60, 116, 240] {
        let a = drawn(&mut rng, n);
        holds(&a, &format!("order {n}"));
        holds(&Mat::zeros(n, n), "zero");
        holds(&Mat::identity(n, n), "identity");
        // Real eigenvalues alone.
        holds(&(&a + a.transpose()), &format!("symmetric, order {n}"));
        holds(&(&a - a.transpose()), &format!("skew, order {n}"));
        let cycle = Mat::from_fn(n, n, |i, j| f64::from(i == (j + 1) % n));
        holds(&cycle, &format!("cycle of {n}"));
        let jordan = Mat::from_fn(n, n, |i, j| f64::from(i == j || i + 1 == j));
        holds(&jordan, &format!("Jordan block of {n}"));
        holds(&jordan.transpose().to_owned(), "Jordan block, transposed");
    }
}

/// Matrices of a machine have entries that underflowed when they were computed: they count as zero.
#[test]
fn entries_of_any_size_leave_a_schur_form() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    for round in 0..400 {
        let n = rng.random_range(2..30);
        let a = drawn(&mut rng, n);
        // Rows and columns apart by up to all the powers that a number has.
        let spread = [3.0, 30.0, 300.0, 330.0][round % 4];
        let of_size: Vec<f64> = (0..n).map(|_| 10f64.powf(-spread * rng.random::<f64>())).collect();
        let scaled = Mat::from_fn(n, n, |i, j| a[(i, j)] * of_size[i]);
        holds(&scaled, &format!("rows, round {round}"));
        let scaled = Mat::from_fn(n, n, |i, j| a[(i, j)] * of_size[j]);
        holds(&scaled, &format!("columns, round {round}"));
        let share = rng.random::<f64>();
        let tiny = [1e-310, 1e-300, 5e-324, 1e-160][round / 4 % 4];
        let some = Mat::from_fn(n, n, |i, j| {
            if rng.random::<f64>() < share && i + j > 0 { tiny * a[(i, j)] } else { 8e6 * a[(i, j)] }
        });
        holds(&some, &format!("tiny entries, round {round}"));
        let size = 10f64.powi(rng.random_range(-150..150));
        let all = Mat::from_fn(n, n, |i, j| size * a[(i, j)]);
        holds(&all, &format!("all of size {size:e}, round {round}"));
        assert_eq!(eigenvalues(&some).unwrap().len(), n);
    }
}
