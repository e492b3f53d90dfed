//! `muspin update`: move the element moduli until resonances and antiresonances match; writes the updated files.

use super::Failure;
use super::choices::PictureArguments;
use super::console::{CommandEnd, Console, REPORT};
use super::machine::{MeasuredMachine, coarse_up_to, load_machine, measured_mesh_warning, say};
use super::progress::Progress;
use super::reading::load_measurement;
use super::timings::Timings;
use crate::controller::Controller;
use crate::input::{Measurement, is_rotor};
use crate::pipeline::PipelineError;
use crate::pipeline::loop_stability::{growth_rate_at, unstable_words};
use crate::report::updating::updating_topic;
use crate::report::whole::Report;
use crate::spindle::Machine;
use crate::update::{
    Method, Targets, UpdateSettings, Updated, gauss_newton, gauss_newton_rotor, nelder_mead, nelder_mead_rotor,
    tool_error_db,
};
use crate::workflow::plausibility::Records;
use crate::workflow::update::{MachineUpdate, read_off, taps_of, targets, updated_rotor_report};
use serde_json::{Value, json};

#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Measurement folder, a YAML file of frequencies, or `paper-frequencies`
    #[arg(long, default_value = "paper-frequencies")]
    measurement: String,
    #[command(flatten)]
    machine: MeasuredMachine,
    /// Method
    #[arg(long, value_enum, default_value = "gauss-newton")]
    method: Method,
    /// FRFs of a sweep whose antiresonances are fitted; what is left of 11, 33, 13, 31 is compared only
    #[arg(long, value_delimiter = ',', default_value = "11,33")]
    frfs: Vec<String>,
    /// Leave the antiresonances off, as in the published case study; the full update is shown beside it
    #[arg(long)]
    resonances_only: bool,
    /// Relative standard deviation of frequencies that were read off a plot; default: estimated from the fit
    #[arg(long)]
    relative_deviation: Option<f64>,
    /// Exponent of the errors in Eq. (7), Nelder–Mead only
    #[arg(long, default_value_t = 2.0)]
    exponent: f64,
    /// Iterations of Nelder–Mead
    #[arg(long, default_value_t = 500)]
    iterations: usize,
    /// Folder for spindle.yaml, tool.yaml, summary.json, report.html, tables and plots
    #[arg(long, default_value = "results/update")]
    out: String,
    #[command(flatten)]
    pictures: PictureArguments,
    #[command(flatten)]
    timings: Timings,
}

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    let settings = settings(arguments)?;
    let measurement = load_measurement(&arguments.measurement, console)?;
    let files = arguments.machine.files(&measurement);
    if is_rotor(files.0) {
        return update_rotor(arguments, &settings, &measurement, console);
    }
    let machine = load_machine(files.0, files.1)?;
    console.claim(&arguments.out, &REPORT, &[])?;
    let progress = Progress::start(console);
    progress.start_stage("records");
    let records = Records::of(&measurement, Some(&machine), &|| {})?;
    records.refuse_for_updating()?;
    records.lines().for_each(|line| eprintln!("{line}"));
    progress.start_stage("resonances and antiresonances");
    let found = targets(&measurement, &records, &machine, arguments.relative_deviation)?;
    found.notes.iter().for_each(|note| eprintln!("{note}"));
    let (mut targets, identification) = (found.targets, found.identification);
    for (frf, code) in targets.antiresonances.iter_mut().zip(FRF_CODES) {
        frf.held_out = !arguments.frfs.iter().any(|f| f == code);
    }
    let fit = |settings: &UpdateSettings| match arguments.method {
        Method::GaussNewton => gauss_newton(&machine, &targets, settings),
        Method::NelderMead => nelder_mead(&machine, &targets, settings),
    };
    progress.start_stage("fit");
    let full = fit(&settings)?;
    let resonances_only = if arguments.resonances_only {
        let settings = UpdateSettings { use_antiresonances: false, ..settings };
        progress.start_stage("fit of resonances only");
        Some(fit(&settings)?)
    } else {
        None
    };
    let delivered = resonances_only.as_ref().unwrap_or(&full);
    if !delivered.fit.explanation.explained {
        measured_mesh_warning(&machine, files.0, files.1, targets.highest_hz())?.iter().for_each(say);
    }
    let models: Vec<(&str, &Updated)> = match &resonances_only {
        Some(only) => vec![("resonances_only", &only.fit), ("full", &full.fit)],
        None => vec![("updated", &full.fit)],
    };
    progress.start_stage("predictions for hammer tests");
    let compared = [&machine, &delivered.machine];
    let hammers = hammer_errors(&measurement, &records.controllers, compared)?;
    let mut updating = updating_topic(&delivered.fit);
    updating["resonances_only"] = json!(resonances_only.is_some());
    if resonances_only.is_some() {
        updating["full_update"] = updating_topic(&full.fit);
    }
    if !hammers.is_empty() {
        updating["held_out_tool_frf"] = json!(hammers);
    }
    progress.start_stage("report");
    let update = MachineUpdate {
        before: &machine,
        delivered,
        models: &models,
        records: &records,
        identification: identification.as_ref(),
    };
    let end = write_update(arguments, update.report(updating)?, &delivered.fit, records.plausible(), console)?;
    progress.end(arguments.timings);
    let out = arguments.out.as_str();
    let tool = (!machine.tool.is_absent()).then(|| format!("{out}/tool.yaml"));
    let with_tool = tool.iter().map(|file| format!(" --tool {file}")).collect::<String>();
    let end = end.row(["evaluations".to_owned(), delivered.fit.evaluations.to_string()]);
    Ok(tool
        .into_iter()
        .fold(end, CommandEnd::file)
        .next(format!("muspin design --spindle {out}/spindle.yaml{with_tool}"))
        .next(format!("muspin diagnose --measurement {}", arguments.measurement)))
}

/// Writes a report; the end of the command with what every update says of its fit.
fn write_update(
    arguments: &Arguments,
    mut report: Report,
    fit: &Updated,
    plausible: bool,
    console: &Console,
) -> Result<CommandEnd, Failure> {
    let (explanation, out) = (&fit.explanation, arguments.out.as_str());
    let largest = match fit.largest_error_percent() {
        percent if percent.is_finite() => format!("{percent:.4}"),
        _ => "a measured one has no counterpart".to_owned(),
    };
    console.writing(|| report.write(out, &arguments.pictures.formats))?;
    let end = CommandEnd::met(plausible && explanation.explained, explanation.statement.as_str())
        .json(report.summary.to_json() + "\n")
        .row(["largest error of a frequency, %".to_owned(), largest])
        .file(format!("{out}/report.html"))
        .file(format!("{out}/spindle.yaml"));
    Ok(if explanation.explained { end } else { end.say(explanation.statement.as_str()) })
}

/// Codes of the FRFs, output and input axis, in the order of the targets.
const FRF_CODES: [&str; 4] = ["11", "33", "13", "31"];

fn settings(arguments: &Arguments) -> Result<UpdateSettings, Failure> {
    if let Some(r) = arguments.relative_deviation
        && !(r > 0.0 && r < 1.0)
    {
        return Err(Failure::new(format!("--relative-deviation: {r} must lie between 0 and 1"))
            .with_hint("0.001 means that frequencies are known to 0.1 %"));
    }
    if !(arguments.exponent > 0.0 && arguments.exponent <= 10.0) {
        return Err(Failure::new(format!("--exponent: {} must lie between 0 and 10", arguments.exponent))
            .with_hint("1 sums errors, 2 sums their squares"));
    }
    if let Some(unknown) = arguments.frfs.iter().find(|f| !FRF_CODES.contains(&f.as_str())) {
        return Err(Failure::new(format!("--frfs: {unknown:?} is none of {}", FRF_CODES.join(", ")))
            .with_hint("the first digit is the sensor, the second the actuator: 1 front, 3 rear"));
    }
    if arguments.iterations == 0 {
        return Err(Failure::new("--iterations: 0 does nothing").with_hint("the reference method takes 400 to 500"));
    }
    Ok(UpdateSettings {
        resonance_exponent: arguments.exponent,
        antiresonance_exponent: arguments.exponent,
        iterations: arguments.iterations,
        ..UpdateSettings::default()
    })
}

/// The moduli of a rotor without magnets.
fn update_rotor(
    arguments: &Arguments,
    settings: &UpdateSettings,
    measurement: &Measurement,
    console: &Console,
) -> Result<CommandEnd, Failure> {
    let rotor = arguments.machine.load_rotor(measurement)?;
    console.claim(&arguments.out, &REPORT, &[])?;
    let progress = Progress::start(console);
    let records = Records::of(measurement, None, &|| {})?;
    records.lines().for_each(|line| eprintln!("{line}"));
    progress.start_stage("resonances and antiresonances");
    let shaft = rotor.rotor()?;
    let mut targets = match measurement.frequencies.first() {
        Some(read) => Targets {
            resonances: read_off(&read.resonances_hz, arguments.relative_deviation),
            springs: rotor.springs(0),
            ..Targets::default()
        },
        None => {
            let springs = |axis| rotor.springs(axis);
            let (found, notes) = taps_of(measurement, &shaft, rotor.tool_plane_m(), &springs)?;
            notes.iter().for_each(|note| eprintln!("{note}"));
            found
        }
    };
    targets.mode_shapes = measurement.mode_shapes.clone();
    progress.start_stage("fit");
    let settings = UpdateSettings { use_antiresonances: !arguments.resonances_only, ..settings.clone() };
    let fit = match arguments.method {
        Method::GaussNewton => gauss_newton_rotor(&shaft, &targets, &settings)?,
        Method::NelderMead => nelder_mead_rotor(&shaft, &targets, &settings)?,
    };
    if !fit.explanation.explained {
        let (file, tool) = arguments.machine.files(measurement);
        coarse_up_to(&rotor, [file, tool], targets.highest_hz())?.iter().for_each(say);
    }
    progress.start_stage("report");
    let end = write_update(arguments, updated_rotor_report(&rotor, &fit)?, &fit, true, console)?;
    progress.end(arguments.timings);
    Ok(end.next(format!("muspin modes --spindle {}/spindle.yaml", arguments.out)))
}

/// How well the closed-loop compliance at the tool is predicted before and after: data that no fit has used.
fn hammer_errors(
    measurement: &Measurement,
    controllers: &[Controller],
    [before, after]: [&Machine; 2],
) -> Result<Vec<Value>, Failure> {
    let mut list = vec![];
    let levitated = measurement.hammers.iter();
    let levitated = levitated.filter(|hammer| hammer.controller.is_some());
    for (hammer, controller) in levitated.zip(controllers) {
        // A model whose loop is unstable predicts no compliance: the rotor was levitated, so the model is wrong there.
        let error = |machine: &Machine| -> Result<(Option<f64>, f64), PipelineError> {
            let growth = growth_rate_at(machine, controller, hammer.frf.speed_rpm)?;
            if growth >= 0.0 {
                return Ok((None, growth));
            }
            let db = tool_error_db(machine, &hammer.frf, hammer.axis, controller)?;
            Ok((Some(db), growth))
        };
        let both = error(before).and_then(|before| Ok((before, error(after)?)));
        let ((before_db, before_growth), (after_db, after_growth)) = match both {
            Ok(both) => both,
            Err(PipelineError::Numeric { stage, source }) => {
                eprintln!("note: {}: its loop is not judged: {stage}: {source}", hammer.name);
                continue;
            }
            Err(other) => return Err(other.into()),
        };
        if after_growth >= 0.0 {
            eprintln!(
                "warning: {}: the updated model is {}",
                hammer.name,
                unstable_words(after_growth, hammer.frf.speed_rpm)
            );
        }
        list.push(json!({
            "file": hammer.name,
            "before_db_rms": before_db,
            "after_db_rms": after_db,
            "before_growth_rate_per_s": before_growth,
            "after_growth_rate_per_s": after_growth,
        }));
    }
    Ok(list)
}
