//! Progress on standard error: a line per finished step and a spinner for the running one; silent when nobody watches.
//!
//! When standard error is no terminal nothing is written, so that logs and pipes hold results and errors only.

use super::console::Console;
use super::timings::Stopwatch;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Progress of one command.
pub struct Progress {
    bar: ProgressBar,
    watch: Mutex<Stopwatch>,
}

impl Progress {
    /// Progress on the terminal, or a silent one.
    pub fn start(console: &Console) -> Self {
        let visible = console.shows_progress() && std::io::stderr().is_terminal();
        let bar = if visible {
            ProgressBar::new_spinner()
        } else {
            ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden())
        };
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} {elapsed}") {
            bar.set_style(style);
        }
        if visible {
            bar.enable_steady_tick(Duration::from_millis(120));
        }
        Self {
            bar,
            watch: Mutex::new(Stopwatch::start()),
        }
    }

    /// Times of the stages of a design.
    pub fn watch(&self) -> MutexGuard<'_, Stopwatch> {
        self.watch.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is being done now.
    pub fn stage(&self, what: impl Into<String>) {
        self.bar.set_message(what.into());
    }

    /// A finished step stays on the terminal as a line: one D-K iteration, the result of a stage.
    pub fn line(&self, text: impl AsRef<str>) {
        self.bar.println(text);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
