//! Peak over all frequencies of a function σ(ω) whose level sets are the imaginary eigenvalues of a Hamiltonian
//! H(γ): jω is an eigenvalue of H(γ) exactly when γ is a singular value of the underlying matrix at ω
//! (Boyd, Balakrishnan and Kabamba 1989; Bruinsma and Steinbuch 1990).
//! The lower bound is attained at a frequency; the upper bound is a level without a crossing.
//! Eigenvalues near the axis are all taken as crossings: more of them cost an evaluation each and hide nothing.

use super::line_maximum::LineMaximum;
use crate::linalg::{Mat, NumericError, c64, eigenvalues};

/// Peak with both bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Peak {
    /// Largest value found.
    pub lower: f64,
    /// Where, rad/s; infinity for s = ∞.
    pub omega_rad_s: f64,
    /// Level without a crossing.
    pub upper: f64,
}

/// Level steps allowed; convergence is quadratic, five are usual.
const STEPS: usize = 60;

/// Peak of `value` (0 ≤ ω ≤ ∞) starting from `seeds`, places with their values; `hamiltonian` gives H(γ), or none when
/// the level is singular.
pub(crate) fn peak(
    value: &dyn Fn(f64) -> f64,
    seeds: &[(f64, f64)],
    floor: f64,
    hamiltonian: &dyn Fn(f64) -> Result<Mat<f64>, NumericError>,
    rel_tol: f64,
) -> Result<Peak, NumericError> {
    let mut best = Peak { lower: floor, omega_rad_s: 0.0, upper: f64::INFINITY };
    let take = |(omega, v): (f64, f64), best: &mut Peak| {
        if v > best.lower {
            best.lower = v;
            best.omega_rad_s = omega;
        }
    };
    for seed in seeds {
        take(*seed, &mut best);
    }
    let try_at = |omega: f64, best: &mut Peak| take((omega, value(omega)), best);
    for _ in 0..STEPS {
        // Local climb first: a level at the top of the known peak leaves only other peaks to find.
        climb(value, &mut best);
        if !best.lower.is_finite() {
            return Err(NumericError::NotFinite { what: "peak gain" });
        }
        let level = best.lower * (1.0 + 2.0 * rel_tol);
        let crossings = crossings(&eigenvalues(&hamiltonian(level)?)?);
        let before = best.lower;
        for pair in crossings.windows(2) {
            try_at(0.5 * (pair[0] + pair[1]), &mut best);
        }
        for omega in &crossings {
            try_at(*omega, &mut best);
        }
        if let Some(last) = crossings.last() {
            try_at(2.0 * last, &mut best);
        }
        if best.lower <= before * (1.0 + rel_tol) {
            if best.lower > before {
                climb(value, &mut best);
            }
            best.upper = level.max(best.lower * (1.0 + rel_tol));
            return Ok(best);
        }
    }
    Err(NumericError::NoConvergence { what: "peak gain by level sets", iterations: STEPS, residual: best.lower })
}

/// Frequencies of the eigenvalues on the axis to within rounding, ascending: where a level may be met that the gain
/// stays clear of or crosses steeply. Narrower than what [`peak`] looks at, which also climbs.
pub(crate) fn axis_frequencies(values: &[c64]) -> Vec<f64> {
    // Rounding moves a crossing by ε‖H‖ over the slope there, a touching one by the root of that.
    near_axis(values, 1e-4, 1e-11)
}

/// Frequencies of the eigenvalues near the axis, ascending.
fn crossings(values: &[c64]) -> Vec<f64> {
    // Rounding moves a simple crossing by ε‖H‖·cond, a double one by its root: far below both margins.
    near_axis(values, 1e-2, 1e-9)
}

/// Imaginary parts ≥ 0, ascending, of the values whose real part is below a share of the imaginary one, or of the
/// largest modulus.
fn near_axis(values: &[c64], of_own: f64, of_largest: f64) -> Vec<f64> {
    let size = values.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let is_near = |v: &&c64| v.im >= 0.0 && (v.re.abs() <= of_own * v.im || v.re.abs() <= of_largest * size);
    let mut list: Vec<f64> = values.iter().filter(is_near).map(|v| v.im).collect();
    list.sort_by(f64::total_cmp);
    list
}

/// Climb round the best frequency, in a bracket that grows while the value rises.
fn climb(value: &dyn Fn(f64) -> f64, best: &mut Peak) {
    let centre = best.omega_rad_s;
    if !(centre.is_finite() && centre > 0.0) {
        return;
    }
    // A relative step that is small against the width of a peak of damping 1e-4, then doubled up to an octave.
    let mut step = 1e-5 * centre;
    let (mut lo, mut hi) = (centre - step, centre + step);
    let (mut at_lo, mut at_hi) = (value(lo), value(hi));
    for _ in 0..16 {
        if at_lo <= best.lower && at_hi <= best.lower {
            break;
        }
        step *= 2.0;
        if at_lo > best.lower {
            (hi, at_hi) = (best.omega_rad_s, best.lower);
            (best.lower, best.omega_rad_s) = (at_lo, lo);
            lo -= step;
            at_lo = value(lo);
        } else {
            (lo, at_lo) = (best.omega_rad_s, best.lower);
            (best.lower, best.omega_rad_s) = (at_hi, hi);
            hi += step;
            at_hi = value(hi);
        }
        if lo <= 0.0 {
            return;
        }
    }
    // The value is quadratic in the offset: a bracket of 1e-9 leaves nothing to gain.
    let points = [(lo, at_lo), (best.omega_rad_s, best.lower), (hi, at_hi)];
    let mut search = LineMaximum::new(points, 2.5e-10 * hi);
    for _ in 0..48 {
        let Some(omega) = search.next() else { break };
        search.add(omega, value(omega));
    }
    (best.omega_rad_s, best.lower) = search.best();
}
