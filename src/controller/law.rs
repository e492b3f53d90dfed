//! A controller with its name, u = K y, in continuous or sampled time. Channel order front_x, front_y, rear_x, rear_y.

use crate::linalg::{Mat, c64};
use crate::lti::responder::FrequencyResponder;
use crate::lti::{Continuous, Discrete, HeldResponse, StateSpace};

/// The law itself, in its own time base.
#[derive(Clone, Debug)]
pub enum ControlLaw {
    /// u = K(s) y.
    Continuous(StateSpace<Continuous>),
    /// u = K(z) y.
    Discrete(StateSpace<Discrete>),
}

impl ControlLaw {
    /// True when the other law has the same coefficients in the same time base.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Discrete(a), Self::Discrete(b)) => a.is_same(b),
            (Self::Continuous(a), Self::Continuous(b)) => a.is_same(b),
            _ => false,
        }
    }
}

/// A named controller: u (A) from y (m), positive feedback.
#[derive(Clone, Debug)]
pub struct Controller {
    /// Name shown in reports.
    pub name: String,
    /// The law.
    pub law: ControlLaw,
}

/// The machine that a controller was designed for. Paths are relative to the folder of the controller file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MachineTag {
    /// Path of the spindle file.
    pub spindle: String,
    /// Path of the tool file.
    pub tool: String,
    /// SHA-256 of spindle and tool as the program writes them, hex: layout and comments of the files do not count.
    pub hash: String,
}

impl Controller {
    /// The response, prepared for many frequencies.
    pub(crate) fn responder(&self) -> Box<dyn HeldResponse> {
        match &self.law {
            ControlLaw::Continuous(k) => Box::new(FrequencyResponder::new(k)),
            ControlLaw::Discrete(k) => Box::new(FrequencyResponder::new(k)),
        }
    }
}

impl HeldResponse for Controller {
    fn held_at(&self, omega_rad_s: f64) -> Mat<c64> {
        match &self.law {
            ControlLaw::Continuous(k) => k.held_at(omega_rad_s),
            ControlLaw::Discrete(k) => k.held_at(omega_rad_s),
        }
    }
}
