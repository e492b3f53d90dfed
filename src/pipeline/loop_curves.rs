//! Classical curves of a loop: response of the controller, characteristic loci, whirl frequencies and unbalance
//! response over speed.

use super::PipelineError;
use super::comparison::Prediction;
use super::overspeed::OVERSPEED;
use crate::controller::Controller;
use crate::predict::loop_shape::{LoopShape, unbalance_response};
use crate::rotor::modes::PlanarModes;
use crate::spindle::{Machine, ModelDetail, Plant, SpindleError};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Speeds of the unbalance response: 2 % of the top speed apart.
const UNBALANCE_SPEEDS: usize = 60;
/// Speeds of the whirl frequencies.
const WHIRL_SPEEDS: usize = 9;
/// The whirl frequencies end there, Hz: the bending modes that a bearing acts on.
const WHIRL_TO_HZ: f64 = 5000.0;

/// A whirl frequency over speed.
#[derive(Clone, Debug)]
pub struct WhirlLine {
    /// +1 forward, −1 backward.
    pub whirl: i8,
    /// Speeds, rpm.
    pub speed_rpm: Vec<f64>,
    /// Frequencies, Hz.
    pub frequency_hz: Vec<f64>,
}

/// Displacements for an unbalance at the tool plane over speed, closed loop of the full model.
#[derive(Clone, Debug)]
pub struct UnbalanceCurve {
    /// Speeds, rpm.
    pub speed_rpm: Vec<f64>,
    /// At tool, front and rear actuator, m per kg m.
    pub displacement: Vec<[f64; 3]>,
}

/// Curves of a loop.
#[derive(Clone, Debug)]
pub struct LoopCurves {
    /// Bending modes of the free rotor over speed.
    pub whirl: Vec<WhirlLine>,
    /// The loop; none that is unstable at rest.
    pub stable: Option<StableLoop>,
}

/// Curves of a loop that is stable at rest.
#[derive(Clone, Debug)]
pub struct StableLoop {
    /// Controller and open loop at rest.
    pub shape: LoopShape,
    /// Response to an unbalance.
    pub unbalance: UnbalanceCurve,
}

impl LoopCurves {
    /// The curves of a controller with its prediction at rest.
    ///
    /// # Errors
    /// [`PipelineError`] when a plant or an eigenvalue iteration fails.
    pub fn of(machine: &Machine, controller: &Controller, rest: &Prediction) -> Result<Self, PipelineError> {
        let whirl = whirl_lines(machine)?;
        if !rest.is_stable() {
            return Ok(Self { whirl, stable: None });
        }
        let plant = Plant::new(machine, 0.0, ModelDetail::Full)?;
        let lines = lines_hz(&plant, &rest.sensitivity.frequency_hz);
        let shape = LoopShape::new(&plant, &*controller.responder(), &lines).map_err(SpindleError::from)?;
        let top_rpm = machine.spindle.max_rpm;
        let speeds = (1..=UNBALANCE_SPEEDS).map(|k| OVERSPEED * top_rpm * k as f64);
        let speed_rpm: Vec<f64> = speeds.map(|v| v / UNBALANCE_SPEEDS as f64).collect();
        let displacement = unbalance_response(machine, controller, &speed_rpm)?;
        Ok(Self { whirl, stable: Some(StableLoop { shape, unbalance: UnbalanceCurve { speed_rpm, displacement } }) })
    }
}

/// The lines of the predictions, dense round the poles of the closed loop, with more round those of the open one:
/// ratios from a tenth of a damping width to a tenth of the frequency.
fn lines_hz(plant: &Plant, closed: &[f64]) -> Vec<f64> {
    let mut all = closed.to_vec();
    let (Some(low), Some(high)) = (closed.first().copied(), closed.last().copied()) else {
        return all;
    };
    for omega in plant.flexible_rad_s() {
        for k in 0..24 {
            let step = 4e-4 * 250f64.powf(f64::from(k) / 23.0);
            all.extend([1.0 - step, 1.0 + step].map(|ratio| omega / TAU * ratio));
        }
        all.push(omega / TAU);
    }
    all.retain(|hz| (low..=high).contains(hz));
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// Whirl frequencies of the bending modes of the free rotor, each mode followed from speed to speed.
fn whirl_lines(machine: &Machine) -> Result<Vec<WhirlLine>, PipelineError> {
    let rotor = machine.rotor()?;
    let top = machine.spindle.max_rpm;
    // The rigid-body modes of the free rotor stay far below half its first bending mode.
    let bending = PlanarModes::new(&rotor).map_err(SpindleError::from)?;
    let lowest = 0.5 * TAU * bending.flexible_hz().first().copied().unwrap_or_default();
    let speeds: Vec<f64> = (1..=WHIRL_SPEEDS).map(|k| top * k as f64 / WHIRL_SPEEDS as f64).collect();
    let spectra: Result<Vec<_>, SpindleError> =
        speeds.par_iter().map(|rpm| machine.whirl(rpm * TAU / 60.0, WHIRL_TO_HZ)).collect();
    let mut lines: Vec<WhirlLine> = vec![];
    for (before, (rpm, found)) in speeds.iter().zip(spectra?).enumerate() {
        for sense in [-1i8, 1] {
            let whirling = found.modes.iter().filter(|m| m.whirl as i8 == sense);
            for mode in whirling.filter(|m| m.natural_rad_s > lowest) {
                // Modes come in ascending order: each goes to the first line that has none at this speed yet.
                let open = |l: &WhirlLine| l.whirl == sense && l.speed_rpm.len() == before;
                let at = match lines.iter().position(open) {
                    Some(at) => at,
                    None if before == 0 => {
                        lines.push(WhirlLine { whirl: sense, speed_rpm: vec![], frequency_hz: vec![] });
                        lines.len() - 1
                    }
                    None => break,
                };
                lines[at].speed_rpm.push(*rpm);
                lines[at].frequency_hz.push(mode.natural_rad_s / TAU);
            }
        }
    }
    Ok(lines)
}
