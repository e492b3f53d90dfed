//! The push into the backup bearings: figure, figures by key, and a sentence.

use super::pictures::Picture;
use super::plot::Role;
use super::simulation::{RecoverySummary, push_figure};
use super::summary::{Named, finite};
use super::whole::{Report, ReportError};
use crate::pipeline::contact::Contact;
use crate::pipeline::simulation::SimulationLimits;
use crate::predict::recovery::Recovery;
use crate::predict::time::TimeResponse;
use crate::spindle::Machine;
use serde::Serialize;

/// `simulation.contact`.
#[derive(Clone, Debug, Serialize)]
struct ContactSummary {
    force_n: Option<f64>,
    speed_rpm: Option<f64>,
    /// By controller.
    #[serde(flatten)]
    recoveries: Named<RecoverySummary>,
}

/// Adds the picture `contact` and the `simulation.contact` object; the sentence about them.
pub(crate) fn add_contact(report: &mut Report, machine: &Machine, contact: &Contact) -> Result<String, ReportError> {
    let limits = SimulationLimits { current_a: contact.current_limit_a, voltage_v: contact.voltage_limit_v };
    let (force_n, top_rpm) = (contact.force_n, contact.speed_rpm);
    let mut runs = vec![("mu", "μ", Role::Mu, &contact.delivered)];
    runs.extend(contact.pid.iter().map(|r| ("pid", "PID", Role::Pid, r)));
    let mut sentences = Vec::new();
    let mut recoveries = Vec::new();
    for (key, name, _, response) in &runs {
        let recovery = Recovery::of(machine, response);
        recoveries.push(((*key).to_owned(), RecoverySummary::from(recovery)));
        sentences.push(format!("with the {name} controller {}", recovery.sentence()));
    }
    report.summary.set(
        "simulation.contact",
        ContactSummary { force_n: finite(force_n), speed_rpm: finite(top_rpm), recoveries: Named(recoveries) },
    );
    let shown: Vec<(&str, Role, &TimeResponse)> = runs.iter().map(|(_, name, role, r)| (*name, *role, *r)).collect();
    let title = format!("Push of {force_n:.0} N at the tool, {top_rpm:.0} rpm");
    report.figures([(Picture::Contact, push_figure(machine, &title, &shown, &limits))])?;
    Ok(format!(
        "After a half-sine push of {force_n:.0} N and {:.1} ms at the tool at {top_rpm:.0} rpm: {}.",
        1e3 * contact.length_s,
        sentences.join("; ")
    ))
}
