//! A second-order factor of a weight, and how it is realised in the w plane of the sampled loop.
//!
//! |W|² is a ratio of quadratics in x = ω². With x = c (2/T)² ρ(X), the approximant of [`super::warp`], it is rational in
//! X = (vT/2)²; every root x = −r gives the roots X of r + c (2/T)² ρ(X) = 0, and s = −(2/T) √(−X) is stable. The factor
//! c makes the approximant exact at the corner: a resonance stays at its frequency.

use super::shape::{Root, Shape, Stage};
use super::warp::{APPROXIMANTS, Approximant, FittedWeight, base_points, ratio_range_over};
use crate::linalg::{Mat, NumericError, c64, eigenvalues_complex};
use crate::lti::{Continuous, StateSpace};

/// W(s) = (b₂ s² + b₁ s + b₀)/(a₂ s² + a₁ s + a₀), stable and minimum phase; a₂ positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondOrder {
    /// b₀, b₁, b₂.
    pub b: [f64; 3],
    /// a₀, a₁, a₂.
    pub a: [f64; 3],
}

impl SecondOrder {
    /// |W(jω)|.
    pub fn magnitude(&self, omega_rad_s: f64) -> f64 {
        let size = |c: &[f64; 3]| {
            let real = c[0] - c[2] * omega_rad_s.powi(2);
            real.hypot(c[1] * omega_rad_s)
        };
        size(&self.b) / size(&self.a)
    }

    /// State space; the states are scaled by the poles' corner.
    ///
    /// # Errors
    /// [`NumericError`] when a coefficient is not finite.
    pub fn system(&self) -> Result<StateSpace<Continuous>, NumericError> {
        let [b0, b1, b2] = self.b.map(|b| b / self.a[2]);
        let (square, damping) = (self.a[0] / self.a[2], self.a[1] / self.a[2]);
        let corner = square.sqrt();
        let a = [[0.0, corner], [-corner, -damping]];
        let c = [(b0 - b2 * square) / square, (b1 - b2 * damping) / corner];
        StateSpace::new(
            Mat::from_fn(2, 2, |i, j| a[i][j]),
            Mat::from_fn(2, 1, |i, _| if i == 0 { 0.0 } else { corner }),
            Mat::from_fn(1, 2, |_, j| c[j]),
            Mat::from_fn(1, 1, |_, _| b2),
            Continuous,
        )
    }

    /// The factor with `stretch` s in the place of s.
    #[must_use]
    fn stretched(&self, stretch: f64) -> Self {
        let own = |c: [f64; 3]| [c[0], c[1] * stretch, c[2] * stretch.powi(2)];
        Self {
            b: own(self.b),
            a: own(self.a),
        }
    }

    /// Corner and damping of the sharper of numerator and denominator.
    fn corner(&self) -> Option<(f64, f64)> {
        let of = |c: &[f64; 3]| {
            let omega = (c[0] / c[2]).sqrt();
            (omega, 0.5 * c[1] / (c[2] * omega))
        };
        let both = [&self.b, &self.a]
            .into_iter()
            .filter(|c| c[2] > 0.0)
            .map(of);
        both.filter(|(omega, damping)| omega.is_finite() && *damping < 1.0)
            .min_by(|x, y| x.1.total_cmp(&y.1))
    }

    /// The factor with v in the place of ω, its corner where it is written.
    pub(super) fn at_corner(&self, period_s: f64) -> Self {
        match self.corner() {
            Some((omega, _)) if 0.5 * omega * period_s < LAST_CORNER => {
                let theta = 0.5 * omega * period_s;
                self.stretched(theta / theta.tan())
            }
            _ => *self,
        }
    }

    /// The factor in the w plane, nowhere below the written one: the lowest order within `tolerance`, else the highest.
    ///
    /// # Errors
    /// [`NumericError`] when a coefficient is not finite, or the eigenvalues of a polynomial are not found.
    pub(super) fn fitted(
        &self,
        period_s: f64,
        tolerance: f64,
    ) -> Result<FittedWeight, NumericError> {
        let k = 2.0 / period_s;
        let written = |theta: f64| self.magnitude(k * theta);
        let lines = self.lines(period_s);
        let judged = |fit: &Shape| {
            let range = ratio_range_over(&lines, &|x| fit.magnitude(k * x.sqrt()), &written);
            (fit.clone(), range)
        };
        let plain = Shape {
            gain: 1.0,
            stages: vec![Stage::Second(self.at_corner(period_s))],
            excess_over_points: 0.0,
        };
        let mut candidates = vec![judged(&plain)];
        if candidates[0].1.1 > tolerance {
            let exact_at = self.corner().map(|(omega, _)| omega / k);
            for approximant in &APPROXIMANTS {
                let fit = self.substituted(approximant, k, exact_at)?;
                candidates.push(judged(&fit));
                if candidates.last().is_some_and(|c| c.1.1 <= tolerance) {
                    break;
                }
            }
        }
        // The one within the tolerance is the last; without one the closest is taken.
        let best = candidates
            .into_iter()
            .min_by(|x, y| x.1.1.total_cmp(&y.1.1));
        match best {
            Some((fit, (least, excess))) if excess.is_finite() && least > 0.0 => Ok(FittedWeight {
                system: fit.times(least.recip()).in_series(Stage::system)?,
                largest_excess: excess,
            }),
            _ => Err(NumericError::NotFinite {
                what: "second-order weight fitted in the w plane",
            }),
        }
    }

    /// ω² replaced by the approximant, exact at θ = `exact_at`.
    fn substituted(
        &self,
        approximant: &Approximant,
        k: f64,
        exact_at: Option<f64>,
    ) -> Result<Shape, NumericError> {
        let correction = exact_at
            .filter(|theta| *theta < LAST_CORNER)
            .map_or(1.0, |theta| {
                theta.powi(2) / approximant.value(theta.tan().powi(2))
            });
        let scale = correction * k.powi(2);
        let side = |c: &[f64; 3]| -> Result<Vec<Root>, NumericError> {
            let mut roots = vec![];
            for r in squares(c) {
                // Of each conjugate pair one: the conjugate of r gives that of u.
                let u = roots_of(approximant, r, scale)?;
                roots.extend(u.into_iter().map(|u| Root::of(-u.sqrt() * k)));
            }
            Ok(roots)
        };
        Shape::from_roots(self.b[0] / self.a[0], &side(&self.b)?, &side(&self.a)?)
    }

    /// Values X at which a fit is judged: many where the corner bends the magnitude.
    fn lines(&self, period_s: f64) -> Vec<f64> {
        let mut lines = base_points();
        if let Some((omega, damping)) = self.corner() {
            let theta = (0.5 * omega * period_s).min(LAST_CORNER);
            for step in -CLOSE..=CLOSE {
                // Steps of a fiftieth of the half width of the resonance.
                let near = theta * (f64::from(step) * damping / 50.0).exp();
                if near < std::f64::consts::FRAC_PI_2 - 1e-9 {
                    lines.push(near.tan().powi(2));
                }
            }
        }
        lines
    }
}

/// θ of the last corner that can be held in place: nine tenths of Nyquist.
const LAST_CORNER: f64 = 0.45 * std::f64::consts::PI;
/// Lines on either side of a corner.
const CLOSE: i32 = 1000;

/// r of the roots x = −r of |c₀ + c₁ jω + c₂ (jω)²|² over x = ω²; of a complex pair the one in the upper half plane.
/// A missing degree has its root at infinity.
fn squares(c: &[f64; 3]) -> Vec<c64> {
    let [c0, c1, c2] = *c;
    let middle = c1.powi(2) - 2.0 * c0 * c2;
    if c2 == 0.0 {
        let first = if c1 == 0.0 {
            f64::INFINITY
        } else {
            (c0 / c1).powi(2)
        };
        return vec![c64::new(first, 0.0), c64::new(f64::INFINITY, 0.0)];
    }
    // c₂² r² − middle r + c₀² = 0.
    let discriminant = c1.powi(2) * (c1.powi(2) - 4.0 * c0 * c2);
    if discriminant < 0.0 {
        let root = c64::new(middle, (-discriminant).sqrt()) / (2.0 * c2.powi(2));
        return vec![root];
    }
    // Both positive: the larger without cancellation, the other from their product.
    let larger = (middle + discriminant.sqrt()) / (2.0 * c2.powi(2));
    let smaller = (c0 / c2).powi(2) / larger;
    vec![c64::new(smaller, 0.0), c64::new(larger, 0.0)]
}

/// −X of the roots of r + scale ρ(X).
fn roots_of(approximant: &Approximant, r: c64, scale: f64) -> Result<Vec<c64>, NumericError> {
    if r.im == 0.0 {
        let (c0, c1) = if r.re.is_finite() {
            (r.re, scale)
        } else {
            (1.0, 0.0)
        };
        let real = approximant.roots(c0, c1).into_iter();
        return Ok(real.map(|u| c64::new(u, 0.0)).collect());
    }
    // r Π(1 − u/p) − scale g u Π(1 − u/z) over the powers of u.
    let product = |roots: &[f64]| {
        roots.iter().fold(vec![1.0], |all: Vec<f64>, root| {
            let mut next = all.clone();
            next.push(0.0);
            for (k, c) in all.iter().enumerate() {
                next[k + 1] -= c / root;
            }
            next
        })
    };
    let (below, above) = (product(approximant.poles), product(approximant.zeros));
    let coefficient = |k: usize| {
        let raised = if k == 0 {
            0.0
        } else {
            scale * approximant.gain * above[k - 1]
        };
        r * below[k] - c64::new(raised, 0.0)
    };
    let coefficients: Vec<c64> = (0..below.len()).map(coefficient).collect();
    polynomial_roots(&coefficients)
}

/// Roots of Σ cₖ uᵏ from the eigenvalues of its companion matrix.
///
/// # Errors
/// [`NumericError`] when the eigenvalue iteration fails.
pub(super) fn polynomial_roots(coefficients: &[c64]) -> Result<Vec<c64>, NumericError> {
    let n = coefficients.len().saturating_sub(1);
    let Some(lead) = coefficients.last().copied().filter(|_| n > 0) else {
        return Ok(vec![]);
    };
    let companion = Mat::from_fn(n, n, |i, j| match (i, j) {
        (i, j) if j + 1 == n => -coefficients[i] / lead,
        (i, j) if i == j + 1 => c64::new(1.0, 0.0),
        _ => c64::new(0.0, 0.0),
    });
    let mut roots = eigenvalues_complex(&companion)?;
    for root in &mut roots {
        // Two steps of Newton remove what the scale of the coefficients leaves.
        for _ in 0..2 {
            let (mut value, mut slope) = (c64::new(0.0, 0.0), c64::new(0.0, 0.0));
            for c in coefficients.iter().rev() {
                slope = slope * *root + value;
                value = value * *root + *c;
            }
            let step = value / slope;
            if step.norm() < 1e-3 * root.norm() {
                *root -= step;
            }
        }
    }
    Ok(roots)
}
