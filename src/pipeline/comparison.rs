//! Predictions for a controller: dynamic stiffness at the tool and sensitivity at the sensors.

use super::PipelineError;
use super::loop_stability::{SpeedPoles, check_sample_time, loop_poles};
use crate::controller::amplifier_demand::amplifier_demand;
use crate::controller::{ControlLaw, Controller};
use crate::linalg::c64;
use crate::lti::sample::tustin;
use crate::lti::{Discrete, FrequencyGrid, StateSpace};
use crate::pid::settings::TuneSettings;
use crate::predict::chatter::{CuttingMaterial, Engagement, StabilityLimit, milling};
use crate::predict::closed_loop::compliance;
use crate::predict::modes::{LoopModes, loop_modes, modes_of_poles};
use crate::predict::sensitivity::{AxisSensitivity, Zone};
use crate::predict::stiffness::{DynamicStiffness, stiffness_and_sensitivity, stiffness_at};
use crate::predict::tool_step::static_load_settling_s;
use crate::spindle::{Machine, ModelDetail, Plant};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Low frequency at which stiffness is compared, Hz.
pub(crate) const LOW_HZ: f64 = 10.0;
/// Points of the plain grid over the band; points round the closed-loop poles are added.
const GRID_POINTS: usize = 400;
/// Lowest frequency of the sensitivity, Hz, where stiffness does not count from a lower one.
const MARGINS_FROM_HZ: f64 = 1.0;
/// Points on each side of every closed-loop pole: both skirts of a lightly damped peak to a percent of its height.
const POINTS_A_SIDE: usize = 12;

/// Predictions for one controller at one speed.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// Name of the controller.
    pub name: String,
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Tool stiffness per axis x, y.
    pub stiffness: [DynamicStiffness; 2],
    /// Smallest tool stiffness over both axes, N/m, and its frequency, Hz.
    pub minimum: (f64, f64),
    /// At 10 Hz, of the softer axis, N/m.
    pub at_10_hz_n_per_m: f64,
    /// At the frequency of the top speed, of the softer axis, N/m.
    pub at_max_speed_n_per_m: f64,
    /// Sensitivity of the four axes.
    pub sensitivity: AxisSensitivity,
    /// Largest growth rate of the loop at this speed, 1/s. An unstable loop has neither stiffness nor zone: the curves
    /// are empty and the figures are not numbers.
    pub growth_rate_per_s: f64,
    /// From when a static load begins until the tool stays within 2 % of where it holds it, s. Not a number of an
    /// unstable loop.
    pub static_load_settling_s: f64,
    /// Closed-loop poles as equivalent continuous ones, rad/s.
    pub poles_rad_s: Vec<c64>,
    /// Flexible and rigid-body modes of the loop.
    pub modes: LoopModes,
}

impl Prediction {
    /// True when the loop is stable at this speed.
    pub fn is_stable(&self) -> bool {
        self.growth_rate_per_s < 0.0
    }

    /// Zone of ISO 14839-3; none of an unstable loop.
    pub(crate) fn zone(&self) -> Option<Zone> {
        self.is_stable().then(|| self.sensitivity.zone())
    }

    /// Largest sensitivity over the axes, dB.
    pub(crate) fn sensitivity_peak_db(&self) -> f64 {
        20.0 * (0..4).map(|axis| self.sensitivity.peak(axis).0).fold(0.0, f64::max).log10()
    }

    /// Letter of the zone, or that the loop is unstable.
    pub(crate) fn zone_word(&self) -> &'static str {
        self.zone().map_or("none, unstable", Zone::letter)
    }
}

/// True when `a` is better than `b` in every figure at every speed given: smallest tool stiffness, stiffness at 10 Hz
/// and at the frequency of the top speed, largest sensitivity of each axis. An unstable loop is worse than a stable
/// one.
pub(crate) fn better_in_every_figure(a: &[Prediction], b: &[Prediction]) -> bool {
    let figures = |p: &Prediction| {
        let stiffness = [p.minimum.0, p.at_10_hz_n_per_m, p.at_max_speed_n_per_m];
        let margins = (0..4).map(|axis| p.sensitivity.peak(axis).0.recip());
        stiffness.into_iter().chain(margins).collect::<Vec<f64>>()
    };
    a.iter()
        .zip(b)
        .all(|(a, b)| a.is_stable() && (!b.is_stable() || figures(a).iter().zip(figures(b)).all(|(a, b)| *a > b)))
}

/// Settings of a PID search whose amplifier limits are the figures of the delivered controller: noise current at rest
/// and top speed, gain above the modes of the model.
pub(crate) fn rival_settings(
    machine: &Machine,
    delivered: &Controller,
    settings: TuneSettings,
) -> Result<TuneSettings, PipelineError> {
    let law = discrete(delivered, machine.spindle.electronics.sample_period_s())?;
    Ok(settings.held_to(&amplifier_demand(machine, &law)?))
}

/// Predictions for a controller on the full plant at a speed.
///
/// # Errors
/// [`PipelineError`] when the plant or the loop cannot be built.
pub fn predict(machine: &Machine, controller: &Controller, speed_rpm: f64) -> Result<Prediction, PipelineError> {
    let band_hz = machine.spindle.stiffness_band_hz;
    let LoopAtSpeed { plant, poles, grid } = closed_loop(machine, controller, speed_rpm, band_hz)?;
    let law = discrete(controller, machine.spindle.electronics.sample_period_s())?;
    // The two frequencies at which stiffness is stated are lines of their own where they lie in the band: beside a
    // sharp zero nothing can be interpolated.
    let top_speed_hz = machine.spindle.max_rpm / 60.0;
    let stated = [LOW_HZ, top_speed_hz].into_iter();
    let stated = stated.filter(|f| (band_hz.0..=band_hz.1).contains(f));
    let stable = poles.growth_rate_per_s < 0.0;
    let lines = grid.omega_rad_s().iter().copied();
    let beside = lines_beside_band(machine, &poles.poles_rad_s);
    let lines = lines.chain(stated.map(|f| f * TAU)).chain(beside);
    let grid = FrequencyGrid::from_rad_s(lines.filter(|_| stable));
    let softer_axis =
        |hz: f64| [0, 1].map(|axis| stiffness_at(&plant, controller, axis, hz)).into_iter().reduce(f64::min);
    let at = |hz: f64| softer_axis(hz).filter(|_| stable).unwrap_or(f64::NAN);
    let (stiffness, sensitivity) = stiffness_and_sensitivity(&plant, &*controller.responder(), &grid, band_hz);
    let modes = match &controller.law {
        ControlLaw::Discrete(_) => modes_of_poles(&plant, &law, &poles.poles_rad_s)?,
        ControlLaw::Continuous(_) => loop_modes(&plant, &law)?,
    };
    let static_load_settling_s = if stable {
        static_load_settling_s(&plant.sample_plant()?, &law).map_err(PipelineError::numeric("static load"))?
    } else {
        f64::NAN
    };
    let minimum = stiffness
        .iter()
        .filter_map(DynamicStiffness::minimum)
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or((f64::NAN, f64::NAN));
    Ok(Prediction {
        name: controller.name.clone(),
        speed_rpm,
        minimum,
        at_10_hz_n_per_m: at(LOW_HZ),
        at_max_speed_n_per_m: at(top_speed_hz),
        sensitivity,
        growth_rate_per_s: poles.growth_rate_per_s,
        static_load_settling_s,
        poles_rad_s: poles.poles_rad_s,
        modes,
        stiffness,
    })
}

pub(super) struct LoopAtSpeed {
    pub(super) plant: Plant,
    pub(super) poles: SpeedPoles,
    /// A grid that is dense round the poles.
    pub(super) grid: FrequencyGrid,
}

/// The full plant at a speed, the poles of its loop, and a grid over `band_hz`, at most to Nyquist, that is dense round
/// them.
pub(super) fn closed_loop(
    machine: &Machine,
    controller: &Controller,
    speed_rpm: f64,
    band_hz: (f64, f64),
) -> Result<LoopAtSpeed, PipelineError> {
    let plant = Plant::new(machine, speed_rpm * TAU / 60.0, ModelDetail::Full)?;
    let poles = loop_poles(&plant, controller)?;
    let grid = FrequencyGrid::log_hz(band_hz.0, below_nyquist(machine, band_hz.1), GRID_POINTS)
        .refine_round_poles(&poles.poles_rad_s, POINTS_A_SIDE);
    Ok(LoopAtSpeed { plant, poles, grid })
}

/// Band of the margins, Hz. A band in which stiffness counts does not bound it.
pub(super) fn margin_band_hz(machine: &Machine) -> (f64, f64) {
    (MARGINS_FROM_HZ.min(machine.spindle.stiffness_band_hz.0), f64::INFINITY)
}

/// Lines of that band outside of the one in which stiffness counts, dense round the poles, rad/s.
pub(super) fn lines_beside_band(machine: &Machine, poles_rad_s: &[c64]) -> Vec<f64> {
    let ((from_hz, to_hz), (low_hz, high_hz)) = (margin_band_hz(machine), machine.spindle.stiffness_band_hz);
    let whole = FrequencyGrid::log_hz(from_hz, below_nyquist(machine, to_hz), GRID_POINTS)
        .refine_round_poles(poles_rad_s, POINTS_A_SIDE);
    let band = low_hz * TAU..=high_hz * TAU;
    whole.omega_rad_s().iter().copied().filter(|w| !band.contains(w)).collect()
}

/// A frequency, at most 0.49 of the sample rate: beyond Nyquist the response of a sampled loop repeats, and says
/// nothing.
pub(super) fn below_nyquist(machine: &Machine, hz: f64) -> f64 {
    hz.min(0.49 * machine.spindle.electronics.sample_rate_hz)
}

/// Stability lobes of milling with a controller at a speed, from the closed-loop tool compliance in both axes.
///
/// `None` for a loop that is unstable without a cut.
pub(crate) fn chatter_limit(
    machine: &Machine,
    controller: &Controller,
    speed_rpm: f64,
    material: &CuttingMaterial,
    cut: &Engagement,
) -> Result<Option<StabilityLimit>, PipelineError> {
    let LoopAtSpeed { plant, poles, grid } = closed_loop(machine, controller, speed_rpm, chatter_band_hz(machine))?;
    if poles.growth_rate_per_s >= 0.0 {
        return Ok(None);
    }
    let responder = controller.responder();
    let tool: Vec<_> = grid
        .omega_rad_s()
        .par_iter()
        .map(|w| compliance(&plant, &*responder, *w).submatrix(0, 0, 2, 2).to_owned())
        .collect();
    Ok(Some(milling(grid.omega_rad_s(), &tool, material, cut)?))
}

/// Band in which chatter is looked for, Hz: from the rigid-body modes to beyond the modes of the design (20 Hz to 6 kHz
/// where stiffness counts from 1 Hz to 4 kHz).
fn chatter_band_hz(machine: &Machine) -> (f64, f64) {
    let (from, to) = machine.spindle.stiffness_band_hz;
    ((20.0 * from).min(0.5 * to), 1.5 * to)
}

/// The law in sampled time; a continuous one by Tustin's rule, as the loop would run it.
///
/// # Errors
/// [`PipelineError::SampleTime`] of a law at another rate; [`PipelineError::Numeric`] when the map is singular.
pub fn discrete(controller: &Controller, period_s: f64) -> Result<StateSpace<Discrete>, PipelineError> {
    match &controller.law {
        ControlLaw::Discrete(law) => check_sample_time(law, period_s).map(|()| law.clone()),
        ControlLaw::Continuous(law) => tustin(law, period_s).map_err(PipelineError::numeric("discretisation")),
    }
}
