//! Why firmware files cannot be made.

use crate::controller::ControllerError;
use thiserror::Error;

/// Failure of the export.
#[derive(Debug, Error)]
pub enum FirmwareError {
    /// The arithmetic cannot hold the controller.
    #[error(transparent)]
    Controller(#[from] ControllerError),
    /// The `.mat` file could not be made.
    #[error("controller.mat: {0}")]
    Mat(#[from] std::io::Error),
    /// Controllers that cannot share a table.
    #[error("controller {prefix}: it has {what}")]
    Table {
        /// Its prefix.
        prefix: String,
        /// What differs, and what to do.
        what: &'static str,
    },
    /// A C file could not be rendered.
    #[error("C template: {0}")]
    Template(#[from] minijinja::Error),
    /// Only sampled controllers run on a processor.
    #[error("{0}: firmware needs a sampled controller; discretise it first")]
    Continuous(String),
}
