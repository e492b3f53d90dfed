//! The thrust axis of a design: its topic of the summary, its picture and the files of its controller.

use super::pid_summary::numbers_topic;
use super::plot::Role;
use super::plot::figure::{Axis, Figure, Panel, Series};
use super::plot::loops::add_zone_limits;
use crate::controller::MachineTag;
use crate::export::c::c_identifier;
use crate::export::error::FirmwareError;
use crate::export::firmware::{Firmware, Format, write_all};
use crate::pid::settings::TuneSettings;
use crate::pipeline::thrust::ThrustDesign;
use crate::predict::sensitivity::Zone;
use crate::predict::stiffness::stiffness_words;
use crate::spindle::Machine;
use serde_json::{Value, json};

/// The files of the controller of a thrust axis in some formats; `tag` names the machine's files beside it.
pub(super) fn thrust_files(
    machine: &Machine,
    found: &ThrustDesign,
    tag: &MachineTag,
    formats: &[Format],
) -> Result<Vec<(String, Vec<u8>)>, FirmwareError> {
    let firmware = Firmware {
        discrete: &found.pid.controller,
        continuous: None,
        scaled: &found.realisation,
        verification: &found.verification,
        machine: &format!("{}, thrust axis", machine.spindle.name),
        tag: Some(tag),
        prefix: &format!("{}_thrust", c_identifier(machine.short_name())),
    };
    Ok(write_all(&firmware, formats)?.files)
}

/// The search holds the noise on fewer lines than the figures are of.
const NOISE_TOLERANCE: f64 = 0.01;

/// A thrust axis in a sentence, and what it misses.
pub(crate) fn thrust_words(found: &ThrustDesign) -> String {
    let pid = &found.pid;
    let zone = Zone::of_peak(pid.sensitivity_peak);
    let mut words = format!(
        "Thrust axis: PID, smallest stiffness {} at {:.0} Hz, zone {}.",
        stiffness_words(pid.minimum.0),
        pid.minimum.1,
        zone.letter()
    );
    if zone != Zone::A {
        words += " None within zone A was found.";
    }
    let most_a = TuneSettings::quick().noise_current_a;
    if pid.noise_current_a > most_a * (1.0 + NOISE_TOLERANCE) {
        words +=
            &format!(" Sensor noise asks for {:.3} A, more than the {most_a} A of a tuned PID.", pid.noise_current_a);
    }
    words
}

/// `thrust` of the summary.
pub(super) fn thrust_topic(found: &ThrustDesign) -> Value {
    let pid = &found.pid;
    let mut numbers = numbers_topic(&pid.parameters);
    if let Some(sections) = numbers["sections"].as_array_mut() {
        sections.truncate(1);
    }
    json!({
        "mass_kg": found.axis.mass_kg,
        "minimum_n_per_m": pid.minimum.0,
        "minimum_frequency_hz": pid.minimum.1,
        "sensitivity_peak_db": 20.0 * pid.sensitivity_peak.log10(),
        "zone": Zone::of_peak(pid.sensitivity_peak).letter(),
        "noise_current_a": pid.noise_current_a,
        "slowest_decay_per_s": found.verification.worst_growth_rate_per_s().map(|rate| -rate),
        "proven_stable": found.verification.is_proven(),
        "numbers": numbers,
    })
}

/// Stiffness and sensitivity over frequency.
pub(super) fn thrust_figure(found: &ThrustDesign) -> Figure {
    let lines = || found.pid.lines.iter();
    let stiffness = lines().map(|line| (line.frequency_hz, 1e-6 * line.stiffness_n_per_m));
    let sensitivity = lines().map(|line| (line.frequency_hz, 20.0 * line.sensitivity.log10()));
    let frequency = || Axis::log("Frequency", "Hz");
    let mut upper = Panel::new("", frequency(), Axis::log("Dynamic stiffness", "N/µm"));
    upper.series.push(Series::of_points("thrust axis", stiffness, Role::Pid.look()));
    let mut lower = Panel::new("", frequency(), Axis::linear("|S|", "dB").with_range(-40.0, 20.0));
    lower.series.push(Series::of_points("thrust axis", sensitivity, Role::Pid.look()));
    add_zone_limits(&mut lower);
    let words = "Force over displacement of the shaft along its axis, and sensitivity of the loop, over frequency.";
    Figure::stacked("Thrust axis", words, [upper, lower])
}
