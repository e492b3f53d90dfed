//! Lines whose signals reach a limit.
//!
//! The fundamental of a sine that is cut off at l lies between l and 4 l/π, however large the sine. Lines in that range
//! below the largest signal of a sweep are left out; where enough of them pile up and the machine explains what is
//! left, they were cut off. A resonance that is lower than in the model passes through the range in a line or two only.

use super::super::DiagnoseError;
use super::super::data::evidence::GAP_FLOOR;
use super::super::data::measurement::RecordSet;
use super::super::decide::candidate::Standing;
use super::trial::Trial;
use crate::identify::plausibility::Signal;
use crate::identify::plausibility::correction::largest;
use crate::linalg::{Mat, c64, solve_complex};
use crate::spindle::response::SIDE;
use std::f64::consts::TAU;

/// Least share of the lines that pile up, and least number of them.
const LEAST: (f64, usize) = (0.03, 4);
/// Most of them: what is left has to speak for the machine.
const MOST: f64 = 0.5;
/// Shares of the largest signal that may be the limit: a limit on the fundamental itself, and on the samples.
const SHARES: [f64; 4] = [0.995, 0.95, 0.87, std::f64::consts::FRAC_PI_4];

/// Limits that a sweep's signals allow, ascending; first the signal of which most lines are close to its largest.
pub(crate) fn clippings(measurement: &RecordSet, sweep: usize) -> Vec<(Signal, Vec<f64>)> {
    let Some(record) = measurement.sweeps.get(sweep) else {
        return vec![];
    };
    let lines = record.frequency_hz.len();
    let least = ((LEAST.0 * lines as f64) as usize).max(LEAST.1);
    let most = (MOST * lines as f64) as usize;
    let mut all: Vec<(usize, Signal, Vec<f64>)> = vec![];
    for signal in [Signal::Displacement, Signal::Current] {
        let sizes: Vec<f64> = (0..lines).map(|k| largest(record, signal, k)).collect();
        let top = sizes.iter().copied().fold(0.0, f64::max);
        let reached = |limit: f64| sizes.iter().filter(|s| **s >= limit).count();
        let limits = SHARES.into_iter().rev().map(|share| share * top);
        let limits: Vec<f64> = limits.filter(|limit| (least..=most).contains(&reached(*limit))).collect();
        all.push((reached(SHARES[0] * top), signal, limits));
    }
    all.sort_by_key(|own| std::cmp::Reverse(own.0));
    all.into_iter().map(|(_, signal, limits)| (signal, limits)).collect()
}

/// Whether the machine, as fitted to the other lines, has larger signals where a limit was reached than the record
/// shows: what is cut off was larger. Without a cut the two differ by what a right model leaves.
pub(super) fn beyond(
    trial: &Trial,
    sweep: usize,
    signal: Signal,
    limit: f64,
    standing: &Standing,
) -> Result<bool, DiagnoseError> {
    let Some(record) = trial.measurement.sweeps.get(sweep) else {
        return Ok(false);
    };
    let p = &standing.candidate.fit.at.p;
    let speed_rad_s = record.speed_rpm * TAU / 60.0;
    let model = trial.model.assemble(p, &[], speed_rad_s, false)?;
    let gain: [f64; 4] = std::array::from_fn(|i| 1.0 + p[trial.model.layout.axis(sweep, i)]);
    let (_, experiments, repeats, _) = record.current.dim();
    let mut ratios = vec![];
    for (k, hz) in record.frequency_hz.iter().enumerate() {
        if largest(record, signal, k) < limit {
            continue;
        }
        let f = model.line(TAU * hz, None).response;
        let g = Mat::from_fn(4, 4, |i, j| f[SIDE * i + j] * gain[i]);
        for (e, r) in (0..experiments).flat_map(|e| (0..repeats).map(move |r| (e, r))) {
            let of = |all: &ndarray::Array4<c64>| Mat::from_fn(4, 1, |i, _| all[(k, e, r, i)]);
            let (current, displacement) = (of(&record.current), of(&record.signal));
            let (shown, full) = match signal {
                Signal::Current => (current, solve_complex(&g, &displacement)),
                _ => (displacement, &g * &current),
            };
            let cut = (0..4).filter(|i| shown[(*i, 0)].norm() >= limit);
            ratios.extend(cut.map(|i| full[(i, 0)].norm() / shown[(i, 0)].norm()));
        }
    }
    ratios.sort_by(f64::total_cmp);
    let middle = ratios.get(ratios.len() / 2).copied().unwrap_or_default();
    Ok(middle > 1.0 + 2.0 * GAP_FLOOR)
}
