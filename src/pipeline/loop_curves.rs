//! Classical curves of a loop: response of the controller, characteristic loci, loop gain, step at the tool, stiffness
//! of sampled plants, whirl frequencies and orbits, spectra over speed, and unbalance response over speed with its
//! amplification factors.

use super::PipelineError;
use super::comparison::{LoopAtSpeed, Prediction, below_nyquist, closed_loop, discrete, margin_band_hz};
use super::overspeed::OVERSPEED;
use crate::controller::Controller;
use crate::controller::verification::growth_rate_of;
use crate::lti::{Discrete, FrequencyGrid, StateSpace};
use crate::pid::shifted_loops::find_shift_range;
use crate::predict::amplification::{CriticalSpeed, find_critical_speeds};
use crate::predict::cascade::Cascade;
use crate::predict::closed_loop::compliance;
use crate::predict::disc_margins::DiscMargins;
use crate::predict::loop_gain::LoopGain;
use crate::predict::loop_shape::{LoopShape, unbalance_response};
use crate::predict::loop_sigma::LoopSigma;
use crate::predict::modes::{LoopMode, loop_modes};
use crate::predict::time::TimeSettings;
use crate::predict::time_force::Magnet;
use crate::predict::tool_step::ToolStep;
use crate::rotor::modes::PlanarModes;
use crate::spindle::{Machine, ModelDetail, Plant, SpindleError, WhirlOrbits};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
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
    /// Maxima of each.
    pub maxima: [Vec<CriticalSpeed>; 3],
}

/// Curves of a loop.
#[derive(Clone, Debug)]
pub struct LoopCurves {
    /// Bending modes of the free rotor over speed.
    pub whirl: Vec<WhirlLine>,
    /// Their orbits at top speed.
    pub orbits: WhirlOrbits,
    /// Static load capacity, N, and force slew rate, N/s, of the front and of the rear bearing.
    pub capacity: [(f64, f64); 2],
    /// The loop; none that is unstable at rest.
    pub stable: Option<StableLoop>,
}

/// Curves of a loop that is stable at rest.
#[derive(Clone, Debug)]
pub struct StableLoop {
    /// Controller and open loop at rest.
    pub shape: LoopShape,
    /// Loop gain of each channel at rest, to the end of the sampled frequencies.
    pub gain: LoopGain,
    /// Largest singular values at rest, on the same lines.
    pub sigma: LoopSigma,
    /// Margins.
    pub margins: LoopMargins,
    /// Displacement after a step of force at the tool, at rest.
    pub step: ToolStep,
    /// Stiffness at rest with rotors from within the uncertainty.
    pub sampled_plants: DrawnPlants,
    /// Response to an unbalance.
    pub unbalance: UnbalanceCurve,
    /// Spectra at the tool up to 1.2 times the top speed.
    pub cascade: Cascade,
    /// Modes of the closed loop from rest to 1.2 times the top speed.
    pub campbell: Vec<ModesAtSpeed>,
}

/// Modes of the closed loop at a speed.
#[derive(Clone, Debug)]
pub struct ModesAtSpeed {
    /// rpm.
    pub speed_rpm: f64,
    /// Those that show at the actuators or in a flexible mode, both whirls apart.
    pub modes: Vec<LoopMode>,
}

/// Speeds at which the modes of the loop are computed.
const CAMPBELL_SPEEDS: usize = 7;

impl ModesAtSpeed {
    /// Of a law from rest to 1.2 times the top speed.
    fn over_speed(machine: &Machine, law: &StateSpace<Discrete>) -> Result<Vec<Self>, PipelineError> {
        let at = |k: usize| {
            let share = k as f64 / (CAMPBELL_SPEEDS - 1) as f64;
            let speed_rpm = OVERSPEED * machine.spindle.max_rpm * share;
            let plant = Plant::new(machine, speed_rpm * TAU / 60.0, ModelDetail::Full)?;
            Ok(Self { speed_rpm, modes: loop_modes(&plant, law)?.visible })
        };
        (0..CAMPBELL_SPEEDS).into_par_iter().map(at).collect()
    }
}

/// What a loop may change by.
#[derive(Clone, Copy, Debug)]
pub struct LoopMargins {
    /// Disc margins at rest and at top speed; none of a loop that is unstable there.
    pub discs: [Option<DiscMargins>; 2],
    /// Relative shift of the natural frequencies, in every combination that a PID is certified with, that it bears.
    pub mode_shift: f64,
}

/// Dynamic stiffness of the tool in x with rotors whose natural frequencies are drawn from their ranges.
#[derive(Clone, Debug)]
pub struct DrawnPlants {
    /// Lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// |F/x| with each rotor whose loop is stable, N/m.
    pub stiffness_n_per_m: Vec<Vec<f64>>,
    /// Rotors whose loop is unstable.
    pub unstable: usize,
}

const SAMPLED_PLANTS: usize = 30;
const SAMPLE_SEED: u64 = 1;
/// Lines of their stiffness over the band, and across the range of each mode and a twentieth of its frequency beyond,
/// by which a loop moves it.
const SAMPLE_LINES: usize = 120;
const LINES_A_MODE: usize = 24;
const BEYOND: f64 = 0.05;

impl LoopCurves {
    /// The curves of a controller with its prediction at rest; natural frequencies are uncertain by these shares.
    ///
    /// # Errors
    /// [`PipelineError`] when a plant or an eigenvalue iteration fails.
    pub fn of(
        machine: &Machine,
        controller: &Controller,
        rest: &Prediction,
        mode_uncertainty: &[f64],
    ) -> Result<Self, PipelineError> {
        let whirl = whirl_lines(machine)?;
        let orbits = WhirlOrbits::of(machine, &[], machine.spindle.max_rpm, WHIRL_TO_HZ)?;
        let magnets = Magnet::both(machine, TimeSettings::default().bus_voltage_v);
        let capacity = magnets.map(|magnet| (magnet.static_capacity_n(), magnet.slew_n_per_s()));
        if !rest.is_stable() {
            return Ok(Self { whirl, orbits, capacity, stable: None });
        }
        let LoopAtSpeed { plant, grid, .. } = closed_loop(machine, controller, 0.0, margin_band_hz(machine))?;
        let gain = LoopGain::new(&plant, &*controller.responder(), &grid);
        let sigma = LoopSigma::new(&plant, &*controller.responder(), &grid);
        let margins = LoopMargins::of(machine, controller)?;
        let lines = lines_hz(&plant, &rest.sensitivity.frequency_hz);
        let shape = LoopShape::new(&plant, &*controller.responder(), &lines).map_err(SpindleError::from)?;
        let top_rpm = machine.spindle.max_rpm;
        let speeds = (1..=UNBALANCE_SPEEDS).map(|k| OVERSPEED * top_rpm * k as f64);
        let speed_rpm: Vec<f64> = speeds.map(|v| v / UNBALANCE_SPEEDS as f64).collect();
        let law = discrete(controller, machine.spindle.electronics.sample_period_s())?;
        let step = ToolStep::of(&plant.sample_plant()?, &law).map_err(PipelineError::numeric("step at the tool"))?;
        let sampled_plants = DrawnPlants::draw(machine, &plant, (controller, &law), mode_uncertainty)?;
        let unbalance = UnbalanceCurve::of(machine, controller, speed_rpm)?;
        let (from_hz, to_hz) = machine.spindle.stiffness_band_hz;
        let range_hz = [from_hz, below_nyquist(machine, to_hz)];
        let cascade = Cascade::new(machine, &*controller.responder(), OVERSPEED * top_rpm, range_hz)?;
        let campbell = ModesAtSpeed::over_speed(machine, &law)?;
        let stable = StableLoop { shape, gain, sigma, margins, step, sampled_plants, unbalance, cascade, campbell };
        Ok(Self { whirl, orbits, capacity, stable: Some(stable) })
    }
}

impl LoopMargins {
    /// Of the loop of a controller.
    ///
    /// # Errors
    /// [`PipelineError`] when a plant or a decomposition fails.
    pub(crate) fn of(machine: &Machine, controller: &Controller) -> Result<Self, PipelineError> {
        let at = |rpm: f64| -> Result<Option<DiscMargins>, PipelineError> {
            let LoopAtSpeed { plant, poles, grid } = closed_loop(machine, controller, rpm, margin_band_hz(machine))?;
            if poles.growth_rate_per_s >= 0.0 {
                return Ok(None);
            }
            let found = DiscMargins::new(&plant, &*controller.responder(), &grid);
            found.map(Some).map_err(PipelineError::mu("disc margins"))
        };
        let law = discrete(controller, machine.spindle.electronics.sample_period_s())?;
        let discs = || rayon::join(|| at(0.0), || at(machine.spindle.max_rpm));
        let ((rest, top), mode_shift) = rayon::join(discs, || find_shift_range(machine, &law));
        Ok(Self { discs: [rest?, top?], mode_shift: mode_shift?.largest })
    }
}

impl UnbalanceCurve {
    fn of(machine: &Machine, controller: &Controller, speed_rpm: Vec<f64>) -> Result<Self, SpindleError> {
        let displacement = unbalance_response(machine, controller, &speed_rpm)?;
        let maxima = |place: usize| {
            let values: Vec<f64> = displacement.iter().map(|at| at[place]).collect();
            find_critical_speeds(&speed_rpm, &values, &|rpm| {
                Ok::<_, SpindleError>(
                    unbalance_response(machine, controller, &[rpm])?.first().map_or(f64::NAN, |at| at[place]),
                )
            })
        };
        let maxima = [maxima(0)?, maxima(1)?, maxima(2)?];
        Ok(Self { speed_rpm, displacement, maxima })
    }
}

impl DrawnPlants {
    /// With rotors around a plant, evenly spread over the ranges of its natural frequencies.
    fn draw(
        machine: &Machine,
        plant: &Plant,
        (controller, law): (&Controller, &StateSpace<Discrete>),
        mode_uncertainty: &[f64],
    ) -> Result<Self, PipelineError> {
        let modes = plant.flexible_rad_s().iter().zip(mode_uncertainty);
        let across = modes.clone().flat_map(|(omega, r)| {
            let share = move |k: usize| (r + BEYOND) * (2.0 * k as f64 / (LINES_A_MODE - 1) as f64 - 1.0);
            (0..LINES_A_MODE).map(move |k| omega * (1.0 + share(k)))
        });
        let (from_hz, to_hz) = machine.spindle.stiffness_band_hz;
        let to_hz = below_nyquist(machine, to_hz);
        let band = from_hz * TAU..=to_hz * TAU;
        let plain = FrequencyGrid::log_hz(from_hz, to_hz, SAMPLE_LINES);
        let lines = plain.omega_rad_s().iter().copied().chain(across).filter(|omega| band.contains(omega));
        let grid = FrequencyGrid::from_rad_s(lines);
        let mut random = ChaCha8Rng::seed_from_u64(SAMPLE_SEED);
        let mut draw = |r: &f64| 1.0 + r * (2.0 * random.random::<f64>() - 1.0);
        let factors: Vec<Vec<f64>> =
            (0..SAMPLED_PLANTS).map(|_| modes.clone().map(|(_, r)| draw(r)).collect()).collect();
        let responder = controller.responder();
        let stiffness = |factors: &Vec<f64>| {
            let drawn = plant.with_scaled_modes(factors);
            let growth = growth_rate_of(&drawn, &drawn.sample_plant()?, law);
            let stable = growth.map_err(PipelineError::numeric("loop with a sampled plant"))? < 0.0;
            let lines = grid.omega_rad_s().iter();
            let values = lines.map(|w| compliance(&drawn, &*responder, *w)[(0, 0)].norm().recip());
            Ok::<_, PipelineError>(stable.then(|| values.collect::<Vec<f64>>()))
        };
        let drawn: Result<Vec<Option<Vec<f64>>>, PipelineError> = factors.par_iter().map(stiffness).collect();
        let stiffness_n_per_m: Vec<Vec<f64>> = drawn?.into_iter().flatten().collect();
        let unstable = SAMPLED_PLANTS - stiffness_n_per_m.len();
        Ok(Self { frequency_hz: grid.hz(), stiffness_n_per_m, unstable })
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
