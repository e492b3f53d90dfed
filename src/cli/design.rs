//! `muspin design`: D-K iteration, reduction, sampling, rounding, verification, firmware tables.

use super::Failure;
use super::choices::PictureArguments;
use super::console::{CommandEnd, Console, REPORT};
use super::design_arguments::{DesignArguments, RouteArgument, tightening};
use super::design_progress::told;
use super::earlier::EarlierArgument;
use super::progress::Progress;
use super::timings::Timings;
use crate::pipeline::certificates::mu_words;
use crate::pipeline::comparison::Prediction;
use crate::pipeline::design::{Design, NO_FIRMWARE};
use crate::pipeline::loop_curves::StableLoop;
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
use crate::report::thrust::thrust_words;
use crate::spindle::Machine;

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
    pictures: PictureArguments,
    #[command(flatten)]
    from: EarlierArgument,
    #[command(flatten)]
    timings: Timings,
}

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    let (machine, written) = arguments.machine.load()?;
    console.claim(&arguments.out, &REPORT, &[])?;
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
    console.writing(|| report.write(&arguments.out, &arguments.pictures.formats))?;
    progress.end(arguments.timings);
    let mut words = found.instability_words().unwrap_or_else(|| design_words(&machine, found, rest));
    words.extend(found.thrust.iter().map(|thrust| format!(" {}", thrust_words(thrust))));
    say_unstable(console, found.instability.is_some(), &words);
    let out = arguments.out.as_str();
    let shown = DesignEnd { design: found, delivered: [rest, speed], stable: study.curves.stable.as_ref(), out };
    let end = shown.end(&words).json(report.summary.to_json());
    Ok(if found.instability.is_none() && found.has_firmware() {
        end.next(format!("muspin export --controller {out}/controller/discrete.json --out firmware"))
    } else {
        end
    })
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
    let softer = design.share_of_floors.filter(|_| !design.holds_floors());
    let softer =
        softer.map(|share| format!(" The tool has {share:.2} of the stiffness that `tool_stiffness` asks for."));
    let scale = design.specification_scale.as_ref().map(|scale| format!(" {}", scale.sentence()));
    let unproven =
        (!design.has_firmware()).then(|| format!(" Its stability is not proven at every speed. {NO_FIRMWARE}"));
    let further: String = [softer, scale, unproven].into_iter().flatten().collect();
    place_words(machine, format!("{words}{further}"))
}

/// Says on standard error that a design is unstable, where the answer on standard output does not begin with that.
pub(super) fn say_unstable(console: &Console, is_unstable: bool, words: &str) {
    if is_unstable && !console.writes_text() {
        eprintln!("{words}");
    }
}

/// A design for a person.
pub(super) struct DesignEnd<'a> {
    pub design: &'a Design,
    /// Predictions of its controller at rest and at top speed.
    pub delivered: [&'a Prediction; 2],
    pub stable: Option<&'a StableLoop>,
    /// Folder of its results.
    pub out: &'a str,
}

impl DesignEnd<'_> {
    /// Whether every target is met: zone D of ISO 14839-3 is not acceptable, zone C is good for a limited time and only
    /// said.
    fn met(&self) -> bool {
        let acceptable = |p: &Prediction| p.zone().is_some_and(|zone| zone < Zone::D);
        self.design.meets_targets() && self.delivered.into_iter().all(acceptable)
    }

    /// The figures of the design below the sentences `words`; of an unstable one none has a meaning.
    pub(super) fn end(&self, words: &str) -> CommandEnd {
        let (design, out) = (self.design, self.out);
        let proven = format!("{:.0}", design.delivery.speed_proof.proven_to_rpm());
        if design.instability.is_some() {
            return CommandEnd::met(false, words)
                .row(["proven stable to, rpm".to_owned(), proven])
                .file(format!("{out}/report.html"));
        }
        let yes = |good: bool| if good { "yes" } else { "no" }.to_owned();
        let rounded = &design.delivery.rounded;
        let decay = design.least_decay().map(|[slowest, asked]| {
            vec!["slowest decay of the loop, 1/s".to_owned(), format!("{slowest:.2}"), format!("≥ {asked}")]
        });
        let floors = design.share_of_floors.map(|share| {
            vec!["tool stiffness over `tool_stiffness`, least".to_owned(), format!("{share:.3}"), "≥ 1".to_owned()]
        });
        CommandEnd::met(self.met(), words)
            .row(["", "reached", "asked"])
            .row(["μ of the specification at rest".to_owned(), rounded.specification.words(), "≤ 1".into()])
            .row(["μ, largest from rest to 1.2 × top speed".to_owned(), mu_words(design.largest_mu()), "≤ 1".into()])
            .row(["proven stable to, rpm".to_owned(), proven, format!("{:.0}", design.delivery.speed_proof.to_rpm)])
            .row(["stable at every speed".to_owned(), yes(design.is_stable()), "yes".into()])
            .row(["order of the controller".to_owned(), (2 * rounded.order).to_string(), String::new()])
            .rows(decay.into_iter().chain(floors).chain(loop_rows(self.delivered, self.stable)))
            .file(format!("{out}/report.html"))
            .file(format!("{out}/controller"))
            .next(format!("muspin simulate --controller {out}/controller/discrete.json --case impulse"))
    }
}
