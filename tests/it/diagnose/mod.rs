//! The diagnosis.

mod diagnose_alike;
mod diagnose_command;
mod diagnose_confusion;
mod diagnose_examples;
mod diagnose_folder;
mod diagnose_localise;
mod diagnose_matrix;
mod diagnose_model;
mod diagnose_next;
mod diagnose_records;
mod diagnose_rehearsed;
mod diagnose_rotor;
mod diagnose_small;
pub mod generator;
mod masses_at_ports;
