//! Coordinates of the shaft behind closed loops, at one line: what every derivative to a property of the shaft is made
//! of.
//!
//! With L = I + H_c κ (outputs × ports) and R = I + κ H_c (ports × inputs), a change dZ of the dynamic stiffness gives
//! −(L Xᵀ) dZ (X R).

use crate::linalg::c64;

/// Coordinates behind a closed loop with n outputs and n inputs, at one line.
pub(crate) struct Adjoint {
    /// Outputs and inputs.
    pub n: usize,
    /// X_l, n × dynamic.
    pub left: Vec<c64>,
    /// X_r, dynamic × n.
    pub right: Vec<c64>,
    /// Forces at the ports of a force at an output, n × ports.
    pub left_ports: Vec<c64>,
    /// Forces at the ports of an input, ports × n.
    pub right_ports: Vec<c64>,
}
