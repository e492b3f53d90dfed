//! Derivatives of a receptance to moduli, and to the mesh, from the strains of the element groups.
//!
//! The stiffness of a group in Ritz coordinates has few directions: K_g = Σ_r v_r v_rᵀ, one strain each. With coordinates X_l and X_r
//! behind a closed loop, ∂H/∂e_g = −X_lᵀ K_g X_r = −Σ_r (v_rᵀX_l)ᵀ(v_rᵀX_r): two rows of products per strain instead of a matrix
//! per group. Coordinates above the dynamic ones follow the forces at the ports as springs, x_h = Ω_h⁻² B_h f. What a finer mesh adds has
//! the same form, with the rigid coordinates.

use super::super::skeleton::Skeleton;
use crate::linalg::{Mat, c64};
use std::ops::Range;

/// Strains of all groups in the modal coordinates of an assembled hypothesis.
#[derive(Clone, Debug)]
pub(super) struct Strain {
    of_group: Vec<Range<usize>>,
    count: usize,
    /// Of the dynamic coordinates, coordinates × strains.
    low: Vec<f64>,
    /// Of the springs above them under a force at a port, ports × strains.
    ports: Vec<f64>,
}

/// Coordinates behind a closed loop with n outputs and n inputs, at one line.
pub(super) struct Behind<'a> {
    /// Outputs and inputs.
    pub n: usize,
    /// X_l, n × dynamic.
    pub left: &'a [c64],
    /// X_r, dynamic × n.
    pub right: &'a [c64],
    /// Forces at the ports of a force at an output, n × ports.
    pub left_ports: &'a [c64],
    /// Forces at the ports of an input, ports × n.
    pub right_ports: &'a [c64],
}

impl Strain {
    /// Strains in the coordinates `turned` (coordinates × modes) with natural frequencies `omega` and port amplitudes `ports`.
    pub fn new(
        skeleton: &Skeleton,
        turned: &Mat<f64>,
        omega: &[f64],
        ports: &[Vec<f64>],
        dynamic: usize,
    ) -> Self {
        let (n, count) = (turned.ncols(), skeleton.strains.ncols());
        let turned = turned.transpose() * &skeleton.strains;
        let mut low = Vec::with_capacity(dynamic * count);
        for k in 0..dynamic {
            low.extend((0..count).map(|r| turned[(k, r)]));
        }
        let mut still = vec![0.0; ports.len() * count];
        for (port, sums) in ports.iter().zip(still.chunks_mut(count.max(1))) {
            for k in dynamic..n {
                let follows = port[k] / omega[k].powi(2);
                for (r, sum) in sums.iter_mut().enumerate() {
                    *sum += follows * turned[(k, r)];
                }
            }
        }
        Self {
            of_group: skeleton.strains_of_group.clone(),
            count,
            low,
            ports: still,
        }
    }

    /// ∂H/∂e_g for every group and the mesh, n × n row-major.
    pub fn slopes(&self, behind: &Behind) -> Vec<Vec<c64>> {
        let (n, count) = (behind.n, self.count);
        let dynamic = behind.right.len() / n.max(1);
        // Strains of the left and right coordinates, real and imaginary parts apart: 4n rows.
        let mut sums = vec![0.0; 4 * n * count];
        let mut add = |rows: &[f64],
                       left: &dyn Fn(usize, usize) -> c64,
                       right: &dyn Fn(usize, usize) -> c64| {
            for (k, row) in rows.chunks(count.max(1)).enumerate() {
                for i in 0..n {
                    let (l, r) = (left(i, k), right(k, i));
                    for (part, value) in [l.re, l.im, r.re, r.im].into_iter().enumerate() {
                        let from = (4 * i + part) * count;
                        for (sum, v) in sums[from..from + count].iter_mut().zip(row) {
                            *sum += value * v;
                        }
                    }
                }
            }
        };
        add(&self.low, &|o, k| behind.left[o * dynamic + k], &|k, i| {
            behind.right[k * n + i]
        });
        let ports = behind.right_ports.len() / n.max(1);
        add(
            &self.ports,
            &|o, q| behind.left_ports[o * ports + q],
            &|q, i| behind.right_ports[q * n + i],
        );
        let strain = |i: usize, part: usize, r: usize| sums[(4 * i + part) * count + r];
        self.of_group
            .iter()
            .map(|range| {
                let mut slope = Vec::with_capacity(n * n);
                for o in 0..n {
                    for i in 0..n {
                        let mut sum = c64::new(0.0, 0.0);
                        for r in range.clone() {
                            let left = c64::new(strain(o, 0, r), strain(o, 1, r));
                            sum -= left * c64::new(strain(i, 2, r), strain(i, 3, r));
                        }
                        slope.push(sum);
                    }
                }
                slope
            })
            .collect()
    }
}
