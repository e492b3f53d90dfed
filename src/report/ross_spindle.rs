//! The spindle file of a rotor that came from ROSS: the shaft complete, and what ROSS does not say as commented keys
//! with `to be given`, so that `muspin check` names them until they are there.

use crate::input::ross::{RossBearing, RossRotor};
use crate::input::write::{number, rotor_lines, text};
use crate::rotor::{Disc, Section};

/// A spindle file with gaps.
#[derive(Clone, Debug)]
pub(crate) struct SpindleDraft {
    pub(crate) text: String,
    /// Keys that are to be given, as paths.
    pub(crate) to_be_given: Vec<String>,
}

/// Gathers lines and gaps.
#[derive(Default)]
struct Draft {
    lines: Vec<String>,
    gaps: Vec<String>,
}

impl Draft {
    fn line(&mut self, line: impl Into<String>) {
        self.lines.push(line.into());
    }

    /// A key whose value stands in the file, or a gap with what belongs there.
    fn key(&mut self, path: &str, value: Option<f64>, meaning: &str) {
        let (indent, key) = place_in_file(path);
        match value {
            Some(value) => self.line(format!("{indent}{key}: {}   # {meaning}", number(value))),
            None => {
                self.line(format!("{indent}# {key}:   # to be given: {meaning}"));
                self.gaps.push(path.to_owned());
            }
        }
    }

    /// The head of a block, in a comment while nothing in it is known.
    fn head(&mut self, path: &str, known: bool) {
        let (indent, key) = place_in_file(path);
        let mark = if known { "" } else { "# " };
        self.line(format!("{indent}{mark}{key}:"));
    }
}

/// Indentation and last word of a path.
fn place_in_file(path: &str) -> (String, &str) {
    ("  ".repeat(path.matches('.').count()), path.rsplit('.').next().unwrap_or(path))
}

/// The draft for the shaft `sections` with `discs` from the nose face on; `rotor` has bearings and speed, its positions
/// less `nose_m` are those of the spindle.
pub(crate) fn spindle_draft(
    name: &str,
    sections: &[Section],
    discs: &[Disc],
    rotor: &RossRotor,
    nose_m: f64,
) -> SpindleDraft {
    let mut draft = Draft::default();
    draft.line("# The rotor is that of a ROSS file. Where a line says `to be given`, remove the # before the key");
    draft.line("# (and before the heads above it) and write the value behind it; `muspin check` names what is left.");
    draft.line(format!("name: {}", text(name)));
    draft.lines.extend(rotor_lines(sections, discs));
    let ratios = "a list, damping ratios of the free-free bending modes; [0.004] is usual for a solid steel shaft";
    draft.key("rotor.damping_ratio", None, ratios);
    draft.key("rotor.flexible_modes", None, "bending modes that the design model keeps, usually 3");
    let bearings = rotor.magnet_pair().map_or([None, None], |pair| pair.map(Some));
    planes(&mut draft, bearings, nose_m);
    magnets(&mut draft, bearings);
    draft.head("electronics", false);
    for (key, meaning) in [
        ("amplifier_bandwidth_hz", "Hz, -3 dB of the current loop"),
        ("sensor_bandwidth_hz", "Hz, -3 dB of the position sensors"),
        ("sensor_noise_m", "m, rms of one axis"),
        ("delay_s", "s, from sampling to the commanded current, half a sample for the hold included"),
        ("sample_rate_hz", "Hz, of the controller"),
    ] {
        draft.key(&format!("electronics.{key}"), None, meaning);
    }
    let rpm = rotor.speed_rad_s.map(|w| w * 60.0 / std::f64::consts::TAU);
    draft.head("speed", rpm.is_some());
    draft.key("speed.max_rpm", rpm, "1/min, top speed");
    draft.key("backup_clearance_m", None, "m, radial clearance of the backup bearings");
    SpindleDraft { text: draft.lines.join("\n") + "\n", to_be_given: draft.gaps }
}

fn planes(draft: &mut Draft, [front, rear]: [Option<&RossBearing>; 2], nose_m: f64) {
    let at = |b: Option<&RossBearing>| b.map(|b| b.position_m - nose_m);
    let place = |b: Option<&RossBearing>, words: &str| match b {
        Some(b) => format!("m, {}", b.tag),
        None => format!("m from the nose face, centre of the {words} magnetic bearing"),
    };
    draft.head("planes", front.is_some());
    draft.key("planes.front_sensor_m", None, "m from the nose face, plane of the front sensors");
    draft.key("planes.front_actuator_m", at(front), &place(front, "front"));
    draft.key("planes.rear_actuator_m", at(rear), &place(rear, "rear"));
    draft.key("planes.rear_sensor_m", None, "m from the nose face, plane of the rear sensors");
}

fn magnets(draft: &mut Draft, bearings: [Option<&RossBearing>; 2]) {
    let magnets = bearings.map(|b| b.and_then(|b| b.magnet));
    draft.head("bearings", magnets.iter().any(Option::is_some));
    for (side, magnet) in ["front", "rear"].iter().zip(magnets) {
        draft.head(&format!("bearings.{side}"), magnet.is_some());
        let values = [
            ("ki_n_per_a", magnet.map(|m| m.ki_n_per_a), "N/A, force per control current"),
            ("ks_n_per_m", magnet.map(|m| m.ks_n_per_m), "N/m, negative stiffness as a positive number"),
            ("max_force_n", None, "N, largest force of an axis"),
            ("bias_current_a", magnet.map(|m| m.bias_current_a), "A, bias current"),
            ("max_current_a", None, "A, largest coil current"),
            ("gap_m", magnet.map(|m| m.gap_m), "m, air gap"),
        ];
        for (key, value, meaning) in values {
            draft.key(&format!("bearings.{side}.{key}"), value, meaning);
        }
    }
}
