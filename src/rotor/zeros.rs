//! Antiresonances: zeros of  g(λ) = Σ_k c_k b_k/(ω_k² − λ),  λ = ω², the undamped transfer function of a free-free
//! shaft from a force with modal amplitudes b to a deflection with amplitudes c. They are the finite eigenvalues λ of
//! the pencil [[K − λM, b], [c, 0]].
//!
//! Method: with a shift σ < 0 and F = (Λ − σ)⁻¹, μ = 1/(λ − σ),  g = μ cᵀ(μI − F)⁻¹F b,  so the zeros are the nonzero
//! eigenvalues μ of (I − F b cᵀ/(cᵀF b)) F: the low zeros are the large, well-conditioned μ. Each is then polished by
//! Newton's method on g itself. Complex zeros (of non-collocated pairs) are not antiresonances and are left out.

use super::RotorError;
use super::assembly::Rotor;
use super::modes::PlanarModes;
use crate::linalg::{Mat, eigenvalues};
use std::f64::consts::TAU;

/// Antiresonance frequencies in Hz, ascending, between `from_hz` and `to_hz`.
///
/// # Errors
/// [`RotorError::Numeric`] when the eigenvalue iteration fails.
pub fn zeros_hz(
    omega_rad_s: &[f64],
    force: &[f64],
    deflection: &[f64],
    from_hz: f64,
    to_hz: f64,
) -> Result<Vec<f64>, RotorError> {
    let lambda: Vec<f64> = omega_rad_s.iter().map(|w| w * w).collect();
    let (low, high) = ((TAU * from_hz).powi(2), (TAU * to_hz).powi(2));
    let mut found = vec![];
    // A shift for which cᵀF b happens to vanish would hide a zero: take the one of three that is farthest from that.
    let candidates = [0.3, 1.0, 3.0].map(|f| -(TAU * 300.0 * f).powi(2));
    let direct = |sigma: f64| -> (f64, f64) {
        let (mut sum, mut size) = (0.0, 0.0f64);
        for k in 0..lambda.len() {
            let term = deflection[k] * force[k] / (lambda[k] - sigma);
            sum += term;
            size += term.abs();
        }
        (sum, size)
    };
    let quality = |s: f64| {
        let (sum, size) = direct(s);
        sum.abs() / size.max(f64::MIN_POSITIVE)
    };
    let sigma = candidates.into_iter().fold(candidates[0], |best, s| if quality(s) > quality(best) { s } else { best });
    let (gain, size) = direct(sigma);
    // No transfer at all between the two (one of them sits on every node): no zeros to speak of.
    if size == 0.0 || gain == 0.0 {
        return Ok(found);
    }
    let n = lambda.len();
    let f: Vec<f64> = lambda.iter().map(|l| 1.0 / (l - sigma)).collect();
    let a = Mat::from_fn(n, n, |i, j| {
        let own = if i == j { f[i] } else { 0.0 };
        own - f[i] * force[i] * deflection[j] * f[j] / gain
    });
    for mu in eigenvalues(&a)? {
        // 1e-5: real double zeros split into the complex plane by the square root of the rounding error.
        if mu.re <= 0.0 || mu.im.abs() > 1e-5 * mu.re {
            continue;
        }
        let zero = polish(sigma + 1.0 / mu.re, &lambda, force, deflection);
        if zero >= low && zero <= high {
            found.push(zero.sqrt() / TAU);
        }
    }
    found.sort_by(f64::total_cmp);
    // Two starts that polish to one zero (a pair that met): 1e-9 is far below any separation of true zeros.
    found.dedup_by(|a, b| (*a - *b).abs() < 1e-9 * *b);
    Ok(found)
}

/// A few Newton steps on g; keeps the start when a step leaves its neighbourhood.
fn polish(start: f64, lambda: &[f64], force: &[f64], deflection: &[f64]) -> f64 {
    let mut x = start;
    for _ in 0..4 {
        let (mut g, mut slope) = (0.0, 0.0);
        for k in 0..lambda.len() {
            let gap = lambda[k] - x;
            let term = deflection[k] * force[k] / gap;
            g += term;
            slope += term / gap;
        }
        let next = x - g / slope;
        // The eigenvalue is good to many digits already: a large step means a pole next to the zero.
        if !next.is_finite() || (next - start).abs() > 1e-4 * start.abs() {
            return start;
        }
        x = next;
    }
    x
}

impl Rotor {
    /// Antiresonances, Hz, of the full model between a force at `actuator_m` and the deflection at `sensor_m`.
    ///
    /// # Errors
    /// [`RotorError::OffShaft`] for a position beyond the ends, [`RotorError::Numeric`] when an iteration fails.
    pub fn antiresonances_hz(
        &self,
        actuator_m: f64,
        sensor_m: f64,
        from_hz: f64,
        to_hz: f64,
    ) -> Result<Vec<f64>, RotorError> {
        let modes = PlanarModes::new(self)?;
        let force = modes.amplitudes(&self.shape_at("actuator", actuator_m)?);
        let deflection = modes.amplitudes(&self.shape_at("sensor", sensor_m)?);
        zeros_hz(&modes.omega_rad_s, &force, &deflection, from_hz, to_hz)
    }
}
