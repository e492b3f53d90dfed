//! The specification a designer writes: Table 2 of the paper, and what the table leaves open.

use super::hardware::Uncertainty;
use super::shape::{Shape, WeightStage};
use super::weighting::WeightSection;
use crate::linalg::NumericError;
use schemars::JsonSchema;
use serde::Deserialize;

/// Limits at one place: loads that must be borne and displacements they may cause, at DC and at high frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest quasi-static load, N.
    pub max_dc_load_n: f64,
    /// Largest high-frequency load, N.
    pub max_hf_load_n: f64,
    /// Displacement allowed at DC, m.
    pub max_dc_displacement_m: f64,
    /// Displacement allowed at high frequency, m.
    pub max_hf_displacement_m: f64,
}

/// A level or corner that a specification may leave to the machine. Places: 0 tool, 1 front, 2 rear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FreeQuantity {
    /// Crossover of the load weight at a place.
    LoadCrossover(usize),
    /// Crossover of the displacement weight at a place.
    DisplacementCrossover(usize),
    /// Control current per unit disturbance.
    CurrentLimit,
    /// Corner of the roll-off of the control current.
    CurrentRolloff,
    /// Sensor noise.
    SensorNoise,
}

/// Weights of the generalized plant.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    /// Name of the specification.
    pub name: String,
    /// Limits at the tool plane.
    pub tool: Limits,
    /// Limits at the front bearing.
    pub front: Limits,
    /// Limits at the rear bearing.
    pub rear: Limits,
    /// Relative natural-frequency uncertainty of flexible modes 1, 2, ….
    pub mode_uncertainty: Vec<f64>,
    /// Crossover of the load weights at tool, front, rear, Hz. Default 40, 40, 40: loads change from
    /// quasi-static to dynamic well below the spindle frequency; γ hardly depends on it from 10 to 300 Hz.
    pub load_crossover_hz: [f64; 3],
    /// Crossover of the displacement weights at tool, front, rear, Hz. Default 40, 100, 100: at the bearings above the
    /// rigid-body modes, else the weight fights the unavoidable |S| > 1 there.
    pub displacement_crossover_hz: [f64; 3],
    /// Control current per unit disturbance, A. Default 2.5, below the bias of 3 A.
    pub current_limit_a: f64,
    /// Corner of the second-order roll-off of the control current, Hz. Default 3000.
    pub current_rolloff_hz: f64,
    /// Frequency ratio over which the roll-off acts. Default 10.
    pub current_rolloff_ratio: f64,
    /// Sensor noise the design assumes, m. Default 0.2 µm, four times a real sensor's: it also limits how hard K works.
    pub sensor_noise_m: f64,
    /// Largest complementary sensitivity, absolute; none by default.
    pub complementary_sensitivity_limit: Option<f64>,
    /// Corner below which the displacement at the sensors is regulated as by an integrator, Hz; none by default.
    pub integral_corner_hz: Option<f64>,
    /// Factor by which the tool displacement limits are tightened. Default 1.
    pub tool_tightening: f64,
    /// Uncertainty besides that of the natural frequencies; none by default.
    pub uncertainty: Uncertainty,
    /// Weights that take the place of those that change from one level to another.
    pub curves: GivenCurves,
    /// Bands in which the tool has to be stiff: limits of the polish, judged beside the specification.
    pub tool_stiffness: Vec<StiffnessFloor>,
    /// Relative shift of the natural frequencies, alone, combined and together, that the loop is to bear beside the
    /// specification, as that of a tuned PID; zero: none.
    pub mode_shift: f64,
    /// Least decay of the loop that the specification asks for, 1/s. None: a loop that decays more slowly than
    /// [`LEAST_DECAY_PER_S`] is polished once more, and need not reach it.
    pub least_decay_per_s: Option<f64>,
    /// What the file leaves to the machine; [`Weights::on`] puts it in. Empty unless the file says `defaults: machine`.
    pub open: Vec<FreeQuantity>,
}

/// Shift of the natural frequencies that a loop is asked to bear, as that of a tuned PID.
pub(crate) const MODE_SHIFT: f64 = 0.03;

/// Decay with which the tool has settled to 2 % a second after a load.
pub(crate) const LEAST_DECAY_PER_S: f64 = 4.0;

/// A band in which the tool has to be stiff.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StiffnessFloor {
    /// First frequency of the band.
    pub from_hz: f64,
    /// Last frequency of the band; the first one for a single frequency.
    pub to_hz: f64,
    /// Least dynamic stiffness of the tool there.
    pub at_least_n_per_m: f64,
}

impl StiffnessFloor {
    /// Rounding of a frequency by 2π and back.
    const ROUNDING: f64 = 1e-9;

    /// True when a frequency lies in the band.
    pub fn holds_at(&self, frequency_hz: f64) -> bool {
        let (low, high) = (self.from_hz * (1.0 - Self::ROUNDING), self.to_hz * (1.0 + Self::ROUNDING));
        (low..=high).contains(&frequency_hz)
    }
}

/// Weights over frequency that a specification gives itself. Places: 0 tool, 1 front, 2 rear.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GivenCurves {
    /// Loads that must be borne, N.
    pub load: [Option<Shape>; 3],
    /// One over the displacements allowed, 1/m.
    pub displacement: [Option<Shape>; 3],
    /// One over the control current allowed, 1/A.
    pub current: Option<Shape>,
    /// Sensor noise, m.
    pub noise: Option<Shape>,
}

impl Weights {
    fn place(&self, place: usize) -> &Limits {
        [&self.tool, &self.front, &self.rear][place]
    }

    /// Weight of the loads at a place, N.
    ///
    /// # Errors
    /// [`NumericError`] when a level is not positive.
    pub fn load_weight(&self, place: usize) -> Result<Shape, NumericError> {
        let limits = self.place(place);
        match &self.curves.load[place] {
            Some(curve) => Ok(curve.clone()),
            None => Shape::level_change(limits.max_dc_load_n, limits.max_hf_load_n, self.load_crossover_hz[place]),
        }
    }

    /// Weight of the displacement at a place, 1/m, the tool's tightened.
    ///
    /// # Errors
    /// As [`Weights::load_weight`].
    pub fn displacement_weight(&self, place: usize) -> Result<Shape, NumericError> {
        let limits = self.place(place);
        let factor = if place == 0 { self.tool_tightening } else { 1.0 };
        match &self.curves.displacement[place] {
            Some(curve) => Ok(curve.times(factor)),
            None => Shape::level_change(
                factor / limits.max_dc_displacement_m,
                factor / limits.max_hf_displacement_m,
                self.displacement_crossover_hz[place],
            ),
        }
    }

    /// Weight of the control current of a bearing, 1/A.
    ///
    /// # Errors
    /// As [`Weights::load_weight`].
    pub fn current_weight(&self) -> Result<Shape, NumericError> {
        if let Some(curve) = &self.curves.current {
            return Ok(curve.clone());
        }
        let stage = WeightSection::roll_on_stage(self.current_rolloff_hz, self.current_rolloff_ratio)?;
        Ok(Shape {
            gain: self.current_limit_a.recip(),
            stages: vec![WeightStage::First(stage); 2],
            excess_over_points: 0.0,
        })
    }
}
