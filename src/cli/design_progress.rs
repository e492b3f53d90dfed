//! What a design tells, on a terminal.

use super::progress::Progress;
use crate::pipeline::progress::{Event, STAGES, next_stage, usual_share};
use crate::robust::dk::DkStep;

/// Tells an event: on a terminal, and to the watch of the stages.
pub(super) fn told(progress: &Progress, event: Event) {
    match event {
        Event::Stage(stage) => {
            progress.end_stage(stage);
            if let Some((done, next)) = next_stage(stage) {
                let (of, in_all) = (STAGES.len(), progress.in_all(usual_share(done)));
                progress.stage(format!("design, {done} of {of} stages done, about {in_all} in all: {next}"));
            }
        }
        Event::Begins(part) => progress.part(part),
        Event::Found(words) => progress.line(words),
        Event::Step(step) => progress.line(step_words(step)),
    }
}

/// Tells an event of one of several designs that run at a time: no watch can tell their stages apart.
pub(super) fn told_of(progress: &Progress, name: &str, event: Event) {
    match event {
        Event::Stage(stage) => {
            if let Some((_, next)) = next_stage(stage) {
                progress.stage(format!("{name}: {next}"));
            }
        }
        Event::Begins(part) => progress.stage(format!("{name}: {part}")),
        Event::Found(words) => progress.line(format!("{name}: {words}")),
        Event::Step(step) => progress.line(format!("{name}: {}", step_words(step))),
    }
}

fn step_words(step: &DkStep) -> String {
    match &step.failure {
        Some(failure) => format!("D-K step {}: failed: {failure}", step.iteration + 1),
        None => format!(
            "D-K step {}: γ {:.4}, peak of μ {:.4}, order {} (D orders {:?})",
            step.iteration + 1,
            step.gamma,
            step.mu_peak,
            step.controller_order,
            step.d_orders
        ),
    }
}
