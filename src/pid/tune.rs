//! Automatic tuning of the PID: largest minimum of the tool's dynamic stiffness, subject to stability from standstill
//! to 1.2 times the largest speed with shifted modes, a sensitivity peak within ISO 14839-3 zone B, and limits on the
//! noise current and on the gain above the band.
//! Search: `search`, starts from the machine's own dynamics and descent with exact derivatives. The result is
//! judged on the full plant ([`crate::pid::certificate`]); where that finds a limit exceeded, the search goes on from
//! there with the limit lowered by as much.

use super::certificate::{JudgedFigures, PidFigures, TunedPid, ZONE_B_DB, certify};
use super::parameters::{PER_AXIS, PidParameters, textbook_gains};
use super::search::{PidSearch, search};
use super::settings::TuneSettings;
use crate::controller::ControllerError;
use crate::controller::amplifier_demand::high_frequency_hz;
use crate::controller::polish::LoopLimits;
use crate::controller::polish::responses::ShiftedRotor;
use crate::controller::verification_error::VerificationError;
use crate::spindle::Machine;

/// Tunes a PID for tool stiffness: the best of the searches asked for. `progress` gets the number of the attempt of a
/// search and the stiffness certified, N/m.
///
/// # Errors
/// [`ControllerError::Infeasible`] when no search finds a stabilising PID, and failures of the plant or the
/// eigenvalues.
pub fn tune(
    machine: &Machine,
    settings: &TuneSettings,
    progress: &mut dyn FnMut(usize, f64),
) -> Result<TunedPid, VerificationError> {
    let first = search_pid(machine, settings, None, progress);
    with_further_searches(first, machine, settings, progress)
}

/// As [`tune`], but the first search goes on from the PID that another one with the same seed found for this machine
/// under other limits. Where that ends outside these limits, it begins as any other.
///
/// # Errors
/// As [`tune`].
pub fn tune_from(
    start: &PidParameters,
    machine: &Machine,
    settings: &TuneSettings,
    progress: &mut dyn FnMut(usize, f64),
) -> Result<TunedPid, VerificationError> {
    let mut first = search_pid(machine, settings, Some(start), progress);
    if !matches!(&first, Ok(pid) if pid.certificate.meets(settings)) {
        let anew = || search_pid(machine, settings, None, progress);
        first = best_of(first, anew, settings);
    }
    with_further_searches(first, machine, settings, progress)
}

/// The best of a first search and the others asked for.
fn with_further_searches(
    first: Result<TunedPid, VerificationError>,
    machine: &Machine,
    settings: &TuneSettings,
    progress: &mut dyn FnMut(usize, f64),
) -> Result<TunedPid, VerificationError> {
    (1..settings.searches as u64).fold(first, |found, number| {
        let seed = settings.seed.wrapping_add(number);
        let settings = TuneSettings { seed, ..*settings };
        let next = || search_pid(machine, &settings, None, progress);
        best_of(found, next, &settings)
    })
}

/// The better of what two searches find. One without a stabilising PID leaves what the other finds; any other failure
/// ends both.
fn best_of(
    earlier: Result<TunedPid, VerificationError>,
    later: impl FnOnce() -> Result<TunedPid, VerificationError>,
    settings: &TuneSettings,
) -> Result<TunedPid, VerificationError> {
    let earlier = match earlier {
        Err(error) if !is_infeasible(&error) => return Err(error),
        earlier => earlier,
    };
    match (earlier, later()) {
        (Ok(earlier), Ok(later)) => Ok(better(earlier, later, settings)),
        (found, Err(error)) if is_infeasible(&error) => found,
        (Err(_), Ok(pid)) => Ok(pid),
        (_, Err(error)) => Err(error),
    }
}

/// One search from the seed of the settings, or from a PID.
fn search_pid(
    machine: &Machine,
    settings: &TuneSettings,
    start: Option<&PidParameters>,
    progress: &mut dyn FnMut(usize, f64),
) -> Result<TunedPid, VerificationError> {
    let first = TuneSettings {
        noise_current_a: NOISE_OF_LINES * settings.noise_current_a,
        high_frequency_gain_a_per_m: GAIN_OF_LINES * settings.high_frequency_gain_a_per_m,
        ..*settings
    };
    let mut goal = first;
    let free: Vec<usize> = (0..2 * PER_AXIS).collect();
    let mut given: Vec<PidParameters> = start.into_iter().copied().collect();
    if start.is_some() {
        (goal.starts, goal.basins) = ONE_START;
    }
    // Loops that were found unstable.
    let mut unstable: Vec<ShiftedRotor> = vec![];
    let mut evaluations = 0;
    let mut best: Option<TunedPid> = None;
    // What exceeds a limit without shifted modes: it is certified if nothing better is found.
    let mut set_aside: Option<(f64, PidFigures, usize)> = None;
    let (mut repairs, mut renewals) = (0, 0);
    for attempt in 0.. {
        let asked = set_up_search(machine, &goal, machine.spindle.stiffness_band_hz)?;
        let found = match search(machine, &asked, &unstable, &given, &Some, &free) {
            Ok(found) => found,
            // A repair that fails leaves what was found before it.
            Err(_) if best.is_some() || set_aside.is_some() => break,
            Err(error) => return Err(error),
        };
        evaluations += found.evaluations;
        given = vec![found.parameters];
        (goal.starts, goal.basins) = ONE_START;
        let figures = PidFigures::new(machine, found.parameters, settings, "PID")?;
        progress(attempt, figures.stiffness_n_per_m());
        let judged = figures.judge_figures();
        let violation = judged.violation(settings);
        let (judged, unstable_loops) = if violation > 0.0 {
            let unstable_loops = figures.unstable_loop().into_iter().collect();
            let least = set_aside.as_ref().map(|(least, ..)| *least);
            if least.is_none_or(|least| violation < least) {
                set_aside = Some((violation, figures, evaluations));
            }
            (judged, unstable_loops)
        } else {
            let tuned = figures.certify_pid(machine, settings, evaluations)?;
            if tuned.certificate.meets(settings) {
                return Ok(tuned);
            }
            let certificate = &tuned.certificate;
            let seen = (certificate.judge_figures(), certificate.unstable_loops());
            best = Some(nearer(best, tuned, settings));
            seen
        };
        if judged.stable {
            repairs += 1;
            lower(&mut goal, settings, &judged);
        } else {
            renewals += 1;
            // A loop that is unstable does not count in a descent, so that a descent from here would leave it so: the
            // search begins again and sees it from the start.
            unstable.extend(unstable_loops);
            (goal, repairs) = (first, 0);
        }
        if repairs > REPAIRS || renewals > RENEWALS {
            break;
        }
    }
    let beaten = |least: f64| {
        let best = best.as_ref();
        best.is_none_or(|pid| least < pid.certificate.judge_figures().violation(settings))
    };
    if let Some((_, figures, evaluations)) = set_aside.filter(|(least, ..)| beaten(*least)) {
        let tuned = figures.certify_pid(machine, settings, evaluations)?;
        best = Some(nearer(best, tuned, settings));
    }
    best.ok_or_else(|| nothing_found("no attempt was made".to_owned()).into())
}

/// Of two PIDs the one that is less far outside what was asked, the earlier of equal ones.
fn nearer(earlier: Option<TunedPid>, later: TunedPid, settings: &TuneSettings) -> TunedPid {
    let violation = |pid: &TunedPid| pid.certificate.judge_figures().violation(settings);
    match earlier {
        Some(earlier) if violation(&earlier) <= violation(&later) => earlier,
        _ => later,
    }
}

/// Of two PIDs that are equally far outside what was asked, or within it, the stiffer one.
fn better(earlier: TunedPid, later: TunedPid, settings: &TuneSettings) -> TunedPid {
    let violation = |pid: &TunedPid| pid.certificate.judge_figures().violation(settings);
    let stiffness = |pid: &TunedPid| {
        let at_speed = pid.certificate.stiffness_at_speed_n_per_m;
        pid.certificate.stiffness_n_per_m.min(at_speed)
    };
    if violation(&earlier) == violation(&later) && stiffness(&later) > stiffness(&earlier) {
        later
    } else {
        nearer(Some(earlier), later, settings)
    }
}

/// Starts drawn and basins of a search that goes on from a PID.
const ONE_START: (usize, usize) = (0, 1);
/// Times the search is taken up again when the full plant shows what its lines did not.
const REPAIRS: usize = 3;
/// Times that it begins again with a loop that was found unstable.
const RENEWALS: usize = 2;

/// Share of the limit of the noise current that is aimed at: the sum over the lines of the search is up to 5e-4 below
/// the noise of the loop (found on six spindles).
const NOISE_OF_LINES: f64 = 0.9995;

/// The same of the gain above the modes: a descent ends at a limit to a few last digits, on either side of it.
const GAIN_OF_LINES: f64 = 1.0 - 1e-6;

/// Takes off the limits what the lines of the search did not see of a stable loop, with a little to spare.
fn lower(goal: &mut TuneSettings, settings: &TuneSettings, found: &JudgedFigures) {
    let over = |value: f64, limit: f64| (value - limit).max(0.0) * 1.2;
    let seen = found.sensitivity_peak_db;
    if seen >= ZONE_B_DB {
        goal.sensitivity_db -= (over(seen, ZONE_B_DB) + 0.1).min(3.0);
    }
    if found.noise_current_a > settings.noise_current_a {
        let lowered = goal.noise_current_a - over(found.noise_current_a, settings.noise_current_a);
        goal.noise_current_a = lowered.max(0.5 * goal.noise_current_a);
    }
    let gain = found.high_frequency_gain_a_per_m;
    if gain > settings.high_frequency_gain_a_per_m {
        let lowered = goal.high_frequency_gain_a_per_m - over(gain, settings.high_frequency_gain_a_per_m);
        goal.high_frequency_gain_a_per_m = lowered.max(0.5 * goal.high_frequency_gain_a_per_m);
    }
}

/// The search for these settings; `band_hz` is that of the tool's stiffness.
fn set_up_search(
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
            // The search has no rotors with weak magnets.
            weak_sensitivity: f64::INFINITY,
            high_frequency_hz: high_frequency_hz(machine)?,
            high_frequency_gain_a_per_m: settings.high_frequency_gain_a_per_m,
            sensor_noise_m: electronics.sensor_noise_m,
            noise_current_a: settings.noise_current_a,
            mu: 1.0,
            tool_softness: 1.0,
        },
        mode_shift: settings.mode_shift,
        starts: settings.starts,
        basins: settings.basins,
        steps: settings.steps,
        rounds: settings.rounds,
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
    let free: Vec<usize> = (0..2 * PER_AXIS).filter(|k| k % PER_AXIS >= FIXED_BY_TEXTBOOK).collect();
    let mut asked = set_up_search(machine, settings, NO_BAND)?;
    // A limit of 0 dB is never met: the search ends at the smallest peak it finds.
    asked.limits.sensitivity = 1.0;
    (asked.basins, asked.rounds) = TEXTBOOK_EFFORT;
    let found = search(machine, &asked, &[], &[gains], &shape, &free)?;
    certify(machine, found.parameters, settings, found.evaluations, "textbook PID")
}

/// Starts descended, and rounds: it is made to levitate, not to be the best.
const TEXTBOOK_EFFORT: (usize, usize) = (1, 2);
/// Gain, integral and derivative time come first in the vector form.
const FIXED_BY_TEXTBOOK: usize = 3;
/// No stiffness of the tool takes part.
const NO_BAND: (f64, f64) = (0.0, 0.0);

/// A PID, or the reason why none was found; other failures stay errors.
pub(crate) fn found_or_reason(
    result: Result<TunedPid, VerificationError>,
) -> Result<Result<TunedPid, String>, VerificationError> {
    match result {
        Ok(pid) => Ok(Ok(pid)),
        Err(error) if is_infeasible(&error) => Ok(Err(error.to_string())),
        Err(error) => Err(error),
    }
}

/// True when a search found no stabilising PID.
pub(crate) fn is_infeasible(error: &VerificationError) -> bool {
    matches!(error, VerificationError::Loop(ControllerError::Infeasible { .. }))
}

fn nothing_found(reason: String) -> ControllerError {
    ControllerError::Infeasible {
        step: "PID tuning",
        reason,
        advice: "check delay, bandwidths and sensor planes of the spindle",
    }
}
