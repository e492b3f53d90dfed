//! Search of a PID: starts are drawn from the machine and screened by the argument principle. The best are descended a
//! few steps with exact derivatives by the method of the polish ([`crate::controller::polish`]), the best of these to
//! convergence: which of them ends best is not seen before.

use super::law::PidLaw;
use super::parameters::{PidParameters, pid_controller};
use super::start::{Start, StartRule, screen, starts};
use crate::augment::plane::x_plane;
use crate::controller::polish::LoopLimits;
use crate::controller::polish::descent::{Effort, Memory, PENALTY, descend};
use crate::controller::polish::lines::lines;
use crate::controller::polish::loss::Loss;
use crate::controller::polish::responses::{Known, Plants, Role, Rotor, shifts};
use crate::controller::polish::structure::Line;
use crate::controller::verification_error::VerificationError;
use crate::controller::{ControlLaw, ControllerError, in_step};
use crate::linalg::c64;
use crate::lti::connect::lower_lft;
use crate::spindle::{Machine, Plant};
use rayon::prelude::*;

/// What a search is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PidSearch {
    /// Limits of the loop.
    pub limits: LoopLimits,
    /// Relative shift of the flexible frequencies, both ways, that the loop must survive.
    pub mode_shift: f64,
    /// Starts drawn.
    pub starts: usize,
    /// Seed of the starts.
    pub seed: u64,
    /// Basins descended.
    pub basins: usize,
    /// Steps of a round of the last descent at most; a basin gets a sixth in all.
    pub steps: usize,
}

/// A PID found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FoundPid {
    /// Parameters.
    pub parameters: PidParameters,
    /// Controllers judged: starts and steps.
    pub evaluations: usize,
}

/// Modes shifted in the plants of a search.
const SHIFTED_MODES: usize = 6;
/// Lowest line, Hz: below the integrators.
const FROM_HZ: f64 = 0.05;
/// Lines closer than this share of their frequency are one.
const APART: f64 = 2e-3;
/// Multiple of the top speed up to which the loop has to be stable.
const OVERSPEED: f64 = 1.2;
/// Starts looked at on all rotors.
const SHORTLIST: usize = 24;
/// Relative gain of a step below which a descent that ranks starts ends.
const RANKING: f64 = 2e-3;
/// The same of the descent from the best one: a rival that is not tuned to its end would flatter the comparison.
const LAST: f64 = 1e-4;
/// Relative gain of a round, on renewed lines and with its curvature learnt afresh, that pays for another one.
const ROUND_GAIN: f64 = 5e-3;
/// What a start may be behind the best of them after its first round to go on, in the logarithm of the stiffness: none
/// that was further behind became the best within its limits on five machines.
const BEHIND: f64 = 0.15;
/// Rounds at most; three to five are usual.
const ROUNDS: usize = 8;

/// The best PID that the search finds; `given` starts come before those drawn, `shape` puts each start into the form
/// searched for (or drops it), `free` lists the parameters that move.
///
/// # Errors
/// [`ControllerError::Infeasible`] when no start levitates the machine at rest and top speed; failures of plants.
pub(super) fn search(
    machine: &Machine,
    asked: &PidSearch,
    given: &[PidParameters],
    shape: &(dyn Fn(PidParameters) -> Option<PidParameters> + Sync),
    free: &[usize],
) -> Result<FoundPid, VerificationError> {
    let plants = Plants::new(
        machine,
        OVERSPEED,
        &shifts(&[asked.mode_shift; SHIFTED_MODES]),
    )?;
    let nyquist = std::f64::consts::PI / plants.period_s();
    let modes = plants.at_rest().flexible_rad_s();
    let bending = modes.first().copied().unwrap_or(0.1 * nyquist);
    let plain = lines(&plants, FROM_HZ, &[], APART);
    let rotors = plants.on(&plain, &Known::NOTHING);
    let nominal: Vec<_> = rotors
        .iter()
        .filter(|r| matches!(r.role, Role::Rest | Role::TopSpeed))
        .collect();
    let unstable_poles = unstable_poles(&plants)?;
    let rule = StartRule::new(machine, bending)?;
    let mut all: Vec<Start> = given
        .iter()
        .filter_map(|p| shape(*p))
        .map(|p| screen(p, &plain, &nominal, unstable_poles))
        .collect();
    let drawn = (asked.starts, asked.seed);
    all.extend(starts(
        &rule,
        drawn,
        (&plain, &nominal),
        unstable_poles,
        shape,
    ));
    let fewest = all.iter().map(|s| s.unstable).min().unwrap_or(i64::MAX);
    if fewest > 0 {
        return Err(infeasible(all.len(), fewest).into());
    }
    all.retain(|s| s.unstable == 0);
    all.sort_by(|a, b| a.sensitivity.total_cmp(&b.sensitivity));
    all.truncate(SHORTLIST);
    let make = |lines: Vec<Line>, known: &Known<'_, &Rotor>| {
        let rotors = plants.on(&lines, known);
        Loss::new(lines, rotors, None, asked.limits, plants.period_s())
    };
    let list: Vec<&Rotor> = rotors.iter().collect();
    let known = Known {
        lines: &plain,
        list: &list,
    };
    let mut loss = make(plain.clone(), &known);
    let mut ranked: Vec<(usize, f64, PidLaw, Vec<f64>)> = all
        .iter()
        .map(|start| {
            let base = start.parameters.to_log();
            let x: Vec<f64> = free.iter().map(|k| base[*k]).collect();
            let law = PidLaw {
                base,
                free: free.to_vec(),
                nyquist_rad_s: nyquist,
            };
            let lost = activate(&mut loss, &law, &x, unstable_poles);
            let merit = loss.evaluate(&law, &x).merit(PENALTY);
            (lost, merit, law, x)
        })
        .collect();
    ranked.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    ranked.truncate(asked.basins.max(1));
    let mut evaluations = asked.starts + given.len();
    let effort = |steps: usize, tolerance: f64| Effort { steps, tolerance };
    for (lost, merit, law, x) in &mut ranked {
        // Rotors that are unstable at first may be stable after a few steps.
        let mut memory = Memory::default();
        for part in 0..2 {
            activate(&mut loss, law, x, unstable_poles);
            let asked = effort(asked.steps / 12 + part, RANKING);
            memory.begin();
            evaluations += descend(&mut loss, law, x, (&asked, &mut memory))?;
        }
        *lost = activate(&mut loss, law, x, unstable_poles);
        *merit = loss.evaluate(law, x).merit(PENALTY);
    }
    ranked.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let last = effort(asked.steps, LAST);
    let fresh = |law: &PidLaw, x: &[f64]| -> Result<Loss, VerificationError> {
        let poles = loop_poles(plants.at_rest(), law, x)?;
        let mut loss = make(lines(&plants, FROM_HZ, &poles, APART), &known);
        activate(&mut loss, law, x, unstable_poles);
        Ok(loss)
    };
    let starts = ranked.into_iter().map(Descent::from).collect();
    let (descents, steps) = to_the_end(starts, &last, &fresh)?;
    evaluations += steps;
    let best = descents
        .into_iter()
        .min_by(|a, b| a.lost.cmp(&b.lost).then(a.merit.total_cmp(&b.merit)));
    let Some(Descent { law, x, .. }) = best else {
        return Err(infeasible(0, 0).into());
    };
    let parameters = law
        .parameters_of(&x)
        .ok_or_else(|| infeasible(evaluations, 0))?;
    Ok(FoundPid {
        parameters,
        evaluations,
    })
}

/// The loss on lines renewed for a law with these parameters.
type FreshLoss<'a> = dyn Fn(&PidLaw, &[f64]) -> Result<Loss, VerificationError> + Sync + 'a;

/// A start on its way to its end.
struct Descent {
    law: PidLaw,
    x: Vec<f64>,
    /// Rotors whose loop is unstable.
    lost: usize,
    /// Logarithmic.
    merit: f64,
    evaluations: usize,
}

impl From<(usize, f64, PidLaw, Vec<f64>)> for Descent {
    fn from((lost, merit, law, x): (usize, f64, PidLaw, Vec<f64>)) -> Self {
        Self {
            law,
            x,
            lost,
            merit,
            evaluations: 0,
        }
    }
}

impl Descent {
    /// Descends once on the loss that `fresh` gives on lines renewed for it; what the merit fell by.
    fn round(&mut self, effort: &Effort, fresh: &FreshLoss) -> Result<f64, VerificationError> {
        let mut loss = fresh(&self.law, &self.x)?;
        // A descent that stands still on the curvature learnt on its way goes on without it.
        let mut memory = Memory::default();
        memory.begin();
        self.evaluations += descend(&mut loss, &self.law, &mut self.x, (effort, &mut memory))?;
        let before = self.merit;
        self.merit = loss.evaluate(&self.law, &self.x).merit(PENALTY);
        self.lost = loss.active.iter().filter(|active| !**active).count();
        Ok(before - self.merit)
    }
}

/// Descends starts to their end; those that a round leaves far behind the best are dropped. The controllers judged come
/// with them.
fn to_the_end(
    mut descents: Vec<Descent>,
    effort: &Effort,
    fresh: &FreshLoss,
) -> Result<(Vec<Descent>, usize), VerificationError> {
    descents
        .par_iter_mut()
        .try_for_each(|d| d.round(effort, fresh).map(|_| ()))?;
    let dropped = |d: &Descent, least: f64| d.merit > least + BEHIND;
    let merits = descents.iter().map(|d| d.merit);
    let least = merits.fold(f64::INFINITY, f64::min);
    let first = descents.iter().filter(|d| dropped(d, least));
    let mut evaluations = first.map(|d| d.evaluations).sum::<usize>();
    descents.retain(|d| !dropped(d, least));
    descents.par_iter_mut().try_for_each(|d| {
        for _ in 1..ROUNDS {
            if d.round(effort, fresh)? < ROUND_GAIN {
                break;
            }
        }
        Ok::<_, VerificationError>(())
    })?;
    evaluations += descents.iter().map(|d| d.evaluations).sum::<usize>();
    Ok((descents, evaluations))
}

/// Lets the rotors count whose loop is stable; the number of the others.
fn activate(loss: &mut Loss, law: &PidLaw, x: &[f64], unstable_poles: i64) -> usize {
    let found = loss.evaluate(law, x);
    let mut lost = 0;
    for (active, turns) in loss.active.iter_mut().zip(&found.turns) {
        *active = *turns == unstable_poles;
        lost += usize::from(!*active);
    }
    lost
}

/// Unstable poles of one plane of the plant at rest.
fn unstable_poles(plants: &Plants) -> Result<i64, VerificationError> {
    let sampled = plants.at_rest().sampled()?;
    let plane = x_plane(&sampled);
    let poles = plane.poles().map_err(in_step("poles of the plant"))?;
    Ok(poles.iter().filter(|z| z.norm() > 1.0).count() as i64)
}

/// Poles of the loop at rest as continuous ones, upper half plane, rad/s.
fn loop_poles(plant: &Plant, law: &PidLaw, x: &[f64]) -> Result<Vec<c64>, VerificationError> {
    let period = plant.sample_period_s();
    let Some(parameters) = law.parameters_of(x) else {
        return Ok(vec![]);
    };
    let ControlLaw::Discrete(sampled) = pid_controller(&parameters, period, "PID")?.law else {
        return Ok(vec![]);
    };
    let numeric = in_step("poles of the PID loop");
    let plane = x_plane(&plant.sampled()?);
    let own = x_plane(&sampled);
    let poles = lower_lft(&plane, &own)
        .and_then(|l| l.continuous_poles())
        .map_err(&numeric)?;
    Ok(poles.into_iter().filter(|p| p.im > 0.0).collect())
}

fn infeasible(tried: usize, unstable: i64) -> ControllerError {
    ControllerError::Infeasible {
        step: "PID",
        reason: format!(
            "of {tried} settings drawn from the rigid-body and bending dynamics none levitates the rotor at rest and \
             at top speed; the best leaves {unstable} unstable poles"
        ),
        advice: "check delay, bandwidths and sensor planes of the spindle",
    }
}
