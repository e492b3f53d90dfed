//! The time base of a problem. A sampled system is solved in the w plane, s = (2/T)(z − 1)/(z + 1), where gains, μ and
//! Hankel values are the same, and what is found there is mapped back.

use super::answer::system;
use super::{Answer, Failure, ProblemFields};
use crate::linalg::NumericError;
use crate::lti::sample::{inverse_tustin, tustin};
use crate::lti::{Continuous, Discrete, StateSpace};

/// The time base: none is continuous time.
#[derive(Clone, Copy)]
pub(super) struct Clock(pub(super) Option<Discrete>);

impl Clock {
    pub(super) fn of(problem: &ProblemFields) -> Result<Self, Failure> {
        Ok(Self(problem.sample_time()?))
    }

    /// The system of a problem in the plane of the solvers.
    pub(super) fn plane_system(self, problem: &ProblemFields) -> Result<StateSpace<Continuous>, Failure> {
        Ok(self.in_plane(problem.system()?)?)
    }

    /// Matrices as a problem gives them in that plane.
    pub(super) fn in_plane(self, given: StateSpace<Continuous>) -> Result<StateSpace<Continuous>, NumericError> {
        match self.0 {
            None => Ok(given),
            Some(time) => inverse_tustin(&given.with_time(time)),
        }
    }

    /// A system of that plane as one of the problem.
    pub(super) fn answer(self, found: &StateSpace<Continuous>) -> Result<Answer, NumericError> {
        Ok(match self.0 {
            None => system(found),
            Some(time) => sampled_system(&tustin(found, time.period_s)?),
        })
    }

    /// A frequency of that plane as a true one, rad/s.
    pub(super) fn true_frequency(self, omega_rad_s: f64) -> f64 {
        self.0.map_or(omega_rad_s, |time| time.true_frequency(omega_rad_s))
    }

    /// The distance of the poles from the limit of stability under the name that it has.
    pub(super) fn with_stability(self, answer: Answer, growth_rate: f64) -> Answer {
        match self.0 {
            None => answer.with_number("closed_loop_max_real", growth_rate),
            Some(time) => answer.with_number("closed_loop_max_abs", (growth_rate * time.period_s).exp()),
        }
    }
}

/// A sampled system as `{A, B, C, D, Ts}`.
pub(super) fn sampled_system(s: &StateSpace<Discrete>) -> Answer {
    system(s).with_number("Ts", s.time.period_s)
}
