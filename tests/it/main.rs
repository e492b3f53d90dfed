//! One integration binary: less linking of heavy dependencies.
mod architecture;
mod augment;
mod connections;
mod control_cases;
mod dfit;
mod firmware;
mod mu_constant;
mod plots;
mod results_folder;
mod rotor_cases;
mod rotor_reference;
mod update_reference;
