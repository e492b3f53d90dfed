//! The polish of the reduced controller in a design: its limits from the machine, and which controller is delivered.
//!
//! Limits: |S_jj| within zone A of ISO 14839-3; current from sensor noise, rms, a thirtieth of the smaller bias current; gain
//! above the modes of the model so that sensor noise at any one frequency asks for that current at most; μ of the covered
//! problem below one. What the start of the polish cannot reach is kept where the first round brings it. The polished
//! controller goes through the same rounding and certificates, and is delivered when they are no worse and its smallest tool
//! stiffness over rest and top speed is larger; else the controller of the D-K iteration is.

use super::PipelineError;
use super::comparison::{BAND_HZ, predict};
use super::delivery::{Delivery, deliver};
use super::design::OVERSPEED;
use super::problems::Problems;
use crate::augment::weights::Weights;
use crate::controller::amplifier_demand::high_frequency_hz;
use crate::controller::polish::{LoopLimits, PolishRound, PolishSettings, polish};
use crate::controller::verification::VerificationError;
use crate::controller::{Controller, ControllerError};
use crate::lti::{Discrete, StateSpace};
use crate::spindle::Machine;

/// How long a controller is polished.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PolishEffort {
    /// Rounds of descent; the lines are renewed between them.
    pub rounds: usize,
    /// Steps of a round at most.
    pub steps: usize,
}

impl Default for PolishEffort {
    /// A hundred steps: on the reference spindle further ones add a percent.
    fn default() -> Self {
        Self {
            rounds: 2,
            steps: 50,
        }
    }
}

/// What a polish did.
#[derive(Clone, Debug)]
pub struct PolishOutcome {
    /// The controller of the D-K iteration, reduced and rounded.
    pub dk: Controller,
    /// Its order over both planes.
    pub dk_order: usize,
    /// Its μ: specification, covered problem.
    pub dk_mu: [f64; 2],
    /// Its smallest tool stiffness at rest and top speed, N/m; NaN for an unstable loop.
    pub dk_stiffness_n_per_m: [f64; 2],
    /// The same of the polished controller.
    pub stiffness_n_per_m: [f64; 2],
    /// Limits of the polish.
    pub limits: LoopLimits,
    /// What the loss said of the start, and after each round.
    pub rounds: Vec<PolishRound>,
    /// Whether the polished controller is delivered.
    pub delivered: bool,
    /// The outcome in a sentence.
    pub sentence: String,
}

/// End of zone A (|S| = 3) less 2 %, for peaks between the lines and for rounding.
const SENSITIVITY: f64 = 0.98 * 3.0;
/// Sensitivity of rotors with shifted modes relative to that.
const SHIFTED_SENSITIVITY: f64 = 1.3;
/// μ below one by what certificates find between the lines.
const MU: f64 = 0.98;
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

/// Polishes `plane`, of which `dk` is the delivery, and decides which of both is delivered.
pub(super) fn polished(
    machine: &Machine,
    (weights, speeds, effort): (&Weights, usize, PolishEffort),
    problems: &Problems,
    plane: &StateSpace<Discrete>,
    dk: Delivery,
) -> Result<(Delivery, PolishOutcome), PipelineError> {
    let limits = limits(machine)?;
    let top = machine.spindle.max_rpm;
    let softest = |controller: &Controller| -> Result<[f64; 2], PipelineError> {
        let [rest, fast] = [0.0, top].map(|rpm| predict(machine, controller, rpm));
        let minimum = |p: &super::comparison::Prediction| {
            if p.is_stable() { p.minimum.0 } else { f64::NAN }
        };
        Ok([minimum(&rest?), minimum(&fast?)])
    };
    let mut outcome = PolishOutcome {
        dk: Controller {
            name: "dk".to_owned(),
            ..dk.controller.clone()
        },
        dk_order: 2 * dk.rounded.order,
        dk_mu: [dk.rounded.specification.upper, dk.rounded.covered.upper],
        dk_stiffness_n_per_m: softest(&dk.controller)?,
        stiffness_n_per_m: [f64::NAN; 2],
        limits,
        rounds: vec![],
        delivered: false,
        sentence: String::new(),
    };
    let settings = PolishSettings {
        limits,
        rounds: effort.rounds,
        steps: effort.steps,
        overspeed: OVERSPEED,
    };
    let found = match polish(machine, weights, &problems.covered_modes, plane, &settings) {
        Ok(found) => found,
        Err(VerificationError::Loop(
            error @ (ControllerError::Infeasible { .. } | ControllerError::Inaccurate { .. }),
        )) => {
            outcome.sentence = format!("The controller was not polished: {error}.");
            return Ok((dk, outcome));
        }
        Err(error) => return Err(error.into()),
    };
    outcome.rounds.push(found.start);
    outcome.rounds.extend(&found.rounds);
    let candidate = deliver(machine, weights, problems, speeds, &found.plane)?;
    outcome.stiffness_n_per_m = softest(&candidate.controller)?;
    let least = |k: [f64; 2]| {
        if k[0].is_nan() || k[1].is_nan() {
            0.0
        } else {
            k[0].min(k[1])
        }
    };
    let (before, after) = (
        least(outcome.dk_stiffness_n_per_m),
        least(outcome.stiffness_n_per_m),
    );
    let certified = candidate.mu() <= dk.mu().max(1.0)
        && (candidate.verification.is_proven() || !dk.verification.is_proven())
        && candidate.speed_proof.proven_to_rpm()
            >= dk.speed_proof.proven_to_rpm().min(OVERSPEED * top)
        && candidate.controller_growth_rate_per_s < 0.0;
    outcome.delivered = certified && after > before;
    let micro = 1e-6;
    outcome.sentence = format!(
        "The polish brought the smallest tool stiffness over rest and top speed from {:.2} to {:.2} N/µm (µ {:.3} and {:.3} with \
         the gyroscopic split covered); {}",
        micro * before,
        micro * after,
        candidate.rounded.specification.upper,
        candidate.rounded.covered.upper,
        match (outcome.delivered, certified) {
            (true, _) => "the polished controller is delivered.",
            (_, false) =>
                "its certificates are worse, so the controller of the D-K iteration is delivered.",
            _ => "the controller of the D-K iteration is delivered.",
        }
    );
    Ok((if outcome.delivered { candidate } else { dk }, outcome))
}
