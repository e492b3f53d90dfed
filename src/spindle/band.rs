//! The band that models of a shaft follow.

use crate::rotor::PlanarModes;
use crate::spindle::{Machine, SpindleError};
use std::f64::consts::TAU;

/// How far beyond the last mode of the design model a sweep goes.
const BEYOND: f64 = 1.25;
/// Share of the sample rate beyond which delay and hold leave nothing to control.
const SHARE: f64 = 0.2;

/// End of the sweeps that a model follows, Hz: a quarter beyond the last mode of the design model, at most a fifth of
/// the sample rate, at least the end of the band in which the stiffness of the tool counts (4 kHz unless the file says
/// otherwise). `flexible_rad_s` are the modes of the free rotor.
pub(crate) fn sweep_end_hz(machine: &Machine, flexible_rad_s: &[f64]) -> f64 {
    let modes = machine.spindle.flexible_modes.min(flexible_rad_s.len());
    let last = flexible_rad_s[..modes].last().copied().unwrap_or_default();
    let most = SHARE * machine.spindle.electronics.sample_rate_hz;
    (BEYOND * last / TAU).min(most).max(machine.spindle.stiffness_band_hz.1)
}

/// The same in rad/s.
pub(crate) fn sweep_end_rad_s(machine: &Machine, flexible_rad_s: &[f64]) -> f64 {
    TAU * sweep_end_hz(machine, flexible_rad_s)
}

/// Modes that lie where a controller still acts, below the end of the band in which the stiffness of the tool counts
/// and a fifth of the sample rate, and that the design model does not keep.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ModesLeftOut {
    /// Number of the first of them, from 1.
    pub(crate) first: usize,
    /// Their frequencies, Hz.
    pub(crate) frequency_hz: Vec<f64>,
    /// End of the band, Hz.
    pub(crate) to_hz: f64,
}

/// The modes of the free rotor that the design model of a machine leaves out of the band; none where there are none.
pub(crate) fn modes_left_out(machine: &Machine) -> Result<Option<ModesLeftOut>, SpindleError> {
    let kept = machine.spindle.flexible_modes;
    let most = SHARE * machine.spindle.electronics.sample_rate_hz;
    let to_hz = machine.spindle.stiffness_band_hz.1.min(most);
    let all = PlanarModes::new(&machine.rotor()?)?.flexible_hz();
    let frequency_hz: Vec<f64> = all.into_iter().skip(kept).take_while(|hz| *hz <= to_hz).collect();
    Ok((!frequency_hz.is_empty()).then_some(ModesLeftOut { first: kept + 1, frequency_hz, to_hz }))
}
