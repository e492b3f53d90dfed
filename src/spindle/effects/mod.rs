//! Effects that a spindle file may add to the nominal model.
//!
//! [`table`] describes every effect in one entry: name, location, parameters, how a fit moves them, sentence and
//! advice. `action` applies an effect to the machine. Files, plant, diagnosis and report read the table.

pub(crate) mod action;
pub mod coordinate;
pub(crate) mod effect;
pub mod entry;
pub(crate) mod kind;
mod lags;
pub(crate) mod location;
mod lookup;
pub mod scale;
pub mod table;

pub use effect::Effect;
pub use kind::EffectKind;
pub use location::{AXIS_NAMES, Bearings, Location, LocationKind, Plane};
