//! `muspin design`: D-K iteration, reduction, sampling, rounding, verification, firmware tables.

use super::console::{Console, Shown};
use super::design_arguments::DesignArguments;
use super::design_progress::{run_design_with, told};
use super::design_variants::{RouteArgument, Tighten, both_routes, tightened, tightening_beside};
use super::earlier::EarlierArgument;
use super::output::{REPORT, claim};
use super::progress::Progress;
use super::timings::Timings;
use super::{Failure, Outcome};
use crate::augment::weights::Weights;
use crate::pipeline::PipelineError;
use crate::pipeline::certificates::mu_words;
use crate::pipeline::comparison::{BAND_HZ, Prediction};
use crate::pipeline::design::Design;
use crate::pipeline::loop_curves::LoopCurves;
use crate::pipeline::order_curve::lowest_order;
use crate::pipeline::overspeed::OVERSPEED;
use crate::pipeline::problem_set::ProblemSet;
use crate::pipeline::run::{at_rest_and_top_speed, by_arithmetic, unpolished};
use crate::pipeline::settings::{DesignSettings, PolishEffort};
use crate::predict::sensitivity::Zone;
use crate::predict::stiffness::stiffness_words;
use crate::report::design_summary::DesignSummary;
use crate::report::order_curve::{OrderCurveSummary, order_figure};
use crate::report::pictures::Picture;
use crate::report::plot::Role;
use crate::report::run::UNPOLISHED;
use crate::report::run_figures::{Measured, predictions, robustness};
use crate::report::variant_summary::LimitSummary;
use crate::report::whole::Report;
use crate::spindle::Machine;

/// Arguments of `muspin design`.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
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
    /// Cut the polished controller and polish it again, order by order, and deliver the lowest order that keeps 95 % of
    /// the smallest tool stiffness and every goal; the curve is in the report
    #[arg(long, conflicts_with = "no_polish")]
    lowest_order: bool,
    /// Compute how stiff any linear controller within the limits of the polish could make the tool at rest (convex, 48
    /// taps)
    #[arg(long)]
    limit: bool,
    /// Write generalized plants, weights, D-scales, controller and closed loop as state space: `problem/` with JSON in
    /// the formats of `muspin solve`, and `problem.mat`
    #[arg(long)]
    problem: bool,
    /// Folder for controller, certificates, pictures and report
    #[arg(long, default_value = "results/design")]
    out: String,
    #[command(flatten)]
    from: EarlierArgument,
    #[command(flatten)]
    timings: Timings,
}

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
pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<Outcome, Failure> {
    let (machine, written) = arguments.machine.load()?;
    claim(&arguments.out, &REPORT, arguments.machine.files())?;
    let progress = Progress::start(console);
    let settings = DesignSettings {
        route: arguments.route.into(),
        polish: (!arguments.no_polish).then(PolishEffort::default),
        earlier: arguments.from.design(&machine)?,
        ..DesignSettings::default()
    };
    let (mut found, factor) = match arguments.tighten {
        None => (
            run_design_with(&machine, &written, &settings, &progress)?,
            1.0,
        ),
        Some(asked) => tightened(&machine, &written, &settings, asked, &progress)?,
    };
    // The specification that the design was asked to meet.
    let asked = Weights {
        tool_tightening: written.tool_tightening * factor,
        ..written.clone()
    };
    let orders = match arguments.lowest_order {
        true => Some(lowest_order(
            &machine,
            &asked,
            &settings,
            &mut found,
            &mut |event| {
                told(&progress, event);
            },
        )?),
        false => None,
    };
    let mut report = Report::of("design", &machine);
    report.summary.set("weights", written.name.as_str());
    report.summary.set("design", DesignSummary::from(&found));
    if let Some(curve) = &orders {
        let summary = OrderCurveSummary::of(curve);
        report.summary.set("design.order_curve", summary);
        report.figures([(Picture::OrderCurve, order_figure(curve))])?;
    }
    let delivered = at_rest_and_top_speed(&machine, &found.delivery.controller)?;
    let [rest, speed] = delivered.each_ref();
    report.arithmetic(&found, &by_arithmetic(&machine, &found)?);
    if let Some(tighten) = arguments.tighten {
        let own = (&found, rest);
        let tightening = (factor, tighten);
        let beside = tightening_beside(&machine, &written, &settings, own, tightening, &progress)?;
        report.summary.set("tightening", beside);
    }
    if arguments.compare_routes {
        let designs = both_routes(&machine, &asked, &settings, (&found, rest), &progress)?;
        report.summary.set("routes.designs", designs);
    }
    report.predictions("mu", [rest, speed]);
    let unpolished = unpolished(&machine, &found)?;
    let mut runs = vec![(Role::Mu, rest), (Role::Mu, speed)];
    if let Some([dk, fast]) = &unpolished {
        report.predictions("dk", [dk, fast]);
        runs.extend([(UNPOLISHED, dk), (UNPOLISHED, fast)]);
    }
    let mut limits = vec![];
    if arguments.limit {
        progress.stage("limit of the stiffness");
        let limit = found.stiffness_limit(&machine)?;
        let figures = LimitSummary::of(&limit, rest.minimum.0);
        report.summary.set("design.stiffness_limit", figures);
        limits.push(Measured::limit(&limit, BAND_HZ));
    }
    let top_hz = machine.spindle.max_rpm / 60.0;
    report.figures(robustness(&found))?;
    report.figures(predictions(&runs, &limits, top_hz))?;
    let curves = LoopCurves::of(&machine, &found.delivery.controller, rest)?;
    report.loop_of(&curves, [rest, speed], machine.spindle.max_rpm)?;
    report.controller(&machine, &found, None)?;
    if arguments.problem {
        report.problem(&ProblemSet::of(&found, &asked)?)?;
    }
    console.writing(|| report.write(&arguments.out))?;
    arguments.timings.print(&progress);
    drop(progress);
    let ended = outcome(&found, [rest, speed]);
    let out = arguments.out.as_str();
    console.json(&report.summary.to_json(), || {
        let words = design_words(&machine, &found, rest);
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

/// Exit of a design: done, or a target missed. `predictions` are those of its controller at rest and at top speed: zone
/// D of ISO 14839-3 is not acceptable, zone C is good for a limited time and only said.
pub(super) fn outcome(design: &Design, predictions: [&Prediction; 2]) -> Outcome {
    let acceptable = |p: &Prediction| p.zone().is_some_and(|zone| zone < Zone::D);
    if design.meets_targets() && predictions.into_iter().all(acceptable) {
        Outcome::Done
    } else {
        Outcome::TargetMissed
    }
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
pub(super) fn shown_design(design: &Design, ended: Outcome, words: &str) -> Shown {
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
