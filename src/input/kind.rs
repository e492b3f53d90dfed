//! What a file is, from its keys.

use super::consistency;
use super::error::InputError;
use super::file;
use super::keys;
use super::plausible::{self, Warning};
use super::rotor_kind::is_rotor_tree;
use super::shipped::{self, FREQUENCIES, SPINDLES, Shipped, TOOLS, WEIGHTS};
use super::spindle::read_spindle;
use super::table::first_line;
use super::weights::read_weights;
use super::yaml;
use std::path::Path;

named! {
    /// Kinds of input.
    pub enum FileKind {
        Spindle = "spindle",
        Rotor = "rotor",
        Tool = "tool",
        Weights = "weights",
        Controller = "controller",
        Measurement = "measurement",
        Sweep = "sweep",
        Hammer = "hammer record",
        ModeShapes = "mode shapes",
        Universal = "universal file",
        Mat = "MATLAB file",
        Pid = "PID",
    }
}

/// Top-level keys that only one kind has.
const TELLING: [(&str, FileKind); 9] = [
    ("records", FileKind::Measurement),
    ("rotor", FileKind::Spindle),
    ("bearings", FileKind::Spindle),
    ("tool_plane_m", FileKind::Tool),
    ("elements", FileKind::Tool),
    ("mode_uncertainty", FileKind::Weights),
    ("front", FileKind::Weights),
    ("resonances_hz", FileKind::Measurement),
    ("antiresonances_hz", FileKind::Measurement),
];

impl FileKind {
    /// The kind of a path or shipped name.
    ///
    /// # Errors
    /// [`InputError`] when it cannot be read, is no YAML or JSON, or has none of the keys that tell.
    pub fn of(source: &str) -> Result<Self, InputError> {
        let path = Path::new(source);
        if path.is_dir() {
            return Ok(Self::Measurement);
        }
        let shipped: [(&[Shipped], Self); 4] = [
            (SPINDLES, Self::Spindle),
            (TOOLS, Self::Tool),
            (WEIGHTS, Self::Weights),
            (FREQUENCIES, Self::Measurement),
        ];
        for (list, kind) in shipped {
            if !path.exists() && list.iter().any(|s| s.name == source) {
                return Ok(kind);
            }
        }
        let extension = path.extension().and_then(|e| e.to_str());
        match extension.map(str::to_ascii_lowercase).as_deref() {
            Some("json") => return Ok(Self::Controller),
            Some("csv") => return Self::of_table(source),
            Some("uff" | "unv") => return Ok(Self::Universal),
            Some("mat") => return Ok(Self::Mat),
            _ => {}
        }
        let text = shipped::text(source, "input", &[])?;
        let value = yaml::value(source, &text)?;
        let is_channel = |name: &&str| value.get(*name).is_some_and(|own| own.get("damping_a_s_per_m").is_some());
        if ["front", "rear", "translation", "tilt"].iter().any(is_channel) {
            return Ok(Self::Pid);
        }
        if is_rotor_tree(&value) {
            return Ok(Self::Rotor);
        }
        let told = TELLING.iter().find(|(key, _)| value.get(key).is_some());
        told.map(|(_, kind)| *kind).ok_or_else(|| {
            InputError::new(source, "is not a file that muspin knows").with_hint(
                "a spindle has `rotor:`, a tool `tool_plane_m:`, weights `mode_uncertainty:`, frequencies \
                 `resonances_hz:`, a PID `damping_a_s_per_m:` in its channels; a controller is JSON, a record CSV or a \
                 universal file, a measurement a folder",
            )
        })
    }

    /// The kind of a table, from its header.
    fn of_table(source: &str) -> Result<Self, InputError> {
        let unread: file::Watch<'_> = &|_| ();
        let reader = file::open_rows(Path::new(source), unread).map_err(|e| e.of(source))?;
        let header = first_line(source, reader)?;
        let known = [("experiment", Self::Sweep), ("h_re", Self::Hammer), ("amplitude", Self::ModeShapes)];
        let told = known.iter().find(|(column, _)| header.contains(column));
        told.map(|(_, kind)| *kind).ok_or_else(|| {
            InputError::new(source, "is no table that muspin knows: no column experiment, h_re or amplitude").with_hint(
                "the first line of a record names its columns, for example \
                    frequency_hz,h_re,h_im,coherence,averages",
            )
        })
    }

    /// What is odd about the values of a file that was read without an error.
    ///
    /// # Errors
    /// [`InputError`] when the file cannot be read any more.
    pub fn warnings(self, source: &str) -> Result<Vec<Warning>, InputError> {
        let (groups, shipped): (_, &[Shipped]) = match self {
            Self::Spindle => (keys::SPINDLE, SPINDLES),
            Self::Rotor => (keys::ROTOR, &[]),
            Self::Tool => (keys::TOOL, TOOLS),
            Self::Weights => (keys::WEIGHTS, WEIGHTS),
            Self::Pid => (keys::PID, &[]),
            Self::Measurement if !Path::new(source).is_dir() => (keys::FREQUENCIES, FREQUENCIES),
            _ => return Ok(vec![]),
        };
        let text = shipped::text(source, self.name(), shipped)?;
        let value = yaml::value(source, &text)?;
        let mut found = plausible::warnings(source, groups, &value);
        found.extend(match self {
            Self::Spindle => consistency::of_spindle(source, &read_spindle(source, &text)?),
            Self::Tool => consistency::of_tool(source, &value),
            Self::Weights => consistency::of_weights(source, &read_weights(source, &text)?),
            _ => vec![],
        });
        Ok(found)
    }
}
