//! Ordered real Schur form A = Z T Zᵀ with T quasi upper triangular (1×1 and 2×2 diagonal blocks).
//! faer has no public Schur form; its unblocked QZ on the pencil (A, I) gives one: Q'AZ = S and Q'Z = diag(±1),
//! so T = diag(±1)·S. The blocked QZ is avoided (slow and inaccurate from order 75).
//! The matrix is scaled to norm one first, and entries whose squares underflow are set to zero: the QZ makes NaN of
//! them.
//! Reordering: direct swapping of adjacent blocks (Bai and Demmel 1993).

use super::dense::{NEGLIGIBLE, unit_of};
use super::error::NumericError;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::evd::ComputeEigenvectors;
use faer::linalg::gevd::{self, GeneralizedSchurParams};
use faer::{Auto, Col, Mat, Par, c64};

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
        return Ok(RealSchur {
            z: Mat::identity(n, n),
            t: a.clone(),
        });
    }
    let unit = unit_of(a.norm_max());
    let scaled = Mat::from_fn(n, n, |i, j| match a[(i, j)] / unit {
        x if x.abs() < NEGLIGIBLE => 0.0,
        x => x,
    });
    let (mut s, mut p) = (scaled.clone(), Mat::<f64>::identity(n, n));
    let (mut q, mut z) = (Mat::<f64>::identity(n, n), Mat::<f64>::identity(n, n));
    let hessenberg: gevd::gen_hessenberg::GeneralizedHessenbergParams = <_ as Auto<f64>>::auto();
    let mut params: GeneralizedSchurParams = <_ as Auto<f64>>::auto();
    params.blocking_threshold = 1 << 20;
    let mut buffer = MemBuffer::new(StackReq::any_of(&[
        gevd::gen_hessenberg::generalized_hessenberg_scratch::<f64>(n, hessenberg),
        gevd::qz_real::hessenberg_to_qz_scratch::<f64>(n, Par::Seq, params),
    ]));
    let stack = MemStack::new(&mut buffer);
    gevd::gen_hessenberg::generalized_hessenberg(
        s.as_mut(),
        p.as_mut(),
        Some(q.as_mut()),
        Some(z.as_mut()),
        Par::Seq,
        stack,
        hessenberg,
    );
    let (mut re, mut im) = (Col::<f64>::zeros(n), Col::<f64>::zeros(n));
    let mut beta = Col::<f64>::zeros(n);
    gevd::qz_real::hessenberg_to_qz(
        s.as_mut(),
        p.as_mut(),
        Some(q.as_mut()),
        Some(z.as_mut()),
        re.as_mut(),
        im.as_mut(),
        beta.as_mut(),
        ComputeEigenvectors::Yes,
        Par::Seq,
        params,
        stack,
    );
    let t = Mat::from_fn(n, n, |i, j| {
        if i > j + 1 {
            0.0
        } else {
            s[(i, j)] * p[(i, i)].signum()
        }
    });
    let mut form = RealSchur { z, t };
    form.deflate();
    let overlap = form.blocks_overlap();
    form.split();
    let defect = (&form.z * &form.t - &scaled * &form.z).norm_l2();
    // Backward stable QZ stays below 1e-13 up to order 400; a failed sweep leaves a defect of order one.
    if overlap || defect.is_nan() || defect > 1e-11 * scaled.norm_l2() {
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
    pub fn ordered(mut self, select: impl Fn(c64) -> bool) -> (Self, usize) {
        let (mut done, mut i) = (0, 0);
        let n = self.t.nrows();
        while i < n {
            let size = block_size(&self.t, i);
            if select(block_eigenvalues(&self.t, i, size).0) {
                let above: Vec<_> = quasi_blocks(&self.t)
                    .into_iter()
                    .filter(|(start, _)| (done..i).contains(start))
                    .collect();
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

    /// Sets negligible entries below the diagonal of a form of norm one to zero.
    fn deflate(&mut self) {
        let norm = self.t.norm_max();
        for i in 0..self.t.nrows().saturating_sub(1) {
            let scale = self.t[(i, i)].abs() + self.t[(i + 1, i + 1)].abs();
            let scale = if scale > 0.0 { scale } else { norm };
            // Deflation threshold of the QR algorithm.
            if self.t[(i + 1, i)].abs() <= (f64::EPSILON * scale).max(NEGLIGIBLE) {
                self.t[(i + 1, i)] = 0.0;
            }
        }
    }

    /// True where a diagonal block is larger than 2×2.
    fn blocks_overlap(&self) -> bool {
        (2..self.t.nrows()).any(|i| self.t[(i, i - 1)] != 0.0 && self.t[(i - 1, i - 2)] != 0.0)
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
            let (first, second) = block_eigenvalues(&self.t, i, 2);
            if first.im == 0.0 {
                // Eigenvector of the eigenvalue farther from t22: no cancellation.
                let d = self.t[(i + 1, i + 1)];
                let value = if (first.re - d).abs() > (second.re - d).abs() {
                    first.re
                } else {
                    second.re
                };
                let (x, y) = (value - d, self.t[(i + 1, i)]);
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
            let old: [f64; 4] =
                std::array::from_fn(|r| if r < k { self.t[(i + r, col)] } else { 0.0 });
            for r in 0..k {
                self.t[(i + r, col)] = (0..k).map(|l| g[(l, r)] * old[l]).sum();
            }
        }
        for m in [&mut self.t, &mut self.z] {
            for row in 0..n {
                let old: [f64; 4] =
                    std::array::from_fn(|r| if r < k { m[(row, i + r)] } else { 0.0 });
                for r in 0..k {
                    m[(row, i + r)] = (0..k).map(|l| old[l] * g[(l, r)]).sum();
                }
            }
        }
    }

    /// Swaps the block of size p at j with the one of size q below it.
    pub(super) fn swap(&mut self, j: usize, p: usize, q: usize) {
        let part = |r: usize, c: usize, h: usize, w: usize| {
            Mat::from_fn(h, w, |k, l| self.t[(j + r + k, j + c + l)])
        };
        let (a, b, c) = (part(0, 0, p, p), part(p, p, q, q), part(0, p, p, q));
        // A X − X B = C; the columns of [−X; I] span the invariant subspace of B.
        let k = Mat::from_fn(p * q, p * q, |r, s| {
            let ((r1, c1), (r2, c2)) = ((r % p, r / p), (s % p, s / p));
            let left = if c1 == c2 { a[(r1, r2)] } else { 0.0 };
            let right = if r1 == r2 { b[(c2, c1)] } else { 0.0 };
            left - right
        });
        let rhs: Vec<f64> = (0..p * q).map(|r| c[(r % p, r / p)]).collect();
        let x = small_solve(&k, &rhs);
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
    if i + 1 < t.nrows() && t[(i + 1, i)] != 0.0 {
        2
    } else {
        1
    }
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

/// Solution of a system of order up to 4 by Gaussian elimination with complete pivoting; a vanishing pivot is
/// replaced by one at rounding level, which is a backward error of that size.
pub(super) fn small_solve(a: &Mat<f64>, b: &[f64]) -> Vec<f64> {
    let n = b.len();
    let (mut m, mut x) = (a.clone(), b.to_vec());
    let floor = (f64::EPSILON * a.norm_max()).max(f64::MIN_POSITIVE);
    let mut order: Vec<usize> = (0..n).collect();
    for k in 0..n {
        let (mut pr, mut pc) = (k, k);
        for i in k..n {
            for j in k..n {
                if m[(i, j)].abs() > m[(pr, pc)].abs() {
                    (pr, pc) = (i, j);
                }
            }
        }
        for j in 0..n {
            let swap = m[(k, j)];
            m[(k, j)] = m[(pr, j)];
            m[(pr, j)] = swap;
        }
        x.swap(k, pr);
        for i in 0..n {
            let swap = m[(i, k)];
            m[(i, k)] = m[(i, pc)];
            m[(i, pc)] = swap;
        }
        order.swap(k, pc);
        if m[(k, k)].abs() < floor {
            m[(k, k)] = if m[(k, k)] < 0.0 { -floor } else { floor };
        }
        for i in k + 1..n {
            let f = m[(i, k)] / m[(k, k)];
            for j in k + 1..n {
                m[(i, j)] -= f * m[(k, j)];
            }
            x[i] -= f * x[k];
        }
    }
    for k in (0..n).rev() {
        let tail: f64 = (k + 1..n).map(|j| m[(k, j)] * x[j]).sum();
        x[k] = (x[k] - tail) / m[(k, k)];
    }
    let mut result = vec![0.0; n];
    for (k, value) in x.into_iter().enumerate() {
        result[order[k]] = value;
    }
    result
}
