//! The PID of one plane as a structure with derivatives: K = −diag(C_front, C_rear), parameters the 26 logarithms of
//! [`PidParameters`]. Each factor of C gives ∂ ln C/∂ ln p in closed form, so ∂C = C · ∂ ln C.

use super::parameters::{AxisParameters, LOWPASS_DAMPING, PER_AXIS, PidParameters, each_gain};
use crate::controller::polish::matrix2::{Matrix2, ONE, ZERO};
use crate::controller::polish::structure::{FixedLaw, LawStructure, LoopLine};
use crate::linalg::c64;

/// A PID with some parameters held: those listed in `free` move.
#[derive(Clone, Debug)]
pub(super) struct PidLaw {
    /// All 26 logarithms; those that are held keep these.
    pub base: Vec<f64>,
    /// Indices of the parameters that move, in ascending order.
    pub free: Vec<usize>,
    pub nyquist_rad_s: f64,
}

impl PidLaw {
    /// All 26 logarithms for free ones.
    pub(super) fn logs(&self, x: &[f64]) -> Vec<f64> {
        let mut all = self.base.clone();
        for (k, v) in self.free.iter().zip(x) {
            all[*k] = *v;
        }
        all
    }

    /// The parameters within the bounds of realisable sections.
    pub(super) fn parameters_of(&self, x: &[f64]) -> Option<PidParameters> {
        PidParameters::from_log(&self.logs(x), self.nyquist_rad_s)
    }

    fn axes(&self, x: &[f64]) -> [Option<AxisParameters>; 2] {
        self.parameters_of(x).map_or([None, None], |p| [Some(p.front), Some(p.rear)])
    }
}

impl LawStructure for PidLaw {
    fn natural_steps(&self, _x: &[f64]) -> Vec<f64> {
        vec![1.0; self.free.len()]
    }

    fn with<'a>(&'a self, x: &[f64]) -> Box<dyn FixedLaw + 'a> {
        let logs = self.logs(x);
        let axes = self.axes(x);
        // A parameter beyond its bound has no effect.
        let moves = [0, 1].map(|axis: usize| {
            let held = axes[axis].map(|p| p.to_log());
            let own = &logs[axis * PER_AXIS..(axis + 1) * PER_AXIS];
            let inside = |k: usize| held.is_some_and(|held| (own[k] - held[k]).abs() < 1e-9);
            std::array::from_fn(inside)
        });
        Box::new(FixedPid { axes, moves, free: &self.free })
    }
}

struct FixedPid<'a> {
    axes: [Option<AxisParameters>; 2],
    /// Whether a parameter has an effect.
    moves: [[bool; PER_AXIS]; 2],
    free: &'a [usize],
}

impl FixedLaw for FixedPid<'_> {
    fn parameters(&self) -> usize {
        self.free.len()
    }

    fn without_integrators(&self, line: &LoopLine) -> c64 {
        let free = |axis: &Option<AxisParameters>| axis.as_ref().map_or(ONE, |a| line.s / (line.s + a.integral_rad_s));
        let [front, rear] = &self.axes;
        free(front) * free(rear)
    }

    fn add_gains(&self, lines: &[LoopLine], to: &mut Vec<Matrix2>) {
        each_gain(self.axes.each_ref().map(Option::as_ref), lines, |[front, rear]| {
            to.push([[front, ZERO], [ZERO, rear]]);
        });
    }

    fn add_gradients(&self, line: &LoopLine, k: &Matrix2, parts: &mut [(Matrix2, Vec<f64>)]) {
        // ∂K_jj/∂ ln p.
        let slopes = [0, 1].map(|axis: usize| {
            let Some(p) = &self.axes[axis] else {
                return [ZERO; PER_AXIS];
            };
            let gain = k[axis][axis];
            let mut slopes = log_slopes(p, line.s.im);
            for (slope, moves) in slopes.iter_mut().zip(self.moves[axis]) {
                *slope = if moves { *slope * gain } else { ZERO };
            }
            slopes
        });
        // Of the free parameters, real and imaginary parts apart; those of the front axis come first.
        let (mut re, mut im) = ([0.0; 2 * PER_AXIS], [0.0; 2 * PER_AXIS]);
        for ((re, im), k) in re.iter_mut().zip(&mut im).zip(self.free) {
            let slope = &slopes[k / PER_AXIS][k % PER_AXIS];
            (*re, *im) = (slope.re, slope.im);
        }
        let front = self.free.partition_point(|k| *k < PER_AXIS);
        for (q, out) in parts {
            for (axis, own) in [0..front, front..out.len()].into_iter().enumerate() {
                let (q, slopes) = (&q[axis][axis], re[own.clone()].iter().zip(&im[own.clone()]));
                for (out, (re, im)) in out[own].iter_mut().zip(slopes) {
                    *out += q.re * re - q.im * im;
                }
            }
        }
    }
}

/// ∂ ln C/∂ ln p at jv for the thirteen parameters, in the order of the vector form.
fn log_slopes(p: &AxisParameters, v: f64) -> [c64; PER_AXIS] {
    let corner = v / p.derivative_corner_rad_s;
    let by_corner = c64::new(1.0, corner).inv();
    let derivative = by_corner * c64::new(0.0, v * p.derivative_s);
    let integral = c64::new(0.0, -p.integral_rad_s / v);
    let by_pid = (integral + derivative + 1.0).inv();
    // ln(s²/w² + 2ζs/w + 1) by ln w and by ln ζ.
    let section = |w: f64, zeta: f64| {
        let r = v / w;
        let (square, damping) = (r * r, 2.0 * zeta * r);
        let by_value = c64::new(1.0 - square, damping).inv();
        (c64::new(2.0 * square, -damping) * by_value, c64::new(0.0, damping) * by_value)
    };
    let mut slopes = [ZERO; PER_AXIS];
    slopes[0] = ONE;
    slopes[1] = integral * by_pid;
    slopes[2] = derivative * by_pid;
    slopes[3] = slopes[2] * by_corner * c64::new(0.0, corner);
    slopes[4] = -section(p.lowpass_rad_s, LOWPASS_DAMPING).0;
    for (k, b) in p.biquads.iter().enumerate() {
        let zero = section(b.zero_rad_s, b.zero_damping);
        let pole = section(b.pole_rad_s, b.pole_damping);
        slopes[5 + 4 * k] = zero.0;
        slopes[6 + 4 * k] = zero.1;
        slopes[7 + 4 * k] = -pole.0;
        slopes[8 + 4 * k] = -pole.1;
    }
    slopes
}
