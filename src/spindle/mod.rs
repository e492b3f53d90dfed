//! The machine round the shaft: bearings, electronics, effects, tool, named ports, the open-loop plant at a speed.

pub mod backup;
pub(crate) mod band;
pub(crate) mod correction;
pub mod effective;
pub mod effects;
pub mod halved;
pub(crate) mod machine;
pub(crate) mod mechanics;
pub mod mesh_quality;
pub(crate) mod model_detail;
pub(crate) mod open_receptance;
pub mod plant;
pub mod plant_loop;
pub(crate) mod realise;
pub mod response;
pub mod rotor_on_supports;
mod rule;
mod rules;
mod supports;
pub(crate) mod thrust;
mod thrust_bearing;
pub(crate) mod whirl_form;
mod whirl_orbits;

pub use backup::{BackupBearings, BackupContact};
pub use effective::{Amplifier, AxisElectronics, Effective, EffectiveBearing, Housing};
pub use effects::{Bearings, Effect, EffectKind, Location, Plane};
pub use machine::{Bearing, Electronics, Machine, Planes, Side, Spindle, Tool};
pub use model_detail::ModelDetail;
pub use plant::Plant;
pub use plant_loop::PlantLoop;
pub use rotor_on_supports::RotorOnSupports;
pub use thrust::ThrustAxis;
pub use thrust_bearing::ThrustBearing;
pub use whirl_orbits::WhirlOrbits;

use crate::linalg::NumericError;
use crate::rotor::RotorError;
use thiserror::Error;

/// What can be wrong with a machine or its plant.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SpindleError {
    /// A value breaks a rule.
    #[error("{path}: {value} {rule}")]
    Value {
        /// Key path in the spindle file.
        path: String,
        /// The value.
        value: f64,
        /// The rule it breaks, as the end of a sentence.
        rule: String,
    },
    /// A name that stands for nothing.
    #[error("{path}: {name:?} {rule}")]
    Name {
        /// Key path in the spindle file.
        path: String,
        /// The name.
        name: String,
        /// The rule it breaks.
        rule: String,
    },
    /// The rotor of the spindle.
    #[error("rotor.{0}")]
    Rotor(RotorError),
    /// The tool.
    #[error("tool {0}")]
    Tool(RotorError),
    /// A computation with the assembled shaft.
    #[error(transparent)]
    Shaft(RotorError),
    /// A matrix computation failed.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}
