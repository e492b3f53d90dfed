//! Progress of the reading of long records.

use super::Failure;
use super::console::Console;
use super::progress::Progress;
use crate::input::file::ReadShare;
use crate::input::{Measurement, load_measurement_watched};
use std::cell::OnceCell;

/// Shortest file whose reading is shown, bytes: a shorter one is read within a second.
const SHOWN_BYTES: u64 = 32 << 20;

/// The progress of one command; it begins with the first long file.
pub(super) struct ReadingProgress<'a> {
    console: &'a Console,
    progress: OnceCell<Progress>,
}

impl<'a> ReadingProgress<'a> {
    pub(super) fn start(console: &'a Console) -> Self {
        Self { console, progress: OnceCell::new() }
    }

    /// Shows how far the reading of a file has come.
    pub(super) fn see(&self, share: ReadShare<'_>) {
        if share.all_bytes >= SHOWN_BYTES {
            show(self.progress.get_or_init(|| Progress::start(self.console)), share);
        }
    }
}

/// Shows on a progress that runs already how far the reading of a file has come.
pub(super) fn show(progress: &Progress, share: ReadShare<'_>) {
    if share.all_bytes >= SHOWN_BYTES {
        let percent = 100.0 * share.done_bytes as f64 / share.all_bytes as f64;
        let name = share.file.file_name().unwrap_or_default().to_string_lossy();
        progress.stage(format!("reading {name}: {percent:.0} %"));
    }
}

/// The records of a measurement, with progress on a terminal.
pub(super) fn load_measurement(source: &str, console: &Console) -> Result<Measurement, Failure> {
    let reading = ReadingProgress::start(console);
    Ok(load_measurement_watched(source, &|share| reading.see(share))?)
}
