//! The polish of the reduced controller in a design: from which starts, and which controller is delivered.
//!
//! The polished controller goes through the same rounding and certificates as the one of the D-K iteration. Of two
//! controllers, the one that meets more goals is delivered ([`super::judged`], the most important goal first); of two
//! equal ones, the stiffer one. Where the controller of the D-K iteration misses a goal, the polish starts from a tuned
//! PID as well. The controller of the D-K iteration counts as stable as far as speeds were computed; it is proven where
//! that decides, or where it is delivered. An earlier design comes before all of these: where its polish meets every
//! goal, it is delivered.

use super::PipelineError;
use super::certificates::mu_words;
use super::comparison::discrete;
use super::contact::recovers;
use super::delivery::{Delivery, DeliveryCandidate, Realised, plane_of_law};
use super::judged::Judged;
use super::overspeed::OVERSPEED;
use super::polish_job::{Goal, PolishJob, Polished, ZONE_A, ZONE_B, limits};
use super::settings::{EarlierDesign, PolishEffort};
use super::starting_pid::{StartingPid, ToolStiffness, tune_starting_pid};
use super::widening::Widening;
use crate::controller::polish::{LoopLimits, PolishRound};
use crate::controller::scaling::ScaledRealisation;
use crate::controller::speed_proof::SpeedProof;
use crate::lti::{Discrete, StateSpace};
use crate::pid::parameters::PidParameters;
use crate::pid::shifted_loops::{bears_shift, find_shift_range};
use crate::pid::surviving::{SurvivingLaw, find_surviving_law};
use crate::predict::sensitivity::Zone;
use crate::predict::stiffness::stiffness_words;

/// A polish from one start.
#[derive(Clone, Debug)]
pub struct PolishAttempt {
    /// Where it started, in words.
    pub start: &'static str,
    /// The polished controller; none when the polish could not start.
    pub judged: Option<Judged>,
    /// Why it did not take the place of the best before it; empty when it did.
    pub objections: Vec<&'static str>,
    /// What the loss said of the start, and after each round.
    pub rounds: Vec<PolishRound>,
    /// Certificates: μ of the specification and its frequency, Hz.
    pub certificates: Vec<(f64, f64)>,
    /// Why it could not start.
    pub failure: Option<String>,
}

impl PolishAttempt {
    /// From a start, without a result.
    fn from(start: &'static str) -> Self {
        Self { start, judged: None, objections: vec![], rounds: vec![], certificates: vec![], failure: None }
    }

    /// From a start to a polished controller.
    fn of(start: &'static str, judged: Judged, course: Polished) -> Self {
        Self { judged: Some(judged), rounds: course.rounds, certificates: course.certificates, ..Self::from(start) }
    }
}

/// What the polish of a design did.
#[derive(Clone, Debug)]
pub struct PolishOutcome {
    /// The controller of the D-K iteration, reduced and rounded; none where the iteration was left out.
    pub dk: Option<Judged>,
    /// Limits asked for.
    pub limits: LoopLimits,
    /// The specification whose μ the polish and its certificates are held to: as written, or with wider limits.
    pub held_to: Widening,
    /// Attempts: from an earlier design where there is one, from the D-K iteration, and, where that misses a target,
    /// from a tuned PID.
    pub attempts: Vec<PolishAttempt>,
    /// Number of the attempt whose controller is delivered; none: that of the D-K iteration is.
    pub delivered: Option<usize>,
    /// A PID tuned without regard to the design, where the controller of the D-K iteration missed a goal.
    pub tuned_pid: Option<PidParameters>,
    /// The search of a law over speed, when no other controller was stable at every speed.
    pub surviving: Option<SurvivingLaw>,
    /// The outcome in a sentence or two.
    pub sentence: String,
}

impl PolishOutcome {
    /// Before the first attempt.
    fn open(job: &PolishJob<'_>, limits: LoopLimits, dk: Option<Judged>) -> Self {
        Self {
            dk,
            limits,
            held_to: Goal::of(job).widening,
            attempts: vec![],
            delivered: None,
            tuned_pid: None,
            surviving: None,
            sentence: String::new(),
        }
    }
}

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
        let attempt = match done {
            Ok((judged, candidate, found)) => {
                let objections = self.objections(&judged);
                if objections.is_empty() {
                    (self.delivery, self.judged) = (Some(candidate), judged.clone());
                    self.outcome.delivered = Some(self.outcome.attempts.len());
                }
                PolishAttempt { objections, ..PolishAttempt::of(start, judged, found) }
            }
            // The controller of an earlier start or of the D-K iteration is kept, and the outcome says what failed.
            Err(failure) => PolishAttempt { failure: Some(failure), ..PolishAttempt::from(start) },
        };
        self.outcome.attempts.push(attempt);
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
            self.attempt(SURVIVING, limits(machine, within)?, Ok(&found.plane));
            if self.survives() {
                return Ok(());
            }
        }
        let as_found = self.job.deliver(&found.plane).map_err(|error| error.to_string());
        self.enter(SURVIVING_AS_FOUND, as_found);
        self.outcome.surviving = Some(found);
        Ok(())
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
        let within = if self.judged.zones == [Some(Zone::A); 2] { ZONE_A } else { ZONE_B };
        let (limits, plane) = (limits(machine, within)?, plane_of_law(machine, &self.judged.controller)?);
        for multiple in FLOOR_MULTIPLES {
            let floors = [self.job.floors, &rival.floors(machine, multiple)].concat();
            let job = PolishJob { floors: &floors, ..self.job };
            let attempt = match polished_from(&job, limits, &plane) {
                Ok((judged, delivery, course)) => {
                    let objection = self.objection_beside(&judged, &delivery, rival)?;
                    let accepted = objection.is_none();
                    let attempt = PolishAttempt {
                        objections: objection.into_iter().collect(),
                        ..PolishAttempt::of(OUTDOING, judged.clone(), course)
                    };
                    if accepted {
                        (self.delivery, self.judged) = (Some(delivery), judged);
                        self.outcome.delivered = Some(self.outcome.attempts.len());
                    }
                    attempt
                }
                Err(failure) => PolishAttempt { failure: Some(failure), ..PolishAttempt::from(OUTDOING) },
            };
            let is_last = attempt.objections.is_empty() && attempt.failure.is_none();
            self.outcome.attempts.push(attempt);
            if is_last {
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
        let stiffer = |rival: &&ToolStiffness| {
            self.judged.tool_stiffness().is_some_and(|own| own.least_ratio_to(rival) > FLOOR_MULTIPLES[1])
        };
        let held = rival.filter(stiffer).map(|rival| rival.floors(machine, FLOOR_MULTIPLES[1]));
        let floors = [self.job.floors, held.as_ref().map_or(&[], |held| held.as_slice())].concat();
        for _ in 0..SHIFT_TRIES {
            // A loop that bears hardly any shift has no rotor beside it to hold on to.
            if found.largest >= asked || found.largest < LEAST_SHIFT {
                break;
            }
            let within = if self.judged.zones == [Some(Zone::A); 2] { ZONE_A } else { ZONE_B };
            let shifts = found.limiting_factors(asked.min(SHIFT_HELD * found.largest));
            let job = PolishJob { shifts: &shifts, floors: &floors, ..self.job };
            let plane = plane_of_law(machine, &self.judged.controller)?;
            let attempt = match polished_from(&job, limits(machine, within)?, &plane) {
                Ok((judged, delivery, course)) => {
                    let next = find_shift_range(machine, &law(&judged)?)?;
                    let mut attempt = PolishAttempt::of(HOLDING, judged.clone(), course);
                    if next.largest <= found.largest {
                        attempt.objections = vec!["it bears no larger shift of the natural frequencies"];
                    } else if !judged.replaces(&self.judged, machine, rival) {
                        attempt.objections = vec!["with a larger shift of the natural frequencies it misses a goal"];
                    } else {
                        (self.delivery, self.judged, found) = (Some(delivery), judged, next);
                        self.outcome.delivered = Some(self.outcome.attempts.len());
                    }
                    attempt
                }
                Err(failure) => PolishAttempt { failure: Some(failure), ..PolishAttempt::from(HOLDING) },
            };
            let ends = !attempt.objections.is_empty() || attempt.failure.is_some();
            self.outcome.attempts.push(attempt);
            if ends {
                break;
            }
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
    if let Ok(StartingPid { stiffness: Some(rival), .. }) = &by_pid {
        contest.outdo(rival)?;
    }
    contest.hold_shift(by_pid.as_ref().ok().and_then(|pid| pid.stiffness.as_ref()))?;
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

fn sentence(outcome: &PolishOutcome) -> String {
    let words = |k: f64| {
        if k.is_nan() { "none (unstable loop)".to_owned() } else { stiffness_words(k) }
    };
    let beside = |dk: &Judged| {
        format!(" (D-K iteration: {} and {})", words(dk.stiffness_n_per_m[0]), words(dk.stiffness_n_per_m[1]))
    };
    let beside = outcome.dk.as_ref().map_or_else(String::new, beside);
    let figures = |attempt: &PolishAttempt, judged: &Judged| {
        format!(
            "The polish from the {} has a smallest tool stiffness of {} at rest and {} at top speed{beside}, µ of the \
             specification at most {} from rest to 1.2 times the top speed",
            attempt.start,
            words(judged.stiffness_n_per_m[0]),
            words(judged.stiffness_n_per_m[1]),
            mu_words(judged.mu),
        )
    };
    if let Some(attempt) = outcome.delivered.and_then(|k| outcome.attempts.get(k))
        && let Some(judged) = &attempt.judged
    {
        let delivered = match outcome.dk {
            Some(_) => "the polished controller is delivered",
            None => "it meets every goal and is delivered; no D-K iteration was run",
        };
        return format!("{}; {delivered}.", figures(attempt, judged));
    }
    let reasons: Vec<String> = outcome
        .attempts
        .iter()
        .map(|attempt| match (&attempt.judged, &attempt.failure) {
            (Some(judged), _) => {
                format!("{}; it is not delivered: {}.", figures(attempt, judged), attempt.objections.join(", "))
            }
            (None, failure) => {
                format!("No polish from the {}: {}.", attempt.start, failure.as_deref().unwrap_or("it did not start"))
            }
        })
        .collect();
    format!("The controller of the D-K iteration is delivered. {}", reasons.join(" "))
}
