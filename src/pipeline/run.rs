//! The whole chain for one tool, as in the paper: the moduli are moved until the model has the measured resonances and
//! antiresonances; the μ controller is designed on the updated machine; a PID is tuned within the same amplifier
//! limits; both loops are predicted on the full plant, and contact with the backup bearings is simulated.

use super::PipelineError;
use super::certificates::mu_words;
use super::comparison::{Prediction, better_in_every_figure, chatter_limit, predict, rival_settings};
use super::contact::{Contact, contact};
use super::design::{Design, design};
use super::loop_curves::{LoopCurves, LoopMargins};
use super::model_curves::{FreeRotor, OpenLoopCurves};
use super::progress::{Event, Listener};
use super::settings::DesignSettings;
use crate::augment::weights::Weights;
use crate::controller::Controller;
use crate::controller::verification_error::VerificationError;
use crate::pid::certificate::TunedPid;
use crate::pid::settings::TuneSettings;
use crate::pid::tune::{found_or_reason, textbook, tune, tune_from};
use crate::predict::chatter::{CuttingMaterial, Engagement, USUAL_WIDTH};
use crate::spindle::Machine;
use crate::update::{Targets, UpdateSettings, UpdatedMachine, gauss_newton, nelder_mead};
use rayon::prelude::*;

/// What a run is given.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// The machine as drawn.
    pub nominal: &'a Machine,
    /// Measured frequencies; none: the model stays as drawn.
    pub targets: Option<&'a Targets>,
    /// The specification; levels that it leaves to the machine are those of the updated one.
    pub weights: &'a Weights,
    /// How the controller is designed.
    pub settings: &'a DesignSettings,
    /// How the PID is sought, before it is held to the amplifier limits of the design.
    pub pid: TuneSettings,
    /// What is computed beside the controller and its proofs.
    pub extent: Extent,
}

/// How much a run computes; the controller and its certificates are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Everything: Nelder–Mead beside Gauss–Newton, PIDs, the push into the backup bearings, curves.
    Everything,
    /// The controller, its proofs and predictions.
    Controller,
}

/// A finished run.
#[derive(Clone, Debug)]
pub struct Run {
    /// The machine as drawn.
    pub nominal: Machine,
    /// The machine that the controller is designed on.
    pub machine: Machine,
    /// Their free rotors, in this order.
    pub rotors: [FreeRotor; 2],
    /// What was measured.
    pub targets: Option<Targets>,
    /// What updating gave.
    pub updating: Option<Updating>,
    /// The μ controller.
    pub design: Design,
    /// Its loop at rest and at top speed.
    pub delivered: [Prediction; 2],
    /// The loop of the D-K iteration's controller, where a polished one is delivered.
    pub unpolished: Option<[Prediction; 2]>,
    /// The loop at rest with the coefficients of each arithmetic.
    pub arithmetic: Vec<Prediction>,
    /// The PIDs.
    pub rivals: Option<Rivals>,
    /// The push into the backup bearings.
    pub contact: Option<Contact>,
    /// Curves of models and loop.
    pub curves: Option<Curves>,
    /// How deep a tool with teeth may cut.
    pub cut: Option<CriticalCut>,
}

/// The deepest cut that is stable at every speed of the spindle: aluminium, down milling over half the diameter.
#[derive(Clone, Copy, Debug)]
pub struct CriticalCut {
    /// Teeth of the tool.
    pub teeth: usize,
    /// With the delivered controller, m; none where the loop is unstable without a cut, infinite where no cut chatters.
    pub delivered_m: Option<f64>,
    /// The same with the tuned PID.
    pub pid_m: Option<f64>,
}

/// Curves of the models and of the loop.
#[derive(Clone, Debug)]
pub struct Curves {
    /// Open loop of the machine as drawn, where it was updated, and of the one used.
    pub open_loop: Vec<OpenLoopCurves>,
    /// The loop of the delivered controller.
    pub closed_loop: LoopCurves,
    /// Margins of the tuned PID.
    pub pid_margins: Option<LoopMargins>,
}

/// The model moved to the measurement.
#[derive(Clone, Debug)]
pub struct Updating {
    /// By sensitivities, with prior and noise: what is used.
    pub gauss_newton: UpdatedMachine,
    /// By the search of the paper, to compare.
    pub nelder_mead: Option<UpdatedMachine>,
}

/// PIDs within the amplifier limits of the delivered controller.
#[derive(Clone, Debug)]
pub struct Rivals {
    /// What the search was held to.
    pub effort: TuneSettings,
    /// The tuned PID.
    pub tuned: Rival,
    /// The textbook PID.
    pub textbook: Rival,
}

/// A PID with its loop at rest and at top speed, or the reason why none was found.
pub(crate) type Rival = Result<(TunedPid, [Prediction; 2]), String>;

impl Run {
    /// True when the tuned PID is better than the delivered controller in every figure.
    pub(crate) fn pid_is_better(&self) -> bool {
        let tuned = self.rivals.as_ref().and_then(|r| r.tuned.as_ref().ok());
        tuned.is_some_and(|(_, pid)| better_in_every_figure(pid, &self.delivered))
    }

    pub(crate) fn pid(&self) -> Option<&TunedPid> {
        let tuned = &self.rivals.as_ref()?.tuned;
        tuned.as_ref().ok().map(|(pid, _)| pid)
    }
}

/// Runs the chain.
///
/// # Errors
/// [`PipelineError`] of the step that failed. A PID that is not found is no error.
pub fn run(task: &Task<'_>, listen: &mut Listener<'_>) -> Result<Run, PipelineError> {
    let updating = match task.targets {
        Some(targets) => {
            listen(Event::Begins("model updating"));
            let found = update(task.nominal, targets, task.extent)?;
            listen(Event::Found(&updating_words(&found)));
            Some(found)
        }
        None => None,
    };
    let machine = match &updating {
        Some(found) => found.gauss_newton.machine.clone(),
        None => task.nominal.clone(),
    };
    listen(Event::Begins("design"));
    let design = design(&machine, task.weights, task.settings, listen)?;
    listen(Event::Found(&format!(
        "controller: μ {} as specified at rest, {} over speed, order {}",
        design.delivery.rounded.specification.words(),
        mu_words(design.largest_mu()),
        2 * design.delivery.rounded.order
    )));
    let rivals = match task.extent {
        Extent::Everything => {
            listen(Event::Begins("PID"));
            Some(rivals(&machine, &design, task.pid)?)
        }
        Extent::Controller => None,
    };
    listen(Event::Begins("predictions"));
    let delivered = predict_delivered(&machine, &design)?;
    let unpolished = predict_unpolished(&machine, &design)?;
    let arithmetic = by_arithmetic(&machine, &design)?;
    let mut run = Run {
        nominal: task.nominal.clone(),
        rotors: [FreeRotor::of(task.nominal)?, FreeRotor::of(&machine)?],
        targets: task.targets.cloned(),
        machine,
        updating,
        design,
        delivered,
        unpolished,
        arithmetic,
        rivals,
        contact: None,
        curves: None,
        cut: None,
    };
    if task.extent == Extent::Everything {
        let pid = run.pid().map(|p| &p.controller);
        run.contact = Some(contact(&run.machine, &run.design.delivery.realisation, pid)?);
        run.curves = Some(curves(&run, &task.weights.mode_uncertainty)?);
        run.cut = run.machine.tool.teeth.map(|teeth| critical_cut(&run, teeth)).transpose()?;
    }
    Ok(run)
}

/// The critical depths of cut at top speed with the delivered controller and the tuned PID.
fn critical_cut(run: &Run, teeth: usize) -> Result<CriticalCut, PipelineError> {
    let cut = Engagement::down_milling(teeth, USUAL_WIDTH);
    let top_rpm = run.machine.spindle.max_rpm;
    let depth_m = |controller: &Controller| -> Result<Option<f64>, PipelineError> {
        let limit = chatter_limit(&run.machine, controller, top_rpm, &CuttingMaterial::ALUMINIUM, &cut)?;
        Ok(limit.map(|limit| limit.minimum().map_or(f64::INFINITY, |least| least.depth_m)))
    };
    let delivered_m = depth_m(&run.design.delivery.controller)?;
    let pid_m = run.pid().map(|pid| depth_m(&pid.controller)).transpose()?.flatten();
    Ok(CriticalCut { teeth, delivered_m, pid_m })
}

fn curves(run: &Run, mode_uncertainty: &[f64]) -> Result<Curves, PipelineError> {
    let used = OpenLoopCurves::of(&run.machine)?;
    let controller = &run.design.delivery.controller;
    Ok(Curves {
        open_loop: match run.updating {
            Some(_) => vec![OpenLoopCurves::of(&run.nominal)?, used],
            None => vec![used],
        },
        closed_loop: LoopCurves::of(&run.machine, controller, &run.delivered[0], mode_uncertainty)?,
        pid_margins: run.pid().map(|pid| LoopMargins::of(&run.machine, &pid.controller)).transpose()?,
    })
}

fn updating_words(found: &Updating) -> String {
    let each = |name: &str, by: &UpdatedMachine| {
        format!("{:.4} % ({name}, {} evaluations)", by.fit.largest_error_percent(), by.fit.evaluations)
    };
    let own = each("Gauss–Newton", &found.gauss_newton);
    let other = found.nelder_mead.as_ref();
    let other = other.map_or(String::new(), |by| format!(", {}", each("Nelder–Mead", by)));
    format!("model updating: largest error {own}{other}")
}

/// Moves the moduli of `nominal` to the measured frequencies.
fn update(nominal: &Machine, targets: &Targets, extent: Extent) -> Result<Updating, PipelineError> {
    let settings = UpdateSettings::default();
    let simplex = || match extent {
        Extent::Everything => nelder_mead(nominal, targets, &settings).map(Some),
        Extent::Controller => Ok(None),
    };
    let (steps, simplex) = rayon::join(|| gauss_newton(nominal, targets, &settings), simplex);
    Ok(Updating { gauss_newton: steps?, nelder_mead: simplex? })
}

/// The loop of a controller at rest and at top speed.
pub(crate) fn at_rest_and_top_speed(
    machine: &Machine,
    controller: &Controller,
) -> Result<[Prediction; 2], PipelineError> {
    let at = |rpm: f64| predict(machine, controller, rpm);
    let (rest, top) = rayon::join(|| at(0.0), || at(machine.spindle.max_rpm));
    Ok([rest?, top?])
}

/// Predictions at rest and top speed with a controller of a design, those that its polish made where it judged it.
fn predict_stiffness(
    machine: &Machine,
    design: &Design,
    controller: &Controller,
) -> Result<[Prediction; 2], PipelineError> {
    let known = design.judged_with(controller);
    known.map_or_else(|| at_rest_and_top_speed(machine, controller), Ok)
}

/// Predictions at rest and top speed with the delivered controller.
pub(crate) fn predict_delivered(machine: &Machine, design: &Design) -> Result<[Prediction; 2], PipelineError> {
    predict_stiffness(machine, design, &design.delivery.controller)
}

/// Predictions at rest and top speed with the controller of the D-K iteration, where a polished one is delivered.
pub(crate) fn predict_unpolished(machine: &Machine, design: &Design) -> Result<Option<[Prediction; 2]>, PipelineError> {
    let polish = design.polish.as_ref().filter(|p| p.delivered.is_some());
    let dk = polish.and_then(|p| p.dk.as_ref());
    dk.map(|dk| predict_stiffness(machine, design, &dk.controller)).transpose()
}

/// The loop at rest with the coefficients of each arithmetic of a design.
pub(crate) fn by_arithmetic(machine: &Machine, design: &Design) -> Result<Vec<Prediction>, PipelineError> {
    let each = design.delivery.arithmetic.par_iter();
    // One of them is delivered.
    let at_rest = |controller: &Controller| match design.judged_with(controller) {
        Some([rest, _]) => Ok(rest),
        None => predict(machine, controller, 0.0),
    };
    each.map(|a| at_rest(&a.controller)).collect()
}

/// The tuned and the textbook PID for a machine, within the amplifier limits of a design.
pub(crate) fn rivals(machine: &Machine, design: &Design, pid: TuneSettings) -> Result<Rivals, PipelineError> {
    let delivered = &design.delivery.controller;
    let effort = rival_settings(machine, delivered, pid)?;
    let rival = |found: Result<TunedPid, VerificationError>| -> Result<Rival, PipelineError> {
        Ok(match found_or_reason(found)? {
            Ok(pid) => {
                let predictions = at_rest_and_top_speed(machine, &pid.controller)?;
                Ok((pid, predictions))
            }
            Err(reason) => Err(reason),
        })
    };
    // Nothing of the textbook PID is tuned for the tool: more effort would not change it.
    let plain = rival_settings(machine, delivered, TuneSettings::quick())?;
    // The polish has tuned one from the same starts as a rule, within limits that are often nearly the same.
    let start = design.polish.as_ref().and_then(|p| p.tuned_pid.as_ref());
    let start = start.filter(|_| effort.seed == TuneSettings::start().seed);
    let tuned = || match start {
        Some(start) => tune_from(start, machine, &effort, &mut |_, _| {}),
        None => tune(machine, &effort, &mut |_, _| {}),
    };
    let (tuned, textbook) = rayon::join(|| rival(tuned()), || rival(textbook(machine, &plain)));
    Ok(Rivals { tuned: tuned?, textbook: textbook?, effort })
}
