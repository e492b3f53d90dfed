//! Forces on the rotor that are not linear: magnets with bias, coil and voltage limits, and the backup bearings.
//!
//! Differential magnet (domain formula F = 4k i₀²/s₀² (η+ξ)(1+ηξ)/(1−ξ²)² cos α, written by its two coils):
//! F = (k_i i₀/4)·[c₊²/(1−ξ)² − c₋²/(1+ξ)²],  c± = 1 ± η held to 0 … i_max/i₀,  η = i/i₀,  ξ = κ x/s₀,  κ = k_s s₀/(k_i
//! i₀), so that ∂F/∂i = k_i and ∂F/∂x = k_s at rest are those of the spindle file (κ is cos α when the file follows the
//! formula). Saturation: the flux density of iron ends at B_sat, so one electromagnet pulls at most F_max = B_sat² A/µ₀
//! cos α at any gap and current (Schweitzer and Maslen, Magnetic Bearings, 2009, section 3.2); the pull of each coil is
//! cut off at the `max_force_n` of the bearing. Below it the law is unchanged; the bend of real iron before saturation
//! is left out.
//! An amplifier of second order counts as one of first order with the same lag; eddy currents, the delay that one axis
//! has beyond the others and what sensors pick up of the currents are left out.
//! Current: i̇ = ω_a (u − i), held to what the bus voltage drives through the coil, |i̇| ≤ U/L, L = k_i s₀/(2 i₀ κ).
//! Contact: beyond the clearance, normal force k_c·depth + c_c·approach (never pulling), Coulomb friction μ.

use crate::spindle::{Bearing, EffectiveBearing, Machine, Side};
use std::f64::consts::TAU;

/// A gap this close to the pole face, as a part of it, is where the force law ends.
pub(crate) const LARGEST_XI: f64 = 0.95;
/// Tangential speed at which friction reaches most of its value, m/s: smooths the sign at standstill.
pub(crate) const FRICTION_SPEED_M_S: f64 = 1e-3;

/// One axis of a bearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Magnet {
    pub(crate) ki_n_per_a: f64,
    pub(crate) kappa_per_m: f64,
    pub(crate) bias_a: f64,
    pub(crate) max_a: f64,
    pub(crate) max_n: f64,
    pub(crate) corner_rad_s: f64,
    pub(crate) slew_a_per_s: f64,
    pub(crate) inductance_h: f64,
}

impl Magnet {
    /// The magnet of an axis (0: x, 1: y) of a bearing after effects, with its amplifier, fed from a bus of
    /// `bus_voltage_v`. Its force constant is its own; k_s is that of the bearing, and what the axes differ by is a
    /// spring at the shaft.
    pub fn new(bearing: &Bearing, effective: &EffectiveBearing, axis: usize, bus_voltage_v: f64) -> Self {
        let own = &effective.axes[axis];
        let ki = effective.ki_n_per_a * own.force_factor;
        let kappa = effective.ks_n_per_m * bearing.gap_m / (ki * bearing.bias_current_a);
        let inductance = ki * bearing.gap_m / (2.0 * bearing.bias_current_a * kappa.max(1e-3));
        Self {
            ki_n_per_a: ki,
            kappa_per_m: kappa / bearing.gap_m,
            bias_a: bearing.bias_current_a,
            max_a: bearing.max_current_a,
            max_n: bearing.max_force_n,
            corner_rad_s: TAU * own.amplifier.lag_bandwidth_hz(),
            slew_a_per_s: bus_voltage_v / inductance,
            inductance_h: inductance,
        }
    }

    /// The magnets of both bearings of a machine: of the axis that bears less.
    pub fn both(machine: &Machine, bus_voltage_v: f64) -> [Self; 2] {
        let effective = machine.effective();
        let weaker = |(side, bearing): (Side, &EffectiveBearing)| {
            let [x, y] = [0, 1].map(|axis| Self::new(machine.spindle.bearing(side), bearing, axis, bus_voltage_v));
            if y.static_capacity_n() < x.static_capacity_n() { y } else { x }
        };
        [weaker((Side::Front, &effective.bearings[0])), weaker((Side::Rear, &effective.bearings[1]))]
    }

    /// Static load capacity (API 617, annex on magnetic bearings): the largest force on a rotor in the middle of its
    /// gap, N, with one coil at its largest current.
    pub fn static_capacity_n(&self) -> f64 {
        self.force_n((self.max_a - self.bias_a).max(0.0), 0.0)
    }

    /// Force slew rate (API 617): the force per time that the bus voltage drives from the bias, N/s, k_i U/L.
    pub fn slew_n_per_s(&self) -> f64 {
        self.ki_n_per_a * self.slew_a_per_s
    }

    /// Force on the rotor, N, at control current `current_a` and displacement `displacement_m`.
    pub fn force_n(&self, current_a: f64, displacement_m: f64) -> f64 {
        let xi = (self.kappa_per_m * displacement_m).clamp(-LARGEST_XI, LARGEST_XI);
        let eta = current_a / self.bias_a;
        let coil = |c: f64| c.clamp(0.0, self.max_a / self.bias_a);
        let (plus, minus) = (coil(1.0 + eta), coil(1.0 - eta));
        let largest = self.max_n / (0.25 * self.ki_n_per_a * self.bias_a);
        let (pull, push) = ((plus / (1.0 - xi)).powi(2).min(largest), (minus / (1.0 + xi)).powi(2).min(largest));
        0.25 * self.ki_n_per_a * self.bias_a * (pull - push)
    }

    /// The part of [`Self::force_n`] that the current makes.
    pub(crate) fn current_force_n(&self, current_a: f64, displacement_m: f64) -> f64 {
        self.force_n(current_a, displacement_m) - self.force_n(0.0, displacement_m)
    }

    /// Voltage that drives the coil through a change of current in `step_s`, V: L·Δi/Δt; the resistance is left out.
    pub fn voltage_v(&self, change_a: f64, step_s: f64) -> f64 {
        self.inductance_h * change_a / step_s
    }

    /// The current after `step_s` towards `command_a`, and whether the voltage limited it.
    pub fn advance(&self, current_a: f64, command_a: f64, step_s: f64) -> (f64, bool) {
        let reach = self.max_a - self.bias_a;
        let command = command_a.clamp(-reach.max(self.bias_a), reach.max(self.bias_a));
        let wanted = (command - current_a) * (1.0 - (-self.corner_rad_s * step_s).exp());
        let largest = self.slew_a_per_s * step_s;
        (current_a + wanted.clamp(-largest, largest), wanted.abs() > largest)
    }
}

/// Backup bearings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BackupBearing {
    /// Radial clearance, m.
    pub clearance_m: f64,
    /// Contact stiffness, N/m.
    pub stiffness_n_per_m: f64,
    /// Contact damping, N s/m.
    pub damping_n_s_per_m: f64,
    /// Friction coefficient.
    pub friction: f64,
    /// Radius of the contact on the rotor, m.
    pub radius_m: f64,
}

impl BackupBearing {
    /// Force (x, y) on the rotor, N; zero inside the clearance.
    pub fn force_n(&self, position: [f64; 2], velocity: [f64; 2], speed_rad_s: f64) -> [f64; 2] {
        let radius = position[0].hypot(position[1]);
        let depth = radius - self.clearance_m;
        if depth <= 0.0 {
            return [0.0, 0.0];
        }
        let n = [position[0] / radius, position[1] / radius];
        let t = [-n[1], n[0]];
        let approach = velocity[0] * n[0] + velocity[1] * n[1];
        let normal = (self.stiffness_n_per_m * depth + self.damping_n_s_per_m * approach).max(0.0);
        let sliding = velocity[0] * t[0] + velocity[1] * t[1] + speed_rad_s * self.radius_m;
        let tangential = -self.friction * normal * (sliding / FRICTION_SPEED_M_S).tanh();
        [-normal * n[0] + tangential * t[0], -normal * n[1] + tangential * t[1]]
    }
}
