//! A sampled controller of one plane as firmware runs it, with every certificate: realisation, rounding, μ of the whole
//! machine, stability over speed, arithmetics.

use super::PipelineError;
use super::certificates::{PeakFigures, Stage, attained, mu_curve, stage};
use super::overspeed::{OVERSPEED, OVERSPEEDS};
use super::problems::Problems;
use super::speed_mu::{SpeedMu, mu_at_speed, mu_over_speed};
use crate::augment::GeneralizedPlant;
use crate::augment::assembly::{UncertainMode, scale_controller};
use crate::augment::plane::{LOADS, x_plane};
use crate::augment::weights::Weights;
use crate::controller::anti_windup::firmware_rows;
use crate::controller::arithmetic::q31;
use crate::controller::scaling::ScaledRealisation;
use crate::controller::speed_proof::{SpeedProof, prove};
use crate::controller::verification::{Verification, verify, verify_at};
use crate::controller::{ControlLaw, Controller};
use crate::lti::sample::{inverse_tustin, tustin};
use crate::lti::{Continuous, Discrete, StateSpace};
use crate::predict::closed_loop::{both_planes, compliance};
use crate::spindle::{Machine, ModelDetail, Plant};

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
        let over_speed = self.speed_mu.iter().map(|s| s.mu);
        over_speed.fold(self.rounded.specification.upper, f64::max)
    }
}

/// Realises, rounds and certifies the sampled controller `plane` of one plane (m to A).
pub(super) fn deliver(
    machine: &Machine,
    weights: &Weights,
    problems: &Problems,
    speeds: usize,
    plane: &StateSpace<Discrete>,
) -> Result<Delivery, PipelineError> {
    let period_s = machine.spindle.electronics.sample_period_s();
    let (realisation, _) = firmware_rows(&both_planes(plane), machine)?;
    // What is verified is what firmware computes: the scaled rows with float32 coefficients. Its x plane closes the
    // design plane.
    let rounded = realisation.rows.rounded_f32()?;
    let rounded_plane = plane_of(&rounded)?;
    let certified = stage("rounded", problems, &rounded_plane)?;
    let at_rest = |weights: &Weights, modes: &[UncertainMode]| {
        mu_at_speed(machine, weights, modes, &rounded, 0.0)
    };
    let rounded_stage = Stage {
        specification: certified
            .specification
            .at_least(&at_rest(weights, &problems.written_modes)?),
        covered: certified
            .covered
            .at_least(&at_rest(&problems.aim, &problems.covered_modes)?),
        ..certified
    };
    let top = machine.spindle.max_rpm;
    let speed_proof = prove(machine, &rounded, OVERSPEED * top)?;
    let verification = Verification {
        mu_peak: Some(rounded_stage.specification.upper).filter(|mu| mu.is_finite()),
        proof: Some(speed_proof.clone()),
        ..verify(
            machine,
            &rounded,
            speeds,
            "full finite-element plant, exact delay, sampled; coefficients rounded to float32",
        )?
    };
    let faster = OVERSPEEDS.map(|share| share * top);
    let overspeed = verify_at(machine, &rounded, &faster, "as below the top speed")?;
    let arithmetics = [
        ("float64", Some(realisation.rows.to_state_space()?)),
        ("float32", Some(rounded.clone())),
        // A range that Q31 does not hold is said by the firmware export; the design stands without it.
        ("Q31", q31(&realisation).and_then(|p| p.rounded()).ok()),
    ];
    let arithmetic: Result<Vec<Arithmetic>, PipelineError> = arithmetics
        .into_iter()
        .filter_map(|(name, law)| Some((name, law?)))
        .map(|(name, law)| {
            let plane = plane_of(&law)?;
            let mu = |plant: &GeneralizedPlant| {
                Ok::<_, PipelineError>(attained(plant, &plane)?.unwrap_or(f64::INFINITY))
            };
            Ok(Arithmetic {
                name,
                specification: mu(&problems.specification)?,
                covered: mu(&problems.covered)?,
                controller: named("mu", ControlLaw::Discrete(law)),
            })
        })
        .collect();
    let at_rest = Plant::new(machine, 0.0, ModelDetail::Full)?;
    let compliance_at_rest = compliance(&at_rest, &rounded, 0.0);
    let curve = |plant: &GeneralizedPlant, peak: &PeakFigures| {
        mu_curve(plant, &rounded_plane, peak, period_s)
    };
    let back = inverse_tustin(plane).map_err(PipelineError::numeric("continuous controller"))?;
    Ok(Delivery {
        speed_proof,
        speed_mu: mu_over_speed(machine, weights, &problems.written_modes, &rounded)?,
        arithmetic: arithmetic?,
        static_stiffness_n_per_m: [0, 2, 4].map(|k| compliance_at_rest[(k, k)].norm().recip()),
        specification_curve: curve(&problems.specification, &rounded_stage.specification)?,
        covered_curve: curve(&problems.covered, &rounded_stage.covered)?,
        rounded: rounded_stage,
        controller_growth_rate_per_s: plane
            .growth_rate()
            .map_err(PipelineError::numeric("controller poles"))?,
        realisation,
        controller: named("mu", ControlLaw::Discrete(rounded)),
        continuous: named("mu", ControlLaw::Continuous(both_planes(&back))),
        verification,
        overspeed,
    })
}

/// The x plane of a four-axis controller, m to A, sampled by Tustin's rule if it is continuous.
pub(super) fn plane_of_law(
    machine: &Machine,
    controller: &Controller,
) -> Result<StateSpace<Discrete>, PipelineError> {
    let sampled = match &controller.law {
        ControlLaw::Discrete(law) => return Ok(x_plane(law)),
        ControlLaw::Continuous(law) => {
            let period_s = machine.spindle.electronics.sample_period_s();
            tustin(law, period_s)
                .map_err(PipelineError::numeric("discretisation of the controller"))?
        }
    };
    Ok(x_plane(&sampled))
}

/// The x plane of a four-axis law in the scaled signals of the w plane.
fn plane_of(law: &StateSpace<Discrete>) -> Result<StateSpace<Continuous>, PipelineError> {
    scaled_plane(&x_plane(law))
}

/// A sampled controller of one plane (m to A) in the scaled signals of the w plane.
pub(super) fn scaled_plane(
    plane: &StateSpace<Discrete>,
) -> Result<StateSpace<Continuous>, PipelineError> {
    let back = inverse_tustin(plane).map_err(PipelineError::numeric("rounded loop"))?;
    Ok(scale_controller(&back))
}

fn named(name: &str, law: ControlLaw) -> Controller {
    Controller {
        name: name.to_owned(),
        law,
    }
}
