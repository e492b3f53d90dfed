//! Largest singular values of a loop over frequency: controller, loop gain, sensitivity and complementary sensitivity,
//! control effort, in the channels of the axes.
//!
//! With positive feedback u = K y: L = G K, S = (I − L)⁻¹, T = L S, K S (Skogestad and Postlethwaite, Multivariable
//! Feedback Control, 2005, section 2.8).

use super::closed_loop::{AXES, sensitivity_of};
use crate::linalg::max_singular_value_complex;
use crate::lti::{FrequencyGrid, HeldResponse, Response};
use rayon::prelude::*;

/// Largest singular values, line by line.
#[derive(Clone, Debug)]
pub struct LoopSigma {
    /// Lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// K, A/m.
    pub controller: Vec<f64>,
    /// L.
    pub loop_gain: Vec<f64>,
    /// S.
    pub sensitivity: Vec<f64>,
    /// T.
    pub complementary: Vec<f64>,
    /// K S, A/m.
    pub effort: Vec<f64>,
}

impl LoopSigma {
    /// On the lines of a grid.
    pub fn new(plant: &dyn Response, controller: &dyn HeldResponse, grid: &FrequencyGrid) -> Self {
        let at = |omega: &f64| {
            let (p, k) = (plant.at(*omega), controller.held_at(*omega));
            let s = sensitivity_of(&p, &k);
            let l = p.submatrix(0, 0, AXES, AXES) * &k;
            let (t, effort) = (&l * &s, &k * &s);
            [&k, &l, &s, &t, &effort].map(max_singular_value_complex)
        };
        let all: Vec<[f64; 5]> = grid.omega_rad_s().par_iter().map(at).collect();
        let [controller, loop_gain, sensitivity, complementary, effort] =
            std::array::from_fn(|which| all.iter().map(|values| values[which]).collect());
        Self { frequency_hz: grid.hz(), controller, loop_gain, sensitivity, complementary, effort }
    }
}
