//! Sweeps and their plausibility.

mod identify_sweeps;
mod record_plausibility;
