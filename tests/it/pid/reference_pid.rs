//! A PID that levitates the reference spindle.

use muspin::pid::parameters::{AxisParameters, Biquad, PidParameters};
use muspin::spindle::{Machine, Side};
use std::f64::consts::TAU;

/// A PID for the reference spindle and rotors like it, gains in terms of those of the bearings; it levitates them and is
/// no good one.
pub fn reference_pid(machine: &Machine) -> PidParameters {
    let axis = |side: Side, gain, integral_hz, zero_hz, corner_hz, roll_hz, b: [[f64; 4]; 2]| {
        let bearing = machine.spindle.bearing(side);
        let biquad = |v: [f64; 4]| Biquad {
            zero_rad_s: TAU * v[0],
            zero_damping: v[1],
            pole_rad_s: TAU * v[2],
            pole_damping: v[3],
        };
        let corner: f64 = TAU * corner_hz;
        AxisParameters {
            gain_a_per_m: gain * bearing.ks_n_per_m / bearing.ki_n_per_a,
            integral_rad_s: TAU * integral_hz,
            derivative_s: 1.0 / (TAU * zero_hz) - 1.0 / corner,
            derivative_corner_rad_s: corner,
            lowpass_rad_s: TAU * roll_hz,
            biquads: b.map(biquad),
        }
    };
    PidParameters {
        front: axis(
            Side::Front,
            9.6,
            0.71,
            146.0,
            3670.0,
            2930.0,
            [[1416.0, 0.586, 1104.0, 0.198], [1598.0, 0.0276, 3387.0, 0.118]],
        ),
        rear: axis(
            Side::Rear,
            5.2,
            1.44,
            121.0,
            1947.0,
            2925.0,
            [[1430.0, 0.211, 807.0, 0.058], [1832.0, 0.2875, 4071.0, 0.628]],
        ),
    }
}
