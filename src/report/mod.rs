//! Files out: results folder, tables, plots, HTML. Gets finished results, never computes.

pub mod atomic;
