//! Designs and whole runs.

mod design_options;
mod problem_files;
mod whole_machine;
mod whole_machine_mu;
mod whole_machine_run;
