//! Sizes of channels and states that do not depend on units: what a control does to the errors, what the disturbances
//! do to a measurement, how far inputs move a state and how far a state shows. Gains are the largest on s = ω
//! e^{jπ/3}, a ray away from undamped poles, over the frequencies of the poles.

use crate::augment::GeneralizedPlant;
use crate::linalg::{Mat, c64, max_singular_value_complex};
use crate::lti::connect::{stack_cols, stack_rows};
use crate::lti::responder::FrequencyResponder;
use crate::lti::response::even_in_logarithm;
use crate::lti::{Continuous, StateSpace};
use std::f64::consts::FRAC_PI_3;

/// Poles closer to the origin than this share of the entries of A are integrators: rounding of a triple one.
const INTEGRATOR: f64 = 1e-6;
/// Frequencies between the slowest and the fastest pole, besides those of the poles.
const BETWEEN: usize = 40;
/// A gain below this share of the product of its factors is the rounding of zero.
const ZERO: f64 = 1e-12;

/// Sizes in the units of each channel and state.
#[derive(Clone, Debug)]
pub(super) struct ChannelUnits {
    /// Gain from the disturbances to the errors.
    pub errors: f64,
    /// Gain from each control to the errors.
    pub controls: Vec<f64>,
    /// Gain from the disturbances to each measurement.
    pub measurements: Vec<f64>,
    /// Gain from the inputs to each state, the disturbances at one.
    pub reached: Vec<f64>,
    /// Gain from each state to the outputs, the errors at one.
    pub seen: Vec<f64>,
}

/// Largest magnitudes over the points: of [C; I](sI − A)⁻¹[B I] + D, and the gain from w to z.
struct LargestGains {
    magnitudes: Mat<f64>,
    errors: f64,
}

impl ChannelUnits {
    /// Sizes of a plant; none when its poles cannot be computed.
    pub(super) fn new(plant: &GeneralizedPlant) -> Option<Self> {
        let s = &plant.system;
        let (n, m, p) = (s.order(), s.inputs(), s.outputs());
        let (m1, p1) = (plant.disturbances(), plant.errors());
        let largest = LargestGains::new(plant)?;
        let at = |i: usize, j: usize| largest.magnitudes[(i, j)];
        let column = |j: usize, rows: std::ops::Range<usize>| rows.map(|i| at(i, j).powi(2)).sum::<f64>().sqrt();
        let row = |i: usize, cols: std::ops::Range<usize>| cols.map(|j| at(i, j).powi(2)).sum::<f64>().sqrt();
        let errors = if largest.errors > 0.0 { largest.errors } else { 1.0 };
        let (c1, b1) = (s.c.subrows(0, p1).norm_l2(), s.b.subcols(0, m1).norm_l2());
        // What counts as zero is measured by the states between the two ends.
        let clean = |gain: f64, size: f64| if gain > ZERO * size { gain } else { 0.0 };
        let controls = (m1..m).map(|j| clean(column(j, 0..p1), c1 * column(j, p..p + n)));
        let measurements = (p1..p).map(|i| clean(row(i, 0..m1), b1 * row(i, m..m + n)));
        let (mut controls, mut measurements): (Vec<f64>, Vec<f64>) = (controls.collect(), measurements.collect());
        // A control that reaches no error counts by the measurements that it reaches, and the reverse.
        for j in 0..controls.len() {
            let sizes = (0..measurements.len()).filter(|i| measurements[*i] > 0.0);
            let through = sizes.map(|i| at(p1 + i, m1 + j) / measurements[i] * errors).fold(0.0, f64::max);
            if controls[j] == 0.0 {
                controls[j] = if through > 0.0 { through } else { 1.0 };
            }
        }
        for i in 0..measurements.len() {
            let through = (0..controls.len()).map(|j| at(p1 + i, m1 + j) / controls[j] * errors).fold(0.0, f64::max);
            if measurements[i] == 0.0 {
                measurements[i] = if through > 0.0 { through } else { 1.0 };
            }
        }
        let or_one = |x: f64| if x > 0.0 && x.is_finite() { x } else { 1.0 };
        let by_controls = |i: usize| {
            let parts = controls.iter().enumerate().map(|(j, unit)| (at(i, m1 + j) / unit * errors).powi(2));
            parts.sum::<f64>().sqrt()
        };
        let by_measurements = |j: usize| {
            let parts = measurements.iter().enumerate().map(|(i, unit)| (at(p1 + i, j) / unit * errors).powi(2));
            parts.sum::<f64>().sqrt()
        };
        let reached = (p..p + n).map(|i| or_one(row(i, 0..m1).max(by_controls(i)))).collect();
        let seen = (m..m + n).map(|j| or_one(column(j, 0..p1).max(by_measurements(j)))).collect();
        Some(Self { errors, controls, measurements, reached, seen })
    }
}

impl LargestGains {
    fn new(plant: &GeneralizedPlant) -> Option<Self> {
        let s = &plant.system;
        let (n, m, p) = (s.order(), s.inputs(), s.outputs());
        let (m1, p1) = (plant.disturbances(), plant.errors());
        let states = Mat::identity(n, n);
        let whole = StateSpace {
            a: s.a.clone(),
            b: stack_cols(&s.b, &states),
            c: stack_rows(&s.c, &states),
            d: Mat::from_fn(p + n, m + n, |i, j| if i < p && j < m { s.d[(i, j)] } else { 0.0 }),
            time: Continuous,
        };
        let responder = FrequencyResponder::new(&whole);
        let mut found = Self { magnitudes: Mat::zeros(p + n, m + n), errors: 0.0 };
        for omega in frequencies(s)? {
            let response = responder.transfer(c64::from_polar(omega, FRAC_PI_3));
            // An unstable pole may lie on the ray.
            if !response.is_all_finite() {
                continue;
            }
            for j in 0..m + n {
                for i in 0..p + n {
                    found.magnitudes[(i, j)] = found.magnitudes[(i, j)].max(response[(i, j)].norm());
                }
            }
            let own = response.submatrix(0, 0, p1, m1).to_owned();
            found.errors = found.errors.max(max_singular_value_complex(&own));
        }
        Some(found)
    }
}

/// Frequencies of the poles, integrators aside, and between them, rad/s.
fn frequencies(system: &StateSpace<Continuous>) -> Option<Vec<f64>> {
    let size = system.a.norm_max();
    let poles = system.poles().ok()?;
    let mut list: Vec<f64> = poles.iter().map(|p| p.norm()).filter(|w| *w > INTEGRATOR * size).collect();
    if list.is_empty() {
        // Integrators alone, or no state at all.
        list.push(if size > 0.0 { size } else { 1.0 });
    }
    let (lo, hi) = (list.iter().copied().fold(f64::INFINITY, f64::min), list.iter().copied().fold(0.0, f64::max));
    if hi > lo {
        list.extend(even_in_logarithm(lo, hi, BETWEEN));
    }
    Some(list)
}
