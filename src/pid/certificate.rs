//! Figures of a PID on the full plant, sampled with true delay, by which its tuning is judged.
//!
//! Stability: eigenvalues of the sampled loop, nominal at every speed checked, and with shifted modes
//! ([`super::shifted_loops`]). Sensitivity and noise: `controller::full_loop`, which cannot miss a peak
//! between lines. Stiffness: on lines that are dense round every closed-loop pole, refined at the lowest minimum; the
//! force at the tool is continuous, without a hold.

use super::parameters::{PidParameters, pid_controller};
use super::settings::TuneSettings;
use super::shifted_loops::{SHIFTED_MODES, SHIFTED_SPEEDS, ShiftedLoops, shifted_loops, with_shifted_modes};
use crate::controller::amplifier_demand::{high_frequency_gain, high_frequency_hz};
use crate::controller::full_loop::FullLoop;
use crate::controller::polish::responses::ShiftedRotor;
use crate::controller::verification::{Verification, verify, verify_at};
use crate::controller::verification_error::VerificationError;
use crate::controller::{ControlLaw, Controller, ControllerError, in_step};
use crate::linalg::c64;
use crate::lti::held::closed_response;
use crate::lti::line_maximum::LineMaximum;
use crate::lti::norm::{HinfNorm, NormError};
use crate::lti::{Discrete, FrequencyGrid, FrequencyResponder, StateSpace};
use crate::spindle::plant::AXES;
use crate::spindle::{Machine, Plant};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// End of zone B of ISO 14839-3, dB: a sensitivity of four.
pub const ZONE_B_DB: f64 = 12.041_199_826_559_248;
/// Relative tolerance of a sensitivity peak: 0.0009 dB, twice that by level sets.
const PEAK_TOLERANCE: f64 = 1e-4;

/// A certified sensitivity peak of a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeakSensitivity {
    /// |S_jj| attained, dB; infinite for an unstable loop.
    pub db: f64,
    /// Level that no frequency reaches, dB.
    pub upper_db: f64,
    /// Where, Hz.
    pub frequency_hz: f64,
}

/// Figures of a PID on the full plant.
#[derive(Clone, Debug, PartialEq)]
pub struct PidCertificate {
    /// Stability over the speeds, nominal.
    pub nominal: Verification,
    /// Stability at standstill, half and largest speed with every flexible frequency of the shaft lowered.
    pub lowered: Verification,
    /// The same with every flexible frequency raised.
    pub raised: Verification,
    /// Stability with modes shifted alone and in combinations.
    pub shifted: ShiftedLoops,
    /// Peak of |S| at standstill per bearing (front, rear).
    pub sensitivity: [PeakSensitivity; 2],
    /// The same at the largest speed.
    pub sensitivity_at_speed: [PeakSensitivity; 2],
    /// Smallest dynamic stiffness of the tool at standstill over the stiffness band, N/m; not a number for an unstable
    /// loop.
    pub stiffness_n_per_m: f64,
    /// Where, Hz.
    pub stiffness_hz: f64,
    /// The same at the largest speed, N/m.
    pub stiffness_at_speed_n_per_m: f64,
    /// Largest rms current from sensor noise, A.
    pub noise_current_a: f64,
    /// Largest singular value of the controller above the modes of the model, A/m.
    pub high_frequency_gain_a_per_m: f64,
    /// From here on that gain counts, Hz.
    pub high_frequency_hz: f64,
    /// Parameter sets judged.
    pub evaluations: usize,
}

/// A PID with its proof.
#[derive(Clone, Debug)]
pub struct TunedPid {
    /// Parameters.
    pub parameters: PidParameters,
    /// As it runs: sampled, u = K y.
    pub controller: Controller,
    /// Figures on the full plant.
    pub certificate: PidCertificate,
}

impl PidCertificate {
    /// True when the loop is stable at every speed checked, nominal and with shifted modes.
    pub fn is_stable(&self) -> bool {
        self.shifted.worst_growth_rate_per_s < 0.0
            && [&self.nominal, &self.lowered, &self.raised].iter().all(|v| v.is_stable())
    }

    /// Largest sensitivity that no frequency exceeds, over bearings, at standstill and largest speed, dB.
    pub fn sensitivity_peak_db(&self) -> f64 {
        highest(self.sensitivity.iter().chain(&self.sensitivity_at_speed))
    }

    /// True when stability, zone B, noise and gain are all within what was asked.
    pub fn meets(&self, settings: &TuneSettings) -> bool {
        self.judge_figures().violation(settings) == 0.0
    }

    /// Rotors with shifted modes whose loop is unstable: one with all modes lowered, one with all raised, and the one
    /// that grows most of the others.
    pub(super) fn unstable_loops(&self) -> Vec<ShiftedRotor> {
        let (r, shifted) = (self.shifted.shift, &self.shifted);
        let rotor = |speed_rpm: f64, factors: Vec<f64>| ShiftedRotor { speed_rad_s: speed_rpm * TAU / 60.0, factors };
        let all = [(&self.lowered, 1.0 - r), (&self.raised, 1.0 + r)];
        let first = all.into_iter().filter_map(|(seen, factor)| {
            let check = seen.first_unstable()?;
            Some(rotor(check.speed_rpm, vec![factor; SHIFTED_MODES]))
        });
        let mut loops: Vec<ShiftedRotor> = first.collect();
        if shifted.worst_growth_rate_per_s >= 0.0 {
            loops.push(rotor(shifted.worst_speed_rpm, shifted.worst_factors.clone()));
        }
        loops
    }

    pub(crate) fn judge_figures(&self) -> JudgedFigures {
        JudgedFigures {
            stable: self.is_stable(),
            sensitivity_peak_db: self.sensitivity_peak_db(),
            noise_current_a: self.noise_current_a,
            high_frequency_gain_a_per_m: self.high_frequency_gain_a_per_m,
        }
    }
}

/// Largest level that no frequency reaches, dB.
fn highest<'a>(peaks: impl Iterator<Item = &'a PeakSensitivity>) -> f64 {
    peaks.map(|p| p.upper_db).fold(f64::NEG_INFINITY, f64::max)
}

/// The figures that the settings of a tuning limit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JudgedFigures {
    /// At every speed that was checked, and with every shift if those were.
    pub stable: bool,
    /// Largest sensitivity, dB.
    pub sensitivity_peak_db: f64,
    /// Largest rms current from sensor noise, A.
    pub noise_current_a: f64,
    /// Largest singular value of the controller above the modes of the model, A/m.
    pub high_frequency_gain_a_per_m: f64,
}

impl JudgedFigures {
    /// How far the figures are outside what was asked: zero inside; an unstable loop counts most.
    pub(crate) fn violation(&self, settings: &TuneSettings) -> f64 {
        let over = |value: f64, limit: f64| (value - limit).max(0.0);
        let stable = if self.stable { 0.0 } else { 1e3 };
        stable
            + over(self.sensitivity_peak_db, ZONE_B_DB).min(1e2)
            + 10.0 * over(self.noise_current_a / settings.noise_current_a, 1.0)
            + 10.0 * over(self.high_frequency_gain_a_per_m / settings.high_frequency_gain_a_per_m, 1.0)
    }

    /// What is outside of what was asked, with the limit.
    pub(crate) fn exceeded(&self, settings: &TuneSettings) -> Vec<String> {
        let stable = (!self.stable).then(|| {
            let percent = 100.0 * settings.mode_shift;
            format!("the loop is unstable with natural frequencies shifted by {percent:.1} %")
        });
        let gain = [self.high_frequency_gain_a_per_m, settings.high_frequency_gain_a_per_m];
        let figures = [
            ("sensitivity", [self.sensitivity_peak_db, ZONE_B_DB], "dB"),
            ("noise current", [self.noise_current_a, settings.noise_current_a].map(|a| 1e3 * a), "mA"),
            ("gain above the modes", gain.map(|g| 1e-6 * g), "A/µm"),
        ];
        let above = figures.into_iter().filter(|(_, [value, limit], _)| value > limit);
        let above = above.map(|(what, [value, limit], unit)| format!("the {what} is {value:.3} {unit} of {limit:.3}"));
        stable.into_iter().chain(above).collect()
    }
}

/// Figures of a PID on the full plant but for the loops with shifted modes, which take most of the time.
pub(super) struct PidFigures {
    parameters: PidParameters,
    name: String,
    law: StateSpace<Discrete>,
    nominal: Verification,
    rest: FullFigures,
    fast: FullFigures,
    high_frequency_gain_a_per_m: f64,
    high_frequency_hz: f64,
}

impl PidFigures {
    /// The PID of these parameters.
    pub(super) fn new(
        machine: &Machine,
        parameters: PidParameters,
        settings: &TuneSettings,
        name: &str,
    ) -> Result<Self, VerificationError> {
        let period = machine.spindle.electronics.sample_period_s();
        let Controller { name, law } = pid_controller(&parameters, period, name)?;
        let ControlLaw::Discrete(law) = law else {
            return Err(ControllerError::Infeasible {
                step: "PID",
                reason: "it was not sampled".to_owned(),
                advice: "check the sample rate of the spindle",
            }
            .into());
        };
        let nominal = verify(machine, &law, settings.speeds, "full plant, sampled")?;
        let stable = nominal.is_stable();
        let fastest = machine.spindle.max_rpm * TAU / 60.0;
        let (rest, fast) =
            rayon::join(|| full_figures(machine, &law, 0.0, stable), || full_figures(machine, &law, fastest, stable));
        let (rest, fast) = (rest?, fast?);
        let high_frequency_hz = high_frequency_hz(machine)?;
        let gain = high_frequency_gain(&law, high_frequency_hz);
        Ok(Self {
            parameters,
            law,
            nominal,
            rest,
            fast,
            high_frequency_gain_a_per_m: gain.map_err(in_step("gain of the PID"))?,
            high_frequency_hz,
            name,
        })
    }

    /// Smallest dynamic stiffness of the tool at standstill, N/m.
    pub(super) fn stiffness_n_per_m(&self) -> f64 {
        self.rest.stiffness.0
    }

    /// The first loop of the machine as it is that is unstable.
    pub(super) fn unstable_loop(&self) -> Option<ShiftedRotor> {
        let check = self.nominal.first_unstable()?;
        Some(ShiftedRotor { speed_rad_s: check.speed_rpm * TAU / 60.0, factors: vec![] })
    }

    pub(super) fn judge_figures(&self) -> JudgedFigures {
        let peaks = self.rest.sensitivity.iter().chain(&self.fast.sensitivity);
        JudgedFigures {
            stable: self.nominal.is_stable(),
            sensitivity_peak_db: highest(peaks),
            noise_current_a: self.rest.noise_current_a.max(self.fast.noise_current_a),
            high_frequency_gain_a_per_m: self.high_frequency_gain_a_per_m,
        }
    }

    /// The PID with its whole certificate, loops with shifted modes included.
    pub(super) fn certify_pid(
        self,
        machine: &Machine,
        settings: &TuneSettings,
        evaluations: usize,
    ) -> Result<TunedPid, VerificationError> {
        let law = &self.law;
        let judged = self.judge_figures();
        // With shifted modes nothing is learnt of a loop that is unstable as it is.
        let is_stable = self.nominal.is_stable();
        let whole = |factor: f64, words: &str| {
            if is_stable {
                let shifted = with_shifted_modes(machine, factor);
                verify(&shifted, law, SHIFTED_SPEEDS, words)
            } else {
                verify_at(machine, law, &[], words)
            }
        };
        let lowered = whole(1.0 - settings.mode_shift, "full plant, all modes lowered")?;
        let raised = whole(1.0 + settings.mode_shift, "full plant, all modes raised")?;
        let shifted =
            if is_stable { shifted_loops(machine, law, settings)? } else { ShiftedLoops::none(settings.mode_shift) };
        Ok(TunedPid {
            certificate: PidCertificate {
                lowered,
                raised,
                shifted,
                nominal: self.nominal,
                sensitivity: self.rest.sensitivity,
                sensitivity_at_speed: self.fast.sensitivity,
                stiffness_n_per_m: self.rest.stiffness.0,
                stiffness_hz: self.rest.stiffness.1,
                stiffness_at_speed_n_per_m: self.fast.stiffness.0,
                noise_current_a: judged.noise_current_a,
                high_frequency_gain_a_per_m: judged.high_frequency_gain_a_per_m,
                high_frequency_hz: self.high_frequency_hz,
                evaluations,
            },
            parameters: self.parameters,
            controller: Controller { name: self.name, law: ControlLaw::Discrete(self.law) },
        })
    }
}

/// The PID of these parameters with its figures on the full plant.
///
/// # Errors
/// [`VerificationError`] from the plants, the eigenvalues or the norms.
pub fn certify(
    machine: &Machine,
    parameters: PidParameters,
    settings: &TuneSettings,
    evaluations: usize,
    name: &str,
) -> Result<TunedPid, VerificationError> {
    PidFigures::new(machine, parameters, settings, name)?.certify_pid(machine, settings, evaluations)
}

struct FullFigures {
    sensitivity: [PeakSensitivity; 2],
    noise_current_a: f64,
    stiffness: (f64, f64),
}

/// Sensitivity peaks, noise current and smallest tool stiffness on the full plant at one speed; no stiffness of an
/// unstable loop.
fn full_figures(
    machine: &Machine,
    law: &StateSpace<Discrete>,
    speed_rad_s: f64,
    stable: bool,
) -> Result<FullFigures, VerificationError> {
    if !stable {
        return Ok(FullFigures {
            sensitivity: [UNBOUNDED; 2],
            noise_current_a: f64::INFINITY,
            stiffness: (f64::NAN, f64::NAN),
        });
    }
    let full = FullLoop::new(machine, law, speed_rad_s)?;
    let numeric = in_step("PID on the full plant");
    let poles = full.poles().map_err(&numeric)?;
    let peaks: Result<Vec<PeakSensitivity>, VerificationError> = [0, 1]
        .into_par_iter()
        .map(|j| match full.sensitivity_peak(j, &poles, PEAK_TOLERANCE) {
            Ok(found) => Ok(peak(&found)),
            Err(NormError::Unstable { .. }) => Ok(UNBOUNDED),
            Err(NormError::Numeric(e)) => Err(in_step("sensitivity peak of the PID")(e).into()),
        })
        .collect();
    let peaks = peaks?;
    let noise = full.noise_gain().map_err(&numeric)?;
    Ok(FullFigures {
        sensitivity: [0, 1].map(|j| peaks.get(j).copied().unwrap_or(UNBOUNDED)),
        noise_current_a: noise * machine.spindle.electronics.sensor_noise_m,
        stiffness: softest(
            &full.plant,
            law,
            poles,
            machine.spindle.stiffness_band_hz.0,
            machine.spindle.stiffness_band_hz.1,
        ),
    })
}

const UNBOUNDED: PeakSensitivity =
    PeakSensitivity { db: f64::INFINITY, upper_db: f64::INFINITY, frequency_hz: f64::NAN };

fn peak(found: &HinfNorm) -> PeakSensitivity {
    PeakSensitivity {
        db: decibel(found.norm),
        upper_db: decibel(found.upper),
        frequency_hz: found.peak_omega_rad_s / TAU,
    }
}

/// Smallest tool stiffness in the band, N/m, and its frequency, Hz: the force at the tool acts continuously, only the
/// currents go through the hold. The poles of the sampled loop, points of the z plane, say where to look.
pub fn softest(plant: &Plant, law: &StateSpace<Discrete>, poles: Vec<c64>, from_hz: f64, to_hz: f64) -> (f64, f64) {
    let poles = law.time.continuous_poles(poles);
    let grid = FrequencyGrid::log_hz(from_hz, to_hz.min(0.49 / law.time.period_s), 300).refine_round_poles(&poles, 12);
    let responder = FrequencyResponder::new(law);
    let stiffness = |omega: f64| closed_response(plant, &responder, AXES, omega)[(0, 0)].norm().recip();
    let lines = grid.omega_rad_s();
    let values: Vec<f64> = lines.par_iter().map(|w| stiffness(*w)).collect();
    let Some(k) = (0..values.len()).reduce(|a, b| if values[b] < values[a] { b } else { a }) else {
        return (f64::NAN, f64::NAN);
    };
    let point = |k: usize| (lines[k], -values[k]);
    let (below, above) = (k.saturating_sub(1), (k + 1).min(lines.len() - 1));
    // The value is quadratic in what is left of the place.
    let tolerance = PLACE * (lines[above] - lines[below]);
    let mut search = LineMaximum::new([point(below), point(k), point(above)], tolerance);
    while let Some(omega) = search.next() {
        search.add(omega, -stiffness(omega));
    }
    let (omega, largest) = search.best();
    (-largest, omega / TAU)
}

/// Tolerance of the place of the smallest stiffness, as a share of the distance of the lines beside it.
const PLACE: f64 = 1e-5;

fn decibel(x: f64) -> f64 {
    20.0 * x.log10()
}
