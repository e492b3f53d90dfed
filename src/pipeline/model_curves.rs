//! Curves of a model: modes of the free rotor, and the open loop of the coaxial channels front and rear.

use super::PipelineError;
use crate::linalg::c64;
use crate::lti::{FrequencyGrid, Response};
use crate::rotor::Rotor;
use crate::rotor::modes::PlanarModes;
use crate::spindle::{Machine, ModelDetail, Plant, SpindleError};

/// Begin of the published sweeps, in begins of the stiffness band (50 Hz where that begins at 1 Hz), and lines to the
/// end of the band.
const BEGIN: f64 = 50.0;
const LINES: usize = 800;

/// The free rotor of a machine with its modes.
#[derive(Clone, Debug)]
pub struct FreeRotor {
    /// The rotor with its tool.
    pub rotor: Rotor,
    /// Its modes.
    pub modes: PlanarModes,
}

impl FreeRotor {
    /// Of a machine.
    ///
    /// # Errors
    /// [`PipelineError`] when the rotor or its modes fail.
    pub fn of(machine: &Machine) -> Result<Self, PipelineError> {
        let rotor = machine.rotor()?;
        let modes = PlanarModes::new(&rotor).map_err(SpindleError::from)?;
        Ok(Self { rotor, modes })
    }
}

/// Sensor over current of the full model at rest.
#[derive(Clone, Debug)]
pub struct OpenLoopCurves {
    /// Lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// Front and rear, m/A.
    pub response: [Vec<c64>; 2],
}

impl OpenLoopCurves {
    /// Of a machine.
    ///
    /// # Errors
    /// [`PipelineError`] when the plant cannot be built.
    pub fn of(machine: &Machine) -> Result<Self, PipelineError> {
        let (from_hz, to_hz) = machine.spindle.stiffness_band_hz;
        let grid = FrequencyGrid::log_hz((BEGIN * from_hz).min(0.5 * to_hz), to_hz, LINES);
        let plant = Plant::new(machine, 0.0, ModelDetail::Full)?;
        let lines: Vec<_> = grid.omega_rad_s().iter().map(|w| plant.at(*w)).collect();
        Ok(Self {
            frequency_hz: grid.hz(),
            response: [0, 2].map(|axis| lines.iter().map(|h| h[(axis, axis)]).collect()),
        })
    }
}
