//! A design with its progress on a terminal.

use super::Failure;
use super::progress::Progress;
use crate::augment::weights::Weights;
use crate::pipeline::design::{Design, design};
use crate::pipeline::progress::{Event, STAGES, next_stage, usual_share};
use crate::pipeline::settings::DesignSettings;
use crate::spindle::Machine;

/// The design with default settings and the polish, with a line per iteration on a terminal.
pub(super) fn run_design(
    machine: &Machine,
    weights: &Weights,
    progress: &Progress,
) -> Result<Design, Failure> {
    run_design_with(machine, weights, &DesignSettings::polished(), progress)
}

/// The design with a line per iteration on a terminal.
pub(super) fn run_design_with(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
    progress: &Progress,
) -> Result<Design, Failure> {
    progress.part("design");
    progress.watch().skip();
    let found = design(machine, weights, settings, &mut |event| {
        told(progress, event);
    })?;
    if let Some(polish) = &found.polish {
        progress.line(polish.sentence.clone());
    }
    if let Some(scale) = &found.specification_scale {
        progress.line(scale.sentence());
    }
    Ok(found)
}

/// Tells an event: on a terminal, and to the watch of the stages.
pub(super) fn told(progress: &Progress, event: Event) {
    match event {
        Event::Stage(stage) => {
            progress.watch().lap(stage);
            if let Some((done, next)) = next_stage(stage) {
                let (of, in_all) = (STAGES.len(), progress.in_all(usual_share(done)));
                progress.stage(format!(
                    "design, {done} of {of} stages done, about {in_all} in all: {next}"
                ));
            }
        }
        Event::Begins(part) => {
            progress.part(part);
            progress.watch().skip();
        }
        Event::Found(words) => progress.line(words),
        Event::Step(step) => progress.line(match &step.failure {
            Some(failure) => format!("D-K step {}: failed: {failure}", step.iteration + 1),
            None => format!(
                "D-K step {}: γ {:.4}, peak of μ {:.4}, order {} (D orders {:?})",
                step.iteration + 1,
                step.gamma,
                step.mu_peak,
                step.controller_order,
                step.d_orders
            ),
        }),
    }
}
