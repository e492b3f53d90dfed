//! Commands.

mod batch_plan;
mod compare_batch;
mod console;
pub mod program;
mod start_files;
mod unstable_loops;
