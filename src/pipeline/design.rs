//! From machine and specification to the controller that firmware runs, with a certificate for every step.
//!
//! At rest the planes decouple: one plane is designed and copied. Three generalized plants share one plane model:
//! the *specification* (Table 2 as written), the *covered* problem (mode uncertainty widened by the gyroscopic split at
//! the highest speed, so that a design at rest holds at speed), and the *synthesis* problem (covered, plus a bound on
//! the complementary sensitivity, because Table 2 alone leaves sensitivity peaks of 15–20 dB). Synthesis takes the
//! tightest bound on T that keeps μ within its target. The w plane is exact in both directions, so nothing is lost to
//! discretisation.

use super::PipelineError;
use super::comparison::Prediction;
use super::delivery::{Delivery, plane_of_law, scaled_plane};
use super::dk_design::{DkDesign, dk_design};
use super::instability::Instability;
use super::judged::{FLOOR_TOLERANCE, Judged};
use super::polish_job::{PolishJob, ZONE_A, limits};
use super::polish_outcome::PolishOutcome;
use super::polishing::{PolishedAgain, polished_again};
use super::posing::pose;
use super::problems::Problems;
use super::progress::{Event, Listener};
use super::real_corners::largest_at_corners;
use super::settings::DesignSettings;
use super::specification_scale::{SpecificationScale, specification_scale};
use super::speed_mu::refine_largest;
use super::synthesis::synthesise_for_machine;
use super::thrust::{ThrustDesign, design_thrust};
use crate::augment::channels::real_channels;
use crate::augment::weights::Weights;
use crate::controller::stiffness_limit::{StiffnessLimit, TAPS, stiffness_limit};
use crate::controller::{ControlLaw, Controller};
use crate::robust::dk::scale::DScales;
use crate::spindle::Machine;

/// A finished design.
#[derive(Clone, Debug)]
pub struct Design {
    /// The problems it solves.
    pub problems: Problems,
    /// Constant scales of the synthesis problem, one per block.
    pub constant_scales: Vec<f64>,
    /// What the D-K iteration led to; none where it was left out because the polish of an earlier design meets every
    /// goal.
    pub dk: Option<DkDesign>,
    /// What the polish did, when it was asked for.
    pub polish: Option<PolishOutcome>,
    /// What is delivered, with its certificates.
    pub delivery: Delivery,
    /// Largest μ of the delivered controller at rest, specification as written, over the corners of k_i and k_s, where
    /// the specification says that they are uncertain.
    pub real_corner_mu: Option<f64>,
    /// Where μ exceeds one: the factor on the limits at which the specification is met.
    pub specification_scale: Option<SpecificationScale>,
    /// Least tool stiffness over what the weights ask for (`tool_stiffness`), at rest and at top speed; none where they
    /// ask for none.
    pub share_of_floors: Option<f64>,
    /// Where the loop is unstable; none where every speed computed is stable.
    pub instability: Option<Instability>,
    /// The controller of the thrust axis, where the machine has one.
    pub thrust: Option<ThrustDesign>,
}

/// What is said of a controller whose loop is unstable, or not proven stable.
pub(crate) const NO_FIRMWARE: &str =
    "No firmware is written; with --force-unverified an export makes it all the same and says so in the files.";

impl Design {
    /// True when the loop is stable at every speed from rest to the top speed, between those computed as well.
    pub fn is_stable(&self) -> bool {
        self.delivery.verification.is_proven()
    }

    /// True when the controller goes to firmware: its loop is proven stable at every speed to the top speed, and none
    /// computed beyond is unstable.
    pub(crate) fn has_firmware(&self) -> bool {
        self.is_stable() && self.instability.is_none()
    }

    /// That the loop is unstable and why, with what was searched for one that is not; none where it is stable at every
    /// speed computed.
    pub(crate) fn instability_words(&self) -> Option<String> {
        let words = self.instability.as_ref()?.words();
        let searched = self.polish.as_ref().and_then(|polish| polish.surviving.as_ref());
        let searched = searched.map(|search| format!(" {}", search.words()));
        Some(format!("{words}{} {NO_FIRMWARE}", searched.unwrap_or_default()))
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
        let mut judged = polish.dk.iter().chain(polished);
        let own = judged.find(|j| j.controller.law.is_same(&controller.law))?;
        Some(own.predictions.clone().map(|prediction| Prediction { name: controller.name.clone(), ..prediction }))
    }

    /// True when the delivered controller has no pole outside the circle.
    pub(crate) fn controller_is_stable(&self) -> bool {
        self.delivery.controller_growth_rate_per_s < 0.0
    }

    /// Whether the delivered controller is stable itself, in a sentence.
    pub(crate) fn own_stability_sentence(&self) -> String {
        let polished = self.polish.as_ref().is_some_and(|p| p.delivered.is_some());
        match &self.dk {
            Some(dk) if !polished => dk.own_stability.sentence(self.delivery.controller_growth_rate_per_s),
            _ => format!(
                "The controller itself is stable: the polish keeps its poles inside the circle, the slowest decays at \
                 {:.3} 1/s.",
                -self.delivery.controller_growth_rate_per_s
            ),
        }
    }

    /// D-scales of the synthesis problem: those of the D-K iteration times the constant scales, or these alone.
    pub(super) fn scales(&self) -> DScales {
        match &self.dk {
            Some(dk) => dk.scales.clone(),
            None => DScales::identity(self.constant_scales.len()).times(&self.constant_scales),
        }
    }

    /// The smallest tool stiffness at rest, maximised over all linear controllers within the limits of the polish and
    /// within zone A: what the delivered one is to be measured by.
    pub(crate) fn stiffness_limit(&self, machine: &Machine) -> Result<StiffnessLimit, PipelineError> {
        let limits = limits(machine, ZONE_A)?;
        let law = plane_of_law(machine, &self.delivery.controller)?;
        Ok(stiffness_limit(machine, &limits, &law, TAPS)?)
    }

    /// Slowest decay of the loop at the speeds of the verification, from rest to top speed, and the least that the
    /// weights ask for, 1/s; none where they ask for none.
    pub(crate) fn least_decay(&self) -> Option<[f64; 2]> {
        let asked = self.problems.aim.least_decay_per_s?;
        let slowest = -self.delivery.verification.worst_growth_rate_per_s()?;
        Some([slowest, asked])
    }

    /// True when the tool is as stiff as the weights ask for.
    pub(crate) fn holds_floors(&self) -> bool {
        self.share_of_floors.is_none_or(|share| share >= 1.0 - FLOOR_TOLERANCE)
    }

    /// True when the specification is met at rest and at speed, the loop decays as fast as it asks, the tool is as
    /// stiff, and every speed from rest to 20 % above the top speed is proven stable.
    pub fn meets_targets(&self) -> bool {
        let decays = self.least_decay().is_none_or(|[slowest, asked]| slowest >= asked);
        decays
            && self.holds_floors()
            && self.largest_mu() <= 1.0
            && self.is_stable()
            && self.delivery.speed_proof.is_complete()
    }
}

/// The whole design, and for the listener what the polish and the scale of the specification have come to.
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

/// The whole design: the thrust axis, where the machine has one, and the four radial axes. Where the polish of an
/// earlier design that suffices meets every goal, it is delivered, and no D-K iteration is run.
///
/// # Errors
/// [`PipelineError`] says which stage failed.
pub fn design(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
    progress: &mut Listener,
) -> Result<Design, PipelineError> {
    // First, because it takes a second and its failure ends the design.
    let thrust = design_thrust(machine)?;
    let radial = design_radial(machine, weights, settings, progress)?;
    Ok(Design { thrust, ..radial })
}

/// The design of the four radial axes.
fn design_radial(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
    progress: &mut Listener,
) -> Result<Design, PipelineError> {
    let weights = &weights.on(machine)?;
    let (problems, scales, _) = pose(machine, weights, settings)?;
    progress(Event::Stage("problems and constant scales"));
    let job = PolishJob::set_up_job(machine, weights, &problems, settings);
    let again = job.zip(settings.earlier.as_ref()).map(|(job, earlier)| {
        progress(Event::Begins("polish of the earlier design"));
        polished_again(job, earlier)
    });
    let entrant = match again.transpose()? {
        Some(PolishedAgain::Delivered(made)) => {
            let (delivery, outcome) = *made;
            let made = (None, (delivery, Some(outcome)));
            return finish_design(machine, weights, (problems, scales), made, progress);
        }
        Some(PolishedAgain::Entrant(entrant)) => {
            progress(Event::Begins("design from the D-K iteration"));
            Some(*entrant)
        }
        None => None,
    };
    let found = synthesise_for_machine(machine, weights, settings, (problems, scales), progress)?;
    let (dk, made) = dk_design(machine, weights, settings, &found, entrant)?;
    progress(Event::Stage("reduction, polish and certificates"));
    let posed = (found.problems, found.scales);
    finish_design(machine, weights, posed, (Some(dk), made), progress)
}

/// The design of a delivery, with what is said of the delivered controller only.
fn finish_design(
    machine: &Machine,
    weights: &Weights,
    (problems, constant_scales): (Problems, Vec<f64>),
    (dk, (mut delivery, polish)): (Option<DkDesign>, (Delivery, Option<PolishOutcome>)),
    progress: &mut Listener,
) -> Result<Design, PipelineError> {
    let specification_scale = match &delivery.controller.law {
        ControlLaw::Discrete(law) => {
            delivery.speed_mu =
                refine_largest(machine, weights, &problems.written_modes, law, std::mem::take(&mut delivery.speed_mu))?;
            specification_scale(machine, weights, &problems, law, &delivery.speed_mu)?
        }
        ControlLaw::Continuous(_) => None,
    };
    progress(Event::Stage("scale of the specification"));
    let real = real_channels(problems.written_modes.len(), weights)
        .map_err(PipelineError::numeric("uncertainty of the specification"))?;
    let delivered = scaled_plane(&plane_of_law(machine, &delivery.controller)?)?;
    let real_corner_mu = largest_at_corners(&problems.specification, &delivered, &real)?;
    let instability = Instability::of(machine, &problems, &delivery)?;
    let floors = &weights.tool_stiffness;
    let measured = || Judged::of(machine, "mu", &delivery)?.measured_by(machine, floors);
    let judged = (!floors.is_empty()).then(measured);
    let share_of_floors = judged.transpose()?.map(|judged| judged.share_of_floors);
    Ok(Design {
        problems,
        constant_scales,
        dk,
        polish,
        delivery,
        real_corner_mu,
        specification_scale,
        share_of_floors,
        instability,
        thrust: None,
    })
}
