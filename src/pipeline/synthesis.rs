//! From the machine to the controller of full order, with as many modes in the synthesis as the whole machine needs.
//!
//! A mode that the synthesis model leaves out may still raise μ. μ of the covered problem is therefore computed on the
//! whole machine. Where it exceeds one, the synthesis is repeated with the modes up to that peak; if the model has them
//! already, with a target lower by the excess. The controller with the lowest μ of the whole machine is taken.

use super::PipelineError;
use super::certificates::{attained_at, attained_gain, true_frequency_hz};
use super::emulation::{Emulated, sampled_by_tustin};
use super::posing::pose_again;
use super::problems::{Problems, build_generalized};
use super::progress::{Event, Listener};
use super::settings::DesignSettings;
use super::stable::{OwnStability, prefer_stable};
use crate::augment::plane::{LOADS, LOOPS, Route};
use crate::augment::weights::Weights;
use crate::lti::{Continuous, StateSpace};
use crate::robust::dk::{DkOutcome, iterate};
use crate::robust::prescale::scale_signals;
use crate::spindle::Machine;
use std::f64::consts::TAU;

/// One synthesis and its μ on the whole machine.
#[derive(Clone, Copy, Debug)]
pub struct Round {
    /// Flexible modes that the synthesis saw.
    pub synthesis_modes: usize,
    /// Level that its constant scales had to reach for a bound on T.
    pub gamma_target: f64,
    /// μ of the synthesis problem, on the modes that it saw.
    pub synthesis: f64,
    /// μ of the covered problem of the whole machine; infinite when that loop is unstable.
    pub whole_machine: f64,
    /// Frequency of the latter, Hz.
    pub frequency_hz: f64,
}

/// A controller of full order in the w plane, in scaled signals, and the problems it solves.
pub(super) struct Synthesised {
    pub(super) problems: Problems,
    pub(super) scales: Vec<f64>,
    pub(super) outcome: DkOutcome,
    pub(super) own_stability: OwnStability,
    pub(super) full: StateSpace<Continuous>,
    /// Largest bound of μ found on the synthesis problem; infinite for an unstable loop.
    pub(super) synthesis: f64,
    pub(super) emulated: Option<Emulated>,
    pub(super) rounds: Vec<Round>,
}

/// Syntheses at most: the modes up to the peak, then twice a lower level.
const ROUNDS: usize = 3;
/// Share of what μ of the whole machine misses that the next level is lowered by beyond it.
const STEP_BACK: f64 = 0.98;
/// Modes up to this factor above the frequency of the peak join the synthesis: a mode acts above its frequency as well.
const REACH: f64 = 1.3;
/// Bounds on T tried for a stable controller when there is none, loosest first.
const T_BOUNDS: [f64; 4] = [20.0, 12.0, 8.0, 5.0];

/// The controller whose μ of the whole machine is at most one, or the lowest found; `posed` is the problem of the first
/// synthesis with its constant scales.
pub(super) fn synthesise_for_machine(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
    posed: (Problems, Vec<f64>),
    progress: &mut Listener,
) -> Result<Synthesised, PipelineError> {
    let mut settings = settings.clone();
    let mut posed = Ok(posed);
    let mut best: Option<(f64, Synthesised)> = None;
    let mut rounds: Vec<Round> = vec![];
    loop {
        let found = posed.and_then(|posed| synthesise_once(machine, &settings, posed.0, posed.1, progress));
        let found = match found {
            Ok(found) => found,
            // A further round that fails leaves what the earlier ones found.
            Err(error) if best.is_none() => return Err(error),
            Err(_) => break,
        };
        let problems = &found.problems;
        let whole = attained_at(&problems.covered, &found.full)?;
        let (mu, omega) = whole.unwrap_or((f64::INFINITY, f64::NAN));
        let round = Round {
            synthesis_modes: problems.synthesis_modes,
            gamma_target: settings.gamma_target,
            synthesis: found.synthesis,
            whole_machine: mu,
            frequency_hz: true_frequency_hz(omega, problems.period_s),
        };
        rounds.push(round);
        progress(Event::Stage("μ of the whole machine"));
        let target = 1.0 / (1.0 + settings.reduction_budget);
        let next = further(&round, problems, &settings, target)
            .filter(|_| rounds.len() < ROUNDS)
            .map(|next| (next, problems.clone(), found.scales.clone()));
        if best.as_ref().is_none_or(|(least, _)| mu < *least) {
            best = Some((mu, found));
        }
        let Some((next, before, scales)) = next else {
            break;
        };
        settings = next;
        posed = pose_again(machine, weights, &settings, Some((&before, &scales)))
            .map(|(problems, scales, _)| (problems, scales));
        progress(Event::Stage("problems and constant scales"));
    }
    match best {
        Some((_, found)) => Ok(Synthesised { rounds, ..found }),
        None => {
            Err(PipelineError::Synthesis(crate::robust::SynthesisError::Partition("no synthesis was tried".to_owned())))
        }
    }
}

/// Settings of the next synthesis; `None` when μ is within target or no setting is left to change.
fn further(round: &Round, problems: &Problems, settings: &DesignSettings, target: f64) -> Option<DesignSettings> {
    // The modes seen did not allow the target: those of the machine will not either.
    let out_of_reach = round.synthesis > 1.0;
    if round.whole_machine <= 1.0 || out_of_reach && round.whole_machine.is_finite() {
        return None;
    }
    let covered = problems.split.len();
    let up_to = if round.frequency_hz.is_finite() {
        let below = |omega: &f64| omega / TAU <= REACH * round.frequency_hz;
        problems.flexible_rad_s.iter().filter(|w| below(w)).count()
    } else {
        problems.machine_modes
    };
    if up_to > problems.synthesis_modes {
        return Some(DesignSettings { extra_modes: up_to - covered, ..settings.clone() });
    }
    let missed = target / round.whole_machine;
    (round.whole_machine.is_finite() && problems.sensitivity_limit.is_some())
        .then(|| DesignSettings { gamma_target: settings.gamma_target * missed * STEP_BACK, ..settings.clone() })
}

fn synthesise_once(
    machine: &Machine,
    settings: &DesignSettings,
    problems: Problems,
    scales: Vec<f64>,
    progress: &mut Listener,
) -> Result<Synthesised, PipelineError> {
    let outcome = iterate(&scale_signals(&problems.posed, &scales), &settings.dk, &mut |step| {
        progress(Event::Step(step));
    })?;
    progress(Event::Stage("D-K iteration"));
    // Modes and further uncertainty come first, one channel each.
    let noise = problems.posed.blocks.len().saturating_sub(1) + LOADS;
    let looser: &[f64] = match problems.sensitivity_limit {
        Some(_) => &[],
        None => &T_BOUNDS,
    };
    let (synthesised, own_stability) =
        prefer_stable(&problems.posed, &scales, &outcome, noise..noise + LOOPS, looser, &|limit| {
            let (flexible, modes) = (problems.synthesis_modes, &problems.covered_modes);
            build_generalized(machine, &problems.aim, flexible, modes, Some(limit), settings.route)
        })?;
    progress(Event::Stage("stable controller"));
    let (full, emulated) = match settings.route {
        Route::Direct => (synthesised, None),
        Route::Emulation { .. } => {
            let (sampled, emulated) = sampled_by_tustin(&problems, &synthesised)?;
            (sampled, Some(emulated))
        }
    };
    let synthesis = attained_gain(&problems.synthesis, &full)?.unwrap_or(f64::INFINITY);
    Ok(Synthesised { problems, scales, outcome, own_stability, full, synthesis, emulated, rounds: vec![] })
}
