//! Modes of the free-free shaft at rest, one plane:  K v = ω² M v,  VᵀMV = I.
//! The two rigid modes (translation; rotation about the centre of gravity) are constructed, not computed, so their
//! frequency is exactly zero; the flexible ones are solved in their M-orthogonal complement.
//! Sign: the first nonzero deflection from the tool end is positive.

use super::RotorError;
use super::assembly::{PlaneMatrices, Rotor};
use crate::linalg::{Mat, definite_eigen_lifted};

/// Number of rigid modes of a plane.
pub const RIGID: usize = 2;

/// Mass-normalised modes of one plane.
#[derive(Clone, Debug)]
pub struct PlanarModes {
    /// Angular natural frequencies, rad/s, ascending; the first two are exactly 0.
    pub omega_rad_s: Vec<f64>,
    /// Shapes, dofs × modes, mass-normalised.
    pub shapes: Mat<f64>,
    /// The matrices they come from.
    pub matrices: PlaneMatrices,
}

impl PlanarModes {
    /// All modes of a free-free shaft.
    ///
    /// # Errors
    /// [`RotorError::Numeric`] when the eigenvalue iteration fails or the mass matrix is not positive definite.
    pub fn new(rotor: &Rotor) -> Result<Self, RotorError> {
        let matrices = rotor.plane_matrices();
        let n = rotor.dofs();
        let properties = rotor.properties_from(&matrices);
        let (shift, tilt) = (properties.mass_kg.sqrt().recip(), properties.diametral_inertia_kg_m2.sqrt().recip());
        let z = rotor.node_positions_m();
        let rigid = Mat::from_fn(n, RIGID, |i, mode| match (mode, i % 2) {
            (0, 0) => shift,
            (0, _) => 0.0,
            (_, 0) => tilt * (properties.centre_of_gravity_m - z[i / 2]),
            _ => -tilt,
        });
        let flexible = definite_eigen_lifted(&matrices.stiffness, &matrices.mass, &rigid)?;
        let mut omega_rad_s = vec![0.0; RIGID];
        omega_rad_s.extend(flexible.values.iter().map(|v| v.max(0.0).sqrt()));
        let shapes = Mat::from_fn(n, n, |i, k| {
            if k < RIGID {
                return rigid[(i, k)];
            }
            let v = &flexible.vectors;
            let scale = (0..n).step_by(2).map(|i| v[(i, k - RIGID)].abs());
            // A tool end that moves less than a ten-millionth of the largest deflection is a node, not a sign.
            let floor = 1e-7 * scale.fold(0.0, f64::max);
            let first = (0..n).step_by(2).map(|i| v[(i, k - RIGID)]).find(|w| w.abs() > floor).unwrap_or(1.0);
            v[(i, k - RIGID)] * first.signum()
        });
        Ok(Self { omega_rad_s, shapes, matrices })
    }

    /// Number of modes of the plane, the two rigid ones included.
    pub fn len(&self) -> usize {
        self.omega_rad_s.len()
    }

    /// True when there are none.
    pub fn is_empty(&self) -> bool {
        self.omega_rad_s.is_empty()
    }

    /// Natural frequencies of the flexible modes, Hz.
    pub fn flexible_hz(&self) -> Vec<f64> {
        self.omega_rad_s.iter().skip(RIGID).map(|w| w / std::f64::consts::TAU).collect()
    }

    /// Modal amplitudes φ_k of a read-out row (pairs dof, coefficient): its product with every shape.
    pub fn amplitudes(&self, row: &[(usize, f64)]) -> Vec<f64> {
        (0..self.len()).map(|k| row.iter().map(|(i, c)| c * self.shapes[(*i, k)]).sum()).collect()
    }
}
