//! Riccati equations of the cost x'Qx + 2x'Su + u'Ru on a system A, B, in continuous and in sampled time:
//!   A'X + XA + Q − (XB + S)F = 0,  F = R⁻¹(B'X + S');
//!   A'XA − X + Q − (A'XB + S)F = 0,  F = (R + B'XB)⁻¹(B'XA + S').
//! X is stabilising: A − BF is stable, u = −Fx. It comes from doubling, then from Newton steps on the equation as
//! given, with residuals of doubled precision, so that neither R⁻¹ nor a large X costs digits.

use super::dense::solve;
use super::doubled::Doubled;
use super::doubling::double_until_settled;
use super::error::NumericError;
use super::lyapunov::{EvenedLyapunov, discrete_lyapunov, symmetric};
use super::real_eigenvalues::eigenvalues;
use super::riccati::{RiccatiEffort, RiccatiError, balance_hamiltonian, care_with, check_symmetry};
use faer::{Mat, c64};

/// Cost and system.
#[derive(Clone, Debug)]
pub struct Regulator {
    /// A, n×n.
    pub a: Mat<f64>,
    /// B, n×m.
    pub b: Mat<f64>,
    /// Q, n×n, symmetric.
    pub q: Mat<f64>,
    /// R, m×m, symmetric; regular in continuous time.
    pub r: Mat<f64>,
    /// S, n×m.
    pub s: Mat<f64>,
    /// Whether A and B are those of sampled time.
    pub is_sampled: bool,
}

/// Stabilising solution with its certificate.
#[derive(Clone, Debug)]
pub struct RegulatorSolution {
    /// X, n×n, symmetric.
    pub x: Mat<f64>,
    /// F, m×n: u = −Fx.
    pub gain: Mat<f64>,
    /// Norm of what is left of the equation per sum of the norms of its terms, in balanced states.
    pub residual: f64,
    /// Eigenvalues of A − BF.
    pub poles: Vec<c64>,
}

/// An equation at a candidate X.
struct Defect {
    gain: Mat<f64>,
    closed: Mat<f64>,
    residual: Mat<f64>,
    relative: f64,
}

impl Regulator {
    /// The stabilising solution.
    ///
    /// # Errors
    /// [`RiccatiError`]: shapes, data that are not symmetric or finite, R without an inverse, no stabilising solution.
    pub fn solve(&self) -> Result<RegulatorSolution, RiccatiError> {
        self.check()?;
        let n = self.a.nrows();
        if n == 0 {
            let gain = Mat::zeros(self.b.ncols(), 0);
            return Ok(RegulatorSolution { x: Mat::zeros(0, 0), gain, residual: 0.0, poles: vec![] });
        }
        // R as it is serves as well as its inverse to bring states to like size where there is none.
        let g = solve(&self.r, &self.b.transpose().to_owned()).unwrap_or_else(|_| self.b.transpose().to_owned());
        let t = balance_hamiltonian(&self.a, &symmetric(&(&self.b * g)), &self.q);
        let even = Self {
            a: Mat::from_fn(n, n, |i, j| self.a[(i, j)] * t[j] / t[i]),
            b: Mat::from_fn(n, self.b.ncols(), |i, j| self.b[(i, j)] / t[i]),
            q: Mat::from_fn(n, n, |i, j| self.q[(i, j)] * t[i] * t[j]),
            s: Mat::from_fn(n, self.b.ncols(), |i, j| self.s[(i, j)] * t[i]),
            ..self.clone()
        };
        let found = even.solve_balanced()?;
        Ok(RegulatorSolution {
            x: Mat::from_fn(n, n, |i, j| found.x[(i, j)] / t[i] / t[j]),
            gain: Mat::from_fn(found.gain.nrows(), n, |i, j| found.gain[(i, j)] / t[j]),
            ..found
        })
    }

    fn check(&self) -> Result<(), RiccatiError> {
        let (n, m) = (self.a.nrows(), self.b.ncols());
        let parts = [(&self.a, n, n), (&self.b, n, m), (&self.q, n, n), (&self.r, m, m), (&self.s, n, m)];
        for (part, rows, cols) in parts {
            if (part.nrows(), part.ncols()) != (rows, cols) {
                return Err(NumericError::Dimension {
                    what: "Riccati equation",
                    expected: format!("A, Q {n} x {n}, B, S {n} x {m}, R {m} x {m}"),
                    found: format!("{} x {}", part.nrows(), part.ncols()),
                }
                .into());
            }
            if !part.is_all_finite() {
                return Err(NumericError::NotFinite { what: "Riccati equation" }.into());
            }
        }
        check_symmetry("Q", &self.q)?;
        check_symmetry("R", &self.r)
    }

    fn solve_balanced(&self) -> Result<RegulatorSolution, RiccatiError> {
        if !self.is_sampled {
            let [a, g, q] = self.without_cross_term()?;
            let start = care_with(&a, &g, &q, RiccatiEffort::Fast)?.x;
            return self.refined(&start).map_err(unsolved);
        }
        // Y = X − αI satisfies the same equation with R + αB'B, S + αA'B, Q + α(A'A − I): a way round a singular R.
        let alpha = (self.q.norm_l2() + self.r.norm_l2()).max(f64::MIN_POSITIVE) / (self.a.nrows() as f64).sqrt();
        let mut failure = None;
        for shift in [0.0, alpha, 1e3 * alpha] {
            let candidate = self.shifted(shift).without_cross_term().map(|[a, g, q]| double_until_settled(a, g, q));
            match candidate {
                Ok(Some(y)) => {
                    let x = Mat::from_fn(y.nrows(), y.ncols(), |i, j| y[(i, j)] + if i == j { shift } else { 0.0 });
                    match self.refined(&x) {
                        Ok(found) => return Ok(found),
                        Err(residual) => failure = Some(unsolved(residual)),
                    }
                }
                Ok(None) => {}
                Err(error) => failure = failure.or(Some(error.into())),
            }
        }
        let on_circle = self.shifted(alpha).circle_eigenvalue();
        Err(on_circle.or(failure).unwrap_or_else(|| unsolved(f64::NAN)))
    }

    fn shifted(&self, alpha: f64) -> Self {
        let n = self.a.nrows();
        let plus =
            |m: &Mat<f64>, more: Mat<f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] + alpha * more[(i, j)]);
        let (at, bt) = (self.a.transpose(), self.b.transpose());
        Self {
            q: plus(&self.q, at * &self.a - Mat::<f64>::identity(n, n)),
            r: plus(&self.r, bt * &self.b),
            s: plus(&self.s, at * &self.b),
            ..self.clone()
        }
    }

    /// A − BR⁻¹S', BR⁻¹B', Q − SR⁻¹S'.
    fn without_cross_term(&self) -> Result<[Mat<f64>; 3], NumericError> {
        let inverted = |right: &Mat<f64>| {
            solve(&self.r, &right.transpose().to_owned()).map_err(|error| match error {
                NumericError::Singular { rcond, .. } => NumericError::Singular { what: "R", rcond },
                other => other,
            })
        };
        let (rb, rs) = (inverted(&self.b)?, inverted(&self.s)?);
        Ok([&self.a - &self.b * &rs, symmetric(&(&self.b * rb)), symmetric(&(&self.q - &self.s * rs))])
    }

    /// Newton steps from a start until the correction is rounding; the relative residual where they end above it.
    fn refined(&self, start: &Mat<f64>) -> Result<RegulatorSolution, f64> {
        // A step gains the digits that ε·cond leaves; twenty that gain less than one are hopeless.
        const LIMIT: usize = 20;
        let mut x = Doubled::from_f64(start);
        let (mut last, mut relative) = (f64::INFINITY, f64::NAN);
        for _ in 0..LIMIT {
            let Some(defect) = self.defect(&x) else { return Err(relative) };
            relative = defect.relative;
            let step = if self.is_sampled {
                discrete_lyapunov(&defect.closed, &defect.residual)
            } else {
                EvenedLyapunov::new(&defect.closed).map(|closed| closed.solve(&defect.residual))
            };
            let Ok(step) = step else { return Err(relative) };
            let change = step.norm_l2() / x.to_double().norm_l2().max(f64::MIN_POSITIVE);
            if !change.is_finite() {
                return Err(relative);
            }
            x = x.plus(&Doubled::from_f64(&step));
            // Half an ulp, or the floor that the conditioning sets.
            if change < 1e-17 || (last < 1e-8 && change >= last) {
                last = change;
                break;
            }
            last = change;
        }
        // What is reported is the X that is returned.
        let x = symmetric(&x.to_double());
        let Some(end) = self.defect(&Doubled::from_f64(&x)) else { return Err(relative) };
        let Ok(poles) = eigenvalues(&end.closed) else { return Err(end.relative) };
        // A larger correction means that digits of X are open.
        if last > 1e-12 || !poles.iter().all(|pole| self.is_stable(pole)) {
            return Err(end.relative);
        }
        Ok(RegulatorSolution { x, gain: end.gain, residual: end.relative, poles })
    }

    fn is_stable(&self, pole: &c64) -> bool {
        if self.is_sampled { pole.norm() < 1.0 } else { pole.re < 0.0 }
    }

    /// What X leaves of the equation; none where the matrix of F has no inverse.
    fn defect(&self, x: &Doubled) -> Option<Defect> {
        let exact = Doubled::from_f64;
        let (a, b, q) = (exact(&self.a), exact(&self.b), exact(&self.q));
        let bx = b.transpose_times(x);
        let (matrix, right, plain, sizes) = if self.is_sampled {
            let axa = a.transpose_times(&x.times(&a));
            let sizes = axa.to_double().norm_l2() + x.to_double().norm_l2();
            (exact(&self.r).plus(&bx.times(&b)), bx.times(&a), axa.plus(&x.scale_power(-1.0)), sizes)
        } else {
            let xa = x.times(&a);
            (exact(&self.r), bx, xa.plus(&xa.transpose()), 2.0 * xa.to_double().norm_l2())
        };
        let right = right.plus(&exact(&self.s).transpose());
        let rounded = matrix.to_double();
        let first = solve(&rounded, &right.to_double()).ok()?;
        let rest = right.plus(&matrix.times(&exact(&first)).scale_power(-1.0)).to_double();
        let gain = exact(&first).plus(&exact(&solve(&rounded, &rest).ok()?));
        let fed = right.transpose_times(&gain);
        let residual = symmetric(&plain.plus(&q).plus(&fed.scale_power(-1.0)).to_double());
        let left = residual.norm_l2();
        let size = sizes + fed.to_double().norm_l2() + self.q.norm_l2();
        let closed = a.plus(&b.times(&gain).scale_power(-1.0)).to_double();
        let relative = if left == 0.0 { 0.0 } else { left / size };
        Some(Defect { gain: gain.to_double(), closed, residual, relative })
    }

    /// The eigenvalue of the symplectic pencil [A 0; −Q I] − λ[I G; 0 A'] on the unit circle, if one is there.
    fn circle_eigenvalue(&self) -> Option<RiccatiError> {
        // A point off the circle that no eigenvalue of plain data meets.
        const POLE: f64 = 0.618_033_988_75;
        // Eigenvalues on the circle are double: they split by the root of the rounding error.
        let tolerance = 10.0 * f64::EPSILON.sqrt();
        let [a, g, q] = self.without_cross_term().ok()?;
        let n = a.nrows();
        let one = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let right = Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
            (true, true) => one(i, j),
            (true, false) => g[(i, j - n)],
            (false, true) => 0.0,
            (false, false) => a[(j - n, i - n)],
        });
        let left = Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
            (true, true) => a[(i, j)],
            (true, false) => 0.0,
            (false, true) => -q[(i - n, j)],
            (false, false) => one(i, j),
        });
        let shifted = Mat::from_fn(2 * n, 2 * n, |i, j| left[(i, j)] - POLE * right[(i, j)]);
        let inverses = eigenvalues(&solve(&shifted, &right).ok()?).ok()?;
        let mut values = inverses.into_iter().filter(|v| v.norm() > 0.0).map(|v| v.inv() + POLE);
        let found = values.find(|v| (v.norm() - 1.0).abs() <= tolerance)?;
        Some(RiccatiError::CircleEigenvalue { angle_rad: found.arg().abs() })
    }
}

fn unsolved(residual: f64) -> RiccatiError {
    RiccatiError::NoStabilisingSolution { residual, closed_loop_max_real: f64::NAN }
}
