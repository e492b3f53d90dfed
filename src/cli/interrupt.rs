//! Ctrl-C: says whether anything was written. An interruption while files are being written waits until they are whole.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Exit code of an interrupted program: 128 and the number of the signal, as shells have it.
const INTERRUPTED: i32 = 130;

/// Whether files of the command were written, shared with whoever answers interruptions; locked while one is written.
#[derive(Clone, Debug, Default)]
pub(crate) struct Writing(Arc<Mutex<bool>>);

impl Writing {
    fn lock_written(&self) -> MutexGuard<'_, bool> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn hold_interrupts<T, E>(&self, write: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        let mut written = self.lock_written();
        let result = write();
        *written |= result.is_ok();
        result
    }

    /// Answers interruptions from now on. Where the system has no signals to answer, the program ends silently as
    /// usual.
    pub(crate) fn answer_interruptions(&self) {
        let own = self.clone();
        let _ = ctrlc::set_handler(move || {
            // Waits for files that are being written. The guard lives until the process ends: no others are begun.
            let written = own.lock_written();
            let words = if *written {
                "interrupted: the files of this run were written"
            } else {
                "interrupted: nothing was written"
            };
            eprintln!("\n{words}");
            std::process::exit(INTERRUPTED);
        });
    }
}
