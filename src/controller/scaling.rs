//! Scaling by L∞ gains: the largest value that any input within its limit can ever drive a state or signal to,
//! |x|∞ ≤ Σₖ Σⱼ |(Aᵏ B)ᵢⱼ| ŷⱼ, becomes (at most) one, so fixed point never overflows in linear operation and
//! clamping at ±1 acts only when something is wrong. Scales are powers of two, which rounds nothing.
//! Slow real poles (integrators, leaky or not) are the exception: their range is the output authority, so the clamp at
//! ±1 is their anti-windup. With the correction of [`super::anti_windup`] states reach further than without;
//! `with_room` gives them the range.
//! Source: Jackson, Bell Syst. Tech. J. 49 (1970) 159, the ℓ₁ bound. Symbols: ŷ input limit, û output limit.

use super::ControllerError;
use super::realise::{ProductTerm, Realisation, Row};
use crate::linalg::Mat;
use crate::lti::{Discrete, StateSpace};
use crate::spindle::Machine;
use crate::spindle::machine::Side;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// A real pole below this frequency winds up under saturation and is held to the output authority.
const WINDUP_CORNER_HZ: f64 = 10.0;
/// Terms of the ℓ₁ sum at most: 26 s at 20 kHz. What has not decayed by then is treated as an integrator.
const LONGEST_SUM: usize = 1 << 19;
/// The sum ends when the state has decayed to this part of its peak: the tail is below the doubling by rounding up.
const DECAYED: f64 = 1e-5;

/// Ranges of the signals at the edge of the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignalLimits {
    /// Largest |y|, m: samples beyond are clamped; full scale of fixed point.
    pub input_m: f64,
    /// Largest |u|, A: the output clamp; full scale of fixed point.
    pub output_a: f64,
}

impl SignalLimits {
    /// Full scales of a machine: the backup clearance, and the current that keeps both coils of the weaker bearing in
    /// their range.
    pub fn of(machine: &Machine) -> Self {
        let current = Side::ALL
            .into_iter()
            .map(|side| {
                let bearing = machine.spindle.bearing(side);
                let range = bearing.max_current_a - bearing.bias_current_a;
                bearing.bias_current_a.min(range)
            })
            .fold(f64::INFINITY, f64::min);
        Self { input_m: machine.spindle.backup_clearance_m, output_a: current }
    }
}

/// A realisation whose states and signals stay within ±1, with the scales that did it.
#[derive(Clone, Debug)]
pub struct ScaledRealisation {
    /// Rows in scaled states and signals, physical inputs (m) and outputs (A).
    pub rows: Realisation,
    /// Edge limits.
    pub limits: SignalLimits,
    /// Physical value of a state at ±1.
    pub state_scale: Vec<f64>,
    /// Physical value of a signal at ±1.
    pub signal_scale: Vec<f64>,
    /// True for states whose clamp is the anti-windup limit.
    pub anti_windup: Vec<bool>,
    /// Rows of L of [`super::anti_windup`], one a state; a term's source is the output, its coefficient scaled state
    /// per A. Empty rows: the state is not conditioned.
    pub conditioning: Vec<Row>,
    /// True for states that float32 holds within ±1: those of `anti_windup` and those that do not decay. All others
    /// stay within ±1 by themselves, because the input is clamped.
    pub clamped: Vec<bool>,
    /// Largest |u|, A, before its limit, with states within ±1 and inputs within their limit.
    pub output_reach_a: f64,
}

/// Nonzero coefficients of every row of A.
fn transition_rows(a: &Mat<f64>) -> Vec<Row> {
    let n = a.nrows();
    let row = |i: usize| {
        let terms = (0..n).filter(|j| a[(i, *j)] != 0.0).map(|j| ProductTerm { source: j, coefficient: a[(i, j)] });
        terms.collect()
    };
    (0..n).map(row).collect()
}

/// Scales states and signals of a realisation to ±1.
///
/// # Errors
/// [`ControllerError::Range`] when a limit is not positive or a gain is not finite.
pub fn scale_realisation(
    realisation: &Realisation,
    limits: SignalLimits,
) -> Result<ScaledRealisation, ControllerError> {
    for (what, value) in [("input limit, m,", limits.input_m), ("output limit, A,", limits.output_a)] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(range(what.to_owned(), value));
        }
    }
    let system = realisation.to_state_space()?;
    let (n, m) = (realisation.order(), realisation.inputs);
    let transitions = transition_rows(&system.a);
    let maps = realisation.signal_maps();
    let gains = l1_gains(&transitions, &maps, &system.b, limits.input_m);
    let authority = |i: usize| {
        let largest = (0..system.outputs()).map(|k| system.c[(k, i)].abs()).fold(0.0, f64::max);
        limits.output_a / largest
    };
    let slow = 1.0 - TAU * WINDUP_CORNER_HZ * realisation.sample_time_s;
    let (mut state_scale, mut anti_windup) = (Vec::new(), Vec::new());
    let clamped = |anti_windup: &[bool]| -> Vec<bool> {
        let decays = gains.states.iter().map(Option::is_some);
        anti_windup.iter().zip(decays).map(|(held, decays)| *held || !decays).collect()
    };
    for i in 0..n {
        let own = transitions[i].iter().find(|t| t.source == i);
        let alone = transitions.iter().enumerate().all(|(k, row)| k == i || row.iter().all(|t| t.source != i))
            && transitions[i].iter().all(|t| t.source == i);
        let winds_up = alone && own.is_some_and(|t| t.coefficient >= slow);
        let limit = authority(i);
        if (winds_up || gains.states[i].is_none()) && limit.is_finite() && limit > 0.0 {
            // A state that does not decay at all but is no plain integrator gets room to swing past its limit.
            let bound = if winds_up { limit } else { 4.0 * limit };
            let bound = gains.states[i].map_or(bound, |gain| gain.min(bound));
            state_scale.push(if winds_up { bound } else { power_of_two(bound) });
            anti_windup.push(winds_up);
        } else {
            state_scale.push(power_of_two(gains.states[i].unwrap_or(1.0)));
            anti_windup.push(false);
        }
    }
    let signal_scale: Vec<f64> = (0..maps.len())
        .map(|k| {
            // Without a finite gain: what the scaled states and inputs can add up to.
            let reach = || {
                (0..n).map(|j| maps[k][j].abs() * state_scale[j]).sum::<f64>()
                    + (0..m).map(|j| maps[k][n + j].abs() * limits.input_m).sum::<f64>()
            };
            power_of_two(gains.signals[k].unwrap_or_else(reach))
        })
        .collect();
    if let Some(bad) = state_scale.iter().chain(&signal_scale).find(|s| !(s.is_finite() && **s > 0.0)) {
        return Err(range("state scale".to_owned(), *bad));
    }
    let rows = rescale_signals(realisation, &state_scale, &signal_scale, 1.0, 1.0);
    let output_reach_a = output_reach_a(&rows.to_state_space()?, limits);
    Ok(ScaledRealisation {
        rows,
        limits,
        conditioning: vec![Row::new(); state_scale.len()],
        state_scale,
        signal_scale,
        clamped: clamped(&anti_windup),
        output_reach_a,
        anti_windup,
    })
}

/// Largest |u| of scaled states and inputs at their limits, A.
fn output_reach_a(scaled: &StateSpace<Discrete>, limits: SignalLimits) -> f64 {
    (0..scaled.outputs())
        .map(|i| {
            let states = (0..scaled.order()).map(|j| scaled.c[(i, j)].abs());
            let inputs = (0..scaled.inputs()).map(|j| scaled.d[(i, j)].abs() * limits.input_m);
            states.sum::<f64>() + inputs.sum::<f64>()
        })
        .fold(0.0, f64::max)
}

/// Scales for the anti-windup x⁺ = (A − LC)x + (B − LD)y + Lu besides: no |y| ≤ ŷ with any |u| ≤ û drives a state or
/// signal beyond ±1 then, so that the clamp at ±1 does not interfere with the correction. States whose clamp is their
/// anti-windup keep their scale. `gain` is L in scaled states per A; `conditioning` of the result is in the new scales.
pub(super) fn with_room(scaled: ScaledRealisation, gain: &Mat<f64>) -> Result<ScaledRealisation, ControllerError> {
    let system = scaled.rows.to_state_space()?;
    let (n, m) = (system.order(), system.inputs());
    let corrected = &system.a - gain * &system.c;
    let transitions = transition_rows(&corrected);
    let maps = scaled.rows.signal_maps();
    let without_inputs: Vec<Vec<f64>> =
        maps.iter().map(|map| map[..n].iter().copied().chain(vec![0.0; m]).collect()).collect();
    let of_y = l1_gains(&transitions, &maps, &(&system.b - gain * &system.d), scaled.limits.input_m);
    let of_u = l1_gains(&transitions, &without_inputs, gain, scaled.limits.output_a);
    // A sum that does not converge, of a mode that L leaves alone, gives no more room than before.
    let factor = |y: Option<f64>, u: Option<f64>| match (y, u) {
        (Some(y), Some(u)) => power_of_two(y + u).max(1.0),
        _ => 1.0,
    };
    let states: Vec<f64> =
        (0..n).map(|i| if scaled.anti_windup[i] { 1.0 } else { factor(of_y.states[i], of_u.states[i]) }).collect();
    let signals: Vec<f64> = (0..maps.len()).map(|k| factor(of_y.signals[k], of_u.signals[k])).collect();
    let rows = rescale_signals(&scaled.rows, &states, &signals, 1.0, 1.0);
    let times = |old: &[f64], by: &[f64]| old.iter().zip(by).map(|(s, f)| s * f).collect();
    Ok(ScaledRealisation {
        output_reach_a: output_reach_a(&rows.to_state_space()?, scaled.limits),
        state_scale: times(&scaled.state_scale, &states),
        signal_scale: times(&scaled.signal_scale, &signals),
        conditioning: (0..n)
            .map(|i| {
                let term = |j: usize| ProductTerm { source: j, coefficient: gain[(i, j)] / states[i] };
                let all = (0..gain.ncols()).map(term);
                all.filter(|t| t.coefficient != 0.0).collect()
            })
            .collect(),
        rows,
        ..scaled
    })
}

/// The rows in units of the given scales: coefficient · scale(source)/scale(target).
pub(super) fn rescale_signals(
    realisation: &Realisation,
    states: &[f64],
    signals: &[f64],
    input: f64,
    output: f64,
) -> Realisation {
    let n = realisation.order();
    let source = |k: usize| {
        if k < n {
            states[k]
        } else if k < n + realisation.inputs {
            input
        } else {
            signals[k - n - realisation.inputs]
        }
    };
    let rows = |list: &[Row], target: &dyn Fn(usize) -> f64| -> Vec<Row> {
        list.iter()
            .enumerate()
            .map(|(i, row)| {
                row.iter()
                    .map(|t| ProductTerm {
                        source: t.source,
                        coefficient: t.coefficient * source(t.source) / target(i),
                    })
                    .collect()
            })
            .collect()
    };
    Realisation {
        signals: rows(&realisation.signals, &|i| signals[i]),
        outputs: rows(&realisation.outputs, &|_| output),
        states: rows(&realisation.states, &|i| states[i]),
        blocks: realisation.blocks.clone(),
        notes: realisation.notes.clone(),
        ..*realisation
    }
}

struct Gains {
    states: Vec<Option<f64>>,
    signals: Vec<Option<f64>>,
}

/// ℓ₁ bounds of states and signals for inputs within ±`limit`; `None` where the sum did not converge.
fn l1_gains(transitions: &[Row], maps: &[Vec<f64>], b: &Mat<f64>, limit: f64) -> Gains {
    let (n, m) = (transitions.len(), b.ncols());
    let read: Vec<Row> = maps.iter().map(|map| terms(&map[..n])).collect();
    let of_inputs = |first: usize| {
        let input = |i: usize, lane: usize| if first + lane < m { b[(i, first + lane)] * limit } else { 0.0 };
        let start = |i: usize| std::array::from_fn(|lane| input(i, lane));
        let mut sums = impulse_sums::<LANES>(transitions, &read, (0..n).map(start).collect());
        sums.truncate(m - first);
        sums
    };
    let firsts: Vec<usize> = (0..m).step_by(LANES).collect();
    let sums: Vec<Gains> = firsts.into_par_iter().flat_map(of_inputs).collect();
    let total = |first: f64, of: &dyn Fn(&Gains) -> Option<f64>| {
        sums.iter().try_fold(first, |sum, gains| of(gains).map(|own| sum + own))
    };
    let states: Vec<Option<f64>> = (0..n).map(|i| total(0.0, &|g| g.states[i])).collect();
    let signals = maps.iter().enumerate().map(|(k, map)| {
        let direct = map[n..].iter().map(|d| d.abs() * limit).sum();
        // A signal is unbounded when it reads a state that is.
        let bounded = read[k].iter().all(|t| states[t.source].is_some());
        total(direct, &|g| g.signals[k]).filter(|_| bounded)
    });
    Gains { signals: signals.collect(), states }
}

/// Nonzero entries of a row.
fn terms(row: &[f64]) -> Row {
    let all = row.iter().enumerate().map(|(source, coefficient)| ProductTerm { source, coefficient: *coefficient });
    all.filter(|t| t.coefficient != 0.0).collect()
}

/// Inputs whose impulse responses are computed together.
const LANES: usize = 4;

/// The states that some starts can ever reach.
fn list_reached<const K: usize>(transitions: &[Row], starts: &[[f64; K]]) -> Vec<usize> {
    let is_moved = |x: &[f64; K]| x.iter().any(|x| *x != 0.0);
    let mut reached: Vec<bool> = starts.iter().map(is_moved).collect();
    loop {
        let newly = |i: &usize| !reached[*i] && transitions[*i].iter().any(|t| reached[t.source]);
        let more: Vec<usize> = (0..starts.len()).filter(newly).collect();
        if more.is_empty() {
            return (0..starts.len()).filter(|i| reached[*i]).collect();
        }
        more.into_iter().for_each(|i| reached[i] = true);
    }
}

/// Σₖ |x| of the states from each of some starts, and of the signals that read them; no sum where it did not converge.
fn impulse_sums<const K: usize>(transitions: &[Row], read: &[Row], starts: Vec<[f64; K]>) -> Vec<Gains> {
    let n = transitions.len();
    let reached = list_reached(transitions, &starts);
    let product = |row: &Row, x: &[[f64; K]]| {
        let terms = row.iter().map(|t| (t.coefficient, &x[t.source]));
        terms.fold([0.0; K], |sum: [f64; K], (coefficient, x)| std::array::from_fn(|l| sum[l] + coefficient * x[l]))
    };
    let (mut x, mut next) = (starts.clone(), vec![[0.0; K]; n]);
    let (mut states, mut signals) = (vec![[0.0; K]; n], vec![[0.0; K]; read.len()]);
    let (mut peak, mut recent) = (vec![[0.0f64; K]; n], vec![[0.0f64; K]; n]);
    let add = |sum: &mut [f64; K], x: &[f64; K]| {
        *sum = std::array::from_fn(|l| sum[l] + x[l].abs());
    };
    let raise = |largest: &mut [f64; K], x: &[f64; K]| {
        *largest = std::array::from_fn(|l| largest[l].max(x[l].abs()));
    };
    for k in 0..LONGEST_SUM {
        for i in reached.iter().copied() {
            add(&mut states[i], &x[i]);
            raise(&mut recent[i], &x[i]);
        }
        for (signal, row) in signals.iter_mut().zip(read) {
            add(signal, &product(row, &x));
        }
        for i in reached.iter().copied() {
            next[i] = product(&transitions[i], &x);
        }
        std::mem::swap(&mut x, &mut next);
        // Oscillating states pass through zero: judge by the largest of the last 256 samples.
        if k % 256 == 255 {
            for i in reached.iter().copied() {
                raise(&mut peak[i], &recent[i]);
            }
            let bounded = x.iter().flatten().all(|v| v.is_finite() && v.abs() < 1e200);
            if !bounded && K > 1 {
                // One that grows does not end the sums of the others.
                let alone = |l: usize| starts.iter().map(|x| [x[l]]).collect();
                return (0..K).flat_map(|l| impulse_sums::<1>(transitions, read, alone(l))).collect();
            }
            let decayed = reached.iter().all(|i| has_decayed(&recent[*i], &peak[*i]));
            if decayed || !bounded || k + 1 == LONGEST_SUM {
                break;
            }
            recent.fill([0.0; K]);
        }
    }
    // Only what has not decayed is unbounded.
    let sum = |i: usize, l: usize| {
        let decays = !x[i][l].is_nan() && has_decayed(&[recent[i][l]], &[peak[i][l]]);
        decays.then_some(states[i][l])
    };
    (0..K)
        .map(|l| Gains {
            states: (0..n).map(|i| sum(i, l)).collect(),
            signals: signals.iter().map(|sum| Some(sum[l])).collect(),
        })
        .collect()
}

/// True where what was last seen is negligible beside the largest.
fn has_decayed<const K: usize>(recent: &[f64; K], peak: &[f64; K]) -> bool {
    (0..K).all(|l| recent[l] <= DECAYED * peak[l])
}

/// Smallest power of two that is not below `value`; 1 for zero.
fn power_of_two(value: f64) -> f64 {
    if value > 0.0 { value.log2().ceil().exp2() } else { 1.0 }
}

fn range(what: String, value: f64) -> ControllerError {
    ControllerError::Range {
        what,
        value,
        format: "a finite positive range",
        advice: "check the limits and that the controller's states decay",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_inputs_that_are_computed_together_are_those_of_geometric_series() {
        // Each of five inputs moves a state of its own; the fourth grows.
        let poles = [0.5, -0.9, 0.99, 1.1, 0.0];
        let transitions: Vec<Row> =
            (0..5).map(|i| terms(&std::array::from_fn::<f64, 5, _>(|j| poles[i] * f64::from(i == j)))).collect();
        let unit = Mat::from_fn(5, 5, |i, j| f64::from(i == j));
        // One signal reads the first two states, another the one that grows.
        let maps = [[1.0, -2.0, 0.0, 0.0, 0.0, 0.0, 3.0], [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]];
        let maps = maps.map(|map| map.to_vec());
        let found = l1_gains(&transitions, &maps, &unit, 2.0);
        for (pole, sum) in poles.iter().zip(&found.states) {
            let exact = (pole.abs() < 1.0).then(|| 2.0 / (1.0 - pole.abs()));
            match (sum, exact) {
                (Some(sum), Some(exact)) => assert!((sum / exact - 1.0).abs() < 1e-4, "{pole}"),
                (sum, exact) => assert!(sum.is_none() && exact.is_none(), "{pole} {sum:?}"),
            }
        }
        let signal = found.signals[0].expect("it reads states that decay");
        assert!((signal / (4.0 + 2.0 * 20.0 + 6.0) - 1.0).abs() < 1e-4, "{signal}");
        assert!(found.signals[1].is_none());
    }
}
