//! A sampled controller of one plane as firmware runs it, with every certificate: realisation, rounding, μ of the whole
//! machine, stability over speed, arithmetics.

use super::PipelineError;
use super::certificates::{KnownStage, PeakFigures, Stage, attained_gain, mu_curve, stage};
use super::overspeed::{OVERSPEED, OVERSPEEDS};
use super::problems::Problems;
use super::speed_mu::{SpeedMu, compared_speeds, delivered_speeds, mu_at_speed, mu_over_speed};
use crate::augment::GeneralizedPlant;
use crate::augment::assembly::scale_controller;
use crate::augment::plane::{LOADS, x_plane};
use crate::augment::weights::Weights;
use crate::controller::anti_windup::firmware_rows;
use crate::controller::arithmetic::q31;
use crate::controller::polish::SPEEDS_BETWEEN;
use crate::controller::scaling::ScaledRealisation;
use crate::controller::speed_proof::{SpeedProof, prove};
use crate::controller::verification::{Verification, verify, verify_at};
use crate::controller::{ControlLaw, Controller};
use crate::lti::sample::{inverse_tustin, tustin};
use crate::lti::{Continuous, Discrete, StateSpace};
use crate::predict::closed_loop::{both_planes, compliance};
use crate::spindle::{Machine, ModelDetail, Plant};
use rayon::prelude::*;

/// The controller in one arithmetic, closed with the design problems.
#[derive(Clone, Debug)]
pub struct Arithmetic {
    /// float64, float32, Q31.
    pub name: &'static str,
    /// Largest bound of μ found for the specification; infinite when the loop is unstable.
    pub specification: f64,
    /// The same for the covered problem.
    pub covered: f64,
    /// The controller with those coefficients.
    pub controller: Controller,
}

/// A controller with its certificates.
#[derive(Clone, Debug)]
pub struct Delivery {
    /// After rounding to float32, in sampled time.
    pub rounded: Stage,
    /// μ over frequency of the rounded loop on the specification: Hz, upper, lower.
    pub specification_curve: Vec<(f64, f64, f64)>,
    /// μ over frequency of the rounded loop on the covered problem.
    pub covered_curve: Vec<(f64, f64, f64)>,
    /// Growth rate of the controller's own poles, 1/s; negative: stable.
    pub controller_growth_rate_per_s: f64,
    /// Modal form with scaled states, before rounding.
    pub realisation: ScaledRealisation,
    /// The controller as it runs: four axes, sampled, coefficients rounded to float32.
    pub controller: Controller,
    /// The same in the continuous w plane, unrounded.
    pub continuous: Controller,
    /// Stability of the full sampled plant with it, over speed.
    pub verification: Verification,
    /// The same from the top speed to 20 % above it.
    pub overspeed: Verification,
    /// Stability at every speed from rest to 20 % above the top speed.
    pub speed_proof: SpeedProof,
    /// μ of the specification with the true gyroscopics, over speed.
    pub speed_mu: Vec<SpeedMu>,
    /// μ with float64, float32 and Q31 coefficients; without Q31 when its range does not hold them.
    pub arithmetic: Vec<Arithmetic>,
    /// Static stiffness at tool, front and rear actuator at rest, N/m.
    pub static_stiffness_n_per_m: [f64; LOADS],
}

impl Delivery {
    /// Largest μ of the specification: certified at rest, on the exact responses over speed.
    pub(crate) fn largest_mu(&self) -> f64 {
        largest_mu(&self.rounded, &self.speed_mu)
    }

    /// Those of the speeds between rest and the top speed that a polish knows, as shares of it, at which μ exceeds one
    /// and all that it is at rest, at top speed and beyond.
    pub(super) fn higher_between(&self, machine: &Machine) -> Vec<f64> {
        let top = machine.spindle.max_rpm;
        let ends = self.speed_mu.iter().filter(|at| at.speed_rpm == 0.0 || at.speed_rpm >= top);
        let limit = ends.map(|at| at.mu).fold(1.0, f64::max);
        let apart = |at: &SpeedMu, share: f64| (at.speed_rpm - share * top).abs();
        let at = |share: f64| self.speed_mu.iter().min_by(|a, b| apart(a, share).total_cmp(&apart(b, share)));
        SPEEDS_BETWEEN.into_iter().filter(|share| at(*share).is_some_and(|at| at.mu > limit)).collect()
    }

    /// The largest μ over speed, its speed and frequency.
    pub(super) fn largest_over_speed(&self) -> Option<SpeedMu> {
        self.speed_mu.iter().copied().max_by(|a, b| a.mu.total_cmp(&b.mu))
    }
}

/// A sampled controller of one plane as firmware would run it.
pub(super) struct Realised {
    /// The controller of one plane before realisation, m to A.
    plane: StateSpace<Discrete>,
    realisation: ScaledRealisation,
    /// The controller as it runs: the scaled rows with float32 coefficients.
    pub law: StateSpace<Discrete>,
    /// Its x plane in the scaled signals of the w plane, which closes the design plane.
    pub rounded_plane: StateSpace<Continuous>,
}

impl Realised {
    /// Realises and rounds the sampled controller `plane` of one plane (m to A).
    pub(super) fn new(machine: &Machine, plane: &StateSpace<Discrete>) -> Result<Self, PipelineError> {
        let (realisation, _) = firmware_rows(&both_planes(plane), machine)?;
        let law = realisation.rows.rounded_f32()?;
        Ok(Self { plane: plane.clone(), rounded_plane: plane_of(&law)?, realisation, law })
    }
}

/// What is known of μ of the specification as written with a realised controller.
#[derive(Clone)]
pub(super) struct KnownMu {
    /// Certified at rest.
    pub at_rest: PeakFigures,
    /// On the exact responses at some speeds.
    pub over_speed: Vec<SpeedMu>,
}

impl KnownMu {
    /// The largest, its speed and frequency.
    pub(super) fn largest(&self) -> SpeedMu {
        let rest = SpeedMu { speed_rpm: 0.0, mu: self.at_rest.upper, frequency_hz: self.at_rest.frequency_hz };
        let larger = |a: SpeedMu, b: &SpeedMu| if b.mu > a.mu { *b } else { a };
        let found = self.over_speed.iter().fold(rest, larger);
        SpeedMu { frequency_hz: found.frequency_hz.abs(), ..found }
    }
}

/// A realised controller with the certificates that decide whether it is delivered but for the proof of its stability
/// over speed.
pub(super) struct DeliveryCandidate {
    realised: Realised,
    /// After rounding to float32, in sampled time.
    pub rounded: Stage,
    /// Growth rate of the controller's own poles, 1/s.
    pub growth_rate_per_s: f64,
    /// μ of the specification over speed; infinite where the loop is unstable.
    speed_mu: Vec<SpeedMu>,
}

impl DeliveryCandidate {
    /// A realised controller with its μ at rest and over speed.
    pub(super) fn new(
        machine: &Machine,
        weights: &Weights,
        problems: &Problems,
        realised: Realised,
    ) -> Result<Self, PipelineError> {
        Ok(Self::beside(machine, (weights, problems), (realised, None), &|_| ())?.0)
    }

    /// As [`Self::new`], with the proof of its stability over speed and what is known of its μ already.
    pub(super) fn prove_candidate(
        machine: &Machine,
        weights: &Weights,
        problems: &Problems,
        realised: Realised,
        known: Option<KnownMu>,
    ) -> Result<(Self, SpeedProof), PipelineError> {
        let proof = |law: &StateSpace<Discrete>| prove_law(machine, law);
        let from = (realised, known);
        let (candidate, proof) = Self::beside(machine, (weights, problems), from, &proof)?;
        Ok((candidate, proof?))
    }

    /// As [`Self::new`], with what is computed of its law in the meantime.
    fn beside<T: Send>(
        machine: &Machine,
        (weights, problems): (&Weights, &Problems),
        (realised, known): (Realised, Option<KnownMu>),
        further: &(dyn Fn(&StateSpace<Discrete>) -> T + Sync),
    ) -> Result<(Self, T), PipelineError> {
        let (law, plane) = (&realised.law, &realised.rounded_plane);
        let (known_at_rest, known_over_speed) =
            known.map_or((None, vec![]), |known| (Some(known.at_rest), known.over_speed));
        let known = KnownStage { specification: known_at_rest, synthesis: None };
        let at_rest = || stage("rounded", problems, plane, known);
        let over_speed = || {
            let (aim, modes) = (&problems.aim, &problems.covered_modes);
            let written = &problems.written_modes;
            let (over_speed, covered) = rayon::join(
                || mu_over_speed(machine, weights, written, law, &compared_speeds(machine), &known_over_speed),
                || mu_at_speed(machine, aim, modes, law, 0.0),
            );
            Ok::<_, PipelineError>((over_speed?, covered?))
        };
        let ((certified, over_speed), further) = rayon::join(|| rayon::join(at_rest, over_speed), || further(law));
        let (certified, (speed_mu, covered_at_rest)) = (certified?, over_speed?);
        let at_rest = speed_mu.iter().filter(|s| s.speed_rpm == 0.0);
        let rounded = Stage {
            specification: at_rest.fold(certified.specification, |peak, s| peak.at_least(s)),
            covered: certified.covered.at_least(&covered_at_rest),
            ..certified
        };
        let growth_rate_per_s = realised.plane.growth_rate().map_err(PipelineError::numeric("controller poles"))?;
        let candidate = Self { realised, rounded, growth_rate_per_s, speed_mu };
        Ok((candidate, further))
    }

    /// The controller as it runs.
    pub(super) fn law(&self) -> &StateSpace<Discrete> {
        &self.realised.law
    }

    /// Largest μ of the specification, as [`Delivery::largest_mu`].
    pub(super) fn largest_mu(&self) -> f64 {
        largest_mu(&self.rounded, &self.speed_mu)
    }

    /// What a proof may reach at most: the first speed of [`Self::speed_mu`] with an unstable loop, or
    /// [`OVERSPEED`] times the top speed, rpm.
    pub(super) fn provable_to_rpm(&self, machine: &Machine) -> f64 {
        let unstable = self.speed_mu.iter().filter(|s| !s.mu.is_finite());
        unstable.map(|s| s.speed_rpm).fold(OVERSPEED * machine.spindle.max_rpm, f64::min)
    }

    /// Proof of stability from rest to [`OVERSPEED`] times the top speed.
    pub(super) fn proof(&self, machine: &Machine) -> Result<SpeedProof, PipelineError> {
        prove_law(machine, self.law())
    }

    /// The delivery, with the proof and what the reader of a report asks beyond it; `speeds` are those of the
    /// verification.
    pub(super) fn deliver_candidate(
        self,
        machine: &Machine,
        weights: &Weights,
        problems: &Problems,
        speeds: usize,
        speed_proof: SpeedProof,
    ) -> Result<Delivery, PipelineError> {
        const CONDITIONS: &str = "full finite-element plant, exact delay, sampled; coefficients rounded to float32";
        let faster = OVERSPEEDS.map(|share| share * machine.spindle.max_rpm);
        let Realised { plane, realisation, law, rounded_plane } = self.realised;
        let verified = || {
            rayon::join(
                || verify(machine, &law, speeds, CONDITIONS),
                || verify_at(machine, &law, &faster, "as below the top speed"),
            )
        };
        let over_speed = || {
            let written = &problems.written_modes;
            mu_over_speed(machine, weights, written, &law, &delivered_speeds(machine), &self.speed_mu)
        };
        let ((verification, overspeed), (arithmetic, speed_mu)) = rayon::join(verified, || {
            rayon::join(|| arithmetics(&realisation, &law, problems, &self.rounded), over_speed)
        });
        let verification = Verification {
            mu_peak: Some(self.rounded.specification.upper).filter(|mu| mu.is_finite()),
            proof: Some(speed_proof.clone()),
            ..verification?
        };
        let at_rest = Plant::new(machine, 0.0, ModelDetail::Full)?;
        let compliance_at_rest = compliance(&at_rest, &law, 0.0);
        let curve =
            |plant: &GeneralizedPlant, peak: &PeakFigures| mu_curve(plant, &rounded_plane, peak, problems.period_s);
        let back = inverse_tustin(&plane).map_err(PipelineError::numeric("continuous controller"))?;
        Ok(Delivery {
            speed_proof,
            arithmetic: arithmetic?,
            static_stiffness_n_per_m: [0, 2, 4].map(|k| compliance_at_rest[(k, k)].norm().recip()),
            specification_curve: curve(&problems.specification, &self.rounded.specification)?,
            covered_curve: curve(&problems.covered, &self.rounded.covered)?,
            rounded: self.rounded,
            speed_mu: speed_mu?,
            controller_growth_rate_per_s: self.growth_rate_per_s,
            realisation,
            controller: name_law("mu", ControlLaw::Discrete(law)),
            continuous: name_law("mu", ControlLaw::Continuous(both_planes(&back))),
            verification,
            overspeed: overspeed?,
        })
    }
}

/// Proof of stability with a four-axis law from rest to [`OVERSPEED`] times the top speed.
fn prove_law(machine: &Machine, law: &StateSpace<Discrete>) -> Result<SpeedProof, PipelineError> {
    Ok(prove(machine, law, OVERSPEED * machine.spindle.max_rpm)?)
}

/// μ with float64, float32 and Q31 coefficients; that of float32, which is delivered, is known.
fn arithmetics(
    realisation: &ScaledRealisation,
    rounded: &StateSpace<Discrete>,
    problems: &Problems,
    known: &Stage,
) -> Result<Vec<Arithmetic>, PipelineError> {
    let laws = [
        ("float64", Some(realisation.rows.to_state_space()?), None),
        ("float32", Some(rounded.clone()), Some(known)),
        // A range that Q31 does not hold is said by the firmware export; the design stands without it.
        ("Q31", q31(realisation).and_then(|p| p.to_rounded_system()).ok(), None),
    ];
    laws.into_par_iter()
        .filter_map(|(name, law, known)| Some((name, law?, known)))
        .map(|(name, law, known)| {
            let plane = plane_of(&law)?;
            let mu = |plant: &GeneralizedPlant, known: Option<PeakFigures>| match known {
                Some(peak) => Ok(peak.attained),
                None => attained_gain(plant, &plane).map(|mu| mu.unwrap_or(f64::INFINITY)),
            };
            Ok(Arithmetic {
                name,
                specification: mu(&problems.specification, known.map(|k| k.specification))?,
                covered: mu(&problems.covered, known.map(|k| k.covered))?,
                controller: name_law("mu", ControlLaw::Discrete(law)),
            })
        })
        .collect()
}

/// Largest μ of the specification at rest and over speed.
fn largest_mu(rounded: &Stage, speed_mu: &[SpeedMu]) -> f64 {
    let over_speed = speed_mu.iter().map(|s| s.mu);
    over_speed.fold(rounded.specification.upper, f64::max)
}

/// The x plane of a four-axis controller, m to A, sampled by Tustin's rule if it is continuous.
pub(super) fn plane_of_law(machine: &Machine, controller: &Controller) -> Result<StateSpace<Discrete>, PipelineError> {
    let sampled = match &controller.law {
        ControlLaw::Discrete(law) => return Ok(x_plane(law)),
        ControlLaw::Continuous(law) => {
            let period_s = machine.spindle.electronics.sample_period_s();
            tustin(law, period_s).map_err(PipelineError::numeric("discretisation of the controller"))?
        }
    };
    Ok(x_plane(&sampled))
}

/// The x plane of a four-axis law in the scaled signals of the w plane.
fn plane_of(law: &StateSpace<Discrete>) -> Result<StateSpace<Continuous>, PipelineError> {
    scaled_plane(&x_plane(law))
}

/// A sampled controller of one plane (m to A) in the scaled signals of the w plane.
pub(super) fn scaled_plane(plane: &StateSpace<Discrete>) -> Result<StateSpace<Continuous>, PipelineError> {
    let back = inverse_tustin(plane).map_err(PipelineError::numeric("rounded loop"))?;
    Ok(scale_controller(&back))
}

fn name_law(name: &str, law: ControlLaw) -> Controller {
    Controller { name: name.to_owned(), law }
}
