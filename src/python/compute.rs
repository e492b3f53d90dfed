//! A computation on a thread of its own: Python's other threads go on, Ctrl-C raises `KeyboardInterrupt` at once, and
//! a defect of the computation becomes a `RuntimeError`.

use crate::workflow::Failure;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// How often Python is asked for signals.
const POLL: Duration = Duration::from_millis(50);

/// Stack of a computation: that of a main thread.
const STACK_BYTES: usize = 8 << 20;

/// Tells a computation that nobody waits for it any more.
#[derive(Clone, Default)]
pub(super) struct Stop(Arc<AtomicBool>);

/// What a stopped computation unwinds with.
struct Stopped;

impl Stop {
    /// Ends the computation here when it has been interrupted; to be called where it reports its progress.
    pub(super) fn here(&self) {
        if self.0.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Stopped));
        }
    }
}

/// Ends the computation here with an exception of Python.
pub(super) fn end_with(error: PyErr) {
    resume_unwind(Box::new(error));
}

/// The result of `work`.
///
/// # Errors
/// `ValueError` with the words of a failure, `KeyboardInterrupt` after Ctrl-C, `RuntimeError` for a panic of the
/// computation.
pub(super) fn compute<T: Send + 'static>(
    python: Python<'_>,
    work: impl FnOnce(&Stop) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let stop = Stop::default();
    let (sender, receiver) = channel();
    let inner = stop.clone();
    let worker = std::thread::Builder::new().stack_size(STACK_BYTES);
    let worker = worker.spawn(move || {
        let found = catch_unwind(AssertUnwindSafe(|| work(&inner)));
        // Nobody listens after an interruption.
        let _ = sender.send(found);
    });
    if let Err(error) = worker {
        return Err(PyRuntimeError::new_err(format!("no thread for the computation: {error}")));
    }
    let found = python.detach(move || {
        loop {
            match receiver.recv_timeout(POLL) {
                Ok(found) => return Ok(found),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(PyRuntimeError::new_err("the computation ended without a result"));
                }
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(interrupted) = Python::attach(|python| python.check_signals()) {
                        stop.0.store(true, Ordering::Relaxed);
                        return Err(interrupted);
                    }
                }
            }
        }
    })?;
    match found {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(failure)) => Err(failure_error(&failure)),
        Err(payload) if payload.is::<PyErr>() => Err(payload
            .downcast::<PyErr>()
            .map_or_else(|_| PyRuntimeError::new_err("the computation ended without a result"), |error| *error)),
        Err(payload) => Err(PyRuntimeError::new_err(format!(
            "a defect of muspin, please report it: {}",
            panic_words(payload.as_ref())
        ))),
    }
}

/// A `ValueError` with the words of a failure, hint included, without the `error:` that a terminal shows.
pub(super) fn failure_error(failure: &Failure) -> PyErr {
    let text = failure.to_string();
    PyValueError::new_err(text.strip_prefix("error: ").unwrap_or(&text).trim_end().to_owned())
}

/// The message of a panic.
fn panic_words(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| payload.downcast_ref::<&str>().copied());
    text.unwrap_or("a panic without a message").to_owned()
}
