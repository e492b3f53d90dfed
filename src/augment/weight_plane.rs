//! The frequency plane of a generalized plant, and how weights of true frequency are realised in it.
//!
//! In the w plane of the sampled loop v = (2/T) tan(ωT/2). In the problems by which a loop is judged, every weight is
//! fitted to its magnitude over true frequency ([`super::warp`]). The synthesis takes the sections as written with v in
//! the place of ω: this needs no further state, and near Nyquist a rising weight asks for more than is written. The
//! sampled plant holds every input. Modal uncertainty and loads act between the samples too: in analysis their inputs
//! carry a fitted 1/sinc(ωT/2), so that their magnitude is that of the continuous response; in synthesis the modal
//! inputs carry its value at their natural frequency.

use super::shape::{Shape, WeightStage};
use super::warp::{FittedWeight, fit_sampled_weight, inverse_hold};
use super::weight_shapes::WeightShapes;
use super::weights::Weights;
use crate::linalg::{Mat, NumericError};
use crate::lti::connect::series;
use crate::lti::{Continuous, StateSpace};

/// Where the weights of a generalized plant are evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WeightPlane {
    /// s = jω: the weights as written.
    Laplace,
    /// w plane for synthesis.
    Synthesis {
        /// Sample period, s.
        period_s: f64,
    },
    /// w plane for analysis: closer fits, inputs that act between the samples are not held.
    Analysis {
        /// Sample period, s.
        period_s: f64,
    },
}

/// Excess of a first-order section allowed in analysis; the control weight is two sections.
const ANALYSIS_EXCESS: f64 = 0.005;
/// Excess of the inverse hold.
const HOLD_EXCESS: f64 = 0.02;

impl WeightPlane {
    /// A weight in this plane.
    ///
    /// # Errors
    /// [`NumericError`] when the weight is not finite.
    pub fn realise(&self, shape: &Shape) -> Result<FittedWeight, NumericError> {
        let mut ratio = 1.0;
        let system = shape.in_series(|stage| {
            let fitted = self.stage(stage)?;
            ratio *= 1.0 + fitted.largest_excess;
            Ok(fitted.system)
        })?;
        Ok(FittedWeight { system, largest_excess: ratio - 1.0 })
    }

    fn stage(&self, stage: &WeightStage) -> Result<FittedWeight, NumericError> {
        match (*self, stage) {
            (Self::Laplace, _) => Ok(FittedWeight { system: stage.system()?, largest_excess: 0.0 }),
            (Self::Synthesis { period_s }, WeightStage::First(_)) => {
                Ok(FittedWeight { system: stage.system()?, largest_excess: warped_excess(stage, stage, period_s) })
            }
            (Self::Synthesis { period_s }, WeightStage::Second(second)) => {
                let placed = WeightStage::Second(second.at_corner(period_s));
                Ok(FittedWeight { system: placed.system()?, largest_excess: warped_excess(&placed, stage, period_s) })
            }
            (Self::Analysis { period_s }, WeightStage::First(section)) => {
                fit_sampled_weight(section, period_s, ANALYSIS_EXCESS)
            }
            (Self::Analysis { period_s }, WeightStage::Second(second)) => second.fit_sampled(period_s, ANALYSIS_EXCESS),
        }
    }

    /// The weight of an input that acts between the samples; `near_rad_s` is the frequency at which it matters, if one.
    pub(crate) fn unheld(
        &self,
        weight: &StateSpace<Continuous>,
        near_rad_s: Option<f64>,
    ) -> Result<StateSpace<Continuous>, NumericError> {
        match (*self, near_rad_s) {
            (Self::Analysis { period_s }, _) => series(&inverse_hold(period_s, HOLD_EXCESS)?.system, weight),
            (Self::Synthesis { period_s }, Some(omega)) => {
                let theta = 0.5 * omega * period_s;
                Ok(weight.scale_outputs(&Mat::from_fn(1, 1, |_, _| theta / theta.sin())))
            }
            _ => Ok(weight.clone()),
        }
    }
}

/// Lines up to Nyquist over which the excess of a section that is read at v is taken: it is smooth, and 1e-5 of it lies
/// between them.
const LINES: usize = 2000;

/// Largest relative excess over true frequency of a stage that reads v in the place of ω over the one as written; none
/// where it falls.
fn warped_excess(read: &WeightStage, written: &WeightStage, period_s: f64) -> f64 {
    let nyquist_rad_s = std::f64::consts::PI / period_s;
    let excess = |k: usize| {
        let omega = nyquist_rad_s * k as f64 / (LINES + 1) as f64;
        let v = 2.0 / period_s * (0.5 * omega * period_s).tan();
        read.magnitude(v) / written.magnitude(omega) - 1.0
    };
    (1..=LINES).map(excess).fold(0.0, f64::max)
}

/// Largest relative excess of the fitted weights over the written ones, true frequency from zero to Nyquist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitErrors {
    /// Of the weights in the problems that are judged.
    pub analysis: f64,
    /// Of the weights that the synthesis sees.
    pub synthesis: f64,
    /// Of the weights given by points over these points; zero without any.
    pub points: f64,
    /// Of the inverse hold on modal and load inputs in the problems that are judged.
    pub hold: f64,
}

/// The fit errors of a specification at a sample period.
///
/// # Errors
/// [`NumericError`] when a weight is not positive.
pub fn fit_errors(weights: &Weights, period_s: f64) -> Result<FitErrors, NumericError> {
    let shapes = WeightShapes::of(weights)?;
    let all: Vec<&Shape> = shapes.over_frequency().collect();
    let largest = |plane: WeightPlane| -> Result<f64, NumericError> {
        all.iter().try_fold(0.0f64, |largest, shape| Ok(largest.max(plane.realise(shape)?.largest_excess)))
    };
    Ok(FitErrors {
        analysis: largest(WeightPlane::Analysis { period_s })?,
        synthesis: largest(WeightPlane::Synthesis { period_s })?,
        points: all.iter().map(|shape| shape.excess_over_points).fold(0.0, f64::max),
        hold: inverse_hold(period_s, HOLD_EXCESS)?.largest_excess,
    })
}
