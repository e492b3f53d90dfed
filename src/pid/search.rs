//! Search of a PID: starts are drawn from the machine and screened by the argument principle. The best are descended
//! with exact derivatives by the method of the polish ([`crate::controller::polish`]): a few steps each, the best of
//! what these lead to further, fewer and fewer of them ([`super::descents`]). Which of them ends best is not seen
//! before.

use super::descents::{Descent, Earlier, Judged, best_end, judge_evaluation, order};
use super::law::PidLaw;
use super::parameters::{PidParameters, pid_controller};
use super::shifted_loops::SHIFTED_MODES;
use super::start::{Screen, Start, StartRule, starts};
use crate::augment::plane::x_plane;
use crate::controller::polish::LoopLimits;
use crate::controller::polish::descent::{Effort, Memory, descend};
use crate::controller::polish::lines::{lines, sharp_lines};
use crate::controller::polish::loop_poles::{SampledPlants, oscillating};
use crate::controller::polish::loss::Loss;
use crate::controller::polish::responses::{Known, Plants, ServedRotor, ShiftedRotor};
use crate::controller::polish::structure::LoopLine;
use crate::controller::verification_error::VerificationError;
use crate::controller::{ControlLaw, ControllerError, in_step};
use crate::linalg::c64;
use crate::spindle::Machine;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// What a search is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PidSearch {
    pub limits: LoopLimits,
    /// Relative shift of the flexible frequencies, both ways, that the loop must survive.
    pub mode_shift: f64,
    /// Starts drawn.
    pub starts: usize,
    pub seed: u64,
    /// Basins: [`TRIED`] starts are tried for each.
    pub basins: usize,
    /// Steps of a round at most; a start that is tried gets a sixth in all.
    pub steps: usize,
    /// Rounds of it at most.
    pub rounds: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FoundPid {
    pub parameters: PidParameters,
    pub evaluations: usize,
}

/// Lowest line, Hz: below the integrators.
const FROM_HZ: f64 = 0.05;
/// Lines closer than this share of their frequency are one.
const APART: f64 = 2e-3;
/// Multiple of the top speed up to which the loop has to be stable.
const OVERSPEED: f64 = 1.2;
/// Starts looked at on all rotors.
const SHORTLIST: usize = 24;
/// Starts that a few steps are tried from for each that is descended to its end: a start says little of where it leads.
const TRIED: usize = 6;
/// Of these, starts that a round is descended from.
const BEGUN: usize = 2;
/// Relative gain of a step below which the first descent of a start ends.
const FIRST: f64 = 2e-3;
/// The same of a round: a rival that is not tuned to its end would flatter the comparison.
const LAST: f64 = 1e-4;

/// Puts a start into the form searched for, or drops it.
type Shape<'a> = dyn Fn(PidParameters) -> Option<PidParameters> + Sync + 'a;

/// The best PID that the search finds; `given` starts come before those drawn, `free` lists the parameters that move.
/// Besides the rotors of every search it serves the `further` ones.
pub(super) fn search(
    machine: &Machine,
    asked: &PidSearch,
    further: &[ShiftedRotor],
    given: &[PidParameters],
    shape: &Shape,
    free: &[usize],
) -> Result<FoundPid, VerificationError> {
    let ground = PidGround::new(machine, asked, further)?;
    let shortlist = ground.shortlist(machine, given, shape)?;
    let of = |start: &Start| {
        let base = start.parameters.to_log();
        let x: Vec<f64> = free.iter().map(|k| base[*k]).collect();
        let law = PidLaw { base, free: free.to_vec(), nyquist_rad_s: ground.nyquist_rad_s() };
        (law, x)
    };
    let starts: Vec<(PidLaw, Vec<f64>)> = shortlist.iter().map(of).collect();
    // A PID that was tuned before stands at limits that plain lines do not show: steps on these may lead astray or out
    // of a corner, so that it goes on from where it stands as well.
    let as_given = match asked.starts {
        0 => starts.clone(),
        _ => vec![],
    };
    let (tried, mut begun) = ground.most_promising(starts)?;
    begun.extend(as_given);
    let fresh = |law: &PidLaw, x: &[f64], earlier: Earlier| ground.fresh(law, x, earlier);
    let begun: Result<Vec<Descent>, VerificationError> =
        begun.into_par_iter().map(|(law, x)| Descent::new(law, x, &fresh)).collect();
    let effort = Effort { steps: asked.steps, tolerance: LAST };
    let (best, steps) = best_end(begun?, &effort, asked.rounds, &fresh)?;
    let evaluations = asked.starts + given.len() + tried.iter().sum::<usize>() + steps;
    let parameters = best.and_then(|end| end.law.parameters_of(&end.best.1));
    Ok(FoundPid { parameters: parameters.ok_or_else(|| infeasible(evaluations, 0))?, evaluations })
}

/// Unstable poles of a PID, whose integrators are counted apart.
const STABLE_LAW: Option<i64> = Some(0);

/// What a PID is searched on: the rotors, on plain lines and on those of a loop.
struct PidGround<'a> {
    asked: &'a PidSearch,
    plants: Plants,
    plain: Vec<LoopLine>,
    /// On the plain lines.
    rotors: Vec<ServedRotor>,
    /// All plants, sampled: their loops have to be stable by their eigenvalues.
    sampled: SampledPlants,
}

impl<'a> PidGround<'a> {
    fn new(machine: &Machine, asked: &'a PidSearch, further: &[ShiftedRotor]) -> Result<Self, VerificationError> {
        let shifts = shifts(asked.mode_shift);
        let plants = Plants::new(machine, OVERSPEED, &shifts)?;
        let plain = lines(&plants, FROM_HZ, &[], APART);
        let plants = plants.with_shifts_at_top_speed(&shifts).with_further(machine, further)?;
        let sampled = SampledPlants::of(&plants, |_, _| true)?;
        Ok(Self { rotors: plants.on(&plain, &Known::NOTHING), asked, plants, plain, sampled })
    }

    fn nyquist_rad_s(&self) -> f64 {
        std::f64::consts::PI / self.plants.period_s()
    }

    /// The starts with the smallest sensitivity of those that levitate the machine at rest and top speed.
    fn shortlist(
        &self,
        machine: &Machine,
        given: &[PidParameters],
        shape: &Shape,
    ) -> Result<Vec<Start>, VerificationError> {
        let modes = self.plants.at_rest().flexible_rad_s();
        let bending = modes.first().copied().unwrap_or(0.1 * self.nyquist_rad_s());
        let rule = StartRule::new(machine, bending)?;
        let screen = Screen::new(&self.plain, &self.rotors);
        let given = given.iter().filter_map(|p| shape(*p));
        let mut all: Vec<Start> = given.map(|p| screen.start(p)).collect();
        let drawn = (self.asked.starts, self.asked.seed);
        all.extend(starts(&rule, drawn, &screen, shape));
        let fewest = all.iter().map(|s| s.unstable).min().unwrap_or(i64::MAX);
        if fewest > 0 {
            return Err(infeasible(all.len(), fewest).into());
        }
        all.retain(|s| s.unstable == 0);
        all.sort_by(|a, b| a.sensitivity.total_cmp(&b.sensitivity));
        all.truncate(SHORTLIST);
        Ok(all)
    }

    /// Of starts those that a few steps on the plain lines lead furthest, and the steps tried from each.
    fn most_promising(
        &self,
        starts: Vec<(PidLaw, Vec<f64>)>,
    ) -> Result<(Vec<usize>, Vec<(PidLaw, Vec<f64>)>), VerificationError> {
        let basins = self.asked.basins.max(1);
        let ranked = starts.into_par_iter().map(|(law, x)| {
            let mut loss = self.loss(self.plain.clone(), None);
            let found = loss.activate(&law, &x, STABLE_LAW);
            (judge_evaluation(&loss, &found), law, x)
        });
        let mut ranked: Vec<Ranked> = ranked.collect();
        ranked.sort_by(|a, b| order(&a.0, &b.0));
        ranked.truncate(TRIED * basins);
        let first = ranked.into_par_iter().map(|(_, law, x)| {
            let loss = self.loss(self.plain.clone(), None);
            first_descent(loss, law, x, self.asked.steps / 12)
        });
        let first: Result<Vec<_>, VerificationError> = first.collect();
        let (tried, mut ranked): (Vec<usize>, Vec<_>) = first?.into_iter().unzip();
        ranked.sort_by(|a, b| order(&a.0, &b.0));
        ranked.truncate(BEGUN * basins);
        let begun = ranked.into_iter().map(|(_, law, x)| (law, x));
        Ok((tried, begun.collect()))
    }

    /// The loss on some lines; responses on the same ones are those of `earlier`, or on the plain lines.
    fn loss(&self, lines: Vec<LoopLine>, earlier: Option<&Loss>) -> Loss {
        let (known, rotors) = match earlier {
            Some(earlier) => (&earlier.lines, &earlier.rotors),
            None => (&self.plain, &self.rotors),
        };
        let list: Vec<&ServedRotor> = rotors.iter().collect();
        let known = Known { lines: known, list: &list };
        let rotors = self.plants.on(&lines, &known);
        Loss::new(lines, rotors, None, self.asked.limits, self.plants.period_s())
    }

    /// The loss on lines round the poles met and those of the loops of a law, which are met by that.
    fn fresh(&self, law: &PidLaw, x: &[f64], (met, earlier): Earlier) -> Result<(Loss, Judged), VerificationError> {
        let LoopPoles { poles, stable } = loop_poles(&self.sampled, law, x)?;
        met.extend(poles);
        // From here on the gain counts, and often it is the largest there.
        let edge = [self.asked.limits.high_frequency_hz * TAU];
        let lines = sharp_lines(&self.plants, FROM_HZ, met, &edge, APART);
        let mut loss = self.loss(lines, earlier);
        let mut found = loss.activate(law, x, STABLE_LAW);
        // Turns on lines can miss a sharp pole; eigenvalues do not.
        let by_turns = loss.active.clone();
        for (number, stable) in stable {
            loss.active[number] &= stable;
        }
        if loss.active != by_turns {
            found = loss.evaluate(law, x);
        }
        let judged = judge_evaluation(&loss, &found);
        Ok((loss, judged))
    }
}

/// A law with its parameters, and what a loss makes of them.
type Ranked = (Judged, PidLaw, Vec<f64>);

/// A few steps from a start on the lines of `loss`, and their number.
fn first_descent(
    mut loss: Loss,
    law: PidLaw,
    mut x: Vec<f64>,
    steps: usize,
) -> Result<(usize, Ranked), VerificationError> {
    // Rotors that are unstable at first may be stable after a few steps.
    let mut memory = Memory::default();
    let mut tried = 0;
    for part in 0..2 {
        loss.activate(&law, &x, STABLE_LAW);
        let effort = Effort { steps: steps + part, tolerance: FIRST };
        memory.begin();
        tried += descend(&mut loss, &law, &mut x, &effort, &mut memory)?;
    }
    let found = loss.activate(&law, &x, STABLE_LAW);
    Ok((tried, (judge_evaluation(&loss, &found), law, x)))
}

/// Factors on the first natural frequencies of the rotors with shifted modes: all raised, all lowered. The certificate
/// checks more combinations. Where it finds a loop unstable, the search begins again with that loop; with more of them
/// in every search, searches take longer and the tools are no stiffer.
fn shifts(shift: f64) -> [Vec<f64>; 2] {
    [1.0 + shift, 1.0 - shift].map(|factor| vec![factor; SHIFTED_MODES])
}

/// Poles of the loops of some plants with a PID.
#[derive(Default)]
struct LoopPoles {
    /// With those of the PID itself, as continuous ones, upper half plane, rad/s.
    poles: Vec<c64>,
    /// Stability of each loop.
    stable: Vec<(usize, bool)>,
}

fn loop_poles(sampled: &SampledPlants, law: &PidLaw, x: &[f64]) -> Result<LoopPoles, VerificationError> {
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
    for (number, found) in sampled.loop_poles(&own).map_err(&numeric)? {
        stable.push((number, found.iter().all(|z| z.norm() < 1.0)));
        poles.extend(found);
    }
    Ok(LoopPoles { poles: oscillating(poles, period_s), stable })
}

fn infeasible(tried: usize, unstable: i64) -> ControllerError {
    ControllerError::Infeasible {
        step: "PID",
        reason: format!(
            "of {tried} settings drawn from the rigid-body and bending dynamics the best leaves {unstable} unstable \
             poles at rest or at top speed; that is a search, no proof that no PID is stable there"
        ),
        advice: "check delay, bandwidths and sensor planes of the spindle",
    }
}
