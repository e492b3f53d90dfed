//! Rounds of a polish: descent, and between two rounds new lines round the closed-loop poles.
//!
//! Where a certificate of the whole machine finds a peak of μ above one between the lines, [`Polisher::add_peak`] adds
//! lines there for the next round: the limit on μ is enforced by cutting planes.

use super::descent::{Effort, Memory, PENALTY, descend};
use super::limits::WEAK_MAGNETS;
use super::lines::{sharp_lines, with_further};
use super::loop_poles::{SampledPlants, oscillating};
use super::loss::{Evaluation, Loss};
use super::modal_law::ModalLaw;
use super::problem::{PolishTask, infeasible, loss_on};
use super::responses::{Plants, RotorRole, ShiftedRotor, shifts};
use super::values::{LIMIT_GROUPS, LIMITS, ValueGroup};
use crate::augment::plane::isotropic;
use crate::augment::split::{ModeSplit, gyroscopic_split};
use crate::controller::verification_error::VerificationError;
use crate::controller::{ControllerError, in_step};
use crate::linalg::{Mat, c64};
use crate::lti::connect::both_planes;
use crate::lti::{Discrete, StateSpace, TimeBase};
use crate::spindle::Machine;
use crate::spindle::plant::AXES;
use std::f64::consts::TAU;

/// A round of the polish.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolishRound {
    /// Steps tried.
    pub steps: usize,
    /// Lines of the loss.
    pub lines: usize,
    /// Smallest stiffness of the tool at the end over rest, top speed and shifted rotors as weighted in the loss, N/m.
    pub stiffness_n_per_m: f64,
    /// Largest ratio of a quantity to its limit: sensitivity, high-frequency gain, noise current, specification,
    /// sensitivity with weak magnets, floors of the tool's stiffness.
    pub over_limit: [f64; LIMITS],
}

/// A mode that splits by more than this share of its frequency changes its shape as well: rest and top speed no longer
/// stand for the speeds between, nor does a shifted rotor at rest.
const LARGE_SPLIT: f64 = 0.05;
/// Those speeds then, as shares of the top speed.
pub(crate) const SPEEDS_BETWEEN: [f64; 3] = [0.25, 0.5, 0.75];
/// Lines closer than these shares of their frequency are one, in the first round and in the later ones.
const COARSE: f64 = 2e-3;
const FINE: f64 = 5e-4;
/// Merit that a few steps have to gain together for a round to go on: a tenth of a percent of stiffness.
const TOLERANCE: f64 = 1e-3;
/// Tries of a round at most.
const TRIES: usize = 4;
/// The steps of a try are those of the one before over this number, and begin with its last proximal weight times this
/// factor.
const FEWER: usize = 3;
const HEAVIER: f64 = 4.0;
/// A limit is exceeded beyond this factor: less is what lines at other frequencies show of the same peak.
const EXCEEDED: f64 = 1.01;
/// A round has to take this share of what exceeds the limits (logarithms, summed). After one that takes less, a limit
/// of whose own excess it took less than this share counts as out of reach and is moved to where the loop is.
const WORTHWHILE: f64 = 0.25;

/// A sampled controller of one plane (signals m to currents A) on its way to a stiffer tool.
pub struct Polisher<'a> {
    task: PolishTask<'a>,
    plants: Plants,
    /// Speed beyond the top speed to which the loop has to stay stable, as a share of it.
    overspeed: f64,
    /// Speeds between rest and the top speed at which the specification has to hold as well, as shares of it.
    between: &'static [f64],
    /// Those at which it is asked for.
    asked_between: Vec<f64>,
    /// Plants at rest, at top speed and beyond, at the speeds between that are asked for, and those with shifted
    /// natural frequencies, as they are when sampled.
    sampled: SampledPlants,
    /// Their poles as continuous ones, rad/s.
    plant_poles: Vec<c64>,
    law: ModalLaw,
    x: Vec<f64>,
    /// What the descents learnt.
    memory: Memory,
    /// The last round was stuck above a limit, and this one began without what was learnt before.
    began_afresh: bool,
    /// Frequencies where a certificate found a peak, rad/s.
    peaks: Vec<f64>,
    loss: Loss,
    figures: PolishRound,
    rounds: usize,
    /// The loss is not of the controller and peaks as they are.
    stale: bool,
    /// Stability at rest, at top speed and beyond.
    stable: Vec<bool>,
    /// Poles of the loop as it is, and of the loop at the ends of tries that were taken back, rad/s.
    loop_poles: Vec<c64>,
    elsewhere: Vec<c64>,
}

/// Where a round stands on lines round the poles of its loop.
struct RoundStanding {
    merit: f64,
    /// Stability at rest, at top speed and beyond.
    stable: Vec<bool>,
    /// Rotors that count.
    active: Vec<bool>,
}

impl<'a> Polisher<'a> {
    /// Prepares the polish of `start`. The mode uncertainty of the specification is widened by the gyroscopic split of
    /// the top speed for the rotors with shifted modes; where a mode splits further than natural frequencies alone can
    /// stand for, the machine at speeds between takes its place. Up to `overspeed` times the top speed the loop has to
    /// stay stable.
    ///
    /// # Errors
    /// [`VerificationError`] from plants and eigenvalues, [`ControllerError::Infeasible`] when the start does not
    /// stabilise the machine at rest, [`ControllerError::Inaccurate`] when its modal form is not the controller.
    pub fn new(
        machine: &Machine,
        task: PolishTask<'a>,
        start: &StateSpace<Discrete>,
        overspeed: f64,
    ) -> Result<Self, VerificationError> {
        Self::prepare(machine, task, start, overspeed, vec![])
    }

    /// The same with the specification asked for at some of the speeds between as well, shares of the top speed.
    fn prepare(
        machine: &Machine,
        task: PolishTask<'a>,
        start: &StateSpace<Discrete>,
        overspeed: f64,
        asked_between: Vec<f64>,
    ) -> Result<Self, VerificationError> {
        let top = machine.spindle.max_rpm * TAU / 60.0;
        let covered = machine.spindle.flexible_modes + 2;
        let table = &task.weights.mode_uncertainty;
        let split: Vec<f64> =
            gyroscopic_split(&isotropic(machine), top, covered)?.iter().map(ModeSplit::relative).collect();
        let relative: Vec<f64> = split
            .iter()
            .enumerate()
            .map(|(k, split)| {
                let small = if *split > LARGE_SPLIT { 0.0 } else { *split };
                small + table.get(k).copied().unwrap_or(0.0)
            })
            .collect();
        let mut plants = Plants::new(machine, overspeed, &shifts(&relative))?.with_weak_magnets(&WEAK_MAGNETS);
        let between: &'static [f64] =
            if split.iter().any(|split| *split > LARGE_SPLIT) { &SPEEDS_BETWEEN } else { &[] };
        let (asked, others): (Vec<f64>, Vec<f64>) = between.iter().partition(|share| asked_between.contains(share));
        let speeds: Vec<f64> = asked.iter().map(|share| share * top).collect();
        let further = others.iter().map(|share| ShiftedRotor { speed_rad_s: share * top, factors: vec![] });
        plants = plants.with_speeds_between(machine, &speeds)?.with_further(machine, &further.collect::<Vec<_>>())?;
        plants = plants.with_bare_stability(task.shifts);
        // Those with shifted natural frequencies and the least margin too: their resonances are as narrow.
        let roles =
            [RotorRole::Rest, RotorRole::TopSpeed, RotorRole::Overspeed, RotorRole::Between, RotorRole::Weakest];
        let sampled = SampledPlants::of(&plants, |_, role| roles.contains(&role))?;
        let period_s = plants.period_s();
        let open = StateSpace::gain(Mat::zeros(AXES, AXES), Discrete { period_s });
        let found = sampled.loop_poles(&open).map_err(in_step(LOOP))?;
        let plant_poles = oscillating(all(&found), period_s);
        let (law, x) = ModalLaw::within(start, task.largest_radius(period_s))?;
        let mut polisher = Self {
            loss: loss_on(&plants, &task, vec![], None)?,
            task,
            plants,
            overspeed,
            between,
            asked_between,
            sampled,
            plant_poles,
            law,
            x,
            memory: Memory::default(),
            began_afresh: false,
            peaks: task.floors.iter().flat_map(|floor| [floor.from_hz, floor.to_hz].map(|hz| TAU * hz)).collect(),
            figures: PolishRound { steps: 0, lines: 0, stiffness_n_per_m: f64::NAN, over_limit: [f64::NAN; LIMITS] },
            rounds: 0,
            stale: false,
            stable: vec![],
            loop_poles: vec![],
            elsewhere: vec![],
        };
        polisher.renew(COARSE)?;
        if polisher.stable.first() != Some(&true) {
            let own = start.growth_rate().map_err(in_step("poles of the start"))?;
            let reason = if own >= 0.0 {
                "the start is unstable itself, and with its poles moved inside the circle it does not levitate \
                     the machine at rest"
            } else {
                "the start does not levitate the machine at rest"
            };
            return Err(infeasible(reason).into());
        }
        Ok(polisher)
    }

    /// What the loss says of the controller as it is, on lines round its own poles.
    pub fn figures(&self) -> PolishRound {
        self.figures
    }

    /// Speeds at which the specification has to hold, as shares of the top speed: at rest, at top speed and beyond, and
    /// between where a mode splits so far that these do not stand for it.
    pub(crate) fn speed_shares(&self) -> Vec<f64> {
        [&[0.0, 1.0, self.overspeed], self.between].concat()
    }

    /// Asks for the specification at one more of the speeds between, and goes on from the controller as it is; false
    /// where the specification is asked for already, or does not have to hold.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn ask_at(&mut self, machine: &Machine, share: f64) -> Result<bool, VerificationError> {
        if !self.between.contains(&share) || self.asked_between.contains(&share) {
            return Ok(false);
        }
        let asked = [&self.asked_between[..], &[share]].concat();
        let next = Self::prepare(machine, self.task, &self.plane()?, self.overspeed, asked)?;
        let peaks = std::mem::take(&mut self.peaks);
        *self = Self { peaks, stale: true, ..next };
        Ok(true)
    }

    /// The controller as it is, own poles inside the circle.
    ///
    /// # Errors
    /// [`ControllerError`] for parameters that are not finite.
    pub fn plane(&self) -> Result<StateSpace<Discrete>, ControllerError> {
        self.law.system(&self.x).map_err(in_step("polish"))
    }

    /// Asks for lines at a peak of μ between the lines, and for a limit on μ lower by the `factor`.
    pub fn add_peak(&mut self, frequency_hz: f64, factor: f64) {
        self.peaks.push(TAU * frequency_hz);
        self.stale = true;
        self.task.limits.mu *= factor;
    }

    /// True where the loss has a line at a frequency: what a certificate finds there is not between its lines.
    pub fn has_line_at(&self, frequency_hz: f64) -> bool {
        let omega = TAU * frequency_hz;
        let lines = self.loss.lines.iter();
        let mut apart = lines.map(|line| (line.omega_rad_s / omega - 1.0).abs());
        apart.any(|apart| apart < FINE)
    }

    /// Limits as they are now: those that are out of reach are where a round brought them.
    pub fn limits(&self) -> super::LoopLimits {
        self.task.limits
    }

    /// A round of `steps` steps at most, on lines round the poles of the loop as it is; then the lines are renewed.
    ///
    /// A pole that moves by more than its width leaves its lines, and what the loop is there shows only on the renewed
    /// ones. A round that is worse on them than where it began, or that loses stability at a speed where the loop had
    /// it, goes on for some steps on the renewed lines; if it still is, it is taken back and tried again with fewer and
    /// shorter steps, on the lines of both.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn run_round(&mut self, steps: usize) -> Result<PolishRound, VerificationError> {
        if self.stale {
            self.renew(FINE)?;
        }
        let start = self.x.clone();
        let before = self.figures;
        let mut begun = self.standing();
        let first = self.rounds == 0;
        let mut effort = Effort { steps, tolerance: TOLERANCE };
        self.memory.begin();
        let mut done = 0;
        for number in 0..TRIES {
            let memory = &mut self.memory;
            done += descend(&mut self.loss, &self.law, &mut self.x, &effort, memory)?;
            self.renew(FINE)?;
            if self.no_worse_than(&begun) {
                break;
            }
            self.elsewhere.extend(&self.loop_poles);
            effort.steps /= FEWER;
            if number == 0 && !self.lost_stability(&begun) {
                continue;
            }
            self.x.clone_from(&start);
            self.renew(FINE)?;
            begun = self.standing();
            self.memory.weight *= HEAVIER;
        }
        self.stale |= !self.elsewhere.is_empty();
        self.elsewhere.clear();
        let after = excess(&self.figures);
        let stuck = after > EXCEEDED.ln() && after > (1.0 - WORTHWHILE) * excess(&before);
        if !first && stuck {
            // Curvature learnt on the way may be what holds it: a limit is given up by a descent that began without.
            if std::mem::replace(&mut self.began_afresh, true) {
                self.keep_within_reach(&before)
            } else {
                self.memory = Memory::default()
            }
        }
        self.began_afresh &= stuck;
        self.rounds += 1;
        self.figures.steps = done;
        Ok(self.figures)
    }

    fn standing(&self) -> RoundStanding {
        RoundStanding {
            merit: PENALTY * excess(&self.figures) - self.figures.stiffness_n_per_m.ln(),
            stable: self.stable.clone(),
            active: self.loss.active.clone(),
        }
    }

    /// True when no speed and no rotor lost its stability and the merit is no worse; a rotor that came to count, with
    /// what it adds to the merit, is a gain.
    fn no_worse_than(&self, begun: &RoundStanding) -> bool {
        let now = self.standing();
        let gained = only_in(&now.active, &begun.active);
        !self.lost_stability(begun) && (gained || now.merit <= begun.merit)
    }

    /// True when a speed or a rotor lost its stability.
    fn lost_stability(&self, begun: &RoundStanding) -> bool {
        only_in(&begun.stable, &self.stable) || only_in(&begun.active, &self.loss.active)
    }

    /// What μ on the lines is, relative to its limit.
    fn mu_over_limit(&self) -> Option<f64> {
        ValueGroup::Specification.limit().map(|k| self.figures.over_limit[k])
    }

    /// Moves the limit on μ to where the loop is, if it exceeds it.
    pub(crate) fn hold_mu(&mut self) {
        if self.mu_over_limit().is_some_and(|over| over > 1.0) {
            self.limit_mu_to(1.0);
        }
    }

    /// Moves the limit on μ to a share of what the loop has on the lines.
    pub(crate) fn limit_mu_to(&mut self, share: f64) {
        if let Some(over) = self.mu_over_limit() {
            self.task.limits.mu *= over * share;
            self.stale = true;
        }
    }

    /// True when the loop is stable at rest, at top speed and beyond.
    pub fn is_stable(&self) -> bool {
        self.stable.iter().all(|stable| *stable)
    }

    /// True when no limit is exceeded, as far as the lines show.
    pub(crate) fn within_limits(&self) -> bool {
        excess(&self.figures) <= EXCEEDED.ln()
    }

    /// Moves the limits that are out of reach to where the loop is: those that were exceeded before the round, and of
    /// whose excess it took too little.
    fn keep_within_reach(&mut self, before: &PolishRound) {
        let limits = &mut self.task.limits;
        let list = [
            &mut limits.sensitivity,
            &mut limits.high_frequency_gain_a_per_m,
            &mut limits.noise_current_a,
            &mut limits.mu,
            &mut limits.weak_sensitivity,
            &mut limits.tool_softness,
        ];
        let over = self.figures.over_limit.into_iter().zip(before.over_limit);
        for (limit, (over, before)) in list.into_iter().zip(over) {
            let exceeded = before.min(over) > EXCEEDED;
            if exceeded && over.ln() > (1.0 - WORTHWHILE) * before.ln() {
                *limit *= over;
            }
        }
        self.loss.limits = *limits;
    }

    /// Lines and figures of the loop as it is, round its poles, and its stability.
    fn renew(&mut self, apart: f64) -> Result<(), VerificationError> {
        let plane = self.plane()?;
        let found = self.sampled.loop_poles(&both_planes(&plane)).map_err(in_step(LOOP))?;
        let is_stable = |poles: &[c64]| plane.time.largest_growth_rate(poles) < 0.0;
        let stable = found.iter().map(|(_, poles)| is_stable(poles)).collect();
        let mut poles = oscillating(all(&found), plane.time.period_s);
        self.loop_poles.clone_from(&poles);
        poles.extend(&self.plant_poles);
        poles.extend(&self.elsewhere);
        let own = plane.poles().map_err(in_step("poles of the polished controller"))?;
        poles.extend(oscillating(own, self.plants.period_s()));
        let lines = sharp_lines(&self.plants, FROM_HZ, &poles, &self.peaks, apart);
        let mut loss = loss_on(&self.plants, &self.task, lines, Some(&self.loss))?;
        let mut found = loss.activate(&self.law, &self.x, None);
        loss.rescale(&mut found);
        let beside = loss.beside_peaks(&found);
        if !beside.is_empty() {
            let lines = with_further(&loss.lines, &beside, self.plants.period_s());
            let active = loss.active.clone();
            loss = loss_on(&self.plants, &self.task, lines, Some(&loss))?;
            loss.active = active;
            found = loss.evaluate(&self.law, &self.x);
            loss.rescale(&mut found);
        }
        self.figures = figures(&loss, &found);
        self.loss = loss;
        self.stale = false;
        self.stable = stable;
        Ok(())
    }
}

/// Step that an error of the poles names.
const LOOP: &str = "poles of the polished loop";

fn all(loops: &[(usize, Vec<c64>)]) -> Vec<c64> {
    loops.iter().flat_map(|(_, poles)| poles).copied().collect()
}

/// First line, Hz: below every bearing's bandwidth.
const FROM_HZ: f64 = 1.0;

/// True when some entry holds in the first list and not in the second.
fn only_in(a: &[bool], b: &[bool]) -> bool {
    a.iter().zip(b).any(|(a, b)| *a && !b)
}

/// What exceeds the limits, logarithms summed.
fn excess(round: &PolishRound) -> f64 {
    round.over_limit.iter().map(|over| over.ln().max(0.0)).sum()
}

fn figures(loss: &Loss, found: &Evaluation) -> PolishRound {
    PolishRound {
        steps: 0,
        lines: loss.lines.len(),
        stiffness_n_per_m: 1e6 * (-found.largest(ValueGroup::Compliance)).exp(),
        over_limit: LIMIT_GROUPS.map(|g| found.largest(g).exp()),
    }
}
