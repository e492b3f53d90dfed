//! Summary, pictures and files of a whole run.

use super::contact::add_contact;
use super::design_summary::design_topic;
use super::identification::identification_topic;
use super::margins::margin_topic;
use super::pictures::Picture;
use super::pid_summary::{OF_DELIVERED, no_pid_topic, pid_topic};
use super::plot::Role;
use super::plot::loops::MarkedFrequency;
use super::prediction_summary::damping_ratios;
use super::run_figures::{open_loop, predictions, robustness, shapes};
use super::unstable::add_instability;
use super::updating::{figures as update_figures, updating_topic};
use super::variant_summary::arithmetic_topic;
use super::whole::{Report, ReportError};
use crate::identify::Identification;
use crate::pipeline::certificates::mu_words;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::design::NO_FIRMWARE;
use crate::pipeline::loop_stability::unstable_words;
use crate::pipeline::model_curves::FreeRotor;
use crate::pipeline::overspeed::OVERSPEED;
use crate::pipeline::run::{CriticalCut, Curves, Rival, Rivals, Run};
use crate::predict::stiffness::stiffness_words;
use crate::spindle::Machine;
use crate::update::{PeakKind, Targets};
use serde_json::{Value, json};

/// Look of the controller of the D-K iteration beside the polished one.
pub(crate) const UNPOLISHED: Role = Role::Other(2);

/// Flexible modes whose frequency and damping are listed.
const LISTED_FREQUENCIES: usize = 5;
const LISTED_DAMPING: usize = 3;

/// The report of a run and its outcome in sentences; pictures where the run has curves.
pub(crate) fn run_report(
    run: &Run,
    weights: &str,
    identification: Option<&Identification>,
) -> Result<(Report, String), ReportError> {
    let mut report = Report::of("run", &run.machine);
    report.summary.set("weights", weights);
    add_models(&mut report, run, identification);
    report.summary.set("design", design_topic(&run.design));
    if add_instability(&mut report, &run.design) {
        if let Some(curves) = &run.curves {
            add_model_pictures(&mut report, run, curves)?;
        }
        return Ok((report, run.design.instability_words().unwrap_or_default()));
    }
    report.summary.set("design.arithmetic", arithmetic_topic(&run.design, &run.arithmetic));
    add_loops(&mut report, run);
    if let Some(curves) = &run.curves {
        add_pictures(&mut report, run, curves)?;
    }
    let words = plain_words(run);
    let mut sentences = vec![words.clone()];
    if let Some(contact) = &run.contact {
        sentences.push(add_contact(&mut report, &run.machine, contact)?);
    }
    report.summary.set("outcome", outcome_topic(run));
    report.summary.set("plain_words", sentences);
    Ok((report, words))
}

/// Frequencies of the models, what was identified, and what updating did.
fn add_models(report: &mut Report, run: &Run, identification: Option<&Identification>) {
    let [nominal, used] = &run.rotors;
    let summary = &mut report.summary;
    summary.set("model.nominal", model_topic(&run.nominal, nominal));
    summary.set("model.used", model_topic(&run.machine, used));
    if let Some(found) = identification {
        summary.set("identification", identification_topic(found));
    }
    if let Some(updating) = &run.updating {
        summary.set("updating", updating_topic(&updating.gauss_newton.fit));
        if let Some(search) = &updating.nelder_mead {
            summary.set("updating.nelder_mead", updating_topic(&search.fit));
        }
    }
}

/// Names of the machine, and natural frequencies of its free rotor at rest.
fn model_topic(machine: &Machine, rotor: &FreeRotor) -> Value {
    let mut listed = rotor.modes.flexible_hz();
    listed.truncate(LISTED_FREQUENCIES);
    json!({ "spindle": machine.spindle.name, "tool": machine.tool.name, "flexible_frequencies_hz": listed })
}

/// Controllers that are compared: key, look, predictions at rest and at top speed.
fn loops(run: &Run) -> Vec<(&'static str, Role, &[Prediction; 2])> {
    let rivals = run.rivals.as_ref();
    let found =
        |of: fn(&Rivals) -> &Rival| rivals.and_then(|r| of(r).as_ref().ok().map(|(_, predictions)| predictions));
    [
        ("mu", Role::Mu, Some(&run.delivered)),
        ("dk", UNPOLISHED, run.unpolished.as_ref()),
        ("pid", Role::Pid, found(|r| &r.tuned)),
        ("textbook_pid", Role::TextbookPid, found(|r| &r.textbook)),
    ]
    .into_iter()
    .filter_map(|(key, role, both)| Some((key, role, both?)))
    .collect()
}

/// Stiffness, sensitivity and damping of the loops, and what the PID search found.
fn add_loops(report: &mut Report, run: &Run) {
    let damped = run.rotors[1].modes.flexible_hz().len();
    let damped = damped.min(LISTED_DAMPING);
    for (name, _, both) in loops(run) {
        report.predictions(name, both.each_ref());
        let damping = damping_ratios(&both[0], damped);
        report.summary.set(&format!("damping_ratio.{name}"), damping);
    }
    if let Some(rivals) = &run.rivals {
        let pid = match &rivals.tuned {
            Ok((found, _)) => pid_topic(found, &rivals.effort, OF_DELIVERED),
            Err(reason) => no_pid_topic(&not_found_words(reason)),
        };
        report.summary.set("pid", pid);
        if let Ok((plain, _)) = &rivals.textbook {
            let stable = plain.certificate.nominal.is_stable();
            report.summary.set("pid.textbook_stable", stable);
        }
    }
}

fn add_model_pictures(report: &mut Report, run: &Run, curves: &Curves) -> Result<(), ReportError> {
    if let Some(updating) = &run.updating {
        let fits = [("updated", &updating.gauss_newton.fit)];
        report.figures(update_figures(Some(&run.nominal), &fits))?;
    }
    // The machine that is used comes last.
    let names = [("nominal", Role::Nominal), ("updated", Role::Updated)];
    let names = names.iter().skip(names.len().saturating_sub(curves.open_loop.len()));
    let models: Vec<_> = names.zip(&curves.open_loop).map(|((name, role), of)| (*name, *role, of)).collect();
    let marked = run.targets.as_ref().map(marks).unwrap_or_default();
    report.figures(open_loop(&models, &marked))?;
    // Updating draws the shapes before and after itself.
    if run.updating.is_none() {
        let figure = shapes("updated", Role::Updated, &run.machine, &run.rotors[1]);
        report.figures([(Picture::ModeShapes, figure)])?;
    }
    Ok(())
}

/// The pictures, from the model to the loop.
fn add_pictures(report: &mut Report, run: &Run, curves: &Curves) -> Result<(), ReportError> {
    add_model_pictures(report, run, curves)?;
    let loops = loops(run);
    let ends = [0, 1].into_iter().flat_map(|k| loops.iter().map(move |(_, role, both)| (*role, &both[k])));
    let shown: Vec<(Role, &Prediction)> = ends.collect();
    let top_hz = run.machine.spindle.max_rpm / 60.0;
    let drawn = robustness(&run.design).into_iter();
    report.figures(drawn.chain(predictions(&shown, &[], top_hz)))?;
    let top_rpm = run.machine.spindle.max_rpm;
    report.loop_of("mu", &curves.closed_loop, run.delivered.each_ref(), top_rpm)?;
    if let Some(margins) = &curves.pid_margins {
        report.summary.set("margins.pid", margin_topic(margins));
    }
    Ok(())
}

fn marks(targets: &Targets) -> [Vec<MarkedFrequency>; 2] {
    [0, 1].map(|bearing| {
        let resonances = targets.resonances.iter().flatten().map(|t| (t, PeakKind::Resonance));
        let zeros = targets
            .antiresonances
            .get(bearing)
            .into_iter()
            .flat_map(|f| f.antiresonances.iter().flatten())
            .map(|t| (t, PeakKind::Antiresonance));
        resonances.chain(zeros).map(|(t, peak)| MarkedFrequency { frequency_hz: t.frequency_hz, peak }).collect()
    })
}

/// A search that found nothing, in a sentence.
fn not_found_words(reason: &str) -> String {
    format!("No PID was found ({reason}); its figures are absent.")
}

/// A line of `outcome`: a figure with what was asked of it, or what the tuned PID reaches.
fn outcome_row(figure: impl Into<String>, reached: impl Into<String>, target: impl Into<String>) -> Value {
    json!({ "figure": figure.into(), "reached": reached.into(), "target": target.into() })
}

fn cut_row(cut: &CriticalCut) -> Value {
    let words = |depth: Option<f64>| match depth {
        None => "unstable without a cut".to_owned(),
        Some(m) if m.is_finite() => format!("{:.3} mm", 1e3 * m),
        Some(_) => "no chatter".to_owned(),
    };
    let figure = format!(
        "critical depth of cut, {} teeth, aluminium, down milling over half the diameter, at top speed",
        cut.teeth
    );
    outcome_row(figure, words(cut.delivered_m), format!("tuned PID: {}", words(cut.pid_m)))
}

/// The figures that a run is judged by: five, and the depth of cut of a tool with teeth.
fn outcome_topic(run: &Run) -> Vec<Value> {
    let (design, [rest, _]) = (&run.design, &run.delivered);
    let delivery = &design.delivery;
    let over_rpm = OVERSPEED * run.machine.spindle.max_rpm;
    let stiffness = |p: &Prediction| {
        if p.is_stable() {
            format!("{} at {:.0} Hz", stiffness_words(p.minimum.0), p.minimum.1)
        } else {
            unstable_words(p.growth_rate_per_s, p.speed_rpm)
        }
    };
    let pid = run.rivals.as_ref().and_then(|rivals| rivals.tuned.as_ref().ok());
    let beside = |words: &dyn Fn(&Prediction) -> String| {
        pid.map_or("no tuned PID".to_owned(), |(_, [pid, _])| format!("tuned PID: {}", words(pid)))
    };
    let mut rows = vec![
        outcome_row("µ of the specification at rest", delivery.rounded.specification.words(), "at most 1"),
        outcome_row(
            format!("µ of the specification, largest from rest to {over_rpm:.0} rpm"),
            mu_words(design.largest_mu()),
            "at most 1",
        ),
        outcome_row(
            "stability proven from rest to",
            format!("{:.0} rpm", delivery.speed_proof.proven_to_rpm()),
            format!("{over_rpm:.0} rpm"),
        ),
        outcome_row(
            "zone of ISO 14839-3 at rest",
            rest.zone_word(),
            format!("A to C; {}", beside(&|pid| pid.zone_word().to_owned())),
        ),
        outcome_row("smallest tool stiffness at rest", stiffness(rest), beside(&stiffness)),
    ];
    rows.extend(run.cut.as_ref().map(cut_row));
    rows
}

/// The outcome in one sentence, and what stands in the way of a firmware or a met specification.
fn plain_words(run: &Run) -> String {
    let design = &run.design;
    let met = design.largest_mu() <= 1.0;
    let specification = if met { "meets its specification" } else { "misses its specification" };
    let stable = if design.is_stable() { "is stable at every speed" } else { "is NOT proven stable at every speed" };
    let machine = format!("{} with {}", run.machine.spindle.name, run.machine.tool.name);
    let mut words = format!("{machine}: the controller {specification} and {stable}.");
    if run.pid_is_better() {
        words = format!("The PID is better in every figure. {words}");
    }
    if let Some(Err(reason)) = run.rivals.as_ref().map(|rivals| &rivals.tuned) {
        words = format!("{words} {}", not_found_words(reason));
    }
    if let Some(scale) = &design.specification_scale {
        words = format!("{words} {}", scale.sentence());
    }
    if design.has_firmware() { words } else { format!("{words} {NO_FIRMWARE}") }
}
