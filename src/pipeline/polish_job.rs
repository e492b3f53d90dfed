//! One polish of a design: limits from the machine, descent, certificates, the controller as it runs.
//!
//! Limits: |S_jj| within a zone of ISO 14839-3; current from sensor noise, rms, a thirtieth of the smaller bias
//! current; gain above the modes of the model so that sensor noise at any one frequency asks for that current at most;
//! μ of the specification as written at rest and, with the true gyroscopics, at top speed and 1.2 times that. After the
//! descent μ of the whole machine is certified, at speeds between as well where a mode splits far; a peak above one is
//! added to the lines of the loss, its speed to those of the loss, and the descent continues.

use super::PipelineError;
use super::certificates::certify_peak;
use super::delivery::{Delivery, DeliveryCandidate, KnownMu, Realised};
use super::judged::Judged;
use super::loop_stability::growth_rate_at;
use super::overspeed::OVERSPEED;
use super::problems::Problems;
use super::settings::{DesignSettings, PolishEffort};
use super::speed_mu::{SpeedMu, mu_at_speed};
use super::widening::Widening;
use crate::augment::GeneralizedPlant;
use crate::augment::weights::{StiffnessFloor, Weights};
use crate::controller::amplifier_demand::high_frequency_hz;
use crate::controller::polish::limits::WEAK_SENSITIVITY;
use crate::controller::polish::{LoopLimits, PolishRound, PolishTask, Polisher};
use crate::controller::{ControlLaw, Controller};
use crate::lti::{Discrete, StateSpace};
use crate::predict::closed_loop::both_planes;
use crate::spindle::Machine;
use rayon::prelude::*;

/// Ends of zone A and zone B (|S| = 3 and 4) less 2 %, for peaks between the lines and for rounding.
pub(super) const ZONE_A: f64 = 0.98 * 3.0;
pub(super) const ZONE_B: f64 = 0.98 * 4.0;
/// Sensitivity of rotors with shifted modes relative to that.
const SHIFTED_SENSITIVITY: f64 = 1.3;
/// μ below one by what the certificate finds between the lines and by the fit of the weights in the w plane.
const MU: f64 = 0.98;
/// Level that a cut aims at, below one by the width of a certificate.
const CUT: f64 = 0.995;
/// Peaks of two certificates closer than this share of their frequency are one.
const SAME_PEAK: f64 = 0.02;
/// Share of the bias current that sensor noise may ask for.
const NOISE_SHARE: f64 = 1.0 / 30.0;

/// Limits of a polish, from the machine, with a largest |S_jj|.
pub(super) fn limits(machine: &Machine, sensitivity: f64) -> Result<LoopLimits, PipelineError> {
    let spindle = &machine.spindle;
    let bias = spindle.front.bias_current_a.min(spindle.rear.bias_current_a);
    let noise = spindle.electronics.sensor_noise_m;
    let nyquist_hz = 0.5 * spindle.electronics.sample_rate_hz;
    let (from_hz, to_hz) = spindle.stiffness_band_hz;
    Ok(LoopLimits {
        stiffness_band_hz: (from_hz, to_hz.min(0.98 * nyquist_hz)),
        sensitivity,
        shifted_sensitivity: SHIFTED_SENSITIVITY,
        weak_sensitivity: WEAK_SENSITIVITY,
        high_frequency_hz: high_frequency_hz(machine)?,
        high_frequency_gain_a_per_m: NOISE_SHARE * bias / noise,
        sensor_noise_m: noise,
        noise_current_a: NOISE_SHARE * bias,
        mu: MU,
        tool_softness: 1.0,
    })
}

/// What the polish holds μ to: the specification as written, and where that was far out of reach what the synthesis
/// aimed at.
#[derive(Clone, Copy)]
pub(super) struct Goal<'a> {
    weights: &'a Weights,
    plant: &'a GeneralizedPlant,
    /// Floors of the tool's stiffness beside it.
    floors: &'a [StiffnessFloor],
    shifts: &'a [Vec<f64>],
    least_decay_per_s: f64,
    asked_between: &'a [f64],
    /// By what the limits are widened.
    pub widening: Widening,
}

/// Largest widening of a limit with which the polish is still held to the specification as written. Chosen, not
/// derived: a polish may lower μ by that much; further out the rows as written would only hold the worst of them.
const WITHIN_REACH: f64 = 2.0;

impl<'a> Goal<'a> {
    pub(super) fn of(job: &PolishJob<'a>) -> Self {
        let PolishJob { problems, floors, shifts, least_decay_per_s, asked_between, .. } = *job;
        let widening = problems.widening;
        if widening.tool.max(widening.current) <= WITHIN_REACH {
            let (weights, plant) = (job.weights, &problems.specification);
            Self { weights, plant, floors, shifts, least_decay_per_s, asked_between, widening: Widening::NONE }
        } else {
            let (weights, plant) = (&problems.aim, &problems.aimed);
            Self { weights, plant, floors, shifts, least_decay_per_s, asked_between, widening }
        }
    }
}

/// μ of the goal with a controller as it runs: certified at rest, on the exact responses at shares of the top speed.
fn certificate(
    machine: &Machine,
    problems: &Problems,
    goal: &Goal<'_>,
    realised: &Realised,
    speed_shares: &[f64],
) -> Result<KnownMu, PipelineError> {
    const STAGE: &str = "certificate of the polish";
    let at = |share: &f64| {
        let (weights, modes) = (goal.weights, &problems.written_modes);
        let speed_rpm = share * machine.spindle.max_rpm;
        mu_at_speed(machine, weights, modes, &realised.law, speed_rpm)
    };
    let (rest, exact) = rayon::join(
        || certify_peak(STAGE, goal.plant, &realised.rounded_plane, problems.period_s),
        || {
            let found: Result<Vec<SpeedMu>, PipelineError> = speed_shares.par_iter().map(at).collect();
            found
        },
    );
    Ok(KnownMu { at_rest: rest?, over_speed: exact? })
}

/// Rounds at most, in units of those asked.
const MOST_ROUNDS: usize = 5;

/// Share of what a peak exceeds one by that a lower limit has to take for another one to follow.
const WORTH_A_CUT: f64 = 0.25;

/// Share of stiffness that a round has to gain for another one to follow.
const WORTH_A_ROUND: f64 = 0.01;

/// True when the last round made the tool stiffer by more than [`WORTH_A_ROUND`].
fn has_gained(rounds: &[PolishRound]) -> bool {
    match rounds {
        [.., before, last] => last.stiffness_n_per_m > (1.0 + WORTH_A_ROUND) * before.stiffness_n_per_m,
        _ => false,
    }
}

/// Share of what the loop has to which a round lowers the limit on μ, what it has to leave of it, and how many rounds
/// in turn may leave more.
const LOWERED: f64 = 0.8;
const WORTH_LOWERING: f64 = 0.98;
const MOST_FAILED: usize = 2;
/// Such rounds of a polish to the least μ.
const LOWERINGS: usize = 4;

/// Shares of the top speed at which a start that is not stable at all of them is polished on its way.
const SPEED_SHARES: [f64; 9] = [1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.25, 0.1];

/// What a polish of the machine at lower and then higher top speeds makes of `plane`, which is not stable up to the
/// overspeed: a loop that is unstable does not count in a polish, so that nothing would stabilise it. Ends where a
/// round gains no speed.
fn up_to_speed(
    machine: &Machine,
    task: PolishTask<'_>,
    plane: &StateSpace<Discrete>,
    effort: PolishEffort,
) -> Result<StateSpace<Discrete>, PipelineError> {
    let slower = |share: f64| {
        let mut slower = machine.clone();
        slower.spindle.max_rpm *= share;
        slower
    };
    let stable = |plane: &StateSpace<Discrete>, share: f64| -> Result<bool, PipelineError> {
        let controller = Controller { name: "polish".to_owned(), law: ControlLaw::Discrete(both_planes(plane)) };
        for speed in [1.0, OVERSPEED] {
            let rpm = share * speed * machine.spindle.max_rpm;
            if growth_rate_at(machine, &controller, rpm)? >= 0.0 {
                return Ok(false);
            }
        }
        Ok(true)
    };
    let mut plane = plane.clone();
    let mut reached = 0.0;
    loop {
        let mut next = None;
        for share in SPEED_SHARES.into_iter().filter(|s| *s > reached) {
            if stable(&plane, share)? {
                next = Some(share);
                break;
            }
        }
        match next {
            // Stable everywhere, or no further: the polish says what it can do with it.
            Some(1.0) | None => return Ok(plane),
            Some(share) => {
                reached = share;
                let machine = slower(share);
                let mut polisher = Polisher::new(&machine, task, &plane, OVERSPEED)?;
                polisher.run_round(effort.steps)?;
                plane = polisher.plane()?;
            }
        }
    }
}

/// The course of a polish that came to its end.
pub(super) struct Polished {
    /// The controller of one plane, m to A.
    pub plane: StateSpace<Discrete>,
    /// What the loss said of the start, and after each round.
    pub rounds: Vec<PolishRound>,
    /// Certificates: μ of the goal and its frequency, Hz.
    pub certificates: Vec<(f64, f64)>,
}

/// Asks for the specification at the speed of a peak; true where it was not asked for there before.
fn ask_at_peak(polisher: &mut Polisher<'_>, machine: &Machine, peak: &SpeedMu) -> Result<bool, PipelineError> {
    let mut shares = polisher.speed_shares().into_iter();
    match shares.find(|share| share * machine.spindle.max_rpm == peak.speed_rpm) {
        Some(share) => Ok(polisher.ask_at(machine, share)?),
        None => Ok(false),
    }
}

/// Rounds that lower the limit on μ below what the loop has, or ask for it at a further speed, from a peak and the
/// least μ so far on; `keep` certifies the controller after each and says its peak.
fn lower_mu(
    polisher: &mut Polisher<'_>,
    machine: &Machine,
    effort: PolishEffort,
    mut peak: SpeedMu,
    mut least: f64,
    keep: &mut dyn FnMut(&Polisher<'_>, PolishRound) -> Result<SpeedMu, PipelineError>,
) -> Result<(), PipelineError> {
    let mut failed = 0;
    for _ in 0..effort.lowerings {
        if least <= 1.0 || !least.is_finite() || failed == MOST_FAILED {
            break;
        }
        if !ask_at_peak(polisher, machine, &peak)? {
            polisher.limit_mu_to(LOWERED);
        }
        let round = polisher.run_round(effort.steps)?;
        peak = keep(polisher, round)?;
        failed = if peak.mu < WORTH_LOWERING * least { 0 } else { failed + 1 };
        least = least.min(peak.mu);
    }
    Ok(())
}

/// Polishes `plane` until its μ is certified, or to the lowest μ found.
fn descend(
    machine: &Machine,
    limits: LoopLimits,
    effort: PolishEffort,
    problems: &Problems,
    goal: &Goal<'_>,
    plane: &StateSpace<Discrete>,
) -> Result<(Polished, Realised, Option<KnownMu>), PipelineError> {
    let task = PolishTask {
        weights: goal.weights,
        modes: &problems.written_modes,
        floors: goal.floors,
        shifts: goal.shifts,
        least_decay_per_s: goal.least_decay_per_s,
        limits,
    };
    let mut polisher = Polisher::new(machine, task, plane, OVERSPEED)?;
    if !polisher.is_stable() {
        let brought = up_to_speed(machine, task, plane, effort)?;
        polisher = Polisher::new(machine, task, &brought, OVERSPEED)?;
    }
    for share in goal.asked_between {
        polisher.ask_at(machine, *share)?;
    }
    // Where the specification is far out of reach, the μ of the start is held, not bought with stiffness.
    if !goal.widening.is_none() {
        polisher.hold_mu();
    }
    let mut rounds = vec![polisher.figures()];
    // Rounds beyond those asked as long as a limit is exceeded or the last one gained: from a distant start they go on.
    while rounds.len() <= effort.rounds
        || rounds.len() <= MOST_ROUNDS * effort.rounds && (!polisher.within_limits() || has_gained(&rounds))
    {
        rounds.push(polisher.run_round(effort.steps)?);
    }
    let speed_shares = polisher.speed_shares();
    let certified = |plane: StateSpace<Discrete>| {
        let realised = Realised::new(machine, &plane)?;
        let known = certificate(machine, problems, goal, &realised, &speed_shares)?;
        Ok::<_, PipelineError>((known.largest(), (plane, realised, known)))
    };
    let figures = |peak: &SpeedMu| (peak.mu, peak.frequency_hz);
    let (mut peak, mut best) = certified(polisher.plane()?)?;
    let mut least = peak.mu;
    let mut certificates = vec![figures(&peak)];
    for _ in 0..effort.cuts {
        let (mu, at_hz) = figures(&peak);
        // Where the limit on μ was out of reach on the lines, no further line brings it back.
        let in_reach = polisher.limits().mu <= 1.0;
        if mu <= 1.0 || !mu.is_finite() || !in_reach {
            break;
        }
        // A peak between the lines needs a line; one at a line, or that comes back beside its line, needs a lower limit
        // as well; one that a lower limit does not lower is out of reach.
        let earlier = &certificates[..certificates.len() - 1];
        let same = |(_, hz): &&(f64, f64)| (hz / at_hz - 1.0).abs() < SAME_PEAK;
        let before: Vec<f64> = earlier.iter().filter(same).map(|(mu, _)| *mu).collect();
        if let [.., _, last] = before[..]
            && mu - 1.0 > (1.0 - WORTH_A_CUT) * (last - 1.0)
        {
            break;
        }
        if ask_at_peak(&mut polisher, machine, &peak)? {
            rounds.push(polisher.run_round(effort.steps)?);
        } else {
            let lower = !before.is_empty() || polisher.has_line_at(at_hz);
            polisher.add_peak(at_hz, if lower { CUT / mu } else { 1.0 });
            rounds.push(polisher.run_round(effort.cut_steps)?);
        }
        if !polisher.within_limits() {
            rounds.push(polisher.run_round(effort.steps)?);
        }
        let (next, found) = certified(polisher.plane()?)?;
        peak = next;
        certificates.push(figures(&peak));
        if peak.mu < least {
            (least, best) = (peak.mu, found);
        }
    }
    lower_mu(&mut polisher, machine, effort, peak, least, &mut |polisher, round| {
        rounds.push(round);
        let (peak, found) = certified(polisher.plane()?)?;
        certificates.push(figures(&peak));
        if peak.mu < least {
            (least, best) = (peak.mu, found);
        }
        Ok(peak)
    })?;
    let (plane, realised, known) = best;
    let course = Polished { plane, rounds, certificates };
    let written = goal.widening.is_none();
    Ok((course, realised, written.then_some(known)))
}

/// What every polish of a design shares.
#[derive(Clone, Copy)]
pub(super) struct PolishJob<'a> {
    pub machine: &'a Machine,
    pub weights: &'a Weights,
    pub problems: &'a Problems,
    /// Floors of the tool's stiffness.
    pub floors: &'a [StiffnessFloor],
    /// Factors on the natural frequencies with which the loop has to stay stable.
    pub shifts: &'a [Vec<f64>],
    /// Least decay of the controller's own poles, 1/s; zero: none is asked.
    pub least_decay_per_s: f64,
    /// Shares of the top speed, between rest and it, at which the specification is asked for from the beginning.
    pub asked_between: &'a [f64],
    pub speeds: usize,
    pub effort: PolishEffort,
}

impl<'a> PolishJob<'a> {
    /// The polish that the settings of a design ask for, if any.
    pub(super) fn set_up_job(
        machine: &'a Machine,
        weights: &'a Weights,
        problems: &'a Problems,
        settings: &DesignSettings,
    ) -> Option<Self> {
        let floors = &weights.tool_stiffness;
        Some(Self {
            machine,
            weights,
            problems,
            floors,
            shifts: &[],
            least_decay_per_s: weights.least_decay_per_s.unwrap_or_default(),
            asked_between: &[],
            speeds: settings.speeds,
            effort: settings.polish?,
        })
    }

    /// The same with rounds that lower μ as far as it goes where it exceeds one.
    pub(super) fn to_least_mu(self) -> Self {
        Self { effort: PolishEffort { lowerings: LOWERINGS, ..self.effort }, ..self }
    }

    /// `plane` as it is, taken through rounding and certificates.
    pub(super) fn deliver(&self, plane: &StateSpace<Discrete>) -> Result<(Judged, Delivery, Polished), PipelineError> {
        let realised = Realised::new(self.machine, plane)?;
        let course = Polished { plane: plane.clone(), rounds: vec![], certificates: vec![] };
        self.judge((course, realised, None))
    }

    /// Rounding, proof and certificates of a polish.
    fn judge(
        &self,
        (course, realised, known): (Polished, Realised, Option<KnownMu>),
    ) -> Result<(Judged, Delivery, Polished), PipelineError> {
        let machine = self.machine;
        let (candidate, proof) =
            DeliveryCandidate::prove_candidate(machine, self.weights, self.problems, realised, known)?;
        let delivery = candidate.deliver_candidate(machine, self.weights, self.problems, self.speeds, proof)?;
        let judged = Judged::of(machine, "mu", &delivery)?.measured_by(machine, &self.weights.tool_stiffness)?;
        Ok((judged, delivery, course))
    }

    /// Polishes `plane` within `limits`, and takes the result through rounding and certificates.
    pub(super) fn polish(
        &self,
        limits: LoopLimits,
        plane: &StateSpace<Discrete>,
    ) -> Result<(Judged, Delivery, Polished), PipelineError> {
        let goal = Goal::of(self);
        self.judge(descend(self.machine, limits, self.effort, self.problems, &goal, plane)?)
    }
}
