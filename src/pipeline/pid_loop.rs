//! A PID for a machine, tuned within amplifier limits or with given numbers, and what is said of its loop: stability
//! over speed, stiffness at the tool, zone, margins. Where the search finds no PID that is stable at speed, a search of
//! leads over speed takes its place, and the better of both is taken.

use super::PipelineError;
use super::comparison::{Prediction, discrete, predict};
use super::instability::Instability;
use super::loop_curves::LoopCurves;
use super::loop_stability::unstable_words;
use super::overspeed::OVERSPEED;
use super::run::at_rest_and_top_speed;
use crate::controller::verification::{Verification, verify_with_proof};
use crate::controller::{ControlLaw, Controller};
use crate::lti::connect::both_planes;
use crate::pid::certificate::TunedPid;
use crate::pid::settings::TuneSettings;
use crate::pid::surviving::{SurvivingLaw, find_surviving_law};
use crate::pid::tune::{found_or_reason, tune};
use crate::predict::sensitivity::Zone;
use crate::spindle::Machine;
use rayon::prelude::*;

/// Speeds checked for stability, evenly spaced from zero to the top speed; the proof adds those that it needs.
const SPEEDS: usize = 11;

/// Where the numbers of a PID come from.
#[derive(Clone, Debug)]
pub(crate) enum PidOrigin {
    /// From a file.
    Given,
    /// From the search of a PID.
    Tuned(Box<TunedPid>),
    /// From the search of leads over speed.
    Surviving,
}

/// A PID and the searches that led to it.
#[derive(Clone, Debug)]
pub(crate) struct PidController {
    pub controller: Controller,
    pub origin: PidOrigin,
    /// Why the search of a PID was not enough, and the search of leads.
    pub further: Option<(String, SurvivingLaw)>,
}

/// The PID that a search within limits finds, else a lead that is searched over speed.
pub(crate) fn tune_pid(machine: &Machine, settings: &TuneSettings) -> Result<PidController, PipelineError> {
    let (pid, reason) = match found_or_reason(tune(machine, settings, &mut |_, _| {}))? {
        Ok(pid) => {
            let reason = pid.certificate.nominal.unstable().map(|at| {
                let words = unstable_words(at.growth_rate_per_s, at.speed_rpm);
                format!("of {} PIDs the best is {words}", pid.certificate.evaluations)
            });
            (Some(pid), reason)
        }
        Err(reason) => (None, Some(reason)),
    };
    let tuned = |pid: TunedPid| (pid.controller.clone(), PidOrigin::Tuned(Box::new(pid)));
    match (pid, reason) {
        (Some(pid), None) => {
            let (controller, origin) = tuned(pid);
            Ok(PidController { controller, origin, further: None })
        }
        (pid, reason) => {
            let law = find_surviving_law(machine, OVERSPEED * machine.spindle.max_rpm)?;
            let grows = |pid: &TunedPid| pid.certificate.nominal.worst_growth_rate_per_s().unwrap_or(f64::INFINITY);
            let (controller, origin) = match pid.filter(|pid| grows(pid) < law.worst.rate_per_s) {
                Some(pid) => tuned(pid),
                None => {
                    let name = "lead that survives at speed".to_owned();
                    let both = ControlLaw::Discrete(both_planes(&law.plane));
                    (Controller { name, law: both }, PidOrigin::Surviving)
                }
            };
            Ok(PidController { controller, origin, further: Some((reason.unwrap_or_default(), law)) })
        }
    }
}

#[derive(Clone, Debug)]
pub(crate) struct PidLoop {
    pub pid: PidController,
    /// Stability over speed, with its proof.
    pub verification: Verification,
    /// Where it grows fastest; none of a loop that is stable at every speed computed.
    pub instability: Option<Instability>,
    /// At rest and at top speed.
    pub ends: [Prediction; 2],
    /// At the speeds asked for.
    pub predictions: Vec<Prediction>,
    /// Curves at rest.
    pub curves: LoopCurves,
}

impl PidLoop {
    /// Closes the loop of a sampled PID; natural frequencies are uncertain by a share.
    pub(crate) fn close(
        machine: &Machine,
        pid: PidController,
        speeds_rpm: &[f64],
        mode_shift: f64,
    ) -> Result<Self, PipelineError> {
        let controller = &pid.controller;
        let law = discrete(controller, machine.spindle.electronics.sample_period_s())?;
        let conditions = "full finite-element plant, exact delay, sampled";
        let verification = verify_with_proof(machine, &law, SPEEDS, conditions)?;
        let ends = at_rest_and_top_speed(machine, controller)?;
        let at = |rpm: &f64| match ends.iter().find(|end| end.speed_rpm == *rpm) {
            Some(end) => Ok(end.clone()),
            None => predict(machine, controller, *rpm),
        };
        Ok(Self {
            instability: Instability::of_verified(machine, controller, &verification)?,
            predictions: speeds_rpm.par_iter().map(at).collect::<Result<_, _>>()?,
            curves: LoopCurves::of(machine, controller, &ends[0], &vec![mode_shift; machine.spindle.flexible_modes])?,
            verification,
            ends,
            pid,
        })
    }

    /// True when stability is proven from rest to the top speed, no zone is D, and a tuned PID keeps its limits.
    pub(crate) fn meets(&self, settings: &TuneSettings) -> bool {
        let acceptable = |p: &Prediction| p.zone().is_some_and(|zone| zone < Zone::D);
        let within = match &self.pid.origin {
            PidOrigin::Tuned(pid) => pid.certificate.meets(settings),
            PidOrigin::Given | PidOrigin::Surviving => true,
        };
        self.verification.is_proven() && self.ends.iter().chain(&self.predictions).all(acceptable) && within
    }

    /// Why it does not meet what is asked, where it is stable, in sentences.
    fn missed(&self, settings: &TuneSettings) -> String {
        let of_zone_d = |p: &&Prediction| p.zone() == Some(Zone::D);
        let zone_d = self.ends.iter().chain(&self.predictions).find(of_zone_d).map(|p| {
            let db = p.sensitivity_peak_db();
            format!("the sensitivity is {db:.1} dB at {:.0} rpm, zone D", p.speed_rpm)
        });
        let exceeded = match &self.pid.origin {
            PidOrigin::Tuned(pid) if self.instability.is_none() => pid.certificate.judge_figures().exceeded(settings),
            _ => vec![],
        };
        let all: Vec<String> = zone_d.into_iter().chain(exceeded).collect();
        if all.is_empty() { String::new() } else { format!(" What it misses: {}.", all.join("; ")) }
    }

    /// What was found, whether it is stable, what it misses, and what was searched, in sentences.
    pub(crate) fn words(&self, settings: &TuneSettings) -> String {
        let stable = match (&self.instability, self.verification.is_proven()) {
            (Some(found), _) => format!("{}.", found.mode_words()),
            (None, true) => {
                "stable at every speed from rest to the top speed, proven between those computed.".to_owned()
            }
            (None, false) => "stable at the speeds computed, not proven between them.".to_owned(),
        };
        let stable = format!("{}: {stable}{}", self.pid.controller.name, self.missed(settings));
        match &self.pid.further {
            Some((reason, law)) => format!("{stable} What was searched: {reason}. {}", law.words()),
            None => stable,
        }
    }
}
