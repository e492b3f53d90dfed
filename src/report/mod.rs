//! Files out: results folder, tables, plots, HTML. Gets finished results, never computes.

pub mod atomic;
pub mod plot;
pub mod tables;
