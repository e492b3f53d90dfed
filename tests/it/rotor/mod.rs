//! The rotor and its spectrum.

pub mod own_spectrum;
mod rotor_cases;
pub mod rotor_reference;
mod supported;
mod whirl_shapes;
