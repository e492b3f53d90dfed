//! Linear time-invariant systems: state space with its time base in the type, connections, responses.

pub mod connect;
pub mod delay;
pub mod response;
pub mod state_space;

pub use response::{FrequencyGrid, Response};
pub use state_space::{Continuous, Discrete, StateSpace, TimeBase};
