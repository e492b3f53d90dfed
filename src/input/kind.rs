//! What a file is, from its keys.

use super::error::InputError;
use super::shipped::{self, FREQUENCIES, SPINDLES, Shipped, TOOLS, WEIGHTS};
use std::path::Path;

/// Kinds of input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// Spindle YAML.
    Spindle,
    /// Tool YAML.
    Tool,
    /// Weights YAML.
    Weights,
    /// Controller JSON.
    Controller,
    /// A measurement folder, or a YAML of frequencies.
    Measurement,
}

/// Top-level keys that only one kind has.
const TELLING: [(&str, FileKind); 8] = [
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
    /// Its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Spindle => "spindle",
            Self::Tool => "tool",
            Self::Weights => "weights",
            Self::Controller => "controller",
            Self::Measurement => "measurement",
        }
    }

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
            if !path.is_file() && list.iter().any(|s| s.name == source) {
                return Ok(kind);
            }
        }
        let text = shipped::text(source, "input", &[])?;
        if path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("json"))
        {
            return Ok(Self::Controller);
        }
        let value: serde_yaml::Value =
            serde_yaml::from_str(&text).map_err(|e| InputError::yaml(source, &e))?;
        let told = TELLING.iter().find(|(key, _)| value.get(key).is_some());
        told.map(|(_, kind)| *kind).ok_or_else(|| {
            InputError::new(source, "is not a file that muspin knows").with_hint(
                "a spindle has `rotor:`, a tool `tool_plane_m:`, weights `mode_uncertainty:`, frequencies \
                 `resonances_hz:`; a controller is JSON, a measurement a folder",
            )
        })
    }
}
