//! The report of one tool of a batch.

use super::run::run_report;
use super::whole::{Report, ReportError};
use super::worst::worst_records;
use crate::augment::weights::Weights;
use crate::pipeline::batch::Finished;

/// Page, controller and files of one tool.
pub(crate) fn tool_report(found: &Finished, weights: &Weights) -> Result<Report, ReportError> {
    let run = &found.run;
    let (mut report, _) = run_report(run, &weights.name, None)?;
    // Of an unstable loop there is no worst case.
    let first = usize::from(run.design.instability.is_some());
    for (name, worst) in ["mu", "pid"].iter().zip(&found.worst).skip(first) {
        let records = worst_records(worst);
        report.summary.set(&format!("worst_case.{name}"), records);
    }
    let pid = run.pid().map(|p| &p.controller);
    report.controller("", &run.machine, &run.design, pid)?;
    Ok(report)
}
