//! Sylvester and Lyapunov equations by real Schur forms (Bartels and Stewart 1972; Golub, Nash and Van Loan 1979).
//! Continuous: AᵀX + XA + Q = 0. Discrete: AᵀXA − X + Q = 0, through the bilinear map.
//! One kernel, TᵀY + YS = F with T and S quasi upper triangular, serves all of them. Cost O(n³).

use super::dense::{balance, solve};
use super::error::NumericError;
use super::schur::{RealSchur, quasi_blocks, schur, small_sylvester};
use faer::Mat;

/// X with AᵀX + XA + Q = 0 for symmetric Q; A has no two eigenvalues that sum to zero.
///
/// # Errors
/// [`NumericError`] when the Schur form fails or the equation is singular.
pub fn lyapunov(a: &Mat<f64>, q: &Mat<f64>) -> Result<Mat<f64>, NumericError> {
    let form = schur(a)?;
    finite(lyapunov_with(&form, q), "Lyapunov equation")
}

/// X with AᵀX + XA + Q = 0 from the Schur form of A.
pub(crate) fn lyapunov_with(form: &RealSchur, q: &Mat<f64>) -> Mat<f64> {
    let rotated = form.z.transpose() * q * &form.z;
    let f = Mat::from_fn(q.nrows(), q.ncols(), |i, j| -rotated[(i, j)]);
    let y = triangular_sylvester(&form.t, &form.t, f);
    symmetric(&(&form.z * y * form.z.transpose()))
}

/// Equations AᵀX + XA + Q = 0 with one A, whose rows and columns may be far apart in size: its Schur form is that of
/// D⁻¹AD with rows and columns evened out.
pub(crate) struct EvenedLyapunov {
    form: RealSchur,
    scale: Vec<f64>,
}

impl EvenedLyapunov {
    /// # Errors
    /// [`NumericError`] when the Schur form fails.
    pub(crate) fn new(a: &Mat<f64>) -> Result<Self, NumericError> {
        let (evened, scale) = balance(a);
        let form = schur(&evened)?;
        Ok(Self { form, scale })
    }

    /// X for a symmetric Q.
    pub(crate) fn solve(&self, q: &Mat<f64>) -> Mat<f64> {
        let (n, d) = (q.nrows(), &self.scale);
        let scaled = Mat::from_fn(n, n, |i, j| q[(i, j)] * d[i] * d[j]);
        let x = lyapunov_with(&self.form, &scaled);
        Mat::from_fn(n, n, |i, j| x[(i, j)] / d[i] / d[j])
    }
}

/// X with A X + X B = C; A is n×n, B m×m, C n×m.
///
/// # Errors
/// [`NumericError`] when a Schur form fails or A and −B share an eigenvalue.
pub fn sylvester(a: &Mat<f64>, b: &Mat<f64>, c: &Mat<f64>) -> Result<Mat<f64>, NumericError> {
    if a.nrows() == 0 || b.nrows() == 0 {
        return Ok(Mat::zeros(a.nrows(), b.nrows()));
    }
    // Aᵀ = U T Uᵀ makes A = U Tᵀ Uᵀ, which is what the kernel wants on the left.
    let (left, right) = (schur(&a.transpose().to_owned())?, schur(b)?);
    let f = left.z.transpose() * c * &right.z;
    let y = triangular_sylvester(&left.t, &right.t, f);
    finite(&left.z * y * right.z.transpose(), "Sylvester equation")
}

/// X with AᵀXA − X + Q = 0 for symmetric Q; all eigenvalues of A inside the unit circle.
/// With Ac = (A − I)(A + I)⁻¹ the equation is AcᵀX + XAc + 2(A + I)⁻ᵀQ(A + I)⁻¹ = 0.
///
/// # Errors
/// [`NumericError`] when A has the eigenvalue −1 or the continuous equation fails.
pub fn discrete_lyapunov(a: &Mat<f64>, q: &Mat<f64>) -> Result<Mat<f64>, NumericError> {
    let n = a.nrows();
    let one = Mat::<f64>::identity(n, n);
    let plus = (a + &one).transpose().to_owned();
    let minus = (a - &one).transpose().to_owned();
    let ac = solve(&plus, &minus)?.transpose().to_owned();
    let half = solve(&plus, q)?;
    let qc = solve(&plus, &half.transpose().to_owned())?;
    lyapunov(&ac, &symmetric(&Mat::from_fn(n, n, |i, j| 2.0 * qc[(i, j)])))
}

/// (M + Mᵀ)/2.
pub fn symmetric(m: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| 0.5 * (m[(i, j)] + m[(j, i)]))
}

/// Y with TᵀY + YS = F, T and S quasi upper triangular.
fn triangular_sylvester(t: &Mat<f64>, s: &Mat<f64>, mut f: Mat<f64>) -> Mat<f64> {
    let (rows, cols) = (quasi_blocks(t), quasi_blocks(s));
    for &(j, w) in &cols {
        for c in j..j + w {
            for l in 0..j {
                let factor = s[(l, c)];
                if factor != 0.0 {
                    for i in 0..t.nrows() {
                        f[(i, c)] -= f[(i, l)] * factor;
                    }
                }
            }
        }
        for &(i, h) in &rows {
            for c in j..j + w {
                for r in i..i + h {
                    let (tc, fc) = (&t.col_as_slice(r)[..i], &f.col_as_slice(c)[..i]);
                    let sum: f64 = tc.iter().zip(fc).map(|(x, y)| x * y).sum();
                    f[(r, c)] -= sum;
                }
            }
            if h == 1 && w == 1 {
                let d = t[(i, i)] + s[(j, j)];
                f[(i, j)] /= d;
                continue;
            }
            let found = small_sylvester(
                [h, w],
                |r1, r2| t[(i + r2, i + r1)],
                |c1, c2| s[(j + c2, j + c1)],
                |r, c| f[(i + r, j + c)],
            );
            for (x, value) in found[..h * w].iter().enumerate() {
                f[(i + x % h, j + x / h)] = *value;
            }
        }
    }
    f
}

fn finite(x: Mat<f64>, what: &'static str) -> Result<Mat<f64>, NumericError> {
    if x.is_all_finite() { Ok(x) } else { Err(NumericError::Singular { what, rcond: 0.0 }) }
}
