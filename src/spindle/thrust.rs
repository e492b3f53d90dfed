//! The thrust axis: rotor and tool as a mass that one magnet holds along the shaft, not coupled to the radial axes.
//!
//! Rigid disc, m the mass: m ẍ = k_i i + k_s x + f. Flexible disc of mass m_d on the shaft of mass m − m_d, natural
//! frequency ω_d with the shaft held: the magnet acts on the disc, sensor and load f on the shaft,
//! m_d ẍ_d = k_i i + k_s x_d − k (x_d − x) − c (ẋ_d − ẋ), k = m_d ω_d², c = 2 ζ m_d ω_d.
//! Current and signal pass the amplifier, the eddy currents of a solid core, 1/(1 + √(s/ω_e)), and the sensor;
//! amplifier, sensor, delay and sample rate are those of the spindle (Schweitzer and Maslen, Magnetic Bearings, 2009).

use super::SpindleError;
use super::machine::{Electronics, Machine};
use super::realise::{first_order, half_order_lag};
use super::rule::rule;
use super::thrust_bearing::{DISC_DAMPING_RATIO, ThrustBearing};
use crate::linalg::{Mat, NumericError};
use crate::lti::connect::{append, series};
use crate::lti::sample::zoh_with_delay;
use crate::lti::{Continuous, Discrete, StateSpace};
use std::f64::consts::TAU;

/// The plant of a thrust bearing: inputs current command (A) and load on the shaft (N), outputs signal (m) and
/// displacement of the shaft (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrustAxis {
    /// The magnet.
    pub bearing: ThrustBearing,
    /// Mass that it carries, kg.
    pub mass_kg: f64,
    /// Amplifier, sensor, delay, sampling.
    pub electronics: Electronics,
}

impl ThrustAxis {
    /// The thrust axis of a machine; none where its file has none.
    ///
    /// # Errors
    /// [`SpindleError`] for a rotor that cannot be assembled, or a disc as heavy as all that the magnet carries.
    pub fn of(machine: &Machine) -> Result<Option<Self>, SpindleError> {
        let Some(bearing) = machine.spindle.thrust else {
            return Ok(None);
        };
        let mass_kg = match bearing.mass_kg {
            Some(given) => given,
            None => machine.rotor()?.mass_properties().mass_kg,
        };
        if let Some(disc_kg) = bearing.disc_mass_kg {
            let lighter = format!("must be smaller than the mass that the thrust bearing carries, {mass_kg:.4} kg");
            rule(disc_kg < mass_kg, "thrust.disc_mass_kg".to_owned(), disc_kg, &lighter)?;
        }
        Ok(Some(Self { bearing, mass_kg, electronics: machine.spindle.electronics }))
    }

    /// The plant without its delay.
    ///
    /// # Errors
    /// [`NumericError`] for numbers that are not finite.
    pub fn plant_without_delay(&self) -> Result<StateSpace<Continuous>, NumericError> {
        let gain = |factor: f64| Mat::from_fn(1, 1, |_, _| factor);
        let mut magnet = first_order(self.electronics.amplifier_bandwidth_hz)?;
        if let Some(corner_hz) = self.bearing.eddy_corner_hz {
            magnet = series(&magnet, &half_order_lag(corner_hz)?)?;
        }
        let magnet = magnet.scale_outputs(&gain(self.bearing.ki_n_per_a));
        let pass = StateSpace::gain(gain(1.0), Continuous);
        let sensor = first_order(self.electronics.sensor_bandwidth_hz)?;
        let moved = series(&append(&magnet, &pass), &self.shaft()?)?;
        series(&moved, &append(&sensor, &pass))
    }

    /// From the current command to the signal at the sample instants, with the hold and the exact delay; a delay below
    /// half a sample counts as half a sample.
    ///
    /// # Errors
    /// As [`ThrustAxis::plant_without_delay`].
    pub fn sample_plant(&self) -> Result<StateSpace<Discrete>, NumericError> {
        let period_s = self.electronics.sample_period_s();
        zoh_with_delay(&self.plant_without_delay()?.select(&[0], &[0]), period_s, self.delay_s() - 0.5 * period_s)
    }

    /// Delay of the current with the half sample of the hold, s.
    pub(crate) fn delay_s(&self) -> f64 {
        self.electronics.delay_s.max(0.5 * self.electronics.sample_period_s())
    }

    /// Forces of magnet and load to the displacement of the shaft, twice. States are displacements times the pole of
    /// the rigid mass on the magnet, and velocities.
    fn shaft(&self) -> Result<StateSpace<Continuous>, NumericError> {
        let b = &self.bearing;
        let scale = (b.ks_n_per_m / self.mass_kg).sqrt().max(1.0);
        let flexible = b.disc_mass_kg.zip(b.disc_mode_hz);
        // Bodies from the magnet on: their masses, and stiffness and damping between the first two.
        let (masses, stiffness, damping) = match flexible {
            Some((disc_kg, hz)) => {
                let omega = TAU * hz;
                let ratio = b.disc_damping_ratio.unwrap_or(DISC_DAMPING_RATIO);
                (vec![disc_kg, self.mass_kg - disc_kg], disc_kg * omega * omega, 2.0 * ratio * disc_kg * omega)
            }
            None => (vec![self.mass_kg], 0.0, 0.0),
        };
        let n = masses.len();
        let between = |value: f64, i: usize, j: usize| {
            if n == 1 {
                0.0
            } else if i == j {
                -value
            } else {
                value
            }
        };
        let negative = |i: usize, j: usize| if i == 0 && j == 0 { b.ks_n_per_m } else { 0.0 };
        let a = Mat::from_fn(2 * n, 2 * n, |i, j| match (i.checked_sub(n), j.checked_sub(n)) {
            (None, None) => 0.0,
            (None, Some(j)) => {
                if i == j {
                    scale
                } else {
                    0.0
                }
            }
            (Some(i), None) => (between(stiffness, i, j) + negative(i, j)) / (masses[i] * scale),
            (Some(i), Some(j)) => between(damping, i, j) / masses[i],
        });
        let acts = |body: usize, input: usize| body == if input == 0 { 0 } else { n - 1 };
        let forces = Mat::from_fn(2 * n, 2, |i, j| match i.checked_sub(n) {
            Some(body) if acts(body, j) => masses[body].recip(),
            _ => 0.0,
        });
        let shown = Mat::from_fn(2, 2 * n, |_, j| if j == n - 1 { scale.recip() } else { 0.0 });
        StateSpace::new(a, forces, shown, Mat::zeros(2, 2), Continuous)
    }
}
