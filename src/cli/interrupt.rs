//! Ctrl-C: says whether anything was written. An interruption while files are being written waits until they are whole.

use crate::report::writing;

/// Exit code of an interrupted program: 128 and the number of the signal, as shells have it.
const INTERRUPTED: i32 = 130;

/// Answers interruptions from now on. Where the system has no signals to answer, the program ends silently as usual.
pub fn answer() {
    let _ = ctrlc::set_handler(|| {
        let words = match writing::finish() {
            true => "interrupted: the files of this run were written",
            false => "interrupted: nothing was written",
        };
        eprintln!("\n{words}");
        std::process::exit(INTERRUPTED);
    });
}
