//! Responses of a machine on the lines of a polish: the loop of one plane in r = x + jy, for every rotor that it has to serve.
//!
//! An isotropic plane has the responses a + jb forwards and a − jb backwards (a: x→x, b: x→y). What the controller sees is the
//! sampled plant, G_d(e^{jωT}) = Σ_k G(ω + kω_s) with the hold in G; between tool and loop the fundamental counts. What
//! couples x and y otherwise (cross terms of the magnets, turned sensor axes) is left out here and comes back in verification.

use super::matrix2::{Matrix2, ZERO};
use super::structure::Line;
use crate::augment::assembly::{UncertainMode, input_weights, output_weights};
use crate::augment::plane::{LOADS, LOOPS, isotropic};
use crate::augment::weight_plane::WeightPlane;
use crate::augment::weights::Weights;
use crate::linalg::{Mat, c64};
use crate::lti::Response;
use crate::spindle::plant::CHANNELS;
use crate::spindle::{Machine, ModelDetail, Plant, SpindleError};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Bands above and below Nyquist that fold back: the hold and the low-passes of amplifier and sensor leave less than 1e-3 of
/// the response beyond.
const FOLDED: i32 = 2;

/// One direction of whirl at one line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoopResponse {
    /// Currents to signals, sampled, m/A.
    pub loops: Matrix2,
    /// Force at the tool to signals, m/N.
    pub read: [c64; 2],
    /// Currents to the displacement of the tool, m/A.
    pub drive: [c64; 2],
    /// Force to displacement at the tool, m/N.
    pub tool: c64,
}

/// What a rotor stands for in the loss.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Role {
    /// The machine as modelled, at rest.
    Rest,
    /// The machine as modelled, at its top speed.
    TopSpeed,
    /// A rotor at rest with shifted modes.
    Shifted,
    /// Beyond the top speed: has to be stable.
    Overspeed,
}

/// A rotor that the controller serves: one direction at rest, two at speed (forwards, backwards).
#[derive(Clone, Debug)]
pub(crate) struct Rotor {
    pub role: Role,
    /// Directions × lines.
    pub directions: Vec<Vec<LoopResponse>>,
}

/// Rows of the weighted specification at one line: M = E₁₁ + E₁₂ R E₂₁ with R = K (I − G K)⁻¹.
#[derive(Clone, Debug)]
pub(crate) struct SpecificationLine {
    pub direct: Mat<c64>,
    /// Errors × currents.
    pub drive: Mat<c64>,
    /// Signals × disturbances.
    pub read: Mat<c64>,
}

/// The plants of a polish before lines are chosen.
pub(crate) struct Plants {
    period_s: f64,
    list: Vec<(Role, Plant)>,
}

impl Plants {
    /// The machine at rest, at its top speed, `over` times as fast, and at rest with modes shifted in the signs of `shifts`.
    ///
    /// # Errors
    /// [`SpindleError`] from the plants.
    pub fn new(machine: &Machine, over: f64, shifts: &[Vec<f64>]) -> Result<Self, SpindleError> {
        let machine = isotropic(machine);
        let top = machine.spindle.max_rpm * TAU / 60.0;
        let at_speeds: Result<Vec<Plant>, SpindleError> = [0.0, top, over * top]
            .into_par_iter()
            .map(|speed| Plant::new(&machine, speed, ModelDetail::Full))
            .collect();
        let at_speeds = at_speeds?;
        let mut list: Vec<(Role, Plant)> = [Role::Rest, Role::TopSpeed, Role::Overspeed]
            .into_iter()
            .zip(at_speeds)
            .collect();
        let rest = list[0].1.clone();
        list.extend(
            shifts
                .iter()
                .map(|factors| (Role::Shifted, rest.with_scaled_modes(factors))),
        );
        Ok(Self {
            period_s: machine.spindle.electronics.sample_period_s(),
            list,
        })
    }

    /// The machine at rest.
    pub fn at_rest(&self) -> &Plant {
        &self.list[0].1
    }

    /// Plants of a role.
    pub fn of(&self, role: Role) -> impl Iterator<Item = &Plant> {
        self.list
            .iter()
            .filter(move |(r, _)| *r == role)
            .map(|(_, p)| p)
    }

    /// Sample period, s.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Every rotor on the lines, rad/s.
    pub fn on(&self, lines: &[Line]) -> Vec<Rotor> {
        self.list
            .iter()
            .map(|(role, plant)| {
                let both: Vec<[LoopResponse; 2]> = lines
                    .par_iter()
                    .map(|line| whirl(plant, line.omega_rad_s, self.period_s))
                    .collect();
                let sides = if plant.mechanics().planes_are_decoupled() {
                    1
                } else {
                    2
                };
                Rotor {
                    role: *role,
                    directions: (0..sides)
                        .map(|k| both.iter().map(|b| b[k]).collect())
                        .collect(),
                }
            })
            .collect()
    }

    /// The specification's rows at the lines, with the machine at rest and weights at true frequency.
    ///
    /// # Errors
    /// [`crate::linalg::NumericError`] for weights that are not positive.
    pub fn specification(
        &self,
        lines: &[Line],
        modes: &[UncertainMode],
        weights: &Weights,
    ) -> Result<Vec<SpecificationLine>, crate::linalg::NumericError> {
        let weights = Weights {
            complementary_sensitivity_limit: None,
            ..weights.clone()
        };
        let (input, output) = (
            input_weights(modes, &weights, WeightPlane::Laplace)?,
            output_weights(modes, &weights, WeightPlane::Laplace)?,
        );
        let ports = modes.iter().map(|m| m.number + 1).max().unwrap_or(0);
        let plant = self.at_rest().with_modal_ports(ports);
        let regulated = weights.integral_corner_hz.is_some();
        let rows = lines.par_iter().map(|line| {
            let (wi, wo) = (input.at(line.omega_rad_s), output.at(line.omega_rad_s));
            specification_line(&plant, modes, line.omega_rad_s, regulated, (&wi, &wo))
        });
        Ok(rows.collect())
    }
}

/// Signs of shifted modes: all combinations of the first three, the others by products of those.
pub(crate) fn shifts(relative: &[f64]) -> Vec<Vec<f64>> {
    (0..8usize)
        .map(|pattern| {
            let sign = |bit: usize| if (pattern >> bit) & 1 == 0 { 1.0 } else { -1.0 };
            let (a, b, c) = (sign(0), sign(1), sign(2));
            let signs = [a, b, c, a * b * c, a * b, a * c];
            relative
                .iter()
                .zip(signs)
                .map(|(r, s)| 1.0 + s * r)
                .collect()
        })
        .collect()
}

/// Magnitude of the hold at a signed frequency; its half sample belongs to the delay of the plant.
fn hold(omega_rad_s: f64, period_s: f64) -> f64 {
    let half = 0.5 * omega_rad_s * period_s;
    if half.abs() < 1e-8 {
        1.0
    } else {
        half.sin() / half
    }
}

/// Forward and backward responses of a plant at a line.
fn whirl(plant: &Plant, omega: f64, period_s: f64) -> [LoopResponse; 2] {
    let empty = LoopResponse {
        loops: [[ZERO; 2]; 2],
        read: [ZERO; 2],
        drive: [ZERO; 2],
        tool: ZERO,
    };
    let mut both = [empty; 2];
    for k in -FOLDED..=FOLDED {
        let w = omega + f64::from(k) * TAU / period_s;
        let h = plant.at(w);
        let gain = hold(w, period_s);
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            let at = |row: usize, column: usize| {
                h[(row, column)] + c64::new(0.0, sign) * h[(row + 1, column)]
            };
            let response = &mut both[side];
            for i in 0..LOOPS {
                for j in 0..LOOPS {
                    response.loops[i][j] += gain * at(2 * i, 2 * j);
                }
            }
            if k == 0 {
                response.read = [at(0, 4), at(2, 4)];
                response.drive = [gain * at(4, 0), gain * at(4, 2)];
                response.tool = at(4, 4);
            }
        }
    }
    both
}

/// Weighted rows (q, x, u, [y]) and columns (v, loads, noise) of the specification.
fn specification_line(
    plant: &Plant,
    modes: &[UncertainMode],
    omega: f64,
    regulated: bool,
    (wi, wo): (&Mat<c64>, &Mat<c64>),
) -> SpecificationLine {
    let h = plant.at(omega);
    let gain = hold(omega, plant.sample_period_s());
    let nv = modes.len();
    let ports: Vec<usize> = modes
        .iter()
        .map(|m| CHANNELS + 2 * m.number)
        .chain((0..LOADS).map(|k| 4 + 2 * k))
        .collect();
    let n = nv + LOADS;
    let extra = if regulated { LOOPS } else { 0 };
    let (rows, columns) = (n + LOOPS + extra, n + LOOPS);
    let unit = |here: bool| if here { c64::new(1.0, 0.0) } else { ZERO };
    // Signals y + n from the disturbances with the loop open.
    let signal = |k: usize, j: usize| match j < n {
        true => h[(2 * k, ports[j])],
        false => unit(j == n + k),
    };
    SpecificationLine {
        direct: Mat::from_fn(rows, columns, |i, j| {
            let open = match (i < n, j < n) {
                (true, true) => h[(ports[i], ports[j])],
                _ if i >= n + LOOPS => signal(i - n - LOOPS, j),
                _ => ZERO,
            };
            wo[(i, i)] * open * wi[(j, j)]
        }),
        drive: Mat::from_fn(rows, LOOPS, |i, k| {
            let open = match i {
                i if i < n => gain * h[(ports[i], 2 * k)],
                i if i < n + LOOPS => unit(i == n + k),
                i => gain * h[(2 * (i - n - LOOPS), 2 * k)],
            };
            wo[(i, i)] * open
        }),
        read: Mat::from_fn(LOOPS, columns, |k, j| signal(k, j) * wi[(j, j)]),
    }
}

/// Lines of a polish: `from_hz` to Nyquist, packed round the plant's modes and the poles of the loop, those closer than a share
/// of their frequency once.
pub(crate) fn lines(plants: &Plants, from_hz: f64, poles_rad_s: &[c64], apart: f64) -> Vec<Line> {
    let period_s = plants.period_s();
    let last = 0.9995 * PI / period_s;
    let steps = |from: f64, to: f64, ratio: f64| {
        let count = ((to / from).ln() / ratio).ceil().max(2.0) as usize;
        (0..=count).map(move |k| from * (to / from).powf(k as f64 / count as f64))
    };
    let knee = (TAU * 20.0).min(0.25 * last);
    let mut omega: Vec<f64> = steps((TAU * from_hz).min(0.5 * knee), knee, 0.12)
        .chain(steps(knee, last, 0.025))
        .collect();
    let flexible = plants.at_rest().flexible_rad_s();
    for mode in flexible {
        omega.extend((-4..=4).map(|k| mode * (1.0 + 0.01 * f64::from(k))));
    }
    for pole in poles_rad_s {
        let (centre, width) = (pole.im.abs(), pole.re.abs());
        // Wider peaks are seen by the plain steps.
        if width < 0.1 * centre {
            omega.extend([-1.6, -0.6, 0.0, 0.6, 1.6].map(|k| centre + width * k));
        }
    }
    omega.retain(|w| *w > 0.0 && *w <= last);
    omega.sort_by(f64::total_cmp);
    omega.dedup_by(|b, a| *b < *a * (1.0 + apart));
    omega.into_iter().map(|w| Line::new(w, period_s)).collect()
}
