//! `muspin export`: firmware tables of a controller, verified first on the sampled closed loop of the full plant.

use super::Failure;
use super::console::{CommandEnd, Console};
use super::controlled_machine::{ControlledMachine, MachineArguments};
use super::fmu::archives;
use super::machine::Remarks;
use super::speeds::parse_one_speed;
use crate::controller::Controller;
use crate::controller::anti_windup::{AntiWindup, with_anti_windup};
use crate::controller::fidelity::TransferChange;
use crate::controller::realise::{Form, modal_form};
use crate::controller::scaling::{ScaledRealisation, SignalLimits, scale_realisation};
use crate::controller::sections::second_order_sections;
use crate::controller::verification::Verification;
use crate::controller::verification::growth_words;
use crate::export::c::{c_identifier, is_prefix, stability_words};
use crate::export::firmware::{Firmware, Format, write_all};
use crate::export::fmu::{controller_unit, machine_unit};
use crate::export::table::controller_table;
use crate::lti::{Discrete, StateSpace};
use crate::pipeline::PipelineError;
use crate::pipeline::firmware_proof::{changed_by_rounding, proven_as_rounded};
use crate::pipeline::sampled::{SampledController, sample_controller};
use crate::predict::time::TimeSettings;
use crate::report::results::ResultsFolder;
use crate::report::simulation::anti_windup_topic;
use crate::spindle::Machine;
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::path::Path;

#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Controller file (JSON); several make a table with bumpless change at run time
    #[arg(long, required = true)]
    controller: Vec<String>,
    /// Kinds of files
    #[arg(long, value_delimiter = ',', default_value = "c,csv,mat,json")]
    format: Vec<Format>,
    /// Arrangement of the sums
    #[arg(long, value_enum, default_value = "modal")]
    form: Form,
    #[command(flatten)]
    machine: MachineArguments,
    /// What every C symbol begins with, one for each controller; default: the name of the tool
    #[arg(long)]
    prefix: Vec<String>,
    /// Folder for the files
    #[arg(long, default_value = "results/export")]
    out: String,
    /// Also write co-simulation units (FMI 2.0 and 3.0) of the controller and of the machine at a speed in rpm, with
    /// sources and a binary for this platform
    #[arg(long, value_name = "RPM", num_args = 0..=1, default_missing_value = "0", value_parser = parse_one_speed)]
    fmu: Option<f64>,
    /// Step of the sensor signals of the machine's unit, m, 0 for none (unless given, as `simulate`)
    #[arg(long, requires = "fmu", value_parser = parse_sensor_step)]
    sensor_step: Option<f64>,
    /// Export even if the loop is unstable or cannot be checked; the files say so
    #[arg(long)]
    force_unverified: bool,
}

/// One controller as it is exported.
struct Prepared {
    discrete: Controller,
    continuous: Option<Controller>,
    rows: ScaledRealisation,
    verification: Verification,
    anti_windup: AntiWindup,
    given: ControlledMachine,
    machine: String,
    /// What rounding does to the controller, where that is much.
    notes: Vec<String>,
}

impl Prepared {
    fn firmware<'a>(&'a self, prefix: &'a str) -> Firmware<'a> {
        Firmware {
            discrete: &self.discrete,
            continuous: self.continuous.as_ref(),
            scaled: &self.rows,
            verification: &self.verification,
            machine: &self.machine,
            tag: self.given.designed_for.as_ref(),
            prefix,
        }
    }

    /// The answer about this controller.
    fn answer(&self, prefix: &str, files: &[String], notes: &[String]) -> Value {
        let rows = &self.rows.rows;
        json!({
            "controller": self.discrete.name,
            "machine": self.given.used_machine(),
            "prefix": prefix,
            "sample_time_s": rows.sample_time_s,
            "discretised": self.continuous.is_some(),
            "form": rows.form.name(),
            "states": rows.order(),
            "multiplications_per_sample": rows.multiplications(),
            "notes": notes,
            "anti_windup": anti_windup_topic(&self.anti_windup),
            "verified": self.verification.is_proven(),
            "verification": stability_words(&self.verification),
            "files": files,
        })
    }
}

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    let (mut prepared, mut remarks) = (Vec::new(), Vec::new());
    for file in &arguments.controller {
        match prepare(arguments, file, console, &mut remarks)? {
            Some(one) => prepared.push(one),
            None => return Ok(CommandEnd::without_answer(false)),
        }
    }
    let prefixes = prefixes(&arguments.prefix, &prepared)?;
    let firmware: Vec<Firmware<'_>> =
        prepared.iter().zip(&prefixes).map(|(one, prefix)| one.firmware(prefix)).collect();
    let mut staged = ResultsFolder::new();
    let (mut answers, mut notes) = (Vec::new(), Vec::new());
    for (one, firmware) in prepared.iter().zip(&firmware) {
        let folder = if prepared.len() == 1 { String::new() } else { format!("{}/", firmware.prefix) };
        let mut written = write_all(firmware, &arguments.format)?;
        if let Some(rpm) = arguments.fmu {
            let settings = TimeSettings {
                quantum_m: arguments.sensor_step.unwrap_or(TimeSettings::default().quantum_m),
                ..TimeSettings::default()
            };
            let (units, notes) = units(one, firmware, rpm, &settings)?;
            written.files.extend(units);
            written.notes.extend(notes);
        }
        let names: Vec<String> = written.files.iter().map(|(name, _)| format!("{folder}{name}")).collect();
        for (name, (_, bytes)) in names.iter().zip(written.files) {
            staged.add(name, bytes)?;
        }
        let own_notes = one.rows.rows.notes.iter().chain(&one.notes).chain(&written.notes);
        let own_notes: Vec<String> = own_notes.cloned().collect();
        answers.push(one.answer(firmware.prefix, &names, &own_notes));
        notes.extend(own_notes);
    }
    if prepared.len() > 1 && arguments.format.contains(&Format::C) {
        for (name, bytes) in controller_table(&firmware)? {
            staged.add(&name, bytes)?;
        }
    }
    for note in &notes {
        eprintln!("note: {note}");
    }
    console.writing(|| staged.write(Path::new(&arguments.out)))?;
    let mut answer = match <[Value; 1]>::try_from(answers) {
        Ok([only]) => only,
        Err(controllers) => json!({ "controllers": controllers }),
    };
    answer["out"] = json!(arguments.out);
    let proven = prepared.iter().all(|p| p.verification.is_proven());
    let rows = prepared.iter().zip(&prefixes).map(|(one, prefix)| {
        let rows = &one.rows.rows;
        vec![prefix.clone(), rows.order().to_string(), rows.multiplications().to_string()]
    });
    let words = prepared.iter().map(|p| stability_words(&p.verification)).collect::<Vec<_>>().join("; ");
    Ok(CommandEnd::met(proven, words)
        .answer(&answer)
        .row(["controller", "states", "products a sample"])
        .rows(rows)
        .file(arguments.out.as_str()))
}

/// A step of sensor signals, in the range that a simulation takes.
pub(super) fn parse_sensor_step(text: &str) -> Result<f64, String> {
    let step_m: f64 = text.parse().map_err(|_| format!("{text} is no number"))?;
    if (0.0..=1e-3).contains(&step_m) { Ok(step_m) } else { Err("must be between 0 and 1e-3 m".to_owned()) }
}

/// The units of a controller and of its machine, and what is to be said of them.
fn units(
    one: &Prepared,
    firmware: &Firmware<'_>,
    rpm: f64,
    settings: &TimeSettings,
) -> Result<(Vec<(String, Vec<u8>)>, Vec<String>), Failure> {
    let machine = &one.given.machine;
    let c_files = write_all(firmware, &[Format::C])?.files;
    let sample_time_s = one.rows.rows.sample_time_s;
    let description = format!("{}, for {}", one.discrete.name, one.machine);
    let shaft = machine_unit(machine, rpm * TAU / 60.0, settings)?;
    let (mut files, mut notes) = (vec![], vec![]);
    for unit in [controller_unit(&description, &c_files, sample_time_s), shaft] {
        let (made, note) = archives(&unit)?;
        files.extend(made);
        notes.extend(note);
    }
    Ok((files, notes))
}

/// Loads, samples, realises and verifies one controller; nothing, with the reason on standard error, when it is
/// refused.
fn prepare(
    arguments: &Arguments,
    file: &str,
    console: &Console,
    remarks: &mut Vec<Remarks>,
) -> Result<Option<Prepared>, Failure> {
    let (given, new) = arguments.machine.with_controller(file)?;
    remarks.push(new);
    console.claim(&arguments.out, &[], &[&given.used.spindle, &given.used.tool])?;
    let machine = &given.machine;
    let SampledController { controller: discrete, law, prewarp_hz } = ready(machine, &given.controller, file)?;
    let continuous = prewarp_hz.map(|_| given.controller.clone());
    let law = &law;
    let realisation = match arguments.form {
        Form::Modal => modal_form(law)?,
        Form::SecondOrderSections => second_order_sections(law)?,
    };
    let unlimited = scale_realisation(&realisation, SignalLimits::of(machine))?;
    let (rows, anti_windup) = with_anti_windup(unlimited, machine)?;
    let notes = rounding_notes(law, &rows, arguments.force_unverified)?;
    let verification = verify_loop(machine, &rows, arguments.force_unverified)?;
    if !verification.is_proven() && !arguments.force_unverified {
        eprintln!("{}", refusal(&verification));
        if arguments.controller.len() > 1 {
            eprintln!("the controller is {file}");
        }
        return Ok(None);
    }
    Ok(Some(Prepared {
        machine: format!("{} with {}", machine.spindle.name, machine.tool.name),
        discrete,
        continuous,
        rows,
        verification,
        anti_windup,
        given,
        notes,
    }))
}

/// The prefixes asked for; else the names of the tools, with the names of the controllers where tools repeat.
fn prefixes(asked: &[String], prepared: &[Prepared]) -> Result<Vec<String>, Failure> {
    if asked.is_empty() {
        let tools: Vec<String> = prepared.iter().map(|p| c_identifier(p.given.machine.short_name())).collect();
        let repeated = |tool: &String| tools.iter().filter(|t| *t == tool).count() > 1;
        let named = |(tool, one): (&String, &Prepared)| {
            if repeated(tool) { format!("{tool}_{}", c_identifier(&one.discrete.name)) } else { tool.clone() }
        };
        return Ok(tools.iter().zip(prepared).map(named).collect());
    }
    if asked.len() != prepared.len() {
        return Err(Failure::new(format!(
            "{} --prefix for {} --controller; give one for each, in the same order, or none",
            asked.len(),
            prepared.len()
        )));
    }
    if let Some(bad) = asked.iter().find(|p| !is_prefix(p)) {
        return Err(Failure::new(format!(
            "--prefix {bad:?}: expected a C identifier that begins with a letter and is not \"muspin\""
        )));
    }
    Ok(asked.to_vec())
}

/// The controller at the spindle's sample rate; that a continuous one was sampled is said.
pub(super) fn ready(machine: &Machine, loaded: &Controller, file: &str) -> Result<SampledController, Failure> {
    let found = sample_controller(machine, loaded).map_err(|error| Failure::from(error).naming(&[file.to_owned()]))?;
    if let Some(hz) = found.prewarp_hz {
        let period_s = found.law.time.period_s;
        eprintln!("note: {file} is continuous; discretised by Tustin's rule at {period_s} s, exact at {hz:.1} Hz");
    }
    Ok(found)
}

/// Proof of stability with the rounded coefficients; none where it fails and the export is forced.
fn verify_loop(machine: &Machine, rows: &ScaledRealisation, forced: bool) -> Result<Verification, Failure> {
    let found = match proven_as_rounded(machine, rows) {
        Ok(found) => found,
        Err(_) if forced => Verification::none(),
        // The words of the cause alone: no stage of a design has failed.
        Err(PipelineError::Controller(cause)) => return Err(cause.into()),
        Err(PipelineError::Verification(cause)) => return Err(cause.into()),
        Err(other) => return Err(other.into()),
    };
    Ok(Verification { forced, ..found })
}

/// What rounding changes where that is more than the design can have meant: float32 is refused unless the export is
/// forced, Q31 is said, for a user of float32 does without.
fn rounding_notes(law: &StateSpace<Discrete>, rows: &ScaledRealisation, forced: bool) -> Result<Vec<String>, Failure> {
    let changed = changed_by_rounding(law, rows)?;
    let period_s = rows.rows.sample_time_s;
    let words = |format: &str, change: &TransferChange| {
        format!(
            "{} in {format}: rounding of the coefficients changes the response by {:.2} % at {:.4} Hz",
            rows.rows.form.name(),
            100.0 * change.relative,
            change.frequency_hz(period_s)
        )
    };
    let mut notes = Vec::new();
    if !changed.float32.is_accepted() {
        let words = words("float32", &changed.float32);
        if !forced {
            let other = match rows.rows.form {
                Form::Modal => "--form sections, where the axes are independent",
                Form::SecondOrderSections => "--form modal",
            };
            let hint = format!("use {other}, or a lower sample rate; --force-unverified exports it all the same");
            return Err(Failure::new(words).with_hint(hint));
        }
        notes.push(words);
    }
    if !changed.q31.is_accepted() {
        notes.push(format!("{}; use float32", words("Q31", &changed.q31)));
    }
    Ok(notes)
}

/// Why nothing is written: the growth rate first.
fn refusal(verification: &Verification) -> String {
    let advice = "nothing was written; check that spindle and tool are those of the design; --force-unverified \
        exports it all the same and says so in the files";
    match verification.unstable() {
        Some(bad) => format!(
            "unstable: the closed loop {} ({})\n{advice}",
            growth_words(bad.growth_rate_per_s, bad.speed_rpm),
            verification.conditions
        ),
        None => format!("{}\n{advice}", stability_words(verification)),
    }
}
