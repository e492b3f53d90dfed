//! A controller of one plane with free parameters: its gain at a line, and the derivative of a scalar of the loop.

use super::matrix2::Matrix2;
use crate::linalg::c64;

/// A line of the sampled loop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoopLine {
    /// ω, rad/s.
    pub omega_rad_s: f64,
    /// e^{jωT}.
    pub z: c64,
    /// (2/T)(z − 1)/(z + 1) = j(2/T)tan(ωT/2), where Tustin's rule reads a continuous law, rad/s.
    pub s: c64,
}

impl LoopLine {
    /// The line at `omega_rad_s` of a loop sampled every `period_s`.
    pub(crate) fn new(omega_rad_s: f64, period_s: f64) -> Self {
        let half = 0.5 * omega_rad_s * period_s;
        Self { omega_rad_s, z: c64::from_polar(1.0, 2.0 * half), s: c64::new(0.0, 2.0 / period_s * half.tan()) }
    }
}

/// K(z; x), two signals (m) to two currents (A), u = K y.
pub(crate) trait LawStructure: Sync {
    /// Change of each parameter that changes its part of the controller by about its own size.
    fn natural_steps(&self, x: &[f64]) -> Vec<f64>;
    /// The controller with parameters x, for many lines.
    fn with<'a>(&'a self, x: &[f64]) -> Box<dyn FixedLaw + 'a>;
}

/// K(z; x) for one x.
pub(crate) trait FixedLaw: Sync {
    fn parameters(&self) -> usize;
    /// 1/K's poles on the unit circle: the factor that takes the integrators out of det(I − G K); 1 without
    /// integrators.
    fn without_integrators(&self, _line: &LoopLine) -> c64 {
        c64::new(1.0, 0.0)
    }
    /// Adds K at some lines, A/m.
    fn add_gains(&self, lines: &[LoopLine], to: &mut Vec<Matrix2>);
    /// Adds Re tr(Q ∂K/∂xₚ) at a line with its K, for every parameter p, to the derivatives beside each Q.
    fn add_gradients(&self, line: &LoopLine, gain: &Matrix2, parts: &mut [(Matrix2, Vec<f64>)]);
}
