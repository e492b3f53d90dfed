//! Robust stability of a stable loop N(s) closed by a structured Δ: margin, worst perturbation, and its frequency.
//!
//! The loop stays stable for every Δ of the structure with σ_max(Δ) < margin, margin = 1/sup_ω μ(N(jω)). The lower end
//! is certified over all frequencies; the upper end belongs to a perturbation that puts a pole on the axis, which is
//! checked.

use super::system::MuSystem;
use crate::augment::Block;
use crate::linalg::hermitian::min_singular_value;
use crate::linalg::{Mat, c64, max_singular_value_complex};
use crate::lti::{Continuous, StateSpace};
use crate::robust::structure::MuError;

/// Margin of robust stability with its proofs.
#[derive(Clone, Debug)]
pub struct RobustStability {
    /// No perturbation smaller than this destabilises the loop (certified).
    pub margin_lower: f64,
    /// A perturbation of this size does; infinite when none was found.
    pub margin_upper: f64,
    /// That perturbation, w×z, at `omega_rad_s`.
    pub worst: Mat<c64>,
    /// Frequency of the pole on the axis, rad/s.
    pub omega_rad_s: f64,
    /// σ_min(I − ΔN(jω)) relative to 1 + σ_max(ΔN): zero for a pole on the axis.
    pub singularity: f64,
}

/// Margin of a stable system N for a block structure; `slack` is the width allowed to the certificate.
///
/// # Errors
/// [`MuError`] when N is unstable, does not fit the blocks, or the certificate does not come to its end.
pub fn robust_stability(
    system: &StateSpace<Continuous>,
    blocks: &[Block],
    slack: f64,
) -> Result<RobustStability, MuError> {
    let analysis = MuSystem::new(system, blocks)?;
    let peak = analysis.peak(slack)?;
    let gain = &peak.bounds.delta * analysis.response(peak.omega_rad_s);
    let n = gain.nrows();
    let difference = Mat::from_fn(n, n, |i, j| {
        c64::new(f64::from(u8::from(i == j)), 0.0) - gain[(i, j)]
    });
    let reciprocal = |v: f64| if v > 0.0 { 1.0 / v } else { f64::INFINITY };
    Ok(RobustStability {
        margin_lower: reciprocal(peak.upper),
        margin_upper: reciprocal(peak.bounds.lower),
        singularity: min_singular_value(&difference) / (1.0 + max_singular_value_complex(&gain)),
        worst: peak.bounds.delta,
        omega_rad_s: peak.omega_rad_s,
    })
}
