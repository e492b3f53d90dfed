//! Classical analysis of a loop: response of the controller, characteristic loci of the open loop, and the response to
//! an unbalance over speed. L = −G K, so that the critical point is −1 though feedback is positive.

use crate::linalg::{Mat, NumericError, c64, eigenvalues_complex};
use crate::lti::held::closed_response;
use crate::lti::{HeldResponse, Response};
use crate::predict::closed_loop::AXES;
use crate::spindle::{Machine, ModelDetail, Plant, SpindleError};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Open loop and controller over frequency, hold included.
#[derive(Clone, Debug)]
pub struct LoopShape {
    /// Lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// K from front to front, rear to rear and rear to front, all in x, A/m.
    pub controller: [Vec<c64>; 3],
    /// The four eigenvalues of L, each followed from line to line.
    pub loci: [Vec<c64>; AXES],
}

impl LoopShape {
    /// Evaluates plant and controller at the lines.
    ///
    /// # Errors
    /// [`NumericError`] when an eigenvalue iteration fails.
    pub fn new(
        plant: &dyn Response,
        controller: &dyn HeldResponse,
        frequency_hz: &[f64],
    ) -> Result<Self, NumericError> {
        let mut shape = Self {
            frequency_hz: frequency_hz.to_vec(),
            controller: [vec![], vec![], vec![]],
            loci: [vec![], vec![], vec![], vec![]],
        };
        for hz in frequency_hz {
            let omega = TAU * hz;
            let (p, k) = (plant.at(omega), controller.held_at(omega));
            let g = p.submatrix(0, 0, AXES, AXES);
            for (list, (i, j)) in shape.controller.iter_mut().zip([(0, 0), (2, 2), (0, 2)]) {
                list.push(k[(i, j)]);
            }
            let l = g * &k;
            let l = Mat::from_fn(AXES, AXES, |i, j| -l[(i, j)]);
            shape.follow(eigenvalues_complex(&l)?);
        }
        Ok(shape)
    }

    /// Appends eigenvalues to the loci whose last points they are nearest to.
    fn follow(&mut self, mut values: Vec<c64>) {
        for locus in &mut self.loci {
            let nearest = match locus.last() {
                None => 0,
                Some(last) => {
                    let distance = |v: &c64| (v - last).norm();
                    let order = |a: &(usize, &c64), b: &(usize, &c64)| distance(a.1).total_cmp(&distance(b.1));
                    values.iter().enumerate().min_by(order).map_or(0, |(k, _)| k)
                }
            };
            if nearest < values.len() {
                locus.push(values.swap_remove(nearest));
            }
        }
    }
}

/// Displacements at tool, front and rear actuator for an unbalance at the tool plane, m per kg m, at every speed in
/// rpm.
///
/// # Errors
/// [`SpindleError`] when a plant cannot be built.
pub fn unbalance_response(
    machine: &Machine,
    controller: &dyn HeldResponse,
    speeds_rpm: &[f64],
) -> Result<Vec<[f64; 3]>, SpindleError> {
    let at = |rpm: &f64| {
        let omega = rpm * TAU / 60.0;
        let plant = Plant::new(machine, omega, ModelDetail::Full)?.for_few_frequencies();
        let h = closed_response(&plant, controller, AXES, omega);
        // A forward circular force: y lags x by a quarter turn.
        let size = |row: usize| (h[(row, 0)] - c64::new(0.0, 1.0) * h[(row, 1)]).norm() * omega * omega;
        Ok([size(0), size(2), size(4)])
    };
    speeds_rpm.par_iter().map(at).collect()
}
