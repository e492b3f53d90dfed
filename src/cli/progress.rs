//! Progress on standard error: a line per finished step and a spinner for the running one; silent when nobody watches.
//!
//! When standard error is no terminal nothing is written, so that logs and pipes hold results and errors only.

use super::console::Console;
use super::timings::{Stopwatch, Timings};
use crate::input::quote::{printable, printable_lines};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

pub(crate) struct Progress {
    bar: ProgressBar,
    watch: Mutex<Stopwatch>,
    /// The stage that [`Progress::timed`] began.
    timed: Mutex<Option<String>>,
    start: Instant,
    /// When the part of the command began that runs now.
    part: Mutex<Instant>,
}

impl Progress {
    /// Progress on the terminal, or a silent one.
    pub(crate) fn start(console: &Console) -> Self {
        let visible = console.shows_progress() && std::io::stderr().is_terminal();
        let bar = if visible {
            ProgressBar::new_spinner()
        } else {
            ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden())
        };
        if let Ok(style) = ProgressStyle::with_template("{spinner} {prefix}{msg} {elapsed}") {
            bar.set_style(style);
        }
        if visible {
            bar.enable_steady_tick(Duration::from_millis(120));
        }
        Self {
            bar,
            watch: Mutex::new(Stopwatch::start()),
            timed: Mutex::new(None),
            start: Instant::now(),
            part: Mutex::new(Instant::now()),
        }
    }

    /// What is being done now.
    pub(crate) fn stage(&self, what: impl Into<String>) {
        self.bar.set_message(printable(&what.into()).into_owned());
    }

    /// A stage begins whose time counts until the next one begins.
    pub(crate) fn start_stage(&self, what: impl Into<String>) {
        self.end_timed();
        let what = what.into();
        lock(&self.watch).skip();
        self.stage(what.clone());
        *lock(&self.timed) = Some(what);
    }

    /// A stage of a part has ended: the time counts for it, and not for the part that [`Progress::timed`] began.
    pub(crate) fn end_stage(&self, stage: &str) {
        *lock(&self.timed) = None;
        lock(&self.watch).lap(stage);
    }

    /// Ends the stage that [`Progress::timed`] began, if one runs.
    fn end_timed(&self) {
        let running = lock(&self.timed).take();
        if let Some(stage) = running {
            lock(&self.watch).lap(&stage);
        }
    }

    /// Ends the last stage and the progress; the times of all stages are told where they are asked for.
    pub(super) fn end(self, timings: Timings) {
        self.end_timed();
        timings.print(&lock(&self.watch));
    }

    /// A part of the command begins, such as a design; it is timed, as a whole or by the stages that it ends.
    pub(crate) fn part(&self, what: &str) {
        *lock(&self.part) = Instant::now();
        self.start_stage(what);
    }

    /// Time that the part will take in all when the share `done` of it has taken what it has.
    pub(crate) fn in_all(&self, done: f64) -> String {
        let begun = *lock(&self.part);
        minutes(begun.elapsed().as_secs_f64() / done)
    }

    /// How many of several equal parts are done; the time that the rest will take is estimated from them.
    pub(crate) fn share(&self, done: usize, of: usize) {
        let left = match done {
            0 => String::new(),
            _ => {
                let each_s = self.start.elapsed().as_secs_f64() / done as f64;
                format!(", about {} left", minutes(each_s * (of - done) as f64))
            }
        };
        self.bar.set_prefix(format!("[{done} of {of}{left}] "));
    }

    /// A finished step stays on the terminal as a line: one D-K iteration, the result of a stage.
    pub(crate) fn line(&self, text: impl AsRef<str>) {
        self.bar.println(printable_lines(text.as_ref()));
    }
}

/// What a lock guards, also where a thread has panicked with it.
pub(super) fn lock<T>(guarded: &Mutex<T>) -> MutexGuard<'_, T> {
    guarded.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A time in minutes and seconds.
fn minutes(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..60 => format!("{whole} s"),
        _ => format!("{} min {} s", whole / 60, whole % 60),
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
