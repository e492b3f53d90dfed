//! A PID with given numbers, the same in x and y: a channel a bearing, or one for translation and one for tilt.
//!   i = −C q,  C = (P + I/s + D s/(1 + s/w_d)) · (1 + s/w_z)/(1 + s/w_p) · notches · LP₂(w, ζ 0.7)
//! Sampled by Tustin's rule, C(z) = C(s) at s = (2/T)(z − 1)/(z + 1); notches are moved so that frequency and bandwidth
//! are those of the sampled ones.
//! Tilt and translation: q_t is the displacement of the centre of gravity, q_θ the tilt times half the distance of the
//! magnets, both from the sensors; i_t acts as a force 2 k_i i_t at the centre of gravity, i_θ as a moment k_i i_θ
//! times the distance of the magnets, with the mean k_i of both. Of a symmetric rotor these are half the sum and half
//! the difference of the sensors, and sum and difference of the currents.
//! A stiffness K given in the place of P is net of the magnet: P = (K + k_s)/k_i, of the bearing or the mean of both.

use super::parameters::{Biquad, roll_off};
use crate::controller::{ControlLaw, Controller, ControllerError, in_step};
use crate::linalg::{Mat, NumericError};
use crate::lti::connect::{append, both_planes, series};
use crate::lti::sample::tustin;
use crate::lti::{Continuous, StateSpace};
use crate::spindle::{Machine, Side, SpindleError};
use thiserror::Error;

/// What the two channels of a PID act on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ChannelCoordinates {
    /// Front and rear bearing.
    #[default]
    Bearings,
    /// Translation and tilt of the rotor.
    TiltTranslation,
}

/// What pushes back in proportion to the displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Restoring {
    /// P, A/m.
    Gain(f64),
    /// Stiffness at the magnet that is left of its negative one, N/m.
    Stiffness(f64),
}

/// A notch: at its frequency the share `depth` of the gain is taken away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Notch {
    /// Frequency, rad/s.
    pub omega_rad_s: f64,
    /// Share of the gain taken away, above 0 and at most 1.
    pub depth: f64,
    /// Bandwidth over frequency.
    pub width: f64,
}

/// Numbers of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenChannel {
    /// P.
    pub restoring: Restoring,
    /// I, A/(m s).
    pub integral_a_per_m_s: f64,
    /// D, A s/m.
    pub damping_a_s_per_m: f64,
    /// w_d, rad/s.
    pub derivative_corner_rad_s: f64,
    /// w_z and w_p, rad/s.
    pub lead_rad_s: Option<[f64; 2]>,
    /// Notches.
    pub notches: Vec<Notch>,
    /// w, rad/s.
    pub roll_off_rad_s: Option<f64>,
}

/// A PID as a person states it.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenPid {
    /// Name of the controller.
    pub name: String,
    /// What the channels act on.
    pub coordinates: ChannelCoordinates,
    /// Front and rear, or translation and tilt.
    pub channels: [GivenChannel; 2],
}

/// Why given numbers make no controller.
#[derive(Debug, Error)]
pub enum GivenPidError {
    /// The machine.
    #[error(transparent)]
    Machine(#[from] SpindleError),
    /// The realisation.
    #[error(transparent)]
    Law(#[from] ControllerError),
}

impl GivenPid {
    /// The PID as it runs on a machine: sampled, u = K y.
    ///
    /// # Errors
    /// [`GivenPidError`] when the rotor breaks a rule, numbers are not finite, or a pole maps to infinity.
    pub fn sample(&self, machine: &Machine) -> Result<Controller, GivenPidError> {
        let numeric = in_step("PID with given numbers");
        let (magnets, period_s) = (self.magnets(machine), machine.spindle.electronics.sample_period_s());
        let [first, second] = [0, 1].map(|k| self.channels[k].system(magnets[k], period_s));
        let channels = append(&first.map_err(&numeric)?, &second.map_err(&numeric)?);
        let plane = match self.coordinates {
            ChannelCoordinates::Bearings => channels,
            ChannelCoordinates::TiltTranslation => {
                let (to_currents, of_signals) = tilt_translation(machine)?;
                channels.scale_inputs(&of_signals).scale_outputs(&to_currents)
            }
        };
        let negative = both_planes(&plane).scale_outputs(&diagonal([-1.0; 4]));
        let law = tustin(&negative, period_s).map_err(&numeric)?;
        Ok(Controller { name: self.name.clone(), law: ControlLaw::Discrete(law) })
    }

    /// k_i in N/A and k_s in N/m that the channels act with.
    fn magnets(&self, machine: &Machine) -> [(f64, f64); 2] {
        let own = [Side::Front, Side::Rear].map(|side| machine.spindle.bearing(side));
        let [front, rear] = own.map(|bearing| (bearing.ki_n_per_a, bearing.ks_n_per_m));
        match self.coordinates {
            ChannelCoordinates::Bearings => [front, rear],
            ChannelCoordinates::TiltTranslation => [(0.5 * (front.0 + rear.0), 0.5 * (front.1 + rear.1)); 2],
        }
    }
}

impl GivenChannel {
    /// C(s) with k_i and k_s of its magnet.
    fn system(
        &self,
        (ki_n_per_a, ks_n_per_m): (f64, f64),
        period_s: f64,
    ) -> Result<StateSpace<Continuous>, NumericError> {
        let m = |r, c, values: &[f64]| Mat::from_fn(r, c, |i, j| values[i * c + j]);
        let gain = match self.restoring {
            Restoring::Gain(gain_a_per_m) => gain_a_per_m,
            Restoring::Stiffness(net_n_per_m) => (net_n_per_m + ks_n_per_m) / ki_n_per_a,
        };
        let (corner, steep) = (self.derivative_corner_rad_s, self.damping_a_s_per_m * self.derivative_corner_rad_s);
        let integral = self.integral_a_per_m_s;
        // P + D w_d − D w_d · w_d/(s + w_d), and I/s where there is one: a zero integral leaves no state at zero.
        let mut chain = if integral > 0.0 {
            let (a, b) = (m(2, 2, &[0.0, 0.0, 0.0, -corner]), m(2, 1, &[integral, corner]));
            StateSpace::new(a, b, m(1, 2, &[1.0, -steep]), m(1, 1, &[gain + steep]), Continuous)?
        } else {
            let (a, b) = (m(1, 1, &[-corner]), m(1, 1, &[corner]));
            StateSpace::new(a, b, m(1, 1, &[-steep]), m(1, 1, &[gain + steep]), Continuous)?
        };
        if let Some([zero, pole]) = self.lead_rad_s {
            let ratio = pole / zero;
            let (a, c) = (m(1, 1, &[-pole]), m(1, 1, &[1.0 - ratio]));
            let lead = StateSpace::new(a, m(1, 1, &[pole]), c, m(1, 1, &[ratio]), Continuous)?;
            chain = series(&chain, &lead)?;
        }
        for notch in &self.notches {
            chain = series(&chain, &notch.biquad(period_s).system()?)?;
        }
        match self.roll_off_rad_s {
            Some(corner) => series(&chain, &roll_off(corner)?),
            None => Ok(chain),
        }
    }
}

impl Notch {
    /// The section that Tustin's rule makes the notch of: ω' = (2/T) tan(ωT/2), and its slope over ω for the bandwidth.
    fn biquad(&self, period_s: f64) -> Biquad {
        let half = 0.5 * self.omega_rad_s * period_s;
        let omega = 2.0 / period_s * half.tan();
        let damping = 0.5 * self.width * 2.0 * half / (2.0 * half).sin();
        Biquad {
            zero_rad_s: omega,
            zero_damping: damping * (1.0 - self.depth),
            pole_rad_s: omega,
            pole_damping: damping,
        }
    }
}

/// Currents front and rear of those of translation and tilt, and translation and tilt of the signals front and rear.
fn tilt_translation(machine: &Machine) -> Result<(Mat<f64>, Mat<f64>), SpindleError> {
    let (planes, centre) = (&machine.spindle.planes, machine.rotor()?.mass_properties().centre_of_gravity_m);
    let span = planes.bearing_span_m();
    let [front, rear] = [Side::Front, Side::Rear].map(|side| machine.spindle.bearing(side).ki_n_per_a);
    let mean = 0.5 * (front + rear);
    // Forces front and rear: of 2 k_i i_t the shares that make no moment, of the moment k_i i_θ·span a pair.
    let share = (planes.rear_actuator_m - centre) / span;
    let to_currents = [[2.0 * mean * share / front, mean / front], [2.0 * mean * (1.0 - share) / rear, -mean / rear]];
    let between = planes.rear_sensor_m - planes.front_sensor_m;
    let share = (planes.rear_sensor_m - centre) / between;
    let tilt = 0.5 * span / between;
    let of_signals = [[share, 1.0 - share], [tilt, -tilt]];
    let matrix = |rows: [[f64; 2]; 2]| Mat::from_fn(2, 2, |i, j| rows[i][j]);
    Ok((matrix(to_currents), matrix(of_signals)))
}

fn diagonal(values: [f64; 4]) -> Mat<f64> {
    Mat::from_fn(4, 4, |i, j| if i == j { values[i] } else { 0.0 })
}
