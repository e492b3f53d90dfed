//! Sensors that read the slope of the shaft, beside sensors that sit elsewhere.
//!
//! A plane that sits δ off reads w(z + δ), a sensor with an arm a reads w(z) + a w′(z). To first order in δ both are
//! the same; the bending of the shaft, ½ δ² w″, tells them apart. What such a sensor reads follows from the derivative
//! to the offset where it is zero, exactly in the arm, as responses of sweeps are linear in the rows of the sensors.

use super::super::DiagnoseError;
use super::linearise::Linearised;
use super::problem::{Point, Problem};
use crate::linalg::Mat;
use crate::linalg::dense::solve_normal;

/// Shares of a step that are tried.
const HALVINGS: i32 = 4;

impl Problem<'_> {
    /// χ² with priors where effect `e`, a sensor offset, is an arm on which the slope is read, its size the arm; fitted
    /// from a fit of the offset, at the same smooth model error. The problem must leave hammer tests out: their loop is
    /// not linear in what a sensor reads.
    pub(crate) fn with_slope_read(
        &self,
        e: usize,
        from: &Point,
        model_error: f64,
        iterations: usize,
    ) -> Result<f64, DiagnoseError> {
        let mut at = from.clone();
        let (mut read, mut lowest) = self.slope_read(e, &at, model_error)?;
        for _ in 0..iterations {
            // The derivatives at the offset serve for the arm.
            let here = Linearised { residual: read.clone(), ..self.linearise_records(&at, model_error)? };
            let equations = self.equations(&at, &here, 0.0);
            let step = solve_normal(&equations.normal, &equations.slope)?;
            let before = lowest;
            for halving in 0..HALVINGS {
                let share = 0.5f64.powi(halving);
                let taken = Mat::from_fn(step.nrows(), 1, |k, _| share * step[(k, 0)]);
                let there = self.take_step(&at, &taken);
                let (next, chi2) = self.slope_read(e, &there, model_error)?;
                if chi2 < lowest {
                    (at, read, lowest) = (there, next, chi2);
                    break;
                }
            }
            if before - lowest < 0.01 {
                break;
            }
        }
        Ok(lowest)
    }

    /// Residuals with an arm in place of the offset, and χ² with priors.
    fn slope_read(&self, e: usize, at: &Point, model_error: f64) -> Result<(Vec<f64>, f64), DiagnoseError> {
        let mut flat = at.clone();
        let own = flat.theta.get_mut(e).and_then(|theta| theta.first_mut());
        let arm = own.map_or(0.0, std::mem::take);
        let here = self.linearise_records(&flat, model_error)?;
        let before = at.theta.iter().take(e).map(Vec::len).sum::<usize>();
        let column = at.p.len() + before;
        let unit = Mat::from_fn(here.jacobian.columns(), 1, |k, _| f64::from(u8::from(k == column)));
        let slope = here.jacobian.times(&unit);
        let residual = here.residual.iter().zip(&slope);
        let residual: Vec<f64> = residual.map(|(r, slope)| r - arm * slope).collect();
        let data: f64 = residual.iter().map(|r| r * r).sum();
        Ok((residual, data + self.prior(at)))
    }
}
