//! Responses of a machine on the lines of a polish: the loop of one plane in r = x + jy, for every rotor that it has to
//! serve.
//!
//! An isotropic plane has the responses a + jb forwards and a − jb backwards (a: x→x, b: x→y). What the controller sees
//! is the sampled plant, G_d(e^{jωT}) = Σ_k G(ω + kω_s) with the hold in G; between tool and loop the fundamental
//! counts. What couples x and y otherwise (cross terms of the magnets, turned sensor axes) is left out here and comes
//! back in verification.

use super::limits::WEAKEST_BELOW;
use super::matrix2::{Matrix2, ZERO};
use super::structure::LoopLine;
use crate::augment::assembly::{ProblemWeights, UncertainMode};
use crate::augment::exposure::Exposure;
use crate::augment::plane::{LOADS, LOOPS, isotropic};
use crate::augment::weights::Weights;
use crate::linalg::c64;
use crate::linalg::lanes::Lanes;
use crate::lti::held::hold_magnitude;
use crate::lti::{Continuous, FrequencyResponder, Response};
use crate::spindle::plant::CHANNELS;
use crate::spindle::response::SIDE;
use crate::spindle::{Machine, ModelDetail, Plant, PlantLoop, SpindleError};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Bands above and below Nyquist that fold back: the hold and the low-passes of amplifier and sensor leave less than
/// 1e-3 of the response beyond.
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
pub(crate) enum RotorRole {
    /// The machine as modelled, at rest.
    Rest,
    /// The machine as modelled, at its top speed.
    TopSpeed,
    /// A rotor with shifted modes at some speed.
    Shifted,
    /// The machine as modelled at a speed below its top speed: counts as one with shifted modes, and has to meet the
    /// specification.
    Between,
    /// Beyond the top speed: has to be stable and to meet the specification.
    Overspeed,
    /// The machine at rest with magnets that give a part of their force: what a limited current does to the loop.
    Weak,
    /// The same with less than half of it.
    Weakest,
}

impl RotorRole {
    /// The machine as modelled, at rest or at its top speed.
    pub(crate) fn is_nominal(self) -> bool {
        matches!(self, Self::Rest | Self::TopSpeed)
    }

    /// The machine as modelled, at a speed at which it has to meet the specification.
    fn has_specification(self) -> bool {
        matches!(self, Self::Rest | Self::TopSpeed | Self::Overspeed | Self::Between)
    }
}

/// A rotor that the controller serves: one direction at rest, two at speed (forwards, backwards).
#[derive(Clone, Debug)]
pub(crate) struct ServedRotor {
    pub role: RotorRole,
    /// Unstable poles of the plant in r = x + jy: turns of det(I − G K) of a stable loop, beside those of K.
    pub unstable_poles: i64,
    /// Directions × lines.
    pub directions: Vec<Vec<LoopResponse>>,
}

/// The weighted specification at one line: M = E₁₁ + E₁₂ R E₂₁ with R = K (I − G K)⁻¹.
#[derive(Clone, Debug)]
pub(crate) struct SpecificationLine {
    /// Errors.
    pub rows: usize,
    /// E₁₁: errors × disturbances, column after column.
    pub direct: Vec<Lanes>,
    /// E₁₂: the errors of each current.
    pub drive: [Vec<Lanes>; LOOPS],
    /// E₂₁: the signals of each disturbance.
    pub read: Vec<[c64; LOOPS]>,
}

/// Responses that were computed before, on lines of ascending frequency.
#[derive(Clone, Copy)]
pub(crate) struct Known<'a, T> {
    pub lines: &'a [LoopLine],
    pub list: &'a [T],
}

impl<T> Known<'_, T> {
    /// None.
    pub(crate) const NOTHING: Self = Self { lines: &[], list: &[] };

    /// For each of the lines its number among the known ones, if its frequency is the same to the last bit.
    fn same(&self, lines: &[LoopLine]) -> Vec<Option<usize>> {
        let number = |line: &LoopLine| {
            let order = |k: &LoopLine| k.omega_rad_s.total_cmp(&line.omega_rad_s);
            self.lines.binary_search_by(order).ok()
        };
        lines.iter().map(number).collect()
    }
}

/// The machine at a speed with shifted modes.
#[derive(Clone, Debug)]
pub(crate) struct ShiftedRotor {
    pub speed_rad_s: f64,
    /// Factors on the natural frequencies of the first flexible modes.
    pub factors: Vec<f64>,
}

/// A plant with its role.
#[derive(Clone)]
struct RotorPlant {
    role: RotorRole,
    plant: Plant,
    /// As [`ServedRotor::unstable_poles`].
    unstable_poles: i64,
}

impl RotorPlant {
    fn new(role: RotorRole, plant: Plant) -> Result<Self, SpindleError> {
        let poles = plant.sample_plant()?.poles()?;
        // Both planes have them.
        let unstable_poles = poles.iter().filter(|z| z.norm() > 1.0).count() as i64 / 2;
        Ok(Self { role, plant, unstable_poles })
    }

    /// With modes shifted by the factors of each of the `shifts`, which leave them stable.
    fn shift_modes(&self, shifts: &[Vec<f64>]) -> Vec<Self> {
        let shifted = |factors: &Vec<f64>| Self {
            role: RotorRole::Shifted,
            plant: self.plant.with_scaled_modes(factors),
            unstable_poles: self.unstable_poles,
        };
        shifts.iter().map(shifted).collect()
    }
}

/// The plants of a polish before lines are chosen.
pub(crate) struct Plants {
    period_s: f64,
    list: Vec<RotorPlant>,
    /// Parts of their force that the magnets of further rotors give.
    weak: Vec<[f64; 2]>,
}

impl Plants {
    /// The machine at rest, at its top speed, `over` times as fast, and at rest with modes shifted in the signs of
    /// `shifts`.
    pub(crate) fn new(machine: &Machine, over: f64, shifts: &[Vec<f64>]) -> Result<Self, SpindleError> {
        let machine = isotropic(machine);
        let top = machine.spindle.max_rpm * TAU / 60.0;
        let roles = [(RotorRole::Rest, 0.0), (RotorRole::TopSpeed, top), (RotorRole::Overspeed, over * top)];
        let at_speeds: Result<Vec<RotorPlant>, SpindleError> = roles
            .into_par_iter()
            .map(|(role, speed)| RotorPlant::new(role, Plant::new(&machine, speed, ModelDetail::Full)?))
            .collect();
        let mut list = at_speeds?;
        list.extend(list[0].shift_modes(shifts));
        Ok(Self { period_s: machine.spindle.electronics.sample_period_s(), list, weak: vec![] })
    }

    /// With the machine at its top speed once more for each of the `shifts`.
    #[must_use]
    pub(crate) fn with_shifts_at_top_speed(mut self, shifts: &[Vec<f64>]) -> Self {
        self.list.extend(self.list[1].shift_modes(shifts));
        self
    }

    /// With the machine at rest once more for each part of their force that its magnets give.
    #[must_use]
    pub(crate) fn with_weak_magnets(self, parts: &[[f64; 2]]) -> Self {
        Self { weak: parts.to_vec(), ..self }
    }

    /// With the machine at rest and at its top speed once more for each of the `shifts`: stable with the least margin,
    /// that of the weakest magnets.
    #[must_use]
    pub(crate) fn with_bare_stability(mut self, shifts: &[Vec<f64>]) -> Self {
        for own in [0, 1] {
            let shifted = self.list[own].shift_modes(shifts);
            self.list.extend(shifted.into_iter().map(|rotor| RotorPlant { role: RotorRole::Weakest, ..rotor }));
        }
        self
    }

    /// With the machine at speeds between rest and its top speed, rad/s, before all rotors without a specification.
    pub(crate) fn with_speeds_between(mut self, machine: &Machine, speeds: &[f64]) -> Result<Self, SpindleError> {
        let machine = isotropic(machine);
        let own = |speed: &f64| RotorPlant::new(RotorRole::Between, Plant::new(&machine, *speed, ModelDetail::Full)?);
        let between: Vec<RotorPlant> = speeds.par_iter().map(own).collect::<Result<_, _>>()?;
        let specified = self.list.iter().take_while(|rotor| rotor.role.has_specification()).count();
        self.list.splice(specified..specified, between);
        Ok(self)
    }

    pub(crate) fn with_further(mut self, machine: &Machine, rotors: &[ShiftedRotor]) -> Result<Self, SpindleError> {
        let machine = isotropic(machine);
        for rotor in rotors {
            let plant = Plant::new(&machine, rotor.speed_rad_s, ModelDetail::Full)?;
            let plant = plant.with_scaled_modes(&rotor.factors);
            self.list.push(RotorPlant::new(RotorRole::Shifted, plant)?);
        }
        Ok(self)
    }

    pub(crate) fn at_rest(&self) -> &Plant {
        &self.list[0].plant
    }

    /// All of them with their roles, in the order of the rotors of [`Self::on`].
    pub(crate) fn all(&self) -> impl Iterator<Item = (RotorRole, &Plant)> {
        self.list.iter().map(|own| (own.role, &own.plant))
    }

    pub(crate) fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Every rotor on the lines; `known` are its responses on other lines, from which the same lines are taken.
    pub(crate) fn on(&self, lines: &[LoopLine], known: &Known<'_, &ServedRotor>) -> Vec<ServedRotor> {
        let same = known.same(lines);
        let mut rotors: Vec<ServedRotor> = self
            .list
            .iter()
            .enumerate()
            .map(|(number, RotorPlant { role, plant, unstable_poles })| {
                let sides = if plant.mechanics().planes_are_decoupled() { 1 } else { 2 };
                let plant = PlantLoop::new(plant);
                let both: Vec<[LoopResponse; 2]> = lines
                    .par_iter()
                    .zip(&same)
                    .map(|(line, same)| match same {
                        Some(k) => {
                            let of = &known.list[number].directions;
                            [of[0][*k], of[sides - 1][*k]]
                        }
                        None => whirl(&plant, line.omega_rad_s, self.period_s),
                    })
                    .collect();
                ServedRotor {
                    role: *role,
                    unstable_poles: *unstable_poles,
                    directions: (0..sides).map(|k| both.iter().map(|b| b[k]).collect()).collect(),
                }
            })
            .collect();
        let rest = rotors.first().cloned();
        let weak = self.weak.iter().zip(rest.iter().cycle());
        rotors.extend(weak.map(|(part, rest)| {
            let weaker = |g: &LoopResponse| LoopResponse {
                loops: g.loops.map(|row| [row[0] * part[0], row[1] * part[1]]),
                drive: [g.drive[0] * part[0], g.drive[1] * part[1]],
                ..*g
            };
            ServedRotor {
                role: if part[0].min(part[1]) < WEAKEST_BELOW { RotorRole::Weakest } else { RotorRole::Weak },
                unstable_poles: rest.unstable_poles,
                directions: rest.directions.iter().map(|lines| lines.iter().map(weaker).collect()).collect(),
            }
        }));
        rotors
    }

    /// The specification's rows of the machine at rest, at its top speed and beyond, in the order of the first loops of
    /// [`Self::on`], on the lines, with weights at true frequency; `known` as there.
    pub(crate) fn specification(
        &self,
        lines: &[LoopLine],
        (modes, weights): (&[UncertainMode], &Weights),
        known: &Known<'_, &[SpecificationLine]>,
    ) -> Result<Vec<Vec<SpecificationLine>>, crate::linalg::NumericError> {
        let same = known.same(lines);
        let round = ProblemWeights::of_specification(modes, weights)?;
        let frame = SpecificationFrame {
            exposure: Exposure::new(modes.len(), &round.channels, weights.integral_corner_hz.is_some()),
            input: FrequencyResponder::new(&round.input),
            output: FrequencyResponder::new(&round.output),
            ports: modes.iter().map(|m| CHANNELS + 2 * m.number).chain((0..LOADS).map(|k| 4 + 2 * k)).collect(),
        };
        let ports = modes.iter().map(|m| m.number + 1).max().unwrap_or(0);
        let mut loops = vec![];
        for RotorPlant { role, plant, .. } in &self.list {
            if !role.has_specification() {
                continue;
            }
            let opened = plant.with_modal_ports(ports);
            let signs: &[f64] = if plant.mechanics().planes_are_decoupled() { &[1.0] } else { &[1.0, -1.0] };
            let first = loops.len();
            let rows: Vec<Vec<SpecificationLine>> = lines
                .par_iter()
                .zip(&same)
                .map(|(line, same)| match same {
                    Some(k) => {
                        let of = &known.list[first..first + signs.len()];
                        of.iter().map(|rows| rows[*k].clone()).collect()
                    }
                    None => frame.rows(&opened, line.omega_rad_s, signs),
                })
                .collect();
            for side in 0..signs.len() {
                loops.push(rows.iter().map(|r| r[side].clone()).collect());
            }
        }
        Ok(loops)
    }
}

/// Signs of shifted modes: all combinations of the first three, the others by products of those.
pub(crate) fn shifts(relative: &[f64]) -> Vec<Vec<f64>> {
    (0..8usize)
        .map(|pattern| {
            let sign = |bit: usize| if (pattern >> bit) & 1 == 0 { 1.0 } else { -1.0 };
            let (a, b, c) = (sign(0), sign(1), sign(2));
            let signs = [a, b, c, a * b * c, a * b, a * c];
            relative.iter().zip(signs).map(|(r, s)| 1.0 + s * r).collect()
        })
        .collect()
}

/// Forward and backward responses of a plant at a line.
fn whirl(plant: &PlantLoop, omega: f64, period_s: f64) -> [LoopResponse; 2] {
    let empty = LoopResponse { loops: [[ZERO; 2]; 2], read: [ZERO; 2], drive: [ZERO; 2], tool: ZERO };
    let mut both = [empty; 2];
    for k in -FOLDED..=FOLDED {
        let w = omega + f64::from(k) * TAU / period_s;
        let h = if k == 0 { plant.at(w) } else { plant.axes_at(w) };
        let gain = hold_magnitude(w, period_s);
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            let at =
                |row: usize, column: usize| h[row * SIDE + column] + c64::new(0.0, sign) * h[(row + 1) * SIDE + column];
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

/// Weights and ports of the specification.
struct SpecificationFrame {
    exposure: Exposure,
    input: FrequencyResponder<Continuous>,
    output: FrequencyResponder<Continuous>,
    /// Channels of the plant, x axis: modal ports and loads.
    ports: Vec<usize>,
}

impl SpecificationFrame {
    /// Weighted rows (q, x, u, [y]) and columns (v, loads, noise) at a frequency: x→x, and ±j of x→y, for each sign.
    fn rows(&self, plant: &Plant, omega: f64, signs: &[f64]) -> Vec<SpecificationLine> {
        let h = plant.at(omega);
        let (wi, wo) = (self.input.at(omega), self.output.at(omega));
        let gain = hold_magnitude(omega, plant.sample_period_s());
        let ports = &self.ports;
        let n = ports.len();
        let exposure = &self.exposure;
        let (rows, columns) = (exposure.error_rows(), exposure.disturbance_columns());
        let of_sign = |sign: &f64| {
            let at = |row: usize, column: usize| h[(row, column)] + c64::new(0.0, *sign) * h[(row + 1, column)];
            // Ports, then signals and currents; currents are held.
            let row = |i: usize| if i < n { ports[i] } else { 2 * (i - n) };
            let exposed = exposure.matrix(|i, j| match j {
                j if j < n => at(row(i), ports[j]),
                j => gain * at(row(i), 2 * (j - n)),
            });
            SpecificationLine {
                rows,
                direct: Lanes::columns(rows, columns, |i, j| wo[(i, i)] * exposed[(i, j)] * wi[(j, j)]),
                drive: [0, 1].map(|k| Lanes::columns(rows, 1, |i, _| wo[(i, i)] * exposed[(i, columns + k)])),
                read: (0..columns).map(|j| [0, 1].map(|k| exposed[(rows + k, j)] * wi[(j, j)])).collect(),
            }
        };
        signs.iter().map(of_sign).collect()
    }
}
