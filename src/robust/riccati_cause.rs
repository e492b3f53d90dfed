//! Why A'X + XA − XGX + Q = 0 has no stabilising solution, in the terms of its data.

use super::hinf::assumptions::unreachable_modes;
use crate::linalg::regulator::Regulator;
use crate::linalg::{Mat, NumericError, c64};
use crate::lti::connect::stack_cols;

/// An eigenvalue this close to the imaginary axis, relative to the size of A, may lie on it: a double one (a rigid
/// body) comes out of an eigenvalue iteration with the root of the rounding error.
const ON_AXIS: f64 = 1e-7;

/// The conditions on (A, G, Q) that fail, each with a mode, and what to do; none when both hold.
///
/// # Errors
/// [`NumericError`] when eigenvalues fail.
pub fn find_cause(a: &Mat<f64>, g: &Mat<f64>, q: &Mat<f64>) -> Result<Option<String>, NumericError> {
    causes_of(a, Part { name: "G", matrix: g }, Part { name: "Q", matrix: q }, false)
}

/// [`find_cause`] for the cost of a regulator, in either time.
///
/// # Errors
/// As [`find_cause`].
pub fn find_regulator_cause(of: &Regulator) -> Result<Option<String>, NumericError> {
    // What the cost sees of a mode is [Q S].
    let seen = stack_cols(&of.q, &of.s);
    causes_of(&of.a, Part { name: "B", matrix: &of.b }, Part { name: "Q", matrix: &seen }, of.is_sampled)
}

/// What reaches or sees the modes, and how the user calls it.
struct Part<'a> {
    name: &'static str,
    matrix: &'a Mat<f64>,
}

fn causes_of(a: &Mat<f64>, reaching: Part, seeing: Part, is_sampled: bool) -> Result<Option<String>, NumericError> {
    let size = a.norm_l2();
    let distance = |mode: &c64| if is_sampled { mode.norm() - 1.0 } else { mode.re };
    // Modes on the limit of stability come out of the eigenvalue iteration at rounding level on either side.
    let near = if is_sampled { ON_AXIS } else { ON_AXIS * size };
    let rounding = if is_sampled { 1e-13 } else { 1e-13 * size };
    let unreached = unreachable_modes(a, reaching.matrix, |mode| distance(mode) >= -rounding)?.into_iter().next();
    // A mode off the axis may stay unobserved: X does not see it, and the closed loop mirrors it.
    let transposed = a.transpose().to_owned();
    let unseen = unreachable_modes(&transposed, seeing.matrix, |mode| distance(mode).abs() <= near)?.into_iter().next();
    let place = |mode: c64| {
        if is_sampled {
            return format!("z = {:.6e} {:+.6e}j", mode.re, mode.im);
        }
        format!("{:.6e} {:+.6e}j rad/s", mode.re, mode.im)
    };
    let (reaching, seeing) = (reaching.name, seeing.name);
    let mut causes = vec![];
    if let Some(mode) = unreached {
        let words = format!("(A, {reaching}) is not stabilisable: {reaching} does not reach the mode at");
        causes.push(format!("{words} {}", place(mode)));
    }
    if let Some(mode) = unseen {
        let words = format!("({seeing}, A) is not detectable: {seeing} does not observe the undamped mode at");
        causes.push(format!("{words} {}, give it a weight in {seeing}", place(mode)));
    }
    Ok((!causes.is_empty()).then(|| causes.join("; ")))
}
