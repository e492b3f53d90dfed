//! One integration binary: less linking of heavy dependencies.

// A test tells its story in one piece.
#![allow(clippy::too_many_lines)]

/// The allocator of the program: tests inside this process take as long as its commands.
#[cfg(feature = "cli")]
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

mod architecture;
mod augment;
mod cli;
mod controller;
mod diagnose;
mod export;
mod file_circles;
mod identify;
mod input;
mod linalg;
mod lti;
mod pid;
mod pipeline;
mod predict;
mod report;
mod robust;
mod rotor;
mod spindle;
mod support;
mod update;
