//! One tool of a batch: the run, the worst cases of its controllers, and how far its specification could be tightened.

use super::PipelineError;
use super::progress::{Event, Listener};
use super::run::{Run, Task, run};
use super::settings::DesignSettings;
use super::tightening::largest_tightening;
use super::worst::{WorstPrediction, worst_predictions};
use crate::predict::sensitivity::Zone;

/// Smallest factor on the tool's specification that the search tries.
const SMALLEST_FACTOR: f64 = 1.0 / 64.0;

/// A finished tool.
#[derive(Clone, Debug)]
pub struct Finished {
    /// Controller, rivals, predictions.
    pub run: Run,
    /// Worst cases over uncertain modes from rest to top speed: of the delivered controller, and of the tuned PID.
    pub worst: Vec<Vec<WorstPrediction>>,
    /// True when the design meets its targets and the loop at rest is better than zone D.
    pub met: bool,
    /// Largest factor on the tool's specification with µ ≤ 1, 0 where none was found; absent where it was not sought,
    /// as for an unstable design.
    pub tightening: Option<f64>,
}

/// Runs one tool; the largest tightening is sought on demand, and where the specification is missed.
pub(crate) fn one_tool(
    task: &Task<'_>,
    tightening: bool,
    listen: &mut Listener<'_>,
) -> Result<Finished, PipelineError> {
    let run = run(task, listen)?;
    listen(Event::Begins("worst cases"));
    let machine = &run.machine;
    let controllers = std::iter::once(&run.design.delivery.controller);
    let worst = controllers
        .chain(run.pid().map(|p| &p.controller))
        .map(|c| {
            let top_rpm = machine.spindle.max_rpm;
            worst_predictions(machine, c, &[], top_rpm, &task.weights.mode_uncertainty)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let zone = run.delivered[0].zone();
    let met = run.design.meets_targets() && zone.is_some_and(|zone| zone < Zone::D);
    let tightening = if (met && !tightening) || run.design.instability.is_some() {
        None
    } else {
        listen(Event::Begins("largest tightening"));
        let factor = largest_tightening(machine, task.weights, &DesignSettings::default())?;
        // The end of the search's range: no factor was found that is met.
        Some(if factor > SMALLEST_FACTOR { factor } else { 0.0 })
    };
    Ok(Finished { run, worst, met, tightening })
}
