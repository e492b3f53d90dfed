//! Sweeps and their plausibility.

mod column_slips;
mod identify_sweeps;
mod measured_plant;
mod modal_sums;
mod partial_records;
mod polluted_lines;
mod record_plausibility;
mod spectra;
