//! What the table says of a kind of effect.

use super::entry::{Entry, Parameter};
use super::kind::EffectKind;
use super::location::LocationKind;
use super::table::TABLE;

impl EffectKind {
    /// Whether it sits in the tool or between tool and spindle.
    pub(crate) fn needs_tool(self) -> bool {
        matches!(self, Self::ToolJoint | Self::ToolMass)
    }

    /// Every kind, in the order of the table.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.iter().map(|entry| entry.kind)
    }

    /// Its entry of the table.
    pub fn entry(self) -> &'static Entry {
        &TABLE[self as usize]
    }

    /// The name in files.
    pub fn name(self) -> &'static str {
        self.entry().name
    }

    /// The kind of that name. Eddy currents in solid iron, ki/(1 + √(s/ω)), have two names.
    pub fn from_name(name: &str) -> Option<Self> {
        let name = if name == "solid_core" { "eddy_currents" } else { name };
        Self::all().find(|kind| kind.name() == name)
    }

    /// What location it needs.
    pub fn location(self) -> LocationKind {
        self.entry().location
    }

    /// Its numbers, in the order of the values of an effect.
    pub fn parameters(self) -> &'static [Parameter] {
        self.entry().parameters
    }
}
