//! `--timings`: wall and processor time of each stage of a long command, on standard error.

use rustix::time::{ClockId, clock_gettime};
use std::io::Write;
use std::time::Instant;

/// The option, for commands that take seconds or longer.
#[derive(clap::Args, Debug, Default, Clone, Copy)]
pub(super) struct Timings {
    /// Print wall and processor time of each stage to standard error
    #[arg(long)]
    timings: bool,
}

impl Timings {
    pub(super) fn are_asked(self) -> bool {
        self.timings
    }

    pub(super) fn print(self, watch: &Stopwatch) {
        if self.timings {
            // Nobody reads a closed standard error.
            let _ = std::io::stderr().write_all(watch.table().as_bytes());
        }
    }
}

struct Lap {
    stage: String,
    wall_s: f64,
    /// Of all threads of the process.
    processor_s: f64,
}

/// Adds up the times of stages.
pub(crate) struct Stopwatch {
    laps: Vec<Lap>,
    wall: Instant,
    processor_s: f64,
}

impl Stopwatch {
    pub(crate) fn start() -> Self {
        Self { laps: vec![], wall: Instant::now(), processor_s: processor_s() }
    }

    /// Leaves what has passed since the last lap out of every stage.
    pub(crate) fn skip(&mut self) {
        (self.wall, self.processor_s) = (Instant::now(), processor_s());
    }

    /// Ends a stage: the time since the last end belongs to it. Stages of one name are added.
    pub(crate) fn lap(&mut self, stage: &str) {
        let wall_s = self.wall.elapsed().as_secs_f64();
        let own_s = processor_s() - self.processor_s;
        self.skip();
        match self.laps.iter_mut().find(|l| l.stage == stage) {
            Some(lap) => {
                lap.wall_s += wall_s;
                lap.processor_s += own_s;
            }
            None => self.laps.push(Lap { stage: stage.to_owned(), wall_s, processor_s: own_s }),
        }
    }

    fn table(&self) -> String {
        let row = |stage: &str, wall: f64, processor: f64| {
            // The width counts characters, as a terminal does.
            format!("{stage:<34}{wall:>9.3} s{processor:>11.3} s\n")
        };
        let mut text = format!("{:<34}{:>11}{:>13}\n", "stage", "wall", "processor");
        let mut total = (0.0, 0.0);
        for lap in &self.laps {
            text.push_str(&row(&lap.stage, lap.wall_s, lap.processor_s));
            total = (total.0 + lap.wall_s, total.1 + lap.processor_s);
        }
        text.push_str(&row("in all", total.0, total.1));
        text
    }
}

/// Processor time of the process so far, s.
fn processor_s() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
