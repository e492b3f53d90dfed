//! `muspin design`: D-K iteration, reduction, sampling, rounding, verification, firmware tables.

use super::console::{Console, Shown};
use super::controlled_machine::machine_tag;
use super::design_arguments::DesignArguments;
use super::design_progress::run_design_with;
use super::design_variants::{RouteArgument, Tighten, routes_json, tightened, tightening_json};
use super::output::{REPORT, claim};
use super::progress::Progress;
use super::timings::Timings;
use super::{Failure, Outcome};
use crate::augment::weights::Weights;
use crate::controller::MachineTag;
use crate::input::{spindle_yaml, tool_yaml};
use crate::pipeline::PipelineError;
use crate::pipeline::certificates::mu_words;
use crate::pipeline::comparison::{BAND_HZ, Prediction, predict};
use crate::pipeline::design::Design;
use crate::pipeline::overspeed::OVERSPEED;
use crate::pipeline::settings::{DesignSettings, PolishEffort};
use crate::predict::sensitivity::Zone;
use crate::predict::stiffness::stiffness_words;
use crate::report::design_summary::{arithmetic_json, limit_json};
use crate::report::firmware::{Firmware, Format, write_all};
use crate::report::firmware_c::c_identifier;
use crate::report::loop_figures::{loop_figures, margin_json};
use crate::report::prediction_summary::{sensitivity_json, stiffness_json};
use crate::report::results::ResultsFolder;
use crate::report::run_figures::{Measured, predictions, robustness};
use crate::report::run_summary::design_json;
use crate::report::summary::Summary;
use crate::report::{html, plot::Role};
use crate::spindle::Machine;
use std::path::Path;

/// Arguments of `muspin design`.
#[derive(clap::Args, Debug)]
pub struct Arguments {
    #[command(flatten)]
    machine: DesignArguments,
    /// How the sampled loop enters the synthesis; the verification is the same for both
    #[arg(long, value_enum, default_value = "direct")]
    route: RouteArgument,
    /// Design by both routes and put the difference into summary and report
    #[arg(long)]
    compare_routes: bool,
    /// Divide the tool's displacement limits by a factor, or with `auto` by the largest with µ ≤ 1 (a bound on the
    /// complementary sensitivity gives way, unless the weights file states it), and compare with the design as written
    #[arg(long, value_name = "auto|FACTOR")]
    tighten: Option<Tighten>,
    /// Deliver the reduced controller of the D-K iteration without the polish for tool stiffness
    #[arg(long)]
    no_polish: bool,
    /// Compute how stiff any linear controller within the limits of the polish could make the tool at rest (convex, 48 taps)
    #[arg(long)]
    limit: bool,
    /// Folder for controller, certificates, pictures and report
    #[arg(long, default_value = "results/design")]
    out: String,
    #[command(flatten)]
    timings: Timings,
}

/// Look of the controller of the D-K iteration beside the polished one.
pub const UNPOLISHED: Role = Role::Other(2);

impl From<PipelineError> for Failure {
    fn from(error: PipelineError) -> Self {
        let hint = match &error {
            PipelineError::Synthesis(inner) => inner.advice().to_owned(),
            PipelineError::Plant(_) => {
                "`muspin check` on the spindle and tool files shows more".to_owned()
            }
            PipelineError::Emulated { .. } => {
                "use --route direct, or a higher sample rate".to_owned()
            }
            _ => "loosen the weights, or check the spindle's data".to_owned(),
        };
        Self::new(error.to_string()).with_hint(hint)
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments, console: &Console) -> Result<Outcome, Failure> {
    let (machine, written) = arguments.machine.load()?;
    claim(&arguments.out, &REPORT, arguments.machine.files())?;
    let progress = Progress::start(console);
    let settings = DesignSettings {
        route: arguments.route.into(),
        polish: (!arguments.no_polish).then(PolishEffort::default),
        ..DesignSettings::default()
    };
    let (found, factor) = match arguments.tighten {
        None => (
            run_design_with(&machine, &written, &settings, &progress)?,
            1.0,
        ),
        Some(asked) => tightened(&machine, &written, &settings, asked, &progress)?,
    };
    let mut folder = ResultsFolder::new();
    let mut summary = Summary::new();
    summary.set("run", "design");
    summary.set("spindle", machine.spindle.name.as_str());
    summary.set("tool", machine.tool.name.as_str());
    summary.set("weights", written.name.as_str());
    summary.set("design", design_json(&found));
    let runs = [0.0, machine.spindle.max_rpm]
        .map(|rpm| predict(&machine, &found.delivery.controller, rpm));
    let [rest, speed] = runs;
    let (rest, speed) = (rest?, speed?);
    add_arithmetic(&mut summary, &machine, &found)?;
    if let Some(asked) = arguments.tighten {
        let own = (&found, &rest);
        let json = tightening_json(
            &machine,
            &written,
            &settings,
            own,
            (factor, asked),
            &progress,
        )?;
        summary.set("tightening", json);
    }
    if arguments.compare_routes {
        let weights = Weights {
            tool_tightening: written.tool_tightening * factor,
            ..written.clone()
        };
        let json = routes_json(&machine, &weights, &settings, (&found, &rest), &progress)?;
        summary.set("routes.designs", json);
    }
    add_predictions(&mut summary, "mu", &rest, &speed);
    let unpolished = of_unpolished(&machine, &found)?;
    let mut runs = vec![(Role::Mu, &rest), (Role::Mu, &speed)];
    if let Some([dk, fast]) = &unpolished {
        add_predictions(&mut summary, "dk", dk, fast);
        runs.extend([(UNPOLISHED, dk), (UNPOLISHED, fast)]);
    }
    let mut limits = vec![];
    if arguments.limit {
        let limit = found.stiffness_limit(&machine)?;
        progress.stage("limit of the stiffness");
        summary.set("design.stiffness_limit", limit_json(&limit, rest.minimum.0));
        limits.push(Measured::limit(&limit, BAND_HZ));
    }
    for (stem, figure) in robustness(&found).into_iter().chain(predictions(
        &runs,
        &limits,
        machine.spindle.max_rpm / 60.0,
    )) {
        folder.add_plot(&stem, &figure)?;
    }
    add_loop(&mut folder, &mut summary, &machine, &found, [&rest, &speed])?;
    let tag = machine_tag(&machine, "../spindle.yaml", "../tool.yaml");
    add_controller(&mut folder, &machine, &found, &tag)?;
    folder.add("spindle.yaml", spindle_yaml(&machine.spindle))?;
    folder.add("tool.yaml", tool_yaml(&machine.tool))?;
    finish(&mut folder, &mut summary, &arguments.out)?;
    arguments.timings.print(&progress.watch());
    drop(progress);
    let ended = outcome(&found, [&rest, &speed]);
    let out = arguments.out.as_str();
    console.json(&summary.to_json(), || {
        let words = design_words(&machine, &found, &rest);
        shown_design(&found, ended, &words)
            .file(format!("{out}/report.html"))
            .file(format!("{out}/controller"))
            .next(format!(
                "muspin simulate --controller {out}/controller/discrete.json --case impulse"
            ))
            .next(format!(
                "muspin export --controller {out}/controller/discrete.json --out firmware"
            ))
    })?;
    Ok(ended)
}

/// µ and tool stiffness with the coefficients of each arithmetic.
pub fn add_arithmetic(
    summary: &mut Summary,
    machine: &Machine,
    design: &Design,
) -> Result<(), Failure> {
    let rest: Result<Vec<Prediction>, PipelineError> = design
        .delivery
        .arithmetic
        .iter()
        .map(|a| predict(machine, &a.controller, 0.0))
        .collect();
    summary.set("design.arithmetic", arithmetic_json(design, &rest?));
    Ok(())
}

/// Exit of a design: done, or a target missed. `predictions` are those of its controller at rest and at top speed: zone D of
/// ISO 14839-3 is not acceptable, zone C is good for a limited time and only said.
pub fn outcome(design: &Design, predictions: [&Prediction; 2]) -> Outcome {
    let acceptable = |p: &Prediction| p.zone().is_some_and(|zone| zone < Zone::D);
    if design.meets_targets() && predictions.into_iter().all(acceptable) {
        Outcome::Done
    } else {
        Outcome::TargetMissed
    }
}

/// The pictures of the loop and its margins at rest (`margins.mu`).
pub fn add_loop(
    folder: &mut ResultsFolder,
    summary: &mut Summary,
    machine: &Machine,
    design: &Design,
    runs: [&Prediction; 2],
) -> Result<(), Failure> {
    let (figures, margin) = loop_figures(machine, &design.delivery.controller, runs)?;
    for (stem, figure) in &figures {
        folder.add_plot(stem, figure)?;
    }
    if let Some(margin) = &margin {
        summary.set("margins.mu", margin_json(margin));
    }
    Ok(())
}

/// Stiffness and sensitivity of a controller at rest and at top speed.
pub fn add_predictions(summary: &mut Summary, name: &str, rest: &Prediction, speed: &Prediction) {
    summary.set(&format!("stiffness.{name}"), stiffness_json(rest));
    summary.set(
        &format!("stiffness.{name}.at_top_speed"),
        stiffness_json(speed),
    );
    summary.set(&format!("sensitivity.{name}"), sensitivity_json(rest));
    summary.set(
        &format!("sensitivity.{name}.at_top_speed"),
        sensitivity_json(speed),
    );
}

/// Predictions at rest and top speed with the controller of the D-K iteration, where a polished one is delivered.
pub fn of_unpolished(
    machine: &Machine,
    design: &Design,
) -> Result<Option<[Prediction; 2]>, Failure> {
    let Some(polish) = design.polish.as_ref().filter(|p| p.delivered.is_some()) else {
        return Ok(None);
    };
    let top = machine.spindle.max_rpm;
    let [rest, speed] = [0.0, top].map(|rpm| predict(machine, &polish.dk.controller, rpm));
    Ok(Some([rest?, speed?]))
}

/// The `controller/` folder of a run: JSON, `.mat`, C, tables, test vectors; `tag` names the machine's files beside it.
pub fn add_controller(
    folder: &mut ResultsFolder,
    machine: &Machine,
    design: &Design,
    tag: &MachineTag,
) -> Result<(), Failure> {
    let name = format!("{} with {}", machine.spindle.name, machine.tool.name);
    let files = write_all(
        &Firmware {
            discrete: &design.delivery.controller,
            // The design's own continuous controller lives in the w plane; no frequency there is a true one.
            continuous: None,
            scaled: &design.delivery.realisation,
            verification: &design.delivery.verification,
            machine: &name,
            tag: Some(tag),
            prefix: &c_identifier(&machine.tool.name),
        },
        &Format::ALL,
    )
    .map_err(|e| Failure::new(format!("firmware: {e}")))?;
    for (file, bytes) in files {
        folder.add(&format!("controller/{file}"), bytes)?;
    }
    Ok(())
}

/// Adds summary and report to the folder and writes it whole.
pub fn finish(folder: &mut ResultsFolder, summary: &mut Summary, out: &str) -> Result<(), Failure> {
    let page = html::report(&summary.value(), &folder.pictures())
        .map_err(|e| Failure::new(format!("report: {e}")))?;
    folder.add("report.html", page)?;
    folder.add("summary.json", summary.to_json())?;
    folder.write(Path::new(out))?;
    Ok(())
}

/// The verdict on a design in one sentence.
fn design_words(machine: &Machine, design: &Design, rest: &Prediction) -> String {
    let stiffness = match rest.is_stable() {
        true => format!(
            ", smallest tool stiffness {} at {:.0} Hz, zone {}",
            stiffness_words(rest.minimum.0),
            rest.minimum.1,
            rest.zone_word()
        ),
        false => ", unstable at rest".to_owned(),
    };
    let words = format!(
        "{} with {}: μ {} at most from rest to {:.0} rpm{stiffness}.",
        machine.spindle.name,
        machine.tool.name,
        mu_words(design.largest_mu()),
        OVERSPEED * machine.spindle.max_rpm,
    );
    match &design.specification_scale {
        Some(scale) => format!("{words} {}", scale.sentence()),
        None => words,
    }
}

/// The figures of a design for a person, below the sentences `words`.
pub fn shown_design(design: &Design, ended: Outcome, words: &str) -> Shown {
    let yes = |good: bool| if good { "yes" } else { "no" }.to_owned();
    Shown::met(ended == Outcome::Done, words)
        .row(["", "reached", "asked"])
        .row([
            "μ of the specification at rest".to_owned(),
            design.delivery.rounded.specification.words(),
            "≤ 1".into(),
        ])
        .row([
            "μ, largest from rest to 1.2 × top speed".to_owned(),
            mu_words(design.largest_mu()),
            "≤ 1".into(),
        ])
        .row([
            "proven stable to, rpm".to_owned(),
            format!("{:.0}", design.delivery.speed_proof.proven_to_rpm()),
            format!("{:.0}", design.delivery.speed_proof.to_rpm),
        ])
        .row([
            "stable at every speed".to_owned(),
            yes(design.is_stable()),
            "yes".into(),
        ])
        .row([
            "order of the controller".to_owned(),
            (2 * design.delivery.rounded.order).to_string(),
            String::new(),
        ])
}
