//! Stability of a PID on the machine with shifted modes: each of the first six alone, every combination of signs of the
//! first four, all modes of the shaft together.

use super::settings::TuneSettings;
use crate::controller::in_step;
use crate::controller::verification::growth_rate_of;
use crate::controller::verification_error::VerificationError;
use crate::lti::{Discrete, StateSpace};
use crate::spindle::{Machine, ModelDetail, Plant};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Modes that are shifted alone, and in every combination.
pub(super) const SHIFTED_MODES: usize = 6;
const COMBINED: usize = 4;
/// Speeds at which the shifted loops are checked: standstill, half and full speed at least.
pub(super) const SHIFTED_SPEEDS: usize = 3;

/// Stability of the loops with shifted modes; of a loop that is unstable as it is none is checked.
#[derive(Clone, Debug, PartialEq)]
pub struct ShiftedLoops {
    /// Relative shift of the modes.
    pub shift: f64,
    /// Loops checked: combinations of shifts times speeds.
    pub loops: usize,
    /// Largest growth rate over all of them, 1/s.
    pub worst_growth_rate_per_s: f64,
    /// Frequency factors of the first modes where it occurs.
    pub worst_factors: Vec<f64>,
    /// Its speed, rpm.
    pub worst_speed_rpm: f64,
}

impl ShiftedLoops {
    pub(super) fn none(shift: f64) -> Self {
        Self { shift, loops: 0, worst_growth_rate_per_s: f64::NAN, worst_factors: vec![], worst_speed_rpm: f64::NAN }
    }
}

/// Machine with every flexible frequency multiplied by `factor` (moduli by its square).
pub(super) fn with_shifted_modes(machine: &Machine, factor: f64) -> Machine {
    let mut shifted = machine.clone();
    for section in shifted.spindle.sections.iter_mut().chain(&mut shifted.tool.sections) {
        section.modulus_scale *= factor * factor;
    }
    shifted
}

/// Growth rates of the loops with modes shifted alone and combined.
pub(super) fn shifted_loops(
    machine: &Machine,
    law: &StateSpace<Discrete>,
    settings: &TuneSettings,
) -> Result<ShiftedLoops, VerificationError> {
    let r = settings.mode_shift;
    let alone = (0..SHIFTED_MODES)
        .flat_map(|k| [1.0 - r, 1.0 + r].map(|f| (0..SHIFTED_MODES).map(|i| if i == k { f } else { 1.0 }).collect()));
    let combined = (0..1usize << COMBINED)
        .map(|signs| (0..COMBINED).map(|k| if (signs >> k) & 1 == 0 { 1.0 - r } else { 1.0 + r }).collect());
    let factors: Vec<Vec<f64>> = alone.chain(combined).collect();
    let speeds = settings.speeds.div_ceil(2).max(SHIFTED_SPEEDS);
    let plants: Result<Vec<(f64, Plant)>, VerificationError> = (0..speeds)
        .into_par_iter()
        .map(|k| {
            let rpm = machine.spindle.max_rpm * k as f64 / (speeds - 1) as f64;
            Ok((rpm, Plant::new(machine, rpm * TAU / 60.0, ModelDetail::Full)?))
        })
        .collect();
    let plants = plants?;
    let pairs: Vec<(&(f64, Plant), &Vec<f64>)> =
        plants.iter().flat_map(|p| factors.iter().map(move |f| (p, f))).collect();
    let rates: Result<Vec<f64>, VerificationError> = pairs
        .par_iter()
        .map(|((_, plant), factors)| {
            let shifted = plant.with_scaled_modes(factors);
            let rate = growth_rate_of(&shifted, &shifted.sample_plant()?, law);
            Ok(rate.map_err(in_step("PID with shifted modes"))?)
        })
        .collect();
    let rates = rates?;
    let worst = (0..rates.len()).reduce(|a, b| if rates[b] > rates[a] { b } else { a }).unwrap_or(0);
    Ok(ShiftedLoops {
        shift: r,
        loops: rates.len(),
        worst_growth_rate_per_s: rates.get(worst).copied().unwrap_or(f64::NAN),
        worst_factors: pairs.get(worst).map_or(vec![], |p| p.1.clone()),
        worst_speed_rpm: pairs.get(worst).map_or(f64::NAN, |p| p.0.0),
    })
}
