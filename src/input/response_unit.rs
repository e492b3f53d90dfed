//! Unit of the responses in a table: displacement, velocity or acceleration, as the sensor gave them, to m.

use super::uff_units::read_unit;
use crate::identify::spectra::Motion;
use crate::identify::{HammerFrf, SweepRecord};
use crate::linalg::c64;
use ndarray::Axis;

/// What a unit of the response is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ResponseUnit {
    motion: Motion,
    /// SI units in one of it.
    si: f64,
}

impl ResponseUnit {
    /// The unit of a label such as `mm/s²`; that of a hammer test may say `/N` as well.
    pub(super) fn read(label: &str, over_force: bool) -> Result<Self, String> {
        let unit = read_unit(label).map_err(|part| format!("{label:?} is not understood: {part}"))?;
        let told = unit.and_then(|unit| {
            let [length, time, newton] = unit.dimensions;
            let fits = newton == 0 || over_force && newton == -1;
            Some(Self { motion: Motion::of_exponents([length, time]).filter(|_| fits)?, si: unit.si })
        });
        told.ok_or_else(|| format!("{label:?} is no displacement, velocity or acceleration"))
    }

    /// Displacement in m of one of it at a frequency above zero, Hz.
    fn displacement_m(self, frequency_hz: f64) -> c64 {
        self.motion.to_displacement(frequency_hz, 0.0) * self.si
    }

    /// Response over force to compliance.
    pub(super) fn to_compliance(self, frf: &mut HammerFrf) {
        for (f, h) in frf.frequency_hz.iter().zip(&mut frf.compliance) {
            *h *= self.displacement_m(*f);
        }
    }

    /// Signals to displacements.
    pub(super) fn to_displacements(self, sweep: &mut SweepRecord) {
        for (f, mut line) in sweep.frequency_hz.iter().zip(sweep.signal.axis_iter_mut(Axis(0))) {
            let unit = self.displacement_m(*f);
            line.mapv_inplace(|y| y * unit);
        }
    }
}
