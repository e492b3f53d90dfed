//! What can go wrong in a matrix computation, with the numbers that say how badly.

use thiserror::Error;

/// Failure of a dense computation.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum NumericError {
    /// Shapes do not fit.
    #[error("{what}: expected {expected}, found {found}")]
    Dimension {
        /// The operation.
        what: &'static str,
        /// Shapes that would fit.
        expected: String,
        /// Shapes given.
        found: String,
    },
    /// A NaN or an infinity in the data.
    #[error("{what}: NaN or infinity in the data")]
    NotFinite {
        /// The operation.
        what: &'static str,
    },
    /// A matrix that must be inverted is singular to working precision.
    #[error("{what}: singular to working precision (reciprocal condition about {rcond:.1e})")]
    Singular {
        /// The operation.
        what: &'static str,
        /// Estimate of the reciprocal condition number.
        rcond: f64,
    },
    /// An algebraic loop without a solution.
    #[error("{what} is singular: the loop is not well posed")]
    IllPosed {
        /// The matrix.
        what: &'static str,
    },
    /// A map of the s plane has its pole at a pole of the system.
    #[error(
        "{map} does not exist: the system has a pole at s = {point} rad/s, where the rule has its own; sample \
         at another rate, or with a hold"
    )]
    PoleOfMap {
        /// The map.
        map: &'static str,
        /// The pole, rad/s.
        point: f64,
    },
    /// A sampled system has a pole where the bilinear map has its own.
    #[error(
        "the bilinear map z = (1 + s T/2)/(1 - s T/2) does not exist: the system has a pole at z = -1, the Nyquist \
         frequency; sample at another rate"
    )]
    PoleAtNyquist,
    /// The answer contradicts what it was computed from.
    #[error(
        "{what}: relative error {residual:.1e}; give the system in other coordinates, as modal blocks for instance"
    )]
    Contradiction {
        /// The equation that does not hold.
        what: &'static str,
        /// By how much.
        residual: f64,
    },
    /// An iteration reached its limit.
    #[error("{what}: no convergence after {iterations} iterations (residual {residual:.1e})")]
    NoConvergence {
        /// The iteration.
        what: &'static str,
        /// Limit reached.
        iterations: usize,
        /// Last residual.
        residual: f64,
    },
}
