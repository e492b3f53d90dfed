//! Weights YAML (formats.md, section 3) to [`Weights`]. Optional keys and their defaults stand at [`Weights`].

use super::curve::CurvesFile;
use super::error::InputError;
use super::error_list::ErrorList;
use super::keys;
use super::shipped::{self, WEIGHTS};
use super::uncertainty::{UncertaintyFile, uncertainty};
use super::yaml;
use crate::augment::weights::{FreeQuantity, Limits, MODE_SHIFT, StiffnessFloor, Weights};
use schemars::JsonSchema;
use serde::Deserialize;

/// What a controller has to achieve: loads, displacements and uncertainty.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WeightsFile {
    /// Name of the specification.
    name: String,
    /// Limits at the tool plane.
    tool: LimitsFile,
    /// Limits at the front bearing.
    front: LimitsFile,
    /// Limits at the rear bearing.
    rear: LimitsFile,
    /// Relative uncertainty of the natural frequencies of flexible modes 1, 2, …; 0.01 is one per cent.
    mode_uncertainty: Vec<f64>,
    /// Control current per unit disturbance.
    #[schemars(extend("default" = CURRENT_LIMIT_A))]
    current_limit_a: Option<f64>,
    /// Corner of the second-order roll-off of the control current.
    #[schemars(extend("default" = CURRENT_ROLLOFF_HZ))]
    current_rolloff_hz: Option<f64>,
    /// Frequency ratio over which the roll-off acts.
    #[schemars(extend("default" = CURRENT_ROLLOFF_RATIO))]
    current_rolloff_ratio: Option<f64>,
    /// Noise that the design assumes.
    #[schemars(extend("default" = SENSOR_NOISE_M))]
    sensor_noise_m: Option<f64>,
    /// Bound on the complementary sensitivity in the D-K iteration only; the design chooses the tightest of 3.5, 4,
    /// 4.5, 5, 6, 8, 12 with γ ≤ 1 unless given.
    complementary_sensitivity_limit: Option<f64>,
    /// Integral action: below it the signals are regulated as by an integrator; none unless given.
    integral_corner_hz: Option<f64>,
    /// Divides the tool's displacement limits.
    #[schemars(extend("default" = 1.0))]
    tool_tightening: Option<f64>,
    /// Uncertainty besides that of the natural frequencies, the same at both bearings; none unless given.
    #[serde(default)]
    uncertainty: UncertaintyFile,
    /// Loads, displacements, current and errors over frequency, as points or transfer functions, in the place of those
    /// that change from one level to another; none unless given.
    #[serde(default)]
    over_frequency: CurvesFile,
    /// Bands in which the tool has to be stiff, at rest and at top speed; limits of the polish, judged beside the loads
    /// and displacements above. None unless given.
    #[serde(default)]
    tool_stiffness: Vec<StiffnessFloor>,
    /// Relative shift of the natural frequencies, alone, combined and together, that the loop is to bear as that of a
    /// tuned PID does: the polish goes on for it where the loop does not. Zero: none is asked. 0.03 unless given.
    mode_shift: Option<f64>,
    /// Least decay of the loop: the polish keeps the controller's own poles at least as fast, so that the tool comes to
    /// rest after a load within some multiples of its inverse. None is asked unless given; a loop slower than 4 1/s is
    /// then polished once more.
    least_decay_per_s: Option<f64>,
    /// Where the keys above come from that the file leaves out: `table`, the values stated here, the same on every
    /// machine, or `machine`: current 5/6 of the bias, roll-off at 0.15 of the sample rate and above the modes of the
    /// table, noise four times that of the sensors, crossovers from mass and negative stiffness.
    #[serde(default)]
    defaults: Defaults,
}

/// Where values come from that a weights file leaves out.
#[derive(Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum Defaults {
    /// The stated ones.
    #[default]
    Table,
    /// The machine.
    Machine,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LimitsFile {
    /// Largest quasi-static load.
    max_dc_load_n: f64,
    /// Largest high-frequency load.
    max_hf_load_n: f64,
    /// Displacement allowed at low frequency.
    max_dc_displacement_m: f64,
    /// Displacement allowed at high frequency.
    max_hf_displacement_m: f64,
    /// Where the load changes from its low-frequency to its high-frequency level.
    #[schemars(extend("default" = LOAD_CROSSOVER_HZ[0]))]
    load_crossover_hz: Option<f64>,
    /// The same for the displacement; 40 at the tool, 100 at the bearings unless given.
    displacement_crossover_hz: Option<f64>,
}

/// Defaults of the keys that Table 2 leaves open; reasons at [`Weights`].
const LOAD_CROSSOVER_HZ: [f64; 3] = [40.0; 3];
const DISPLACEMENT_CROSSOVER_HZ: [f64; 3] = [40.0, 100.0, 100.0];
const CURRENT_LIMIT_A: f64 = 2.5;
const CURRENT_ROLLOFF_HZ: f64 = 3000.0;
const CURRENT_ROLLOFF_RATIO: f64 = 10.0;
const SENSOR_NOISE_M: f64 = 0.2e-6;

/// Weights from a path or a shipped name.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn load_weights(source: &str) -> Result<Weights, InputError> {
    read_weights(source, &shipped::text(source, "weights", WEIGHTS)?)
}

/// Weights from the text of a file; `file` names it in messages.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn read_weights(file: &str, text: &str) -> Result<Weights, InputError> {
    let mut errors = ErrorList::new(file, text);
    let weights = yaml::read(&mut errors, keys::WEIGHTS).map(|read| weights(&mut errors, read));
    errors.finish(weights)
}

/// Adds an error for every number that breaks a rule of its own.
fn check_numbers(errors: &mut ErrorList<'_>, read: &WeightsFile) {
    let mut refuse = |rule: String, hint: &str| {
        errors.add_rule(InputError::new(errors.file, rule).with_hint(hint));
    };
    if let Some(ratio) = read.current_rolloff_ratio.filter(|ratio| !(ratio.is_finite() && *ratio > 1.0)) {
        refuse(format!("current_rolloff_ratio: {ratio} must be greater than 1"), "10 is a decade of roll-off");
    }
    if let Some(shift) = read.mode_shift.filter(|shift| shift.is_nan() || *shift < 0.0) {
        refuse(format!("mode_shift: {shift} must be at least 0"), "0.03 is 3 % up and down; 0 asks for none");
    }
    for (i, r) in read.mode_uncertainty.iter().enumerate().filter(|(_, r)| !(0.0..1.0).contains(*r)) {
        let rule = format!("mode_uncertainty[{i}]: {r} must be at least 0 and below 1");
        refuse(rule, "0.01 means one per cent of the natural frequency");
    }
}

/// The weights of a file; what its values break is added to the errors.
fn weights(errors: &mut ErrorList<'_>, read: WeightsFile) -> Weights {
    check_numbers(errors, &read);
    let limits = |l: &LimitsFile| Limits {
        max_dc_load_n: l.max_dc_load_n,
        max_hf_load_n: l.max_hf_load_n,
        max_dc_displacement_m: l.max_dc_displacement_m,
        max_hf_displacement_m: l.max_hf_displacement_m,
    };
    let each = |pick: fn(&LimitsFile) -> Option<f64>, default: [f64; 3]| {
        let places = [&read.tool, &read.front, &read.rear];
        [0, 1, 2].map(|i: usize| pick(places[i]).unwrap_or(default[i]))
    };
    let open = match read.defaults {
        Defaults::Table => vec![],
        Defaults::Machine => left_out(&read),
    };
    let uncertainty = uncertainty(errors, &read.uncertainty, &read.over_frequency);
    let curves = read.over_frequency.weights(errors);
    check_floors(errors, &read.tool_stiffness);
    Weights {
        uncertainty,
        curves,
        mode_shift: read.mode_shift.unwrap_or(MODE_SHIFT),
        least_decay_per_s: read.least_decay_per_s,
        tool_stiffness: read.tool_stiffness,
        open,
        tool: limits(&read.tool),
        front: limits(&read.front),
        rear: limits(&read.rear),
        load_crossover_hz: each(|l| l.load_crossover_hz, LOAD_CROSSOVER_HZ),
        displacement_crossover_hz: each(|l| l.displacement_crossover_hz, DISPLACEMENT_CROSSOVER_HZ),
        current_limit_a: read.current_limit_a.unwrap_or(CURRENT_LIMIT_A),
        current_rolloff_hz: read.current_rolloff_hz.unwrap_or(CURRENT_ROLLOFF_HZ),
        current_rolloff_ratio: read.current_rolloff_ratio.unwrap_or(CURRENT_ROLLOFF_RATIO),
        sensor_noise_m: read.sensor_noise_m.unwrap_or(SENSOR_NOISE_M),
        complementary_sensitivity_limit: read.complementary_sensitivity_limit,
        integral_corner_hz: read.integral_corner_hz,
        tool_tightening: read.tool_tightening.unwrap_or(1.0),
        mode_uncertainty: read.mode_uncertainty,
        name: read.name,
    }
}

fn check_floors(errors: &mut ErrorList<'_>, floors: &[StiffnessFloor]) {
    for (i, band) in floors.iter().enumerate() {
        if band.from_hz > band.to_hz {
            let rule = format!("tool_stiffness[{i}].to_hz: {} lies below from_hz: {}", band.to_hz, band.from_hz);
            errors.add_rule(InputError::new(errors.file, rule).with_hint("a single frequency is written twice"));
        }
    }
}

/// What a file leaves out.
fn left_out(read: &WeightsFile) -> Vec<FreeQuantity> {
    let mut open = vec![];
    for (place, limits) in [&read.tool, &read.front, &read.rear].into_iter().enumerate() {
        if limits.load_crossover_hz.is_none() {
            open.push(FreeQuantity::LoadCrossover(place));
        }
        if limits.displacement_crossover_hz.is_none() {
            open.push(FreeQuantity::DisplacementCrossover(place));
        }
    }
    let levels = [
        (read.current_limit_a, FreeQuantity::CurrentLimit),
        (read.current_rolloff_hz, FreeQuantity::CurrentRolloff),
        (read.sensor_noise_m, FreeQuantity::SensorNoise),
    ];
    open.extend(levels.into_iter().filter(|(v, _)| v.is_none()).map(|(_, q)| q));
    open
}
