//! What most programs on this crate import: `use muspin::prelude::*;`.

pub use crate::augment::{Block, GeneralizedPlant};
pub use crate::controller::{ControlLaw, Controller};
pub use crate::diagnose::{Diagnosis, Verdict, diagnose};
pub use crate::input::load_machine;
pub use crate::linalg::{Mat, c64};
pub use crate::lti::{Continuous, Discrete, Response, StateSpace};
pub use crate::robust::{dk, hinf};
pub use crate::spindle::{Effect, EffectKind, Location, Machine, ModelDetail, Plant};
pub use crate::update::{Targets, UpdateSettings};
