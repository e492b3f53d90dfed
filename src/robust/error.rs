//! Why a synthesis problem has no controller to return: the assumption, the level, the frequency, and what to do.

use crate::linalg::NumericError;
use crate::linalg::riccati::RiccatiError;
use crate::lti::norm::NormError;
use thiserror::Error;

/// Condition of the two-Riccati test that fails at a level γ.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum Condition {
    /// γ is not above the largest gain that the direct feedthrough D11 leaves whatever K(∞) is (Parrott).
    #[error("gamma is below what D11 leaves for any controller ({bound:.6e})")]
    Feedthrough {
        /// Lower bound from D11.
        bound: f64,
    },
    /// The Hamiltonian of X has an eigenvalue on the axis: a frequency where no control brings the gain below γ.
    #[error(
        "the control Hamiltonian has an eigenvalue on the axis at {omega_rad_s:.6e} rad/s (no level below {bound:.6e} \
         exists there)"
    )]
    ControlAxis {
        /// Smallest level of that condition.
        bound: f64,
        /// Its frequency, rad/s.
        omega_rad_s: f64,
    },
    /// The Hamiltonian of Y has an eigenvalue on the axis.
    #[error(
        "the filter Hamiltonian has an eigenvalue on the axis at {omega_rad_s:.6e} rad/s (no level below {bound:.6e} \
         exists there)"
    )]
    FilterAxis {
        /// Smallest level of that condition.
        bound: f64,
        /// Its frequency, rad/s.
        omega_rad_s: f64,
    },
    /// X ≥ 0 fails.
    #[error("X is indefinite")]
    ControlIndefinite,
    /// Y ≥ 0 fails.
    #[error("Y is indefinite")]
    FilterIndefinite,
    /// ρ(XY) < γ² fails.
    #[error("the spectral radius of XY is {ratio:.6e} gamma^2")]
    Coupling {
        /// ρ(XY)/γ².
        ratio: f64,
    },
    /// No Riccati solver found a stabilising solution; `control` tells X from Y.
    #[error("no stabilising Riccati solution was found")]
    Unsolved,
}

/// Failure of a synthesis.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SynthesisError {
    /// Channel counts that do not fit.
    #[error("generalized plant: {0}")]
    Partition(String),
    /// An unstable or undamped mode that u does not reach.
    #[error("(A, B2) is not stabilisable: the control inputs do not reach the mode at {re:.6e} {im:+.6e}j rad/s")]
    NotStabilisable {
        /// Real part of the eigenvalue.
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// An unstable or undamped mode that y does not see.
    #[error("(C2, A) is not detectable: the measurements do not see the mode at {re:.6e} {im:+.6e}j rad/s")]
    NotDetectable {
        /// Real part of the eigenvalue.
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// D12 has no full column rank.
    #[error("D12 ({rows} x {cols}) has no full column rank: singular values {smallest:.3e} to {largest:.3e}")]
    ControlCost {
        /// Rows.
        rows: usize,
        /// Columns.
        cols: usize,
        /// Smallest singular value after column scaling.
        smallest: f64,
        /// Largest one.
        largest: f64,
    },
    /// D21 has no full row rank.
    #[error("D21 ({rows} x {cols}) has no full row rank: singular values {smallest:.3e} to {largest:.3e}")]
    MeasurementNoise {
        /// Rows.
        rows: usize,
        /// Columns.
        cols: usize,
        /// Smallest singular value after row scaling.
        smallest: f64,
        /// Largest one.
        largest: f64,
    },
    /// A synthesis failed, and D12 or D21 is almost without rank beside the rest of the plant.
    #[error(
        "{which} ({rows} x {cols}) is almost rank deficient: smallest singular value {smallest:.3e}, {relative:.1e} \
         of the gain that its channels reach over frequency; with it: {source}"
    )]
    WeakFeedthrough {
        /// "D12" or "D21".
        which: &'static str,
        /// Rows.
        rows: usize,
        /// Columns.
        cols: usize,
        /// Smallest singular value.
        smallest: f64,
        /// The same after division by the largest gain of each control (measurement) over frequency.
        relative: f64,
        /// How the synthesis failed.
        source: Box<SynthesisError>,
    },
    /// P12 or P21 has a zero on the imaginary axis.
    #[error("{which} has a zero on the imaginary axis at {omega_rad_s:.6e} rad/s")]
    AxisZero {
        /// "P12 (u to z)" or "P21 (w to y)".
        which: &'static str,
        /// Frequency, rad/s.
        omega_rad_s: f64,
    },
    /// The Riccati equation of the γ = ∞ problem has no solution, for no reason above.
    #[error("{which} Riccati equation at gamma = infinity: {source}")]
    Regulator {
        /// "control" or "filter".
        which: &'static str,
        /// Reason.
        source: RiccatiError,
    },
    /// The level asked for cannot be reached.
    #[error("no controller achieves gamma = {gamma:.6e}: {condition}")]
    Infeasible {
        /// Level.
        gamma: f64,
        /// Condition that fails.
        condition: Condition,
    },
    /// The search found no level at all.
    #[error("no feasible level found up to gamma = {gamma:.6e}: {condition}")]
    NoLevel {
        /// Largest level tried.
        gamma: f64,
        /// Condition that fails there.
        condition: Condition,
    },
    /// A controller was formed, but an independent check refutes it.
    #[error(
        "controller at gamma = {gamma:.6e} fails its check: closed-loop norm {norm:.6e}, growth rate \
         {growth_rate:.3e} 1/s"
    )]
    Refuted {
        /// Level.
        gamma: f64,
        /// Closed-loop norm, infinity when unstable.
        norm: f64,
        /// Closed-loop growth rate, 1/s.
        growth_rate: f64,
    },
    /// A norm that could not be computed.
    #[error(transparent)]
    Norm(#[from] NormError),
    /// A numeric failure.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}

impl SynthesisError {
    /// What to do about it.
    pub fn advice(&self) -> &'static str {
        match self {
            Self::Partition(_) => "check m1, m2, p1, p2 against B, C and D",
            Self::NotStabilisable { .. } => {
                "give a weight with a pole on the axis a small damping, or move it so that u drives it"
            }
            Self::NotDetectable { .. } => {
                "give a weight with a pole on the axis a small damping, or move it so that y sees it"
            }
            Self::ControlCost { .. } => {
                "weight every control input at high frequency: each u needs its own error z with a direct term"
            }
            Self::MeasurementNoise { .. } => {
                "add noise to every measurement: each y needs its own disturbance w with a direct term"
            }
            Self::WeakFeedthrough { which: "D12", .. } => {
                "raise the weight on the control inputs: each u needs an error z with a direct term that counts \
                 beside the others"
            }
            Self::WeakFeedthrough { .. } => {
                "raise the noise on the measurements: each y needs a disturbance w with a direct term that counts \
                 beside the others"
            }
            Self::AxisZero { .. } => {
                "shift the zero off the axis: a small stable weight instead of an integrator, a little damping, or a \
                 small extra channel"
            }
            Self::Infeasible { .. } => "ask for a larger gamma, or let the search find the optimum",
            Self::Regulator { .. } | Self::NoLevel { .. } | Self::Refuted { .. } => {
                "check the scaling of states and channels, and modes that are almost unreachable or unobservable"
            }
            Self::Norm(_) | Self::Numeric(_) => "check the data for extreme or inconsistent entries",
        }
    }
}
