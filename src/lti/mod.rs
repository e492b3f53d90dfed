//! Linear time-invariant systems: state space with its time base in the type, connections, responses.

pub mod balance;
pub mod connect;
pub mod delay;
pub mod held;
pub mod level_set;
pub mod norm;
pub mod responder;
pub mod response;
pub mod sample;
pub mod scale;
pub mod state_space;
pub mod structure;

pub use held::HeldResponse;
pub use responder::FrequencyResponder;
pub use response::{FrequencyGrid, Response};
pub use state_space::{Continuous, Discrete, StateSpace, TimeBase};
