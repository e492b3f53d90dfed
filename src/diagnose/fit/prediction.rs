//! χ² after one step with a new effect, predicted from a linear model: a score test, jointly with all other parameters.

use super::super::DiagnoseError;
use super::estimate::UNKNOWN;
use super::hypothesis::Hypothesis;
use super::jacobian::Jacobian;
use super::linearise::Linearised;
use super::problem::{Point, Problem};
use crate::linalg::Mat;
use crate::linalg::dense::solve_normal;
use crate::spindle::response::Receptance;
use crate::spindle::response::electronics_change::on_electronics;

/// Effects at a point, linearised.
pub struct Linear {
    residual: Vec<f64>,
    jacobian: Jacobian,
    normal: Mat<f64>,
    shaft: Vec<Receptance>,
}

impl Linear {
    /// Derivatives of the predicted residuals, and JᵀJ with priors.
    pub fn parts(&self) -> (&Jacobian, &Mat<f64>) {
        (&self.jacobian, &self.normal)
    }

    pub fn residuals(&self) -> usize {
        self.residual.len()
    }

    pub(crate) fn residual(&self) -> &[f64] {
        &self.residual
    }
}

impl Problem<'_> {
    /// Residuals and derivatives of these effects at a point, for [`Self::predict_minimum`].
    ///
    /// # Errors
    /// As [`Self::residual`].
    pub fn linear(&self, at: &Point, model_error: f64) -> Result<Linear, DiagnoseError> {
        let Linearised { residual, jacobian, shaft } = self.linearise_records(at, model_error)?;
        let mut normal = jacobian.normal();
        for (k, (weight, _)) in self.model.layout.pull(&at.p).enumerate() {
            normal[(k, k)] += weight;
        }
        // A number on which nothing depends, the polar inertia of a disc at rest, stays where it is.
        for k in (0..normal.nrows()).filter(|k| normal[(*k, *k)] == 0.0).collect::<Vec<usize>>() {
            normal[(k, k)] = 1.0;
        }
        Ok(Linear { residual, jacobian, normal, shaft })
    }

    /// χ² predicted after one joint Gauss–Newton step from `from`, the last effect of the problem being new; and the
    /// point of that step.
    ///
    /// # Errors
    /// As [`Self::residual`].
    pub fn predict_minimum(
        &self,
        base: &Linear,
        from: &Point,
        model_error: f64,
    ) -> Result<(Point, f64), DiagnoseError> {
        let (Some(hypothesis), Some(theta)) = (self.effects.last(), from.theta.last()) else {
            return Ok((from.clone(), f64::INFINITY));
        };
        let alone = on_electronics(hypothesis.kind);
        let shaft = alone.then_some(base.shaft.as_slice());
        let Linearised { residual: here, jacobian, .. } = self.newest(from, model_error, shaft)?;
        let step = NewStep {
            model_error,
            data: here.iter().map(|r| r * r).sum(),
            small: base.jacobian.transpose_times(&here),
            cross: base.jacobian.transpose_times_columns(&jacobian),
            own: jacobian.normal(),
            new: jacobian.transpose_times(&here),
        };
        self.new_step(base, from, theta, &step)
    }

    /// The same for many effects of no size beside those of the problem: `further` of which none has to be assembled
    /// first (`assembled_with_size`). With the problem's effects and each of them in turn, `with` gives the fit.
    pub(crate) fn predicted_beside(
        &self,
        base: &Linear,
        from: &Point,
        model_error: f64,
        further: &[Hypothesis],
    ) -> Result<Vec<(Point, f64)>, DiagnoseError> {
        let Linearised { residual, jacobian, .. } = self.beside(from, model_error, further)?;
        let data = residual.iter().map(|r| r * r).sum();
        let small = base.jacobian.transpose_times(&residual);
        let cross = base.jacobian.transpose_times_columns(&jacobian);
        let new = jacobian.transpose_times(&residual);
        let widths: Vec<usize> = further.iter().map(|h| h.nothing().len()).collect();
        let own = jacobian.normal_of_each(&widths);
        let mut first = 0;
        let each = further.iter().zip(own).map(|(h, own)| {
            let theta = h.nothing();
            let d = theta.len();
            let step = NewStep {
                model_error,
                data,
                small: small.clone(),
                cross: cross.submatrix(0, first, cross.nrows(), d).to_owned(),
                own,
                new: new.submatrix(first, 0, d, 1).to_owned(),
            };
            first += d;
            let mut effects = self.effects.to_vec();
            effects.push(h.clone());
            let problem = Problem { effects: &effects, ..*self };
            let mut from = from.clone();
            from.theta.push(theta.clone());
            problem.new_step(base, &from, &theta, &step)
        });
        each.collect()
    }

    /// The step of all parameters that a new effect leads to, and χ² after it.
    fn new_step(
        &self,
        base: &Linear,
        from: &Point,
        theta: &[f64],
        new: &NewStep,
    ) -> Result<(Point, f64), DiagnoseError> {
        let (n, d) = (base.jacobian.columns(), theta.len());
        let mut slope = Mat::zeros(n + d, 1);
        for k in 0..n {
            slope[(k, 0)] = new.small[(k, 0)];
        }
        for (k, (_, pull)) in self.model.layout.pull(&from.p).enumerate() {
            slope[(k, 0)] += pull;
        }
        for k in 0..d {
            slope[(n + k, 0)] = new.new[(k, 0)];
        }
        let normal = Mat::from_fn(n + d, n + d, |i, j| match (i < n, j < n) {
            (true, true) => base.normal[(i, j)],
            (true, false) => new.cross[(i, j - n)],
            (false, true) => new.cross[(j, i - n)],
            (false, false) => new.own[(i - n, j - n)] + if i == j { UNKNOWN } else { 0.0 },
        });
        let step = solve_normal(&normal, &slope)?;
        let gain: f64 = (0..n + d).map(|k| step[(k, 0)] * slope[(k, 0)]).sum();
        // The whole step where it is short, the same direction where it is long: the prediction is linear. The nuisance
        // parameters go along, as they have taken up what the new effect explains.
        let share = (0..d).fold(1.0f64, |share, i| {
            let limit = 2.0 + theta[i].abs();
            share.min(limit / step[(n + i, 0)].abs().max(f64::MIN_POSITIVE))
        });
        let taken = Mat::from_fn(n + d, 1, |k, _| share * step[(k, 0)]);
        let there = self.take_step(from, &taken);
        let chi2 = new.data + self.prior(from) + self.cost(from, new.model_error)? - gain;
        // The longer a step, the less a linear prediction is worth; a negative χ² is none.
        Ok((there, chi2.max(0.0)))
    }
}

/// What a step with a new effect follows from, beside the linearisation without it.
struct NewStep {
    model_error: f64,
    data: f64,
    /// Jᵀr of the earlier parameters.
    small: Mat<f64>,
    /// Jᵀ times the columns of the new effect.
    cross: Mat<f64>,
    /// Normal equations of the new effect alone.
    own: Mat<f64>,
    /// Its Jᵀr.
    new: Mat<f64>,
}
