//! `muspin`: from spindle drawing and measured sweeps to a robust magnetic-bearing controller that firmware can load.
//!
//! The modules are the pipeline, in order; each may use those above it, never the reverse.
#![warn(missing_docs)]

pub mod augment;
pub mod cli;
pub mod controller;
pub mod diagnose;
pub mod guide;
pub mod identify;
pub mod input;
pub mod linalg;
pub mod lti;
pub mod pipeline;
pub mod predict;
pub mod report;
pub mod robust;
pub mod rotor;
pub mod spindle;
pub mod update;
