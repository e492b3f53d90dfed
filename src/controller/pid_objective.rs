//! What a PID is worth on one machine: tool stiffness, sensitivity, noise current, high-frequency gain and stability over a
//! set of plants (standstill and largest speed, flexible modes nominal and shifted), from tables of the plant's response.
//!
//! D = det(I + G C). Stability by the argument principle: the phase that D gathers from the first line to the Nyquist
//! frequency equals that of a loop known to be stable. The shifted plants move six modes by ±r each, all at once, in the
//! signs of a 2^(6−3) design: every combination of the three modes in the band, every pair of signs of any other two.

use super::ControllerError;
use super::amplifier_demand::high_frequency_hz;
use super::pid::PidParameters;
use super::pid_tables::{Loops, Ports, Scenario, Table, lines, reachable, scenario, x_plane};
use crate::linalg::{Mat, c64};
use crate::lti::{Discrete, StateSpace, TimeBase};
use crate::spindle::{Machine, ModelDetail, Plant, SpindleError};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Flexible modes per plane in the tables: the three in the band and guard modes above it.
const FLEXIBLE_MODES: usize = 6;
/// Band of the dynamic stiffness, Hz.
const STIFFNESS_BAND_HZ: (f64, f64) = (1.0, 4000.0);
/// Sign patterns of the shifted plants.
const PATTERNS: usize = 8;
/// Plants of the set: nominal and shifted, each at standstill and at the largest speed.
const PLANTS: usize = 2 + 2 * PATTERNS;

/// Tables of a machine, ready to judge parameters.
pub struct Objective {
    omega: Vec<f64>,
    /// s of Tustin's rule at each line.
    s: Vec<c64>,
    scenarios: Vec<Scenario>,
    /// The plane at standstill, for the poles.
    plane: StateSpace<Discrete>,
    nyquist: f64,
    noise_m: f64,
    /// From here on gain counts as high-frequency gain.
    high_rad_s: f64,
}

/// What a PID does on the nominal plants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Performance {
    /// Smallest dynamic stiffness at the tool, standstill and largest speed, N/m.
    pub stiffness_n_per_m: f64,
    /// Largest |S_jj| over loops, standstill and largest speed.
    pub sensitivity: f64,
    /// Largest |S_jj| on the plants with shifted modes.
    pub shifted_sensitivity: f64,
    /// Largest rms current from sensor noise, A.
    pub noise_current_a: f64,
    /// Largest gain |C| above [`high_frequency_hz`], A/m.
    pub high_frequency_gain_a_per_m: f64,
    /// Phase of det(I + G C) gathered on each plant, rad; plants in a fixed order.
    pub phase_rad: [f64; PLANTS],
}

/// Frequency factors of a sign pattern: the signs of modes 1–3 are the bits, those of 4–6 their products.
fn factors(pattern: usize, shift: f64) -> [f64; FLEXIBLE_MODES] {
    let sign = |bit: usize| if (pattern >> bit) & 1 == 0 { 1.0 } else { -1.0 };
    let (a, b, c) = (sign(0), sign(1), sign(2));
    [a, b, c, a * b * c, a * b, a * c].map(|s| 1.0 + s * shift)
}

impl Objective {
    /// Tables for a machine; plants with modes shifted by ± `mode_shift` (relative) besides the nominal ones.
    ///
    /// # Errors
    /// [`SpindleError`] from the plants.
    pub fn new(machine: &Machine, mode_shift: f64) -> Result<Self, SpindleError> {
        let detail = ModelDetail::Modes {
            flexible: FLEXIBLE_MODES,
            static_residual: true,
        };
        let fastest = machine.spindle.max_rpm * TAU / 60.0;
        let (at_rest, at_speed) = (
            Plant::new(machine, 0.0, detail)?,
            Plant::new(machine, fastest, detail)?,
        );
        let cases: Vec<(Option<[f64; FLEXIBLE_MODES]>, &Plant)> = std::iter::once(None)
            .chain((0..PATTERNS).map(|k| Some(factors(k, mode_shift))))
            .flat_map(|shift| [(shift, &at_rest), (shift, &at_speed)])
            .collect();
        let plants: Result<Vec<StateSpace<Discrete>>, SpindleError> = cases
            .par_iter()
            .map(|(shift, plant)| match shift {
                None => plant.sampled(),
                Some(factors) => plant.with_scaled_modes(factors).sampled(),
            })
            .collect();
        let plants = plants?;
        let modes: Vec<f64> = at_rest.flexible_rad_s().to_vec();
        let period = machine.spindle.electronics.sample_period_s();
        let nyquist = PI / period;
        let omega = lines(&modes, nyquist);
        let scenarios = plants
            .par_iter()
            .zip(&cases)
            .map(|(sampled, (shift, plant))| {
                let own = shift.is_none().then_some(*plant);
                scenario(sampled, &omega, plant.speed_rad_s() > 0.0, own)
            })
            .collect();
        let s = omega
            .iter()
            .map(|w| c64::new(0.0, 2.0 / period * (0.5 * w * period).tan()))
            .collect();
        let plane = plants
            .first()
            .map(x_plane)
            .unwrap_or_else(|| StateSpace::gain(Mat::zeros(2, 2), Discrete { period_s: period }));
        Ok(Self {
            omega,
            s,
            scenarios,
            plane,
            nyquist,
            noise_m: machine.spindle.electronics.sensor_noise_m,
            high_rad_s: TAU * high_frequency_hz(machine)?,
        })
    }

    /// Nyquist frequency, rad/s.
    pub fn nyquist_rad_s(&self) -> f64 {
        self.nyquist
    }

    /// Largest growth rate of the plane's sampled loop at standstill, 1/s.
    ///
    /// # Errors
    /// [`ControllerError`] when the loop is not well posed or the eigenvalue iteration fails.
    pub fn growth_rate(&self, parameters: &PidParameters) -> Result<f64, ControllerError> {
        let period = self.plane.time.period_s;
        let controller = super::pid::pid_controller(parameters, period, "")?;
        let super::ControlLaw::Discrete(law) = controller.law else {
            return Ok(f64::INFINITY);
        };
        let numeric = super::in_step("PID loop at standstill");
        let two = law.select(&[0, 2], &[0, 2]);
        let reached = reachable(&two);
        crate::lti::connect::lower_lft(&self.plane, &reached)
            .and_then(|closed| closed.poles())
            .map(|poles| {
                poles
                    .into_iter()
                    .map(|z| self.plane.time.growth_rate(z))
                    .fold(f64::NEG_INFINITY, f64::max)
            })
            .map_err(numeric)
    }

    /// Figures of a PID over all tables; meaningful where the loops are stable.
    pub fn performance(&self, parameters: &PidParameters) -> Performance {
        let gains: Vec<[c64; 2]> = self
            .s
            .iter()
            .map(|s| [parameters.front.response(*s), parameters.rear.response(*s)])
            .collect();
        let mut result = Performance {
            stiffness_n_per_m: f64::INFINITY,
            sensitivity: 0.0,
            shifted_sensitivity: 0.0,
            noise_current_a: 0.0,
            high_frequency_gain_a_per_m: 0.0,
            phase_rad: [0.0; PLANTS],
        };
        for (omega, [front, rear]) in self.omega.iter().zip(&gains) {
            if *omega >= self.high_rad_s {
                let gain = front.norm().max(rear.norm());
                result.high_frequency_gain_a_per_m = result.high_frequency_gain_a_per_m.max(gain);
            }
        }
        for (scenario, phase) in self.scenarios.iter().zip(&mut result.phase_rad) {
            let share = 1.0 / scenario.tables.len() as f64;
            *phase = scenario
                .tables
                .iter()
                .map(|table| share * gathered_phase(table, &gains))
                .sum();
        }
        let (nominal, shifted): (Vec<_>, Vec<_>) = self
            .scenarios
            .iter()
            .partition(|s| s.tables.iter().all(|t| !t.ports.is_empty()));
        for table in shifted.iter().flat_map(|s| &s.tables) {
            let peak = sensitivity_peak(table, &gains);
            result.shifted_sensitivity = result.shifted_sensitivity.max(peak);
        }
        for scenario in nominal {
            self.judge_nominal(scenario, &gains, &mut result);
        }
        result
    }

    /// Stiffness, sensitivity and noise of a nominal plant; directions of whirl averaged to the x axis.
    fn judge_nominal(&self, scenario: &Scenario, gains: &[[c64; 2]], result: &mut Performance) {
        let share = 1.0 / scenario.tables.len() as f64;
        let mut noise = [0.0f64; 2];
        for (k, c) in gains.iter().enumerate() {
            let mut sum = LoopLine::default();
            for table in &scenario.tables {
                let at = close(&table.loops[k], &table.ports[k], c);
                sum.s[0] += at.s[0] * share;
                sum.s[1] += at.s[1] * share;
                sum.compliance += at.compliance * share;
                sum.noise[0] += at.noise[0] * share;
                sum.noise[1] += at.noise[1] * share;
            }
            result.sensitivity = result.sensitivity.max(sum.s[0].norm()).max(sum.s[1].norm());
            let hz = self.omega[k] / TAU;
            if hz >= STIFFNESS_BAND_HZ.0 && hz <= STIFFNESS_BAND_HZ.1 {
                let stiffness = 1.0 / sum.compliance.norm();
                result.stiffness_n_per_m = result.stiffness_n_per_m.min(stiffness);
            }
            // Trapezoid over the lines; white noise of variance σ² has density σ²/ω_N up to Nyquist.
            let low = if k == 0 { 0.0 } else { self.omega[k - 1] };
            let high = self.omega.get(k + 1).copied().unwrap_or(self.nyquist);
            for (total, rate) in noise.iter_mut().zip(sum.noise) {
                *total += rate * 0.5 * (high - low) / self.nyquist;
            }
        }
        let rms = noise[0].max(noise[1]).sqrt() * self.noise_m;
        result.noise_current_a = result.noise_current_a.max(rms);
    }
}

/// Loop quantities at a line.
#[derive(Default)]
struct LoopLine {
    s: [c64; 2],
    compliance: c64,
    /// Σ|K S|² of each current over the two sensors.
    noise: [f64; 2],
}

/// det(I + G C).
fn determinant(g: &Loops, c: &[c64; 2]) -> c64 {
    g[3] * (c[0] * c[1]) + g[0] * c[0] + g[1] * c[1] + 1.0
}

/// Phase that det(I + G C) gathers over the lines: crossings of the negative real axis, and the two ends.
fn gathered_phase(table: &Table, gains: &[[c64; 2]]) -> f64 {
    let mut values = table
        .loops
        .iter()
        .zip(gains)
        .map(|(g, c)| determinant(g, c));
    let Some(first) = values.next() else {
        return 0.0;
    };
    let (mut last, mut turns) = (first, 0.0);
    for value in values {
        if (value.im < 0.0) != (last.im < 0.0) {
            // Where the chord crosses the real axis.
            let crossing = last.re + (value.re - last.re) * last.im / (last.im - value.im);
            if crossing < 0.0 {
                turns += if value.im < 0.0 { 1.0 } else { -1.0 };
            }
        }
        last = value;
    }
    last.arg() - first.arg() + TAU * turns
}

/// Largest |S_jj| of the two loops in one direction of whirl.
fn sensitivity_peak(table: &Table, gains: &[[c64; 2]]) -> f64 {
    let squared = table.loops.iter().zip(gains).map(|(g, c)| {
        let numerator = (g[0] * c[0] + 1.0)
            .norm_sqr()
            .max((g[1] * c[1] + 1.0).norm_sqr());
        numerator / determinant(g, c).norm_sqr()
    });
    squared.fold(0.0, f64::max).sqrt()
}

/// Closes the two loops u = −C y at one line.
fn close(g: &Loops, ports: &Ports, c: &[c64; 2]) -> LoopLine {
    let one = c64::new(1.0, 0.0);
    let [g12, g21, g1t, g2t, gt1, gt2, gtt] = *ports;
    let inverse = determinant(g, c).inv();
    let (s11, s22) = ((one + g[1] * c[1]) * inverse, (one + g[0] * c[0]) * inverse);
    let (s12, s21) = (-g12 * c[1] * inverse, -g21 * c[0] * inverse);
    let y = [s11 * g1t + s12 * g2t, s21 * g1t + s22 * g2t];
    LoopLine {
        s: [s11, s22],
        compliance: gtt - gt1 * c[0] * y[0] - gt2 * c[1] * y[1],
        noise: [
            c[0].norm_sqr() * (s11.norm_sqr() + s12.norm_sqr()),
            c[1].norm_sqr() * (s21.norm_sqr() + s22.norm_sqr()),
        ],
    }
}
