//! What a PID is worth on one machine: tool stiffness, sensitivity, noise current and stability over a set of plants
//! (standstill and largest speed, flexible modes nominal and shifted), from tables of the sampled plant's response.
//!
//! In r = x + jy an isotropic plane has the responses a ± jb forwards and backwards (a: x→x, b: x→y), each with two loops;
//! D = det(I + G C). Stability by the argument principle: the phase that D gathers from the first line to the Nyquist
//! frequency equals that of a loop known to be stable. The lines are packed round every open-loop mode (64 within ±8 %).

use super::ControllerError;
use super::pid::PidParameters;
use crate::linalg::{Mat, c64};
use crate::lti::{Discrete, FrequencyGrid, FrequencyResponder, StateSpace, TimeBase};
use crate::spindle::{Machine, ModelDetail, Plant, SpindleError};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Flexible modes per plane in the tables: the three in the band and guard modes above it.
const FLEXIBLE_MODES: usize = 6;
/// Band of the dynamic stiffness, Hz.
const STIFFNESS_BAND_HZ: (f64, f64) = (1.0, 4000.0);

/// The two loops at one line: g₁₁, g₂₂, g₁₂·g₂₁ and det G = g₁₁g₂₂ − g₁₂g₂₁ (front 1, rear 2).
type Loops = [c64; 4];
/// What performance needs besides: g₁₂, g₂₁, g₁ₜ, g₂ₜ, gₜ₁, gₜ₂, gₜₜ (t: force and displacement at the tool).
type Ports = [c64; 7];

/// One direction of whirl of one plant over the lines; `ports` is empty where only stability counts.
struct Table {
    loops: Vec<Loops>,
    ports: Vec<Ports>,
}

/// One plant: one table at standstill, two (forwards, backwards) at speed.
struct Scenario {
    tables: Vec<Table>,
}

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
    /// Phase of det(I + G C) gathered by each table, rad; plants in a fixed order.
    pub phase_rad: [f64; 6],
}

/// Machine with every flexible frequency multiplied by `factor` (moduli by its square).
pub fn with_shifted_modes(machine: &Machine, factor: f64) -> Machine {
    let mut shifted = machine.clone();
    for section in shifted
        .spindle
        .sections
        .iter_mut()
        .chain(&mut shifted.tool.sections)
    {
        section.modulus_scale *= factor * factor;
    }
    shifted
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
        let cases: Vec<(f64, f64)> = [1.0, 1.0 + mode_shift, 1.0 - mode_shift]
            .into_iter()
            .flat_map(|factor| [(factor, 0.0), (factor, fastest)])
            .collect();
        let plants: Result<Vec<StateSpace<Discrete>>, SpindleError> = cases
            .par_iter()
            .map(|(factor, speed)| {
                let shifted = with_shifted_modes(machine, *factor);
                Plant::new(&shifted, *speed, detail)?.sampled()
            })
            .collect();
        let plants = plants?;
        let modes: Vec<f64> = Plant::new(machine, 0.0, detail)?.flexible_rad_s().to_vec();
        let period = machine.spindle.electronics.sample_period_s();
        let nyquist = PI / period;
        let omega = lines(&modes, nyquist);
        let scenarios = plants
            .par_iter()
            .zip(&cases)
            .map(|(plant, (factor, speed))| scenario(plant, &omega, *speed > 0.0, *factor == 1.0))
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
            phase_rad: [0.0; 6],
        };
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

/// Lines: 4 % steps from 1 Hz to 30 Hz, 1.2 % steps to Nyquist, and f/400 within ±8 % of every mode.
fn lines(modes_rad_s: &[f64], nyquist: f64) -> Vec<f64> {
    let last = nyquist * 0.9999;
    let steps = |from: f64, to: f64, ratio: f64| {
        let count = ((to / from).ln() / ratio).ceil().max(2.0) as usize;
        (0..=count).map(move |k| from * ((to / from).ln() * k as f64 / count as f64).exp())
    };
    let knee = (TAU * 30.0).min(0.5 * last);
    let base = steps(TAU.min(0.5 * knee), knee, 0.04).chain(steps(knee, last, 0.012));
    let packed = modes_rad_s
        .iter()
        .flat_map(|mode| (-32..=32).map(move |k| mode * (1.0 + f64::from(k) / 400.0)))
        .filter(|w| *w < last);
    FrequencyGrid::from_rad_s(base.chain(packed))
        .omega_rad_s()
        .to_vec()
}

/// Tables of a sampled plant over the lines.
fn scenario(
    plant: &StateSpace<Discrete>,
    omega: &[f64],
    rotating: bool,
    nominal: bool,
) -> Scenario {
    // Outputs x then y of front, rear sensor and tool; inputs x of front, rear current and tool force.
    let responder = FrequencyResponder::new(&plant.select(&[0, 2, 4, 1, 3, 5], &[0, 2, 4]));
    let responses: Vec<Mat<c64>> = omega
        .iter()
        .map(|w| responder.transfer(plant.time.point(*w)))
        .collect();
    let j = c64::new(0.0, 1.0);
    let table = |sign: f64| {
        let at = |h: &Mat<c64>, row: usize, column: usize| {
            h[(row, column)] + j * sign * h[(row + 3, column)]
        };
        Table {
            loops: responses
                .iter()
                .map(|h| {
                    let cross = at(h, 0, 1) * at(h, 1, 0);
                    let (g11, g22) = (at(h, 0, 0), at(h, 1, 1));
                    [g11, g22, cross, g11 * g22 - cross]
                })
                .collect(),
            ports: responses
                .iter()
                .filter(|_| nominal)
                .map(|h| {
                    [(0, 1), (1, 0), (0, 2), (1, 2), (2, 0), (2, 1), (2, 2)]
                        .map(|(row, column)| at(h, row, column))
                })
                .collect(),
        }
    };
    Scenario {
        tables: if rotating {
            vec![table(1.0), table(-1.0)]
        } else {
            vec![table(0.0)]
        },
    }
}

/// Currents front_x, rear_x to signals front_x, rear_x, without the states of the other plane.
fn x_plane(plant: &StateSpace<Discrete>) -> StateSpace<Discrete> {
    reachable(&plant.select(&[0, 2], &[0, 2]))
}

/// The system without states that the pattern of A and B never reaches.
fn reachable(system: &StateSpace<Discrete>) -> StateSpace<Discrete> {
    let n = system.order();
    let mut seen: Vec<bool> = (0..n)
        .map(|i| (0..system.inputs()).any(|j| system.b[(i, j)] != 0.0))
        .collect();
    for _ in 0..n {
        for i in 0..n {
            if !seen[i] && (0..n).any(|j| seen[j] && system.a[(i, j)] != 0.0) {
                seen[i] = true;
            }
        }
    }
    let keep: Vec<usize> = (0..n).filter(|i| seen[*i]).collect();
    StateSpace {
        a: Mat::from_fn(keep.len(), keep.len(), |i, j| system.a[(keep[i], keep[j])]),
        b: Mat::from_fn(keep.len(), system.inputs(), |i, j| system.b[(keep[i], j)]),
        c: Mat::from_fn(system.outputs(), keep.len(), |i, j| system.c[(i, keep[j])]),
        d: system.d.clone(),
        time: system.time,
    }
}
