//! `muspin compare`: dynamic stiffness and sensitivity of controllers, and of measured hammer tests, side by side.

use super::console::{Console, Shown};
use super::controlled_machine::other_machine;
use super::design::{add_predictions, finish};
use super::design_arguments::{DesignArguments, PidArguments, PidEffort};
use super::design_progress::run_design;
use super::machine::Remarks;
use super::output::{REPORT, claim};
use super::progress::Progress;
use super::{Failure, Outcome};
use crate::augment::weights::Weights;
use crate::controller::Controller;
use crate::controller::pid_settings::TuneSettings;
use crate::controller::pid_tune::{found_or_reason, textbook, tune};
use crate::controller::verification::{Verification, verify_with_proof};
use crate::identify::HammerFrf;
use crate::identify::peaks::{Channel, Resonance, resonances};
use crate::input::{load_measurement, load_tagged_controller, load_weights};
use crate::pipeline::comparison::{Prediction, chatter_limit, discrete, predict, rival_settings};
use crate::pipeline::loop_stability::unstable_words;
use crate::pipeline::worst::{WorstPrediction, worst_predictions};
use crate::predict::chatter::{Engagement, Material, StabilityLimit};
use crate::predict::sensitivity::Zone;
use crate::report::comparison::{
    certificate_json, figure_9_words, measured_json, measured_row, pid_json, ratio_json,
    statements_json, statements_table,
};
use crate::report::comparison_figures::worst_figures;
use crate::report::design_summary::speed_proof_json;
use crate::report::plot::Curve;
use crate::report::plot::Role;
use crate::report::plot::machining::chatter_lobes;
use crate::report::results::ResultsFolder;
use crate::report::run_figures::{Measured, predictions};
use crate::report::run_summary::{modal_damping_json, verification_json};
use crate::report::summary::{Summary, number};
use crate::report::worst::worst_json;
use crate::rotor::modes::PlanarModes;
use crate::spindle::Machine;
use serde_json::Value;
use std::f64::consts::TAU;

/// Speeds checked for stability, evenly spaced from zero to the top speed.
const SPEEDS: usize = 11;

/// Arguments of `muspin compare`.
#[derive(clap::Args, Debug)]
pub struct Arguments {
    #[command(flatten)]
    machine: DesignArguments,
    /// Controllers (JSON), any number; default: the μ design, the tuned and the textbook PID for this machine
    #[arg(long)]
    controller: Vec<String>,
    /// Measurement folder whose hammer tests are shown beside the predictions
    #[arg(long)]
    measurement: Option<String>,
    /// Speeds in rpm, separated by commas; default: standstill and the top speed
    #[arg(long, value_delimiter = ',')]
    speeds: Vec<f64>,
    #[command(flatten)]
    pid: PidArguments,
    /// Uncertainty of the natural frequencies for the worst case in percent, mode by mode; default: that of the weights
    #[arg(long, value_delimiter = ',')]
    mode_uncertainty: Vec<f64>,
    /// Tangential cutting force coefficient of the workpiece for the stability lobes, Pa (aluminium 8e8, steel 2e9)
    #[arg(long, default_value_t = 8e8)]
    tangential_pa: f64,
    /// Radial over tangential cutting force
    #[arg(long, default_value_t = 0.3)]
    radial_ratio: f64,
    /// Teeth of the cutter
    #[arg(long, default_value_t = 2)]
    teeth: usize,
    /// Radial width of cut over diameter, down milling; 1 is a slot
    #[arg(long, default_value_t = 0.5)]
    radial_width: f64,
    /// Folder for summary, pictures and report
    #[arg(long, default_value = "results/compare")]
    out: String,
}

/// Runs the command.
pub fn run(arguments: &Arguments, console: &Console) -> Result<Outcome, Failure> {
    let weights = load_weights(&arguments.machine.weights)?;
    let (machine, mut controllers, used, remarks) = given(arguments)?;
    let speeds = speeds(arguments, machine.spindle.max_rpm)?;
    let uncertainty = mode_uncertainty(arguments, &weights)?;
    let hammers = match &arguments.measurement {
        Some(source) => load_measurement(source)?.hammers,
        None => vec![],
    };
    let read = arguments.controller.iter().chain(&arguments.measurement);
    let read = read.map(String::as_str).chain(arguments.machine.files());
    claim(&arguments.out, &REPORT, read)?;
    let progress = Progress::start(console);
    let mut result = Outcome::Done;
    let mut summary = Summary::new();
    summary.set("run", "compare");
    summary.set("spindle", machine.spindle.name.as_str());
    summary.set("tool", machine.tool.name.as_str());
    if let Some(used) = used {
        summary.set("machine", used);
    }
    if controllers.is_empty() {
        let found = run_design(&machine, &weights, &progress)?;
        if !found.meets_targets() {
            result = Outcome::TargetMissed;
        }
        progress.stage("PID");
        let effort = arguments.pid.settings(PidEffort::Thorough);
        let effort = rival_settings(&machine, &found.delivery.controller, effort)?;
        let pid = found_or_reason(tune(&machine, &effort, &mut |_, _| {}))?;
        let plain = found_or_reason(textbook(&machine, &TuneSettings::quick()))?;
        controllers = vec![(Role::Mu, found.delivery.controller)];
        match pid {
            Ok(pid) => {
                summary.set("pid", pid_json(&pid, &effort));
                controllers.push((Role::Pid, pid.controller));
            }
            Err(reason) => {
                summary.set("pid.found", false);
                summary.set("pid.sentence", format!("No PID was found ({reason})."));
            }
        }
        if let Ok(plain) = plain {
            summary.set("pid.textbook", certificate_json(&plain.certificate));
            controllers.push((Role::TextbookPid, plain.controller));
        }
    }
    let flexible: Vec<f64> = PlanarModes::new(&machine.rotor()?)?
        .omega_rad_s
        .iter()
        .skip(crate::rotor::modes::RIGID)
        .take(3)
        .copied()
        .collect();
    let period = machine.spindle.electronics.sample_period_s();
    let flexible_hz: Vec<f64> = flexible.iter().map(|w| w / TAU).collect();
    let mut runs: Vec<(Role, Prediction)> = vec![];
    let mut first_words: Vec<String> = vec![];
    let mut worst: Vec<(Role, String, Vec<WorstPrediction>)> = vec![];
    let (material, cut) = cut(arguments)?;
    let top = machine.spindle.max_rpm;
    let lobe_speeds: Vec<f64> = (1..=LOBE_POINTS)
        .map(|k| top * k as f64 / LOBE_POINTS as f64)
        .collect();
    let mut lobes: Vec<(Role, String, Vec<f64>)> = vec![];
    for (name, (role, controller)) in keys(&controllers).iter().zip(&controllers) {
        progress.stage(format!("predictions for {name}"));
        let each = speeds
            .iter()
            .map(|rpm| predict(&machine, controller, *rpm))
            .collect::<Result<Vec<_>, _>>()?;
        let (Some(first), Some(last)) = (each.first(), each.last()) else {
            continue;
        };
        add_predictions(&mut summary, name, first, last);
        summary.set(
            &format!("damping_ratio.{name}"),
            modal_damping_json(first, &flexible),
        );
        let spoken = each
            .iter()
            .map(|p| statements_json(p, &flexible_hz, top / 60.0));
        summary.set(
            &format!("tool_plane.{name}"),
            Value::Array(spoken.collect()),
        );
        let law = discrete(controller, period)?;
        let checked = verify_with_proof(
            &machine,
            &law,
            SPEEDS,
            "full finite-element plant, exact delay, sampled",
        )?;
        let acceptable = |p: &Prediction| p.zone().is_some_and(|zone| zone < Zone::D);
        // The textbook PID shows what is left without tuning: its zone is no target.
        let zone_counts = *role != Role::TextbookPid;
        if !checked.is_proven() || (zone_counts && !each.iter().all(acceptable)) {
            result = Outcome::TargetMissed;
        }
        say_unstable(&mut first_words, name, &checked, &each);
        summary.set(&format!("stability.{name}.stable"), checked.is_proven());
        if let Some(proof) = &checked.proof {
            summary.set(&format!("stability.{name}.proof"), speed_proof_json(proof));
        }
        if let Some(failure) = &checked.proof_failure {
            let key = format!("stability.{name}.proof_failure");
            summary.set(&key, failure.as_str());
        }
        progress.stage(format!("worst case of {name}"));
        let reach = checked.proof.as_ref().map_or(0.0, |p| p.proven_to_rpm());
        let over = worst_predictions(&machine, controller, &speeds, reach.min(top), &uncertainty)?;
        summary.set(&format!("worst_case.{name}"), worst_json(&over));
        worst.push((*role, name.clone(), over));
        summary.set(
            &format!("stability.{name}.certificates"),
            verification_json(&checked),
        );
        let limit = chatter_limit(&machine, controller, top, &material, &cut)?;
        let minimum = limit.as_ref().and_then(StabilityLimit::minimum);
        summary.set(
            &format!("chatter.{name}.minimum_depth_m"),
            number(minimum.map_or(f64::NAN, |m| m.depth_m)),
        );
        summary.set(
            &format!("chatter.{name}.frequency_hz"),
            number(minimum.map_or(f64::NAN, |m| m.omega_rad_s / TAU)),
        );
        let angular: Vec<f64> = lobe_speeds.iter().map(|rpm| rpm * TAU / 60.0).collect();
        lobes.extend(limit.map(|l| (*role, name.clone(), l.depths(&angular))));
        runs.extend(each.into_iter().map(|mut p| {
            p.name.clone_from(name);
            (*role, p)
        }));
    }
    let measured: Vec<Measured> = hammers
        .iter()
        .map(|h| Measured {
            name: format!("measured ({})", stem(&h.name)),
            role: Role::Measured,
            speed_rpm: h.frf.speed_rpm,
            frequency_hz: h.frf.frequency_hz.clone(),
            stiffness_n_per_m: h.frf.compliance.iter().map(|c| c.norm().recip()).collect(),
        })
        .collect();
    for (m, hammer) in measured.iter().zip(&hammers) {
        let key = format!(
            "tool_plane.measured_{}",
            stem(&hammer.name).replace(['.', ' '], "_")
        );
        let shown = lightly_damped(&hammer.frf);
        summary.set(&key, measured_json(m, &shown, &flexible_hz, top / 60.0));
    }
    add_ratios(&mut summary, &runs);
    let every: Vec<&Prediction> = runs.iter().map(|(_, p)| p).collect();
    let words = figure_9_words(&every, &worst);
    let mut statements = statements_table(&every, &worst, &flexible_hz, top / 60.0);
    let rows = measured.iter();
    statements.extend(rows.map(|m| measured_row(m, &flexible_hz, top / 60.0)));
    summary.set("statements", Value::Array(statements));
    summary.set("verdict.met", result == Outcome::Done);
    let sentence = match result {
        Outcome::Done => "every loop is proven stable at every speed",
        Outcome::TargetMissed => {
            "a loop is not proven stable at every speed, is in zone D, or the design misses its specification"
        }
    };
    summary.set("verdict.sentence", sentence);
    summary.set("plain_words", words);
    summary.set("speeds_rpm", crate::report::summary::numbers(&speeds));
    summary.set("top_speed_hz", number(machine.spindle.max_rpm / 60.0));
    let mut folder = ResultsFolder::new();
    let drawn: Vec<(Role, &Prediction)> = runs.iter().map(|(r, p)| (*r, p)).collect();
    for (stem, figure) in predictions(&drawn, &measured, machine.spindle.max_rpm / 60.0) {
        folder.add_plot(&stem, &figure)?;
    }
    for (stem, figure) in worst_figures(&worst) {
        folder.add_plot(&stem, &figure)?;
    }
    let curves: Vec<Curve> = lobes
        .iter()
        .map(|(role, name, depth)| Curve {
            name,
            role: *role,
            x: &lobe_speeds,
            y: depth,
        })
        .collect();
    if !curves.is_empty() {
        let figure = chatter_lobes("Stable depth of cut", &curves, top);
        folder.add_plot("chatter", &figure)?;
    }
    finish(&mut folder, &mut summary, &arguments.out)?;
    drop(progress);
    first_words.iter().for_each(|line| eprintln!("{line}"));
    drop(remarks);
    console.json(&summary.to_json(), || {
        shown(sentence, result, &runs, &arguments.out)
    })?;
    Ok(result)
}

/// Points of the stability lobes over speed: lobes of a two-tooth cutter stay smooth down to a tenth of the top speed.
const LOBE_POINTS: usize = 1000;

/// The name of a record's file without folders and extension.
fn stem(name: &str) -> &str {
    let path = std::path::Path::new(name);
    path.file_stem().and_then(|s| s.to_str()).unwrap_or(name)
}

/// Resonances of a hammer record that a local fit resolves: those with a damping ratio of two percent at most.
fn lightly_damped(frf: &HammerFrf) -> Vec<Resonance> {
    let lines = 0..frf.frequency_hz.len();
    // A floor of half a percent: what repeated hammer tests differ by.
    let channel = Channel {
        name: "tool".to_owned(),
        value: frf.compliance.clone(),
        sigma: lines.map(|k| frf.sigma(k, 0.005)).collect(),
    };
    resonances(&frf.frequency_hz, &[channel])
}

type Given = (Machine, Vec<(Role, Controller)>, Option<Value>, Remarks);

/// The machine, the controllers of the command line, which machine was used for them, and what looks wrong in its files.
fn given(arguments: &Arguments) -> Result<Given, Failure> {
    let files = &arguments.machine.machine;
    let Some((first, others)) = arguments.controller.split_first() else {
        return Ok((files.alone()?, vec![], None, Remarks::default()));
    };
    let (found, mut remarks) = files.with_controller(first)?;
    let json = found.json();
    let mut controllers = vec![(Role::Other(0), found.controller)];
    for file in others {
        let loaded = load_tagged_controller(file)?;
        let other = other_machine(file, loaded.machine.as_ref(), &found.used);
        remarks.0.extend(other);
        controllers.push((Role::Other(controllers.len()), loaded.controller));
    }
    Ok((found.machine, controllers, Some(json), remarks))
}

/// What is said first about a loop that is unstable: at a speed that was asked for, else anywhere up to the top speed.
fn say_unstable(words: &mut Vec<String>, name: &str, checked: &Verification, each: &[Prediction]) {
    let asked = each.iter().find(|p| !p.is_stable());
    let asked = asked.map(|p| (p.growth_rate_per_s, p.speed_rpm));
    let anywhere = checked
        .unstable()
        .map(|c| (c.growth_rate_per_s, c.speed_rpm));
    if let Some((growth, rpm)) = asked.or(anywhere) {
        words.push(format!("{name}: {}", unstable_words(growth, rpm)));
    }
}

/// Stiffness of the first controller over that of each other one, speed by speed.
fn add_ratios(summary: &mut Summary, runs: &[(Role, Prediction)]) {
    let Some(first) = runs.first().map(|(_, p)| p.name.clone()) else {
        return;
    };
    let mut others: Vec<&str> = runs.iter().map(|(_, p)| p.name.as_str()).collect();
    others.dedup();
    for other in others.into_iter().filter(|name| **name != first) {
        let of = |name: &str, rpm: f64| {
            let mut all = runs.iter().map(|(_, p)| p);
            all.find(|p| p.name == name && p.speed_rpm == rpm)
        };
        let ratios = runs
            .iter()
            .filter(|(_, p)| p.name == first)
            .filter_map(|(_, p)| Some(ratio_json(p, of(other, p.speed_rpm)?)));
        summary.set(
            &format!("stiffness_ratio.{first}_over_{other}"),
            Value::Array(ratios.collect()),
        );
    }
}

/// Relative uncertainty per mode: from the command line in percent, else from the weights.
fn mode_uncertainty(arguments: &Arguments, weights: &Weights) -> Result<Vec<f64>, Failure> {
    // Beyond a fifth of its frequency a mode is not uncertain but unknown.
    if let Some(bad) = arguments
        .mode_uncertainty
        .iter()
        .find(|r| !(0.0..=20.0).contains(*r))
    {
        return Err(Failure::new(format!(
            "--mode-uncertainty: {bad} must lie between 0 and 20 percent"
        ))
        .with_hint("one number a mode, for example --mode-uncertainty 1,1,0"));
    }
    Ok(if arguments.mode_uncertainty.is_empty() {
        weights.mode_uncertainty.clone()
    } else {
        arguments
            .mode_uncertainty
            .iter()
            .map(|r| 0.01 * r)
            .collect()
    })
}

fn cut(arguments: &Arguments) -> Result<(Material, Engagement), Failure> {
    let width = arguments.radial_width;
    if !(width > 0.0 && width <= 1.0) {
        return Err(
            Failure::new(format!("--radial-width: {width} must lie between 0 and 1"))
                .with_hint("1 is a slot, 0.5 half the diameter"),
        );
    }
    let material = Material {
        tangential_pa: arguments.tangential_pa,
        radial_ratio: arguments.radial_ratio,
    };
    Ok((material, Engagement::down_milling(arguments.teeth, width)))
}

/// Names of the controllers as keys: blanks become underscores, repeated names get a number.
fn keys(controllers: &[(Role, Controller)]) -> Vec<String> {
    let mut names: Vec<String> = vec![];
    for (role, controller) in controllers {
        let base = match role {
            Role::Mu => "mu".to_owned(),
            Role::Pid => "pid".to_owned(),
            Role::TextbookPid => "textbook_pid".to_owned(),
            _ => controller.name.replace([' ', '.'], "_").to_lowercase(),
        };
        let repeats = names
            .iter()
            .filter(|n| **n == base || n.starts_with(&format!("{base}_")))
            .count();
        names.push(if repeats == 0 {
            base
        } else {
            format!("{base}_{}", repeats + 1)
        });
    }
    names
}

fn speeds(arguments: &Arguments, top_rpm: f64) -> Result<Vec<f64>, Failure> {
    if let Some(bad) = arguments
        .speeds
        .iter()
        .find(|s| !(s.is_finite() && **s >= 0.0))
    {
        return Err(
            Failure::new(format!("--speeds: {bad} must be zero or a positive number"))
                .with_hint("speeds are in rpm, for example --speeds 0,25000,50000"),
        );
    }
    Ok(if arguments.speeds.is_empty() {
        vec![0.0, top_rpm]
    } else {
        arguments.speeds.clone()
    })
}

fn shown(sentence: &str, ended: Outcome, runs: &[(Role, Prediction)], out: &str) -> Shown {
    let head = [
        "controller",
        "rpm",
        "smallest stiffness, N/µm",
        "at Hz",
        "zone",
    ];
    let rows = runs.iter().map(|(_, p)| {
        vec![
            p.name.clone(),
            format!("{:.0}", p.speed_rpm),
            format!("{:.2}", 1e-6 * p.minimum.0),
            format!("{:.0}", p.minimum.1),
            p.zone_word().to_owned(),
        ]
    });
    Shown::met(ended == Outcome::Done, sentence)
        .row(head)
        .rows(rows)
        .file(format!("{out}/report.html"))
}
