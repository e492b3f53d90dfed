//! Automatic tuning of the PID: largest minimum of the tool's dynamic stiffness, subject to stability from standstill
//! to 1.2 times the largest speed with shifted modes, a sensitivity peak within ISO 14839-3 zone B, and limits on the noise
//! current and on the gain above the band.
//! Search: [`super::pid_search`], starts from the machine's own dynamics and descent with exact derivatives. The result is judged
//! on the full plant ([`super::pid_certificate`]); where that finds a limit exceeded, the search goes on from there with the
//! limit lowered by as much.

use super::amplifier_demand::AmplifierDemand;
use super::amplifier_demand::high_frequency_hz;
use super::pid::{PER_AXIS, PidParameters, textbook_gains};
use super::pid_certificate::{BAND_HZ, PidCertificate, ZONE_B_DB, certify};
use super::pid_search::{PidSearch, search};
use super::polish::LoopLimits;
use super::verification::VerificationError;
use super::{Controller, ControllerError};
use crate::spindle::Machine;

/// Requirements and effort of a tuning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TuneSettings {
    /// Sensitivity peak aimed at, dB; zone B ends at 12 dB.
    pub sensitivity_db: f64,
    /// Relative shift of the flexible frequencies, both ways, that the loop must survive.
    pub mode_shift: f64,
    /// Largest rms current from sensor noise, A.
    pub noise_current_a: f64,
    /// Largest singular value of the controller above the modes of the model, A/m.
    pub high_frequency_gain_a_per_m: f64,
    /// Starts drawn from the machine's own dynamics and screened.
    pub starts: usize,
    /// Starts descended; the best goes to the end.
    pub basins: usize,
    /// Steps of the descent from the best of them at most.
    pub steps: usize,
    /// Seed of the starts.
    pub seed: u64,
    /// Speeds at which the full plant is checked, from 0 to the largest.
    pub speeds: usize,
}

impl TuneSettings {
    /// For a whole run: a few seconds.
    pub fn quick() -> Self {
        Self {
            // A quarter of a decibel below the end of zone B: peaks between the lines of the search.
            sensitivity_db: 11.8,
            mode_shift: 0.03,
            noise_current_a: 0.1,
            // Without a delivered controller to be held to: a micrometre of noise or of an unknown mode above those of the
            // model asks for two amperes at most.
            high_frequency_gain_a_per_m: 2.0e6,
            starts: 3000,
            basins: 3,
            steps: 120,
            seed: 1,
            speeds: 6,
        }
    }

    /// The same search with the amplifier limits of a delivered controller, so that neither is held shorter than the other.
    /// Where its loop is unstable and has no noise current, the limit stays.
    #[must_use]
    pub fn held_to(self, demand: &AmplifierDemand) -> Self {
        let noise = demand.noise_current_a;
        Self {
            high_frequency_gain_a_per_m: demand.high_frequency_gain_a_per_m,
            noise_current_a: if noise.is_finite() {
                noise
            } else {
                self.noise_current_a
            },
            ..self
        }
    }

    /// More starts and more steps: a quarter of a minute.
    pub fn thorough() -> Self {
        Self {
            starts: 12_000,
            basins: 8,
            steps: 200,
            speeds: 11,
            ..Self::quick()
        }
    }
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

/// Tunes a PID for tool stiffness. `progress` gets the number of the attempt and the stiffness certified, N/m.
///
/// # Errors
/// [`ControllerError::Infeasible`] when no stabilising PID is found, and failures of the plant or the eigenvalues.
pub fn tune(
    machine: &Machine,
    settings: &TuneSettings,
    progress: &mut dyn FnMut(usize, f64),
) -> Result<TunedPid, VerificationError> {
    let mut goal = *settings;
    let free: Vec<usize> = (0..2 * PER_AXIS).collect();
    let mut given: Vec<PidParameters> = vec![];
    let mut evaluations = 0;
    let mut best: Option<TunedPid> = None;
    for attempt in 0..=REPAIRS {
        let asked = asked(machine, &goal, BAND_HZ)?;
        let found = match search(machine, &asked, &given, &Some, &free) {
            Ok(found) => found,
            // A repair that fails leaves what was found before it.
            Err(_) if best.is_some() => break,
            Err(error) => return Err(error),
        };
        evaluations += found.evaluations;
        let tuned = certify(machine, found.parameters, settings, evaluations, "PID")?;
        let certified = &tuned.certificate;
        progress(attempt, certified.stiffness_n_per_m);
        let meets = certified.meets(settings);
        lower(&mut goal, settings, certified);
        given = vec![tuned.parameters];
        (goal.starts, goal.basins) = (0, 1);
        let better =
            |old: &TunedPid| certified.violation(settings) < old.certificate.violation(settings);
        if meets || best.as_ref().is_none_or(better) {
            best = Some(tuned);
        }
        if meets {
            break;
        }
    }
    best.ok_or_else(|| nothing_found("no attempt was made".to_owned()).into())
}

/// Times the search is taken up again when the full plant shows what its lines did not.
const REPAIRS: usize = 3;

/// Takes off the limits what the lines of the search did not see, with a little to spare.
fn lower(goal: &mut TuneSettings, settings: &TuneSettings, found: &PidCertificate) {
    let over = |value: f64, limit: f64| (value - limit).max(0.0) * 1.2;
    let seen = found.sensitivity_peak_db();
    if seen >= ZONE_B_DB {
        goal.sensitivity_db -= (over(seen, ZONE_B_DB) + 0.1).min(3.0);
    }
    if found.noise_current_a > settings.noise_current_a {
        let lowered = goal.noise_current_a - over(found.noise_current_a, settings.noise_current_a);
        goal.noise_current_a = lowered.max(0.5 * goal.noise_current_a);
    }
    let gain = found.high_frequency_gain_a_per_m;
    if gain > settings.high_frequency_gain_a_per_m {
        let lowered =
            goal.high_frequency_gain_a_per_m - over(gain, settings.high_frequency_gain_a_per_m);
        goal.high_frequency_gain_a_per_m = lowered.max(0.5 * goal.high_frequency_gain_a_per_m);
    }
    if !found.is_stable() {
        goal.mode_shift *= 1.3;
    }
}

/// The search for these settings; `band_hz` is that of the tool's stiffness.
fn asked(
    machine: &Machine,
    settings: &TuneSettings,
    band_hz: (f64, f64),
) -> Result<PidSearch, VerificationError> {
    let electronics = &machine.spindle.electronics;
    Ok(PidSearch {
        limits: LoopLimits {
            stiffness_band_hz: band_hz,
            sensitivity: 10f64.powf(settings.sensitivity_db / 20.0),
            // With shifted modes the loop may leave zone B, but keeps a margin: 4 dB.
            shifted_sensitivity: 10f64.powf(4.0 / 20.0),
            high_frequency_hz: high_frequency_hz(machine)?,
            high_frequency_gain_a_per_m: settings.high_frequency_gain_a_per_m,
            sensor_noise_m: electronics.sensor_noise_m,
            noise_current_a: settings.noise_current_a,
            mu: 1.0,
        },
        mode_shift: settings.mode_shift,
        starts: settings.starts,
        basins: settings.basins,
        steps: settings.steps,
        seed: settings.seed,
    })
}

/// The textbook PID made to levitate: gains from [`textbook_gains`] and untouched, only corner frequencies and biquads
/// moved, for the smallest sensitivity; nothing is tuned for the tool.
///
/// # Errors
/// As [`tune`].
pub fn textbook(machine: &Machine, settings: &TuneSettings) -> Result<TunedPid, VerificationError> {
    let gains = textbook_gains(machine)?;
    let shape = |mut p: PidParameters| {
        for (axis, fixed) in [(&mut p.front, gains.front), (&mut p.rear, gains.rear)] {
            axis.gain_a_per_m = fixed.gain_a_per_m;
            axis.integral_rad_s = fixed.integral_rad_s;
            axis.derivative_s = fixed.derivative_s;
        }
        Some(p)
    };
    let free: Vec<usize> = (0..2 * PER_AXIS)
        .filter(|k| k % PER_AXIS >= FIXED_BY_TEXTBOOK)
        .collect();
    let mut asked = asked(machine, settings, NO_BAND)?;
    // A limit of 0 dB is never met: the search ends at the smallest peak it finds.
    asked.limits.sensitivity = 1.0;
    let found = search(machine, &asked, &[gains], &shape, &free)?;
    certify(
        machine,
        found.parameters,
        settings,
        found.evaluations,
        "textbook PID",
    )
}

/// Gain, integral and derivative time come first in the vector form.
const FIXED_BY_TEXTBOOK: usize = 3;
/// No stiffness of the tool takes part.
const NO_BAND: (f64, f64) = (0.0, 0.0);

/// A PID, or the reason why none was found; other failures stay errors.
///
/// # Errors
/// [`VerificationError`] from plants and eigenvalues.
pub fn found_or_reason(
    result: Result<TunedPid, VerificationError>,
) -> Result<Result<TunedPid, String>, VerificationError> {
    match result {
        Ok(pid) => Ok(Ok(pid)),
        Err(VerificationError::Loop(error @ ControllerError::Infeasible { .. })) => {
            Ok(Err(error.to_string()))
        }
        Err(error) => Err(error),
    }
}

fn nothing_found(reason: String) -> ControllerError {
    ControllerError::Infeasible {
        step: "PID tuning",
        reason,
        advice: "check delay, bandwidths and sensor planes of the spindle",
    }
}

pub(super) fn decibel(x: f64) -> f64 {
    20.0 * x.log10()
}
