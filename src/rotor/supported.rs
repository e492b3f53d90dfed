//! The bend of a shaft on two supports.

use super::{Rotor, RotorError};
use crate::linalg::{Mat, solve};

/// Displacement per force (m/N) at `position_m` of a shaft that is held at two positions and free to tilt there; the
/// equilibrium alone sets both reactions.
///
/// K u = f with C u = 0 by Lagrange multipliers: [[K, Cᵀ], [C, 0]].
///
/// # Errors
/// [`RotorError`] for a position off the shaft, or supports at one place.
pub fn supported_compliance(rotor: &Rotor, position_m: f64, supports_m: [f64; 2]) -> Result<f64, RotorError> {
    let stiffness = rotor.plane_matrices().stiffness;
    let n = stiffness.nrows();
    let load = rotor.shape_at("position", position_m)?;
    let mut system = Mat::zeros(n + 2, n + 2);
    system.submatrix_mut(0, 0, n, n).copy_from(&stiffness);
    // Of the size of the stiffness, so that no row is lost beside the others.
    let scale = stiffness.norm_max();
    for (k, support_m) in supports_m.into_iter().enumerate() {
        for (dof, share) in rotor.shape_at("support", support_m)? {
            system[(n + k, dof)] += scale * share;
            system[(dof, n + k)] += scale * share;
        }
    }
    let mut force = Mat::zeros(n + 2, 1);
    for (dof, share) in &load {
        force[(*dof, 0)] += share;
    }
    let moved = solve(&system, &force)?;
    Ok(load.iter().map(|(dof, share)| share * moved[(*dof, 0)]).sum())
}
