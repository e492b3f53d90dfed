//! A second-order factor of a weight in the w plane of the sampled loop.
//!
//! |W|² is a ratio of quadratics in x = ω². With x = c (2/T)² ρ(X), the approximant of [`super::warp`], it is rational
//! in X = (vT/2)²; every root x = −r gives the roots X of r + c (2/T)² ρ(X) = 0, and s = −(2/T) √(−X) is stable. The
//! factor c makes the approximant exact at the corner: a resonance stays at its frequency.

use super::root::Root;
use super::second_order::{LAST_CORNER, SecondOrder};
use super::shape::{Shape, WeightStage};
use super::warp::{APPROXIMANTS, Approximant, FittedWeight, base_points, ratio_range_over};
use crate::linalg::{NumericError, c64, polynomial_roots};

impl SecondOrder {
    /// The factor in the w plane, nowhere below the written one: the lowest order within `tolerance`, else the highest.
    pub(super) fn fit_sampled(&self, period_s: f64, tolerance: f64) -> Result<FittedWeight, NumericError> {
        let k = 2.0 / period_s;
        let written = |theta: f64| self.magnitude(k * theta);
        let lines = self.lines(period_s);
        let judged = |fit: &Shape| {
            let range = ratio_range_over(&lines, &|x| fit.magnitude(k * x.sqrt()), &written);
            (fit.clone(), range)
        };
        let plain =
            Shape { gain: 1.0, stages: vec![WeightStage::Second(self.at_corner(period_s))], excess_over_points: 0.0 };
        let mut candidates = vec![judged(&plain)];
        if candidates[0].1.1 > tolerance {
            let exact_at = self.corner().map(|(omega, _)| omega / k);
            for approximant in &APPROXIMANTS {
                let fit = self.substitute_frequency(approximant, k, exact_at)?;
                candidates.push(judged(&fit));
                if candidates.last().is_some_and(|c| c.1.1 <= tolerance) {
                    break;
                }
            }
        }
        // The one within the tolerance is the last; without one the closest is taken.
        let best = candidates.into_iter().min_by(|x, y| x.1.1.total_cmp(&y.1.1));
        match best {
            Some((fit, (least, excess))) if excess.is_finite() && least > 0.0 => Ok(FittedWeight {
                system: fit.times(least.recip()).in_series(WeightStage::system)?,
                largest_excess: excess,
            }),
            _ => Err(NumericError::NotFinite { what: "second-order weight fitted in the w plane" }),
        }
    }

    /// ω² replaced by the approximant, exact at θ = `exact_at`.
    fn substitute_frequency(
        &self,
        approximant: &Approximant,
        k: f64,
        exact_at: Option<f64>,
    ) -> Result<Shape, NumericError> {
        let correction = exact_at
            .filter(|theta| *theta < LAST_CORNER)
            .map_or(1.0, |theta| theta.powi(2) / approximant.value(theta.tan().powi(2)));
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

/// Lines on either side of a corner.
const CLOSE: i32 = 1000;

/// r of the roots x = −r of |c₀ + c₁ jω + c₂ (jω)²|² over x = ω²; of a complex pair the one in the upper half plane.
/// A missing degree has its root at infinity.
fn squares(c: &[f64; 3]) -> Vec<c64> {
    let [c0, c1, c2] = *c;
    let middle = c1.powi(2) - 2.0 * c0 * c2;
    if c2 == 0.0 {
        let first = if c1 == 0.0 { f64::INFINITY } else { (c0 / c1).powi(2) };
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
        let (c0, c1) = if r.re.is_finite() { (r.re, scale) } else { (1.0, 0.0) };
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
        let raised = if k == 0 { 0.0 } else { scale * approximant.gain * above[k - 1] };
        r * below[k] - c64::new(raised, 0.0)
    };
    let coefficients: Vec<c64> = (0..below.len()).map(coefficient).collect();
    polynomial_roots(&coefficients)
}
