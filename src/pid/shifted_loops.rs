//! Stability of a PID on the machine with shifted modes: each of the first six alone, every combination of signs of the
//! first four, all modes of the shaft together.

use super::settings::TuneSettings;
use crate::controller::in_step;
use crate::controller::verification::growth_rate_of;
use crate::controller::verification_error::VerificationError;
use crate::lti::{Discrete, StateSpace};
use crate::spindle::{Machine, ModelDetail, Plant};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Modes that are shifted alone, and in every combination.
pub(super) const SHIFTED_MODES: usize = 6;
const COMBINED: usize = 4;
/// Speeds at which the shifted loops are checked: standstill, half and full speed at least.
pub(super) const SHIFTED_SPEEDS: usize = 3;

/// Stability of the loops with shifted modes; of a loop that is unstable as it is none is checked.
#[derive(Clone, Debug, PartialEq)]
pub struct ShiftedLoops {
    /// Relative shift of the modes.
    pub shift: f64,
    /// Loops checked: combinations of shifts times speeds.
    pub loops: usize,
    /// Largest growth rate over all of them, 1/s.
    pub worst_growth_rate_per_s: f64,
    /// Frequency factors of the first modes where it occurs.
    pub worst_factors: Vec<f64>,
    /// Its speed, rpm.
    pub worst_speed_rpm: f64,
}

impl ShiftedLoops {
    pub(super) fn none(shift: f64) -> Self {
        Self { shift, loops: 0, worst_growth_rate_per_s: f64::NAN, worst_factors: vec![], worst_speed_rpm: f64::NAN }
    }
}

/// Machine with every flexible frequency multiplied by `factor` (moduli by its square).
pub(super) fn with_shifted_modes(machine: &Machine, factor: f64) -> Machine {
    let mut shifted = machine.clone();
    for section in shifted.spindle.sections.iter_mut().chain(&mut shifted.tool.sections) {
        section.modulus_scale *= factor * factor;
    }
    shifted
}

/// Factors on the first modes: each alone, every combination of signs, all together.
fn shift_factors(shift: f64) -> Vec<Vec<f64>> {
    let ends = [1.0 - shift, 1.0 + shift];
    let alone = (0..SHIFTED_MODES)
        .flat_map(|k| ends.map(|f| (0..SHIFTED_MODES).map(|i| if i == k { f } else { 1.0 }).collect()));
    let combined = (0..1usize << COMBINED).map(|signs| (0..COMBINED).map(|k| ends[(signs >> k) & 1]).collect());
    let together = ends.map(|f| vec![f; MODES_TOGETHER]);
    alone.chain(combined).chain(together).collect()
}

/// A machine at some speeds, whose modes are shifted.
struct ShiftedPlants(Vec<(f64, Plant)>);

/// A loop with shifted modes: speed, rpm, factors, growth rate, 1/s.
type ShiftedLoop = (f64, Vec<f64>, f64);

impl ShiftedPlants {
    fn new(machine: &Machine, speeds: usize) -> Result<Self, VerificationError> {
        let plants: Result<Vec<(f64, Plant)>, VerificationError> = (0..speeds)
            .into_par_iter()
            .map(|k| {
                let rpm = machine.spindle.max_rpm * k as f64 / (speeds - 1) as f64;
                Ok((rpm, Plant::new(machine, rpm * TAU / 60.0, ModelDetail::Full)?))
            })
            .collect();
        Ok(Self(plants?))
    }

    /// The loops with some factors at all speeds.
    fn loops(&self, law: &StateSpace<Discrete>, factors: &[Vec<f64>]) -> Result<Vec<ShiftedLoop>, VerificationError> {
        let pairs: Vec<(&(f64, Plant), &Vec<f64>)> =
            self.0.iter().flat_map(|p| factors.iter().map(move |f| (p, f))).collect();
        pairs
            .into_par_iter()
            .map(|((rpm, plant), factors)| {
                let shifted = plant.with_scaled_modes(factors);
                let rate = growth_rate_of(&shifted, &shifted.sample_plant()?, law);
                Ok((*rpm, factors.clone(), rate.map_err(in_step("loop with shifted modes"))?))
            })
            .collect()
    }
}

/// Growth rates of the loops with modes shifted alone and combined.
pub(super) fn shifted_loops(
    machine: &Machine,
    law: &StateSpace<Discrete>,
    settings: &TuneSettings,
) -> Result<ShiftedLoops, VerificationError> {
    let shift = settings.mode_shift;
    let plants = ShiftedPlants::new(machine, settings.speeds.div_ceil(2).max(SHIFTED_SPEEDS))?;
    let factors = shift_factors(shift);
    // All together are verified on the machine with other moduli.
    let loops = plants.loops(law, &factors[..factors.len() - 2])?;
    let worst = loops.iter().reduce(|a, b| if b.2 > a.2 { b } else { a });
    Ok(match worst {
        Some((rpm, factors, rate)) => ShiftedLoops {
            shift,
            loops: loops.len(),
            worst_growth_rate_per_s: *rate,
            worst_factors: factors.clone(),
            worst_speed_rpm: *rpm,
        },
        None => ShiftedLoops::none(shift),
    })
}

/// Flexible modes that are shifted all together: more than lie below half of any sample rate.
const MODES_TOGETHER: usize = 64;
/// Shifts beyond this are no matter of tolerances.
const MOST_SHIFT: f64 = 0.1;
/// Width of the range that is found, absolute.
const SHIFT_WIDTH: f64 = 1e-3;
/// Combinations that a shift in the search is judged by, those nearest to instability; all are asked where it ends.
const NEAREST_COMBINATIONS: usize = 6;

/// What shift of its natural frequencies a loop bears.
#[derive(Clone, Debug)]
pub struct ShiftRange {
    /// The largest relative shift, at most a tenth, with which the loop is stable for every combination that a PID is
    /// certified with, and with all modes together, at rest, half and full top speed; zero for a loop that is unstable
    /// as it is.
    pub largest: f64,
    /// Numbers of the combinations that are nearest to instability there.
    nearest: Vec<usize>,
}

impl ShiftRange {
    /// Factors on the natural frequencies in the combinations that limit the range, of a relative shift.
    pub(crate) fn limiting_factors(&self, shift: f64) -> Vec<Vec<f64>> {
        let all = shift_factors(shift);
        self.nearest.iter().map(|k| all[*k].clone()).collect()
    }
}

/// Whether the loop of a law is stable with natural frequencies shifted by this much, in every combination.
///
/// # Errors
/// [`VerificationError`] when a plant or its eigenvalues fail.
pub(crate) fn bears_shift(
    machine: &Machine,
    law: &StateSpace<Discrete>,
    shift: f64,
) -> Result<bool, VerificationError> {
    let loops = ShiftedPlants::new(machine, SHIFTED_SPEEDS)?.loops(law, &shift_factors(shift))?;
    Ok(loops.iter().all(|own| own.2 < 0.0))
}

/// What shift of its natural frequencies the loop of a law bears.
///
/// # Errors
/// [`VerificationError`] when a plant or its eigenvalues fail.
pub fn find_shift_range(machine: &Machine, law: &StateSpace<Discrete>) -> Result<ShiftRange, VerificationError> {
    let plants = ShiftedPlants::new(machine, SHIFTED_SPEEDS)?;
    if plants.loops(law, &[vec![]])?.iter().any(|own| own.2 >= 0.0) {
        return Ok(ShiftRange { largest: 0.0, nearest: vec![] });
    }
    let of = |shift: f64, chosen: &[usize]| -> Result<Vec<ShiftedLoop>, VerificationError> {
        let all = shift_factors(shift);
        let some: Vec<Vec<f64>> = chosen.iter().map(|k| all[*k].clone()).collect();
        plants.loops(law, &some)
    };
    let every: Vec<usize> = (0..shift_factors(0.0).len()).collect();
    let holds = |loops: &[ShiftedLoop]| loops.iter().all(|own| own.2 < 0.0);
    let (mut low, mut high) = (0.0, MOST_SHIFT);
    let mut next = TuneSettings::quick().mode_shift;
    let mut near = nearest(&of(next, &every)?, every.len());
    loop {
        while high - low > SHIFT_WIDTH {
            if holds(&of(next, &near)?) {
                low = next
            } else {
                high = next
            }
            next = 0.5 * (low + high);
        }
        let loops = of(low, &every)?;
        if low == 0.0 || holds(&loops) {
            return Ok(ShiftRange { largest: low, nearest: near });
        }
        // A combination that was not asked fails: from below, with those that are nearest now.
        near = nearest(&loops, every.len());
        (low, high) = (0.0, low);
        next = 0.5 * high;
    }
}

/// Numbers of the combinations that are nearest to instability at any speed.
fn nearest(loops: &[ShiftedLoop], combinations: usize) -> Vec<usize> {
    let worst =
        |k: usize| loops.iter().skip(k).step_by(combinations).map(|own| own.2).fold(f64::NEG_INFINITY, f64::max);
    let mut order: Vec<usize> = (0..combinations).collect();
    order.sort_by(|a, b| worst(*b).total_cmp(&worst(*a)));
    order.truncate(NEAREST_COMBINATIONS);
    order
}
