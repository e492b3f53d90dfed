//! The polish of the reduced controller in a design: from which starts, and which controller is delivered.
//!
//! The polished controller goes through the same rounding and certificates as the one of the D-K iteration. Of two
//! controllers, the one that meets more goals is delivered ([`super::judged`], the most important goal first); of two
//! equal ones, the stiffer one. Where the controller of the D-K iteration misses a goal, the polish starts from a tuned
//! PID as well. Where no controller is stable at every speed, a law that is stable there is searched and polished.
//! Where the controller of the D-K iteration is unstable at some speed, the order of the best one grows
//! ([`super::growth`]). That controller counts as stable as far as speeds were computed; it is proven where that
//! decides, or where it is delivered. An earlier design comes before all of these: where its polish meets every goal,
//! it is delivered.

use super::PipelineError;
use super::comparison::discrete;
use super::contact::recovers;
use super::delivery::{Delivery, DeliveryCandidate, Realised, plane_of_law};
use super::growth::with_section;
use super::judged::Judged;
use super::overspeed::OVERSPEED;
use super::polish_job::{PolishJob, Polished, ZONE_A, ZONE_B, limits};
use super::polish_outcome::{PolishAttempt, PolishOutcome, sentence};
use super::settings::{EarlierDesign, PolishEffort};
use super::starting_pid::{StartingPid, ToolStiffness, tune_starting_pid};
use crate::augment::weights::{LEAST_DECAY_PER_S, StiffnessFloor};
use crate::controller::polish::LoopLimits;
use crate::controller::scaling::ScaledRealisation;
use crate::controller::speed_proof::SpeedProof;
use crate::lti::{Discrete, StateSpace};
use crate::pid::shifted_loops::{bears_shift, find_shift_range};
use crate::pid::surviving::find_surviving_law;
use crate::predict::sensitivity::Zone;
use rayon::prelude::*;

/// What the attempts share.
struct Contest<'a> {
    job: PolishJob<'a>,
    /// Smallest tool stiffness of a tuned PID at rest and at top speed, once there is one, N/m.
    rival: Option<[f64; 2]>,
    /// The controller of the D-K iteration, and the proof of its stability once it was asked for.
    dk: DeliveryCandidate,
    dk_proof: Option<SpeedProof>,
    /// The best so far; no delivery: that of the D-K iteration is.
    delivery: Option<Delivery>,
    judged: Judged,
    outcome: PolishOutcome,
}

impl<'a> Contest<'a> {
    /// Opened by `plane`, the controller of the D-K iteration.
    fn with(job: PolishJob<'a>, limits: LoopLimits, plane: &StateSpace<Discrete>) -> Result<Self, PipelineError> {
        let realised = Realised::new(job.machine, plane)?;
        let dk = DeliveryCandidate::new(job.machine, job.weights, job.problems, realised)?;
        let judged =
            Judged::judge_unproven(job.machine, "dk", &dk)?.measured_by(job.machine, &job.weights.tool_stiffness)?;
        Ok(Self {
            job,
            rival: None,
            outcome: PolishOutcome::open(&job, limits, Some(judged.clone())),
            dk,
            dk_proof: None,
            delivery: None,
            judged,
        })
    }

    fn misses_a_goal(&self) -> bool {
        self.judged.met(self.job.machine, self.rival).contains(&false)
    }

    /// True when a larger sensitivity may help: the zone is worse than B, or the tool softer than that of the PID.
    fn wants_sensitivity(&self) -> bool {
        let [.., zone_b, above_floors, as_stiff] = self.judged.met(self.job.machine, self.rival);
        !zone_b || !above_floors || !as_stiff
    }

    /// Why a controller is not delivered in place of the best so far. How far the stability of that of the D-K
    /// iteration is proven is asked only where it may decide.
    fn objections(&mut self, judged: &Judged) -> Vec<&'static str> {
        let machine = self.job.machine;
        let found = judged.objections(&self.judged, machine, self.rival);
        if found.is_empty() || self.delivery.is_some() || self.dk_proof.is_some() {
            return found;
        }
        self.prove_dk();
        judged.objections(&self.judged, machine, self.rival)
    }

    /// Proves the stability of the controller of the D-K iteration, of which `judged` still is.
    fn prove_dk(&mut self) {
        // What cannot be computed is not proven; delivery asks again and says why.
        self.dk_proof = self.dk.proof(self.job.machine).ok();
        let proven = self.dk_proof.as_ref().map_or(0.0, SpeedProof::proven_to_rpm);
        self.judged.proven_to_rpm = proven.min(self.judged.proven_to_rpm);
        self.outcome.dk = Some(self.judged.clone());
    }

    /// Polishes `plane`, and keeps the result when it is better.
    fn attempt(
        &mut self,
        start: &'static str,
        limits: LoopLimits,
        plane: Result<&StateSpace<Discrete>, &PipelineError>,
    ) {
        let done = plane.map_err(ToString::to_string).and_then(|plane| polished_from(&self.job, limits, plane));
        self.enter(start, done);
    }

    /// Keeps what a polish led to when it is better.
    fn enter(&mut self, start: &'static str, done: Entrant) {
        let objections = done.as_ref().map_or(vec![], |(judged, ..)| self.objections(judged));
        self.keep_unless(objections, start, done);
    }

    /// Keeps what a polish led to unless there are objections; true when it is kept.
    fn keep_unless(&mut self, objections: Vec<&'static str>, start: &'static str, done: Entrant) -> bool {
        let is_kept = done.is_ok() && objections.is_empty();
        let attempt = match done {
            Ok((judged, delivery, course)) => {
                if is_kept {
                    (self.delivery, self.judged) = (Some(delivery), judged.clone());
                    self.outcome.delivered = Some(self.outcome.attempts.len());
                }
                PolishAttempt { objections, ..PolishAttempt::of(start, judged, course) }
            }
            // The best controller so far is kept, and the outcome says what failed.
            Err(failure) => PolishAttempt { failure: Some(failure), ..PolishAttempt::from(start) },
        };
        self.outcome.attempts.push(attempt);
        is_kept
    }
}

/// Multiples of the PID's stiffness that are tried as floors, the first that leads to a stiffer tool everywhere: lines
/// and the rival of a whole run, which is held to other limits, take off some per cent.
const FLOOR_MULTIPLES: [f64; 2] = [1.2, 1.05];
const SURVIVING: &str = "law that survives at speed";
const SURVIVING_AS_FOUND: &str = "law that survives at speed, as found";
/// Polishes that widen the range of shifts.
const SHIFT_TRIES: usize = 4;
/// Part of the range at which the loop with shifted modes is held stable with a margin: near its end, where that margin
/// is not there yet.
const SHIFT_HELD: f64 = 0.97;
/// Ranges below this, a few times the width to which they are found, are none.
const LEAST_SHIFT: f64 = 0.003;
const HOLDING: &str = "best controller, with shifted natural frequencies,";
const DECAYING: &str = "best controller, without slow poles,";
const GROWN: &str = "best controller, with sections where µ peaks,";
/// Strengths of a section that starts a polish: the next one where none lowers µ. A strong one gives the polish more to
/// move, a weak one leaves the loop stable.
const SECTION_STRENGTHS: [f64; 3] = [0.6, 0.3, 0.15];
/// Sections tried at most, and the share of µ that one may leave to be kept, unless it is one: less is not worth the
/// states.
const MOST_SECTIONS: usize = 8;
const WORTH_A_SECTION: f64 = 0.98;
const OUTDOING: &str = "best controller, with floors above the stiffness of the tuned PID,";

impl Contest<'_> {
    /// True when stability is proven from rest to the overspeed.
    fn survives(&self) -> bool {
        self.judged.proven_to_rpm >= OVERSPEED * self.job.machine.spindle.max_rpm
    }

    /// Where no controller is stable at every speed, searches a law that is, and polishes it; delivered as found where
    /// its polish does not keep it stable.
    fn attempt_surviving(&mut self) -> Result<(), PipelineError> {
        if self.survives() {
            return Ok(());
        }
        let machine = self.job.machine;
        let found = find_surviving_law(machine, OVERSPEED * machine.spindle.max_rpm)?;
        for within in [ZONE_A, ZONE_B] {
            let done = polished_from(&self.job.to_least_mu(), limits(machine, within)?, &found.plane);
            self.enter(SURVIVING, done);
            if self.survives() {
                return Ok(());
            }
        }
        let as_found = self.job.deliver(&found.plane).map_err(|error| error.to_string());
        self.enter(SURVIVING_AS_FOUND, as_found);
        self.outcome.surviving = Some(found);
        Ok(())
    }

    /// Adds sections to the best controller where µ of the whole machine peaks, as long as it exceeds one and falls.
    /// Only where the controller of the D-K iteration, which sees the machine at rest, is unstable at some speed: on
    /// five spindles where it is stable, sections lowered µ by less than one per cent.
    fn grow(&mut self) -> Result<(), PipelineError> {
        let is_stable = self.dk.largest_mu().is_finite();
        if is_stable || !self.survives() {
            return Ok(());
        }
        let mut strengths = SECTION_STRENGTHS.into_iter();
        let mut strength = strengths.next();
        for _ in 0..MOST_SECTIONS {
            let peak = self.delivery.as_ref().and_then(Delivery::largest_over_speed).filter(|peak| peak.mu > 1.0);
            let (Some(peak), Some(own)) = (peak, strength) else {
                break;
            };
            let plane = plane_of_law(self.job.machine, &self.judged.controller)?;
            let asked_between = self.delivery.as_ref().map_or(vec![], |best| best.higher_between(self.job.machine));
            let job = PolishJob { asked_between: &asked_between, ..self.job.to_least_mu() };
            let limits = self.limits_of_zone()?;
            let grown = with_section(&plane, peak.frequency_hz.abs(), own)?;
            let done: Vec<Entrant> = grown.par_iter().map(|plane| polished_from(&job, limits, plane)).collect();
            // Those without an objection first, then by µ.
            let rank = |done: &Entrant| match done {
                Ok((judged, ..)) => (self.objection_to_grown(judged).is_some(), judged.mu),
                Err(_) => (true, f64::INFINITY),
            };
            let order = |a: (bool, f64), b: (bool, f64)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
            let Some(best) = done.into_iter().min_by(|a, b| order(rank(a), rank(b))) else {
                break;
            };
            let objection = best.as_ref().ok().and_then(|(judged, ..)| self.objection_to_grown(judged));
            if !self.keep_unless(objection.into_iter().collect(), GROWN, best) {
                strength = strengths.next();
            }
        }
        Ok(())
    }

    /// Why a controller with one section more does not take the place of the best one.
    fn objection_to_grown(&self, judged: &Judged) -> Option<&'static str> {
        if judged.mu > (WORTH_A_SECTION * self.judged.mu).max(1.0) {
            return Some("µ of the whole machine falls by too little");
        }
        let replaces = judged.replaces(&self.judged, self.job.machine, None);
        (!replaces).then_some("with the section it misses a goal, or its zone is worse")
    }

    /// Limits of the zone that the best controller is in: A, or B.
    fn limits_of_zone(&self) -> Result<LoopLimits, PipelineError> {
        let within = if self.judged.zones == [Some(Zone::A); 2] { ZONE_A } else { ZONE_B };
        limits(self.job.machine, within)
    }

    /// Where the PID is stiffer at low frequency, at that of the top speed or at the minimum, polishes the best
    /// controller again with floors there, and keeps the result when it is stiffer everywhere, meets what it met, and
    /// comes back from the backup bearings as before.
    fn outdo(&mut self, rival: &ToolStiffness) -> Result<(), PipelineError> {
        let machine = self.job.machine;
        let is_behind = |own: ToolStiffness| own.least_ratio_to(rival) < FLOOR_MULTIPLES[1];
        if !self.judged.tool_stiffness().is_some_and(is_behind) {
            return Ok(());
        }
        let (limits, plane) = (self.limits_of_zone()?, plane_of_law(machine, &self.judged.controller)?);
        for multiple in FLOOR_MULTIPLES {
            let floors = [self.job.floors, &rival.floors(machine, multiple)].concat();
            // It starts at the optimum without these floors, off which the first round spends its steps.
            let effort = PolishEffort { rounds: self.job.effort.rounds + 1, ..self.job.effort };
            let job = PolishJob { floors: &floors, effort, ..self.job };
            let done = polished_from(&job, limits, &plane);
            let objection = match &done {
                Ok((judged, delivery, _)) => self.objection_beside(judged, delivery, rival)?,
                Err(_) => None,
            };
            if self.keep_unless(objection.into_iter().collect(), OUTDOING, done) {
                break;
            }
        }
        Ok(())
    }

    /// Why a controller polished to outdo `rival` does not take the place of the best one.
    fn objection_beside(
        &self,
        judged: &Judged,
        delivery: &Delivery,
        rival: &ToolStiffness,
    ) -> Result<Option<&'static str>, PipelineError> {
        let machine = self.job.machine;
        if !judged.outdoes(&self.judged, machine, rival) {
            return Ok(Some("it is not stiffer than the tuned PID everywhere at the same µ and zone"));
        }
        let comes_back = |rows: &ScaledRealisation| recovers(machine, rows);
        let recovered = match &self.delivery {
            Some(best) => comes_back(&best.realisation)?,
            // The controller of the D-K iteration is no delivery yet: the stricter answer.
            None => true,
        };
        if recovered && !comes_back(&delivery.realisation)? {
            return Ok(Some("with it the rotor does not come free of the backup bearings"));
        }
        Ok(None)
    }
}

impl Contest<'_> {
    /// The floors of the specification, and the stiffness of the PID where the tool is stiffer.
    fn floors_that_stay(&self, rival: Option<&ToolStiffness>) -> Vec<StiffnessFloor> {
        let stiffer = |rival: &&ToolStiffness| {
            self.judged.tool_stiffness().is_some_and(|own| own.least_ratio_to(rival) > FLOOR_MULTIPLES[1])
        };
        let held = rival.filter(stiffer).map(|rival| rival.floors(self.job.machine, FLOOR_MULTIPLES[1]));
        [self.job.floors, held.as_ref().map_or(&[], |held| held.as_slice())].concat()
    }

    /// Where the loop of the best controller creeps to rest, polishes it again without slow poles of its own, and keeps
    /// what decays faster and meets what the best one met. Integral action is such a pole.
    fn raise_decay(&mut self, rival: Option<&ToolStiffness>) -> Result<(), PipelineError> {
        let PolishJob { machine, weights, .. } = self.job;
        let asks = weights.least_decay_per_s.is_none() && weights.integral_corner_hz.is_none();
        let slowest = self.judged.decay_per_s();
        if !asks || !self.survives() || slowest >= LEAST_DECAY_PER_S {
            return Ok(());
        }
        let floors = self.floors_that_stay(rival);
        let job = PolishJob { floors: &floors, least_decay_per_s: LEAST_DECAY_PER_S, ..self.job };
        let plane = plane_of_law(machine, &self.judged.controller)?;
        let done = polished_from(&job, self.limits_of_zone()?, &plane);
        let objection = done.as_ref().ok().and_then(|(judged, ..)| {
            if judged.decay_per_s() <= slowest {
                return Some("the loop decays no faster");
            }
            let stays = judged.is_as_good_as(&self.judged, machine, rival);
            (!stays).then_some("without slow poles it misses a goal")
        });
        if self.keep_unless(objection.into_iter().collect(), DECAYING, done) {
            self.job.least_decay_per_s = LEAST_DECAY_PER_S;
        }
        Ok(())
    }

    /// Where the loop of the best controller does not bear the shift of the natural frequencies that is asked, polishes
    /// it again with those that it bears nearly, further each time. What comes out is kept as long as it meets what the
    /// best one met and its tool stays stiffer than that of the PID.
    fn hold_shift(&mut self, rival: Option<&ToolStiffness>) -> Result<(), PipelineError> {
        let (machine, asked) = (self.job.machine, self.job.weights.mode_shift);
        let law = |judged: &Judged| discrete(&judged.controller, machine.spindle.electronics.sample_period_s());
        let own = law(&self.judged)?;
        if asked == 0.0 || !self.survives() || bears_shift(machine, &own, asked)? {
            return Ok(());
        }
        let mut found = find_shift_range(machine, &own)?;
        let floors = self.floors_that_stay(rival);
        for _ in 0..SHIFT_TRIES {
            // A loop that bears hardly any shift has no rotor beside it to hold on to.
            if found.largest >= asked || found.largest < LEAST_SHIFT {
                break;
            }
            let shifts = found.limiting_factors(asked.min(SHIFT_HELD * found.largest));
            let job = PolishJob { shifts: &shifts, floors: &floors, ..self.job };
            let plane = plane_of_law(machine, &self.judged.controller)?;
            let done = polished_from(&job, self.limits_of_zone()?, &plane);
            let mut further = found.clone();
            let objection = match &done {
                Ok((judged, ..)) => {
                    further = find_shift_range(machine, &law(judged)?)?;
                    let stays = judged.replaces(&self.judged, machine, rival);
                    if further.largest <= found.largest {
                        Some("it bears no larger shift of the natural frequencies")
                    } else {
                        (!stays).then_some("with a larger shift of the natural frequencies it misses a goal")
                    }
                }
                Err(_) => None,
            };
            if !self.keep_unless(objection.into_iter().collect(), HOLDING, done) {
                break;
            }
            found = further;
        }
        Ok(())
    }
}

/// The figures, the delivery and the course of a polish.
type Attempted = (Judged, Delivery, Polished);

/// What a polish led to, or in words why there is none.
pub(super) type Entrant = Result<Attempted, String>;

/// A polish, or in words why there is none.
fn polished_from(job: &PolishJob<'_>, limits: LoopLimits, plane: &StateSpace<Discrete>) -> Entrant {
    job.polish(limits, plane).map_err(|error| error.to_string())
}

/// What the polish of an earlier design led to.
pub(super) enum PolishedAgain {
    /// A controller that meets every goal, delivered.
    Delivered(Box<(Delivery, PolishOutcome)>),
    /// One that misses a goal, or does not suffice by itself: an attempt beside that from the D-K iteration.
    Entrant(Box<Entrant>),
}

const DK: &str = "D-K iteration";
const EARLIER: &str = "earlier design";

/// Polishes the controller of an earlier design.
pub(super) fn polished_again(job: PolishJob<'_>, earlier: &EarlierDesign) -> Result<PolishedAgain, PipelineError> {
    let zone_a = limits(job.machine, ZONE_A)?;
    // It is polished already: its first round tells whether there is more to gain.
    let effort = PolishEffort { rounds: 1, ..job.effort };
    let done = polished_from(&PolishJob { effort, ..job }, zone_a, &earlier.plane);
    let enough = |judged: &Judged| !judged.met(job.machine, None).contains(&false);
    Ok(match done {
        Ok((judged, delivery, course)) if earlier.suffices && enough(&judged) => {
            let mut outcome = PolishOutcome::open(&job, zone_a, None);
            outcome.attempts = vec![PolishAttempt::of(EARLIER, judged, course)];
            outcome.delivered = Some(0);
            outcome.sentence = sentence(&outcome);
            PolishedAgain::Delivered(Box::new((delivery, outcome)))
        }
        done => PolishedAgain::Entrant(Box::new(done)),
    })
}

/// Polishes `plane`, the controller of the D-K iteration, and decides which controller is delivered, it, the polished
/// one, or `earlier`, what the polish of an earlier design led to. Where that of the D-K iteration misses a goal, a PID
/// is tuned: the polished controller has to be as stiff, and where it misses a goal too, the polish starts from the PID
/// as well, within zone A, then within zone B.
pub(super) fn polish_law(
    job: PolishJob<'_>,
    plane: &StateSpace<Discrete>,
    earlier: Option<Entrant>,
) -> Result<(Delivery, PolishOutcome), PipelineError> {
    let machine = job.machine;
    let zone_a = limits(machine, ZONE_A)?;
    // The figures of the D-K iteration, with the tuned PID, and the first polish do not depend on each other.
    let entered = || {
        let mut contest = Contest::with(job, zone_a, plane)?;
        let by_pid = tune_starting_pid(machine);
        let rivals = contest.misses_a_goal();
        if let Ok(pid) = &by_pid {
            // A PID with an unstable loop is not compared.
            contest.rival = rivals.then(|| pid.stiffness.map_or([0.0; 2], |own| own.minimum_n_per_m));
            contest.outcome.tuned_pid = Some(pid.parameters);
        }
        Ok::<_, PipelineError>((contest, by_pid, rivals))
    };
    let (entered, done) = rayon::join(entered, || polished_from(&job, zone_a, plane));
    let (mut contest, by_pid, rivals) = entered?;
    if let Some(earlier) = earlier {
        contest.enter(EARLIER, earlier);
    }
    contest.enter(DK, done);
    if rivals {
        let start = by_pid.as_ref().map(|pid| &pid.plane);
        if contest.misses_a_goal() {
            contest.attempt("tuned PID", zone_a, start);
        }
        if contest.wants_sensitivity() && start.is_ok() {
            contest.attempt("tuned PID within zone B", limits(machine, ZONE_B)?, start);
        }
    }
    contest.attempt_surviving()?;
    contest.grow()?;
    if let Ok(StartingPid { stiffness: Some(rival), .. }) = &by_pid {
        contest.outdo(rival)?;
    }
    let rival = by_pid.as_ref().ok().and_then(|pid| pid.stiffness.as_ref());
    contest.raise_decay(rival)?;
    contest.hold_shift(rival)?;
    let mut outcome = contest.outcome;
    outcome.sentence = sentence(&outcome);
    let delivery = match (contest.delivery, contest.dk_proof) {
        (Some(polished), _) => polished,
        (None, proof) => {
            let proof = proof.map_or_else(|| contest.dk.proof(machine), Ok)?;
            contest.dk.deliver_candidate(machine, job.weights, job.problems, job.speeds, proof)?
        }
    };
    Ok((delivery, outcome))
}
