//! Commands.

mod batch_plan;
mod compare_batch;
mod console;
mod design_from;
mod pid;
pub mod program;
mod start_files;
mod unstable_designs;
mod unstable_loops;
