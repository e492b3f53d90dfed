//! `muspin simulate`: time response of the levitated rotor with force law, limits and clearance; figures as JSON on
//! standard output, response and orbits as CSV and SVG in the folder.

use super::Failure;
use super::choices::PictureArguments;
use super::console::{CommandEnd, Console, REPORT};
use super::controlled_machine::MachineArguments;
use super::export::{parse_sensor_step, ready};
use super::speeds::parse_one_speed;
use crate::pipeline::PipelineError;
use crate::pipeline::loop_stability::unstable_words;
use crate::pipeline::simulation::{SimulationCase, SimulationWish, simulate_controller};
use crate::predict::time::{TimeError, TimeSettings};
use crate::report::place_words::place_words;
use crate::report::time_response::simulation_report;

#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    /// Controller file (JSON)
    #[arg(long)]
    controller: String,
    /// What happens
    #[arg(long, value_enum)]
    case: SimulationCase,
    /// Speed, rpm (unbalance and contact: largest speed unless given; otherwise 0)
    #[arg(long = "speeds", alias = "speed", value_name = "SPEED", value_parser = parse_one_speed)]
    speed: Option<f64>,
    /// Balance grade in mm/s, for unbalance (0.4 unless given)
    #[arg(long)]
    grade: Option<f64>,
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
    /// Time over which the reference moves from the rest position to the centre at lift-off, s (0.1 unless given)
    #[arg(long)]
    ramp: Option<f64>,
    /// Voltage of the amplifiers' bus, V
    #[arg(long, default_value_t = TimeSettings::default().bus_voltage_v)]
    bus_voltage: f64,
    /// Step of the digitised sensor signals, m, 0 for none (unless given, that of 16 bit over ±10 V at 20 V/mm)
    #[arg(long, value_parser = parse_sensor_step)]
    sensor_step: Option<f64>,
    /// Adds the sensor noise of the spindle, with this seed
    #[arg(long)]
    noise_seed: Option<u64>,
    #[command(flatten)]
    machine: MachineArguments,
    /// Folder for response, orbits and plots
    #[arg(long, default_value = "results/simulate")]
    out: String,
    #[command(flatten)]
    pictures: PictureArguments,
}

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    let (given, remarks) = arguments.machine.with_controller(&arguments.controller)?;
    console.claim(&arguments.out, &REPORT, &[&given.used.spindle, &given.used.tool])?;
    let machine = &given.machine;
    let sampled = ready(machine, &given.controller, &arguments.controller)?;
    let settings = TimeSettings {
        noise_seed: arguments.noise_seed,
        bus_voltage_v: arguments.bus_voltage,
        quantum_m: arguments.sensor_step.unwrap_or(TimeSettings::default().quantum_m),
        ..TimeSettings::default()
    };
    let wish = arguments.wish();
    let simulated = simulate_controller(machine, &sampled, &wish, &settings).map_err(|error| match error {
        PipelineError::Time(TimeError::Setting { what, value, rule }) => {
            Failure::new(format!("--{}: {value} must be {rule}", what.replace('_', "-")))
        }
        PipelineError::Time(other) => other.into(),
        other => other.into(),
    })?;
    let (name, speed_rpm) = (wish.case.name(), simulated.scenario.speed_rpm);
    if !simulated.scenario.stable {
        eprintln!("{}", unstable_words(simulated.growth_rate_per_s, speed_rpm));
    }
    drop(remarks);
    let mut report = simulation_report(machine, &sampled.controller.name, name, &simulated)?;
    report.summary.set("machine", given.used_machine());
    console.writing(|| report.write(&arguments.out, &arguments.pictures.formats))?;
    let (found, out) = (&simulated.found, arguments.out.as_str());
    let words = place_words(machine, format!("{name} at {speed_rpm:.0} rpm: {}", found.end));
    Ok(CommandEnd::met(found.met, words).json(report.summary.to_json()).file(format!("{out}/report.html")))
}

impl Arguments {
    fn wish(&self) -> SimulationWish {
        SimulationWish {
            case: self.case,
            speed_rpm: self.speed,
            grade_m_s: self.grade.map(|grade| 1e-3 * grade),
            force_n: self.force,
            push_s: self.push,
            duration_s: self.duration,
            ramp_s: self.ramp,
        }
    }
}
