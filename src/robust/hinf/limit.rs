//! The smallest feasible level, and what keeps it from being lowered.

/// The condition that fails just below the optimal level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// The coupling ρ(XY) < γ² of the control and the filter Riccati equation.
    Coupling,
    /// The control Riccati equation: with all states and disturbances measured, no control reaches a lower level at
    /// this frequency (rad/s).
    ControlSide {
        /// Infinite where the feedthrough binds.
        omega_rad_s: f64,
    },
    /// The filter Riccati equation: no estimate of the errors reaches a lower level at this frequency (rad/s).
    FilterSide {
        /// Infinite where the feedthrough binds.
        omega_rad_s: f64,
    },
    /// The control Riccati solution X, which passes infinity and turns indefinite.
    ControlIndefinite,
    /// The filter Riccati solution Y, which passes infinity and turns indefinite.
    FilterIndefinite,
    /// None: the infimum is zero and not attained; the level is where rounding ends the search.
    Rounding,
}

/// The smallest feasible level.
#[derive(Clone, Copy, Debug)]
pub(super) struct Optimum {
    pub gamma: f64,
    pub limit: Limit,
}
