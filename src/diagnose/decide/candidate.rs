//! A set of effects, fitted at ever smaller model errors until it fails.
//!
//! A missing effect that is far too large for the noise makes a final fit meaningless, so a fit works at the model
//! error at which the present model just fails, from the fit at the error before. Score = χ² + d ln N (BIC).

use super::super::DiagnoseError;
use super::super::data::evidence::Subset;
use super::super::fit::case::Case;
use super::super::fit::estimate::{FINAL_MODEL_ERROR, Fit};
use super::super::fit::hypothesis::Hypothesis;
use super::super::fit::problem::Point;
use crate::spindle::Effect;

/// Relative model errors of successive fits, decreasing.
pub(crate) const MODEL_ERRORS: [f64; 6] = [0.1, 0.03, 0.01, 0.003, 0.001, FINAL_MODEL_ERROR];
/// Iterations at each model error.
const ITERATIONS: usize = 4;
/// Iterations at the last one.
const FINAL_ITERATIONS: usize = 20;
/// χ² per residual above which a model fails at a model error. Where noise and model error describe the data it is
/// below 1.
pub const FAILING_CHI2: f64 = 1.0;
/// χ² per residual above which smaller model errors are not tried: a fit that is off by so much does not come closer.
pub(crate) const HOPELESS_CHI2: f64 = 10.0;

/// χ² per residual above which this many of them are not explained: four standard deviations of its scatter by chance
/// above [`FAILING_CHI2`].
pub(crate) fn failing_chi2(residuals: usize) -> f64 {
    FAILING_CHI2 + 4.0 * (2.0 / residuals.max(1) as f64).sqrt()
}

/// Whether a fit leaves more than noise and model error do.
pub fn fails(fit: &Fit) -> bool {
    fit.data_chi2 > failing_chi2(fit.residuals) * fit.residuals as f64
}

/// A set of effects with its fit.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The effects.
    pub effects: Vec<Hypothesis>,
    /// The fit, at `model_error`.
    pub fit: Fit,
    /// Relative model error of the fit.
    pub model_error: f64,
}

impl Candidate {
    /// d, the free numbers of the effects that are no nuisance parameters.
    pub(crate) fn numbers(&self) -> usize {
        let both = self.effects.iter().zip(&self.fit.at.theta);
        both.filter(|(h, _)| !h.is_nuisance()).map(|(_, theta)| theta.len()).sum()
    }

    /// The effects without one, and the point without its numbers.
    pub(crate) fn without(&self, member: usize) -> (Vec<Hypothesis>, Point) {
        let (mut effects, mut at) = (self.effects.clone(), self.fit.at.clone());
        effects.remove(member);
        at.theta.remove(member);
        (effects, at)
    }

    pub(crate) fn newest(&self) -> Option<Effect> {
        let (h, theta) = (self.effects.last()?, self.fit.at.theta.last()?);
        Some(h.effect(theta))
    }

    /// χ² + d ln N.
    pub fn score(&self) -> f64 {
        self.fit.chi2 + self.numbers() as f64 * (self.fit.residuals.max(2) as f64).ln()
    }
}

/// A set of effects with the smallest model error at which it still fits, and the one at which it fails.
#[derive(Clone, Debug)]
pub struct Standing {
    /// The last fit.
    pub candidate: Candidate,
    /// Fit from which further effects start.
    pub from: Point,
    /// Floor at which it fails, or the final one.
    pub working_error: f64,
    /// χ² per residual there.
    pub failure: f64,
}

impl Standing {
    /// Whether this set brings the data closer within reach than another: a lower model error, or a fifth less χ² at
    /// the same one.
    pub(crate) fn nearer_than(&self, other: &Self) -> bool {
        self.working_error < other.working_error
            || self.working_error == other.working_error && self.failure < 0.8 * other.failure
    }
}

impl Case<'_> {
    /// Fits at decreasing model errors until the effects fail or the final model error is reached.
    ///
    /// # Errors
    /// [`DiagnoseError`] when a model cannot be assembled.
    pub fn fit_down(&self, effects: &[Hypothesis], from: &Point, usage: Subset) -> Result<Standing, DiagnoseError> {
        self.fit_until(effects, from, usage, FINAL_MODEL_ERROR)
    }

    /// The same down to a least model error.
    pub(crate) fn fit_until(
        &self,
        effects: &[Hypothesis],
        from: &Point,
        usage: Subset,
        least: f64,
    ) -> Result<Standing, DiagnoseError> {
        let problem = self.problem(effects, usage);
        let (mut at, mut before) = (from.clone(), from.clone());
        let mut last = None;
        for model_error in MODEL_ERRORS.into_iter().filter(|e| *e >= least) {
            let iterations = if model_error == FINAL_MODEL_ERROR { FINAL_ITERATIONS } else { ITERATIONS };
            let fit = problem.fit(&at, &[(model_error, iterations)])?;
            let fails = fails(&fit);
            at = fit.at.clone();
            last = Some((fit, model_error));
            if fails {
                break;
            }
            before = at.clone();
        }
        let (fit, model_error) = last.ok_or(DiagnoseError::NoSweep)?;
        Ok(Standing {
            failure: fit.data_chi2 / fit.residuals.max(1) as f64,
            candidate: Candidate { effects: effects.to_vec(), fit, model_error },
            from: before,
            working_error: model_error,
        })
    }

    /// A set at the final model error with its first effects put last; the columns of the curvature follow their order.
    pub(crate) fn rotate_effects(&self, set: &Candidate, first: usize) -> Result<Candidate, DiagnoseError> {
        let (mut effects, mut at) = (set.effects.clone(), set.fit.at.clone());
        effects.rotate_left(first);
        at.theta.rotate_left(first);
        self.finish(&effects, &at, FINAL_MODEL_ERROR, Subset::ALL)
    }

    /// Fits at every model error from `top` down to the final one, or until χ² per residual exceeds the limit beyond
    /// which no fit comes closer. Fits at larger model errors take some of the lines; the
    /// fit that is returned takes all of `usage`.
    ///
    /// # Errors
    /// As [`Self::fit_down`].
    pub fn finish(
        &self,
        effects: &[Hypothesis],
        from: &Point,
        top: f64,
        usage: Subset,
    ) -> Result<Candidate, DiagnoseError> {
        let whole = self.problem(effects, usage);
        let leading = self.problem(effects, self.leading(usage));
        let (mut at, mut last) = (from.clone(), None);
        for model_error in MODEL_ERRORS.into_iter().filter(|f| *f <= top) {
            let last_stage = model_error == FINAL_MODEL_ERROR;
            let iterations = if last_stage { FINAL_ITERATIONS } else { ITERATIONS };
            // Where there are many lines, most of the way at the final model error is gone on some of them, too.
            let mut fit = leading.fit(&at, &[(model_error, iterations)])?;
            if last_stage && leading.usage != whole.usage {
                fit = whole.fit(&fit.at, &[(model_error, iterations)])?;
            }
            let hopeless = fit.data_chi2 > HOPELESS_CHI2 * fit.residuals as f64;
            at = fit.at.clone();
            last = Some((fit, model_error));
            if hopeless {
                break;
            }
        }
        let (mut fit, model_error) = last.ok_or(DiagnoseError::NoSweep)?;
        if model_error != FINAL_MODEL_ERROR && self.leading(usage) != usage {
            fit = whole.fit(&at, &[(model_error, 0)])?;
        }
        Ok(Candidate { effects: effects.to_vec(), fit, model_error })
    }
}

/// The model error after this one.
pub(crate) fn next_model_error(model_error: f64) -> f64 {
    MODEL_ERRORS.into_iter().find(|f| *f < model_error).unwrap_or(FINAL_MODEL_ERROR)
}
