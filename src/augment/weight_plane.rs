//! The frequency plane of a generalized plant, and how weights of true frequency are realised in it.
//!
//! In the w plane of the sampled loop v = (2/T) tan(ωT/2). What a loop is judged on has every weight fitted to its
//! magnitude over true frequency ([`super::warp`]). The synthesis takes the sections as written, with v in the place of
//! ω: no state more, and a rising weight asks for more than is written as Nyquist is approached. The sampled plant
//! holds every input. Modal uncertainty and loads act between the samples too: in analysis their inputs carry a fitted
//! 1/sinc(ωT/2), so that their magnitude is that of the continuous response; in synthesis the modal inputs carry its
//! value at their natural frequency.

use super::channels::{ChannelWeight, channels};
use super::warp::{FittedWeight, fitted, inverse_hold};
use super::weighting::{Section, integral_section};
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
    /// A section in this plane.
    ///
    /// # Errors
    /// [`NumericError`] when the section is not finite.
    pub fn realise(&self, section: &Section) -> Result<FittedWeight, NumericError> {
        match *self {
            Self::Laplace => Ok(FittedWeight {
                system: section.system()?,
                largest_excess: 0.0,
            }),
            Self::Synthesis { period_s } => Ok(FittedWeight {
                system: section.system()?,
                largest_excess: warped_excess(section, period_s),
            }),
            Self::Analysis { period_s } => fitted(section, period_s, ANALYSIS_EXCESS),
        }
    }

    /// The weight of an input that acts between the samples; `near_rad_s` is the frequency at which it matters, if one.
    ///
    /// # Errors
    /// [`NumericError`] when the connection fails.
    pub fn unheld(
        &self,
        weight: &StateSpace<Continuous>,
        near_rad_s: Option<f64>,
    ) -> Result<StateSpace<Continuous>, NumericError> {
        match (*self, near_rad_s) {
            (Self::Analysis { period_s }, _) => {
                series(&inverse_hold(period_s, HOLD_EXCESS)?.system, weight)
            }
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

/// Largest relative excess over true frequency of a section that reads v in the place of ω; none where the section
/// falls.
fn warped_excess(section: &Section, period_s: f64) -> f64 {
    let nyquist_rad_s = std::f64::consts::PI / period_s;
    let excess = |k: usize| {
        let omega = nyquist_rad_s * k as f64 / (LINES + 1) as f64;
        let v = 2.0 / period_s * (0.5 * omega * period_s).tan();
        section.magnitude(v) / section.magnitude(omega) - 1.0
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
    /// Of the inverse hold on modal and load inputs in the problems that are judged.
    pub hold: f64,
}

/// The fit errors of a specification at a sample period.
///
/// # Errors
/// [`NumericError`] when a weight is not positive.
pub fn fit_errors(weights: &Weights, period_s: f64) -> Result<FitErrors, NumericError> {
    let limits = [&weights.tool, &weights.front, &weights.rear];
    let mut single = vec![];
    let crossovers = weights
        .load_crossover_hz
        .iter()
        .zip(weights.displacement_crossover_hz);
    for (limit, (load_hz, displacement_hz)) in limits.iter().zip(crossovers) {
        single.push(Section::level_change(
            limit.max_dc_load_n,
            limit.max_hf_load_n,
            *load_hz,
        )?);
        single.push(Section::level_change(
            1.0 / limit.max_dc_displacement_m,
            1.0 / limit.max_hf_displacement_m,
            displacement_hz,
        )?);
    }
    if let Some(corner) = weights.integral_corner_hz {
        single.push(integral_section(
            weights.front.max_dc_displacement_m,
            corner,
        )?);
    }
    single.extend(
        channels(weights)?
            .into_iter()
            .filter_map(|c| match c.output {
                ChannelWeight::OverFrequency(section) => Some(section),
                ChannelWeight::Constant(_) => None,
            }),
    );
    let stage = Section::roll_on_stage(weights.current_rolloff_hz, weights.current_rolloff_ratio)?;
    let largest = |plane: WeightPlane| -> Result<f64, NumericError> {
        let twice = (1.0 + plane.realise(&stage)?.largest_excess).powi(2) - 1.0;
        single.iter().try_fold(twice, |all, section| {
            Ok(all.max(plane.realise(section)?.largest_excess))
        })
    };
    Ok(FitErrors {
        analysis: largest(WeightPlane::Analysis { period_s })?,
        synthesis: largest(WeightPlane::Synthesis { period_s })?,
        hold: inverse_hold(period_s, HOLD_EXCESS)?.largest_excess,
    })
}
