//! One integration binary: less linking of heavy dependencies.
mod architecture;
mod augment;
mod connections;
mod control_cases;
mod dfit;
mod dk;
mod firmware;
mod input_files;
mod mu_constant;
mod mu_system;
mod plots;
mod results_folder;
mod rotor_cases;
mod rotor_reference;
mod spindle_effects;
mod spindle_plant;
mod update_reference;
