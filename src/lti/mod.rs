//! Linear time-invariant systems: state space with its time base in the type, connections, responses.

pub mod balance;
pub mod connect;
pub mod delay;
pub mod energy_norm;
pub mod held;
pub(crate) mod level_set;
pub(crate) mod line_maximum;
pub mod matched;
pub mod norm;
pub(crate) mod partial_fractions;
pub(crate) mod pole_residues;
pub(crate) mod responder;
pub(crate) mod response;
pub mod sample;
pub(crate) mod scale;
pub(crate) mod state_space;
pub(crate) mod structure;
pub(crate) mod zeros;

pub use held::HeldResponse;
pub use responder::FrequencyResponder;
pub use response::{FrequencyGrid, Response};
pub use state_space::{Continuous, Discrete, StateSpace, TimeBase};
