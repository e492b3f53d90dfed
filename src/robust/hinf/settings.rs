//! What an H∞ synthesis searches for, and how closely.

/// What to search for and how closely.
#[derive(Clone, Debug)]
pub struct HinfSettings {
    /// Level of the central controller; none: search the optimum.
    pub gamma: Option<f64>,
    /// Relative tolerance of the optimum.
    pub rel_tol: f64,
    /// The controller is delivered at γ_opt·(1 + slack), or further off when that one fails its check.
    pub slack: f64,
    /// A level near the optimum, from an earlier similar problem; saves evaluations, changes no result.
    pub hint: Option<f64>,
}

impl Default for HinfSettings {
    fn default() -> Self {
        Self { gamma: None, rel_tol: 1e-7, slack: 1e-3, hint: None }
    }
}
