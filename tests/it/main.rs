//! One integration binary: less linking of heavy dependencies.
mod augment;
mod connections;
mod rotor_cases;
mod rotor_reference;
mod control_cases;
mod mu_constant;
mod update_reference;
mod diagnose_folder;
mod diagnose_model;
mod diagnose_examples;
