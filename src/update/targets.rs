//! What the model is moved towards: measured resonances and antiresonances, each with a standard deviation where one is
//! known, and measured mode shapes, which are compared but not fitted.

use crate::identify::Reading;

/// A measured frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Frequency of the free-free rotor, Hz.
    pub frequency_hz: f64,
    /// Standard deviation, Hz; `None` when whoever read it off gave none.
    pub standard_deviation_hz: Option<f64>,
    /// Part of the frequency that stands for the stiffness of the magnets, which was removed, Hz; 0 where there was
    /// none.
    pub magnet_shift_hz: f64,
}

impl Target {
    /// A reading of a measured peak; none of a peak that was not found.
    pub(super) fn of(reading: &Reading) -> Option<Self> {
        let Reading::Found { frequency_hz, standard_deviation_hz, magnet_shift_hz } = *reading else {
            return None;
        };
        Some(Self { frequency_hz, standard_deviation_hz: Some(standard_deviation_hz), magnet_shift_hz })
    }

    /// A frequency of the free-free rotor, Hz, with its standard deviation if one is known.
    pub fn free(frequency_hz: f64, standard_deviation_hz: Option<f64>) -> Self {
        Self { frequency_hz, standard_deviation_hz, magnet_shift_hz: 0.0 }
    }

    /// A frequency without a standard deviation.
    pub fn read_off(frequency_hz: f64) -> Self {
        Self::free(frequency_hz, None)
    }
}

/// Antiresonances of one FRF of the free-free rotor.
#[derive(Clone, Debug, PartialEq)]
pub struct FrfTargets {
    /// Name in reports: `front`, `rear`, or output and input.
    pub name: String,
    /// Where the displacement is read, m from the nose face.
    pub output_m: f64,
    /// Where the force acts, m from the nose face.
    pub input_m: f64,
    /// Antiresonances in ascending order; `None` stands for one that exists but could not be identified.
    pub antiresonances: Vec<Option<Target>>,
    /// True keeps them out of the fit: the updated model is only compared with them.
    pub held_out: bool,
}

/// Points of a measured mode shape.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredShape {
    /// Flexible mode, from 1.
    pub mode: usize,
    /// (position m from the nose face, amplitude in any scale).
    pub points: Vec<(f64, f64)>,
}

/// Everything a fit can use.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Targets {
    /// Flexible resonances in ascending order; `None` stands for one that exists but could not be identified.
    pub resonances: Vec<Option<Target>>,
    /// Antiresonances, one entry per FRF.
    pub antiresonances: Vec<FrfTargets>,
    /// Mode shapes to compare with.
    pub mode_shapes: Vec<MeasuredShape>,
    /// Springs to ground that the measured rotor stands on: place, m, and stiffness, N/m. None: it is free.
    pub springs: Vec<(f64, f64)>,
}

impl Targets {
    /// Number of measured frequencies; antiresonances count only with `with_antiresonances`.
    pub(crate) fn count(&self, with_antiresonances: bool) -> usize {
        let fitted = self.antiresonances.iter().filter(|f| !f.held_out);
        let zeros = fitted.flat_map(|f| &f.antiresonances);
        self.resonances.iter().flatten().count() + if with_antiresonances { zeros.flatten().count() } else { 0 }
    }

    /// Highest measured frequency, Hz; 0 when there is none.
    pub(crate) fn highest_hz(&self) -> f64 {
        self.all_hz().fold(0.0, f64::max)
    }

    /// Lowest measured frequency, Hz; infinite when there is none.
    pub(super) fn lowest_hz(&self) -> f64 {
        self.all_hz().fold(f64::INFINITY, f64::min)
    }

    fn all_hz(&self) -> impl Iterator<Item = f64> {
        let zeros = self.antiresonances.iter().flat_map(|f| &f.antiresonances);
        zeros.chain(&self.resonances).flatten().map(|t| t.frequency_hz)
    }
}
