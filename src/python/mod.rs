//! The module `muspin._native` of Python: solvers on numpy arrays, a spindle with its stages, the command line.
//!
//! Built with the feature `python` (`pip install .`). The package in `src/python/muspin` gives these functions the
//! argument order and the named results that users of python-control and MATLAB expect.
// The macros of pyo3 expand to unsafe code; nothing else here is.
#![allow(unsafe_code)]

mod compute;
mod convert;
mod machine;
mod measured;
mod results;
mod solvers;

use crate::robust::hinf::regularise::DEFAULT_SHARE;
use pyo3::prelude::*;

/// Runs the command line with `arguments`, the name of the program first; returns its exit code.
#[pyfunction]
fn run(python: Python<'_>, arguments: Vec<String>) -> u8 {
    python.detach(|| crate::cli::run(arguments.into_iter().map(Into::into)))
}

/// The native part of the package `muspin`.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("REGULARISATION", DEFAULT_SHARE)?;
    module.add_function(wrap_pyfunction!(run, module)?)?;
    module.add_class::<machine::NativeMachine>()?;
    module.add_class::<results::NativeResults>()?;
    solvers::register(module)
}
