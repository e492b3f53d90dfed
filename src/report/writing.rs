//! Whether files of this process are being written or were written, for whoever ends the process early.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// True once a results folder has been replaced; locked while one is.
static WRITTEN: Mutex<bool> = Mutex::new(false);

fn written() -> MutexGuard<'static, bool> {
    WRITTEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs a replacement of files that nobody may cut short.
pub(super) fn uninterrupted<T, E>(write: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
    let mut written = written();
    let result = write();
    *written |= result.is_ok();
    result
}

/// Waits for a replacement that is running and keeps others from starting; true when files were written.
pub fn finish() -> bool {
    let written = written();
    let any = *written;
    // The process ends: nothing may be written any more.
    std::mem::forget(written);
    any
}
