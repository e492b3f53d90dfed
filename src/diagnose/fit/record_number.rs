//! One number of a record (a speed, a factor) fitted jointly with the nuisance parameters.
//!
//! The other records stand; the residuals of this one are functions of the number c, differentiated by a difference.
//! With D = −∂r/∂c beside the Jacobian of the nuisance parameters the Gauss–Newton step follows from the bordered
//! normal equations.

use super::super::DiagnoseError;
use super::super::data::evidence::{Evidence, Subset};
use super::model::Model;
use super::prediction::Linear;
use super::problem::{Point, Problem};
use crate::linalg::Mat;
use crate::linalg::dense::solve_normal;

/// Curvature that the number has at least: data that do not depend on it leave it where it is.
const UNKNOWN: f64 = 1e-6;
/// Shares of a step that are tried.
const HALVINGS: usize = 5;

/// A measurement of which one record depends on a number.
pub(crate) struct RecordNumber<'a> {
    pub model: &'a Model,
    pub rest: &'a Evidence,
    /// The record by itself for a number.
    pub own: &'a (dyn Fn(f64) -> Evidence + Sync),
    /// Which lines.
    pub usage: Subset,
    /// Over which difference the record is differentiated.
    pub difference: f64,
    pub longest: f64,
}

#[derive(Clone, Debug)]
pub(crate) struct Numbered {
    pub number: f64,
    pub at: Point,
    /// χ² of the data and of the priors.
    pub chi2: f64,
    /// χ² per residual.
    pub failure: f64,
    pub model_error: f64,
}

impl RecordNumber<'_> {
    fn problem<'b>(&'b self, evidence: &'b Evidence) -> Problem<'b> {
        Problem { model: self.model, evidence, usage: self.usage, effects: &[] }
    }

    /// χ² with priors, and the number of residuals.
    fn chi2(&self, at: &Point, number: f64, model_error: f64) -> Result<(f64, usize), DiagnoseError> {
        let own = (self.own)(number);
        let (mut sum, mut count) = (self.problem(self.rest).prior(at), 0);
        for evidence in [self.rest, &own] {
            let r = self.problem(evidence).residual(at, model_error)?;
            sum += r.iter().map(|r| r * r).sum::<f64>();
            count += r.len();
        }
        Ok((sum, count))
    }

    /// Fits at a model error from a start.
    pub(crate) fn fit(&self, from: &Numbered, model_error: f64, iterations: usize) -> Result<Numbered, DiagnoseError> {
        let mut best = from.clone();
        best.model_error = model_error;
        let (chi2, count) = self.chi2(&best.at, best.number, model_error)?;
        best.chi2 = chi2;
        for _ in 0..iterations {
            let step = self.step(&best, model_error)?;
            let n = step.nrows() - 1;
            let shorten = (self.longest / step[(n, 0)].abs().max(f64::MIN_POSITIVE)).min(1.0);
            let before = best.chi2;
            for halving in 0..HALVINGS {
                let share = shorten * 0.5f64.powi(halving as i32);
                let taken = Mat::from_fn(n, 1, |k, _| share * step[(k, 0)]);
                let at = self.problem(self.rest).take_step(&best.at, &taken);
                let number = best.number + share * step[(n, 0)];
                match self.chi2(&at, number, model_error) {
                    Ok((chi2, _)) if chi2 < best.chi2 => {
                        (best.at, best.number, best.chi2) = (at, number, chi2);
                        break;
                    }
                    _ => {}
                }
            }
            if before - best.chi2 < 1e-4 * best.chi2 {
                break;
            }
        }
        let prior = self.problem(self.rest).prior(&best.at);
        best.failure = (best.chi2 - prior) / count.max(1) as f64;
        Ok(best)
    }

    /// How far χ² falls at most in a linear model of the number and the nuisance parameters (a score test): a scalar of
    /// χ² distribution with one degree of freedom where the number is right, the nuisance parameters fitted. `known`
    /// are the linearisations there of the record and of all others.
    pub(crate) fn predicted_fall(
        &self,
        from: &Numbered,
        model_error: f64,
        known: (&Linear, &[&Linear]),
    ) -> Result<f64, DiagnoseError> {
        let (normal, slope) = self.border_equations(from, model_error, known.0, known.1)?;
        let step = solve_normal(&normal, &slope)?;
        let n = step.nrows() - 1;
        // What is left of the number's own curvature once the nuisance parameters follow.
        let shared = Mat::from_fn(n, 1, |k, _| normal[(k, n)]);
        let block = Mat::from_fn(n, n, |i, j| normal[(i, j)]);
        let absorbed = solve_normal(&block, &shared)?;
        let taken: f64 = (0..n).map(|k| shared[(k, 0)] * absorbed[(k, 0)]).sum();
        Ok(step[(n, 0)].powi(2) * (normal[(n, n)] - taken).max(0.0))
    }

    /// The Gauss–Newton step of nuisance parameters and number, n+1×1.
    fn step(&self, from: &Numbered, model_error: f64) -> Result<Mat<f64>, DiagnoseError> {
        let (normal, slope) = self.equations(from, model_error)?;
        Ok(solve_normal(&normal, &slope)?)
    }

    /// The bordered normal equations, the number last.
    fn equations(&self, from: &Numbered, model_error: f64) -> Result<(Mat<f64>, Mat<f64>), DiagnoseError> {
        let own = (self.own)(from.number);
        let rest = self.problem(self.rest).linear(&from.at, model_error)?;
        let here = self.problem(&own).linear(&from.at, model_error)?;
        self.border_equations(from, model_error, &here, &[&rest])
    }

    /// The same from linearisations of the record and of the others.
    fn border_equations(
        &self,
        from: &Numbered,
        model_error: f64,
        here: &Linear,
        others: &[&Linear],
    ) -> Result<(Mat<f64>, Mat<f64>), DiagnoseError> {
        let moved = (self.own)(from.number + self.difference);
        let there = self.problem(&moved).residual(&from.at, model_error)?;
        let n = from.at.p.len();
        let both = here.residual().iter().zip(&there);
        let along = both.map(|(here, there)| (here - there) / self.difference);
        let along: Vec<f64> = along.collect();
        let cross = here.parts().0.transpose_times(&along);
        let own_curvature: f64 = along.iter().map(|a| a * a).sum();
        let pull: f64 = along.iter().zip(here.residual()).map(|(a, r)| a * r).sum();
        let mut normal = Mat::zeros(n + 1, n + 1);
        let mut slope = Mat::zeros(n + 1, 1);
        for linear in others.iter().chain([&here]) {
            let (jacobian, own) = linear.parts();
            let right = jacobian.transpose_times(linear.residual());
            for k in 0..n {
                slope[(k, 0)] += right[(k, 0)];
                (0..n).for_each(|l| normal[(k, l)] += own[(k, l)]);
            }
        }
        for (k, (weight, pull)) in self.model.layout.pull(&from.at.p).enumerate() {
            // Each of them holds the priors.
            normal[(k, k)] -= others.len() as f64 * weight;
            slope[(k, 0)] += pull;
            normal[(k, n)] = cross[(k, 0)];
            normal[(n, k)] = cross[(k, 0)];
        }
        normal[(n, n)] = own_curvature + UNKNOWN;
        slope[(n, 0)] = pull;
        Ok((normal, slope))
    }
}
