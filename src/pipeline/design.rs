//! From machine and specification to the controller that firmware runs, with a certificate for every step.
//!
//! At rest the planes decouple: one plane is designed and copied. Three generalized plants share one plane model:
//! the *specification* (Table 2 as written), the *covered* problem (mode uncertainty widened by the gyroscopic split at
//! the highest speed, so that a design at rest holds at speed), and the *synthesis* problem (covered, plus a bound on
//! the complementary sensitivity, because Table 2 alone leaves sensitivity peaks of 15–20 dB). Synthesis takes the
//! tightest bound on T that keeps μ within its target. The w plane is exact in both directions, so nothing is lost to
//! discretisation.

use super::PipelineError;
use super::certificates::{DScaleCurve, KnownStage, Stage, d_scales, stage};
use super::comparison::Prediction;
use super::delivery::{Candidate, Delivery, Realised, plane_of_law, scaled_plane};
use super::emulation::Emulated;
use super::polish_job::{PolishJob, ZONE_A, limits};
use super::polishing::{PolishOutcome, polished};
use super::problems::Problems;
use super::progress::{Event, Listener};
use super::real_corners::largest_at_corners;
use super::reduction::reduce;
use super::settings::DesignSettings;
use super::specification_scale::{SpecificationScale, specification_scale};
use super::stable::OwnStability;
use super::synthesis::{Round, Synthesised, synthesise_for_machine};
use crate::augment::assembly::unscale_controller;
use crate::augment::channels::real_channels;
use crate::augment::weights::Weights;
use crate::controller::stiffness_limit::{StiffnessLimit, TAPS, stiffness_limit};
use crate::controller::{ControlLaw, Controller};
use crate::lti::sample::tustin;
use crate::lti::{Continuous, StateSpace};
use crate::robust::dk::DkStep;
use crate::robust::dk::scale::DScales;
use crate::spindle::Machine;

/// A finished design.
#[derive(Clone, Debug)]
pub struct Design {
    /// The problems it solves.
    pub problems: Problems,
    /// Records of the D-K iteration on the synthesis problem.
    pub steps: Vec<DkStep>,
    /// Syntheses with more modes or a lower level that μ of the whole machine asked for; the last is the first within
    /// target.
    pub rounds: Vec<Round>,
    /// D-scales of the best step beside what the pointwise bound of its loop asks for.
    pub d_scales: Vec<DScaleCurve>,
    /// The D-scales of the best step times the constant scales that it started from.
    pub scales: DScales,
    /// Those constant scales, one per block.
    pub constant_scales: Vec<f64>,
    /// γ of the best step.
    pub gamma: f64,
    /// Orders of the D-scales of the best step, summed over the blocks.
    pub d_order: usize,
    /// Stability of the controller itself.
    pub own_stability: OwnStability,
    /// What sampling did, on the emulation route.
    pub emulated: Option<Emulated>,
    /// What the polish did, when it was asked for.
    pub polish: Option<PolishOutcome>,
    /// Level that μ of the synthesis problem had to keep in reduction.
    pub reduction_limit: f64,
    /// Controller of one plane as synthesised.
    pub full: Stage,
    /// After reduction.
    pub reduced: Stage,
    /// μ against order tried in reduction: (order, μ of the covered problem).
    pub orders_tried: Vec<(usize, f64)>,
    /// What is delivered, with its certificates.
    pub delivery: Delivery,
    /// Largest μ of the delivered controller at rest, specification as written, over the corners of k_i and k_s, where
    /// the specification says that they are uncertain.
    pub real_corner_mu: Option<f64>,
    /// Where μ exceeds one: the factor on the limits at which the specification is met.
    pub specification_scale: Option<SpecificationScale>,
}

impl Design {
    /// True when the loop is stable at every speed from rest to the top speed, between those computed as well.
    pub fn is_stable(&self) -> bool {
        self.delivery.verification.is_proven()
    }

    /// Largest μ of the specification from rest to 20 % above the top speed: certified at rest, on the exact responses
    /// with the true gyroscopics over speed.
    pub fn largest_mu(&self) -> f64 {
        self.delivery.largest_mu()
    }

    /// The loop at rest and at top speed with a controller that the polish judged.
    pub(super) fn judged_with(&self, controller: &Controller) -> Option<[Prediction; 2]> {
        let polish = self.polish.as_ref()?;
        let polished = polish.attempts.iter().filter_map(|a| a.judged.as_ref());
        let mut judged = std::iter::once(&polish.dk).chain(polished);
        let own = judged.find(|j| j.controller.law.is_same(&controller.law))?;
        Some(own.predictions.clone().map(|prediction| Prediction {
            name: controller.name.clone(),
            ..prediction
        }))
    }

    /// True when the delivered controller has no pole outside the circle.
    pub(crate) fn controller_is_stable(&self) -> bool {
        self.delivery.controller_growth_rate_per_s < 0.0
    }

    /// Whether the delivered controller is stable itself, in a sentence.
    pub(crate) fn own_stability_sentence(&self) -> String {
        let polished = self.polish.as_ref().is_some_and(|p| p.delivered.is_some());
        match polished {
            true => format!(
                "The controller itself is stable: the polish keeps its poles inside the circle, the slowest decays at \
                 {:.3} 1/s.",
                -self.delivery.controller_growth_rate_per_s
            ),
            false => self.own_stability.sentence(),
        }
    }

    /// The smallest tool stiffness at rest, maximised over all linear controllers within the limits of the polish and
    /// within zone A: what the delivered one is to be measured by.
    ///
    /// # Errors
    /// [`PipelineError`] when the delivered controller is unstable itself or does not levitate the machine, or the
    /// convex problem has no answer.
    pub(crate) fn stiffness_limit(
        &self,
        machine: &Machine,
    ) -> Result<StiffnessLimit, PipelineError> {
        let limits = limits(machine, ZONE_A)?;
        let law = plane_of_law(machine, &self.delivery.controller)?;
        Ok(stiffness_limit(machine, &limits, &law, TAPS)?)
    }

    /// True when the specification is met at rest and at speed and every speed from rest to 20 % above the top speed is
    /// proven stable.
    pub(crate) fn meets_targets(&self) -> bool {
        self.largest_mu() <= 1.0 && self.is_stable() && self.delivery.speed_proof.is_complete()
    }
}

/// The whole design, and for the listener what the polish and the scale of the specification have come to.
///
/// # Errors
/// As [`design`].
pub(crate) fn design_in_words(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
    progress: &mut Listener,
) -> Result<Design, PipelineError> {
    progress(Event::Begins("design"));
    let found = design(machine, weights, settings, progress)?;
    if let Some(polish) = &found.polish {
        progress(Event::Found(&polish.sentence));
    }
    if let Some(scale) = &found.specification_scale {
        progress(Event::Found(&scale.sentence()));
    }
    Ok(found)
}

/// What a controller of scaled signals in the w plane becomes: sampled, polished where that is asked, rounded and
/// proven.
fn delivered(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
    (problems, reduced): (&Problems, &StateSpace<Continuous>),
) -> Result<(Delivery, Option<PolishOutcome>), PipelineError> {
    let period_s = machine.spindle.electronics.sample_period_s();
    let physical = unscale_controller(reduced);
    let sampled = tustin(&physical, period_s).map_err(PipelineError::numeric("discretisation"))?;
    let Some(effort) = &settings.polish else {
        let realised = Realised::new(machine, &sampled)?;
        let from_dk = Candidate::new(machine, weights, problems, realised)?;
        let proof = from_dk.proof(machine)?;
        let delivery = from_dk.delivered(machine, problems, settings.speeds, proof)?;
        return Ok((delivery, None));
    };
    let job = PolishJob {
        machine,
        weights,
        problems,
        speeds: settings.speeds,
        effort: *effort,
        earlier: settings.earlier.as_ref().map(|e| &e.plane),
    };
    let (delivery, outcome) = polished(job, &sampled)?;
    Ok((delivery, Some(outcome)))
}

/// The whole design.
///
/// # Errors
/// [`PipelineError`] says which stage failed.
pub fn design(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
    progress: &mut Listener,
) -> Result<Design, PipelineError> {
    let weights = &weights.on(machine)?;
    let Synthesised {
        problems,
        scales,
        outcome,
        own_stability,
        full,
        synthesis,
        emulated,
        rounds,
    } = synthesise_for_machine(machine, weights, settings, progress)?;
    let known = |synthesis: f64| KnownStage {
        synthesis: Some(synthesis),
        ..KnownStage::default()
    };
    let reduction_limit = synthesis * (1.0 + settings.reduction_budget);
    let deliver = || {
        let reduced = reduce(&problems, &scales, &full, synthesis, reduction_limit)?;
        let (made, at_reduced) = rayon::join(
            || delivered(machine, weights, settings, (&problems, &reduced.controller)),
            || {
                let known = known(reduced.synthesis);
                stage("reduced order", &problems, &reduced.controller, known)
            },
        );
        Ok::<_, PipelineError>((reduced.tried, at_reduced?, made?))
    };
    // What only the report says of the controller as synthesised is computed beside what is delivered.
    let (made, (d_scales, full_stage)) = rayon::join(deliver, || {
        rayon::join(
            || d_scales(&problems, &scales, &outcome),
            || stage("full order", &problems, &full, known(synthesis)),
        )
    });
    let (d_scales, full_stage) = (d_scales?, full_stage?);
    let (orders_tried, reduced_stage, (delivery, polish)) = made?;
    progress(Event::Stage("reduction, polish and certificates"));
    let specification_scale = match &delivery.controller.law {
        ControlLaw::Discrete(law) => specification_scale(
            machine,
            (weights, &problems.written_modes),
            law,
            &delivery.speed_mu,
        )?,
        ControlLaw::Continuous(_) => None,
    };
    progress(Event::Stage("scale of the specification"));
    let real = real_channels(problems.written_modes.len(), weights)
        .map_err(PipelineError::numeric("uncertainty of the specification"))?;
    let delivered = scaled_plane(&plane_of_law(machine, &delivery.controller)?)?;
    let real_corner_mu = largest_at_corners(&problems.specification, &delivered, &real)?;
    Ok(Design {
        rounds,
        specification_scale,
        real_corner_mu,
        own_stability,
        emulated,
        polish,
        delivery,
        scales: outcome.scales.times(&scales),
        constant_scales: scales,
        gamma: outcome.gamma,
        d_order: outcome
            .steps
            .get(outcome.best_iteration)
            .map_or(0, |s| s.d_orders.iter().sum()),
        reduction_limit,
        d_scales,
        steps: outcome.steps,
        full: full_stage,
        reduced: reduced_stage,
        orders_tried,
        problems,
    })
}
