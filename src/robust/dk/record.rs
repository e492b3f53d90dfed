//! What a D-K iteration is asked, what it records and what it returns.

use super::scale::DScales;
use crate::linalg::NumericError;
use crate::lti::{Continuous, StateSpace, TimeBase};
use crate::robust::error::SynthesisError;
use crate::robust::structure::MuError;
use thiserror::Error;

/// Why a D-K iteration has nothing to return.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DkError {
    /// The blocks do not fit the plant.
    #[error(
        "the blocks have {rows} inputs and {cols} outputs, the plant has {disturbances} disturbances and {errors} \
         errors"
    )]
    Blocks {
        /// Σ rows of the blocks.
        rows: usize,
        /// Σ cols of the blocks.
        cols: usize,
        /// dim w.
        disturbances: usize,
        /// dim z.
        errors: usize,
    },
    /// The first synthesis failed: there is no controller to start from.
    #[error("the first synthesis of the D-K iteration failed: {0}")]
    Synthesis(#[from] SynthesisError),
    /// The μ of the first loop could not be computed.
    #[error("the loop of the D-K iteration could not be analysed: {0}")]
    Mu(#[from] MuError),
    /// A connection failed.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}

/// What to iterate for.
#[derive(Clone, Debug)]
pub struct DkSettings {
    /// Syntheses at most.
    pub max_iterations: usize,
    /// Largest order of a scale; the controller has the order of the plant plus Σ orders·(rows + cols).
    pub max_d_order: usize,
    /// Stop as soon as the peak of μ is below this.
    pub target_mu: Option<f64>,
    /// Stop when this many steps in a row improve the best peak by less than `min_improvement`.
    pub patience: usize,
    /// Relative improvement that counts.
    pub min_improvement: f64,
    /// Slack of the certificate of the answer.
    pub certificate_slack: f64,
    /// Frequencies (rad/s) that the fits of D are to follow; none: decades round the poles of the plant.
    pub fit_range_rad_s: Option<(f64, f64)>,
    /// Share of γ by which the peak of μ of a loop has to lie below it for scales of higher order to pay: they lower γ
    /// towards that peak. 0: they are always tried.
    pub least_gap: f64,
    /// Steps of the descent on γ that follows the alternation; 0: alternation only.
    pub descent_steps: usize,
}

impl Default for DkSettings {
    fn default() -> Self {
        Self {
            max_iterations: 3,
            max_d_order: 4,
            target_mu: None,
            patience: 2,
            min_improvement: 3e-4,
            // A twentieth of the 1e-3 that a claimed μ may be off by.
            certificate_slack: 5e-5,
            fit_range_rad_s: None,
            least_gap: 0.0,
            descent_steps: 90,
        }
    }
}

/// Record of one step.
#[derive(Clone, Debug)]
pub struct DkStep {
    /// Number of the step, from 0.
    pub iteration: usize,
    /// γ of the synthesis; NaN when it failed.
    pub gamma: f64,
    /// Largest pointwise μ bound of the loop, for full complex blocks and in the steps of the mixed iteration for the
    /// blocks as they are; NaN when the step failed.
    pub mu_peak: f64,
    /// Its frequency, rad/s.
    pub peak_omega_rad_s: f64,
    /// Order of the controller; 0 when the step failed.
    pub controller_order: usize,
    /// Orders of the scales that the synthesis used, without the performance block.
    pub d_orders: Vec<usize>,
    /// What went wrong in this step; the earlier best is kept.
    pub failure: Option<String>,
}

/// The best controller met, with its certificate.
#[derive(Clone, Debug)]
pub struct DkOutcome<T: TimeBase = Continuous> {
    /// u = K y.
    pub controller: StateSpace<T>,
    /// No frequency has a larger μ bound (certified).
    pub mu_peak: f64,
    /// Lower bound of μ at the peak.
    pub mu_lower_peak: f64,
    /// Frequency of the peak, rad/s.
    pub peak_omega_rad_s: f64,
    /// γ of the synthesis that gave the controller.
    pub gamma: f64,
    /// Scales of that synthesis.
    pub scales: DScales,
    /// Number of that step.
    pub best_iteration: usize,
    /// Records of all steps.
    pub steps: Vec<DkStep>,
}
