//! The line of the shaft between the planes that a simulation records, for pictures of its motion.
//!
//! Tool and both actuators are recorded; between and beyond them the line is the combination of the two rigid modes and
//! the first bending mode of the free rotor through these three points. Limits: a picture, not a prediction; higher
//! bending shows at the three planes only.

use crate::linalg::{Mat, solve};
use crate::rotor::modes::PlanarModes;
use crate::spindle::{Machine, SpindleError};

/// Planes that are recorded.
const PLANES: usize = 3;

/// Weights that turn displacements at tool, front and rear actuator into displacements along the shaft.
#[derive(Clone, Debug)]
pub struct ShaftLine {
    /// Stations along the shaft, m from the tool end.
    pub position_m: Vec<f64>,
    /// Stations × three planes.
    weights: Mat<f64>,
}

impl ShaftLine {
    /// The line of a machine's rotor at evenly spaced stations.
    ///
    /// # Errors
    /// [`SpindleError`] when the rotor breaks a rule or the three planes do not determine the line.
    pub fn new(machine: &Machine, stations: usize) -> Result<Self, SpindleError> {
        let rotor = machine.rotor()?;
        let modes = PlanarModes::new(&rotor)?;
        let ends = rotor.node_positions_m();
        let (first, last) = (ends.first().copied().unwrap_or(0.0), ends.last().copied().unwrap_or(0.0));
        let planes = &machine.spindle.planes;
        let recorded = [machine.tool_plane_m(), planes.front_actuator_m, planes.rear_actuator_m];
        let count = stations.max(2);
        let position_m: Vec<f64> = (0..count).map(|k| first + (last - first) * k as f64 / (count - 1) as f64).collect();
        let amplitudes = |z: &[f64]| -> Result<Mat<f64>, SpindleError> {
            let rows: Result<Vec<Vec<f64>>, SpindleError> = z
                .iter()
                .map(|z| {
                    let row = rotor.shape_at("line of the shaft", *z)?;
                    Ok(modes.amplitudes(&row))
                })
                .collect();
            let rows = rows?;
            Ok(Mat::from_fn(z.len(), PLANES, |i, k| rows[i].get(k).copied().unwrap_or(0.0)))
        };
        let (along, through) = (amplitudes(&position_m)?, amplitudes(&recorded)?);
        let inverse = solve(&through, &Mat::identity(PLANES, PLANES))?;
        Ok(Self { position_m, weights: &along * &inverse })
    }

    /// Displacements at the stations from those at tool, front and rear actuator.
    pub fn through(&self, planes: [f64; PLANES]) -> Vec<f64> {
        (0..self.weights.nrows()).map(|i| (0..PLANES).map(|k| self.weights[(i, k)] * planes[k]).sum()).collect()
    }
}
