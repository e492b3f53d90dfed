//! One integration binary: less linking of heavy dependencies.
mod augment;
mod connections;
mod control_cases;
mod dfit;
mod firmware;
mod identify_sweeps;
mod mu_constant;
mod plots;
mod rotor_cases;
mod rotor_reference;
mod uff;
mod update_reference;
