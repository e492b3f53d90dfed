//! What a designer may set, with the defaults of the reference run.

use crate::augment::plane::Route;
use crate::lti::{Discrete, StateSpace};
use crate::robust::dk::DkSettings;

/// What a designer may turn, with the defaults of the reference run.
#[derive(Clone, Debug)]
pub struct DesignSettings {
    /// Flexible modes in the design model beyond the spindle's `flexible_modes`.
    pub guard_modes: usize,
    /// Flexible modes that the synthesis sees beyond the guard modes, without uncertainty of their own, at most those
    /// below half the sample rate. With fewer, the design adds some when μ of the whole machine exceeds one.
    pub extra_modes: usize,
    /// Shares of the gyroscopic split of the guard modes to cover, the first with which the target can be reached; none
    /// of it when all fail. The whole split as a complex uncertainty asks for more damping than a mode beyond the band
    /// can get, none leaves μ of the rotating plant above one there (1.3 at 4.6 kHz on the reference spindle): 0.4
    /// brings it to what it is at rest.
    pub guard_cover: Vec<f64>,
    /// Direct sampled design, or emulation.
    pub route: Route,
    /// Bounds on the complementary sensitivity to try, tightest first, when the weights leave it open.
    pub sensitivity_limits: Vec<f64>,
    /// Level that the optimal γ with constant scales must reach for a bound on T to be accepted.
    pub gamma_target: f64,
    /// Where the target is out of reach, the cover of the gyroscopic split gives way mode by mode, then the limits of
    /// the specification.
    pub give_way: bool,
    /// Relative growth of μ that reduction may cost, as long as μ stays below one.
    pub reduction_budget: f64,
    /// Settings of the D-K iteration.
    pub dk: DkSettings,
    /// Speeds checked between zero and the top speed, evenly spaced, both ends included.
    pub speeds: usize,
    /// Effort of the polish after the reduction; `None`, the default: the reduced controller of the D-K iteration is
    /// delivered.
    pub polish: Option<PolishEffort>,
    /// An earlier design, say of the previous tool, from whose controller the polish starts first.
    pub earlier: Option<EarlierDesign>,
}

/// What a design takes over from an earlier one; every certificate is computed anew.
#[derive(Clone, Debug)]
pub struct EarlierDesign {
    /// Its sampled controller of one plane, m to A.
    pub plane: StateSpace<Discrete>,
    /// Its constant scales, one per block; may be empty.
    pub scales: Vec<f64>,
    /// Whether the D-K iteration is left out where the polish of this controller meets every goal.
    pub suffices: bool,
}

impl Default for DesignSettings {
    fn default() -> Self {
        Self {
            guard_modes: 1,
            extra_modes: 0,
            guard_cover: vec![0.4, 0.2],
            route: Route::Direct,
            sensitivity_limits: vec![3.5, 4.0, 4.5, 5.0, 6.0, 8.0, 12.0],
            // What reduction may cost is kept free.
            gamma_target: 1.0 / 1.02,
            give_way: true,
            reduction_budget: 0.02,
            // Constant scales come first, so the iteration starts close: two steps with low-order scales settle it.
            dk: DkSettings {
                max_iterations: 3,
                max_d_order: 2,
                patience: 1,
                min_improvement: 2e-3,
                descent_steps: 6,
                // Half a percent of μ is no difference in a loop that is polished afterwards.
                least_gap: 5e-3,
                ..DkSettings::default()
            },
            speeds: 11,
            polish: None,
            earlier: None,
        }
    }
}

impl DesignSettings {
    /// With the polish: what the commands deliver.
    #[must_use]
    pub fn with_polish() -> Self {
        Self { polish: Some(PolishEffort::default()), ..Self::default() }
    }
}

/// How long a controller is polished.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PolishEffort {
    /// Rounds of descent; the lines are renewed between them.
    pub rounds: usize,
    /// Steps of a round at most.
    pub steps: usize,
    /// Further rounds at most, each with a line at the peak of μ that the certificate found.
    pub cuts: usize,
    /// Steps of such a round at most.
    pub cut_steps: usize,
    /// Further rounds at most in which the limit on μ is below what the loop has, where that exceeds one.
    pub lowerings: usize,
}

impl Default for PolishEffort {
    /// Eighty steps, and more as long as a round gains one percent.
    fn default() -> Self {
        Self { rounds: 2, steps: 40, cuts: 4, cut_steps: 15, lowerings: 0 }
    }
}
