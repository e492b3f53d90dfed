//! The PID that the μ controller is compared with: two axes with notches, searched within the amplifier limits of the
//! machine, and its certificate; and a PID with given numbers.

pub mod certificate;
mod descents;
pub mod given;
mod law;
pub mod parameters;
mod rigid_bearing;
mod search;
pub mod settings;
pub mod shifted_loops;
mod start;
pub mod surviving;
pub mod thrust;
pub mod tune;
