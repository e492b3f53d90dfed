//! Plant and controller closed with positive feedback u = K y: stability in sampled time, frequency responses.
//! The plant carries the channels of [`crate::spindle`]: currents then forces in, sensors then displacements out.
//! Frequency predictions take the plant as [`Response`] and the controller as [`HeldResponse`], so that PID, full,
//! reduced and rounded controllers go through the same lines, and sampled ones through their hold:
//! T = P_zw + P_zu K (I − P_yu K)⁻¹ P_yw.

use crate::linalg::{Mat, NumericError, c64, solve_complex};
use crate::lti::connect::{check_sample_times, lower_lft};
use crate::lti::held::{closed_response, return_difference};
use crate::lti::{Discrete, HeldResponse, Response, StateSpace};

pub use crate::lti::connect::both_planes;
pub use crate::spindle::plant::AXES;

/// Closed-loop response from the forces to the displacements (the channels after the four control channels)
/// at `omega_rad_s`, displacements × forces, m/N; the forces act continuously, the currents through the hold.
pub fn compliance(plant: &dyn Response, controller: &dyn HeldResponse, omega_rad_s: f64) -> Mat<c64> {
    closed_response(plant, controller, AXES, omega_rad_s)
}

/// Output sensitivity S = (I − G K)⁻¹ at the sensors, 4×4.
pub fn sensitivity(plant: &dyn Response, controller: &dyn HeldResponse, omega_rad_s: f64) -> Mat<c64> {
    sensitivity_of(&plant.at(omega_rad_s), &controller.held_at(omega_rad_s))
}

/// (I − G K)⁻¹ of a plant's and a controller's response.
fn sensitivity_of(p: &Mat<c64>, k: &Mat<c64>) -> Mat<c64> {
    let g = p.submatrix(0, 0, AXES, AXES).to_owned();
    let identity = Mat::from_fn(AXES, AXES, |i, j| c64::new(if i == j { 1.0 } else { 0.0 }, 0.0));
    solve_complex(&return_difference(&g, k), &identity)
}

/// Compliance of the forces' channels and output sensitivity of a loop at `omega_rad_s`, as [`compliance`] and
/// [`sensitivity`] have them, from one response of the plant and one of the controller.
pub(crate) fn compliance_and_sensitivity(
    plant: &dyn Response,
    controller: &dyn HeldResponse,
    omega_rad_s: f64,
) -> (Mat<c64>, Mat<c64>) {
    let (p, k) = (plant.at(omega_rad_s), controller.held_at(omega_rad_s));
    let s = sensitivity_of(&p, &k);
    let (nz, nw) = (p.nrows() - AXES, p.ncols() - AXES);
    let drive = p.submatrix(AXES, 0, nz, AXES) * &k;
    let read = &s * p.submatrix(0, AXES, AXES, nw);
    (p.submatrix(AXES, AXES, nz, nw) + drive * read, s)
}

/// Sampled closed loop of the full plant with a sampled controller, forces → displacements.
///
/// # Errors
/// [`NumericError`] when the loop is not well posed or the sample times differ.
pub fn close(
    plant: &StateSpace<Discrete>,
    controller: &StateSpace<Discrete>,
) -> Result<StateSpace<Discrete>, NumericError> {
    check_sample_times(plant, controller)?;
    let all_in: Vec<usize> = (AXES..plant.inputs()).chain(0..AXES).collect();
    let all_out: Vec<usize> = (AXES..plant.outputs()).chain(0..AXES).collect();
    lower_lft(&plant.select(&all_out, &all_in), controller)
}
