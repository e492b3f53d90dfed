//! Commands.

mod batch_plan;
mod compare_batch;
mod console;
mod design_from;
pub mod program;
mod start_files;
mod unstable_designs;
mod unstable_loops;
