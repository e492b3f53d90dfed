//! What was measured: sweeps under levitation, hammer tests at the tool with the controller that levitated.

use crate::identify::{HammerFrf, SweepRecord};
use crate::lti::HeldResponse;

/// A control axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// x.
    X,
    /// y, 90° ahead.
    Y,
}

/// A hammer test at the tool plane.
pub struct HammerTest<'a> {
    /// The compliance.
    pub frf: HammerFrf,
    /// Direction of blow and probe.
    pub axis: Axis,
    /// u = K y while it was measured; a sampled one acts through its hold.
    pub controller: &'a dyn HeldResponse,
}

/// Everything that was measured.
#[derive(Default)]
pub struct Measurement<'a> {
    /// Sweeps.
    pub sweeps: Vec<SweepRecord>,
    /// Hammer tests.
    pub taps: Vec<HammerTest<'a>>,
}
