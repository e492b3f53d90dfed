//! Ordered real Schur form A = Z T Zᵀ with T quasi upper triangular (1×1 and 2×2 diagonal blocks).
//! The matrix is scaled to norm one first, and entries whose squares underflow are set to zero.
//! Reordering: direct swapping of adjacent blocks (Bai and Demmel 1993).

use super::dense::{NEGLIGIBLE, unit_of};
use super::error::NumericError;
use super::francis::Francis;
use faer::{Mat, c64};

/// Real Schur form A = Z T Zᵀ.
#[derive(Clone, Debug)]
pub struct RealSchur {
    /// Orthogonal, n×n.
    pub z: Mat<f64>,
    /// Quasi upper triangular, n×n; a 2×2 block is a complex pair.
    pub t: Mat<f64>,
}

/// Real Schur form of a square matrix; the data is used as it stands (balance first if it is badly scaled).
///
/// # Errors
/// [`NumericError::NotFinite`] for bad data, [`NumericError::NoConvergence`] when A − ZTZᵀ does not vanish.
pub fn schur(a: &Mat<f64>) -> Result<RealSchur, NumericError> {
    let n = a.nrows();
    if !a.is_all_finite() {
        return Err(NumericError::NotFinite { what: "Schur form" });
    }
    if n <= 1 {
        return Ok(RealSchur { z: Mat::identity(n, n), t: a.clone() });
    }
    let unit = unit_of(a.norm_max());
    let scaled = Mat::from_fn(n, n, |i, j| match a[(i, j)] / unit {
        x if x.abs() < NEGLIGIBLE => 0.0,
        x => x,
    });
    let [z, t] = Francis::of_schur_form(scaled.clone()).check_finished()?.basis_and_form();
    let mut form = RealSchur { z, t };
    form.split();
    let defect = (&form.z * &form.t - &scaled * &form.z).norm_l2();
    // Reflections are backward stable: the tests hold the defect below 1e-14 (n + 10) up to order 240. A failed sweep
    // leaves one of order one.
    if defect.is_nan() || defect > 1e-11 * scaled.norm_l2() {
        return Err(NumericError::NoConvergence {
            what: "Schur form",
            iterations: 30 * n,
            residual: defect / scaled.norm_l2(),
        });
    }
    form.t *= faer::Scale(unit);
    Ok(form)
}

impl RealSchur {
    /// Start and size of every diagonal block, from the top.
    pub(crate) fn blocks(&self) -> Vec<(usize, usize)> {
        quasi_blocks(&self.t)
    }

    /// Eigenvalues in the order of the diagonal.
    pub fn eigenvalues(&self) -> Vec<c64> {
        let mut values = Vec::with_capacity(self.t.nrows());
        for (i, size) in self.blocks() {
            let (first, second) = block_eigenvalues(&self.t, i, size);
            values.push(first);
            if size == 2 {
                values.push(second);
            }
        }
        values
    }

    /// Moves the blocks whose eigenvalue is selected to the top, keeping their order; returns the form and their
    /// total size k. The first k columns of Z span the invariant subspace of the selected eigenvalues.
    pub fn reorder(mut self, select: impl Fn(c64) -> bool) -> (Self, usize) {
        let (mut done, mut i) = (0, 0);
        let n = self.t.nrows();
        while i < n {
            let size = block_size(&self.t, i);
            if select(block_eigenvalues(&self.t, i, size).0) {
                let above: Vec<_> =
                    quasi_blocks(&self.t).into_iter().filter(|(start, _)| (done..i).contains(start)).collect();
                for (start, above_size) in above.into_iter().rev() {
                    self.swap(start, above_size, size);
                }
                done += size;
            }
            i += size;
        }
        (self, done)
    }

    /// Size of the diagonal block that starts at row `i`.
    pub(super) fn block_at(&self, i: usize) -> usize {
        block_size(&self.t, i)
    }

    /// Eigenvalue of the diagonal block that starts at row `i`; of a pair the one in the upper half plane.
    pub(super) fn eigenvalue_at(&self, i: usize) -> c64 {
        block_eigenvalues(&self.t, i, block_size(&self.t, i)).0
    }

    /// Splits 2×2 blocks with real eigenvalues.
    fn split(&mut self) {
        let n = self.t.nrows();
        let mut i = 0;
        while i + 1 < n {
            if self.t[(i + 1, i)] == 0.0 {
                i += 1;
                continue;
            }
            let (half, c) = (0.5 * (self.t[(i, i)] - self.t[(i + 1, i + 1)]), self.t[(i + 1, i)]);
            let [square, product] = [half * half, self.t[(i, i + 1)] * c];
            // Two equal eigenvalues may look complex for rounding.
            if square + product >= -4.0 * f64::EPSILON * square {
                // Eigenvector of the eigenvalue farther from t22, by its distance: no cancellation.
                let root = (square + product).max(0.0).sqrt();
                let (x, y) = (half + root.copysign(half), c);
                let r = x.hypot(y);
                if r > 0.0 {
                    self.rotate(i, x / r, y / r);
                }
                self.t[(i + 1, i)] = 0.0;
                i += 1;
            } else {
                i += 2;
            }
        }
    }

    /// Similarity by the plane rotation whose first axis is (c, s) in rows i and i+1.
    fn rotate(&mut self, i: usize, c: f64, s: f64) {
        let g = Mat::from_fn(2, 2, |r, k| match (r, k) {
            (0, 0) | (1, 1) => c,
            (0, 1) => -s,
            _ => s,
        });
        self.transform(i, &g);
    }

    /// T ← GᵀTG, Z ← ZG on the rows and columns from i on, G orthogonal and small.
    fn transform(&mut self, i: usize, g: &Mat<f64>) {
        let (n, k) = (self.t.nrows(), g.nrows());
        for col in 0..n {
            let old: [f64; 4] = std::array::from_fn(|r| if r < k { self.t[(i + r, col)] } else { 0.0 });
            for r in 0..k {
                self.t[(i + r, col)] = (0..k).map(|l| g[(l, r)] * old[l]).sum();
            }
        }
        for m in [&mut self.t, &mut self.z] {
            for row in 0..n {
                let old: [f64; 4] = std::array::from_fn(|r| if r < k { m[(row, i + r)] } else { 0.0 });
                for r in 0..k {
                    m[(row, i + r)] = (0..k).map(|l| old[l] * g[(l, r)]).sum();
                }
            }
        }
    }

    /// Swaps the block of size p at j with the one of size q below it.
    pub(super) fn swap(&mut self, j: usize, p: usize, q: usize) {
        let part = |r: usize, c: usize, h: usize, w: usize| Mat::from_fn(h, w, |k, l| self.t[(j + r + k, j + c + l)]);
        let (a, b, c) = (part(0, 0, p, p), part(p, p, q, q), part(0, p, p, q));
        // A X − X B = C; the columns of [−X; I] span the invariant subspace of B.
        let left = |r: usize, s: usize| a[(r, s)];
        let right = |r: usize, s: usize| -b[(s, r)];
        let x = small_sylvester([p, q], left, right, |r, s| c[(r, s)]);
        let basis = Mat::from_fn(p + q, q, |r, s| {
            if r < p {
                -x[s * p + r]
            } else if r - p == s {
                1.0
            } else {
                0.0
            }
        });
        let g = basis.qr().compute_Q();
        self.transform(j, &g);
        for r in q..q + p {
            for s in 0..q {
                self.t[(j + r, j + s)] = 0.0;
            }
        }
    }
}

fn block_size(t: &Mat<f64>, i: usize) -> usize {
    if i + 1 < t.nrows() && t[(i + 1, i)] != 0.0 { 2 } else { 1 }
}

/// Start and size of every diagonal block of a quasi triangular matrix.
pub(super) fn quasi_blocks(t: &Mat<f64>) -> Vec<(usize, usize)> {
    let (mut list, mut i) = (Vec::new(), 0);
    while i < t.nrows() {
        let size = block_size(t, i);
        list.push((i, size));
        i += size;
    }
    list
}

fn block_eigenvalues(t: &Mat<f64>, i: usize, size: usize) -> (c64, c64) {
    if size == 1 {
        let x = c64::new(t[(i, i)], 0.0);
        return (x, x);
    }
    let (a, b, c, d) = (t[(i, i)], t[(i, i + 1)], t[(i + 1, i)], t[(i + 1, i + 1)]);
    let (mean, half) = (0.5 * (a + d), 0.5 * (a - d));
    let disc = half * half + b * c;
    if disc >= 0.0 {
        let root = disc.sqrt();
        (c64::new(mean + root, 0.0), c64::new(mean - root, 0.0))
    } else {
        let root = (-disc).sqrt();
        (c64::new(mean, root), c64::new(mean, -root))
    }
}

/// X with L X + X Rᵀ = C, column by column, for L of order p and R of order q up to 2, by their entries.
pub(super) fn small_sylvester(
    [p, q]: [usize; 2],
    left: impl Fn(usize, usize) -> f64,
    right: impl Fn(usize, usize) -> f64,
    c: impl Fn(usize, usize) -> f64,
) -> [f64; 4] {
    let entry = |row: usize, column: usize| {
        let ((r1, c1), (r2, c2)) = ((row % p, row / p), (column % p, column / p));
        let by_left = if c1 == c2 { left(r1, r2) } else { 0.0 };
        let by_right = if r1 == r2 { right(c1, c2) } else { 0.0 };
        by_left + by_right
    };
    let (mut m, mut rhs) = ([[0.0; 4]; 4], [0.0; 4]);
    for row in 0..p * q {
        (0..p * q).for_each(|column| m[row][column] = entry(row, column));
        rhs[row] = c(row % p, row / p);
    }
    small_solve(p * q, m, rhs)
}

/// Solution of a system of order `n` up to 4 by Gaussian elimination with complete pivoting; a vanishing pivot is
/// replaced by one at rounding level, which is a backward error of that size.
fn small_solve(n: usize, mut m: [[f64; 4]; 4], mut x: [f64; 4]) -> [f64; 4] {
    let largest = m[..n].iter().flat_map(|row| &row[..n]);
    let largest = largest.fold(0.0f64, |most, entry| most.max(entry.abs()));
    let floor = (f64::EPSILON * largest).max(f64::MIN_POSITIVE);
    let mut order = [0, 1, 2, 3];
    for k in 0..n {
        let (mut pr, mut pc) = (k, k);
        for i in k..n {
            for j in k..n {
                if m[i][j].abs() > m[pr][pc].abs() {
                    (pr, pc) = (i, j);
                }
            }
        }
        m.swap(k, pr);
        x.swap(k, pr);
        m[..n].iter_mut().for_each(|row| row.swap(k, pc));
        order.swap(k, pc);
        let pivot_row = {
            let row = &mut m[k];
            if row[k].abs() < floor {
                row[k] = floor.copysign(row[k]);
            }
            *row
        };
        for i in k + 1..n {
            let f = m[i][k] / pivot_row[k];
            for j in k + 1..n {
                m[i][j] -= f * pivot_row[j];
            }
            x[i] -= f * x[k];
        }
    }
    for k in (0..n).rev() {
        let tail: f64 = (k + 1..n).map(|j| m[k][j] * x[j]).sum();
        x[k] = (x[k] - tail) / m[k][k];
    }
    let mut result = [0.0; 4];
    for k in 0..n {
        result[order[k]] = x[k];
    }
    result
}
