//! Levels and corners of a specification that follow from the machine: from bias, sensors, sample rate and rigid-body
//! dynamics.
//!
//! A specification that states every level is the same for every machine, so that μ of two machines can be compared.
//! With `defaults: machine` the same is asked of each machine relative to its own hardware.

use super::weights::{FreeQuantity, Weights};
use crate::rotor::{PlanarModes, Rotor};
use crate::spindle::{Machine, Spindle, SpindleError};
use std::f64::consts::TAU;

/// Part of the bias current that a unit disturbance may ask for: the force of a magnet is linear up to the bias, and a
/// sixth is left for unbalance and noise.
const PART_OF_BIAS: f64 = 5.0 / 6.0;
/// Corner of the roll-off relative to the sample rate: with one and a half samples of delay the loop has lost 80°
/// there.
const PART_OF_SAMPLE_RATE: f64 = 0.15;
/// The roll-off begins above the last mode that the table names by this factor, so that the controller can damp it.
const ABOVE_LAST_MODE: f64 = 1.1;
/// No later than this part of the sample rate, half of Nyquist.
const LATEST: f64 = 0.25;
/// Noise that the design assumes, in units of the sensor's: it also limits how hard the controller works.
const NOISE_FACTOR: f64 = 4.0;
/// The same relative to the clearance of the backup bearings, for a sensor without noise.
const PART_OF_CLEARANCE: f64 = 1e-3;
/// Crossovers relative to f₀ = √(Σks/m)/2π, at which the rotor would leave the magnets' centre: loads turn dynamic
/// below it, and displacement at the bearings is limited above it, else the weight fights the unavoidable |S| > 1.
const LOAD_CROSSOVER: f64 = 0.5;
const TOOL_CROSSOVER: f64 = 0.5;
const BEARING_CROSSOVER: f64 = 1.2;
/// f₀ in relation to the first bending mode where the magnets have no negative stiffness.
const WITHOUT_STIFFNESS: f64 = 0.07;

impl Weights {
    /// The specification with what it leaves to the machine put in; as it is when it leaves nothing.
    ///
    /// # Errors
    /// [`SpindleError`] when the rotor of the spindle cannot be assembled.
    pub fn on(&self, machine: &Machine) -> Result<Self, SpindleError> {
        let spindle = &machine.spindle;
        let mut filled = self.clone();
        if filled.uncertainty.negative_stiffness > 0.0 {
            let bearings = [&spindle.front, &spindle.rear];
            filled.uncertainty.ks_n_per_m = Some(bearings.map(|b| b.ks_n_per_m.abs()));
        }
        if self.open.is_empty() {
            return Ok(filled);
        }
        let rotor = Rotor::new(0.0, spindle.sections.clone(), &spindle.discs).map_err(SpindleError::Rotor)?;
        let modes_hz = PlanarModes::new(&rotor).map_err(SpindleError::Shaft)?.flexible_hz();
        let unstable_hz = unstable_hz(spindle, &rotor, &modes_hz);
        for quantity in filled.open.drain(..).collect::<Vec<_>>() {
            match quantity {
                FreeQuantity::LoadCrossover(place) => {
                    filled.load_crossover_hz[place] = LOAD_CROSSOVER * unstable_hz;
                }
                FreeQuantity::DisplacementCrossover(place) => {
                    let factor = match place {
                        0 => TOOL_CROSSOVER,
                        _ => BEARING_CROSSOVER,
                    };
                    filled.displacement_crossover_hz[place] = factor * unstable_hz;
                }
                FreeQuantity::CurrentLimit => filled.current_limit_a = current_limit_a(spindle),
                FreeQuantity::CurrentRolloff => {
                    let last = self.mode_uncertainty.len().min(modes_hz.len());
                    let named = last.checked_sub(1).map_or(0.0, |k| modes_hz[k]);
                    filled.current_rolloff_hz = rolloff_hz(spindle, named);
                }
                FreeQuantity::SensorNoise => filled.sensor_noise_m = noise_m(spindle),
            }
        }
        Ok(filled)
    }
}

/// Frequency at which the rotor without its tool leaves the centre of the magnets, Hz.
fn unstable_hz(spindle: &Spindle, rotor: &Rotor, modes_hz: &[f64]) -> f64 {
    let stiffness = spindle.front.ks_n_per_m + spindle.rear.ks_n_per_m;
    if stiffness > 0.0 {
        (stiffness / rotor.mass_properties().mass_kg).sqrt() / TAU
    } else {
        let nyquist_hz = 0.5 * spindle.electronics.sample_rate_hz;
        WITHOUT_STIFFNESS * modes_hz.first().copied().unwrap_or(nyquist_hz)
    }
}

fn current_limit_a(spindle: &Spindle) -> f64 {
    let of = |b: &crate::spindle::Bearing| (PART_OF_BIAS * b.bias_current_a).min(b.max_current_a - b.bias_current_a);
    of(&spindle.front).min(of(&spindle.rear))
}

fn rolloff_hz(spindle: &Spindle, last_mode_hz: f64) -> f64 {
    let rate = spindle.electronics.sample_rate_hz;
    (PART_OF_SAMPLE_RATE * rate).max(ABOVE_LAST_MODE * last_mode_hz).min(LATEST * rate)
}

fn noise_m(spindle: &Spindle) -> f64 {
    match spindle.electronics.sensor_noise_m {
        noise if noise > 0.0 => NOISE_FACTOR * noise,
        _ => PART_OF_CLEARANCE * spindle.backup_clearance_m,
    }
}
