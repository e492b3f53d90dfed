//! The open-loop plant at one speed: from commanded currents and forces to sensor signals and displacements.
//!
//! Chain of an axis: command → delay e^{−sτ} → amplifier 1/(1+s/ω_a) → eddy currents 1/(1+√(s/ω_e)) → force ki·i →
//! shaft on magnets → sensor axes, gain → sensor 1/(1+s/ω_s) → low-pass. Inputs (10): commanded currents front_x,
//! front_y, rear_x, rear_y (A); forces tool_x, tool_y, front_actuator_x, …, rear_actuator_y (N). Outputs (10): sensor
//! signals front_x … rear_y (m); displacements tool_x … rear_actuator_y (m, absolute).
//!
//! The shaft is isotropic, so it is evaluated in r = x + jy: with H(ω) the response to r-forces,
//! a = (H(ω) + H̄(−ω))/2 goes x→x and y→y, b = (H(ω) − H̄(−ω))/2j goes x→y, and −b goes y→x. Springs in one plane are
//! closed round that.

use super::SpindleError;
use super::effective::{Effective, EffectiveBearing};
use super::machine::Machine;
use super::mechanics::Mechanics;
use super::model_detail::ModelDetail;
use super::response::channels::{in_pairs, planar};
use super::response::electronics::ElectronicsLine;
use super::response::feedback::close_in_planes;
use crate::linalg::{Mat, c64};
use crate::lti::Response;

/// Number of commanded currents and of sensor signals.
pub const AXES: usize = 4;
/// Number of inputs and of outputs of a plant. Inputs: currents front x, front y, rear x, rear y, force at the tool x,
/// y, forces at the actuators front x, front y, rear x, rear y. Outputs: signals in the order of the currents,
/// displacements of the tool x, y, and at the actuators in the order of the forces.
pub const CHANNELS: usize = 10;
/// The open-loop plant of a machine at a speed.
#[derive(Clone, Debug)]
pub struct Plant {
    pub(super) mechanics: Mechanics,
    pub(super) effective: Effective,
    pub(super) sample_period_s: f64,
    /// Modal ports behind the ten channels of the frequency response.
    modal_ports: usize,
}

impl Plant {
    /// The plant at `speed_rad_s`.
    ///
    /// # Errors
    /// [`SpindleError`] when the machine breaks a rule or an eigenvalue iteration fails.
    pub fn new(machine: &Machine, speed_rad_s: f64, detail: ModelDetail) -> Result<Self, SpindleError> {
        let effective = machine.effective();
        Ok(Self {
            mechanics: Mechanics::new(machine, &effective, speed_rad_s, detail)?,
            effective,
            sample_period_s: machine.spindle.electronics.sample_period_s(),
            modal_ports: 0,
        })
    }

    /// The design model of the spindle: its `flexible_modes` with the static flexibility of the others.
    ///
    /// # Errors
    /// As [`Plant::new`].
    pub fn design_model(machine: &Machine, speed_rad_s: f64) -> Result<Self, SpindleError> {
        let detail = ModelDetail::Modes { flexible: machine.spindle.flexible_modes, static_residual: true };
        Self::new(machine, speed_rad_s, detail)
    }

    /// The same plant whose frequency response has the ports of modal uncertainty behind the ten channels: for each of
    /// the first `modes` flexible modes an input that adds to q̈ (x, then y) and the modal coordinate q (x, then y) as
    /// output. For a state space see [`Plant::state_space_with_modal_ports`].
    #[must_use]
    pub fn with_modal_ports(&self, modes: usize) -> Self {
        let modes = modes.min(self.mechanics.flexible());
        Self { mechanics: self.mechanics.with_modal_ports(modes), modal_ports: modes, ..self.clone() }
    }

    /// The same plant with the natural frequencies of its first flexible modes multiplied by these factors; modal
    /// dampers 2ζω keep their values. Without modal ports.
    #[must_use]
    pub fn with_scaled_modes(&self, factors: &[f64]) -> Self {
        Self { mechanics: self.mechanics.with_scaled_modes(factors), modal_ports: 0, ..self.clone() }
    }

    /// The same plant, whose response is asked at a few frequencies only.
    #[must_use]
    pub(crate) fn for_few_frequencies(self) -> Self {
        Self { mechanics: self.mechanics.for_few_frequencies(), ..self }
    }

    /// Total delay τ from sampling to current command that all axes share, s.
    pub(crate) fn delay_s(&self) -> f64 {
        self.effective.common_delay_s()
    }

    /// Sample period of the machine, s.
    pub fn sample_period_s(&self) -> f64 {
        self.sample_period_s
    }

    /// Whether x and y do not act on each other and answer alike, so that one plane stands for both.
    pub(crate) fn planes_are_alike(&self) -> bool {
        let bearings = &self.effective.bearings;
        self.mechanics.planes_are_decoupled()
            && self.mechanics.plane_laws().is_empty()
            && !self.effective.signals_mix()
            && bearings.iter().all(EffectiveBearing::axes_are_alike)
    }

    /// The shaft.
    pub(crate) fn mechanics(&self) -> &Mechanics {
        &self.mechanics
    }

    /// Angular frequencies of the true flexible modes in the model, rad/s.
    pub fn flexible_rad_s(&self) -> &[f64] {
        let rigid = crate::rotor::modes::RIGID;
        &self.mechanics.omega_rad_s()[rigid..rigid + self.mechanics.flexible()]
    }
}

impl Response for Plant {
    fn at(&self, omega_rad_s: f64) -> Mat<c64> {
        let (forward, backward) = self.mechanics.both_ways(omega_rad_s);
        // Ports: 0, 1 control; 2 tool; 3, 4 actuators; 5, 6 sensors.
        let ports = self.mechanics.ports();
        let first = ports - self.modal_ports;
        let laws = self.mechanics.plane_laws();
        let further: Vec<usize> = (first..ports).chain(laws.iter().map(|s| s.port)).collect();
        let inputs = [&[0usize, 1, 2, 3, 4], further.as_slice()].concat();
        let outputs = [&[5usize, 6, 2, 3, 4], further.as_slice()].concat();
        let channels = 2 * inputs.len();
        let mut h = in_pairs(inputs.len(), |n| {
            let entry = outputs[n / inputs.len()] * ports + inputs[n % inputs.len()];
            planar(forward[entry], backward.as_ref().map(|b| b[entry]))
        });
        if !laws.is_empty() {
            let first = inputs.len() - laws.len();
            (_, h) = close_in_planes(&h, channels, first, laws, omega_rad_s);
        }
        ElectronicsLine::new(&self.effective, omega_rad_s).apply_with_pickup(&mut h, channels);
        let outer = CHANNELS + 2 * self.modal_ports;
        Mat::from_fn(outer, outer, |i, j| h[i * channels + j])
    }
}
