//! The open-loop plant at one speed: from commanded currents and forces to sensor signals and displacements.
//!
//! Chain of an axis: command → delay e^{−sτ} → amplifier 1/(1+s/ω_a) → eddy currents 1/(1+√(s/ω_e)) → force ki·i → shaft on
//! magnets → sensor axes, gain → sensor 1/(1+s/ω_s) → low-pass. Inputs (10): commanded currents front_x, front_y, rear_x,
//! rear_y (A); forces tool_x, tool_y, front_actuator_x, …, rear_actuator_y (N). Outputs (10): sensor signals front_x …
//! rear_y (m); displacements tool_x … rear_actuator_y (m, absolute).
//!
//! The shaft is isotropic, so it is evaluated in r = x + jy: with H(ω) the response to r-forces,
//! a = (H(ω) + H̄(−ω))/2 goes x→x and y→y, b = (H(ω) − H̄(−ω))/2j goes x→y, and −b goes y→x.

use super::SpindleError;
use super::effective::{Effective, EffectiveBearing};
use super::machine::Machine;
use super::mechanics::Mechanics;
use crate::linalg::{Mat, c64};
use crate::lti::Response;
use std::f64::consts::TAU;

/// Number of commanded currents and of sensor signals.
pub const AXES: usize = 4;
/// Number of inputs and of outputs of a plant.
pub const CHANNELS: usize = 10;
/// Names of the inputs.
pub const INPUT_NAMES: [&str; CHANNELS] = [
    "front_x",
    "front_y",
    "rear_x",
    "rear_y",
    "tool_force_x",
    "tool_force_y",
    "front_actuator_force_x",
    "front_actuator_force_y",
    "rear_actuator_force_x",
    "rear_actuator_force_y",
];
/// Names of the outputs.
pub const OUTPUT_NAMES: [&str; CHANNELS] = [
    "front_x",
    "front_y",
    "rear_x",
    "rear_y",
    "tool_x",
    "tool_y",
    "front_actuator_x",
    "front_actuator_y",
    "rear_actuator_x",
    "rear_actuator_y",
];

/// How much of the shaft a plant keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelDetail {
    /// The full FE model: its modes up to 24 kHz, and Ritz vectors of all ports and gyroscopic moments for the rest.
    Full,
    /// Two rigid and so many flexible modes per plane.
    Modes {
        /// Flexible modes.
        flexible: usize,
        /// Whether the cut modes leave their static flexibility.
        static_residual: bool,
    },
}

/// The open-loop plant of a machine at a speed.
#[derive(Clone, Debug)]
pub struct Plant {
    pub(super) mechanics: Mechanics,
    pub(super) effective: Effective,
    pub(super) sensor_bandwidth_hz: f64,
    pub(super) sample_period_s: f64,
    speed_rad_s: f64,
    /// Modal ports behind the ten channels of the frequency response.
    modal_ports: usize,
}

impl Plant {
    /// The plant at `speed_rad_s`.
    ///
    /// # Errors
    /// [`SpindleError`] when the machine breaks a rule or an eigenvalue iteration fails.
    pub fn new(
        machine: &Machine,
        speed_rad_s: f64,
        detail: ModelDetail,
    ) -> Result<Self, SpindleError> {
        let effective = machine.effective();
        let electronics = &machine.spindle.electronics;
        Ok(Self {
            mechanics: Mechanics::new(machine, &effective, speed_rad_s, detail)?,
            effective,
            sensor_bandwidth_hz: electronics.sensor_bandwidth_hz,
            sample_period_s: electronics.sample_period_s(),
            speed_rad_s,
            modal_ports: 0,
        })
    }

    /// The design model of the spindle: its `flexible_modes` with the static flexibility of the others.
    ///
    /// # Errors
    /// As [`Plant::new`].
    pub fn design_model(machine: &Machine, speed_rad_s: f64) -> Result<Self, SpindleError> {
        let detail = ModelDetail::Modes {
            flexible: machine.spindle.flexible_modes,
            static_residual: true,
        };
        Self::new(machine, speed_rad_s, detail)
    }

    /// The same plant whose frequency response has the ports of modal uncertainty behind the ten channels: for each of the
    /// first `modes` flexible modes an input that adds to q̈ (x, then y) and the modal coordinate q (x, then y) as output.
    /// For a state space see [`Plant::state_space_with_modal_ports`].
    #[must_use]
    pub fn with_modal_ports(&self, modes: usize) -> Self {
        let modes = modes.min(self.mechanics.flexible());
        Self {
            mechanics: self.mechanics.with_modal_ports(modes),
            modal_ports: modes,
            ..self.clone()
        }
    }

    /// The same plant with the natural frequencies of its first flexible modes multiplied by these factors; modal dampers
    /// 2ζω keep their values. Without modal ports.
    #[must_use]
    pub fn with_scaled_modes(&self, factors: &[f64]) -> Self {
        Self {
            mechanics: self.mechanics.with_scaled_modes(factors),
            modal_ports: 0,
            ..self.clone()
        }
    }

    /// Speed, rad/s.
    pub fn speed_rad_s(&self) -> f64 {
        self.speed_rad_s
    }

    /// Total delay τ from sampling to current command, s.
    pub fn delay_s(&self) -> f64 {
        self.effective.delay_s
    }

    /// Sample period of the machine, s.
    pub fn sample_period_s(&self) -> f64 {
        self.sample_period_s
    }

    /// The shaft.
    pub fn mechanics(&self) -> &Mechanics {
        &self.mechanics
    }

    /// Angular frequencies of the true flexible modes in the model, rad/s.
    pub fn flexible_rad_s(&self) -> &[f64] {
        let rigid = crate::rotor::modes::RIGID;
        &self.mechanics.omega_rad_s()[rigid..rigid + self.mechanics.flexible()]
    }

    /// Force per commanded current of bearing 0 or 1, without ki: delay, amplifier, eddy currents.
    fn actuator(&self, bearing: &EffectiveBearing, omega: f64) -> c64 {
        let s = c64::new(0.0, omega);
        let one = c64::new(1.0, 0.0);
        let delay = (-s * self.effective.delay_s).exp();
        let amplifier = one / (one + s / (TAU * bearing.amplifier_bandwidth_hz));
        let eddy = bearing
            .eddy_corner_hz
            .map_or(one, |corner| one / (one + (s / (TAU * corner)).sqrt()));
        delay * amplifier * eddy
    }

    /// Signal per displacement of a bearing's sensors, without rotation.
    fn sensor(&self, bearing: &EffectiveBearing, omega: f64) -> c64 {
        let s = c64::new(0.0, omega);
        let one = c64::new(1.0, 0.0);
        let first = one / (one + s / (TAU * self.sensor_bandwidth_hz));
        let lowpass = bearing.sensor_lowpass_hz.map_or(one, |bandwidth| {
            let p = s / (TAU * bandwidth);
            one / (one + 2.0 * LOWPASS_DAMPING * p + p * p)
        });
        first * lowpass * bearing.sensor_gain
    }
}

/// Damping ratio of the sensor low-pass.
pub const LOWPASS_DAMPING: f64 = 0.707;

impl EffectiveBearing {
    /// Forces (x, y) per currents (x, y) behind the amplifiers, N/A.
    pub fn force_matrix(&self) -> [[f64; 2]; 2] {
        let (direct, cross) = (self.ki_n_per_a, self.ki_n_per_a * self.coupling_ratio);
        [[direct, cross], [cross, direct]]
    }

    /// Sensor axes (x', y') from displacements (x, y).
    pub fn axes_matrix(&self) -> [[f64; 2]; 2] {
        let (sin, cos) = self.sensor_angle_rad.sin_cos();
        [[cos, sin], [-sin, cos]]
    }
}

impl Response for Plant {
    fn at(&self, omega_rad_s: f64) -> Mat<c64> {
        let forward = self.mechanics.receptance(omega_rad_s);
        let backward = if self.mechanics.planes_are_decoupled() {
            None
        } else {
            Some(self.mechanics.receptance(-omega_rad_s))
        };
        // Ports: 0, 1 control; 2 tool; 3, 4 actuators; 5, 6 sensors.
        let first = forward.nrows() - self.modal_ports;
        let modal: Vec<usize> = (first..forward.nrows()).collect();
        let inputs = [&[0usize, 1, 2, 3, 4], modal.as_slice()].concat();
        let outputs = [&[5usize, 6, 2, 3, 4], modal.as_slice()].concat();
        let channels = CHANNELS + 2 * self.modal_ports;
        let mut h = Mat::<c64>::zeros(channels, channels);
        for (o, out) in outputs.iter().copied().enumerate() {
            for (i, input) in inputs.iter().copied().enumerate() {
                let plus = forward[(out, input)];
                let (a, b) = match &backward {
                    None => (plus, c64::new(0.0, 0.0)),
                    Some(backward) => {
                        let minus = backward[(out, input)].conj();
                        (0.5 * (plus + minus), c64::new(0.0, -0.5) * (plus - minus))
                    }
                };
                h[(2 * o, 2 * i)] = a;
                h[(2 * o + 1, 2 * i + 1)] = a;
                h[(2 * o + 1, 2 * i)] = b;
                h[(2 * o, 2 * i + 1)] = -b;
            }
        }
        for (i, bearing) in self.effective.bearings.iter().enumerate() {
            let (gain, force) = (self.actuator(bearing, omega_rad_s), bearing.force_matrix());
            for row in 0..channels {
                let (x, y) = (h[(row, 2 * i)], h[(row, 2 * i + 1)]);
                h[(row, 2 * i)] = gain * (x * force[0][0] + y * force[1][0]);
                h[(row, 2 * i + 1)] = gain * (x * force[0][1] + y * force[1][1]);
            }
            let (gain, axes) = (self.sensor(bearing, omega_rad_s), bearing.axes_matrix());
            for column in 0..channels {
                let (x, y) = (h[(2 * i, column)], h[(2 * i + 1, column)]);
                h[(2 * i, column)] = gain * (x * axes[0][0] + y * axes[0][1]);
                h[(2 * i + 1, column)] = gain * (x * axes[1][0] + y * axes[1][1]);
            }
        }
        h
    }
}
