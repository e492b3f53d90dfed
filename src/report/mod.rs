//! Files out: results folder, tables, plots, HTML. Gets finished results, never computes.

pub mod atomic;
pub mod comparison;
pub mod comparison_figures;
pub mod controller_json;
pub mod design_summary;
pub mod diagnosis;
pub mod diagnosis_tables;
pub mod diagnosis_words;
pub mod firmware;
pub mod firmware_c;
pub mod frequency_table;
pub mod html;
pub mod identification;
pub mod mat;
pub mod plot;
pub mod readable;
pub mod results;
pub mod run_figures;
pub mod run_summary;
pub mod simulation;
pub mod summary;
pub mod tables;
pub mod uff;
pub mod updating;
pub mod worst;
