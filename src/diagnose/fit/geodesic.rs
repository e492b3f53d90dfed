//! Geodesic acceleration of a Gauss–Newton step.
//!
//! Where the data determine a product or a difference of parameters and only priors determine the rest, the minimum of
//! χ² is long, narrow and curved, and a straight Gauss–Newton step increases χ². The second derivative of the residuals
//! along the step, from one more evaluation, curves the step (geodesic acceleration: Transtrum, Machta, Sethna, Phys.
//! Rev. E 83, 036701, 2011): x(t) = x + t δ + ½ t² a, with (JᵀJ + priors) a = Jᵀ ∂²r/∂t². The prior is linear and has
//! none.

use super::super::DiagnoseError;
use super::linearise::Linearised;
use super::problem::{Point, Problem};
use crate::linalg::Mat;
use crate::linalg::dense::solve_normal;

/// Share of the step over which the second derivative is taken: long enough for rounding, short enough for a parabola.
const NEAR: f64 = 0.1;
/// Shortest share of the step that is tried; shorter ones are left to damping.
const SHORTEST: f64 = 0.03;

/// The normal equations at a point, and the Gauss–Newton step that increases χ².
pub(super) struct GaussNewtonStep<'a> {
    /// JᵀJ with priors, n×n.
    pub normal: &'a Mat<f64>,
    /// Coordinates that bounds hold.
    pub held: &'a [bool],
    /// The step, n×1.
    pub step: &'a Mat<f64>,
    /// χ² with priors at the point.
    pub chi2: f64,
}

impl Problem<'_> {
    /// The point of least χ² on the curved step, over decreasing shares of it; none where χ² decreases nowhere.
    pub(super) fn along(
        &self,
        at: &Point,
        here: &Linearised,
        gauss_newton: &GaussNewtonStep,
        model_error: f64,
    ) -> Result<Option<Point>, DiagnoseError> {
        let n = gauss_newton.step.nrows();
        let near = Mat::from_fn(n, 1, |k, _| NEAR * gauss_newton.step[(k, 0)]);
        let Ok(there) = self.residual(&self.take_step(at, &near), model_error) else {
            return Ok(None);
        };
        let straight = here.jacobian.times(&near);
        let both = there.iter().zip(&here.residual).zip(&straight);
        let second = both.map(|((there, here), along)| 2.0 / (NEAR * NEAR) * (there - here + along));
        let second: Vec<f64> = second.collect();
        let mut pull = here.jacobian.transpose_times(&second);
        for (k, held) in gauss_newton.held.iter().enumerate() {
            if *held {
                pull[(k, 0)] = 0.0;
            }
        }
        let bend = solve_normal(gauss_newton.normal, &pull)?;
        let (mut best, mut lowest) = (None, gauss_newton.chi2);
        let mut share = 1.0;
        while share > SHORTEST {
            let step = Mat::from_fn(n, 1, |k, _| share * (gauss_newton.step[(k, 0)] + 0.5 * share * bend[(k, 0)]));
            let there = self.take_step(at, &step);
            match self.chi2(&there, model_error) {
                Ok(value) if value < lowest => (best, lowest) = (Some(there), value),
                // χ² rises again.
                _ if best.is_some() => break,
                _ => {}
            }
            share *= 0.5;
        }
        Ok(best)
    }
}
