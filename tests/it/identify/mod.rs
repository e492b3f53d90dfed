//! Sweeps and their plausibility.

mod identify_sweeps;
mod polluted_lines;
mod record_plausibility;
