//! `muspin frf`: open-loop frequency responses u → y and F_t → x_t, or with a controller the closed-loop tool
//! compliance, as CSV; an unstable loop has none. Without a controller the tool compliance is that of the rotor on its
//! magnets, currents zero. Of a rotor without magnets: displacement over force between two places.

use super::console::{CommandEnd, Console};
use super::controlled_machine::MachineArguments;
use super::machine::{Remarks, load_rotor_said};
use super::speeds::parse_one_speed;
use super::{Failure, stdout};
use crate::input::is_rotor;
use crate::linalg::c64;
use crate::lti::response::even_in_logarithm;
use crate::pipeline::loop_stability::{growth_rate_at, unstable_words};
use crate::pipeline::response_table::ResponseTable;
use crate::report::summary::json;
use crate::spindle::{ModelDetail, Plant};
use serde_json::Value;
use std::f64::consts::TAU;
use std::io::Write;

#[derive(clap::Args, Debug)]
pub(super) struct Arguments {
    #[command(flatten)]
    machine: MachineArguments,
    /// Speed, rpm
    #[arg(long = "speeds", alias = "speed", value_name = "SPEED", default_value = "0", value_parser = parse_one_speed)]
    speed: f64,
    /// First frequency, Hz
    #[arg(long, default_value_t = 1.0)]
    from: f64,
    /// Last frequency, Hz
    #[arg(long, default_value_t = 4000.0)]
    to: f64,
    /// Number of frequencies, spaced evenly in the logarithm, ends included
    #[arg(long, default_value_t = 480)]
    points: usize,
    /// The reduced model of the design instead of the full FE model
    #[arg(long)]
    design_model: bool,
    /// Also the open-loop paths current → tool and force at the tool → signal, as further columns
    #[arg(long)]
    tool_paths: bool,
    /// Controller file: the t_ columns become the closed-loop tool compliance
    #[arg(long)]
    controller: Option<String>,
    /// Place where the displacement is read, m, of a rotor without magnets; default: the tool plane
    #[arg(long)]
    response_m: Option<f64>,
    /// Place where the force acts, m, of a rotor without magnets; default: the tool plane
    #[arg(long)]
    force_m: Option<f64>,
}

/// Most frequencies of one call: minutes of computation, and a file of half a gigabyte.
const MOST_POINTS: usize = 1_000_000;

pub(super) fn run(arguments: &Arguments, console: &Console) -> Result<CommandEnd, Failure> {
    let frequencies = frequencies_hz(arguments)?;
    if arguments.machine.spindle.as_deref().is_some_and(is_rotor) {
        return of_rotor(arguments, &frequencies, console);
    }
    if arguments.response_m.is_some() || arguments.force_m.is_some() {
        return Err(Failure::new("--response-m, --force-m: the spindle has magnets").with_hint(
            "places are chosen of a rotor without magnets: a file without planes, bearings and electronics",
        ));
    }
    let (machine, controller, remarks) = match &arguments.controller {
        None => (arguments.machine.alone()?, None, Remarks::default()),
        Some(file) => {
            let (found, remarks) = arguments.machine.with_controller(file)?;
            (found.machine, Some(found.controller), remarks)
        }
    };
    if let Some(controller) = &controller {
        let growth = growth_rate_at(&machine, controller, arguments.speed)?;
        if growth >= 0.0 {
            eprintln!("{}", unstable_words(growth, arguments.speed));
            return Ok(CommandEnd::without_answer(false));
        }
    }
    drop(remarks);
    let speed = arguments.speed * TAU / 60.0;
    let plant = if arguments.design_model {
        Plant::design_model(&machine, speed)?
    } else {
        Plant::new(&machine, speed, ModelDetail::Full)?
    };
    let responses = ResponseTable { plant: &plant, controller: controller.as_ref(), tool_paths: arguments.tool_paths };
    let header = responses.header();
    let row = |hz: &f64| responses.row(*hz);
    end_table(&header, frequencies.iter().map(row), console)
}

/// Displacement over force of a rotor without magnets.
fn of_rotor(arguments: &Arguments, frequencies: &[f64], console: &Console) -> Result<CommandEnd, Failure> {
    if arguments.controller.is_some() || arguments.design_model || arguments.tool_paths {
        return Err(Failure::new("--controller, --design-model, --tool-paths: the rotor has no magnets")
            .with_hint("leave them out, or take a spindle file with planes, bearings and electronics"));
    }
    let files = &arguments.machine;
    let rotor = load_rotor_said(files.spindle.as_deref().unwrap_or_default(), files.tool.as_deref())?;
    let places = [arguments.response_m, arguments.force_m].map(|z| z.unwrap_or(rotor.tool_plane_m()));
    let responses = rotor.receptance(arguments.speed * TAU / 60.0, places, frequencies)?;
    let header = ["xx", "xy", "yx", "yy"].map(|entry| [format!("h_{entry}_re"), format!("h_{entry}_im")]);
    let header = [vec!["frequency_hz".to_owned()], header.concat()].concat();
    let row = |(hz, h): (&f64, &[[c64; 2]; 2])| {
        let parts = h.iter().flatten().flat_map(|value| [value.re, value.im]);
        std::iter::once(*hz).chain(parts).collect::<Vec<f64>>()
    };
    end_table(&header, frequencies.iter().zip(&responses).map(row), console)
}

/// Ends with a table: as CSV line by line, for a million lines need no memory, else whole.
fn end_table(
    header: &[String],
    mut rows: impl Iterator<Item = Vec<f64>>,
    console: &Console,
) -> Result<CommandEnd, Failure> {
    if console.writes_data() {
        stdout::data(|out| {
            writeln!(out, "{}", header.join(","))?;
            rows.try_for_each(|row| csv_line(out, &row))
        })?;
        return Ok(CommandEnd::without_answer(true));
    }
    let table: Vec<Vec<f64>> = rows.collect();
    Ok(show_table(header, &table).data(String::new(), columns(header, &table)))
}

fn frequencies_hz(arguments: &Arguments) -> Result<Vec<f64>, Failure> {
    let (from, to, points) = (arguments.from, arguments.to, arguments.points);
    if !(from.is_finite() && from > 0.0 && to.is_finite() && to >= from) {
        return Err(Failure::new(format!("--from {from} --to {to}: no frequency range"))
            .with_hint("frequencies are in Hz, 0 < from ≤ to"));
    }
    if points == 0 {
        return Err(Failure::new("--points 0: no frequency").with_hint("give 1 or more"));
    }
    if points > MOST_POINTS {
        return Err(Failure::new(format!("--points {points}: at most {MOST_POINTS} frequencies are computed"))
            .with_hint("a thousand a decade resolve every peak; narrow the range with --from and --to"));
    }
    Ok(even_in_logarithm(from, to, points).collect())
}

fn csv_line(out: &mut dyn Write, row: &[f64]) -> std::io::Result<()> {
    let mut cells = row.iter();
    if let Some(hz) = cells.next() {
        write!(out, "{hz}")?;
    }
    cells.try_for_each(|x| write!(out, ",{x:e}"))?;
    writeln!(out)
}

/// One list a column.
fn columns(header: &[String], table: &[Vec<f64>]) -> Value {
    let column = |k: usize| table.iter().map(|row| row[k]).collect::<Vec<f64>>();
    header.iter().enumerate().map(|(k, name)| (name.clone(), json(column(k)))).collect()
}

/// The largest magnitude of the diagonal entries and where it is.
fn show_table(header: &[String], table: &[Vec<f64>]) -> CommandEnd {
    let mut shown = CommandEnd::done(format!("{} lines", table.len())).row(["", "largest magnitude", "at Hz"]);
    for name in ["g_11", "g_22", "g_33", "g_44", "t_xx", "t_yy", "h_xx", "h_yy"] {
        let re = format!("{name}_re");
        let Some(k) = header.iter().position(|h| *h == re) else {
            continue;
        };
        let size = |row: &&Vec<f64>| row[k].hypot(row[k + 1]);
        if let Some(peak) = table.iter().max_by(|a, b| size(a).total_cmp(&size(b))) {
            let unit = if name.starts_with('g') { "m/A" } else { "m/N" };
            shown = shown.row([name.to_owned(), format!("{:.3e} {unit}", size(&peak)), format!("{:.1}", peak[0])]);
        }
    }
    shown.next("the same command with > frf.csv writes the table, --json prints its columns")
}
