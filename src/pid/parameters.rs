//! Per-axis PID with lead, roll-off and two biquads, equal in x and y:
//!   i = −C y,  C = kp (1 + wᵢ/s + T_d s/(1 + s/w_d)) · LP₂(w_lp, ζ 0.7) · BQ₁ · BQ₂,
//!   BQ = (s²/w_z² + 2ζ_z s/w_z + 1)/(s²/w_p² + 2ζ_p s/w_p + 1).
//! Sampled by Tustin's rule: C(z) = C(s) at s = (2/T)(z − 1)/(z + 1). Gains here are positive; the sign is in u = K y.
//! Stiffness and damping: K = k_i kp − k_s, c = k_i kp T_d net of lags; textbook choice K = k_s, ζ 0.5–0.7,
//! T_d = 2ζ√(K m_e)/(k_i kp) with m_e the mass that a rigid rotor shows at the actuator.

use crate::controller::polish::structure::LoopLine;
use crate::controller::{ControlLaw, Controller, ControllerError, in_step};
use crate::linalg::lanes::{Lanes, Reals, WIDTH, reals};
use crate::linalg::{Mat, NumericError, c64};
use crate::lti::connect::{append, series};
use crate::lti::sample::tustin;
use crate::lti::{Continuous, StateSpace};
use crate::spindle::{Machine, Side, SpindleError};
use std::f64::consts::{PI, TAU};

/// Damping ratio of the roll-off.
pub(super) const LOWPASS_DAMPING: f64 = 0.7;

/// Second-order section with unit DC gain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Biquad {
    /// Zero frequency w_z, rad/s.
    pub zero_rad_s: f64,
    /// Zero damping ζ_z.
    pub zero_damping: f64,
    /// Pole frequency w_p, rad/s.
    pub pole_rad_s: f64,
    /// Pole damping ζ_p.
    pub pole_damping: f64,
}

impl Biquad {
    /// The section, one signal to one.
    pub(crate) fn system(&self) -> Result<StateSpace<Continuous>, NumericError> {
        let (p, z) = (self.pole_rad_s, self.zero_rad_s);
        let direct = (p / z).powi(2);
        let c = [1.0 - direct, 2.0 * (self.zero_damping * p / z - self.pole_damping * direct)];
        second_order(p, self.pole_damping, c, direct)
    }
}

/// LP₂ with its corner in rad/s.
pub(super) fn roll_off(corner_rad_s: f64) -> Result<StateSpace<Continuous>, NumericError> {
    second_order(corner_rad_s, LOWPASS_DAMPING, [1.0, 0.0], 0.0)
}

/// States in units of the pole frequency: A = w [[0, 1], [−1, −2ζ]].
fn second_order(w: f64, zeta: f64, c: [f64; 2], d: f64) -> Result<StateSpace<Continuous>, NumericError> {
    let m = |r, c, values: &[f64]| Mat::from_fn(r, c, |i, j| values[i * c + j]);
    StateSpace::new(m(2, 2, &[0.0, w, -w, -2.0 * zeta * w]), m(2, 1, &[0.0, w]), m(1, 2, &c), m(1, 1, &[d]), Continuous)
}

/// Parameters of the axes of one bearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisParameters {
    /// kp, A/m, positive for a restoring force.
    pub gain_a_per_m: f64,
    /// wᵢ, rad/s.
    pub integral_rad_s: f64,
    /// T_d, s.
    pub derivative_s: f64,
    /// w_d, rad/s.
    pub derivative_corner_rad_s: f64,
    /// w_lp, rad/s.
    pub lowpass_rad_s: f64,
    /// BQ₁, BQ₂.
    pub biquads: [Biquad; 2],
}

/// A PID for the machine, the same in x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PidParameters {
    /// Front bearing.
    pub front: AxisParameters,
    /// Rear bearing.
    pub rear: AxisParameters,
}

/// Numbers per axis in the vector form.
pub(super) const PER_AXIS: usize = 13;

impl AxisParameters {
    /// C(s), A/m (positive feedback sign not yet applied).
    pub fn response(&self, s: c64) -> c64 {
        let second = |w: f64, zeta: f64| {
            let p = s / w;
            p * p + p * (2.0 * zeta) + 1.0
        };
        // 1 + wᵢ/s + T_d s/(1 + s/w_d) over one denominator.
        let corner = s / self.derivative_corner_rad_s + 1.0;
        let pid = (s + self.integral_rad_s) * corner + s * s * self.derivative_s;
        let below = s * corner * second(self.lowpass_rad_s, LOWPASS_DAMPING);
        let (above, below) = self.biquads.iter().fold((pid, below), |(above, below), b| {
            (above * second(b.zero_rad_s, b.zero_damping), below * second(b.pole_rad_s, b.pole_damping))
        });
        above / below * self.gain_a_per_m
    }

    /// C(jv) at four v, as [`Self::response`], with fewer operations.
    #[inline]
    fn responses_on_axis(&self, v: Reals) -> Lanes {
        let one = Reals::splat(1.0);
        let second = |w: f64, zeta: f64| {
            let p = v * (1.0 / w);
            Lanes::of_parts((-p).mul_add(p, one), p * (2.0 * zeta))
        };
        let by_corner = 1.0 / self.derivative_corner_rad_s;
        let corner = v * by_corner;
        // As there over jv: (wᵢ/(jv) + 1)(1 + jv/w_d) + jv T_d over 1 + jv/w_d.
        let pid = Lanes::of_parts(
            Reals::splat(1.0 + self.integral_rad_s * by_corner),
            corner - Reals::splat(self.integral_rad_s) / v + v * self.derivative_s,
        );
        let below = Lanes::of_parts(one, corner);
        let below = below.product(&second(self.lowpass_rad_s, LOWPASS_DAMPING));
        let (above, below) = self.biquads.iter().fold((pid, below), |(above, below), b| {
            (above.product(&second(b.zero_rad_s, b.zero_damping)), below.product(&second(b.pole_rad_s, b.pole_damping)))
        });
        let scale = Reals::splat(self.gain_a_per_m) / below.squares();
        above.product(&below.conjugate()).times(scale)
    }

    /// Logarithms of the thirteen numbers, for search.
    pub(super) fn to_log(self) -> [f64; PER_AXIS] {
        let [p, q] = self.biquads;
        [
            self.gain_a_per_m,
            self.integral_rad_s,
            self.derivative_s,
            self.derivative_corner_rad_s,
            self.lowpass_rad_s,
            p.zero_rad_s,
            p.zero_damping,
            p.pole_rad_s,
            p.pole_damping,
            q.zero_rad_s,
            q.zero_damping,
            q.pole_rad_s,
            q.pole_damping,
        ]
        .map(f64::ln)
    }

    /// Back from logarithms, within bounds that keep every section realisable at the sample rate: frequencies below
    /// 0.8 of Nyquist, biquad damping 0.02 … 2.
    pub(super) fn from_log(x: &[f64], nyquist_rad_s: f64) -> Option<Self> {
        let [kp, wi, td, wd, wl, z1, a1, p1, b1, z2, a2, p2, b2] = <[f64; PER_AXIS]>::try_from(x).ok()?.map(f64::exp);
        let frequency = |w: f64| w.clamp(TAU * 20.0, 0.8 * nyquist_rad_s);
        let damping = |z: f64| z.clamp(0.02, 2.0);
        let biquad = |zero, zero_damping, pole, pole_damping| Biquad {
            zero_rad_s: frequency(zero),
            zero_damping: damping(zero_damping),
            pole_rad_s: frequency(pole),
            pole_damping: damping(pole_damping),
        };
        Some(Self {
            gain_a_per_m: kp,
            // The integrator acts within seconds and stays out of the rigid-body dynamics.
            integral_rad_s: wi.clamp(TAU * 0.3, TAU * 5.0),
            derivative_s: td,
            derivative_corner_rad_s: frequency(wd),
            lowpass_rad_s: frequency(wl),
            biquads: [biquad(z1, a1, p1, b1), biquad(z2, a2, p2, b2)],
        })
    }

    /// C(s) as a cascade: PI + D, low-pass, two biquads; order 8.
    fn system(&self) -> Result<StateSpace<Continuous>, ControllerError> {
        self.system_with(&self.biquads)
    }

    /// C(s) with some of its biquads.
    pub(super) fn system_with(&self, biquads: &[Biquad]) -> Result<StateSpace<Continuous>, ControllerError> {
        let m = |r, c, values: &[f64]| Mat::from_fn(r, c, |i, j| values[i * c + j]);
        let wd = self.derivative_corner_rad_s;
        // 1 + wᵢ/s + T_d w_d − T_d w_d · w_d/(s + w_d)
        let pid = StateSpace::new(
            m(2, 2, &[0.0, 0.0, 0.0, -wd]),
            m(2, 1, &[self.integral_rad_s, wd]),
            m(1, 2, &[1.0, -self.derivative_s * wd]),
            m(1, 1, &[1.0 + self.derivative_s * wd]),
            Continuous,
        );
        let build = || {
            let mut chain = series(&pid?, &roll_off(self.lowpass_rad_s)?)?;
            for b in biquads {
                chain = series(&chain, &b.system()?)?;
            }
            Ok(chain.scale_outputs(&m(1, 1, &[self.gain_a_per_m])))
        };
        build().map_err(in_step("PID"))
    }
}

impl PidParameters {
    /// Vector of 26 logarithms, front first.
    pub(super) fn to_log(self) -> Vec<f64> {
        self.front.to_log().into_iter().chain(self.rear.to_log()).collect()
    }

    /// Back from logarithms.
    pub(super) fn from_log(x: &[f64], nyquist_rad_s: f64) -> Option<Self> {
        Some(Self {
            front: AxisParameters::from_log(x.get(..PER_AXIS)?, nyquist_rad_s)?,
            rear: AxisParameters::from_log(x.get(PER_AXIS..)?, nyquist_rad_s)?,
        })
    }
}

/// Hands over −C of both axes at each of some lines; what is not a number of parameters that are none.
pub(super) fn each_gain(axes: [Option<&AxisParameters>; 2], lines: &[LoopLine], mut add: impl FnMut([c64; 2])) {
    const NONE: Lanes = Lanes::splat(c64::new(f64::NAN, 0.0));
    for four in lines.chunks(WIDTH) {
        let v = reals(|l| four[l.min(four.len() - 1)].s.im);
        let responses = axes.map(|own| own.map_or(NONE, |a| a.responses_on_axis(v)));
        for l in 0..four.len() {
            add(responses.map(|c| -c.lane(l)));
        }
    }
}

/// The PID as a continuous controller, u = K y, order 32.
///
/// # Errors
/// [`ControllerError::Numeric`] for parameters that are not finite.
pub fn pid_continuous(parameters: &PidParameters, name: &str) -> Result<Controller, ControllerError> {
    let (front, rear) = (parameters.front.system()?, parameters.rear.system()?);
    let four = append(&append(&front, &front), &append(&rear, &rear));
    Ok(Controller {
        name: name.to_owned(),
        law: ControlLaw::Continuous(four.scale_outputs(&Mat::from_fn(4, 4, |i, j| if i == j { -1.0 } else { 0.0 }))),
    })
}

/// The PID as it runs: sampled by Tustin's rule, u = K y, order 32.
///
/// # Errors
/// As [`pid_continuous`], and when a pole maps to infinity.
pub fn pid_controller(
    parameters: &PidParameters,
    sample_time_s: f64,
    name: &str,
) -> Result<Controller, ControllerError> {
    let continuous = pid_continuous(parameters, name)?;
    let ControlLaw::Continuous(law) = continuous.law else {
        return Ok(continuous);
    };
    Ok(Controller {
        name: continuous.name,
        law: ControlLaw::Discrete(tustin(&law, sample_time_s).map_err(in_step("PID"))?),
    })
}

/// Textbook gains from the bearing constants and the rigid rotor: K = k_s, ζ = 0.7, integral at 2 Hz, derivative
/// corner and roll-off as high as the sample rate allows, both biquads flat. Flexible modes are not considered.
///
/// # Errors
/// [`SpindleError`] when the rotor breaks a rule.
pub fn textbook_gains(machine: &Machine) -> Result<PidParameters, SpindleError> {
    let mass = machine.rotor()?.mass_properties();
    let nyquist = PI * machine.spindle.electronics.sample_rate_hz;
    let axis = |side: Side, position_m: f64| {
        let bearing = machine.spindle.bearing(side);
        let lever = position_m - mass.centre_of_gravity_m;
        let effective = 1.0 / (1.0 / mass.mass_kg + lever * lever / mass.diametral_inertia_kg_m2);
        let stiffness = bearing.ks_n_per_m;
        let gain = 2.0 * stiffness / bearing.ki_n_per_a;
        let flat = |w: f64| Biquad { zero_rad_s: w, zero_damping: 0.5, pole_rad_s: w, pole_damping: 0.5 };
        AxisParameters {
            gain_a_per_m: gain,
            integral_rad_s: TAU * 2.0,
            derivative_s: 2.0 * 0.7 * (stiffness * effective).sqrt() / (bearing.ki_n_per_a * gain),
            derivative_corner_rad_s: 0.4 * nyquist,
            lowpass_rad_s: 0.4 * nyquist,
            biquads: [flat(0.14 * nyquist), flat(0.25 * nyquist)],
        }
    };
    let planes = &machine.spindle.planes;
    Ok(PidParameters {
        front: axis(Side::Front, planes.front_actuator_m),
        rear: axis(Side::Rear, planes.rear_actuator_m),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_response_on_the_axis_is_that_of_the_plane() {
        let axis = AxisParameters {
            gain_a_per_m: 3e4,
            integral_rad_s: 9.0,
            derivative_s: 2e-3,
            derivative_corner_rad_s: 2e4,
            lowpass_rad_s: 2.3e4,
            biquads: [[9e3, 0.4, 6e3, 0.2], [1.1e4, 0.03, 2.4e4, 1.4]].map(|b| Biquad {
                zero_rad_s: b[0],
                zero_damping: b[1],
                pole_rad_s: b[2],
                pole_damping: b[3],
            }),
        };
        for v in [1e-3, 0.3, 9.0, 700.0, 8.9e3, 1.1e4, 2e5, 5e7] {
            let found = axis.responses_on_axis(Reals::splat(v)).lane(0);
            let exact = axis.response(c64::new(0.0, v));
            assert!((found - exact).norm() < 1e-13 * exact.norm(), "{v}: {found} for {exact}");
        }
    }
}
