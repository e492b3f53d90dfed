//! Modes of the free shaft of a machine in Ritz coordinates.

use crate::linalg::{Mat, NumericError, definite_eigen_lifted, symmetric_eigen};
use crate::rotor::modes::RIGID;
use crate::spindle::SpindleError;

/// Modes, mass-orthonormal, the rigid ones first.
#[derive(Debug)]
pub(super) struct Modes {
    /// Natural frequencies, rad/s; zero for the rigid ones.
    pub omega: Vec<f64>,
    /// Coordinates × modes.
    pub shapes: Mat<f64>,
}

/// Modes of a stiffness whose first coordinates are rigid, with further masses (amplitudes of a place, kg) on a unit
/// mass matrix.
pub(super) fn modes(stiffness: &Mat<f64>, masses: &[(Vec<f64>, f64)]) -> Result<Modes, SpindleError> {
    let n = stiffness.nrows();
    let mut omega = vec![0.0; RIGID];
    if masses.is_empty() {
        let flexible = stiffness.submatrix(RIGID, RIGID, n - RIGID, n - RIGID);
        let (values, vectors) = symmetric_eigen(&flexible.to_owned())?;
        omega.extend(values.iter().map(|v| frequency(*v)));
        let mut shapes = Mat::identity(n, n);
        let mut flexible = shapes.submatrix_mut(RIGID, RIGID, n - RIGID, n - RIGID);
        flexible.copy_from(&vectors);
        return Ok(Modes { omega, shapes });
    }
    let mass = Mat::from_fn(n, n, |i, j| {
        let own = f64::from(u8::from(i == j));
        own + masses.iter().map(|(b, m)| m * b[i] * b[j]).sum::<f64>()
    });
    // Rigid modes R = [C⁻ᵀ; 0], C Cᵀ the rigid block of the mass.
    let (a, b, d) = (mass[(0, 0)], mass[(0, 1)], mass[(1, 1)]);
    let first = a.sqrt();
    let second = (d - b * b / a).sqrt();
    if !(first > 0.0 && second > 0.0) {
        return Err(NumericError::Singular { what: "mass of the shaft with negative added masses", rcond: 0.0 }.into());
    }
    let mut rigid = Mat::zeros(n, RIGID);
    rigid[(0, 0)] = first.recip();
    rigid[(0, 1)] = -b / (a * second);
    rigid[(1, 1)] = second.recip();
    let flexible = definite_eigen_lifted(stiffness, &mass, &rigid)?;
    omega.extend(flexible.values.iter().map(|v| frequency(*v)));
    let shapes = Mat::from_fn(n, n, |i, k| if k < RIGID { rigid[(i, k)] } else { flexible.vectors[(i, k - RIGID)] });
    Ok(Modes { omega, shapes })
}

/// Natural frequency of a flexible mode from its square. A shaft is stiff: what rounding leaves of it is no less than
/// 1 rad/s.
pub(super) fn frequency(squared: f64) -> f64 {
    squared.max(1.0).sqrt()
}
