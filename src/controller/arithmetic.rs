//! The firmware's arithmetic, bit for bit: float32 (multiply, round, add, round, in row order, no fused
//! multiply-add) and Q31 (32-bit fractions in ±1, coefficients with a post shift per row, 64-bit sums).
//! Q31 row: coefficients qⱼ = round(cⱼ·2^(31−s)), s the least shift with Σ|qⱼ| ≤ 2³¹, so that the sum of
//! products of 32-bit values never leaves 64 bits; result = (Σ qⱼ vⱼ + 2^(30−s)) >> (31−s), saturated.
//! Q31: states, signals and outputs saturate at ±1. Float32: outputs at their limit, and those states at ±1 that would
//! wind up or do not decay, and conditioned ones while an output is limited (see [`super::anti_windup`]); a sample that
//! is not a finite number leaves the last valid one of its channel in place.

use super::ControllerError;
use super::anti_windup::correct_f32;
use super::realise::{ProductTerm, Realisation, Row};
use super::scaling::{ScaledRealisation, rescale_signals};

/// Full scale of Q31, 2³¹.
const Q31_ONE: f64 = 2_147_483_648.0;

/// An output, before its limit, beyond this many times what states and inputs within their ranges can give does not
/// come from operation: memory was never set, or was overwritten.
const GUARD: f64 = 1024.0;

/// The rows with single-precision coefficients, and one instance of the controller.
#[derive(Clone, Debug)]
pub struct Float32Program {
    /// Scaled rows; coefficients are exactly representable in single precision.
    pub rows: Realisation,
    /// Input clamp, m.
    pub input_limit_m: f32,
    /// Output clamp, A.
    pub output_limit_a: f32,
    /// Outputs before their limit beyond this, A, restart the controller.
    pub output_guard_a: f32,
    /// States that are clamped at ±1.
    pub clamped: Vec<bool>,
    /// Rows of the anti-windup gain L, one a state, exactly representable in single precision.
    pub conditioning: Vec<Row>,
    excess_a: Vec<f32>,
    state: Vec<f32>,
    input_m: Vec<f32>,
    signal: Vec<f32>,
}

/// Single-precision program of a scaled realisation, states at zero.
///
/// # Errors
/// [`ControllerError::Range`] when a coefficient overflows single precision.
pub fn float32(scaled: &ScaledRealisation) -> Result<Float32Program, ControllerError> {
    let rows = scaled.rows.map_coefficients(|c| f64::from(c as f32));
    if let Some(bad) = rows.rows().flatten().find(|term| !term.coefficient.is_finite()) {
        return Err(ControllerError::Range {
            what: "coefficient".to_owned(),
            value: bad.coefficient,
            format: "float32",
            advice: "check the units of the controller: metres in, amperes out",
        });
    }
    Ok(Float32Program {
        state: vec![0.0; rows.order()],
        input_m: vec![0.0; rows.inputs],
        signal: vec![0.0; rows.signals.len()],
        clamped: scaled.clamped.clone(),
        conditioning: single(&scaled.conditioning),
        excess_a: vec![0.0; rows.outputs.len()],
        rows,
        input_limit_m: scaled.limits.input_m as f32,
        output_limit_a: scaled.limits.output_a as f32,
        output_guard_a: (GUARD * scaled.output_reach_a.max(scaled.limits.output_a)) as f32,
    })
}

impl Float32Program {
    /// One sample: currents (A) from displacements (m); advances the state.
    pub fn step(&mut self, y: &[f32]) -> Vec<f32> {
        let u = self.output(y);
        self.update();
        u
    }

    /// First half of a sample: currents (A) from displacements (m). A displacement that is not a finite number is
    /// replaced by the last valid one of its channel. No output is ever NaN.
    pub(crate) fn output(&mut self, y: &[f32]) -> Vec<f32> {
        for (j, held) in self.input_m.iter_mut().enumerate() {
            let sample = y.get(j).copied().unwrap_or(0.0);
            if sample.is_finite() {
                *held = clamp_f32(sample, self.input_limit_m);
            }
        }
        let mut u = self.sums();
        self.excess_a.iter_mut().for_each(|e| *e = 0.0);
        // NaN is within nothing.
        let within = |u: &[f32], limit: f32| u.iter().all(|v| v.abs() <= limit);
        if !within(&u, self.output_limit_a) {
            if !within(&u, self.output_guard_a) {
                self.state.iter_mut().for_each(|x| *x = 0.0);
                u = self.sums();
            }
            for (value, excess) in u.iter_mut().zip(&mut self.excess_a) {
                let wanted = if value.is_nan() { 0.0 } else { *value };
                *value = clamp_f32(wanted, self.output_limit_a);
                *excess = *value - wanted;
            }
        }
        u
    }

    /// Second half of a sample: advances the state, and conditions it while an output is limited.
    pub(crate) fn update(&mut self) {
        let v = self.values();
        let mut next: Vec<f32> = self.rows.states.iter().map(|r| sum_f32(r, &v)).collect();
        correct_f32(&mut next, &self.conditioning, &self.excess_a);
        let limited = self.excess_a.iter().any(|e| *e != 0.0);
        for (i, x) in next.iter_mut().enumerate() {
            if self.clamped[i] || (limited && !self.conditioning[i].is_empty()) {
                *x = clamp_f32(*x, 1.0);
            }
        }
        self.state = next;
    }

    /// Signals, which are kept for [`Self::update`], and outputs before their limit.
    fn sums(&mut self) -> Vec<f32> {
        let mut v = self.state.clone();
        v.extend(&self.input_m);
        for row in &self.rows.signals {
            let value = sum_f32(row, &v);
            v.push(value);
        }
        self.signal = v.split_off(self.state.len() + self.input_m.len());
        let v = self.values();
        self.rows.outputs.iter().map(|r| sum_f32(r, &v)).collect()
    }

    fn values(&self) -> Vec<f32> {
        [&self.state[..], &self.input_m, &self.signal].concat()
    }
}

/// Rows with coefficients that single precision holds.
fn single(rows: &[Row]) -> Vec<Row> {
    let round = |term: &ProductTerm| ProductTerm { coefficient: f64::from(term.coefficient as f32), ..*term };
    rows.iter().map(|row| row.iter().map(round).collect()).collect()
}

/// Products are rounded one by one and added in row order.
fn sum_f32(row: &Row, v: &[f32]) -> f32 {
    row.iter().map(|term| term.coefficient as f32 * v[term.source]).reduce(|sum, product| sum + product).unwrap_or(0.0)
}

fn clamp_f32(value: f32, limit: f32) -> f32 {
    if value > limit {
        limit
    } else if value < -limit {
        -limit
    } else {
        value
    }
}

/// One Q31 row: integer coefficients and the right shift that brings the sum back to Q31.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FixedRow {
    /// (index into [x; y; t], coefficient).
    pub terms: Vec<(usize, i32)>,
    /// Right shift of the 64-bit sum, 1 … 62.
    pub shift: u32,
}

/// The rows in Q31.
#[derive(Clone, Debug)]
pub struct Q31Program {
    /// Intermediate signals.
    pub signals: Vec<FixedRow>,
    /// Outputs.
    pub outputs: Vec<FixedRow>,
    /// Next states.
    pub states: Vec<FixedRow>,
    /// Rows of the anti-windup gain L, one a state: conditioned states from the excess of the outputs.
    pub conditioning: Vec<FixedRow>,
    /// The excess is held in units of 2 to this power of the full scale, so that it fits.
    pub excess_shift: u32,
    /// Number of inputs.
    pub inputs: usize,
    /// Displacement at full scale, m.
    pub input_full_scale_m: f64,
    /// Current at full scale, A.
    pub output_full_scale_a: f64,
    exact: Realisation,
    state: Vec<i32>,
    input: Vec<i32>,
    signal: Vec<i32>,
    excess: Vec<i32>,
}

/// Q31 program of a scaled realisation, states at zero.
///
/// # Errors
/// [`ControllerError::Range`] when a row needs coefficients beyond 2³⁰ in normalised units.
pub fn q31(scaled: &ScaledRealisation) -> Result<Q31Program, ControllerError> {
    let ones = |count: usize| vec![1.0; count];
    let exact = rescale_signals(
        &scaled.rows,
        &ones(scaled.rows.order()),
        &ones(scaled.rows.signals.len()),
        scaled.limits.input_m,
        scaled.limits.output_a,
    );
    let rows = |list: &[Row]| -> Result<Vec<FixedRow>, ControllerError> { list.iter().map(to_fixed_row).collect() };
    // |u − v| is at most the reach of v, in full scales.
    let excess_shift = (scaled.output_reach_a / scaled.limits.output_a).max(1.0).log2().ceil() as u32;
    let unit_a = scaled.limits.output_a * f64::from(excess_shift).exp2();
    let conditioning: Vec<Row> = scaled
        .conditioning
        .iter()
        .map(|row| {
            let in_units = |t: &ProductTerm| ProductTerm { coefficient: t.coefficient * unit_a, ..*t };
            row.iter().map(in_units).collect()
        })
        .collect();
    Ok(Q31Program {
        conditioning: rows(&conditioning)?,
        excess_shift,
        excess: vec![0; exact.outputs.len()],
        signals: rows(&exact.signals)?,
        outputs: rows(&exact.outputs)?,
        states: rows(&exact.states)?,
        inputs: exact.inputs,
        input_full_scale_m: scaled.limits.input_m,
        output_full_scale_a: scaled.limits.output_a,
        state: vec![0; exact.order()],
        input: vec![0; exact.inputs],
        signal: vec![0; exact.signals.len()],
        exact,
    })
}

pub(super) fn to_fixed_row(row: &Row) -> Result<FixedRow, ControllerError> {
    let sum: f64 = row.iter().map(|t| t.coefficient.abs()).sum();
    // Rounding may add half a unit a term; the shift must leave room for it.
    let exponent = if sum > 0.0 { sum.log2().ceil() as i32 } else { -31 };
    for s in exponent.max(-31)..=30 {
        let factor = f64::from(31 - s).exp2();
        let terms: Vec<(usize, f64)> = row.iter().map(|t| (t.source, (t.coefficient * factor).round())).collect();
        let total: f64 = terms.iter().map(|t| t.1.abs()).sum();
        let largest = terms.iter().map(|t| t.1.abs()).fold(0.0, f64::max);
        if total <= Q31_ONE && largest < Q31_ONE {
            return Ok(FixedRow {
                terms: terms.into_iter().map(|t| (t.0, t.1 as i32)).collect(),
                shift: (31 - s) as u32,
            });
        }
    }
    Err(ControllerError::Range {
        what: "sum of coefficients of a row".to_owned(),
        value: sum,
        format: "Q31 with a post shift of up to 2^30",
        advice: "use float32, or raise the current limit that is full scale",
    })
}

impl Q31Program {
    /// One sample: currents (fraction of full scale, Q31) from displacements (Q31); advances the state.
    pub fn step(&mut self, y: &[i32]) -> Vec<i32> {
        let u = self.output(y);
        self.update();
        u
    }

    /// First half of a sample: currents from displacements.
    pub(crate) fn output(&mut self, y: &[i32]) -> Vec<i32> {
        for (j, held) in self.input.iter_mut().enumerate() {
            *held = saturate(i64::from(y.get(j).copied().unwrap_or(0)));
        }
        let mut v = [&self.state[..], &self.input].concat();
        for row in &self.signals {
            let value = sum_q31(row, &v);
            v.push(value);
        }
        self.signal = v.split_off(self.state.len() + self.input.len());
        let v = self.values();
        let wanted: Vec<i64> = self.outputs.iter().map(|row| rounded_sum(row, &v)).collect();
        let u: Vec<i32> = wanted.iter().map(|v| saturate(*v)).collect();
        let half = (1i64 << self.excess_shift) >> 1;
        self.excess =
            u.iter().zip(&wanted).map(|(u, v)| saturate((i64::from(*u) - v + half) >> self.excess_shift)).collect();
        u
    }

    /// Second half of a sample: advances the state, and conditions it while an output is limited.
    pub(crate) fn update(&mut self) {
        let v = self.values();
        self.state = self
            .states
            .iter()
            .zip(&self.conditioning)
            .map(|(row, correction)| {
                let next = sum_q31(row, &v);
                saturate(i64::from(next) + rounded_sum(correction, &self.excess))
            })
            .collect();
    }

    fn values(&self) -> Vec<i32> {
        [&self.state[..], &self.input, &self.signal].concat()
    }

    /// A displacement as Q31 integer, rounded to nearest, saturated.
    pub fn encode_input(&self, displacement_m: f64) -> i32 {
        let scaled = (displacement_m / self.input_full_scale_m * Q31_ONE).round();
        // The cast saturates; ±(2³¹ − 1) is the symmetric range.
        saturate(scaled as i64)
    }

    /// A displacement in metres from its Q31 integer.
    pub fn decode_input(&self, value: i32) -> f64 {
        f64::from(value) / Q31_ONE * self.input_full_scale_m
    }

    /// A current in amperes from its Q31 integer.
    pub fn decode_output(&self, value: i32) -> f64 {
        f64::from(value) / Q31_ONE * self.output_full_scale_a
    }

    /// The linear system with its coefficients as Q31 holds them, physical units (m in, A out), for verification.
    ///
    /// # Errors
    /// [`ControllerError::Numeric`] for coefficients that are not finite.
    pub fn to_rounded_system(&self) -> Result<crate::lti::StateSpace<crate::lti::Discrete>, ControllerError> {
        let held = self.held();
        let ones = |count: usize| vec![1.0; count];
        rescale_signals(
            &held,
            &ones(held.order()),
            &ones(held.signals.len()),
            1.0 / self.input_full_scale_m,
            1.0 / self.output_full_scale_a,
        )
        .to_state_space()
    }

    /// Coefficients as held, in normalised units.
    fn held(&self) -> Realisation {
        let rows = |exact: &[Row], fixed: &[FixedRow]| -> Vec<Row> {
            exact
                .iter()
                .zip(fixed)
                .map(|(row, fixed)| {
                    let unit = -f64::from(fixed.shift);
                    row.iter()
                        .zip(&fixed.terms)
                        .map(|(term, held)| super::realise::ProductTerm {
                            source: term.source,
                            coefficient: f64::from(held.1) * unit.exp2(),
                        })
                        .collect()
                })
                .collect()
        };
        Realisation {
            signals: rows(&self.exact.signals, &self.signals),
            outputs: rows(&self.exact.outputs, &self.outputs),
            states: rows(&self.exact.states, &self.states),
            blocks: self.exact.blocks.clone(),
            notes: self.exact.notes.clone(),
            ..self.exact
        }
    }

    /// Bound on |u_Q31 − u_exact| (A) over the first `samples` samples from rest, while nothing saturates, against
    /// exact arithmetic with exact coefficients: each row errs by at most half a unit of rounding plus Σ|Δc| (all
    /// values are within ±1), and an error in a value spreads through the exact system by its ℓ₁ gain.
    pub fn error_bound_a(&self, samples: usize) -> f64 {
        let held = self.held();
        let half_unit = 0.5 / Q31_ONE;
        let row_error = |exact: &Row, held: &Row| {
            let coefficients: f64 = exact.iter().zip(held).map(|(e, h)| (e.coefficient - h.coefficient).abs()).sum();
            half_unit + coefficients
        };
        let errors = |exact: &[Row], held: &[Row]| -> Vec<f64> {
            exact.iter().zip(held).map(|(e, h)| row_error(e, h)).collect()
        };
        let signals = errors(&self.exact.signals, &held.signals);
        let outputs = errors(&self.exact.outputs, &held.outputs);
        let states = errors(&self.exact.states, &held.states);
        let (n, m) = (self.exact.order(), self.inputs);
        // Injection points: every state, every signal; the response of the outputs to a unit injected once.
        let mut total = outputs;
        for (point, size) in (0..n).map(|i| (i, states[i])).chain((0..signals.len()).map(|k| (n + m + k, signals[k]))) {
            let mut state = vec![0.0; n];
            let mut injected = Some(point);
            if point < n {
                state[point] = 1.0;
                injected = None;
            }
            for _ in 0..samples {
                let mut v = state.clone();
                v.extend(std::iter::repeat_n(0.0, m));
                for (k, row) in self.exact.signals.iter().enumerate() {
                    let mut value = sum_f64(row, &v);
                    if injected == Some(n + m + k) {
                        value += 1.0;
                    }
                    v.push(value);
                }
                injected = None;
                for (bound, row) in total.iter_mut().zip(&self.exact.outputs) {
                    *bound += size * sum_f64(row, &v).abs();
                }
                state = self.exact.states.iter().map(|r| sum_f64(r, &v)).collect();
            }
        }
        total.into_iter().fold(0.0, f64::max) * self.output_full_scale_a
    }
}

fn sum_f64(row: &Row, v: &[f64]) -> f64 {
    row.iter().map(|t| t.coefficient * v[t.source]).sum()
}

fn sum_q31(row: &FixedRow, v: &[i32]) -> i32 {
    saturate(rounded_sum(row, v))
}

/// The sum of a row, rounded and shifted, not yet saturated; zero for an empty row.
fn rounded_sum(row: &FixedRow, v: &[i32]) -> i64 {
    let sum =
        row.terms.iter().fold(0i64, |sum, (source, coefficient)| sum + i64::from(*coefficient) * i64::from(v[*source]));
    (sum + (1i64 << (row.shift - 1))) >> row.shift
}

fn saturate(value: i64) -> i32 {
    let limit = i64::from(i32::MAX);
    value.clamp(-limit, limit) as i32
}
