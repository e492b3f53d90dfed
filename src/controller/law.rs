//! A controller with its name, u = K y, in continuous or sampled time. Channel order front_x, front_y, rear_x, rear_y.

use crate::linalg::{Mat, c64};
use crate::lti::{Continuous, Discrete, Response, StateSpace};

/// The law itself, in its own time base.
#[derive(Clone, Debug)]
pub enum ControlLaw {
    /// u = K(s) y.
    Continuous(StateSpace<Continuous>),
    /// u = K(z) y.
    Discrete(StateSpace<Discrete>),
}

/// A named controller: u (A) from y (m), positive feedback.
#[derive(Clone, Debug)]
pub struct Controller {
    /// Name shown in reports.
    pub name: String,
    /// The law.
    pub law: ControlLaw,
}

impl Response for Controller {
    fn at(&self, omega_rad_s: f64) -> Mat<c64> {
        match &self.law {
            ControlLaw::Continuous(k) => k.at(omega_rad_s),
            ControlLaw::Discrete(k) => k.at(omega_rad_s),
        }
    }
}
