//! `muspin design`: D-K iteration, reduction, sampling, rounding, verification, firmware tables.

use super::console::{CommandEnd, Console};
use super::design_arguments::{DesignArguments, RouteArgument, tightening};
use super::design_progress::told;
use super::earlier::EarlierArgument;
use super::output::{REPORT, claim};
use super::progress::Progress;
use super::timings::Timings;
use super::{Failure, Outcome};
use crate::pipeline::certificates::mu_words;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::design::{Design, NO_FIRMWARE};
use crate::pipeline::overspeed::OVERSPEED;
use crate::pipeline::problem_set::ProblemSet;
use crate::pipeline::settings::{DesignSettings, PolishEffort};
use crate::pipeline::study::{Questions, study};
use crate::pipeline::tightening::Tightening;
use crate::predict::sensitivity::Zone;
use crate::predict::stiffness::stiffness_words;
use crate::report::design_study::design_report;
use crate::report::margins::loop_rows;
use crate::report::place_words::place_words;
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
    #[arg(long, value_name = "auto|FACTOR", value_parser = tightening)]
    tighten: Option<Tightening>,
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
    let questions = Questions {
        tightening: arguments.tighten,
        other_route: arguments.compare_routes,
        lowest_order: arguments.lowest_order,
        limit: arguments.limit,
    };
    let study = study(&machine, &written, &settings, questions, &mut |event| {
        told(&progress, event);
    })?;
    progress.start_stage("report");
    let mut report = design_report(&machine, &study, settings.route)?;
    let found = &study.design;
    let [rest, speed] = study.delivered.each_ref();
    if arguments.problem {
        report.problem(&ProblemSet::of(found, &study.weights)?)?;
    }
    console.writing(|| report.write(&arguments.out))?;
    arguments.timings.print(&progress.times());
    drop(progress);
    let ended = outcome(found, [rest, speed]);
    let out = arguments.out.as_str();
    if let Some(words) = found.instability_words() {
        say_unstable(console, &words);
        console.json(&report.summary.to_json(), || shown_unstable(found, &words).file(format!("{out}/report.html")))?;
        return Ok(ended);
    }
    console.json(&report.summary.to_json(), || {
        let words = design_words(&machine, found, rest);
        let shown = shown_design(found, ended, &words)
            .rows(loop_rows([rest, speed], study.curves.stable.as_ref()))
            .file(format!("{out}/report.html"))
            .file(format!("{out}/controller"))
            .next(format!("muspin simulate --controller {out}/controller/discrete.json --case impulse"));
        if found.has_firmware() {
            shown.next(format!("muspin export --controller {out}/controller/discrete.json --out firmware"))
        } else {
            shown
        }
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
    let stiffness = if rest.is_stable() {
        format!(
            ", smallest tool stiffness {} at {:.0} Hz, zone {}",
            stiffness_words(rest.minimum.0),
            rest.minimum.1,
            rest.zone_word()
        )
    } else {
        ", unstable at rest".to_owned()
    };
    let words = format!(
        "{} with {}: μ {} at most from rest to {:.0} rpm{stiffness}.",
        machine.spindle.name,
        machine.tool.name,
        mu_words(design.largest_mu()),
        OVERSPEED * machine.spindle.max_rpm,
    );
    let scale = design.specification_scale.as_ref().map(|scale| format!(" {}", scale.sentence()));
    let unproven =
        (!design.has_firmware()).then(|| format!(" Its stability is not proven at every speed. {NO_FIRMWARE}"));
    place_words(machine, format!("{words}{}{}", scale.unwrap_or_default(), unproven.unwrap_or_default()))
}

/// Says on standard error that a design is unstable, where the answer on standard output does not begin with that.
pub(super) fn say_unstable(console: &Console, words: &str) {
    if !console.writes_text() {
        eprintln!("{words}");
    }
}

/// An unstable design for a person: no figure of it has a meaning.
pub(super) fn shown_unstable(design: &Design, words: &str) -> CommandEnd {
    CommandEnd::met(false, words)
        .row(["proven stable to, rpm".to_owned(), format!("{:.0}", design.delivery.speed_proof.proven_to_rpm())])
}

/// The figures of a design for a person, below the sentences `words`.
pub(super) fn shown_design(design: &Design, ended: Outcome, words: &str) -> CommandEnd {
    let yes = |good: bool| if good { "yes" } else { "no" }.to_owned();
    CommandEnd::met(ended == Outcome::Done, words)
        .row(["", "reached", "asked"])
        .row(["μ of the specification at rest".to_owned(), design.delivery.rounded.specification.words(), "≤ 1".into()])
        .row(["μ, largest from rest to 1.2 × top speed".to_owned(), mu_words(design.largest_mu()), "≤ 1".into()])
        .row([
            "proven stable to, rpm".to_owned(),
            format!("{:.0}", design.delivery.speed_proof.proven_to_rpm()),
            format!("{:.0}", design.delivery.speed_proof.to_rpm),
        ])
        .row(["stable at every speed".to_owned(), yes(design.is_stable()), "yes".into()])
        .row(["order of the controller".to_owned(), (2 * design.delivery.rounded.order).to_string(), String::new()])
}
