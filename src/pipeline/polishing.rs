//! The polish of the reduced controller in a design: its limits from the machine, its certificates, and which controller is
//! delivered.
//!
//! Limits: |S_jj| within zone A of ISO 14839-3; current from sensor noise, rms, a thirtieth of the smaller bias current; gain
//! above the modes of the model so that sensor noise at any one frequency asks for that current at most; μ of the specification
//! as written at rest and, with the true gyroscopics, at top speed and 1.2 times that. After the descent μ of the whole machine
//! is certified; a peak above one becomes a line of the loss, and the descent goes on from there. The polished controller goes
//! through the same rounding and certificates as the one of the D-K iteration, and is delivered when they hold and its tool is
//! stiffer at rest and at top speed. Where the controller of the D-K iteration misses a target, the polish starts from a tuned
//! PID as well.

use super::PipelineError;
use super::certificates::{PeakFigures, certified, mu_words};
use super::comparison::{BAND_HZ, Prediction, predict};
use super::delivery::{Delivery, deliver, scaled_plane};
use super::overspeed::OVERSPEED;
use super::problems::Problems;
use super::settings::PolishEffort;
use super::speed_mu::mu_at_speed;
use crate::augment::plane::connected_part;
use crate::augment::weights::Weights;
use crate::controller::amplifier_demand::high_frequency_hz;
use crate::controller::pid_settings::TuneSettings;
use crate::controller::pid_tune::tune;
use crate::controller::polish::{LoopLimits, PolishRound, PolishTask, Polisher};
use crate::controller::{ControlLaw, Controller};
use crate::lti::sample::tustin;
use crate::lti::{Discrete, StateSpace};
use crate::predict::closed_loop::both_planes;
use crate::predict::sensitivity::Zone;
use crate::spindle::Machine;

/// A controller with the figures that decide between two.
#[derive(Clone, Debug)]
pub struct Judged {
    /// The controller as it runs.
    pub controller: Controller,
    /// Its order over both planes.
    pub order: usize,
    /// Largest μ of the specification: certified at rest, on exact responses at speeds to 1.2 times the top speed.
    pub mu: f64,
    /// Certified μ at rest: specification, and with the gyroscopic split covered.
    pub mu_at_rest: [f64; 2],
    /// Smallest tool stiffness at rest and at top speed, N/m; NaN for an unstable loop.
    pub stiffness_n_per_m: [f64; 2],
    /// Zone at rest and at top speed; none of an unstable loop.
    pub zones: [Option<Zone>; 2],
    /// Stability is proven from rest to this speed, at most 1.2 times the top speed, rpm.
    pub proven_to_rpm: f64,
    /// Growth rate of the controller's own poles, 1/s.
    pub growth_rate_per_s: f64,
}

impl Judged {
    fn of(machine: &Machine, name: &str, delivery: &Delivery) -> Result<Self, PipelineError> {
        let top = machine.spindle.max_rpm;
        let controller = Controller {
            name: name.to_owned(),
            ..delivery.controller.clone()
        };
        let [rest, fast] = [0.0, top].map(|rpm| predict(machine, &controller, rpm));
        let both = [rest?, fast?];
        let minimum = |p: &Prediction| {
            if p.is_stable() { p.minimum.0 } else { f64::NAN }
        };
        Ok(Self {
            order: 2 * delivery.rounded.order,
            mu: delivery.largest_mu(),
            mu_at_rest: [
                delivery.rounded.specification.upper,
                delivery.rounded.covered.upper,
            ],
            stiffness_n_per_m: [minimum(&both[0]), minimum(&both[1])],
            zones: [both[0].zone(), both[1].zone()],
            proven_to_rpm: delivery.speed_proof.proven_to_rpm().min(OVERSPEED * top),
            growth_rate_per_s: delivery.controller_growth_rate_per_s,
            controller,
        })
    }

    /// True when μ exceeds one, a speed is not proven stable, or the controller itself is unstable.
    fn misses_a_target(&self, machine: &Machine) -> bool {
        let met = self.mu <= 1.0
            && self.proven_to_rpm >= OVERSPEED * machine.spindle.max_rpm
            && self.growth_rate_per_s < 0.0;
        !met
    }

    /// Why this controller is not delivered in place of `other`; empty when it is.
    fn objections(&self, other: &Self) -> Vec<&'static str> {
        let worse_zone = |k: usize| {
            let rank = |z: Option<Zone>| z.map_or(usize::MAX, |z| z as usize);
            rank(self.zones[k]) > rank(other.zones[k])
        };
        let softer = |k: usize| {
            let now = self.stiffness_n_per_m[k];
            now.is_nan() || now <= other.stiffness_n_per_m[k]
        };
        let list = [
            (
                self.mu.is_nan() || self.mu > other.mu.max(1.0),
                "µ of the whole machine exceeds one",
            ),
            (
                self.proven_to_rpm < other.proven_to_rpm,
                "stability is proven to a lower speed",
            ),
            (
                self.growth_rate_per_s >= 0.0,
                "the controller itself is unstable",
            ),
            (
                worse_zone(0) || worse_zone(1),
                "its zone of ISO 14839-3 is worse",
            ),
            (
                softer(0) || softer(1),
                "its tool is not stiffer both at rest and at top speed",
            ),
        ];
        list.into_iter()
            .filter_map(|(holds, words)| holds.then_some(words))
            .collect()
    }
}

/// A polish from one start.
#[derive(Clone, Debug)]
pub struct PolishAttempt {
    /// Where it started, in words.
    pub start: &'static str,
    /// The polished controller; none when the polish could not start.
    pub judged: Option<Judged>,
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
    /// Attempts: from the D-K iteration, and, where that misses a target, from a tuned PID.
    pub attempts: Vec<PolishAttempt>,
    /// Number of the attempt whose controller is delivered; none: that of the D-K iteration is.
    pub delivered: Option<usize>,
    /// The outcome in a sentence or two.
    pub sentence: String,
}

/// End of zone A (|S| = 3) less 2 %, for peaks between the lines and for rounding.
const SENSITIVITY: f64 = 0.98 * 3.0;
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

/// Limits of a polish, from the machine.
fn limits(machine: &Machine) -> Result<LoopLimits, PipelineError> {
    let spindle = &machine.spindle;
    let bias = spindle
        .front
        .bias_current_a
        .min(spindle.rear.bias_current_a);
    let noise = spindle.electronics.sensor_noise_m;
    let nyquist_hz = 0.5 * spindle.electronics.sample_rate_hz;
    Ok(LoopLimits {
        stiffness_band_hz: (BAND_HZ.0, BAND_HZ.1.min(0.98 * nyquist_hz)),
        sensitivity: SENSITIVITY,
        shifted_sensitivity: SHIFTED_SENSITIVITY,
        high_frequency_hz: high_frequency_hz(machine)?,
        high_frequency_gain_a_per_m: NOISE_SHARE * bias / noise,
        sensor_noise_m: noise,
        noise_current_a: NOISE_SHARE * bias,
        mu: MU,
    })
}

/// The largest μ of the specification with a controller of one plane, and its frequency, Hz: certified at rest, on the exact
/// responses at rest, top speed and beyond.
fn certificate(
    machine: &Machine,
    weights: &Weights,
    problems: &Problems,
    plane: &StateSpace<Discrete>,
) -> Result<(f64, f64), PipelineError> {
    const STAGE: &str = "certificate of the polish";
    let scaled = scaled_plane(plane)?;
    let rest = certified(STAGE, &problems.specification, &scaled, problems.period_s)?;
    let law = both_planes(plane);
    let mut worst: PeakFigures = rest;
    for share in [0.0, 1.0, OVERSPEED] {
        let speed = share * machine.spindle.max_rpm;
        let exact = mu_at_speed(machine, weights, &problems.written_modes, &law, speed)?;
        worst = worst.at_least(&exact);
    }
    Ok((worst.upper, worst.frequency_hz))
}

/// A polish that came to its end.
struct Polished {
    plane: StateSpace<Discrete>,
    rounds: Vec<PolishRound>,
    certificates: Vec<(f64, f64)>,
}

/// Polishes `plane` until its μ is certified, or to the lowest μ found.
fn descend(
    machine: &Machine,
    (weights, effort): (&Weights, PolishEffort),
    problems: &Problems,
    plane: &StateSpace<Discrete>,
) -> Result<Polished, PipelineError> {
    let task = PolishTask {
        weights,
        modes: &problems.written_modes,
        limits: limits(machine)?,
    };
    let mut polisher = Polisher::new(machine, task, plane, OVERSPEED)?;
    let mut rounds = vec![polisher.figures()];
    for _ in 0..effort.rounds {
        rounds.push(polisher.round(effort.steps)?);
    }
    let mut certificates: Vec<(f64, f64)> = vec![];
    let mut best: Option<(f64, StateSpace<Discrete>)> = None;
    for cut in 0..=effort.cuts {
        let found = polisher.plane()?;
        let (mu, at_hz) = certificate(machine, weights, problems, &found)?;
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
    }
    Ok(Polished {
        plane: best.map_or_else(|| plane.clone(), |(_, found)| found),
        rounds,
        certificates,
    })
}

/// Polishes `plane`, of which `dk` is the delivery, and decides which controller is delivered. Where that of the D-K iteration
/// misses a target, the polish starts from a tuned PID as well.
pub(super) fn polished(
    machine: &Machine,
    asked: (&Weights, usize, PolishEffort),
    problems: &Problems,
    plane: &StateSpace<Discrete>,
    dk: Delivery,
) -> Result<(Delivery, PolishOutcome), PipelineError> {
    let mut outcome = PolishOutcome {
        dk: Judged::of(machine, "dk", &dk)?,
        limits: limits(machine)?,
        attempts: vec![],
        delivered: None,
        sentence: String::new(),
    };
    let mut best = (dk, outcome.dk.clone());
    let mut starts = vec![("D-K iteration", Ok(plane.clone()))];
    if outcome.dk.misses_a_target(machine) {
        starts.push(("tuned PID", tuned_pid(machine)));
    }
    for (start, plane) in starts {
        let mut attempt = PolishAttempt {
            start,
            judged: None,
            rounds: vec![],
            certificates: vec![],
            failure: None,
        };
        let done = plane.and_then(|plane| {
            let found = descend(machine, (asked.0, asked.2), problems, &plane)?;
            let candidate = deliver(machine, asked.0, problems, asked.1, &found.plane)?;
            Ok((Judged::of(machine, "mu", &candidate)?, candidate, found))
        });
        match done {
            Ok((judged, candidate, found)) => {
                if judged.objections(&best.1).is_empty() {
                    best = (candidate, judged.clone());
                    outcome.delivered = Some(outcome.attempts.len());
                }
                attempt.judged = Some(judged);
                attempt.rounds = found.rounds;
                attempt.certificates = found.certificates;
            }
            // What an earlier start or the D-K iteration gave stands, and the outcome says what failed.
            Err(error) => attempt.failure = Some(error.to_string()),
        }
        outcome.attempts.push(attempt);
    }
    outcome.sentence = sentence(&outcome);
    Ok((best.0, outcome))
}

/// One plane of a tuned PID, m to A.
fn tuned_pid(machine: &Machine) -> Result<StateSpace<Discrete>, PipelineError> {
    let found = tune(machine, &TuneSettings::quick(), &mut |_, _| {})?;
    let period_s = machine.spindle.electronics.sample_period_s();
    let law = match &found.controller.law {
        ControlLaw::Discrete(law) => law.clone(),
        ControlLaw::Continuous(law) => {
            tustin(law, period_s).map_err(PipelineError::numeric("discretisation of the PID"))?
        }
    };
    Ok(connected_part(&law.select(&[0, 2], &[0, 2])))
}

fn sentence(outcome: &PolishOutcome) -> String {
    let dk = &outcome.dk;
    let micro = |k: f64| {
        if k.is_nan() {
            "none (unstable loop)".to_owned()
        } else {
            format!("{:.2} N/µm", 1e-6 * k)
        }
    };
    let figures = |attempt: &PolishAttempt, judged: &Judged| {
        format!(
            "The polish from the {} has a smallest tool stiffness of {} at rest and {} at top speed (D-K iteration: {} and {}), \
             µ of the specification at most {} from rest to 1.2 times the top speed",
            attempt.start,
            micro(judged.stiffness_n_per_m[0]),
            micro(judged.stiffness_n_per_m[1]),
            micro(dk.stiffness_n_per_m[0]),
            micro(dk.stiffness_n_per_m[1]),
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
                judged.objections(dk).join(", ")
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
