//! Designs and whole runs.

mod bracket;
mod design_options;
mod growth;
mod least_mu;
mod problem_files;
mod real_corners;
mod shank_limit;
mod thrust;
mod updated_levels;
mod whole_machine;
mod whole_machine_mu;
mod whole_machine_run;
