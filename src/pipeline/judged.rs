//! Which of two controllers is delivered.

use super::PipelineError;
use super::certificates::Stage;
use super::comparison::{Prediction, predict};
use super::delivery::{Delivery, DeliveryCandidate};
use super::overspeed::OVERSPEED;
use super::starting_pid::ToolStiffness;
use crate::augment::weights::StiffnessFloor;
use crate::controller::{ControlLaw, Controller};
use crate::predict::sensitivity::Zone;
use crate::predict::stiffness::stiffness_at;
use crate::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::TAU;

/// A controller with the figures that decide which of two is delivered.
#[derive(Clone, Debug)]
pub struct Judged {
    /// The controller as it runs.
    pub controller: Controller,
    /// Its order over both planes.
    pub order: usize,
    /// Largest μ of the specification: certified at rest, on exact responses at speeds to 1.2 times the top speed.
    pub mu: f64,
    /// Certified μ at rest: specification, and with the gyroscopic split covered.
    pub mu_at_rest: [f64; 2],
    /// Smallest tool stiffness at rest and at top speed, N/m; NaN for an unstable loop.
    pub stiffness_n_per_m: [f64; 2],
    /// Zone at rest and at top speed; none of an unstable loop.
    pub zones: [Option<Zone>; 2],
    /// Stability is proven from rest to this speed, at most 1.2 times the top speed, rpm.
    pub proven_to_rpm: f64,
    /// Growth rate of the controller's own poles, 1/s.
    pub growth_rate_per_s: f64,
    /// Least tool stiffness over what the specification asks for in its bands, at rest and at top speed.
    pub share_of_floors: f64,
    /// The loop at rest and at top speed.
    pub(super) predictions: [Prediction; 2],
}

impl Judged {
    pub(super) fn of(machine: &Machine, name: &str, delivery: &Delivery) -> Result<Self, PipelineError> {
        let to_rpm = delivery.speed_proof.proven_to_rpm();
        let controller = Controller { name: name.to_owned(), law: delivery.controller.law.clone() };
        let growth_rate_per_s = delivery.controller_growth_rate_per_s;
        Self::with(machine, controller, &delivery.rounded, delivery.largest_mu(), growth_rate_per_s, to_rpm)
    }

    /// A candidate that counts as proven as far as a proof may reach ([`DeliveryCandidate::provable_to_rpm`]).
    pub(super) fn judge_unproven(
        machine: &Machine,
        name: &str,
        candidate: &DeliveryCandidate,
    ) -> Result<Self, PipelineError> {
        let to_rpm = candidate.provable_to_rpm(machine);
        let controller = Controller { name: name.to_owned(), law: ControlLaw::Discrete(candidate.law().clone()) };
        let growth_rate_per_s = candidate.growth_rate_per_s;
        Self::with(machine, controller, &candidate.rounded, candidate.largest_mu(), growth_rate_per_s, to_rpm)
    }

    fn with(
        machine: &Machine,
        controller: Controller,
        rounded: &Stage,
        mu: f64,
        growth_rate_per_s: f64,
        proven_to_rpm: f64,
    ) -> Result<Self, PipelineError> {
        let top = machine.spindle.max_rpm;
        let at = |rpm: f64| predict(machine, &controller, rpm);
        let (rest, fast) = rayon::join(|| at(0.0), || at(top));
        let both = [rest?, fast?];
        let minimum = |p: &Prediction| {
            if p.is_stable() { p.minimum.0 } else { f64::NAN }
        };
        Ok(Self {
            order: 2 * rounded.order,
            mu,
            mu_at_rest: [rounded.specification.upper, rounded.covered.upper],
            stiffness_n_per_m: [minimum(&both[0]), minimum(&both[1])],
            zones: [both[0].zone(), both[1].zone()],
            proven_to_rpm: proven_to_rpm.min(OVERSPEED * top),
            growth_rate_per_s,
            controller,
            share_of_floors: f64::INFINITY,
            predictions: both,
        })
    }

    /// With its stiffness over `floors`: on the lines of the predictions in the bands, and at both ends of each band.
    pub(super) fn measured_by(mut self, machine: &Machine, floors: &[StiffnessFloor]) -> Result<Self, PipelineError> {
        for prediction in self.predictions.iter().filter(|_| !floors.is_empty()) {
            if !prediction.is_stable() {
                self.share_of_floors = 0.0;
                continue;
            }
            let plant = Plant::new(machine, prediction.speed_rpm * TAU / 60.0, ModelDetail::Full)?;
            let responder = self.controller.responder();
            let lines = |floor: &StiffnessFloor| {
                let curves = prediction.stiffness.iter();
                let lines = curves.flat_map(|own| own.frequency_hz.iter().zip(&own.magnitude_n_per_m));
                let within = lines.filter(|(hz, _)| floor.holds_at(**hz)).map(|(_, k)| *k);
                let ends = [(0, floor.from_hz), (1, floor.from_hz), (0, floor.to_hz), (1, floor.to_hz)];
                let at_ends = ends.map(|(axis, hz)| stiffness_at(&plant, &*responder, axis, hz));
                within.chain(at_ends).fold(f64::INFINITY, f64::min)
            };
            let shares = floors.iter().map(|floor| lines(floor) / floor.at_least_n_per_m);
            self.share_of_floors = shares.fold(self.share_of_floors, f64::min);
        }
        Ok(self)
    }

    /// Slowest decay of the loop at rest and at top speed, 1/s.
    pub(super) fn decay_per_s(&self) -> f64 {
        self.predictions.iter().map(|p| -p.growth_rate_per_s).fold(f64::INFINITY, f64::min)
    }

    /// Stiffness where controllers are compared; none of an unstable loop.
    pub(super) fn tool_stiffness(&self) -> Option<ToolStiffness> {
        ToolStiffness::of(&self.predictions)
    }

    /// True when this controller may take the place of `other`, from which its polish started to be as stiff as `rival`
    /// where that is stiffer: it is stiffer than the rival everywhere, meets what the other one meets, its zones are no
    /// worse, and where µ exceeds one it is no larger but for the width of lines.
    pub(super) fn outdoes(&self, other: &Self, machine: &Machine, rival: &ToolStiffness) -> bool {
        let stiffer = self.tool_stiffness().is_some_and(|own| own.least_ratio_to(rival) > 1.0);
        stiffer && self.meets_as_much_as(other, machine) && self.mu <= SAME_MU * other.mu.max(1.0)
    }

    /// True when this controller, which gained something else, may take the place of `other`: it is as good in the rest
    /// ([`Self::is_as_good_as`]), at no larger µ where that is above one.
    pub(super) fn replaces(&self, other: &Self, machine: &Machine, rival: Option<&ToolStiffness>) -> bool {
        self.is_as_good_as(other, machine, rival) && self.mu <= other.mu.max(1.0)
    }

    /// True when this controller meets what the other one meets, at a µ that is no larger where that is above one but
    /// for the width of lines, in no worse zones, and is not softer than `rival` where the other one is not.
    pub(super) fn is_as_good_as(&self, other: &Self, machine: &Machine, rival: Option<&ToolStiffness>) -> bool {
        let stiffer = |judged: &Self, rival| judged.tool_stiffness().is_some_and(|own| own.least_ratio_to(rival) > 1.0);
        let keeps = rival.is_none_or(|rival| stiffer(self, rival) || !stiffer(other, rival));
        keeps && self.meets_as_much_as(other, machine) && self.mu <= SAME_MU * other.mu.max(1.0)
    }

    /// True when it meets what the other one meets, in no worse zones.
    fn meets_as_much_as(&self, other: &Self, machine: &Machine) -> bool {
        let (own, others) = (self.met(machine, None), other.met(machine, None));
        let meets = own.iter().zip(others).all(|(own, other)| *own || !other);
        meets && !(0..2).any(|k| self.is_in_a_worse_zone(other, k))
    }

    /// Which of [`GOALS`] are met; `rival` are the smallest tool stiffnesses of a tuned PID, if there is one.
    pub(super) fn met(&self, machine: &Machine, rival: Option<[f64; 2]>) -> [bool; GOALS.len()] {
        let within_zone_b = |zone: Option<Zone>| zone.is_some_and(|z| z <= Zone::B);
        let stiff = |rival: [f64; 2]| (0..2).all(|k| self.stiffness_n_per_m[k] >= rival[k]);
        [
            self.proven_to_rpm >= OVERSPEED * machine.spindle.max_rpm,
            self.growth_rate_per_s < 0.0,
            self.mu <= 1.0,
            self.zones.into_iter().all(within_zone_b),
            self.share_of_floors >= 1.0 - FLOOR_TOLERANCE,
            rival.is_none_or(stiff),
        ]
    }

    /// True where the zone at rest (0) or at top speed (1) is worse; an unstable loop has the worst.
    fn is_in_a_worse_zone(&self, other: &Self, k: usize) -> bool {
        let rank = |zone: Option<Zone>| zone.map_or(usize::MAX, |zone| zone as usize);
        rank(self.zones[k]) > rank(other.zones[k])
    }

    /// Why this controller is not delivered in place of `other`; empty when it is. The controller that misses the later
    /// goal is the better one; of two that miss the same the stiffer one in no worse a zone, at a μ that is no worse.
    pub(super) fn objections(&self, other: &Self, machine: &Machine, rival: Option<[f64; 2]>) -> Vec<&'static str> {
        let (own, others) = (self.met(machine, rival), other.met(machine, rival));
        if let Some(goal) = (0..GOALS.len()).find(|k| own[*k] != others[*k]) {
            return if own[goal] { vec![] } else { vec![GOALS[goal]] };
        }
        let softer = |k: usize| {
            let now = self.stiffness_n_per_m[k];
            now.is_nan() || now <= other.stiffness_n_per_m[k]
        };
        let list = [
            (self.mu.is_nan() || self.mu > other.mu.max(1.0), "µ of the whole machine is larger"),
            (self.proven_to_rpm < other.proven_to_rpm, "stability is proven to a lower speed"),
            ((0..2).any(|k| self.is_in_a_worse_zone(other, k)), "its zone of ISO 14839-3 is worse"),
            (softer(0) || softer(1), "its tool is not stiffer both at rest and at top speed"),
        ];
        list.into_iter().filter_map(|(holds, words)| holds.then_some(words)).collect()
    }
}

/// µ of two polishes of one controller is the same within this factor: the width of the lines of a polish.
const SAME_MU: f64 = 1.01;
/// A floor counts as held within the width of the lines of the polish, as its other limits do.
pub(super) const FLOOR_TOLERANCE: f64 = 0.01;

/// What a delivered controller has to meet, the most important first, as words for one that misses it.
const GOALS: [&str; 6] = [
    "stability is not proven to 1.2 times the top speed",
    "the controller itself is unstable",
    "µ of the whole machine exceeds one",
    "its sensitivity exceeds zone B of ISO 14839-3",
    "its tool is softer than `tool_stiffness` of the specification asks",
    "its tool is softer than that of the tuned PID",
];
