//! The push into the backup bearings: figure, figures by key, and a sentence.

use super::pictures::Picture;
use super::plot::Role;
use super::simulation::{push_figure, recovery_topic};
use super::whole::{Report, ReportError};
use crate::pipeline::contact::Contact;
use crate::pipeline::simulation::SimulationLimits;
use crate::predict::recovery::Recovery;
use crate::spindle::Machine;
use serde_json::json;

/// Adds the picture `contact` and the `simulation.contact` object; the sentence about them.
pub(crate) fn add_contact(report: &mut Report, machine: &Machine, contact: &Contact) -> Result<String, ReportError> {
    let limits = SimulationLimits { current_a: contact.current_limit_a, voltage_v: contact.voltage_limit_v };
    let (force_n, top_rpm) = (contact.force_n, contact.speed_rpm);
    let mut runs = vec![("μ", Role::Mu, &contact.delivered)];
    runs.extend(contact.pid.iter().map(|response| ("PID", Role::Pid, response)));
    let mut sentences = Vec::new();
    let mut topic = json!({ "force_n": force_n, "speed_rpm": top_rpm });
    for (key, (name, _, response)) in ["mu", "pid"].into_iter().zip(&runs) {
        let recovery = Recovery::of(machine, response);
        topic[key] = recovery_topic(recovery);
        sentences.push(format!("with the {name} controller {}", recovery.sentence()));
    }
    report.summary.set("simulation.contact", topic);
    let title = format!("Push of {force_n:.0} N at the tool, {top_rpm:.0} rpm");
    report.figures([(Picture::Contact, push_figure(machine, &title, &runs, &limits))])?;
    Ok(format!(
        "After a half-sine push of {force_n:.0} N and {:.1} ms at the tool at {top_rpm:.0} rpm: {}.",
        1e3 * contact.length_s,
        sentences.join("; ")
    ))
}
