//! Matrices in doubled precision: each entry is an unevaluated sum hi + lo of two f64, about 32 digits.
//! Error-free sums (Knuth 1969) and products (Dekker 1971); dot products as Ogita, Rump and Oishi 2005.
//! Used for residuals only: a Newton step with a residual of 32 digits makes the solution exact to the last bit of
//! f64 whenever the equation can be solved at all.

use faer::Mat;

/// hi + lo, both n×m.
#[derive(Clone, Debug)]
pub(crate) struct Doubled {
    /// Leading part.
    pub hi: Mat<f64>,
    /// Rest, below half an ulp of the leading part.
    pub lo: Mat<f64>,
}

/// Sum and its exact rounding error.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let t = s - a;
    (s, (a - (s - t)) + (b - t))
}

/// Upper and lower half of the digits.
fn split(a: f64) -> (f64, f64) {
    // 2^27 + 1 halves the 53 digits.
    let c = 134_217_729.0 * a;
    let hi = c - (c - a);
    (hi, a - hi)
}

/// Product and its exact rounding error (no overflow below 1e290).
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let p = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    (p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
}

impl Doubled {
    /// An f64 matrix, exactly.
    pub(crate) fn from_f64(m: &Mat<f64>) -> Self {
        Self { hi: m.clone(), lo: Mat::zeros(m.nrows(), m.ncols()) }
    }

    /// The nearest f64 matrix.
    pub(crate) fn to_double(&self) -> Mat<f64> {
        Mat::from_fn(self.hi.nrows(), self.hi.ncols(), |i, j| self.hi[(i, j)] + self.lo[(i, j)])
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        let mut sum = self.clone();
        for j in 0..self.hi.ncols() {
            for i in 0..self.hi.nrows() {
                let (s, e) = two_sum(self.hi[(i, j)], other.hi[(i, j)]);
                let (hi, lo) = two_sum(s, e + (self.lo[(i, j)] + other.lo[(i, j)]));
                sum.hi[(i, j)] = hi;
                sum.lo[(i, j)] = lo;
            }
        }
        sum
    }

    /// The matrix times a power of two.
    pub(crate) fn scale_power(&self, power_of_two: f64) -> Self {
        let (n, m) = (self.hi.nrows(), self.hi.ncols());
        Self {
            hi: Mat::from_fn(n, m, |i, j| power_of_two * self.hi[(i, j)]),
            lo: Mat::from_fn(n, m, |i, j| power_of_two * self.lo[(i, j)]),
        }
    }

    pub(crate) fn transpose(&self) -> Self {
        Self { hi: self.hi.transpose().to_owned(), lo: self.lo.transpose().to_owned() }
    }

    /// self·other. Column-oriented: independent sums run side by side.
    pub(crate) fn times(&self, other: &Self) -> Self {
        let (n, m) = (self.hi.nrows(), other.hi.ncols());
        let mut product = Self::from_f64(&Mat::zeros(n, m));
        for j in 0..m {
            let (bh, bl) = (other.hi.col_as_slice(j), other.lo.col_as_slice(j));
            let sum = product.hi.col_as_slice_mut(j);
            let rest = product.lo.col_as_slice_mut(j);
            for (k, (&b, &b_low)) in bh.iter().zip(bl).enumerate() {
                if b == 0.0 {
                    continue;
                }
                let (ah, al) = (self.hi.col_as_slice(k), self.lo.col_as_slice(k));
                for ((s, r), (&a, &a_low)) in sum.iter_mut().zip(rest.iter_mut()).zip(ah.iter().zip(al)) {
                    let (p, e) = two_product(a, b);
                    let (t, f) = two_sum(*s, p);
                    *s = t;
                    *r += e + f + (a * b_low + a_low * b);
                }
            }
            for (s, r) in sum.iter_mut().zip(rest.iter_mut()) {
                (*s, *r) = two_sum(*s, *r);
            }
        }
        product
    }
}

impl Doubled {
    /// MᵀM of an f64 matrix.
    pub(crate) fn gram(m: &Mat<f64>) -> Self {
        let n = m.ncols();
        let exact = Self::from_f64(m);
        let mut product = Self::from_f64(&Mat::zeros(n, n));
        for j in 0..n {
            for i in 0..n {
                let (hi, lo) = exact.column_dot(i, &exact, j, m.nrows());
                product.hi[(i, j)] = hi;
                product.lo[(i, j)] = lo;
            }
        }
        product
    }

    /// selfᵀ·other.
    pub(crate) fn transpose_times(&self, other: &Self) -> Self {
        let (n, m, rows) = (self.hi.ncols(), other.hi.ncols(), self.hi.nrows());
        let mut product = Self::from_f64(&Mat::zeros(n, m));
        for j in 0..m {
            for i in 0..n {
                let (hi, lo) = self.column_dot(i, other, j, rows);
                product.hi[(i, j)] = hi;
                product.lo[(i, j)] = lo;
            }
        }
        product
    }

    /// Dot product of the first `rows` entries of two columns.
    fn column_dot(&self, i: usize, other: &Self, j: usize, rows: usize) -> (f64, f64) {
        let (ah, al) = (self.hi.col_as_slice(i), self.lo.col_as_slice(i));
        let (bh, bl) = (other.hi.col_as_slice(j), other.lo.col_as_slice(j));
        let (mut sum, mut rest) = (0.0, 0.0);
        for k in 0..rows {
            let (p, e) = two_product(ah[k], bh[k]);
            let (s, f) = two_sum(sum, p);
            sum = s;
            rest += e + f + (ah[k] * bl[k] + al[k] * bh[k]);
        }
        two_sum(sum, rest)
    }

    /// Lower triangular L with self = L Lᵀ for a symmetric non-negative matrix. A pivot at the floor of doubled
    /// precision ends its column: zeros.
    pub(crate) fn cholesky(&self) -> Self {
        let n = self.hi.nrows();
        // Works on Lᵀ, whose columns are contiguous rows of L.
        let mut t = Self::from_f64(&Mat::zeros(n, n));
        for j in 0..n {
            let (dot, rest) = t.column_dot(j, &t, j, j);
            let (s, e) = two_sum(self.hi[(j, j)], -dot);
            let pivot = two_sum(s, e + self.lo[(j, j)] - rest);
            // Rounding of n terms at 2⁻¹⁰⁶.
            if pivot.0 <= 1e-30 * n as f64 * self.hi[(j, j)].abs() {
                continue;
            }
            let root = pivot.0.sqrt();
            let (p, pe) = two_product(root, root);
            let (rh, rl) = two_sum(root, ((pivot.0 - p) - pe + pivot.1) / (2.0 * root));
            t.hi[(j, j)] = rh;
            t.lo[(j, j)] = rl;
            for i in j + 1..n {
                let (dot, rest) = t.column_dot(i, &t, j, j);
                let (s, e) = two_sum(self.hi[(i, j)], -dot);
                let (nh, nl) = two_sum(s, e + self.lo[(i, j)] - rest);
                let quotient = nh / rh;
                let (p, pe) = two_product(quotient, rh);
                let correction = ((nh - p) - pe + nl - quotient * rl) / rh;
                let (hi, lo) = two_sum(quotient, correction);
                t.hi[(j, i)] = hi;
                t.lo[(j, i)] = lo;
            }
        }
        t.transpose()
    }
}
