//! `muspin batch`: a design per tool and one table over all.

use super::console::{Console, Shown};
use super::controlled_machine::machine_tag;
use super::design::{add_controller, finish};
use super::design_arguments::{PidArguments, PidEffort};
use super::design_progress::run_design;
use super::machine::load_machine;
use super::output::{REPORT, claim};
use super::progress::Progress;
use super::{Failure, Outcome};
use crate::augment::weights::Weights;
use crate::controller::MachineTag;
use crate::controller::pid_tune::{found_or_reason, tune};
use crate::input::{load_weights, spindle_yaml, tool_yaml};
use crate::pipeline::comparison::{Prediction, predict, rival_settings};
use crate::pipeline::settings::DesignSettings;
use crate::pipeline::tightening::largest_tightening;
use crate::pipeline::worst::{WorstPrediction, worst_predictions};
use crate::predict::sensitivity::Zone;
use crate::predict::stiffness::stiffness_words;
use crate::report::comparison::pid_json;
use crate::report::controller_json::controller_json;
use crate::report::manifest::{MANIFEST, is_inside};
use crate::report::plot::machining::{ToolQuantity, tool_stiffness, tools};
use crate::report::plot::{Curve, Figure, Role};
use crate::report::prediction_summary::{sensitivity_json, stiffness_json};
use crate::report::results::ResultsFolder;
use crate::report::run_summary::design_json;
use crate::report::summary::{Summary, number};
use crate::report::tables::Table;
use crate::report::worst::{least_over_speed, worst_json};
use crate::spindle::Machine;
use serde_json::{Value, json};
use std::collections::BTreeMap;
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
    #[command(flatten)]
    pid: PidArguments,
    /// Also seek the largest tightening of tools that meet the specification
    #[arg(long)]
    tightening: bool,
    /// Folder for the table, a controller per tool, picture and report
    #[arg(long, default_value = "results/batch")]
    out: String,
}

/// Smallest factor on the tool's specification that the search tries.
const SMALLEST_FACTOR: f64 = 1.0 / 64.0;

/// One line of the table.
struct Row {
    tool: String,
    summary: Value,
    mu: f64,
    covered: f64,
    order: usize,
    /// µ controller and PID; the latter is absent where none was found.
    rest: Vec<Prediction>,
    worst: [f64; 2],
    stable_to_rpm: f64,
    met: bool,
    tightening: Option<f64>,
}

impl Row {
    fn minimum(&self, k: usize) -> f64 {
        self.rest.get(k).map_or(f64::NAN, |p| p.minimum.0)
    }

    fn peak_db(&self, k: usize) -> f64 {
        let Some(prediction) = self.rest.get(k).filter(|p| p.is_stable()) else {
            return f64::NAN;
        };
        let sensitivity = &prediction.sensitivity;
        let peak = (0..4).map(|axis| sensitivity.peak(axis).0);
        20.0 * peak.fold(0.0, f64::max).log10()
    }

    fn zone(&self, k: usize) -> &'static str {
        self.rest.get(k).map_or("-", |p| p.zone_word())
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments, console: &Console) -> Result<Outcome, Failure> {
    let weights = load_weights(&arguments.weights)?;
    let sources = expand(&arguments.tools)?;
    // Every file is read before the first design starts.
    let machines = sources
        .iter()
        .map(|tool| load_machine(&arguments.spindle, tool))
        .collect::<Result<Vec<_>, Failure>>()?;
    distinct_names(&sources, &machines)?;
    let read = sources
        .iter()
        .chain([&arguments.spindle, &arguments.weights]);
    claim(&arguments.out, &REPORT, read.map(String::as_str))?;
    let progress = Progress::start(console);
    let mut folder = ResultsFolder::new();
    let mut rows = vec![];
    for machine in &machines {
        progress.line(format!("tool {}", machine.tool.name));
        rows.push(one(arguments, machine, &weights, &mut folder, &progress)?);
    }
    let mut summary = Summary::new();
    summary.set("run", "batch");
    summary.set("spindle", arguments.spindle.as_str());
    summary.set("weights", weights.name.as_str());
    summary.set("plain_words", sentences(&rows));
    summary.set("table", overview(&rows));
    summary.set(
        "tools",
        Value::Array(rows.iter().map(|r| r.summary.clone()).collect()),
    );
    let met = rows.iter().filter(|r| r.met).count();
    summary.set("verdict.met", met == rows.len());
    summary.set(
        "verdict.sentence",
        format!("{met} of {} tools meet the specification", rows.len()),
    );
    let table = table(&rows);
    folder.add_table("tools.csv", &table)?;
    let top_hz = machines
        .first()
        .map_or(f64::NAN, |m| m.spindle.max_rpm / 60.0);
    for (stem, figure) in figures(&rows, top_hz) {
        folder.add_plot(stem, &figure)?;
    }
    finish(&mut folder, &mut summary, &arguments.out)?;
    drop(progress);
    console.other(
        || table.to_csv(),
        || summary.value(),
        || shown(&rows, &arguments.out),
    )?;
    Ok(if rows.iter().all(|r| r.met) {
        Outcome::Done
    } else {
        Outcome::TargetMissed
    })
}

/// Names of files and folders that the batch writes beside the folder of each tool.
const RESERVED: [&str; 5] = [
    "plots",
    "report.html",
    "summary.json",
    "tools.csv",
    MANIFEST,
];

/// Every tool needs a folder of its own, on file systems that do not tell upper from lower case as well.
fn distinct_names(sources: &[String], machines: &[Machine]) -> Result<(), Failure> {
    let mut known: BTreeMap<String, &String> = BTreeMap::new();
    for (source, machine) in sources.iter().zip(machines) {
        let name = &machine.tool.name;
        let refused = |rule: String| {
            Err(Failure::new(format!("{source}: name: {name:?} {rule}"))
                .with_hint("the results of a tool go to a folder of its name: change `name:` in the tool file"))
        };
        let folder = name.to_lowercase();
        if name.contains('/') || !is_inside(name) {
            return refused("cannot be the name of a folder".into());
        }
        if RESERVED.contains(&folder.as_str()) {
            return refused("is the name of a file or folder of the batch itself".into());
        }
        if let Some(first) = known.insert(folder, source) {
            return refused(format!("is the name of the tool in {first} already"));
        }
    }
    Ok(())
}

/// Design, rival and figures of one tool; its controller goes into the folder.
fn one(
    arguments: &Arguments,
    machine: &Machine,
    weights: &Weights,
    folder: &mut ResultsFolder,
    progress: &Progress,
) -> Result<Row, Failure> {
    let tool = machine.tool.name.clone();
    let design = run_design(machine, weights, progress)?;
    progress.stage(format!("{tool}: PID"));
    let effort = arguments.pid.settings(PidEffort::Quick);
    let effort = rival_settings(machine, &design.delivery.controller, effort)?;
    let pid = found_or_reason(tune(machine, &effort, &mut |_, _| {}))?;
    progress.stage(format!("{tool}: predictions"));
    let mut controllers = vec![&design.delivery.controller];
    controllers.extend(pid.as_ref().ok().map(|p| &p.controller));
    let rest = controllers
        .iter()
        .map(|c| predict(machine, c, 0.0))
        .collect::<Result<Vec<_>, _>>()?;
    let top = machine.spindle.max_rpm;
    let worst = controllers
        .iter()
        .map(|c| worst_predictions(machine, c, &[], top, &weights.mode_uncertainty))
        .collect::<Result<Vec<_>, _>>()?;
    let least = |cases: &[WorstPrediction]| least_over_speed(cases).map_or(f64::NAN, |l| l.n_per_m);
    let met = design.meets_targets() && rest[0].zone().is_some_and(|zone| zone < Zone::D);
    let tightening = if met && !arguments.tightening {
        None
    } else {
        progress.stage(format!("{tool}: largest tightening"));
        {
            let factor = largest_tightening(machine, weights, &DesignSettings::default())?;
            // The end of the search's range: no factor was found that is met.
            Some(if factor > SMALLEST_FACTOR {
                factor
            } else {
                0.0
            })
        }
    };
    let mut own = ResultsFolder::new();
    add_controller(&mut own, machine, &design, &own_machine(machine))?;
    own.add("controller/spindle.yaml", spindle_yaml(&machine.spindle))?;
    own.add("controller/tool.yaml", tool_yaml(&machine.tool))?;
    for (path, bytes) in own.files() {
        let name = path.strip_prefix("controller/").unwrap_or(path);
        folder.add(&format!("{tool}/{name}"), bytes)?;
    }
    if let Ok(pid) = &pid {
        folder.add(
            &format!("{tool}/pid.json"),
            controller_json(&pid.controller, Some(&own_machine(machine))),
        )?;
    }
    let of = |k: usize, json: &dyn Fn(&Prediction) -> Value| rest.get(k).map(json);
    let stiffness = |k: usize| of(k, &stiffness_json);
    let sensitivity = |k: usize| of(k, &sensitivity_json);
    let worst_cases = |k: usize| worst.get(k).map(|w| worst_json(w));
    Ok(Row {
        mu: design.delivery.rounded.specification.upper,
        covered: design.delivery.rounded.covered.upper,
        order: 2 * design.delivery.rounded.order,
        stable_to_rpm: design.delivery.speed_proof.proven_to_rpm(),
        worst: [0, 1].map(|k| worst.get(k).map_or(f64::NAN, |w| least(w))),
        met,
        tightening,
        summary: json!({
            "tool": tool,
            "design": design_json(&design),
            "stiffness": { "mu": stiffness(0), "pid": stiffness(1) },
            "sensitivity": { "mu": sensitivity(0), "pid": sensitivity(1) },
            "worst_case": { "mu": worst_cases(0), "pid": worst_cases(1) },
            "pid": match &pid {
                Ok(found) => pid_json(found, &effort),
                Err(reason) => json!({ "found": false, "sentence": format!("No PID was found ({reason}).") }),
            },
            "largest_tool_tightening": tightening.map(number),
        }),
        rest,
        tool,
    })
}

/// The machine of a design, whose files stand beside its controllers.
fn own_machine(machine: &Machine) -> MachineTag {
    machine_tag(machine, "spindle.yaml", "tool.yaml")
}

/// The batch in sentences.
fn sentences(rows: &[Row]) -> Value {
    let mut words = vec![];
    let missed: Vec<String> = rows
        .iter()
        .filter(|r| !r.met)
        .map(|r| match r.tightening {
            Some(0.0) => format!("{} (at no size of its tool specification)", r.tool),
            Some(t) => format!("{} (up to {t:.2} times its tool specification)", r.tool),
            None => r.tool.clone(),
        })
        .collect();
    if !missed.is_empty() {
        words.push(format!("Specification missed by {}.", missed.join(", ")));
    }
    let stiffest = |k: usize| {
        let all = rows.iter().map(|r| r.minimum(k));
        let (low, high) = all.fold((f64::INFINITY, 0.0f64), |(a, b), x| (a.min(x), b.max(x)));
        format!("{:.2} to {:.2} N/µm", 1e-6 * low, 1e-6 * high)
    };
    let wins = rows
        .iter()
        .filter(|r| r.rest.len() < 2 || r.minimum(0) > r.minimum(1))
        .count();
    words.push(format!(
        "Smallest tool stiffness: {} with the µ controllers, {} with PIDs tuned for it; the µ controller is the stiffer one for {wins} of {} tools.",
        stiffest(0),
        stiffest(1),
        rows.len()
    ));
    words.into()
}

/// The table of the report: one record a tool.
fn overview(rows: &[Row]) -> Value {
    let record = |r: &Row| {
        json!({
            "tool": r.tool,
            "mu_as_specified": number(r.mu),
            "order": r.order,
            "minimum_stiffness_mu_n_per_m": number(r.minimum(0)),
            "minimum_stiffness_pid_n_per_m": number(r.minimum(1)),
            "worst_stiffness_mu_n_per_m": number(r.worst[0]),
            "worst_stiffness_pid_n_per_m": number(r.worst[1]),
            "zone_mu": r.zone(0),
            "zone_pid": r.zone(1),
            "stable_to_rpm": number(r.stable_to_rpm),
            "meets_specification": r.met,
            "largest_tool_tightening": r.tightening.map(number),
        })
    };
    Value::Array(rows.iter().map(record).collect())
}

fn figures(rows: &[Row], top_speed_hz: f64) -> Vec<(&'static str, Figure)> {
    let names: Vec<String> = rows.iter().map(|r| r.tool.clone()).collect();
    let column = |f: &dyn Fn(&Row) -> f64| rows.iter().map(f).collect::<Vec<f64>>();
    let both = |f: &dyn Fn(&Row, usize) -> f64| {
        vec![
            ("µ controller", column(&|r| f(r, 0))),
            ("tuned PID", column(&|r| f(r, 1))),
        ]
    };
    let mut quantities = vec![
        ToolQuantity {
            label: "µ of the specification as written",
            unit: "",
            references: vec![(1.0, "µ = 1")],
            bars: vec![("µ controller", column(&|r| r.mu))],
        },
        ToolQuantity {
            label: "Smallest tool stiffness, 1–4000 Hz",
            unit: "N/µm",
            references: vec![],
            bars: both(&|r, k| 1e-6 * r.minimum(k)),
        },
        ToolQuantity {
            label: "The same in the worst case over uncertain modes, at rest, top speed and between",
            unit: "N/µm",
            references: vec![],
            bars: both(&|r, k| 1e-6 * r.worst[k]),
        },
        ToolQuantity {
            label: "Sensitivity peak and the zones of ISO 14839-3",
            unit: "dB",
            references: vec![(9.5, "A | B"), (12.0, "B | C"), (14.0, "C | D")],
            bars: both(&|r, k| r.peak_db(k)),
        },
        ToolQuantity {
            label: "Order of the controller",
            unit: "",
            references: vec![],
            bars: vec![("µ controller", column(&|r| r.order as f64))],
        },
    ];
    if rows.iter().any(|r| r.tightening.is_some()) {
        quantities.push(ToolQuantity {
            label: "Largest factor on the tool's specification",
            unit: "",
            references: vec![(1.0, "as written")],
            bars: vec![(
                "µ controller",
                column(&|r| r.tightening.unwrap_or(f64::NAN)),
            )],
        });
    }
    let curves = |k: usize| -> Vec<Curve> {
        rows.iter()
            .enumerate()
            .filter_map(|(n, r)| {
                let stiffness = &r.rest.get(k)?.stiffness[0];
                Some(Curve {
                    name: &r.tool,
                    role: Role::Other(n),
                    x: &stiffness.frequency_hz,
                    y: &stiffness.magnitude_n_per_m,
                })
            })
            .collect()
    };
    let panels = [("µ controllers", curves(0)), ("tuned PIDs", curves(1))];
    vec![
        ("tools", tools("A design per tool", &names, &quantities)),
        (
            "tools_stiffness",
            tool_stiffness("Dynamic stiffness with each tool", &panels, top_speed_hz),
        ),
    ]
}

fn table(rows: &[Row]) -> Table {
    let mut table = Table::with_columns(&[
        "tool",
        "mu_as_specified",
        "mu_with_gyroscopic_cover",
        "order",
        "minimum_stiffness_mu_n_per_m",
        "minimum_stiffness_pid_n_per_m",
        "worst_stiffness_mu_n_per_m",
        "worst_stiffness_pid_n_per_m",
        "iso_zone",
        "iso_zone_pid",
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
            Table::number(r.minimum(0)),
            Table::number(r.minimum(1)),
            Table::number(r.worst[0]),
            Table::number(r.worst[1]),
            r.zone(0).to_owned(),
            r.zone(1).to_owned(),
            Table::number(r.stable_to_rpm),
            r.met.to_string(),
            r.tightening.map_or_else(String::new, Table::number),
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

fn shown(rows: &[Row], out: &str) -> Shown {
    let met = rows.iter().filter(|r| r.met).count();
    let stiffness = |x: f64| match x.is_finite() {
        true => stiffness_words(x),
        false => "-".to_owned(),
    };
    let lines = rows.iter().map(|r| {
        let verdict = if r.met { "met" } else { "missed" };
        vec![
            r.tool.clone(),
            verdict.to_owned(),
            format!("{:.3}", r.mu),
            r.order.to_string(),
            stiffness(r.minimum(0)),
            stiffness(r.minimum(1)),
            r.zone(0).to_owned(),
            format!("{:.0}", r.stable_to_rpm),
        ]
    });
    let head = [
        "tool",
        "specification",
        "μ at rest",
        "order",
        "stiffness with μ",
        "with PID",
        "zone",
        "stable to rpm",
    ];
    Shown::met(
        met == rows.len(),
        format!("{met} of {} tools meet the specification", rows.len()),
    )
    .row(head)
    .rows(lines)
    .file(format!("{out}/report.html"))
    .file(format!("{out}/tools.csv"))
}
