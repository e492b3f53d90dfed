//! Figures by which controllers are compared: predictions at each speed, stability over speed, worst case over
//! uncertain modes, and the largest stable depth of cut.

use super::PipelineError;
use super::comparison::{Prediction, chatter_limit, discrete, predict};
use super::design::{Design, design_in_words};
use super::progress::{Event, Listener};
use super::run::{Rival, Rivals, rivals};
use super::settings::DesignSettings;
use super::worst::{WorstPrediction, worst_predictions};
use crate::augment::weights::Weights;
use crate::controller::Controller;
use crate::controller::speed_proof::SpeedProof;
use crate::controller::verification::{Verification, verify_with_proof};
use crate::pid::settings::TuneSettings;
use crate::predict::chatter::{CuttingMaterial, Engagement, StabilityLimit};
use crate::spindle::Machine;

/// Speeds checked for stability, evenly spaced from zero to the top speed.
const SPEEDS: usize = 11;

/// Machine, speeds, uncertainty and cut on which controllers are compared.
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a> {
    /// Spindle with tool.
    pub machine: &'a Machine,
    /// Speeds of the predictions, rpm.
    pub speeds_rpm: &'a [f64],
    /// Relative uncertainty of the natural frequencies, mode by mode.
    pub mode_uncertainty: &'a [f64],
    /// The workpiece.
    pub material: &'a CuttingMaterial,
    /// The cut.
    pub cut: &'a Engagement,
}

/// A controller with what it is compared by.
#[derive(Clone, Debug)]
pub struct Compared {
    /// Key of the controller.
    pub name: String,
    /// Its loop at each speed.
    pub predictions: Vec<Prediction>,
    /// The same at rest and at top speed.
    pub ends: [Prediction; 2],
    /// Stability over speed.
    pub verification: Verification,
    /// Worst cases at those speeds and over all that are proven stable.
    pub worst: Vec<WorstPrediction>,
    /// Stability lobes at the top speed; none of a loop that is unstable without a cut.
    pub lobes: Option<StabilityLimit>,
}

impl Compared {
    /// Growth rate and speed of a loop that is unstable: at a speed that was asked for, else anywhere up to the top
    /// speed.
    pub(crate) fn unstable(&self) -> Option<(f64, f64)> {
        let asked = self.predictions.iter().find(|p| !p.is_stable());
        let asked = asked.map(|p| (p.growth_rate_per_s, p.speed_rpm));
        let anywhere = self.verification.unstable();
        asked.or(anywhere.map(|c| (c.growth_rate_per_s, c.speed_rpm)))
    }
}

/// The μ design and the PIDs for a machine, for a comparison without given controllers.
#[derive(Clone, Debug)]
pub(crate) struct OwnControllers {
    pub design: Design,
    /// The tuned and the textbook PID within the amplifier limits of the design.
    pub rivals: Rivals,
}

/// Designs with the usual settings, and tunes a PID with effort `pid`.
pub(crate) fn own_controllers(
    machine: &Machine,
    weights: &Weights,
    pid: TuneSettings,
    progress: &mut Listener,
) -> Result<OwnControllers, PipelineError> {
    let design = design_in_words(machine, weights, &DesignSettings::with_polish(), progress)?;
    progress(Event::Begins("PID"));
    let rivals = rivals(machine, &design, pid)?;
    Ok(OwnControllers { design, rivals })
}

/// What the design or the PID search that found a controller has computed of it.
#[derive(Clone, Debug, Default)]
pub struct KnownFigures {
    /// Its loop at some speeds.
    pub predictions: Vec<Prediction>,
    /// Its stability over speed, with a proof that reaches the top speed.
    pub verification: Option<Verification>,
}

impl OwnControllers {
    /// What is known of the delivered controller, the tuned and the textbook PID.
    pub(crate) fn known_controllers(&self) -> [KnownFigures; 3] {
        let delivery = &self.design.delivery;
        let verification = &delivery.verification;
        let of_pid = |pid: &Rival| {
            let predictions = pid.as_ref().map(|(_, own)| own.to_vec());
            KnownFigures { predictions: predictions.unwrap_or_default(), verification: None }
        };
        let judged = self.design.judged_with(&delivery.controller);
        let delivered = KnownFigures {
            predictions: judged.map_or(vec![], Vec::from),
            verification: verification.is_proven().then(|| verification.clone()),
        };
        [delivered, of_pid(&self.rivals.tuned), of_pid(&self.rivals.textbook)]
    }
}

/// Compares one controller under a key.
///
/// # Errors
/// [`PipelineError`] when a plant or a loop cannot be built, or the cut is out of range.
pub fn compare_controller(
    ground: &Ground<'_>,
    name: &str,
    controller: &Controller,
    known: &KnownFigures,
) -> Result<Compared, PipelineError> {
    let machine = ground.machine;
    let top_rpm = machine.spindle.max_rpm;
    let at = |rpm: f64, known: &[Prediction]| -> Result<Prediction, PipelineError> {
        let prediction = match known.iter().find(|p| p.speed_rpm == rpm) {
            Some(known) => known.clone(),
            None => predict(machine, controller, rpm)?,
        };
        Ok(Prediction { name: name.to_owned(), ..prediction })
    };
    let predictions = ground.speeds_rpm.iter().map(|rpm| at(*rpm, &known.predictions));
    let predictions = predictions.collect::<Result<Vec<_>, _>>()?;
    let ends = [at(0.0, &predictions)?, at(top_rpm, &predictions)?];
    let verification = match &known.verification {
        Some(known) => known.clone(),
        None => {
            let law = discrete(controller, machine.spindle.electronics.sample_period_s())?;
            let conditions = "full finite-element plant, exact delay, sampled";
            verify_with_proof(machine, &law, SPEEDS, conditions)?
        }
    };
    let proven_rpm = verification.proof.as_ref().map_or(0.0, SpeedProof::proven_to_rpm);
    Ok(Compared {
        name: name.to_owned(),
        worst: worst_predictions(
            machine,
            controller,
            ground.speeds_rpm,
            proven_rpm.min(top_rpm),
            ground.mode_uncertainty,
        )?,
        lobes: chatter_limit(machine, controller, top_rpm, ground.material, ground.cut)?,
        predictions,
        ends,
        verification,
    })
}
