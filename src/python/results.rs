//! Results of a stage as Python holds them: figures, and files that are written on demand.

use super::compute::{Stop, compute};
use super::convert::to_value_error;
use crate::report::results::ResultsFolder;
use crate::report::whole::Report;
use crate::workflow::Failure;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::Path;

/// Figures and files.
#[pyclass(name = "Results", frozen)]
pub(super) struct NativeResults {
    figures: String,
    folder: ResultsFolder,
}

impl NativeResults {
    /// A report with its page.
    pub(super) fn of(mut report: Report) -> Result<Self, Failure> {
        report.finish()?;
        Ok(Self { figures: report.summary.to_json(), folder: report.folder })
    }

    /// Files without figures.
    pub(super) fn files_only(folder: ResultsFolder) -> Self {
        Self { figures: "{}".to_owned(), folder }
    }
}

#[pymethods]
impl NativeResults {
    /// The figures as JSON.
    fn figures(&self) -> &str {
        &self.figures
    }

    /// Paths of the files.
    fn names(&self) -> Vec<String> {
        self.folder.files().map(|(name, _)| name.to_owned()).collect()
    }

    /// The bytes of a file; none where there is no such file.
    fn file<'py>(&self, python: Python<'py>, name: &str) -> Option<Bound<'py, PyBytes>> {
        let found = self.folder.files().find(|(path, _)| *path == name);
        found.map(|(_, bytes)| PyBytes::new(python, bytes))
    }

    /// Writes all files into a folder, whole or not at all.
    fn write(&self, folder: &str) -> PyResult<()> {
        self.folder.write(Path::new(folder)).map_err(to_value_error)
    }
}

/// The results of a computation that ends in a report.
pub(super) fn results(
    python: Python<'_>,
    work: impl FnOnce(&Stop) -> Result<Report, Failure> + Send + 'static,
) -> PyResult<NativeResults> {
    compute(python, move |stop| NativeResults::of(work(stop)?))
}
