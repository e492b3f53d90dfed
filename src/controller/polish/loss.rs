//! Objective and limits of a polish over all rotors and lines, with exact derivatives.
//!
//! With G the loop, K the controller, S = (I − G K)⁻¹, S_u = (I − K G)⁻¹: H = G_td + G_tu K S G_yd is the tool's
//! compliance,
//!   δH = G_tu S_u δK S G_yd,   δS = S G δK S,   δ(K S) = S_u δK S.
//! A value enters by its logarithm relative to its limit, so each derivative is Re tr(Q δK) with a 2×2 matrix Q per
//! line, and the structure of the controller turns Q into derivatives by parameters. At speed the x axis is the mean of
//! both whirls.

use super::limits::LoopLimits;
use super::line_scales::LineScales;
use super::line_state::{ClosedLines, DirectionSums, LinePart};
use super::lines::beside_peaks;
use super::loop_state::LoopState;
use super::matrix2::{Matrix2, adjoint, conjugate_square, hermitian_eigen, outer, times};
use super::packed_loops::PackedLoops;
use super::phase_count::turns_of;
use super::responses::{LoopResponse, ServedRotor, SpecificationLine};
use super::rotor_groups::RotorGroups;
use super::specification_bound::{Bound, best_scales, bound_line};
use super::specification_norm::{self, PackedNorms};
use super::structure::{FixedLaw, LawStructure, LoopLine};
use super::values::{LIMIT_GROUPS, LIMITS, Value, ValueGroup, nan_max};
use crate::augment::weights::StiffnessFloor;
use crate::linalg::lanes::{Lanes, WIDTH, groups, place};
use crate::robust::structure::Structure as Blocks;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::ops::{Range, RangeInclusive};

pub(crate) struct Evaluation {
    pub(super) lines: ClosedLines,
    /// Those that may take part in a step of a descent.
    pub values: Vec<Value>,
    /// Largest value of each group, minus infinity where there is none.
    pub(super) largest: [f64; LIMITS + 1],
    /// Turns of det(I − G K) per rotor, forwards and backwards together: unstable poles of the plant less those of the
    /// loop.
    pub turns: Vec<i64>,
}

impl Evaluation {
    pub(crate) fn largest(&self, group: ValueGroup) -> f64 {
        self.largest[group as usize]
    }

    /// Objective plus penalty times what exceeds the limits.
    pub(crate) fn merit(&self, penalty: f64) -> f64 {
        let over: f64 = LIMIT_GROUPS.iter().map(|g| self.largest(*g).max(0.0)).sum();
        let compliance = self.largest(ValueGroup::Compliance);
        // Without a band of stiffness the limits are all there is.
        penalty * over + if compliance == f64::NEG_INFINITY { 0.0 } else { compliance }
    }
}

/// Rotors, lines and limits: everything about a loop but the controller.
pub(crate) struct Loss {
    pub lines: Vec<LoopLine>,
    pub rotors: Vec<ServedRotor>,
    /// Rotors whose loops are closed together.
    pub(super) groups: RotorGroups,
    /// All loops in packs, those of a line after those of the line before.
    loops: Vec<PackedLoops>,
    specification: Option<Specification>,
    /// Pack and place in it of each loop of the specification.
    specified: Vec<(usize, usize)>,
    pub limits: LoopLimits,
    /// Share of the band up to Nyquist that a line stands for.
    pub(super) share: Vec<f64>,
    /// Rotors that count; a rotor whose loop is unstable from the start cannot.
    pub active: Vec<bool>,
    /// Lines at which the tool's stiffness has a floor, and that floor, N/m.
    pub(super) floors: Vec<(usize, f64)>,
}

/// The specification of the nominal loops on the lines, with its scales.
pub(crate) struct Specification {
    /// Loops: flat index among rotors × directions, weighted rows and scales of the modal channels on each line.
    pub loops: Vec<SpecifiedLoop>,
    /// Norms of all loops on each line, in groups of four.
    norms: Vec<PackedNorms>,
    pub blocks: Blocks,
}

impl Specification {
    /// Of loops on the same lines.
    pub(super) fn new(loops: Vec<SpecifiedLoop>, blocks: Blocks) -> Self {
        let lines = loops.first().map_or(0, |own| own.lines.len());
        let norms = |k: usize| {
            loops.chunks(WIDTH).map(move |four| {
                let mut norms = PackedNorms::NOTHING;
                for (l, own) in four.iter().enumerate() {
                    norms.set(l, &own.lines[k], &own.scales[k]);
                }
                norms
            })
        };
        Self { norms: (0..lines).into_par_iter().flat_map_iter(norms).collect(), loops, blocks }
    }

    /// Norms of the loops on a line.
    fn norms(&self, line: usize) -> &[PackedNorms] {
        let each = groups(self.loops.len());
        &self.norms[line * each..(line + 1) * each]
    }

    /// Renews the scales of a loop on a line.
    fn set_scales(&mut self, part: usize, line: usize, scales: LineScales) {
        let (group, lane) = place(part);
        let norms = &mut self.norms[line * groups(self.loops.len()) + group];
        let own = &mut self.loops[part];
        norms.set(lane, &own.lines[line], &scales);
        own.scales[line] = scales;
    }
}

pub(crate) struct SpecifiedLoop {
    pub side: usize,
    pub lines: Vec<SpecificationLine>,
    pub scales: Vec<LineScales>,
}

impl Loss {
    /// A loss over rotors on their lines.
    pub(crate) fn new(
        lines: Vec<LoopLine>,
        rotors: Vec<ServedRotor>,
        specification: Option<Specification>,
        limits: LoopLimits,
        period_s: f64,
    ) -> Self {
        let nyquist = PI / period_s;
        let at = |k: usize| lines.get(k).map_or(nyquist, |l: &LoopLine| l.omega_rad_s);
        let share = (0..lines.len())
            .map(|k| {
                let below = if k == 0 { 0.0 } else { 0.5 * (at(k - 1) + at(k)) };
                let above = if k + 1 == lines.len() { nyquist } else { 0.5 * (at(k) + at(k + 1)) };
                (above - below) / nyquist
            })
            .collect();
        let active = vec![true; rotors.len()];
        let loops = specification.iter().flat_map(|s| &s.loops);
        let sides: Vec<usize> = loops.map(|part| part.side).collect();
        let groups = RotorGroups::new(&rotors, sides.iter().map(|side| side + 1).max().unwrap_or(0));
        let pack = |k: usize| groups.pack(&rotors, k);
        Self {
            loops: (0..lines.len()).into_par_iter().flat_map_iter(pack).collect(),
            specified: sides.iter().filter_map(|side| groups.place(*side)).collect(),
            lines,
            groups,
            rotors,
            specification,
            limits,
            share,
            active,
            floors: vec![],
        }
    }

    /// With floors of the tool's stiffness on the lines in their bands; where two bands overlap the higher one.
    pub(super) fn with_floors(mut self, floors: &[StiffnessFloor]) -> Self {
        let floor_at = |(line, at): (usize, &LoopLine)| {
            let here = floors.iter().filter(|floor| floor.holds_at(at.omega_rad_s / TAU));
            here.map(|floor| floor.at_least_n_per_m).reduce(f64::max).map(|highest| (line, highest))
        };
        self.floors = self.lines.iter().enumerate().filter_map(floor_at).collect();
        self
    }

    /// Responses of the rotors, and rows of the specification of each of its loops, on the lines.
    pub(super) fn responses(&self) -> (Vec<&ServedRotor>, Vec<&[SpecificationLine]>) {
        let loops = self.specification.iter().flat_map(|s| &s.loops);
        let rows = loops.map(|part| part.lines.as_slice()).collect();
        (self.rotors.iter().collect(), rows)
    }

    /// Scales of the modal channels of a loop of the specification, each from the nearest line.
    pub(super) fn scales_near(&self, lines: &[LoopLine], side: usize, blocks: usize) -> Vec<Vec<f64>> {
        let mut loops = self.specification.iter().flat_map(|s| &s.loops);
        let own = loops.find(|part| part.side == side);
        let nearest = |line: &LoopLine| {
            let omega = line.omega_rad_s;
            let above = self.lines.partition_point(|l| l.omega_rad_s < omega);
            let beside = above.saturating_sub(1)..self.lines.len().min(above + 1);
            let distance = |k: &usize| (self.lines[*k].omega_rad_s - omega).abs();
            let k = beside.min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
            own.map(|part| part.scales[k].list().to_vec())
        };
        let lines = lines.iter();
        lines.map(|line| nearest(line).unwrap_or_else(|| vec![1.0; blocks])).collect()
    }

    /// The loop with parameters `x` of a structure, over all rotors that count; no values are kept.
    pub(crate) fn evaluate(&self, law: &dyn LawStructure, x: &[f64]) -> Evaluation {
        let lines = self.close_lines(law, x, 0.0);
        let turns = self.turns(&lines);
        self.gather_lines(lines, turns, None)
    }

    /// As [`Self::evaluate`] for a step of a descent: values that are `reach` and more (logarithms) below their limit,
    /// or below the largest of the objective, are left out, and such a bound of the specification may be replaced by a
    /// larger one that is, too.
    pub(super) fn evaluate_near(&self, law: &dyn LawStructure, x: &[f64], reach: f64) -> Evaluation {
        let lines = self.close_lines(law, x, (-reach).exp() * self.limits.mu);
        let turns = self.turns(&lines);
        self.gather_lines(lines, turns, Some(reach))
    }

    /// [`Self::evaluate`] over the rotors whose turns are those of a stable loop; from here on these count. The law
    /// adds its unstable poles to those of each plant; where they are not known, the loop at rest counts as stable.
    pub(crate) fn activate(&mut self, law: &dyn LawStructure, x: &[f64], unstable_law: Option<i64>) -> Evaluation {
        let lines = self.close_lines(law, x, 0.0);
        let turns = self.turns(&lines);
        let beyond = |k: usize| turns[k] - self.rotors[k].unstable_poles;
        let of_law = unstable_law.unwrap_or_else(|| beyond(0));
        self.active = (0..turns.len()).map(|k| beyond(k) == of_law).collect();
        self.gather_lines(lines, turns, None)
    }

    /// The loops of all rotors at every line; bounds of the specification are exact above `floor`.
    fn close_lines(&self, law: &dyn LawStructure, x: &[f64], floor: f64) -> ClosedLines {
        let fixed = law.with(x);
        let groups = &self.groups;
        let sizes = [groups.list.len(), groups.packs(), self.specified.len()];
        ClosedLines::collect(
            self.lines.len(),
            sizes,
            |lines, gains| fixed.add_gains(&self.lines[lines], gains),
            |part, k| self.close(part, &*fixed, k, floor),
        )
    }

    /// Turns of det(I − G K) per rotor.
    fn turns(&self, lines: &ClosedLines) -> Vec<i64> {
        let mut turns = vec![0; self.rotors.len()];
        for group in &self.groups.list {
            let phases: Vec<_> = group.packs.clone().map(|pack| lines.phases(pack)).collect();
            for (l, rotor) in group.rotors.iter().enumerate() {
                turns[*rotor] = turns_of(phases.iter().map(|four| four[l]));
            }
        }
        turns
    }

    /// Adds a line to its part.
    fn close(&self, part: &mut LinePart, law: &dyn FixedLaw, k: usize, floor: f64) {
        let gain = part.gains[k - part.first];
        let free = law.without_integrators(&self.lines[k]);
        let (omega, band) = (self.lines[k].omega_rad_s, self.stiffness_band_rad_s());
        let packs = self.groups.packs();
        let loops = &self.loops[k * packs..(k + 1) * packs];
        for (place, group) in self.groups.list.iter().enumerate() {
            let mut sums = DirectionSums::ZERO;
            for number in group.packs.clone() {
                let pack = &loops[number];
                let state = if group.is_nominal {
                    let whole = pack.closed_nominal(&gain, free);
                    let share = self.share[k] / group.packs.len() as f64;
                    part.largest[place].add_noise(share, whole.currents());
                    for (own, (at, lane)) in part.specified.iter_mut().zip(&self.specified) {
                        if *at == number {
                            *own = whole.lane(*lane);
                        }
                    }
                    whole.state
                } else {
                    pack.close_loops(&gain, free)
                };
                part.add_determinant(number, &state.determinant);
                sums = sums.with(&state);
            }
            let squares = sums.mean_squares(group.packs.len());
            part.largest[place].add(&squares, band.contains(&omega));
            part.squares.push(squares);
        }
        if let Some(spec) = &self.specification {
            self.add_bounds(part, spec, k, floor);
        }
    }

    /// Adds the bounds of the specification at a line, of the loops there.
    fn add_bounds(&self, part: &mut LinePart, spec: &Specification, k: usize, floor: f64) {
        let least = floor * floor;
        let fours = part.specified.chunks(WIDTH).zip(spec.loops.chunks(WIDTH));
        for ((states, loops), norms) in fours.zip(spec.norms(k)) {
            let mut r = [[Lanes::ZERO; 2]; 2];
            for (l, state) in states.iter().enumerate() {
                specification_norm::set(&mut r, l, &state.r);
            }
            // σ ≤ ‖M‖_F.
            let squares = norms.squares_at_most(&r).to_array();
            for ((state, own), square) in states.iter().zip(loops).zip(squares) {
                part.specification.push(if square < least {
                    Bound::at_most(square.sqrt())
                } else {
                    let g = &response(&self.rotors, own.side, k).loops;
                    bound_line(&own.lines[k], &own.scales[k], state, g, floor)
                });
            }
        }
    }

    /// Band of the tool's stiffness, with what rounding may take off its ends, rad/s.
    pub(super) fn stiffness_band_rad_s(&self) -> RangeInclusive<f64> {
        let (low, high) = self.limits.stiffness_band_hz;
        low * TAU * (1.0 - 1e-9)..=high * TAU * (1.0 + 1e-9)
    }

    /// The loop with a flat index at a line.
    pub(super) fn loop_state(&self, found: &Evaluation, line: usize, side: usize) -> LoopState {
        let gain = found.lines.line(line).gain;
        LoopState::new(response(&self.rotors, side, line), gain)
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
                let part = &spec.loops[p];
                let (line, g) = (&part.lines[k], response(rotors, part.side, k));
                let own = LoopState::new(g, found.lines.line(k).gain);
                let scales = LineScales::new(best_scales(line, &own.r, &spec.blocks));
                let bound = bound_line(line, &scales, &own, &g.loops, 0.0);
                (k, p, scales, bound)
            })
            .collect();
        for (k, p, scales, bound) in renewed {
            // The iteration for the scales ends at a tolerance: what was there may be better by as much.
            let before = found.lines.specification_mut(k, p);
            if bound.sigma < before.sigma {
                spec.set_scales(p, k, scales);
                *before = bound;
            }
        }
        let value = |bound: &Bound| (bound.sigma / limit).max(f64::MIN_POSITIVE).ln();
        for own in &mut found.values {
            if own.group == ValueGroup::Specification {
                own.value = value(&found.lines.line(own.line).specification[own.entry.0]);
            }
        }
        let bounds = found.lines.all().flat_map(|line| line.specification);
        found.largest[ValueGroup::Specification as usize] = bounds.map(value).fold(f64::NEG_INFINITY, nan_max);
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
        self.groups.sides(rotor)
    }
}

/// A bound that no scale changes by more than this (logarithms) keeps its scales: with curvatures of the order of a
/// tenth the optimum is lower by 5e-4 at most, less than what lines at other frequencies show.
const FLAT: f64 = 0.01;
/// Lines whose bound is below this share of the limit keep their scales, and a peak there gets no further lines.
const NEAR: f64 = 0.92;

/// Largest singular value σ of K and Q of its logarithm: v uᴴ/σ with K v = σ u.
pub(super) fn largest_singular(k: &Matrix2) -> (f64, Matrix2) {
    let ([square, _], [v, _]) = hermitian_eigen(&conjugate_square(&adjoint(k)));
    let u = times(k, &v).map(|z| z.conj());
    (square.sqrt(), outer(&v, &u, (1.0 / square).into()))
}

/// Responses of the loop with a flat index at a line.
fn response(rotors: &[ServedRotor], mut side: usize, line: usize) -> &LoopResponse {
    let mut rotor = 0;
    while side >= rotors[rotor].directions.len() {
        side -= rotors[rotor].directions.len();
        rotor += 1;
    }
    &rotors[rotor].directions[side][line]
}
