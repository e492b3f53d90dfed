//! `muspin compare`: dynamic stiffness and sensitivity of controllers, and of measured hammer tests, side by side.

use super::design::{add_predictions, finish, outcome, run_design};
use super::design_arguments::DesignArguments;
use super::progress::Progress;
use super::{Failure, Outcome, stdout};
use crate::controller::Controller;
use crate::controller::pid_tune::{TuneSettings, textbook, tune};
use crate::controller::verification::verify;
use crate::input::{load_controller, load_measurement};
use crate::pipeline::comparison::{Prediction, discrete, predict};
use crate::report::plot::Role;
use crate::report::results::ResultsFolder;
use crate::report::run_figures::{Measured, predictions};
use crate::report::run_summary::{modal_damping_json, verification_json};
use crate::report::summary::{Summary, number};
use crate::rotor::modes::PlanarModes;

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
    /// Folder for summary, pictures and report
    #[arg(long, default_value = "results/compare")]
    out: String,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let (machine, weights) = arguments.machine.load()?;
    let speeds = speeds(arguments, machine.spindle.max_rpm)?;
    let hammers = match &arguments.measurement {
        Some(source) => load_measurement(source)?.hammers,
        None => vec![],
    };
    let mut controllers = vec![];
    for file in &arguments.controller {
        controllers.push((Role::Other(controllers.len()), load_controller(file)?));
    }
    let progress = Progress::start();
    let mut result = Outcome::Done;
    if controllers.is_empty() {
        let found = run_design(&machine, &weights, &progress)?;
        result = outcome(&found);
        progress.stage("PID");
        let quick = TuneSettings::quick();
        controllers = vec![
            (Role::Mu, found.controller),
            (
                Role::Pid,
                tune(&machine, &quick, &mut |_, _| {})?.controller,
            ),
            (Role::TextbookPid, textbook(&machine, &quick)?.controller),
        ];
    }
    let mut summary = Summary::new();
    summary.set("run", "compare");
    summary.set("spindle", machine.spindle.name.as_str());
    summary.set("tool", machine.tool.name.as_str());
    let flexible: Vec<f64> = PlanarModes::new(&machine.rotor()?)?
        .omega_rad_s
        .iter()
        .skip(crate::rotor::modes::RIGID)
        .take(3)
        .copied()
        .collect();
    let period = machine.spindle.electronics.sample_period_s();
    let mut runs: Vec<(Role, Prediction)> = vec![];
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
        let law = discrete(controller, period)?;
        let checked = verify(
            &machine,
            &law,
            SPEEDS,
            "full finite-element plant, exact delay, sampled",
        )?;
        if !checked.is_stable() {
            result = Outcome::TargetMissed;
        }
        summary.set(&format!("stability.{name}.stable"), checked.is_stable());
        summary.set(
            &format!("stability.{name}.certificates"),
            verification_json(&checked),
        );
        runs.extend(each.into_iter().map(|mut p| {
            p.name.clone_from(name);
            (*role, p)
        }));
    }
    let measured: Vec<Measured> = hammers
        .iter()
        .map(|h| Measured {
            name: format!("measured ({})", h.name),
            speed_rpm: h.frf.speed_rpm,
            frequency_hz: h.frf.frequency_hz.clone(),
            stiffness_n_per_m: h.frf.compliance.iter().map(|c| c.norm().recip()).collect(),
        })
        .collect();
    summary.set("speeds_rpm", crate::report::summary::numbers(&speeds));
    summary.set("top_speed_hz", number(machine.spindle.max_rpm / 60.0));
    let mut folder = ResultsFolder::new();
    let shown: Vec<(Role, &Prediction)> = runs.iter().map(|(r, p)| (*r, p)).collect();
    for (stem, figure) in predictions(&shown, &measured, machine.spindle.max_rpm / 60.0) {
        folder.add_plot(&stem, &figure)?;
    }
    finish(&mut folder, &mut summary, &arguments.out)?;
    drop(progress);
    stdout::data(|out| out.write_all(summary.to_json().as_bytes()))?;
    Ok(result)
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
