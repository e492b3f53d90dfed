//! Verification of an exported controller: stability of the sampled closed loop of the full plant over the speed range,
//! with the coefficients as the firmware holds them.

use super::in_step;
use super::speed_proof::{SpeedProof, prove};
use super::verification_error::VerificationError;
use crate::linalg::NumericError;
use crate::lti::connect::lower_lft;
use crate::lti::{Discrete, StateSpace, TimeBase};
use crate::spindle::{Machine, ModelDetail, Plant};
use rayon::prelude::*;
use std::f64::consts::TAU;

const AXES: usize = crate::spindle::plant::AXES;

/// Growth rate of the closed loop at one speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedCheck {
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Largest (|z| − 1)/Tₛ over the closed-loop poles, 1/s; negative when stable.
    pub growth_rate_per_s: f64,
}

/// What was checked and what came out.
#[derive(Clone, Debug, PartialEq)]
pub struct Verification {
    /// Stability at each speed; empty when the loop was not checked.
    pub speeds: Vec<SpeedCheck>,
    /// What the check used: plant, coefficients.
    pub conditions: String,
    /// Peak of μ of the same loop, when known.
    pub mu_peak: Option<f64>,
    /// Proof between the speeds computed, when it was asked for.
    pub proof: Option<SpeedProof>,
    /// Why there is no proof although it was asked for: the computation that failed.
    pub proof_failure: Option<String>,
    /// Largest speed of the machine, rpm: a loop counts as verified when it is proven stable from rest to it.
    pub top_rpm: f64,
    /// A loop that is not verified was exported because the user asked for it all the same.
    pub forced: bool,
}

impl Verification {
    /// A controller that nobody has checked.
    pub fn none() -> Self {
        Self {
            speeds: Vec::new(),
            conditions: "not verified".to_owned(),
            mu_peak: None,
            proof: None,
            proof_failure: None,
            top_rpm: f64::NAN,
            forced: false,
        }
    }

    /// The same with the proof between the speeds.
    #[must_use]
    pub(crate) fn with_proof(self, proof: SpeedProof) -> Self {
        Self { proof: Some(proof), ..self }
    }

    /// True when the loop is proven stable at every speed from rest to the largest one, not only at those computed.
    pub(crate) fn is_proven(&self) -> bool {
        let reaches = |proof: &SpeedProof| proof.covers(self.top_rpm);
        self.is_stable() && self.proof.as_ref().is_some_and(reaches)
    }

    /// The first speed at which the loop is known to be unstable: of those checked, else of the centres of the proof up
    /// to the largest speed.
    pub(crate) fn unstable(&self) -> Option<SpeedCheck> {
        let centres = self.proof.iter().flat_map(|proof| &proof.intervals);
        let below = centres
            .filter(|i| i.centre_rpm <= self.top_rpm && i.growth_rate_per_s >= 0.0)
            .map(|i| SpeedCheck { speed_rpm: i.centre_rpm, growth_rate_per_s: i.growth_rate_per_s })
            .next();
        self.first_unstable().or(below)
    }

    /// True when the loop was checked and is stable at every speed.
    pub fn is_stable(&self) -> bool {
        !self.speeds.is_empty() && self.speeds.iter().all(|s| s.growth_rate_per_s < 0.0)
    }

    /// The first speed at which the loop is unstable.
    pub(crate) fn first_unstable(&self) -> Option<SpeedCheck> {
        self.speeds.iter().find(|s| s.growth_rate_per_s.is_nan() || s.growth_rate_per_s >= 0.0).copied()
    }

    /// Slowest decay over the speeds, 1/s, as a (negative) growth rate.
    pub fn worst_growth_rate_per_s(&self) -> Option<f64> {
        self.speeds.iter().map(|s| s.growth_rate_per_s).max_by(f64::total_cmp)
    }
}

/// Largest growth rate of the sampled loop of a plant (channels of [`crate::spindle::plant`]) with u = K y, 1/s.
///
/// # Errors
/// [`NumericError`] when the loop is not well posed or the eigenvalue iteration fails.
pub fn growth_rate(plant: &StateSpace<Discrete>, controller: &StateSpace<Discrete>) -> Result<f64, NumericError> {
    let axes: Vec<usize> = (0..AXES).collect();
    lower_lft(&plant.select(&axes, &axes), controller)?.growth_rate()
}

/// [`growth_rate`] of the sampled loop of a spindle; `sampled` is [`Plant::sample_plant`].
pub(crate) fn growth_rate_of(
    plant: &Plant,
    sampled: &StateSpace<Discrete>,
    controller: &StateSpace<Discrete>,
) -> Result<f64, NumericError> {
    let poles = plant.loop_poles(sampled, controller)?;
    Ok(sampled.time.largest_growth_rate(&poles))
}

/// Checks the sampled loop of the full plant at `points` speeds, evenly spaced from 0 to the largest speed.
pub(crate) fn verify(
    machine: &Machine,
    controller: &StateSpace<Discrete>,
    points: usize,
    conditions: &str,
) -> Result<Verification, VerificationError> {
    let last = points.max(2) - 1;
    let speeds: Vec<f64> = (0..=last).map(|k| machine.spindle.max_rpm * k as f64 / last as f64).collect();
    verify_at(machine, controller, &speeds, conditions)
}

/// Checks the sampled loop at `points` speeds and proves stability between them, from rest to the largest speed. A loop
/// that is unstable at rest is proven nowhere: the proof is left out. A proof that fails numerically leaves the loop
/// unproven, with the reason.
pub(crate) fn verify_with_proof(
    machine: &Machine,
    controller: &StateSpace<Discrete>,
    points: usize,
    conditions: &str,
) -> Result<Verification, VerificationError> {
    let checked = verify(machine, controller, points, conditions)?;
    let at_rest = checked.speeds.first();
    if at_rest.is_none_or(|s| s.growth_rate_per_s.is_nan() || s.growth_rate_per_s >= 0.0) {
        return Ok(checked);
    }
    Ok(match prove(machine, controller, machine.spindle.max_rpm) {
        Ok(proof) => checked.with_proof(proof),
        Err(error) => Verification { proof_failure: Some(error.to_string()), ..checked },
    })
}

/// Checks the sampled loop of the full plant at the speeds given, rpm.
///
/// # Errors
/// [`VerificationError`] from the plant or the eigenvalue iteration.
pub fn verify_at(
    machine: &Machine,
    controller: &StateSpace<Discrete>,
    speeds_rpm: &[f64],
    conditions: &str,
) -> Result<Verification, VerificationError> {
    let speeds: Result<Vec<SpeedCheck>, VerificationError> = speeds_rpm
        .par_iter()
        .map(|speed_rpm| {
            let plant = Plant::new(machine, speed_rpm * TAU / 60.0, ModelDetail::Full)?;
            Ok(SpeedCheck {
                speed_rpm: *speed_rpm,
                growth_rate_per_s: growth_rate_of(&plant, &plant.sample_plant()?, controller)
                    .map_err(in_step("closed-loop stability"))?,
            })
        })
        .collect();
    Ok(Verification {
        speeds: speeds?,
        conditions: conditions.to_owned(),
        mu_peak: None,
        proof: None,
        proof_failure: None,
        top_rpm: machine.spindle.max_rpm,
        forced: false,
    })
}

/// A growth rate in 1/s for people: so many digits behind the point, or three digits and an exponent where it is so
/// large that only its size says anything.
pub(crate) fn rate_words(rate_per_s: f64, decimals: usize) -> String {
    /// Growth by a factor e within ten microseconds, less than a sample of any controller.
    const LARGE_PER_S: f64 = 1e5;
    if rate_per_s.abs() < LARGE_PER_S { format!("{rate_per_s:.decimals$}") } else { format!("{rate_per_s:.2e}") }
}

/// What an unstable loop does: how fast it grows, and at which speed.
pub(crate) fn growth_words(rate_per_s: f64, speed_rpm: f64) -> String {
    format!("grows by {} 1/s at {speed_rpm:.0} rpm", rate_words(rate_per_s, 2))
}

#[cfg(test)]
mod tests {
    use super::rate_words;

    #[test]
    fn large_rates_are_three_digits_and_an_exponent() {
        for (rate, words) in [(-12.345, "-12.3"), (99_999.0, "99999.0"), (1.234_5e9, "1.23e9"), (f64::MAX, "1.80e308")]
        {
            assert_eq!(rate_words(rate, 1), words);
        }
    }
}
