//! The polish of the reduced controller in a design: its limits from the machine, its certificates, and which
//! controller is delivered.
//!
//! Limits: |S_jj| within zone A of ISO 14839-3; current from sensor noise, rms, a thirtieth of the smaller bias
//! current; gain above the modes of the model so that sensor noise at any one frequency asks for that current at most;
//! μ of the specification as written at rest and, with the true gyroscopics, at top speed and 1.2 times that. After the
//! descent μ of the whole machine is certified; a peak above one becomes a line of the loss, and the descent goes on
//! from there. The polished controller goes through the same rounding and certificates as the one of the D-K iteration.
//! Of two controllers the one is delivered that meets more goals ([`super::judged`], the most important first), and of
//! equals the stiffer one. Where the controller of the D-K iteration misses a goal, the polish starts from a tuned PID
//! as well.

use super::PipelineError;
use super::certificates::{PeakFigures, certified, mu_words};
use super::comparison::{BAND_HZ, predict};
use super::delivery::{Delivery, deliver, scaled_plane};
use super::judged::Judged;
use super::overspeed::OVERSPEED;
use super::problems::Problems;
use super::settings::PolishEffort;
use super::speed_mu::mu_at_speed;
use super::widening::Widening;
use crate::augment::GeneralizedPlant;
use crate::augment::plane::connected_part;
use crate::augment::weights::Weights;
use crate::controller::ControlLaw;
use crate::controller::amplifier_demand::high_frequency_hz;
use crate::controller::polish::limits::WEAK_SENSITIVITY;
use crate::controller::polish::{LoopLimits, PolishRound, PolishTask, Polisher};
use crate::lti::sample::tustin;
use crate::lti::{Discrete, StateSpace};
use crate::pid::settings::TuneSettings;
use crate::pid::tune::tune;
use crate::predict::closed_loop::both_planes;
use crate::predict::stiffness::stiffness_words;
use crate::spindle::Machine;

/// A polish from one start.
#[derive(Clone, Debug)]
pub struct PolishAttempt {
    /// Where it started, in words.
    pub start: &'static str,
    /// The polished controller; none when the polish could not start.
    pub judged: Option<Judged>,
    /// Why it did not take the place of the best before it; empty when it did.
    pub objections: Vec<&'static str>,
    /// What the loss said of the start, and after each round.
    pub rounds: Vec<PolishRound>,
    /// Certificates: μ of the specification and its frequency, Hz.
    pub certificates: Vec<(f64, f64)>,
    /// Why it could not start.
    pub failure: Option<String>,
}

/// What the polish of a design did.
#[derive(Clone, Debug)]
pub struct PolishOutcome {
    /// The controller of the D-K iteration, reduced and rounded.
    pub dk: Judged,
    /// Limits asked for.
    pub limits: LoopLimits,
    /// The specification whose μ the polish and its certificates are held to: as written, or with wider limits.
    pub held_to: Widening,
    /// Attempts: from the D-K iteration, and, where that misses a target, from a tuned PID.
    pub attempts: Vec<PolishAttempt>,
    /// Number of the attempt whose controller is delivered; none: that of the D-K iteration is.
    pub delivered: Option<usize>,
    /// The outcome in a sentence or two.
    pub sentence: String,
}

/// Ends of zone A and zone B (|S| = 3 and 4) less 2 %, for peaks between the lines and for rounding.
pub(super) const ZONE_A: f64 = 0.98 * 3.0;
const ZONE_B: f64 = 0.98 * 4.0;
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
    let bias = spindle
        .front
        .bias_current_a
        .min(spindle.rear.bias_current_a);
    let noise = spindle.electronics.sensor_noise_m;
    let nyquist_hz = 0.5 * spindle.electronics.sample_rate_hz;
    Ok(LoopLimits {
        stiffness_band_hz: (BAND_HZ.0, BAND_HZ.1.min(0.98 * nyquist_hz)),
        sensitivity,
        shifted_sensitivity: SHIFTED_SENSITIVITY,
        weak_sensitivity: WEAK_SENSITIVITY,
        high_frequency_hz: high_frequency_hz(machine)?,
        high_frequency_gain_a_per_m: NOISE_SHARE * bias / noise,
        sensor_noise_m: noise,
        noise_current_a: NOISE_SHARE * bias,
        mu: MU,
    })
}

/// What the polish holds μ to: the specification as written, and where that was far out of reach what the synthesis
/// aimed at.
#[derive(Clone, Copy)]
struct Goal<'a> {
    weights: &'a Weights,
    plant: &'a GeneralizedPlant,
    widening: Widening,
}

/// Largest widening of a limit with which the polish is still held to the specification as written. Chosen, not
/// derived: a polish may lower μ by that much; further out the rows as written would only hold the worst of them.
const WITHIN_REACH: f64 = 2.0;

impl<'a> Goal<'a> {
    fn of(problems: &'a Problems, written: &'a Weights) -> Self {
        let widening = problems.widening;
        if widening.tool.max(widening.current) <= WITHIN_REACH {
            Self {
                weights: written,
                plant: &problems.specification,
                widening: Widening::NONE,
            }
        } else {
            Self {
                weights: &problems.aim,
                plant: &problems.aimed,
                widening,
            }
        }
    }
}

/// The largest μ of the goal with a controller of one plane, and its frequency, Hz: certified at rest, on the exact
/// responses at rest, top speed and beyond.
fn certificate(
    machine: &Machine,
    (problems, goal): (&Problems, &Goal<'_>),
    plane: &StateSpace<Discrete>,
) -> Result<(f64, f64), PipelineError> {
    const STAGE: &str = "certificate of the polish";
    let scaled = scaled_plane(plane)?;
    let rest = certified(STAGE, goal.plant, &scaled, problems.period_s)?;
    let law = both_planes(plane);
    let mut worst: PeakFigures = rest;
    for share in [0.0, 1.0, OVERSPEED] {
        let speed = share * machine.spindle.max_rpm;
        let exact = mu_at_speed(machine, &problems.aim, &problems.written_modes, &law, speed)?;
        worst = worst.at_least(&exact);
    }
    Ok((worst.upper, worst.frequency_hz))
}

/// Rounds at most, in units of those asked.
const MOST_ROUNDS: usize = 3;

/// A polish that came to its end.
struct Polished {
    plane: StateSpace<Discrete>,
    rounds: Vec<PolishRound>,
    certificates: Vec<(f64, f64)>,
}

/// Polishes `plane` until its μ is certified, or to the lowest μ found.
fn descend(
    machine: &Machine,
    (limits, effort): (LoopLimits, PolishEffort),
    (problems, goal): (&Problems, &Goal<'_>),
    plane: &StateSpace<Discrete>,
) -> Result<Polished, PipelineError> {
    let task = PolishTask {
        weights: goal.weights,
        modes: &problems.written_modes,
        limits,
    };
    let mut polisher = Polisher::new(machine, task, plane, OVERSPEED)?;
    let mut rounds = vec![polisher.figures()];
    // Rounds beyond those asked as long as a limit is exceeded: from a distant start they go on to gain.
    while rounds.len() <= effort.rounds
        || rounds.len() <= MOST_ROUNDS * effort.rounds && !polisher.within_limits()
    {
        rounds.push(polisher.round(effort.steps)?);
    }
    let mut certificates: Vec<(f64, f64)> = vec![];
    let mut best: Option<(f64, StateSpace<Discrete>)> = None;
    for cut in 0..=effort.cuts {
        let found = polisher.plane()?;
        let (mu, at_hz) = certificate(machine, (problems, goal), &found)?;
        certificates.push((mu, at_hz));
        if best.as_ref().is_none_or(|(least, _)| mu < *least) {
            best = Some((mu, found));
        }
        if mu <= 1.0 || !mu.is_finite() || cut == effort.cuts {
            break;
        }
        // A peak between the lines needs a line; one that comes back beside its line needs a lower limit as well.
        let earlier = &certificates[..certificates.len() - 1];
        let again = earlier
            .iter()
            .any(|(_, hz)| (hz / at_hz - 1.0).abs() < SAME_PEAK);
        polisher.add_peak(at_hz, if again { CUT / mu } else { 1.0 });
        rounds.push(polisher.round(effort.cut_steps)?);
        if !polisher.within_limits() {
            rounds.push(polisher.round(effort.steps)?);
        }
    }
    Ok(Polished {
        plane: best.map_or_else(|| plane.clone(), |(_, found)| found),
        rounds,
        certificates,
    })
}

/// What the attempts share.
struct Contest<'a> {
    machine: &'a Machine,
    weights: &'a Weights,
    problems: &'a Problems,
    speeds: usize,
    effort: PolishEffort,
    /// Smallest tool stiffness of a tuned PID at rest and at top speed, once there is one, N/m.
    rival: Option<[f64; 2]>,
    /// The best so far.
    delivery: Delivery,
    judged: Judged,
    outcome: PolishOutcome,
}

impl Contest<'_> {
    fn misses_a_goal(&self) -> bool {
        self.judged.met(self.machine, self.rival).contains(&false)
    }

    /// True when a larger sensitivity may help: the zone is worse than B, or the tool softer than that of the PID.
    fn wants_sensitivity(&self) -> bool {
        let [.., zone_b, as_stiff] = self.judged.met(self.machine, self.rival);
        !zone_b || !as_stiff
    }

    /// Polishes `plane`, and keeps the result when it is better.
    fn attempt(
        &mut self,
        start: &'static str,
        limits: LoopLimits,
        plane: Result<&StateSpace<Discrete>, &PipelineError>,
    ) {
        let mut attempt = PolishAttempt {
            start,
            judged: None,
            objections: vec![],
            rounds: vec![],
            certificates: vec![],
            failure: None,
        };
        let done = plane.map_err(ToString::to_string).and_then(|plane| {
            self.polish(limits, plane)
                .map_err(|error| error.to_string())
        });
        match done {
            Ok((judged, candidate, found)) => {
                attempt.objections = judged.objections(&self.judged, self.machine, self.rival);
                if attempt.objections.is_empty() {
                    (self.delivery, self.judged) = (candidate, judged.clone());
                    self.outcome.delivered = Some(self.outcome.attempts.len());
                }
                attempt.judged = Some(judged);
                attempt.rounds = found.rounds;
                attempt.certificates = found.certificates;
            }
            // What an earlier start or the D-K iteration gave stands, and the outcome says what failed.
            Err(failure) => attempt.failure = Some(failure),
        }
        self.outcome.attempts.push(attempt);
    }

    fn polish(
        &self,
        limits: LoopLimits,
        plane: &StateSpace<Discrete>,
    ) -> Result<(Judged, Delivery, Polished), PipelineError> {
        let goal = Goal::of(self.problems, self.weights);
        let found = descend(
            self.machine,
            (limits, self.effort),
            (self.problems, &goal),
            plane,
        )?;
        let candidate = deliver(
            self.machine,
            self.weights,
            self.problems,
            self.speeds,
            &found.plane,
        )?;
        let judged = Judged::of(self.machine, "mu", &candidate)?;
        Ok((judged, candidate, found))
    }
}

/// Polishes `plane`, of which `dk` is the delivery, and decides which controller is delivered. Where that of the D-K
/// iteration misses a goal, a PID is tuned: the polished controller has to be as stiff, and where it misses a goal too,
/// the polish starts from the PID as well, within zone A, then within zone B.
pub(super) fn polished(
    machine: &Machine,
    (weights, speeds, effort): (&Weights, usize, PolishEffort),
    problems: &Problems,
    plane: &StateSpace<Discrete>,
    dk: Delivery,
) -> Result<(Delivery, PolishOutcome), PipelineError> {
    let zone_a = limits(machine, ZONE_A)?;
    let judged = Judged::of(machine, "dk", &dk)?;
    let mut contest = Contest {
        machine,
        weights,
        problems,
        speeds,
        effort,
        rival: None,
        outcome: PolishOutcome {
            dk: judged.clone(),
            limits: zone_a,
            held_to: Goal::of(problems, weights).widening,
            attempts: vec![],
            delivered: None,
            sentence: String::new(),
        },
        delivery: dk,
        judged,
    };
    let by_pid = contest.misses_a_goal().then(|| tuned_pid(machine));
    if let Some(Ok((_, stiffness))) = &by_pid {
        contest.rival = Some(*stiffness);
    }
    contest.attempt("D-K iteration", zone_a, Ok(plane));
    if let Some(found) = &by_pid {
        let start = found.as_ref().map(|(plane, _)| plane);
        if contest.misses_a_goal() {
            contest.attempt("tuned PID", zone_a, start);
        }
        if contest.wants_sensitivity() && start.is_ok() {
            contest.attempt("tuned PID within zone B", limits(machine, ZONE_B)?, start);
        }
    }
    let mut outcome = contest.outcome;
    outcome.sentence = sentence(&outcome);
    Ok((contest.delivery, outcome))
}

/// One plane of a tuned PID, m to A, and its smallest tool stiffness at rest and at top speed, N/m.
fn tuned_pid(machine: &Machine) -> Result<(StateSpace<Discrete>, [f64; 2]), PipelineError> {
    let found = tune(machine, &TuneSettings::quick(), &mut |_, _| {})?;
    let period_s = machine.spindle.electronics.sample_period_s();
    let law = match &found.controller.law {
        ControlLaw::Discrete(law) => law.clone(),
        ControlLaw::Continuous(law) => {
            tustin(law, period_s).map_err(PipelineError::numeric("discretisation of the PID"))?
        }
    };
    let minimum = |rpm: f64| -> Result<f64, PipelineError> {
        let seen = predict(machine, &found.controller, rpm)?;
        // An unstable loop is no rival.
        Ok(if seen.is_stable() {
            seen.minimum.0
        } else {
            0.0
        })
    };
    let stiffness = [minimum(0.0)?, minimum(machine.spindle.max_rpm)?];
    Ok((connected_part(&law.select(&[0, 2], &[0, 2])), stiffness))
}

fn sentence(outcome: &PolishOutcome) -> String {
    let dk = &outcome.dk;
    let words = |k: f64| {
        if k.is_nan() {
            "none (unstable loop)".to_owned()
        } else {
            stiffness_words(k)
        }
    };
    let figures = |attempt: &PolishAttempt, judged: &Judged| {
        format!(
            "The polish from the {} has a smallest tool stiffness of {} at rest and {} at top speed (D-K iteration: \
             {} and {}), µ of the specification at most {} from rest to 1.2 times the top speed",
            attempt.start,
            words(judged.stiffness_n_per_m[0]),
            words(judged.stiffness_n_per_m[1]),
            words(dk.stiffness_n_per_m[0]),
            words(dk.stiffness_n_per_m[1]),
            mu_words(judged.mu),
        )
    };
    if let Some(attempt) = outcome.delivered.and_then(|k| outcome.attempts.get(k))
        && let Some(judged) = &attempt.judged
    {
        return format!(
            "{}; the polished controller is delivered.",
            figures(attempt, judged)
        );
    }
    let reasons: Vec<String> = outcome
        .attempts
        .iter()
        .map(|attempt| match (&attempt.judged, &attempt.failure) {
            (Some(judged), _) => format!(
                "{}; it is not delivered: {}.",
                figures(attempt, judged),
                attempt.objections.join(", ")
            ),
            (None, failure) => format!(
                "No polish from the {}: {}.",
                attempt.start,
                failure.as_deref().unwrap_or("it did not start")
            ),
        })
        .collect();
    format!(
        "The controller of the D-K iteration is delivered. {}",
        reasons.join(" ")
    )
}
