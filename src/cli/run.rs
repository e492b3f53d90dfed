//! `muspin run`: the whole pipeline, from drawing and measurement to firmware tables and a report.

use super::console::Console;
use super::controlled_machine::{MachineArguments, machine_tag};
use super::design::{
    UNPOLISHED, add_arithmetic, add_controller, add_loop, add_predictions, finish, of_unpolished,
    outcome, shown_design,
};
use super::design_progress::run_design;
use super::machine::of_measurement;
use super::output::{REPORT, claim};
use super::plausibility::Records;
use super::progress::Progress;
use super::timings::Timings;
use super::update::targets;
use super::{Failure, Outcome};
use crate::controller::Controller;
use crate::controller::pid_certificate::TunedPid;
use crate::controller::pid_settings::TuneSettings;
use crate::controller::pid_tune::{found_or_reason, textbook, tune};
use crate::input::{load_measurement, load_weights, spindle_yaml, tool_yaml};
use crate::pipeline::certificates::mu_words;
use crate::pipeline::comparison::{Prediction, better_in_every_figure, predict, rival_settings};
use crate::pipeline::design::Design;
use crate::pipeline::loop_stability::unstable_words;
use crate::pipeline::overspeed::OVERSPEED;
use crate::predict::stiffness::stiffness_words;
use crate::report::comparison::pid_json;
use crate::report::controller_json::controller_json;
use crate::report::identification::identification_json;
use crate::report::plot::Role;
use crate::report::plot::loops::{MarkedFrequency, Peak};
use crate::report::results::ResultsFolder;
use crate::report::run_figures::{open_loop, predictions, robustness, shapes};
use crate::report::run_summary::{design_json, machine_json, modal_damping_json};
use crate::report::summary::Summary;
use crate::report::updating::{figures as update_figures, updating_json};
use crate::rotor::modes::PlanarModes;
use crate::spindle::Machine;
use crate::update::{Targets, UpdateSettings, UpdatedMachine, gauss_newton, nelder_mead};
use serde_json::json;
use std::f64::consts::TAU;

/// Arguments of `muspin run`.
#[derive(clap::Args, Debug)]
pub struct Arguments {
    /// Spindle file or shipped name; default: that of the measurement, or the reference
    #[arg(long)]
    spindle: Option<String>,
    /// Tool file or shipped name; default: that of the measurement, or the paper's
    #[arg(long)]
    tool: Option<String>,
    /// Weights file, or the name of a shipped one
    #[arg(long, default_value = "benchmark")]
    weights: String,
    /// Measurement folder or file of frequencies to update the model with; default: the published frequencies for the
    /// reference spindle, none for another
    #[arg(long)]
    measurement: Option<String>,
    /// Folder for the results
    #[arg(long, default_value = "results/reference")]
    out: String,
    #[command(flatten)]
    timings: Timings,
}

impl Default for Arguments {
    fn default() -> Self {
        Self {
            spindle: None,
            tool: None,
            weights: "benchmark".into(),
            measurement: None,
            out: "results/reference".into(),
            timings: Timings::default(),
        }
    }
}

/// A PID, or the reason why none was found.
type Rival = Result<TunedPid, String>;

/// What updating gave.
struct Updating {
    machine: Machine,
    gauss_newton: UpdatedMachine,
    nelder_mead: UpdatedMachine,
    targets: Targets,
    identification: Option<crate::identify::Identification>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, console: &Console) -> Result<Outcome, Failure> {
    let weights = load_weights(&arguments.weights)?;
    let named = [&arguments.spindle, &arguments.tool, &arguments.measurement];
    let read = named.into_iter().flatten().chain([&arguments.weights]);
    claim(&arguments.out, &REPORT, read.map(String::as_str))?;
    let progress = Progress::start(console);
    let nominal_files = MachineArguments {
        spindle: arguments.spindle.clone(),
        tool: arguments.tool.clone(),
    };
    let source = match (&arguments.measurement, &arguments.spindle) {
        (Some(given), _) => Some(given.clone()),
        (None, None) => Some("paper-frequencies".to_owned()),
        (None, Some(_)) => None,
    };
    let (nominal, updating) = match &source {
        None => (nominal_files.alone()?, None),
        Some(source) => {
            progress.stage("model updating");
            let measurement = load_measurement(source)?;
            let nominal = of_measurement(
                &measurement,
                arguments.spindle.as_deref(),
                arguments.tool.as_deref(),
            )?;
            let found = update(&measurement, &nominal)?;
            (nominal, Some(found))
        }
    };
    let machine = updating.as_ref().map_or(&nominal, |u| &u.machine);
    if let Some(u) = &updating {
        progress.line(format!(
            "model updating: largest error {:.4} % (Gauss–Newton, {} evaluations), {:.4} % (Nelder–Mead, {} evaluations)",
            u.gauss_newton.fit.largest_error_percent(),
            u.gauss_newton.fit.evaluations,
            u.nelder_mead.fit.largest_error_percent(),
            u.nelder_mead.fit.evaluations
        ));
    }
    let design = run_design(machine, &weights, &progress)?;
    progress.line(format!(
        "controller: μ {} as specified at rest, {} over speed, order {}",
        design.delivery.rounded.specification.words(),
        mu_words(design.largest_mu()),
        2 * design.delivery.rounded.order
    ));
    progress.stage("PID");
    let quick = rival_settings(machine, &design.delivery.controller, TuneSettings::quick())?;
    // A PID that is not found leaves the run without it.
    let pid = found_or_reason(tune(machine, &quick, &mut |_, _| {}))?;
    let plain = found_or_reason(textbook(machine, &quick))?;
    progress.stage("predictions and report");
    let result = assemble(
        &nominal,
        machine,
        &weights.name,
        updating.as_ref(),
        &design,
        (&pid, &quick),
        &plain,
    )?;
    let (mut folder, mut summary, ended) = result;
    finish(&mut folder, &mut summary, &arguments.out)?;
    arguments.timings.print(&progress.watch());
    drop(progress);
    let words = summary
        .get("plain_words")
        .and_then(|v| v.as_str())
        .unwrap_or_default()
        .to_owned();
    let out = arguments.out.as_str();
    console.other(
        || format!("{words}\nresults in {out}\n"),
        || summary.value(),
        || {
            shown_design(&design, ended, &words)
                .file(format!("{out}/report.html"))
                .file(format!("{out}/controller"))
                .next(format!(
                    "muspin simulate --controller {out}/controller/discrete.json --case impulse"
                ))
        },
    )?;
    Ok(ended)
}

fn update(measurement: &crate::input::Measurement, nominal: &Machine) -> Result<Updating, Failure> {
    let records = Records::of(measurement, nominal)?;
    records.refuse_for_updating()?;
    records.say();
    let (targets, identification) = targets(measurement, &records, nominal, None)?;
    let settings = UpdateSettings::default();
    let found = gauss_newton(nominal, &targets, &settings)?;
    Ok(Updating {
        machine: found.machine.clone(),
        nelder_mead: nelder_mead(nominal, &targets, &settings)?,
        gauss_newton: found,
        targets,
        identification,
    })
}

/// Summary, pictures and files of a run, and how it ended.
fn assemble(
    nominal: &Machine,
    machine: &Machine,
    weights: &str,
    updating: Option<&Updating>,
    design: &Design,
    (pid, effort): (&Rival, &TuneSettings),
    plain: &Rival,
) -> Result<(ResultsFolder, Summary, Outcome), Failure> {
    let (mut folder, mut summary) = (ResultsFolder::new(), Summary::new());
    let top = machine.spindle.max_rpm;
    let frequencies = |m: &Machine| -> Result<Vec<f64>, Failure> {
        let modes = PlanarModes::new(&m.rotor()?)?;
        Ok(modes.flexible_hz().into_iter().take(5).collect())
    };
    let updated_hz = frequencies(machine)?;
    summary.set("run", "run");
    summary.set("spindle", machine.spindle.name.as_str());
    summary.set("tool", machine.tool.name.as_str());
    summary.set("weights", weights);
    summary.set(
        "model.nominal",
        machine_json(nominal, &frequencies(nominal)?),
    );
    summary.set("model.used", machine_json(machine, &updated_hz));
    if let Some(u) = updating {
        if let Some(found) = &u.identification {
            summary.set("identification", identification_json(found));
        }
        summary.set("updating", updating_json(&u.gauss_newton.fit));
        summary.set("updating.nelder_mead", updating_json(&u.nelder_mead.fit));
        for (stem, figure) in update_figures(nominal, &[("updated", &u.gauss_newton.fit)]) {
            folder.add_plot(stem, &figure)?;
        }
    }
    summary.set("design", design_json(design));
    add_arithmetic(&mut summary, machine, design)?;
    let both = |controller: &Controller| -> Result<[Prediction; 2], Failure> {
        Ok([
            predict(machine, controller, 0.0)?,
            predict(machine, controller, top)?,
        ])
    };
    let of = |rival: &Rival| -> Result<Option<[Prediction; 2]>, Failure> {
        rival.as_ref().ok().map(|p| both(&p.controller)).transpose()
    };
    let (mu, tuned, untuned) = (both(&design.delivery.controller)?, of(pid)?, of(plain)?);
    let flexible: Vec<f64> = updated_hz.iter().take(3).map(|f| f * TAU).collect();
    let unpolished = of_unpolished(machine, design)?;
    let named = [
        ("mu", Role::Mu, Some(&mu)),
        ("dk", UNPOLISHED, unpolished.as_ref()),
        ("pid", Role::Pid, tuned.as_ref()),
        ("textbook_pid", Role::TextbookPid, untuned.as_ref()),
    ];
    for (name, _, found) in &named {
        let Some([rest, speed]) = found else { continue };
        add_predictions(&mut summary, name, rest, speed);
        summary.set(
            &format!("damping_ratio.{name}"),
            modal_damping_json(rest, &flexible),
        );
    }
    summary.set(
        "pid",
        match pid {
            Ok(found) => pid_json(found, effort),
            Err(reason) => json!({ "found": false, "sentence": not_found_words(reason) }),
        },
    );
    if let Ok(plain) = plain {
        summary.set("pid.textbook_stable", plain.certificate.nominal.is_stable());
    }
    let rival = match (&tuned, pid) {
        (Some(tuned), _) => Ok(&tuned[0]),
        (None, Err(reason)) => Err(reason.as_str()),
        (None, Ok(_)) => Err(""),
    };
    let marked = updating.map_or_else(Default::default, |u| marks(&u.targets));
    let models = [
        ("nominal", Role::Nominal, nominal),
        ("updated", Role::Updated, machine),
    ];
    let models = if updating.is_some() {
        &models[..]
    } else {
        &models[1..]
    };
    for (stem, figure) in open_loop(models, &marked)? {
        folder.add_plot(&stem, &figure)?;
    }
    // Updating draws the shapes before and after itself.
    if updating.is_none()
        && let Some(figure) = shapes(models)?
    {
        folder.add_plot("mode_shapes", &figure)?;
    }
    let mut runs: Vec<(Role, &Prediction)> = vec![];
    for k in 0..2 {
        for (_, role, found) in &named {
            runs.extend(found.map(|p| (*role, &p[k])));
        }
    }
    for (stem, figure) in robustness(design)
        .into_iter()
        .chain(predictions(&runs, &[], top / 60.0))
    {
        folder.add_plot(&stem, &figure)?;
    }
    add_loop(&mut folder, &mut summary, machine, design, [&mu[0], &mu[1]])?;
    let sentence = super::contact::add_contact(
        &mut folder,
        &mut summary,
        machine,
        design,
        pid.as_ref().ok(),
    )?;
    let pid_is_better = tuned
        .as_ref()
        .is_some_and(|pid| better_in_every_figure(pid, &mu));
    let words = plain_words(machine, design, &mu[0], rival, pid_is_better);
    summary.set("plain_words", format!("{words} {sentence}"));
    let tag = machine_tag(machine, "../spindle.yaml", "../tool.yaml");
    add_controller(&mut folder, machine, design, &tag)?;
    if let Ok(pid) = pid {
        folder.add(
            "controller/pid.json",
            controller_json(&pid.controller, Some(&tag)),
        )?;
    }
    folder.add("spindle.yaml", spindle_yaml(&machine.spindle))?;
    folder.add("tool.yaml", tool_yaml(&machine.tool))?;
    let ended = outcome(design, [&mu[0], &mu[1]]);
    Ok((folder, summary, ended))
}

fn marks(targets: &Targets) -> [Vec<MarkedFrequency>; 2] {
    [0, 1].map(|bearing| {
        let resonances = targets
            .resonances
            .iter()
            .flatten()
            .map(|t| (t, Peak::Resonance));
        let zeros = targets
            .antiresonances
            .get(bearing)
            .into_iter()
            .flat_map(|f| f.antiresonances.iter().flatten())
            .map(|t| (t, Peak::Antiresonance));
        resonances
            .chain(zeros)
            .map(|(t, peak)| MarkedFrequency {
                frequency_hz: t.frequency_hz,
                peak,
            })
            .collect()
    })
}

/// A search that found nothing, in a sentence.
fn not_found_words(reason: &str) -> String {
    format!("No PID was found ({reason}); its figures are absent.")
}

/// The outcome in a few sentences.
fn plain_words(
    machine: &Machine,
    design: &Design,
    mu: &Prediction,
    pid: Result<&Prediction, &str>,
    pid_is_better: bool,
) -> String {
    let stable = if design.is_stable() {
        format!(
            "stable at every speed up to {:.0} rpm, proven between the speeds computed as well",
            design.delivery.speed_proof.proven_to_rpm()
        )
    } else {
        format!(
            "NOT proven stable at every speed (up to {:.0} rpm only)",
            design.delivery.speed_proof.proven_to_rpm()
        )
    };
    let stiffness = match (mu.is_stable(), pid) {
        (true, Err(reason)) => format!(
            "Smallest tool stiffness {} at {:.0} Hz. {}",
            stiffness_words(mu.minimum.0),
            mu.minimum.1,
            not_found_words(reason)
        ),
        (true, Ok(pid)) if pid.is_stable() => format!(
            "Smallest tool stiffness {} at {:.0} Hz against {} with the tuned PID (zone {}), a factor of {:.1}.",
            stiffness_words(mu.minimum.0),
            mu.minimum.1,
            stiffness_words(pid.minimum.0),
            pid.zone_word(),
            mu.minimum.0 / pid.minimum.0
        ),
        (true, Ok(_)) => format!(
            "Smallest tool stiffness {} at {:.0} Hz; the loop of the tuned PID is unstable at rest.",
            stiffness_words(mu.minimum.0),
            mu.minimum.1
        ),
        (false, _) => format!(
            "At rest it is {}.",
            unstable_words(mu.growth_rate_per_s, mu.speed_rpm)
        ),
    };
    let words = format!(
        "{} with {}: the sampled controller with rounded coefficients (order {}) has μ {} for the specification as \
         written at rest, {} at most from rest to {:.0} rpm, is {stable}, zone {}. {stiffness}",
        machine.spindle.name,
        machine.tool.name,
        2 * design.delivery.rounded.order,
        design.delivery.rounded.specification.words(),
        mu_words(design.largest_mu()),
        OVERSPEED * machine.spindle.max_rpm,
        mu.zone_word(),
    );
    let words = match &design.specification_scale {
        Some(scale) => format!("{words} {}", scale.sentence()),
        None => words,
    };
    match (pid_is_better, &design.polish) {
        (true, _) => format!("The PID is better in every figure. {words}"),
        (false, Some(polish)) => format!("{words} {}", polish.sentence),
        (false, None) => words,
    }
}
