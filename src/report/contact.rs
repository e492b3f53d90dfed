//! The push into the backup bearings: figure, figures by key, and a sentence.

use super::plot::Role;
use super::simulation::{Limits, push_figure, recovery_json};
use super::summary::number;
use super::whole::{Report, ReportError};
use crate::pipeline::contact::Contact;
use crate::predict::recovery::Recovery;
use crate::predict::time::TimeResponse;
use crate::spindle::Machine;

/// Adds the picture `contact` and the `simulation.contact` object; the sentence about them.
///
/// # Errors
/// [`ReportError`] when the picture cannot be drawn.
pub fn add_contact(
    report: &mut Report,
    machine: &Machine,
    contact: &Contact,
) -> Result<String, ReportError> {
    let limits = Limits {
        current_a: contact.current_limit_a,
        voltage_v: contact.voltage_limit_v,
    };
    let (force_n, top_rpm) = (contact.force_n, contact.speed_rpm);
    let mut runs = vec![("mu", "μ", Role::Mu, &contact.delivered)];
    runs.extend(contact.pid.iter().map(|r| ("pid", "PID", Role::Pid, r)));
    let summary = &mut report.summary;
    summary.set("simulation.contact.force_n", number(force_n));
    summary.set("simulation.contact.speed_rpm", number(top_rpm));
    let mut sentences = Vec::new();
    for (key, name, _, response) in &runs {
        let recovery = Recovery::of(machine, response);
        let key = format!("simulation.contact.{key}");
        summary.set(&key, recovery_json(recovery));
        sentences.push(format!(
            "with the {name} controller {}",
            recovery.sentence()
        ));
    }
    let shown: Vec<(&str, Role, &TimeResponse)> = runs
        .iter()
        .map(|(_, name, role, r)| (*name, *role, *r))
        .collect();
    let title = format!("Push of {force_n:.0} N at the tool, {top_rpm:.0} rpm");
    report.figures([("contact", push_figure(machine, &title, &shown, &limits))])?;
    Ok(format!(
        "After a half-sine push of {force_n:.0} N and {:.1} ms at the tool at {top_rpm:.0} rpm: {}.",
        1e3 * contact.length_s,
        sentences.join("; ")
    ))
}
