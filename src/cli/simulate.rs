//! `muspin simulate`: time response of the levitated rotor with force law, limits and clearance; figures as JSON on
//! standard output, response and orbits as CSV and SVG in the folder.

use super::console::{CommandEnd, Console};
use super::controlled_machine::MachineArguments;
use super::export::ready;
use super::output::{REPORT, claim};
use super::speeds::parse_one_speed;
use super::{Failure, Outcome};
use crate::controller::ControlLaw;
use crate::controller::anti_windup::firmware_rows;
use crate::controller::arithmetic::float32;
use crate::controller::scaling::SignalLimits;
use crate::pipeline::loop_stability::{growth_rate_at, unstable_words};
use crate::pipeline::simulation::{Goal, SimulationScenario, simulate_scenario};
use crate::predict::recovery::touching_force_n;
use crate::predict::time::{TimeError, TimeSettings};
use crate::predict::time_cases::{PUSH_S, StandardCase};
use crate::report::simulation::SimulationSummary;
use crate::report::summary::finite;
use crate::report::time_response::add_simulation;
use crate::report::whole::Report;
use crate::spindle::Machine;

/// Arguments of `muspin simulate`.
#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Controller file (JSON)
    #[arg(long)]
    controller: String,
    /// What happens
    #[arg(long, value_enum)]
    case: CaseArgument,
    /// Speed, rpm (unbalance and contact: largest speed unless given; otherwise 0)
    #[arg(long = "speeds", alias = "speed", value_name = "SPEED", value_parser = parse_one_speed)]
    speed: Option<f64>,
    /// Balance grade in mm/s, for unbalance
    #[arg(long, default_value_t = 0.4)]
    grade: f64,
    /// Force at the tool, N (impulse 50, step 40 unless given; contact: what no controller can hold within the
    /// clearance)
    #[arg(long)]
    force: Option<f64>,
    /// Length of the half-sine push, s, for impulse and contact (0.0005 unless given)
    #[arg(long)]
    push: Option<f64>,
    /// Duration, s
    #[arg(long)]
    duration: Option<f64>,
    /// Time over which the reference moves from the rest position to the centre at lift-off, s
    #[arg(long, default_value_t = 0.1)]
    ramp: f64,
    /// Voltage of the amplifiers' bus, V
    #[arg(long, default_value_t = 300.0)]
    bus_voltage: f64,
    /// Adds the sensor noise of the spindle, with this seed
    #[arg(long)]
    noise_seed: Option<u64>,
    #[command(flatten)]
    machine: MachineArguments,
    /// Folder for response, orbits and plots
    #[arg(long, default_value = "results/simulate")]
    out: String,
}

#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
enum CaseArgument {
    /// Half-sine push at the tool
    Impulse,
    /// Constant force at the tool
    Step,
    /// Unbalance of a balance grade at speed
    Unbalance,
    /// Lift-off from the backup bearings
    LiftOff,
    /// Half-sine push at the tool that throws the rotor into its backup bearings
    Contact,
}

impl From<TimeError> for Failure {
    fn from(error: TimeError) -> Self {
        match error {
            TimeError::Plant(e) => e.into(),
            other => Self::new(other.to_string()),
        }
    }
}

/// Longest simulation, s: every sample is kept in memory and written.
const LONGEST_S: f64 = 20.0;

/// Runs the command.
pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<Outcome, Failure> {
    let (given, remarks) = arguments.machine.with_controller(&arguments.controller)?;
    let read = [&arguments.controller, &given.used.spindle, &given.used.tool];
    claim(&arguments.out, &REPORT, read.map(String::as_str))?;
    let machine = &given.machine;
    let (discrete, _) = ready(machine, &given.controller, &arguments.controller)?;
    let ControlLaw::Discrete(law) = &discrete.law else {
        return Err(Failure::new("the controller could not be sampled"));
    };
    let (rows, anti_windup) = firmware_rows(law, machine)?;
    let program = float32(&rows)?;
    let (name, mut scenario) = scenario(arguments, machine)?;
    let speed_rpm = scenario.speed_rpm;
    let growth = growth_rate_at(machine, &discrete, speed_rpm)?;
    scenario.stable = growth < 0.0;
    if !scenario.stable {
        eprintln!("{}", unstable_words(growth, speed_rpm));
    }
    drop(remarks);
    let settings = TimeSettings {
        noise_seed: arguments.noise_seed,
        bus_voltage_v: arguments.bus_voltage,
        reference_ramp_s: match scenario.case {
            StandardCase::LiftOff => arguments.ramp,
            _ => 0.0,
        },
        ..TimeSettings::default()
    };
    let found = simulate_scenario(machine, &program, &scenario, &settings)?;
    let mut report = Report::of("simulate", machine);
    let summary = &mut report.summary;
    summary.set("controller", discrete.name.as_str());
    summary.set("case", name);
    summary.set("speed_rpm", finite(speed_rpm));
    summary.set("duration_s", finite(scenario.duration_s));
    given.add_to(summary);
    summary.set("stability.stable", found.stable);
    summary.set("stability.growth_rate_per_s", finite(growth));
    if let StandardCase::Impulse { force_n, .. } | StandardCase::Step { force_n } = scenario.case {
        summary.set("force_n", finite(force_n));
    }
    if let StandardCase::Impulse { length_s, .. } = scenario.case {
        summary.set("push_s", finite(length_s));
    }
    let figures = SimulationSummary::of(machine, &found, &anti_windup);
    summary.set("simulation", figures);
    add_simulation(&mut report, machine, name, speed_rpm, &found)?;
    console.writing(|| report.write(&arguments.out))?;
    let out = arguments.out.as_str();
    console.json(&report.summary.to_json(), || {
        CommandEnd::met(found.met, format!("{name} at {speed_rpm:.0} rpm: {}", found.end))
            .file(format!("{out}/report.html"))
    })?;
    Ok(if found.met { Outcome::Done } else { Outcome::TargetMissed })
}

/// Name of the case, and what is simulated; whether the loop is stable is not known yet.
fn scenario(arguments: &Arguments, machine: &Machine) -> Result<(&'static str, SimulationScenario), Failure> {
    let positive = |name: &str, value: Option<f64>| match value {
        Some(v) if !(v.is_finite() && v > 0.0) => Err(Failure::new(format!("--{name}: {v} must be a positive number"))),
        other => Ok(other),
    };
    let force = positive("force", arguments.force)?;
    let duration = positive("duration", arguments.duration)?;
    if let Some(seconds) = duration.filter(|d| *d > LONGEST_S) {
        return Err(Failure::new(format!("--duration: {seconds} s; at most {LONGEST_S} s are simulated"))
            .with_hint("lift-off, the slowest event, ends within a second"));
    }
    let period_s = machine.spindle.electronics.sample_period_s();
    let length_s = match arguments.push {
        Some(given) if !(given >= period_s && given.is_finite()) => {
            return Err(Failure::new(format!(
                "--push: {given} s must be a time of at least one sampling period, {period_s} s"
            )));
        }
        given => given.unwrap_or(PUSH_S),
    };
    let grade = positive("grade", Some(arguments.grade))?.unwrap_or(0.4);
    let (case, name, length) = match arguments.case {
        CaseArgument::Impulse => (StandardCase::Impulse { force_n: force.unwrap_or(50.0), length_s }, "impulse", 0.1),
        CaseArgument::Contact => {
            let limit = SignalLimits::of(machine).output_a;
            let force_n = match force {
                Some(given) => given,
                None => touching_force_n(machine, limit, length_s)?,
            };
            (StandardCase::Impulse { force_n, length_s }, "contact", 0.2)
        }
        CaseArgument::Step => (StandardCase::Step { force_n: force.unwrap_or(40.0) }, "step", 0.3),
        CaseArgument::Unbalance => (StandardCase::Unbalance { grade_m_s: 1e-3 * grade }, "unbalance", 0.2),
        CaseArgument::LiftOff => (StandardCase::LiftOff, "lift-off", 0.5),
    };
    let usual = match arguments.case {
        CaseArgument::Unbalance | CaseArgument::Contact => machine.spindle.max_rpm,
        _ => 0.0,
    };
    let speed = arguments.speed.unwrap_or(usual);
    let goal = match arguments.case {
        CaseArgument::Impulse | CaseArgument::Contact => Goal::Recovers,
        CaseArgument::Step | CaseArgument::Unbalance => Goal::StaysClear,
        CaseArgument::LiftOff => Goal::LiftsOff,
    };
    let scenario =
        SimulationScenario { case, goal, speed_rpm: speed, duration_s: duration.unwrap_or(length), stable: true };
    Ok((name, scenario))
}
