//! Search of a PID: starts are drawn from the machine and screened by the argument principle. The best are descended
//! with exact derivatives by the method of the polish ([`crate::controller::polish`]): a few steps each, the best of
//! what these lead to further, to convergence unless the first rounds leave them far behind. Which of them ends best is
//! not seen before.

use super::law::PidLaw;
use super::parameters::{PidParameters, pid_controller};
use super::start::{Start, StartRule, screen, starts};
use crate::augment::plane::x_plane;
use crate::controller::polish::LoopLimits;
use crate::controller::polish::descent::{Effort, Memory, PENALTY, descend};
use crate::controller::polish::lines::lines;
use crate::controller::polish::loop_poles::{SampledPlants, oscillating};
use crate::controller::polish::loss::Loss;
use crate::controller::polish::responses::{Known, Plants, Role, Rotor, shifts};
use crate::controller::polish::structure::Line;
use crate::controller::verification_error::VerificationError;
use crate::controller::{ControlLaw, ControllerError, in_step};
use crate::linalg::c64;
use crate::spindle::Machine;
use rayon::prelude::*;
use std::cmp::Ordering;

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
    /// Rounds of it at most.
    pub rounds: usize,
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
/// Starts that a few steps are tried from for each that is descended: a start says little of where it leads.
const RIVALS: usize = 4;
/// Relative gain of a step below which the first descent of a start ends.
const FIRST: f64 = 2e-3;
/// The same of a round: a rival that is not tuned to its end would flatter the comparison.
const LAST: f64 = 1e-4;
/// Relative gain of a round, on renewed lines and with its curvature learnt afresh, that pays for another one.
const ROUND_GAIN: f64 = 5e-3;
/// Rounds in a row without that gain that end a descent: a peak that one lets grow between its lines is on those of the
/// next.
const IDLE: usize = 2;
/// Rounds after which starts are compared.
const FIRST_ROUNDS: usize = 2;
/// What a start may be behind the best of them then to go on, in the logarithm of the stiffness.
const BEHIND: f64 = 0.3;

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
    let nominal: Vec<_> = rotors.iter().filter(|rotor| is_nominal(rotor)).collect();
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
    let mut ranked: Vec<Ranked> = all
        .par_iter()
        .map(|start| {
            let base = start.parameters.to_log();
            let x: Vec<f64> = free.iter().map(|k| base[*k]).collect();
            let law = PidLaw {
                base,
                free: free.to_vec(),
                nyquist_rad_s: nyquist,
            };
            let mut loss = make(plain.clone(), &known);
            activate(&mut loss, &law, &x, unstable_poles);
            (judged(&loss, &law, &x), law, x)
        })
        .collect();
    ranked.sort_by(|a, b| order(&a.0, &b.0));
    ranked.truncate(RIVALS * asked.basins.max(1));
    let mut evaluations = asked.starts + given.len();
    let first = ranked.into_par_iter().map(|(_, law, x)| {
        let loss = make(plain.clone(), &known);
        first_descent(loss, (law, x), asked.steps / 12, unstable_poles)
    });
    let first: Result<Vec<_>, VerificationError> = first.collect();
    let (tried, mut ranked): (Vec<usize>, Vec<_>) = first?.into_iter().unzip();
    evaluations += tried.iter().sum::<usize>();
    ranked.sort_by(|a, b| order(&a.0, &b.0));
    ranked.truncate(asked.basins.max(1));
    let last = Effort {
        steps: asked.steps,
        tolerance: LAST,
    };
    let sampled = SampledPlants::of(&plants, &[Role::Rest, Role::TopSpeed])?;
    let fresh = |law: &PidLaw, x: &[f64]| -> Result<Loss, VerificationError> {
        let LoopPoles { poles, stable } = loop_poles(&sampled, law, x)?;
        let mut loss = make(lines(&plants, FROM_HZ, &poles, APART), &known);
        activate(&mut loss, law, x, unstable_poles);
        // Turns on lines can miss a sharp pole; eigenvalues do not.
        for (rotor, active) in loss.rotors.iter().zip(&mut loss.active) {
            let found = stable.iter().find(|(role, _)| *role == rotor.role);
            *active &= found.is_none_or(|(_, stable)| *stable);
        }
        Ok(loss)
    };
    let starts: Result<Vec<Descent>, VerificationError> = ranked
        .into_par_iter()
        .map(|(_, law, x)| Descent::new(law, x, &fresh))
        .collect();
    let (best, steps) = best_end(starts?, (&last, asked.rounds), &fresh)?;
    evaluations += steps;
    let Some(Descent { law, best, .. }) = best else {
        return Err(infeasible(0, 0).into());
    };
    let parameters = law
        .parameters_of(&best.1)
        .ok_or_else(|| infeasible(evaluations, 0))?;
    Ok(FoundPid {
        parameters,
        evaluations,
    })
}

/// A law with its parameters, and what a loss makes of them.
type Ranked = (Judged, PidLaw, Vec<f64>);

/// A few steps from a start on the lines of `loss`, and their number.
fn first_descent(
    mut loss: Loss,
    (law, mut x): (PidLaw, Vec<f64>),
    steps: usize,
    unstable_poles: i64,
) -> Result<(usize, Ranked), VerificationError> {
    // Rotors that are unstable at first may be stable after a few steps.
    let mut memory = Memory::default();
    let mut tried = 0;
    for part in 0..2 {
        activate(&mut loss, &law, &x, unstable_poles);
        let effort = Effort {
            steps: steps + part,
            tolerance: FIRST,
        };
        memory.begin();
        tried += descend(&mut loss, &law, &mut x, (&effort, &mut memory))?;
    }
    activate(&mut loss, &law, &x, unstable_poles);
    Ok((tried, (judged(&loss, &law, &x), law, x)))
}

/// The loss on lines renewed for a law with these parameters.
type FreshLoss<'a> = dyn Fn(&PidLaw, &[f64]) -> Result<Loss, VerificationError> + Sync + 'a;

/// What a loss makes of parameters: rotors with an unstable loop, the machine as it is before those with shifted
/// modes, then the merit.
type Judged = ([usize; 2], f64);

/// The machine as it is, at rest and at top speed.
fn is_nominal(rotor: &Rotor) -> bool {
    matches!(rotor.role, Role::Rest | Role::TopSpeed)
}

/// The better first.
fn order(a: &Judged, b: &Judged) -> Ordering {
    a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
}

/// A start on its way to its end.
struct Descent {
    law: PidLaw,
    /// Where the descent stands, and the loss on lines renewed for that.
    x: Vec<f64>,
    loss: Loss,
    /// The best parameters met at the end of a round, judged on lines renewed for them: a descent finds the gaps
    /// between its own.
    best: (Judged, Vec<f64>),
    evaluations: usize,
}

impl Descent {
    fn new(law: PidLaw, x: Vec<f64>, fresh: &FreshLoss) -> Result<Self, VerificationError> {
        let loss = fresh(&law, &x)?;
        Ok(Self {
            best: (judged(&loss, &law, &x), x.clone()),
            law,
            x,
            loss,
            evaluations: 0,
        })
    }

    /// Descends once and renews the lines; true when that pays for another round.
    fn round(&mut self, effort: &Effort, fresh: &FreshLoss) -> Result<bool, VerificationError> {
        // A descent that stands still on the curvature learnt on its way goes on without it.
        let how = (effort, &mut Memory::default());
        self.evaluations += descend(&mut self.loss, &self.law, &mut self.x, how)?;
        self.loss = fresh(&self.law, &self.x)?;
        let found = judged(&self.loss, &self.law, &self.x);
        let before = self.best.0;
        if order(&found, &before).is_lt() {
            self.best = (found, self.x.clone());
        }
        // The merit is logarithmic.
        Ok(order(&(found.0, found.1 + ROUND_GAIN), &before).is_lt())
    }

    /// Rounds, until as many as [`IDLE`] in a row bring nothing.
    fn rounds(
        &mut self,
        most: usize,
        effort: &Effort,
        fresh: &FreshLoss,
    ) -> Result<(), VerificationError> {
        let mut idle = 0;
        for _ in 0..most {
            idle = match self.round(effort, fresh)? {
                true => 0,
                false => idle + 1,
            };
            if idle == IDLE {
                break;
            }
        }
        Ok(())
    }
}

fn judged(loss: &Loss, law: &PidLaw, x: &[f64]) -> Judged {
    let mut lost = [0; 2];
    for (rotor, active) in loss.rotors.iter().zip(&loss.active) {
        let shifted = usize::from(!is_nominal(rotor));
        lost[shifted] += usize::from(!active);
    }
    (lost, loss.evaluate(law, x).merit(PENALTY))
}

/// The start that ends best; those that the first rounds leave far behind go no further. The controllers judged come
/// with it.
fn best_end(
    mut descents: Vec<Descent>,
    (effort, rounds): (&Effort, usize),
    fresh: &FreshLoss,
) -> Result<(Option<Descent>, usize), VerificationError> {
    let first_rounds = FIRST_ROUNDS.min(rounds);
    descents
        .par_iter_mut()
        .try_for_each(|d| d.rounds(first_rounds, effort, fresh))?;
    let Some(best) = descents.iter().map(|d| d.best.0).min_by(order) else {
        return Ok((None, 0));
    };
    let may_win = |d: &Descent| {
        let (lost, merit) = d.best.0;
        order(&(lost, merit - BEHIND), &best).is_lt()
    };
    descents
        .par_iter_mut()
        .filter(|d| may_win(d))
        .try_for_each(|d| d.rounds(rounds - first_rounds, effort, fresh))?;
    let evaluations = descents.iter().map(|d| d.evaluations).sum();
    let winner = descents
        .into_iter()
        .min_by(|a, b| order(&a.best.0, &b.best.0));
    Ok((winner, evaluations))
}

/// Lets the rotors count whose loop is stable.
fn activate(loss: &mut Loss, law: &PidLaw, x: &[f64], unstable_poles: i64) {
    let found = loss.evaluate(law, x);
    for (active, turns) in loss.active.iter_mut().zip(&found.turns) {
        *active = *turns == unstable_poles;
    }
}

/// Unstable poles of one plane of the plant at rest.
fn unstable_poles(plants: &Plants) -> Result<i64, VerificationError> {
    let sampled = plants.at_rest().sampled()?;
    let plane = x_plane(&sampled);
    let poles = plane.poles().map_err(in_step("poles of the plant"))?;
    Ok(poles.iter().filter(|z| z.norm() > 1.0).count() as i64)
}

/// Poles of the loops of some plants with a PID.
#[derive(Default)]
struct LoopPoles {
    /// With those of the PID itself, as continuous ones, upper half plane, rad/s.
    poles: Vec<c64>,
    /// Stability of each loop.
    stable: Vec<(Role, bool)>,
}

fn loop_poles(
    sampled: &SampledPlants,
    law: &PidLaw,
    x: &[f64],
) -> Result<LoopPoles, VerificationError> {
    let Some(parameters) = law.parameters_of(x) else {
        return Ok(LoopPoles::default());
    };
    let period_s = std::f64::consts::PI / law.nyquist_rad_s;
    let ControlLaw::Discrete(own) = pid_controller(&parameters, period_s, "PID")?.law else {
        return Ok(LoopPoles::default());
    };
    let numeric = in_step("poles of the PID loop");
    let mut poles = x_plane(&own).poles().map_err(&numeric)?;
    let mut stable = vec![];
    for (role, found) in sampled.loop_poles(&own).map_err(&numeric)? {
        stable.push((role, found.iter().all(|z| z.norm() < 1.0)));
        poles.extend(found);
    }
    Ok(LoopPoles {
        poles: oscillating(poles, period_s),
        stable,
    })
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
