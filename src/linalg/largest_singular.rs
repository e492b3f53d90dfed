//! Largest singular value of a small complex matrix, through the smaller Gram matrix: Householder's tridiagonal form,
//! then QL. Both are done in arrays whose size the compiler knows where the matrix is small enough.

use super::fixed::{Columns, Fixed};
use super::planar::Planar;

/// Largest singular value, exact to rounding relative to itself. NaN for entries that are not finite.
pub(crate) fn largest_singular_value(m: &Planar) -> f64 {
    let size = m.largest_part();
    if size == 0.0 {
        return 0.0;
    }
    // Entries of size one: squares neither overflow nor vanish.
    let scale = size.recip();
    if !scale.is_finite() || scale == 0.0 {
        return if size.is_finite() { size } else { f64::NAN };
    }
    let largest = match m.rows().max(m.cols()) {
        0..=4 => largest_gram_value::<Fixed<4>>(m, scale),
        5..=8 => largest_gram_value::<Fixed<8>>(m, scale),
        _ => largest_gram_value::<Planar>(m, scale),
    };
    largest.max(0.0).sqrt() * size
}

/// Largest eigenvalue of the smaller Gram matrix of `scale` times a matrix.
fn largest_gram_value<M: Columns>(m: &Planar, scale: f64) -> f64 {
    let (n, columns) = (m.rows().min(m.cols()), m.rows().max(m.cols()));
    let is_wide = m.rows() < m.cols();
    let mut source = M::zeros(n, columns);
    for j in 0..columns {
        for i in 0..n {
            let (re, im) = if is_wide { m.at(i, j) } else { m.at(j, i) };
            source.set(i, j, (re * scale, im * scale));
        }
    }
    let mut gram = M::zeros(n, n);
    for k in 0..columns {
        for j in 0..n {
            let (re, im) = source.at(j, k);
            gram.add(0..n, j, (re, -im), (&source, k));
        }
    }
    largest_hermitian_value(gram, n)
}

/// Largest eigenvalue of a Hermitian matrix of an order (both triangles).
fn largest_hermitian_value<M: Columns>(mut a: M, n: usize) -> f64 {
    let (mut d, mut e) = (vec![0.0; n], vec![0.0; n]);
    let (mut v, mut p) = (M::zeros(n, 1), M::zeros(n, 1));
    for k in 0..n {
        d[k] = a.at(k, k).0;
        if k + 1 < n {
            e[k] = reflect(&mut a, k, n, &mut v, &mut p);
        }
    }
    tridiagonal_values(&mut d, &mut e);
    d.iter().fold(f64::NEG_INFINITY, |m, v| m.max(*v))
}

/// Annihilates column k below the subdiagonal by a reflection I − τvvᴴ on both sides; returns |subdiagonal entry|. Rows
/// and columns up to k are done with.
fn reflect<M: Columns>(a: &mut M, k: usize, n: usize, v: &mut M, p: &mut M) -> f64 {
    let first = k + 1;
    let below = first + 1..n;
    let of_real: f64 = below.clone().map(|i| a.at(i, k).0.powi(2)).sum();
    let tail = below.fold(of_real, |sum, i| sum + a.at(i, k).1.powi(2));
    let (re, im) = a.at(first, k);
    let head = (re * re + im * im).sqrt();
    if tail == 0.0 {
        return head;
    }
    let norm = (head * head + tail).sqrt();
    // v = x + e^{iθ}‖x‖e₁ with the phase of x₁; vᴴv = 2‖x‖(‖x‖ + |x₁|).
    let turn = if head > 0.0 { (re / head, im / head) } else { (1.0, 0.0) };
    v.clear();
    for i in first..n {
        v.set(i, 0, a.at(i, k));
    }
    v.set(first, 0, (re + turn.0 * norm, im + turn.1 * norm));
    let tau = (norm * (norm + head)).recip();
    p.clear();
    for j in first..n {
        let (re, im) = v.at(j, 0);
        p.add(first..n, 0, (tau * re, tau * im), (a, j));
    }
    let product = |i: usize| {
        let (v, p) = (v.at(i, 0), p.at(i, 0));
        v.0 * p.0 + v.1 * p.1
    };
    let dot: f64 = (first..n).map(product).sum();
    p.add(first..n, 0, (-0.5 * tau * dot, 0.0), (v, 0));
    for j in first..n {
        let (by_v, by_p) = (p.at(j, 0), v.at(j, 0));
        a.add(first..n, j, (-by_v.0, by_v.1), (v, 0));
        a.add(first..n, j, (-by_p.0, by_p.1), (p, 0));
    }
    norm
}

/// Eigenvalues of the symmetric tridiagonal matrix with diagonal d and subdiagonal e (its last entry unused), into d:
/// implicit QL without vectors (Bowdler, Martin, Reinsch and Wilkinson 1968).
fn tridiagonal_values(d: &mut [f64], e: &mut [f64]) {
    let n = d.len();
    for l in 0..n {
        // Two or three sweeps a value are usual; what is left after 60 is rounding of a matrix that is not finite.
        for _ in 0..60 {
            let small = |m: &usize| e[*m].abs() <= f64::EPSILON * (d[*m].abs() + d[*m + 1].abs());
            let m = (l..n - 1).find(small).unwrap_or(n - 1);
            if m == l {
                break;
            }
            sweep(d, e, l, m);
        }
    }
}

/// One QL sweep on rows l..=m.
fn sweep(d: &mut [f64], e: &mut [f64], l: usize, m: usize) {
    let shift = (d[l + 1] - d[l]) / (2.0 * e[l]);
    let mut g = d[m] - d[l] + e[l] / (shift + (shift * shift + 1.0).sqrt().copysign(shift));
    let (mut s, mut c, mut p) = (1.0, 1.0, 0.0);
    for i in (l..m).rev() {
        let (f, b) = (s * e[i], c * e[i]);
        let r = (f * f + g * g).sqrt();
        e[i + 1] = r;
        if r == 0.0 {
            d[i + 1] -= p;
            e[m] = 0.0;
            return;
        }
        (s, c) = (f / r, g / r);
        g = d[i + 1] - p;
        let t = (d[i] - g) * s + 2.0 * c * b;
        p = s * t;
        d[i + 1] = g + p;
        g = c * t - b;
    }
    d[l] -= p;
    e[l] = g;
    e[m] = 0.0;
}

#[cfg(test)]
mod tests {
    use super::super::Mat;
    use super::super::c64;
    use super::*;

    #[test]
    fn the_largest_singular_value_is_that_of_the_library() {
        for (rows, cols) in [(1, 1), (2, 4), (4, 3), (4, 4), (5, 2), (8, 8), (7, 8), (9, 3), (6, 11)] {
            for size in [1e-200, 1.0, 1e180] {
                let entry = |i: usize, j: usize| {
                    let (sin, cos) = ((3 * i + 7 * j + i * j) as f64).sin_cos();
                    (size * sin / (1.0 + i as f64), size * cos)
                };
                let found = largest_singular_value(&Planar::from_fn(rows, cols, entry));
                let one = Mat::from_fn(rows, cols, |i, j| {
                    let (re, im) = entry(i, j);
                    c64::new(re / size, im / size)
                });
                let exact = one.singular_values().expect("finite")[0] * size;
                assert!((found / exact - 1.0).abs() < 1e-14, "{rows}x{cols}: {found}, {exact}");
            }
        }
        let zero = Planar::from_fn(3, 4, |_, _| (0.0, 0.0));
        assert_eq!(largest_singular_value(&zero), 0.0);
        let diagonal = Planar::from_fn(4, 4, |i, j| if i == j { (i as f64, 0.0) } else { (0.0, 0.0) });
        assert_eq!(largest_singular_value(&diagonal), 3.0);
        for value in [f64::NAN, f64::INFINITY] {
            let bad = Planar::from_fn(3, 3, |i, j| if i > j { (value, 0.0) } else { (1.0, 0.0) });
            assert!(largest_singular_value(&bad).is_nan());
        }
    }
}
