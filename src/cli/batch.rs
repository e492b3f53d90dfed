//! `muspin batch`: a design per tool and one table over all.

use super::design::{add_controller, finish, run_design};
use super::progress::Progress;
use super::{Failure, Outcome, stdout};
use crate::controller::pid_tune::{TuneSettings, tune};
use crate::input::{load_machine, load_weights};
use crate::pipeline::comparison::predict;
use crate::pipeline::design::{DesignSettings, largest_tightening};
use crate::report::plot::machining::{ToolQuantity, tools};
use crate::report::results::ResultsFolder;
use crate::report::run_summary::{design_json, sensitivity_json, stiffness_json};
use crate::report::summary::{Summary, number};
use crate::report::tables::Table;
use serde_json::{Value, json};
use std::path::Path;

/// Arguments of `muspin batch`.
#[derive(clap::Args, Debug)]
pub struct Arguments {
    /// Spindle file, or the name of a shipped one; usually the updated model of a run
    #[arg(long, default_value = "reference")]
    spindle: String,
    /// Tools: files or shipped names separated by commas, or a folder of tool files
    #[arg(long, value_delimiter = ',', required = true)]
    tools: Vec<String>,
    /// Weights file, or the name of a shipped one
    #[arg(long, default_value = "benchmark")]
    weights: String,
    /// Folder for the table, a controller per tool, picture and report
    #[arg(long, default_value = "results/batch")]
    out: String,
}

/// One line of the table.
struct Row {
    tool: String,
    summary: Value,
    mu: f64,
    covered: f64,
    order: usize,
    stiffness_mu: f64,
    stiffness_pid: f64,
    zone: &'static str,
    stable_to_rpm: f64,
    met: bool,
    tightening: f64,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let weights = load_weights(&arguments.weights)?;
    let sources = expand(&arguments.tools)?;
    // Every file is read before the first design starts.
    let machines = sources
        .iter()
        .map(|tool| Ok(load_machine(&arguments.spindle, tool)?))
        .collect::<Result<Vec<_>, Failure>>()?;
    let progress = Progress::start();
    let mut folder = ResultsFolder::new();
    let mut rows = vec![];
    for machine in &machines {
        let tool = machine.tool.name.clone();
        progress.line(format!("tool {tool}"));
        let design = run_design(machine, &weights, &progress)?;
        progress.stage(format!("{tool}: PID and predictions"));
        let pid = tune(machine, &TuneSettings::quick(), &mut |_, _| {})?;
        let mu = predict(machine, &design.controller, 0.0)?;
        let rival = predict(machine, &pid.controller, 0.0)?;
        let tightening = largest_tightening(machine, &weights, &DesignSettings::default())?;
        let mut own = ResultsFolder::new();
        add_controller(&mut own, machine, &design)?;
        for (path, bytes) in own.files() {
            let name = path.strip_prefix("controller/").unwrap_or(path);
            folder.add(&format!("{tool}/{name}"), bytes)?;
        }
        let stable = design
            .verification
            .speeds
            .iter()
            .take_while(|s| s.growth_rate_per_s < 0.0);
        rows.push(Row {
            mu: design.rounded.specification.upper,
            covered: design.rounded.covered.upper,
            order: 2 * design.rounded.order,
            stiffness_mu: mu.minimum.0,
            stiffness_pid: rival.minimum.0,
            zone: mu.sensitivity.zone().letter(),
            stable_to_rpm: stable.last().map_or(f64::NAN, |s| s.speed_rpm),
            met: design.meets_targets(),
            tightening,
            summary: json!({
                "tool": tool,
                "design": design_json(&design),
                "stiffness": { "mu": stiffness_json(&mu), "pid": stiffness_json(&rival) },
                "sensitivity": { "mu": sensitivity_json(&mu), "pid": sensitivity_json(&rival) },
                "largest_tool_tightening": number(tightening),
            }),
            tool,
        });
    }
    let mut summary = Summary::new();
    summary.set("run", "batch");
    summary.set("spindle", arguments.spindle.as_str());
    summary.set("weights", weights.name.as_str());
    summary.set(
        "tools",
        Value::Array(rows.iter().map(|r| r.summary.clone()).collect()),
    );
    let table = table(&rows);
    folder.add_table("tools.csv", &table)?;
    let names: Vec<String> = rows.iter().map(|r| r.tool.clone()).collect();
    let column = |f: fn(&Row) -> f64| rows.iter().map(f).collect::<Vec<f64>>();
    let (mu, stiff, rival) = (
        column(|r| r.mu),
        column(|r| r.stiffness_mu * 1e-6),
        column(|r| r.stiffness_pid * 1e-6),
    );
    let quantities = [
        ToolQuantity {
            label: "µ as specified",
            unit: "",
            reference: Some((1.0, "µ = 1")),
            bars: vec![("µ controller", mu)],
        },
        ToolQuantity {
            label: "Minimum stiffness",
            unit: "N/µm",
            reference: None,
            bars: vec![("µ controller", stiff), ("tuned PID", rival)],
        },
    ];
    folder.add_plot("tools", &tools("A design per tool", &names, &quantities))?;
    finish(&mut folder, &mut summary, &arguments.out)?;
    drop(progress);
    stdout::data(|out| out.write_all(table.to_csv().as_bytes()))?;
    Ok(if rows.iter().all(|r| r.met) {
        Outcome::Done
    } else {
        Outcome::TargetMissed
    })
}

fn table(rows: &[Row]) -> Table {
    let mut table = Table::with_columns(&[
        "tool",
        "mu_as_specified",
        "mu_with_gyroscopic_cover",
        "order",
        "minimum_stiffness_mu_n_per_m",
        "minimum_stiffness_pid_n_per_m",
        "iso_zone",
        "stable_to_rpm",
        "meets_specification",
        "largest_tool_tightening",
    ]);
    for r in rows {
        table.push(vec![
            r.tool.clone(),
            Table::number(r.mu),
            Table::number(r.covered),
            r.order.to_string(),
            Table::number(r.stiffness_mu),
            Table::number(r.stiffness_pid),
            r.zone.to_owned(),
            Table::number(r.stable_to_rpm),
            r.met.to_string(),
            Table::number(r.tightening),
        ]);
    }
    table
}

/// Files and names as given; a folder stands for its tool files in alphabetical order.
fn expand(tools: &[String]) -> Result<Vec<String>, Failure> {
    let mut all = vec![];
    for tool in tools {
        if !Path::new(tool).is_dir() {
            all.push(tool.clone());
            continue;
        }
        let entries = std::fs::read_dir(tool).map_err(|e| Failure::new(format!("{tool}: {e}")))?;
        let mut files: Vec<String> = entries
            .filter_map(|e| Some(e.ok()?.path()))
            .filter(|p| p.extension().is_some_and(|x| x == "yaml"))
            .map(|p| p.display().to_string())
            .collect();
        files.sort();
        if files.is_empty() {
            return Err(Failure::new(format!("--tools: {tool} holds no .yaml file"))
                .with_hint("give a folder of tool files, or names separated by commas"));
        }
        all.extend(files);
    }
    Ok(all)
}
