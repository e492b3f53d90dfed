//! What was measured: sweeps under levitation, hammer tests at the tool with the controller that levitated.

use crate::identify::plausibility::RecordFault;
use crate::identify::{HammerFrf, SweepRecord};
use crate::lti::HeldResponse;

/// A control axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlAxis {
    /// x.
    X,
    /// y, 90° ahead.
    Y,
}

/// A hammer test at the tool plane.
#[derive(Clone)]
pub struct HammerTest<'a> {
    /// The compliance.
    pub frf: HammerFrf,
    /// Direction of blow and probe.
    pub axis: ControlAxis,
    /// u = K y while it was measured; a sampled one acts through its hold.
    pub controller: &'a dyn HeldResponse,
}

/// Everything that was measured.
#[derive(Clone, Default)]
pub struct RecordSet<'a> {
    /// Sweeps.
    pub sweeps: Vec<SweepRecord>,
    /// Hammer tests.
    pub taps: Vec<HammerTest<'a>>,
}

/// One record of a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordId {
    /// Index of a sweep.
    Sweep(usize),
    /// Index of a hammer test.
    Hammer(usize),
}

impl<'a> RecordSet<'a> {
    /// All records.
    pub fn records(&self) -> impl Iterator<Item = RecordId> + use<> {
        let sweeps = (0..self.sweeps.len()).map(RecordId::Sweep);
        sweeps.chain((0..self.taps.len()).map(RecordId::Hammer))
    }

    /// One record alone.
    #[must_use]
    pub fn only(&self, record: RecordId) -> Self {
        let mut one = Self::default();
        match record {
            RecordId::Sweep(s) => one.sweeps.extend(self.sweeps.get(s).cloned()),
            RecordId::Hammer(t) => one.taps.extend(self.taps.get(t).cloned()),
        }
        one
    }

    /// All records but one.
    #[must_use]
    pub fn without(&self, record: RecordId) -> Self {
        let mut rest = self.clone();
        match record {
            RecordId::Sweep(s) if s < rest.sweeps.len() => drop(rest.sweeps.remove(s)),
            RecordId::Hammer(t) if t < rest.taps.len() => drop(rest.taps.remove(t)),
            _ => {}
        }
        rest
    }

    /// With a fault taken out of one record.
    #[must_use]
    pub fn correct_record(mut self, record: RecordId, fault: RecordFault) -> Self {
        match record {
            RecordId::Sweep(s) => {
                if let Some(sweep) = self.sweeps.get_mut(s) {
                    *sweep = fault.corrected_sweep(sweep);
                }
            }
            RecordId::Hammer(t) => {
                if let Some(tap) = self.taps.get_mut(t) {
                    tap.frf = fault.corrected_hammer(&tap.frf);
                }
            }
        }
        self
    }

    /// Speed of a record, rpm.
    pub fn speed_rpm(&self, record: RecordId) -> f64 {
        match record {
            RecordId::Sweep(s) => self.sweeps.get(s).map_or(0.0, |r| r.speed_rpm),
            RecordId::Hammer(t) => self.taps.get(t).map_or(0.0, |r| r.frf.speed_rpm),
        }
    }
}
