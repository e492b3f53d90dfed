//! Stabilising solution of the continuous algebraic Riccati equation  AᵀX + XA − XGX + Q = 0, G and Q symmetric,
//! possibly indefinite. Symbols: X symmetric, A − GX stable.
//! Roads: structured doubling with several shifts, and the ordered Schur form of the Hamiltonian (Laub 1979), both on
//! data balanced by a diagonal similarity of the Hamiltonian that keeps its structure; then Newton steps, whose
//! residual [`care`] evaluates in doubled precision: X comes out right to the last bit.

use super::balance::balance_scales;
use super::dense::solve;
use super::doubled::Doubled;
use super::doubling::doubling;
use super::error::NumericError;
use super::lyapunov::{EvenedLyapunov, symmetric};
use super::real_eigenvalues::eigenvalues;
use super::schur::schur;
use faer::{Mat, c64};
use thiserror::Error;

/// Why there is no stabilising solution to return.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RiccatiError {
    /// G, Q or R is not symmetric.
    #[error("{which} is not symmetric: entries ({row}, {col}) and ({col}, {row}) differ")]
    NotSymmetric {
        /// "G", "Q" or "R".
        which: &'static str,
        /// Row.
        row: usize,
        /// Column.
        col: usize,
    },
    /// The Hamiltonian has eigenvalues on the imaginary axis.
    #[error(
        "the Hamiltonian has an eigenvalue on the imaginary axis (at about {omega_rad_s:.6e} rad/s): \
         no stabilising solution exists"
    )]
    AxisEigenvalue {
        /// Frequency, rad/s.
        omega_rad_s: f64,
    },
    /// The symplectic pencil of an equation in sampled time has eigenvalues on the unit circle.
    #[error(
        "the symplectic pencil has an eigenvalue on the unit circle (at an angle of about {angle_rad:.6e} rad): no \
         stabilising solution exists"
    )]
    CircleEigenvalue {
        /// Its angle, rad.
        angle_rad: f64,
    },
    /// The stable invariant subspace exists but is no graph of a matrix, or the pair cannot be stabilised.
    #[error(
        "no stabilising solution found (best relative residual {residual:.1e}, \
         closed-loop growth rate {closed_loop_max_real:.3e})"
    )]
    NoStabilisingSolution {
        /// Best relative residual.
        residual: f64,
        /// Largest real part of the eigenvalues of A − GX, NaN when no X was found.
        closed_loop_max_real: f64,
    },
    /// Wrong shapes, bad data, failed iteration.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}

/// Solution with its certificate.
#[derive(Clone, Debug)]
pub struct CareSolution {
    /// X, n×n, symmetric.
    pub x: Mat<f64>,
    /// ‖AᵀX + XA − XGX + Q‖ / (2‖AᵀX‖ + ‖XGX‖ + ‖Q‖), Frobenius norms, in the balanced coordinates.
    pub residual: f64,
    /// Largest real part of the eigenvalues of A − GX, negative.
    pub closed_loop_max_real: f64,
}

impl CareSolution {
    /// True where Newton's method may begin: from any stabilising start it converges when G ≥ 0 (Kleinman 1968); one
    /// that is close may look unstable for rounding alone. The result is judged anyway.
    fn is_start(&self) -> bool {
        self.closed_loop_max_real < 0.0 || self.residual < USABLE
    }
}

/// Which roads to take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RiccatiEffort {
    /// First road that gives a stable closed loop and a residual that tells whether there is a solution, not its last
    /// digits; f64 only.
    Decision,
    /// First road that gives a small residual and a stable closed loop; f64 only.
    Fast,
    /// Refined in doubled precision until X is right to the last bit.
    Full,
}

/// Solves with [`RiccatiEffort::Full`].
///
/// # Errors
/// See [`RiccatiError`].
pub fn care(a: &Mat<f64>, g: &Mat<f64>, q: &Mat<f64>) -> Result<CareSolution, RiccatiError> {
    care_with(a, g, q, RiccatiEffort::Full)
}

/// Solves with the effort asked.
///
/// # Errors
/// See [`RiccatiError`].
pub fn care_with(
    a: &Mat<f64>,
    g: &Mat<f64>,
    q: &Mat<f64>,
    effort: RiccatiEffort,
) -> Result<CareSolution, RiccatiError> {
    check(a, g, q)?;
    let n = a.nrows();
    if n == 0 {
        return Ok(CareSolution { x: Mat::zeros(0, 0), residual: 0.0, closed_loop_max_real: f64::NEG_INFINITY });
    }
    let scale = balance_hamiltonian(a, g, q);
    let data = RiccatiData {
        a: Mat::from_fn(n, n, |i, j| a[(i, j)] * scale[j] / scale[i]),
        g: Mat::from_fn(n, n, |i, j| g[(i, j)] / scale[i] / scale[j]),
        q: Mat::from_fn(n, n, |i, j| q[(i, j)] * scale[i] * scale[j]),
    };
    let found = match effort {
        RiccatiEffort::Decision => data.first_good(DECIDES),
        RiccatiEffort::Fast => data.first_good(GOOD),
        RiccatiEffort::Full => data.best_refined().map_err(|failed| data.diagnose(&failed)),
    }?;
    Ok(CareSolution { x: Mat::from_fn(n, n, |i, j| found.x[(i, j)] / scale[i] / scale[j]), ..found })
}

/// Residual below which a solution counts as found by the fast road; the γ iteration needs no more.
const GOOD: f64 = 1e-10;
/// The same where only the existence of a solution is asked.
const DECIDES: f64 = 1e-7;
/// Share of its modulus by which an eigenvalue on the axis is off it for rounding: found are 1e-14 to 1e-12. A side of
/// an H∞ problem whose level is 1e-9 above the smallest has them off by 1e-5.
const ON_AXIS: f64 = 1e-11;
/// Residual above which a candidate is no start for Newton's method, unless it stabilises.
const USABLE: f64 = 1e-3;

struct RiccatiData {
    a: Mat<f64>,
    g: Mat<f64>,
    q: Mat<f64>,
}

impl RiccatiData {
    fn candidate(&self, x: Mat<f64>) -> CareSolution {
        let ax = self.a.transpose() * &x;
        let xgx = &x * &self.g * &x;
        let defect = (&ax + ax.transpose() - &xgx + &self.q).norm_l2();
        let size = 2.0 * ax.norm_l2() + xgx.norm_l2() + self.q.norm_l2();
        CareSolution {
            residual: if defect == 0.0 { 0.0 } else { defect / size },
            closed_loop_max_real: growth(&(&self.a - &self.g * &x)),
            x,
        }
    }

    fn shifts(&self) -> [f64; 3] {
        let n = self.a.nrows() as f64;
        let base = (self.a.norm_l2() / n.sqrt())
            .max((self.g.norm_l2() * self.q.norm_l2()).sqrt() / n)
            .max(f64::MIN_POSITIVE.sqrt());
        [base, 8.0 * base, base / 8.0]
    }

    fn by_schur(&self) -> Option<Mat<f64>> {
        let n = self.a.nrows();
        let (form, stable) = schur(&self.hamiltonian()).ok()?.reorder(|v| v.re < 0.0);
        if stable != n {
            return None;
        }
        let u1t = Mat::from_fn(n, n, |i, j| form.z[(j, i)]);
        let u2t = Mat::from_fn(n, n, |i, j| form.z[(n + j, i)]);
        solve(&u1t, &u2t).ok().map(|x| symmetric(&x))
    }

    fn hamiltonian(&self) -> Mat<f64> {
        let n = self.a.nrows();
        Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
            (true, true) => self.a[(i, j)],
            (true, false) => -self.g[(i, j - n)],
            (false, true) => -self.q[(i - n, j)],
            (false, false) => -self.a[(j - n, i - n)],
        })
    }

    fn first_good(&self, good: f64) -> Result<CareSolution, RiccatiError> {
        let mut failed = Vec::new();
        for road in 0..4 {
            let Some(x) = self.road(road) else {
                // Doubling goes on for ever where an eigenvalue is on the axis, and no other road leads anywhere.
                match self.nearest_the_axis().filter(|_| road == 0) {
                    Some(v) if v.re.abs() <= ON_AXIS * v.norm() => {
                        let omega_rad_s = v.im.abs();
                        return Err(RiccatiError::AxisEigenvalue { omega_rad_s });
                    }
                    _ => continue,
                }
            };
            let mut found = self.candidate(x);
            if found.residual > good && found.residual < USABLE && found.closed_loop_max_real < 0.0 {
                found = self.newton(found);
            }
            if found.residual <= good && found.closed_loop_max_real < 0.0 {
                return Ok(found);
            }
            failed.push(found);
        }
        // Ill-conditioned, but not hopeless: residuals of f64 are noise here, those of doubled precision are not.
        let mut starts = failed.iter().filter(|c| c.is_start());
        let refined = starts.find_map(|c| self.refine_solution(&c.x));
        refined.ok_or_else(|| self.diagnose(&failed))
    }

    /// One Newton step in f64, kept when it helps.
    fn newton(&self, start: CareSolution) -> CareSolution {
        let x = &start.x;
        let ax = self.a.transpose() * x;
        let residual = symmetric(&(&ax + ax.transpose() - x * &self.g * x + &self.q));
        let Ok(closed) = EvenedLyapunov::new(&(&self.a - &self.g * x)) else {
            return start;
        };
        let better = self.candidate(symmetric(&(x + closed.solve(&residual))));
        if better.residual < start.residual && better.closed_loop_max_real < 0.0 { better } else { start }
    }

    /// The first start that Newton's method refines to the last bit: then no other road can be better.
    fn best_refined(&self) -> Result<CareSolution, Vec<CareSolution>> {
        let mut failed = Vec::new();
        for road in 0..4 {
            let Some(x) = self.road(road) else { continue };
            let start = self.candidate(x);
            if start.is_start()
                && let Some(found) = self.refine_solution(&start.x)
            {
                return Ok(found);
            }
            failed.push(start);
        }
        Err(failed)
    }

    /// Three doublings with different shifts, then the ordered Schur form.
    fn road(&self, index: usize) -> Option<Mat<f64>> {
        match self.shifts().get(index) {
            Some(shift) => doubling(&self.a, &self.g, &self.q, *shift),
            None => self.by_schur(),
        }
    }

    /// Newton steps with residuals of 32 digits until the correction is below half an ulp. None when they do not
    /// settle, which is what happens when the closed loop has an eigenvalue on the axis.
    fn refine_solution(&self, start: &Mat<f64>) -> Option<CareSolution> {
        // Every step gains log10(1/(ε·cond)) digits; a problem that gains less than one digit a step is singular.
        const LIMIT: usize = 40;
        let n = self.a.nrows();
        let (a, g, q) = (Doubled::from_f64(&self.a), Doubled::from_f64(&self.g), Doubled::from_f64(&self.q));
        let mut x = Doubled::from_f64(start);
        let mut closed = EvenedLyapunov::new(&(&self.a - &self.g * start)).ok()?;
        let (mut last, mut settled) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..LIMIT {
            // AᵀX + XA − XGX + Q = XW + (XW)ᵀ + Q with W = A − GX/2.
            let w = a.plus(&g.times(&x).scale_power(-0.5));
            let p = x.times(&w);
            let residual = p.plus(&p.transpose()).plus(&q).to_double();
            let step = closed.solve(&residual);
            let rounded = x.to_double();
            if !step.is_all_finite() {
                return None;
            }
            let size = (0..n)
                .flat_map(|j| (0..n).map(move |i| (i, j)))
                .map(|(i, j)| {
                    // Each entry counts against its own size: small entries must be right as well.
                    let own = (rounded[(i, i)] * rounded[(j, j)]).abs().sqrt();
                    step[(i, j)].abs() / rounded[(i, j)].abs().max(1e-16 * own).max(1e-300)
                })
                .fold(0.0, f64::max);
            settled = step.norm_l2() / rounded.norm_l2().max(f64::MIN_POSITIVE);
            x = x.plus(&Doubled::from_f64(&step));
            if size < 1e-17 || settled == 0.0 {
                break;
            }
            if settled > 1e-8 {
                closed = EvenedLyapunov::new(&(&self.a - &self.g * x.to_double())).ok()?;
            } else if settled >= last {
                break;
            }
            last = settled;
        }
        // Correction of the last step: anything larger means that digits of X are open.
        if settled > 1e-13 {
            return None;
        }
        // What is reported is the X that is returned, measured without the rounding of the measurement.
        let x = symmetric(&x.to_double());
        let exact = Doubled::from_f64(&x);
        let gx = g.times(&exact);
        let p = exact.times(&a.plus(&gx.scale_power(-0.5)));
        let defect = p.plus(&p.transpose()).plus(&q).to_double().norm_l2();
        let size = 2.0 * (self.a.transpose() * &x).norm_l2() + (&x * &self.g * &x).norm_l2() + self.q.norm_l2();
        let found = CareSolution {
            residual: if defect == 0.0 { 0.0 } else { defect / size },
            closed_loop_max_real: growth(&a.plus(&gx.scale_power(-1.0)).to_double()),
            x,
        };
        (found.closed_loop_max_real < 0.0).then_some(found)
    }

    /// The eigenvalue of the Hamiltonian whose angle to the imaginary axis is the smallest; none when they fail.
    fn nearest_the_axis(&self) -> Option<c64> {
        let share = |v: &c64| v.re.abs() / v.norm().max(1e-300);
        let values = eigenvalues(&self.hamiltonian()).ok()?;
        values.into_iter().min_by(|x, y| share(x).total_cmp(&share(y)))
    }

    fn diagnose(&self, failed: &[CareSolution]) -> RiccatiError {
        // Eigenvalues on the axis split by the square root of the rounding error.
        let tolerance = f64::EPSILON.sqrt() * 10.0;
        if let Some(v) = self.nearest_the_axis()
            && (v.re.abs() <= tolerance * v.norm()
                || v.norm() <= f64::EPSILON.sqrt() * 1e-3 * self.hamiltonian().norm_max())
        {
            return RiccatiError::AxisEigenvalue { omega_rad_s: v.im.abs() };
        }
        let best = failed.iter().min_by(|x, y| x.residual.total_cmp(&y.residual));
        RiccatiError::NoStabilisingSolution {
            residual: best.map_or(f64::NAN, |b| b.residual),
            closed_loop_max_real: best.map_or(f64::NAN, |b| b.closed_loop_max_real),
        }
    }
}

/// Largest real part of the eigenvalues; NaN when they cannot be computed.
fn growth(a: &Mat<f64>) -> f64 {
    eigenvalues(a).map_or(f64::NAN, |values| {
        let parts = values.iter().map(|v| v.re);
        parts.fold(f64::NEG_INFINITY, f64::max)
    })
}

/// Diagonal T (powers of two) such that [T⁻¹AT, T⁻¹GT⁻¹; TQT, TᵀAᵀT⁻¹] has rows and columns of like size.
pub(crate) fn balance_hamiltonian(a: &Mat<f64>, g: &Mat<f64>, q: &Mat<f64>) -> Vec<f64> {
    let n = a.nrows();
    balance_scales(n, |t, i| {
        let (mut col, mut row) = (0.0, 0.0);
        for j in 0..n {
            if i != j {
                col += (a[(j, i)] * t[i] / t[j]).abs();
                row += (a[(i, j)] * t[j] / t[i]).abs();
            }
            col += (q[(j, i)] * t[i] * t[j]).abs();
            row += (g[(i, j)] / t[i] / t[j]).abs();
        }
        (row, col)
    })
}

fn check(a: &Mat<f64>, g: &Mat<f64>, q: &Mat<f64>) -> Result<(), RiccatiError> {
    let n = a.nrows();
    for m in [a, g, q] {
        if (m.nrows(), m.ncols()) != (n, n) {
            return Err(NumericError::Dimension {
                what: "Riccati equation",
                expected: format!("A, G, Q of order {n}"),
                found: format!("{} x {}", m.nrows(), m.ncols()),
            }
            .into());
        }
        if !m.is_all_finite() {
            return Err(NumericError::NotFinite { what: "Riccati equation" }.into());
        }
    }
    check_symmetry("G", g)?;
    check_symmetry("Q", q)
}

/// Refuses a matrix that is not symmetric.
pub(super) fn check_symmetry(which: &'static str, m: &Mat<f64>) -> Result<(), RiccatiError> {
    // Data that was formed in f64 is symmetric up to rounding; more is a mistake of the user.
    let tolerance = 1e-10 * m.norm_max();
    let pairs = (0..m.nrows()).flat_map(|row| (0..row).map(move |col| (row, col)));
    for (row, col) in pairs {
        if (m[(row, col)] - m[(col, row)]).abs() > tolerance {
            return Err(RiccatiError::NotSymmetric { which, row, col });
        }
    }
    Ok(())
}
