//! Sweeps and their plausibility.

mod column_slips;
mod identify_sweeps;
mod polluted_lines;
mod record_plausibility;
