//! Demand of a controller on the amplifiers: its gain above the modes of the model, and the current from sensor noise.
//! A PID is tuned within the figures of the delivered controller, so that both have the same limits.
//!
//! Gain: largest singular value of K(e^{jωT}), A/m, the largest current vector per signal vector; for a controller per
//! axis the largest axis. It counts from the geometric mean of the last flexible mode that the spindle's model keeps
//! and the next one (at most 0.4 of the sample rate) to the Nyquist frequency: beyond the modes that the design knows,
//! gain only amplifies noise and unknown modes. Noise: largest rms current of an axis from white sensor noise, at rest
//! and at the top speed.

use super::full_loop::noise_current_a;
use super::in_step;
use super::verification_error::VerificationError;
use crate::linalg::{NumericError, max_singular_value_complex};
use crate::lti::{Discrete, FrequencyGrid, FrequencyResponder, StateSpace, TimeBase};
use crate::rotor::modes::PlanarModes;
use crate::spindle::{Machine, SpindleError};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Largest share of the sample rate at which the high-frequency gain begins.
const LAST_SHARE: f64 = 0.4;
/// Lines of the gain: 0.1 % apart over a decade and a half.
const LINES: usize = 2000;
/// Lines on each side of a lightly damped pole of the controller.
const A_SIDE: usize = 12;

/// Figures of a controller at the amplifiers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmplifierDemand {
    /// From here on the gain counts, Hz.
    pub from_hz: f64,
    /// Largest singular value of K from there to Nyquist, A/m.
    pub high_frequency_gain_a_per_m: f64,
    /// Largest rms current of an axis from sensor noise, A; infinite for an unstable loop.
    pub noise_current_a: f64,
}

/// Frequency from which gain counts as high-frequency gain, Hz.
///
/// # Errors
/// [`SpindleError`] when the rotor breaks a rule.
pub fn high_frequency_hz(machine: &Machine) -> Result<f64, SpindleError> {
    let modes_hz = PlanarModes::new(&machine.rotor()?)?.flexible_hz();
    let last = LAST_SHARE * machine.spindle.electronics.sample_rate_hz;
    let kept = machine.spindle.flexible_modes;
    let between = match (kept.checked_sub(1).and_then(|k| modes_hz.get(k)), modes_hz.get(kept)) {
        (Some(below), Some(above)) => (below * above).sqrt(),
        // A model without flexible modes: below the first one.
        (None, Some(above)) => *above,
        _ => last,
    };
    Ok(between.min(last))
}

/// Largest singular value of a sampled controller from `from_hz` to the Nyquist frequency, A/m.
///
/// # Errors
/// [`NumericError`] when the eigenvalues of the controller fail.
pub fn high_frequency_gain(law: &StateSpace<Discrete>, from_hz: f64) -> Result<f64, NumericError> {
    let period = law.time.period_s;
    let poles = law.continuous_poles()?;
    let grid = FrequencyGrid::log_hz(from_hz, 0.4999 / period, LINES).refine_round_poles(&poles, A_SIDE);
    let response = FrequencyResponder::new(law);
    let gain = |omega: &f64| max_singular_value_complex(&response.transfer(law.time.point(*omega)));
    let gains: Vec<f64> = grid.omega_rad_s().par_iter().map(gain).collect();
    Ok(gains.into_iter().fold(0.0, f64::max))
}

/// Figures of a controller on the full sampled plant.
pub(crate) fn amplifier_demand(
    machine: &Machine,
    law: &StateSpace<Discrete>,
) -> Result<AmplifierDemand, VerificationError> {
    let from_hz = high_frequency_hz(machine)?;
    let fastest = machine.spindle.max_rpm * TAU / 60.0;
    let noise: Result<Vec<f64>, VerificationError> =
        [0.0, fastest].into_par_iter().map(|speed| noise_current_a(machine, law, speed)).collect();
    Ok(AmplifierDemand {
        from_hz,
        high_frequency_gain_a_per_m: high_frequency_gain(law, from_hz).map_err(in_step("gain of the controller"))?,
        noise_current_a: noise?.into_iter().fold(0.0, f64::max),
    })
}
