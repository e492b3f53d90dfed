//! Derivatives of a receptance to moduli, and to the mesh, from the strains of the element groups.
//!
//! The stiffness of a group in Ritz coordinates has few directions: K_g = Σ_r v_r v_rᵀ, one strain each. With
//! coordinates X_l and X_r behind a closed loop, ∂H/∂ln e_g = −X_lᵀ K_g X_r = −Σ_r (v_rᵀX_l)ᵀ(v_rᵀX_r): two rows of
//! products per strain instead of a matrix per group. Coordinates above the dynamic ones follow the forces at the ports
//! as springs, x_h = Ω_h⁻² B_h f. What a finer mesh adds has the same form, with the rigid coordinates.

use super::adjoint::Adjoint;
use super::ritz::ReducedShaft;
use super::shaft_modes::Modes;
use crate::linalg::gram::complex_dot_in_lanes;
use crate::linalg::{Mat, c64};
use std::ops::Range;

/// Strains of all groups in the modal coordinates of an assembled machine.
#[derive(Clone, Debug)]
pub(super) struct Strain {
    of_group: Vec<Range<usize>>,
    /// Of the dynamic coordinates, then of the springs above them under a force at each port: strains × (dynamic +
    /// ports).
    strains: Mat<f64>,
}

impl Strain {
    /// Strains of groups whose stiffness is `scale` times their own, in the modes of the shaft with port amplitudes
    /// `ports`.
    pub(super) fn new(shaft: &ReducedShaft, scale: &[f64], modes: &Modes, ports: &[Vec<f64>], dynamic: usize) -> Self {
        let (turned, omega) = (&modes.shapes, &modes.omega);
        let (n, count) = (turned.ncols(), shaft.strains.ncols());
        let mut amplitude = vec![1.0; count];
        for (range, scale) in shaft.strains_of_group.iter().zip(scale) {
            amplitude[range.clone()].fill(scale.sqrt());
        }
        let own = Mat::from_fn(n, count, |i, r| shaft.strains[(i, r)] * amplitude[r]);
        let turned = own.transpose() * turned;
        let follow = Mat::from_fn(n - dynamic, ports.len(), |k, q| ports[q][dynamic + k] / omega[dynamic + k].powi(2));
        let above = turned.subcols(dynamic, n - dynamic) * follow;
        let strains = Mat::from_fn(count, dynamic + ports.len(), |r, c| {
            if c < dynamic { turned[(r, c)] } else { above[(r, c - dynamic)] }
        });
        Self { of_group: shaft.strains_of_group.clone(), strains }
    }

    /// ∂H to the logarithm of every group's stiffness and to the mesh, each n × n row-major, one behind the other.
    pub(super) fn slopes(&self, behind: &Adjoint) -> Vec<c64> {
        let n = behind.n;
        let dynamic = behind.right.len() / n.max(1);
        let ports = behind.right_ports.len() / n.max(1);
        // Left and right coordinates, real and imaginary parts apart: 4n columns.
        let mut coordinates = Mat::zeros(dynamic + ports, 4 * n);
        for i in 0..n {
            let left = behind.left[i * dynamic..(i + 1) * dynamic].iter();
            let left = left.chain(&behind.left_ports[i * ports..(i + 1) * ports]);
            let right = behind.right[i..].iter().step_by(n);
            let right = right.chain(behind.right_ports[i..].iter().step_by(n));
            for (k, (left, right)) in left.zip(right).enumerate() {
                coordinates[(k, 4 * i)] = left.re;
                coordinates[(k, 4 * i + 1)] = left.im;
                coordinates[(k, 4 * i + 2)] = right.re;
                coordinates[(k, 4 * i + 3)] = right.im;
            }
        }
        let strains = &self.strains * coordinates;
        let part = |i: usize, part: usize, range: &Range<usize>| &strains.col_as_slice(4 * i + part)[range.clone()];
        let mut slopes = Vec::with_capacity(self.of_group.len() * n * n);
        for range in &self.of_group {
            for o in 0..n {
                let (a, b) = (part(o, 0, range), part(o, 1, range));
                for i in 0..n {
                    let (c, d) = (part(i, 2, range), part(i, 3, range));
                    slopes.push(-complex_dot_in_lanes((a, b), (c, d)));
                }
            }
        }
        slopes
    }
}
