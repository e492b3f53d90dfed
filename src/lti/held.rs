//! A controller as the plant sees it. A sampled controller acts through a zero-order hold, whose response is (1 −
//! e^{−jωT})/(jωT) = sinc(fT)·e^{−jωT/2}: its half sample is part of the plant's delay (`delay_s`, of which the hold
//! takes T/2 and the rest is pure delay), its magnitude sinc(fT) = sin(πfT)/(πfT) belongs to the controller. A
//! continuous controller has no hold. Every closed-loop response takes its controller through this trait, so that the
//! magnitude of the hold cannot be left out.

use super::responder::FrequencyResponder;
use super::response::Response;
use super::state_space::{Continuous, Discrete, StateSpace};
use crate::linalg::{Mat, c64, solve_complex};

/// Anything that commands currents from signals, with the hold that its output passes through.
pub trait HeldResponse: Sync {
    /// Response at `omega_rad_s` with the magnitude of the hold, outputs × inputs.
    fn held_at(&self, omega_rad_s: f64) -> Mat<c64>;
}

impl HeldResponse for StateSpace<Continuous> {
    fn held_at(&self, omega_rad_s: f64) -> Mat<c64> {
        self.at(omega_rad_s)
    }
}

impl HeldResponse for StateSpace<Discrete> {
    fn held_at(&self, omega_rad_s: f64) -> Mat<c64> {
        held(&self.at(omega_rad_s), omega_rad_s, self.time)
    }
}

impl HeldResponse for FrequencyResponder<Continuous> {
    fn held_at(&self, omega_rad_s: f64) -> Mat<c64> {
        self.at(omega_rad_s)
    }
}

impl HeldResponse for FrequencyResponder<Discrete> {
    fn held_at(&self, omega_rad_s: f64) -> Mat<c64> {
        held(&self.at(omega_rad_s), omega_rad_s, self.time())
    }
}

/// A response with the magnitude of the hold behind it.
fn held(response: &Mat<c64>, omega_rad_s: f64, time: Discrete) -> Mat<c64> {
    let magnitude = hold_magnitude(omega_rad_s, time.period_s);
    Mat::from_fn(response.nrows(), response.ncols(), |i, j| response[(i, j)] * magnitude)
}

/// sinc(fT) = sin(ωT/2)/(ωT/2) of a zero-order hold; one at ω = 0.
pub fn hold_magnitude(omega_rad_s: f64, period_s: f64) -> f64 {
    let half = 0.5 * omega_rad_s * period_s;
    // The series is 1 − x²/6: below 1e-4 it differs from one by less than rounding of the quotient.
    if half.abs() < 1e-4 {
        return 1.0 - half * half / 6.0;
    }
    half.sin() / half
}

/// Response of a plant closed with u = K y: of the channels after the first `loops` ones, outputs × inputs,
/// P_zw + P_zu K (I − P_yu K)⁻¹ P_yw, with the delay of the plant and the hold of the controller.
pub fn closed_response(
    plant: &dyn Response,
    controller: &dyn HeldResponse,
    loops: usize,
    omega_rad_s: f64,
) -> Mat<c64> {
    let p = plant.at(omega_rad_s);
    let k = controller.held_at(omega_rad_s);
    let (nz, nw) = (p.nrows() - loops, p.ncols() - loops);
    let part = |r, c, nr, nc| p.submatrix(r, c, nr, nc).to_owned();
    let (pzw, pzu) = (part(loops, loops, nz, nw), part(loops, 0, nz, loops));
    let (pyw, pyu) = (part(0, loops, loops, nw), part(0, 0, loops, loops));
    let y = solve_complex(&return_difference(&pyu, &k), &pyw);
    pzw + pzu * (&k * y)
}

/// I − G K.
pub(crate) fn return_difference(g: &Mat<c64>, k: &Mat<c64>) -> Mat<c64> {
    let l = g * k;
    Mat::from_fn(l.nrows(), l.ncols(), |i, j| c64::new(if i == j { 1.0 } else { 0.0 }, 0.0) - l[(i, j)])
}
