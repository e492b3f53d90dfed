//! Objective and limits of a polish over all rotors and lines, with exact derivatives.
//!
//! With G the loop, K the controller, S = (I − G K)⁻¹, S_u = (I − K G)⁻¹: H = G_td + G_tu K S G_yd is the tool's
//! compliance,
//!   δH = G_tu S_u δK S G_yd,   δS = S G δK S,   δ(K S) = S_u δK S.
//! A value enters by its logarithm relative to its limit, so each derivative is Re tr(Q δK) with a 2×2 matrix Q per
//! line, and the structure of the controller turns Q into derivatives by parameters. At speed the x axis is the mean of
//! both whirls.

use super::limits::{AT_TOP_SPEED, LoopLimits, SHIFTED, WEAKEST};
use super::line_scales::LineScales;
use super::line_state::{ClosedLines, LinePart, turns_of};
use super::lines::beside_peaks;
use super::loop_state::LoopState;
use super::matrix2::{Matrix2, ONE, adjoint, hermitian_eigen, outer, squared, times};
use super::packed_loops::PackedLoops;
use super::responses::{LoopResponse, Role, Rotor, SpecificationLine};
use super::specification_bound::{Bound, best_scales, bound};
use super::structure::{Fixed, Line, Structure};
use super::values::{Gathered, Group, LIMIT_GROUPS, LIMITS, Value, nan_max};
use crate::robust::structure::Structure as Blocks;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// A controller evaluated.
pub(crate) struct Evaluation {
    pub(super) lines: ClosedLines,
    /// Those that may take part in a step of a descent.
    pub values: Vec<Value>,
    /// Largest value of each group, minus infinity where there is none.
    largest: [f64; LIMITS + 1],
    /// Turns of det(I − G K) per rotor, forwards and backwards together: unstable poles of the plant less those of the
    /// loop.
    pub turns: Vec<i64>,
}

impl Evaluation {
    /// Largest value of a group.
    pub(crate) fn largest(&self, group: Group) -> f64 {
        self.largest[group as usize]
    }

    /// Objective plus penalty times what exceeds the limits.
    pub(crate) fn merit(&self, penalty: f64) -> f64 {
        let over: f64 = LIMIT_GROUPS.iter().map(|g| self.largest(*g).max(0.0)).sum();
        let compliance = self.largest(Group::Compliance);
        // Without a band of stiffness the limits are all there is.
        penalty * over
            + if compliance == f64::NEG_INFINITY {
                0.0
            } else {
                compliance
            }
    }
}

/// Rotors, lines and limits: everything about a loop but the controller.
pub(crate) struct Loss {
    pub lines: Vec<Line>,
    pub rotors: Vec<Rotor>,
    /// Flat indices of the loops of each rotor.
    sides: Vec<Range<usize>>,
    /// Loops that are evaluated one by one; they come first.
    nominal: usize,
    /// The others at each line, in groups.
    others: Vec<Vec<PackedLoops>>,
    specification: Option<Specification>,
    pub limits: LoopLimits,
    /// Share of the band up to Nyquist that a line stands for.
    pub(super) share: Vec<f64>,
    /// Rotors that count; a rotor whose loop is unstable from the start cannot.
    pub active: Vec<bool>,
}

/// The specification of the nominal loops on the lines, with its scales.
pub(crate) struct Specification {
    /// Loops: flat index among rotors × directions, weighted rows and scales of the modal channels on each line.
    pub loops: Vec<SpecifiedLoop>,
    pub blocks: Blocks,
}

/// The specification of one loop.
pub(crate) struct SpecifiedLoop {
    pub side: usize,
    pub lines: Vec<SpecificationLine>,
    pub scales: Vec<LineScales>,
}

impl Loss {
    /// A loss over rotors on their lines.
    pub(crate) fn new(
        lines: Vec<Line>,
        rotors: Vec<Rotor>,
        specification: Option<Specification>,
        limits: LoopLimits,
        period_s: f64,
    ) -> Self {
        let nyquist = PI / period_s;
        let at = |k: usize| lines.get(k).map_or(nyquist, |l: &Line| l.omega_rad_s);
        let share = (0..lines.len())
            .map(|k| {
                let below = if k == 0 {
                    0.0
                } else {
                    0.5 * (at(k - 1) + at(k))
                };
                let above = if k + 1 == lines.len() {
                    nyquist
                } else {
                    0.5 * (at(k) + at(k + 1))
                };
                (above - below) / nyquist
            })
            .collect();
        let active = vec![true; rotors.len()];
        let nominal = rotors.iter().take_while(|rotor| rotor.role.is_nominal());
        let nominal = nominal.map(|rotor| rotor.directions.len()).sum::<usize>();
        let specified = specification.as_ref().map_or(0, |s| s.loops.len());
        let nominal = nominal.max(specified);
        let all: Vec<&Vec<LoopResponse>> = rotors.iter().flat_map(|r| &r.directions).collect();
        let others = |k: usize| {
            let list: Vec<&LoopResponse> = all[nominal..].iter().map(|side| &side[k]).collect();
            PackedLoops::pack(&list)
        };
        let others = (0..lines.len()).into_par_iter().map(others).collect();
        let mut end = 0;
        let sides = rotors.iter().map(|rotor| {
            let first = end;
            end += rotor.directions.len();
            first..end
        });
        Self {
            lines,
            nominal,
            sides: sides.collect(),
            others,
            rotors,
            specification,
            limits,
            share,
            active,
        }
    }

    /// Responses of the rotors, and rows of the specification of each of its loops, on the lines.
    pub(super) fn responses(&self) -> (Vec<&Rotor>, Vec<&[SpecificationLine]>) {
        let loops = self.specification.iter().flat_map(|s| &s.loops);
        let rows = loops.map(|part| part.lines.as_slice()).collect();
        (self.rotors.iter().collect(), rows)
    }

    /// Scales of the modal channels of a loop of the specification, each from the nearest line.
    pub(super) fn scales_near(&self, lines: &[Line], side: usize, blocks: usize) -> Vec<Vec<f64>> {
        let mut loops = self.specification.iter().flat_map(|s| &s.loops);
        let own = loops.find(|part| part.side == side);
        let nearest = |line: &Line| {
            let omega = line.omega_rad_s;
            let above = self.lines.partition_point(|l| l.omega_rad_s < omega);
            let beside = above.saturating_sub(1)..self.lines.len().min(above + 1);
            let distance = |k: &usize| (self.lines[*k].omega_rad_s - omega).abs();
            let k = beside.min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
            own.map(|part| part.scales[k].list().to_vec())
        };
        let lines = lines.iter();
        lines
            .map(|line| nearest(line).unwrap_or_else(|| vec![1.0; blocks]))
            .collect()
    }

    /// The loop with parameters `x` of a structure, over all rotors that count; no values are kept.
    pub(crate) fn evaluate(&self, law: &dyn Structure, x: &[f64]) -> Evaluation {
        let lines = self.closed(law, x, 0.0);
        let turns = self.turns(&lines);
        self.gathered(lines, turns, None)
    }

    /// As [`Self::evaluate`] for a step of a descent: values that are `reach` and more (logarithms) below their limit,
    /// or below the largest of the objective, are left out, and such a bound of the specification may be replaced by a
    /// larger one that is, too.
    pub(super) fn evaluate_near(&self, law: &dyn Structure, x: &[f64], reach: f64) -> Evaluation {
        let lines = self.closed(law, x, (-reach).exp() * self.limits.mu);
        let turns = self.turns(&lines);
        self.gathered(lines, turns, Some(reach))
    }

    /// [`Self::evaluate`] over the rotors whose turns are `right`, given those of all; from here on these count.
    pub(crate) fn activate(
        &mut self,
        law: &dyn Structure,
        x: &[f64],
        right: impl Fn(&[i64]) -> i64,
    ) -> Evaluation {
        let lines = self.closed(law, x, 0.0);
        let turns = self.turns(&lines);
        let right = right(&turns);
        self.active = turns.iter().map(|turns| *turns == right).collect();
        self.gathered(lines, turns, None)
    }

    /// The loops of all rotors at every line; bounds of the specification are exact above `floor`.
    fn closed(&self, law: &dyn Structure, x: &[f64], floor: f64) -> ClosedLines {
        let fixed = law.with(x);
        ClosedLines::collect(self.lines.len(), |part, k| {
            self.close(part, &*fixed, (k, floor));
        })
    }

    /// Turns of det(I − G K) per rotor.
    fn turns(&self, lines: &ClosedLines) -> Vec<i64> {
        let of = |side: usize| lines.determinants(side);
        let turns = |rotor: usize| turns_of(self.sides(rotor).map(of)) as i64;
        (0..self.rotors.len()).map(turns).collect()
    }

    /// What closed loops come to over the rotors that count; of the values those within a reach.
    fn gathered(&self, lines: ClosedLines, turns: Vec<i64>, reach: Option<f64>) -> Evaluation {
        let mut parts: Vec<Gathered> = (0..self.rotors.len())
            .into_par_iter()
            .filter(|rotor| self.active[*rotor])
            .map(|rotor| self.rotor_values(rotor, &lines, reach))
            .collect();
        parts.push(self.controller_values(&lines, reach));
        let mut largest = [f64::NEG_INFINITY; LIMITS + 1];
        for part in &parts {
            for (all, square) in largest.iter_mut().zip(part.largest) {
                *all = nan_max(*all, 0.5 * square.ln());
            }
        }
        Evaluation {
            values: parts.into_iter().flat_map(|part| part.values).collect(),
            lines,
            largest,
            turns,
        }
    }

    /// Adds a line to its part.
    fn close(&self, part: &mut LinePart, law: &dyn Fixed, (k, floor): (usize, f64)) {
        let gain = law.gain(&self.lines[k]);
        let free = law.without_integrators(&self.lines[k]);
        let first = (part.nominal.len(), part.others.len());
        let sides = self.rotors.iter().flat_map(|r| &r.directions);
        let nominal = sides.take(self.nominal);
        part.nominal
            .extend(nominal.map(|d| LoopState::new(&d[k], &gain, free)));
        let others = self.others[k].iter();
        part.others
            .extend(others.map(|group| group.closed(&gain, free)));
        part.add_squares(first, &self.sides);
        for spec in self.specification.iter().flat_map(|s| &s.loops) {
            let own = (
                &part.nominal[first.0 + spec.side],
                &response(&self.rotors, spec.side, k).loops,
            );
            let bound = bound(&spec.lines[k], &spec.scales[k], own, floor);
            part.specification.push(bound);
        }
        part.gains.push(gain);
    }

    /// The loop with a flat index at a line, but for its determinant.
    pub(super) fn loop_state(&self, found: &Evaluation, line: usize, side: usize) -> LoopState {
        let state = found.lines.line(line);
        match state.nominal.get(side) {
            Some(own) => *own,
            None => LoopState::new(response(&self.rotors, side, line), state.gain, ONE),
        }
    }

    /// Renews the scales of the modal channels where the bound is near its limit and not flat, and those bounds in
    /// `found`.
    pub(crate) fn rescale(&mut self, found: &mut Evaluation) {
        let Some(spec) = &mut self.specification else {
            return;
        };
        let limit = self.limits.mu;
        let near: Vec<(usize, usize)> = (0..self.lines.len())
            .flat_map(|k| (0..spec.loops.len()).map(move |p| (k, p)))
            .filter(|(k, p)| {
                let bound = &found.lines.line(*k).specification[*p];
                bound.sigma >= NEAR * limit && bound.slope > FLAT
            })
            .collect();
        let rotors = &self.rotors;
        let renewed: Vec<(usize, usize, LineScales, Bound)> = near
            .into_par_iter()
            .map(|(k, p)| {
                let (part, state) = (&spec.loops[p], found.lines.line(k));
                let own = &state.nominal[part.side];
                let line = &part.lines[k];
                let scales = LineScales::new(line, best_scales(line, &own.r, &spec.blocks));
                let own = (own, &response(rotors, part.side, k).loops);
                let bound = bound(line, &scales, own, 0.0);
                (k, p, scales, bound)
            })
            .collect();
        for (k, p, scales, bound) in renewed {
            // The iteration for the scales ends at a tolerance: what was there may be better by as much.
            let before = found.lines.specification_mut(k, p);
            if bound.sigma < before.sigma {
                spec.loops[p].scales[k] = scales;
                *before = bound;
            }
        }
        let value = |bound: &Bound| (bound.sigma / limit).max(f64::MIN_POSITIVE).ln();
        for own in &mut found.values {
            if own.group == Group::Specification {
                own.value = value(&found.lines.line(own.line).specification[own.entry.0]);
            }
        }
        let bounds = found.lines.all().flat_map(|line| line.specification);
        found.largest[Group::Specification as usize] =
            bounds.map(value).fold(f64::NEG_INFINITY, nan_max);
    }

    /// Frequencies beside the peaks of the specification's bounds that are near the limit, rad/s.
    pub(super) fn beside_peaks(&self, found: &Evaluation) -> Vec<f64> {
        let loops = self.specification.iter().flat_map(|s| 0..s.loops.len());
        loops
            .flat_map(|part| {
                let sigma = |k: usize| found.lines.line(k).specification[part].sigma;
                beside_peaks(&self.lines, sigma, NEAR * self.limits.mu)
            })
            .collect()
    }

    /// Flat indices of the loops of a rotor.
    pub(super) fn sides(&self, rotor: usize) -> Range<usize> {
        self.sides[rotor].clone()
    }

    fn rotor_values(&self, rotor: usize, lines: &ClosedLines, reach: Option<f64>) -> Gathered {
        let mut all = Gathered::new(rotor, reach);
        let sides = self.sides(rotor);
        let role = self.rotors[rotor].role;
        let weight = match role {
            Role::Rest => 1.0,
            Role::TopSpeed => AT_TOP_SPEED,
            Role::Shifted => SHIFTED,
            Role::Overspeed | Role::Weak | Role::Weakest => 0.0,
        };
        let nominal = role.is_nominal();
        let (group, limit) = match role {
            Role::Rest | Role::TopSpeed => (Group::Sensitivity, self.limits.sensitivity),
            Role::Shifted | Role::Overspeed => (
                Group::Sensitivity,
                self.limits.sensitivity * self.limits.shifted_sensitivity,
            ),
            Role::Weak => (Group::Margin, self.limits.weak_sensitivity),
            Role::Weakest => (Group::Margin, WEAKEST * self.limits.weak_sensitivity),
        };
        let share = 1.0 / sides.len() as f64;
        let unit = (weight * 1e6).powi(2);
        let limit = limit * limit;
        let band = self.limits.stiffness_band_hz;
        let (low, high) = (band.0 * TAU * (1.0 - 1e-9), band.1 * TAU * (1.0 + 1e-9));
        let mut noise = [0.0f64; 2];
        for (line, state) in lines.all().enumerate() {
            let squares = &state.squares[rotor];
            let omega = self.lines[line].omega_rad_s;
            if weight > 0.0 && omega >= low && omega <= high {
                all.push(Group::Compliance, squares.compliance * unit, line, (0, 0));
            }
            for (j, square) in squares.sensitivity.iter().enumerate() {
                all.push(group, square / limit, line, (j, j));
            }
            if nominal {
                for l in &state.nominal[sides.clone()] {
                    for i in 0..2 {
                        let square = l.r[i][0].norm_sqr() + l.r[i][1].norm_sqr();
                        noise[i] += share * self.share[line] * square;
                    }
                }
            }
        }
        if nominal {
            for i in 0..2 {
                let unit = self.limits.sensor_noise_m / self.limits.noise_current_a;
                all.push(Group::NoiseCurrent, noise[i] * unit * unit, 0, (i, i));
            }
        }
        all
    }

    fn controller_values(&self, lines: &ClosedLines, reach: Option<f64>) -> Gathered {
        let mut all = Gathered::new(0, reach);
        let from = self.limits.high_frequency_hz * TAU;
        for (line, state) in lines.all().enumerate() {
            if self.lines[line].omega_rad_s >= from {
                let gain = largest_singular(state.gain).0;
                if gain != 0.0 {
                    let ratio = gain / self.limits.high_frequency_gain_a_per_m;
                    all.push(Group::HighGain, ratio * ratio, line, (0, 0));
                }
            }
            for (part, bound) in state.specification.iter().enumerate() {
                let ratio = (bound.sigma / self.limits.mu).powi(2);
                // Zero has no logarithm; what is not a number stays.
                let ratio = if ratio < f64::MIN_POSITIVE {
                    f64::MIN_POSITIVE
                } else {
                    ratio
                };
                all.push(Group::Specification, ratio, line, (part, part));
            }
        }
        all
    }
}

/// A bound that no scale changes by more than this (logarithms) keeps its scales: with curvatures of the order of a
/// tenth the optimum is lower by 5e-4 at most, less than what lines at other frequencies show.
const FLAT: f64 = 0.01;
/// Lines whose bound is below this share of the limit keep their scales, and a peak there gets no further lines.
const NEAR: f64 = 0.92;

/// Largest singular value σ of K and Q of its logarithm: v uᴴ/σ with K v = σ u.
pub(super) fn largest_singular(k: &Matrix2) -> (f64, Matrix2) {
    let ([square, _], [v, _]) = hermitian_eigen(&squared(&adjoint(k)));
    let u = times(k, &v).map(|z| z.conj());
    (square.sqrt(), outer(&v, &u, (1.0 / square).into()))
}

/// Responses of the loop with a flat index at a line.
fn response(rotors: &[Rotor], mut side: usize, line: usize) -> &LoopResponse {
    let mut rotor = 0;
    while side >= rotors[rotor].directions.len() {
        side -= rotors[rotor].directions.len();
        rotor += 1;
    }
    &rotors[rotor].directions[side][line]
}
