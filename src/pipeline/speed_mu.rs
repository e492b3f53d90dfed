//! μ of the whole machine on its exact frequency responses (`rotating_loop`), at rest and over speed.
//!
//! The values are upper bounds on a grid that is dense round the closed-loop poles, not certified between its lines. An
//! unstable loop has no μ.

use super::PipelineError;
use super::rotating_loop::{RotatingLoop, SIGNS};
use crate::augment::Block;
use crate::augment::assembly::UncertainMode;
use crate::augment::plane::isotropic;
use crate::augment::weights::Weights;
use crate::linalg::{Mat, c64};
use crate::lti::line_maximum::LineMaximum;
use crate::lti::{Discrete, FrequencyGrid, StateSpace};
use crate::robust::mu::upper_bound;
use crate::robust::structure::Scaling;
use crate::spindle::{Machine, ModelDetail, Plant};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// μ at one speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedMu {
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Largest upper bound on the grid; infinite for an unstable loop.
    pub mu: f64,
    /// Its frequency, Hz; negative: backward whirl.
    pub frequency_hz: f64,
}

/// Speeds over the top speed on which candidates are compared; those of a delivery hold them.
const COMPARED_SPEEDS: [f64; 6] = [0.0, 0.25, 0.5, 0.75, 1.0, 1.2];
/// Twentieths of the top speed from rest to 1.2 times the top speed: speeds of a delivery.
const LAST_TWENTIETH: usize = 24;
/// Every so many lines the bound is optimised for its scaling, whatever its value.
const STRIDE: usize = 12;
/// Share of the distance of its neighbours to which the place of a peak is sought: what is missed falls with its
/// square, from [`BETWEEN_LINES`] to 2e-5.
const PLACE: f64 = 0.01;
/// What the plain lines may miss of a peak: three lines to a half-power width show it to that share.
const BETWEEN_LINES: f64 = 0.05;
/// Peaks that are looked at more closely, the highest first.
const MOST_TOPS: usize = 8;
/// Last frequency as a share of Nyquist.
const LAST: f64 = 0.9995;
/// Lines of the plain grid and on each side of a pole: three to each half-power width.
const LINES: usize = 160;
const LINES_A_SIDE: usize = 3;

/// Speeds on which candidates are compared, rpm.
pub(super) fn compared_speeds(machine: &Machine) -> Vec<f64> {
    COMPARED_SPEEDS.map(|share| share * machine.spindle.max_rpm).to_vec()
}

/// Speeds on which the μ of a delivered controller is stated, rpm.
pub(super) fn delivered_speeds(machine: &Machine) -> Vec<f64> {
    (0..=LAST_TWENTIETH).map(|k| k as f64 * machine.spindle.max_rpm / 20.0).collect()
}

/// μ of the specification with a four-axis law at some speeds, rpm; what is `known` at some of these is not computed
/// again.
///
/// # Errors
/// [`PipelineError`] when a plant, a weight or a bound fails.
pub fn mu_over_speed(
    machine: &Machine,
    weights: &Weights,
    modes: &[UncertainMode],
    law: &StateSpace<Discrete>,
    speeds_rpm: &[f64],
    known: &[SpeedMu],
) -> Result<Vec<SpeedMu>, PipelineError> {
    speeds_rpm
        .par_iter()
        .map(|&speed_rpm| match known.iter().find(|found| found.speed_rpm == speed_rpm) {
            Some(found) => Ok(*found),
            None => mu_at_speed(machine, weights, modes, law, speed_rpm),
        })
        .collect()
}

/// What the speeds of a delivery may miss of a peak over speed, relative to it: tops of at least this share of the
/// largest are looked at more closely.
const BETWEEN_SPEEDS: f64 = 0.05;
/// Share of the distance of its neighbours to which the speed of a peak is sought: what is missed falls with its
/// square.
const SPEED_PLACE: f64 = 0.02;
/// Tops over speed that are looked at more closely, the highest first.
const MOST_SPEED_TOPS: usize = 3;

/// μ at more speeds than `found`, round the largest, so that none between them is larger by more than some 1e-3 of it
/// where a top between two speeds shows on them; in the order of the speeds. An unstable loop has no μ to look for.
///
/// # Errors
/// As [`mu_over_speed`].
pub(super) fn refine_largest(
    machine: &Machine,
    weights: &Weights,
    modes: &[UncertainMode],
    law: &StateSpace<Discrete>,
    mut found: Vec<SpeedMu>,
) -> Result<Vec<SpeedMu>, PipelineError> {
    let order = |a: &SpeedMu, b: &SpeedMu| a.speed_rpm.total_cmp(&b.speed_rpm);
    found.sort_by(order);
    if found.len() < 3 || found.iter().any(|at| !at.mu.is_finite()) {
        return Ok(found);
    }
    let at = |speed_rpm: f64| mu_at_speed(machine, weights, modes, law, speed_rpm);
    // A top at an end may lie beside it: half way to the neighbour tells.
    let last = found.len() - 1;
    for (end, beside) in [(0, 1), (last, last - 1)] {
        if found[end].mu >= found[beside].mu {
            found.push(at(0.5 * (found[end].speed_rpm + found[beside].speed_rpm))?);
        }
    }
    found.sort_by(order);
    let largest = found.iter().map(|at| at.mu).fold(0.0, f64::max);
    let inside = |three: &&[SpeedMu]| three[1].mu >= three[0].mu.max(three[2].mu);
    let mut tops: Vec<[SpeedMu; 3]> = found.windows(3).filter(inside).map(|t| [t[0], t[1], t[2]]).collect();
    tops.retain(|top| top[1].mu >= (1.0 - BETWEEN_SPEEDS) * largest);
    tops.sort_by(|a, b| b[1].mu.total_cmp(&a[1].mu));
    tops.truncate(MOST_SPEED_TOPS);
    for top in tops {
        let points = top.map(|at| (at.speed_rpm, at.mu));
        let mut search = LineMaximum::new(points, SPEED_PLACE * (points[2].0 - points[0].0));
        while let Some(speed_rpm) = search.next() {
            let further = at(speed_rpm)?;
            search.add(speed_rpm, further.mu);
            found.push(further);
        }
    }
    found.sort_by(order);
    Ok(found)
}

/// μ of a specification with a four-axis law at one speed; `modes` are the uncertain ones.
///
/// # Errors
/// As [`mu_over_speed`].
pub fn mu_at_speed(
    machine: &Machine,
    weights: &Weights,
    modes: &[UncertainMode],
    law: &StateSpace<Discrete>,
    speed_rpm: f64,
) -> Result<SpeedMu, PipelineError> {
    let machine = isotropic(machine);
    let plant = Plant::new(&machine, speed_rpm * TAU / 60.0, ModelDetail::Full)?;
    let sampled = plant.sample_plant()?;
    let poles = plant.loop_poles(&sampled, law);
    let poles = poles.map_err(PipelineError::numeric(STAGE))?;
    let poles = sampled.time.continuous_poles(poles);
    if poles.iter().any(|p| p.re.is_nan() || p.re >= 0.0) {
        return Ok(SpeedMu { speed_rpm, mu: f64::INFINITY, frequency_hz: f64::NAN });
    }
    let nyquist_hz = 0.5 / plant.sample_period_s();
    let grid = FrequencyGrid::log_hz(1.0, 0.98 * nyquist_hz, LINES);
    // An integral weight asks most below 1 Hz; a thousandth of its corner is where it ends to rise.
    let below = weights.integral_corner_hz.map(|corner| FrequencyGrid::log_hz(1e-4 * corner.min(1.0), 1.0, LINES / 4));
    let below = below.iter().flat_map(|grid| grid.omega_rad_s().iter().copied());
    let grid = FrequencyGrid::from_rad_s(below.chain(grid.omega_rad_s().iter().copied()));
    let grid = grid.refine_round_poles(&poles, LINES_A_SIDE);
    let rotating = RotatingLoop::new(&plant, weights, modes, law)?;
    let last = LAST * TAU * nyquist_hz;
    let (mu, omega) = PeakSearch::new(&rotating, grid.omega_rad_s())?.peak(last)?;
    Ok(SpeedMu { speed_rpm, mu, frequency_hz: omega / TAU })
}

const STAGE: &str = "μ over speed";

/// The larger bound with its frequency, the first of equal ones.
fn larger(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    if b.0 > a.0 { b } else { a }
}

/// Values of ascending frequency (their sign aside) that are at least as large as both neighbours, the largest first.
fn tops(values: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let at = |k: Option<usize>| k.and_then(|k| values.get(k)).map_or(0.0, |v| v.0);
    let mut tops: Vec<(f64, f64)> = (0..values.len())
        .filter(|k| values[*k].0 >= at(k.checked_sub(1)).max(at(Some(k + 1))))
        .map(|k| values[k])
        .collect();
    tops.sort_by(|a, b| b.0.total_cmp(&a.0));
    tops
}

/// Largest bound of μ of a loop on lines, and between them round the largest.
struct PeakSearch<'a> {
    rotating: &'a RotatingLoop,
    lines: &'a [f64],
    /// Numbers of the lines whose scaling guides their neighbours.
    guides: Vec<usize>,
    /// Bound and scaling there, forwards and backwards.
    guided: Vec<[(f64, Scaling); 2]>,
}

impl<'a> PeakSearch<'a> {
    fn new(rotating: &'a RotatingLoop, lines: &'a [f64]) -> Result<Self, PipelineError> {
        let guides: Vec<usize> = (0..lines.len()).step_by(STRIDE).collect();
        let guided: Result<Vec<[(f64, Scaling); 2]>, PipelineError> = guides
            .par_iter()
            .map(|k| {
                let [forward, backward] = rotating.at(lines[*k]);
                let both =
                    |(m, blocks): &(Mat<c64>, Vec<Block>)| upper_bound(m, blocks).map_err(PipelineError::mu(STAGE));
                Ok([both(&forward)?, both(&backward)?])
            })
            .collect();
        Ok(Self { rotating, lines, guides, guided: guided? })
    }

    /// The largest bound and its signed frequency, rad/s, sought up to `last`: beyond Nyquist the loop of a sampled
    /// controller is not that of the response at one frequency.
    fn peak(&self, last: f64) -> Result<(f64, f64), PipelineError> {
        let mut peak = (0.0, f64::NAN);
        for (k, both) in self.guides.iter().zip(&self.guided) {
            for ((upper, _), sign) in both.iter().zip(SIGNS) {
                peak = larger(peak, (*upper, sign * self.lines[*k]));
            }
        }
        // A peak is higher than its lines show: those that may turn out the highest are looked at more closely.
        let high = self.above(self.lines, (1.0 - BETWEEN_LINES) * peak.0)?;
        peak = high.iter().copied().fold(peak, larger);
        let mut tops = tops(&high);
        tops.retain(|top| top.0 >= (1.0 - BETWEEN_LINES) * peak.0);
        tops.truncate(MOST_TOPS);
        let refined: Result<Vec<(f64, f64)>, PipelineError> =
            tops.par_iter().map(|top| self.refine_peak(*top, &high, last)).collect();
        Ok(refined?.into_iter().fold(peak, larger))
    }

    /// The largest bound round a line that is larger than its neighbours; `high` are the bounds known on lines.
    fn refine_peak(&self, top: (f64, f64), high: &[(f64, f64)], last: f64) -> Result<(f64, f64), PipelineError> {
        let (centre, side) = (top.1.abs(), usize::from(top.1 < 0.0));
        let number = self.lines.partition_point(|w| *w < centre);
        let line = |number: Option<usize>| number.and_then(|k| self.lines.get(k)).copied();
        let below = line(number.checked_sub(1)).map_or(0.9 * centre, |w| w.max(0.9 * centre));
        let above = line(Some(number + 1)).map_or(1.1 * centre, |w| w.min(1.1 * centre));
        let known = |omega: f64| {
            let found = high.iter().find(|value| value.1.abs() == omega);
            (omega, found.map_or(f64::NEG_INFINITY, |value| value.0))
        };
        let above = above.min(last);
        let points = [known(below), (centre, top.0), known(above)];
        let mut search = LineMaximum::new(points, PLACE * (above - below));
        let mut peak = top;
        while let Some(omega) = search.next() {
            let mut least = [peak.0; 2];
            least[side] = 0.0;
            let found = self.bound_at(omega, least)?;
            search.add(omega, found.map_or(f64::NAN, |found| found.0));
            peak = found.into_iter().fold(peak, larger);
        }
        Ok(peak)
    }

    /// Bounds on lines, with their signed frequencies, where they may exceed `least`.
    fn above(&self, lines: &[f64], least: f64) -> Result<Vec<(f64, f64)>, PipelineError> {
        let found: Result<Vec<Option<(f64, f64)>>, PipelineError> =
            lines.par_iter().map(|omega| self.bound_at(*omega, [least; 2])).collect();
        Ok(found?.into_iter().flatten().collect())
    }

    /// The larger bound at a frequency, with its sign, of those forwards and backwards that may exceed `least`. Any
    /// scaling gives a bound: where that of the nearest guide is below `least` already, the optimum is, too.
    fn bound_at(&self, omega: f64, least: [f64; 2]) -> Result<Option<(f64, f64)>, PipelineError> {
        let after = self.guides.partition_point(|k| self.lines[*k] < omega);
        let guide = self.guided.get(after).or(self.guided.last());
        let mut largest: Option<(f64, f64)> = None;
        let both = self.rotating.at(omega);
        for (side, (m, blocks)) in both.into_iter().enumerate() {
            if guide.is_some_and(|g| g[side].1.bound_from(&m, least[side]) <= least[side]) {
                continue;
            }
            let (upper, _) = upper_bound(&m, &blocks).map_err(PipelineError::mu(STAGE))?;
            if largest.is_none_or(|l| upper > l.0) {
                largest = Some((upper, SIGNS[side] * omega));
            }
        }
        Ok(largest)
    }
}
