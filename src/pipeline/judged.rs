//! Which of two controllers is delivered.

use super::PipelineError;
use super::certificates::Stage;
use super::comparison::{Prediction, predict};
use super::delivery::{Candidate, Delivery};
use super::overspeed::OVERSPEED;
use crate::controller::{ControlLaw, Controller};
use crate::predict::sensitivity::Zone;
use crate::spindle::Machine;

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
    /// The loop at rest and at top speed.
    pub(super) predictions: [Prediction; 2],
}

impl Judged {
    /// A controller that is delivered.
    pub(super) fn of(machine: &Machine, name: &str, delivery: &Delivery) -> Result<Self, PipelineError> {
        let to_rpm = delivery.speed_proof.proven_to_rpm();
        let figures = (delivery.largest_mu(), delivery.controller_growth_rate_per_s);
        let law = delivery.controller.law.clone();
        Self::with(machine, (name, law), &delivery.rounded, figures, to_rpm)
    }

    /// A candidate that counts as proven as far as a proof may reach ([`Candidate::provable_to_rpm`]).
    pub(super) fn unproven(machine: &Machine, name: &str, candidate: &Candidate) -> Result<Self, PipelineError> {
        let to_rpm = candidate.provable_to_rpm(machine);
        let figures = (candidate.largest_mu(), candidate.growth_rate_per_s);
        let law = ControlLaw::Discrete(candidate.law().clone());
        Self::with(machine, (name, law), &candidate.rounded, figures, to_rpm)
    }

    fn with(
        machine: &Machine,
        (name, law): (&str, ControlLaw),
        rounded: &Stage,
        (mu, growth_rate_per_s): (f64, f64),
        proven_to_rpm: f64,
    ) -> Result<Self, PipelineError> {
        let top = machine.spindle.max_rpm;
        let controller = Controller { name: name.to_owned(), law };
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
            predictions: both,
        })
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
            rival.is_none_or(stiff),
        ]
    }

    /// Why this controller is not delivered in place of `other`; empty when it is. The controller that misses the later
    /// goal is the better one; of two that miss the same the stiffer one in no worse a zone, at a μ that is no worse.
    pub(super) fn objections(&self, other: &Self, machine: &Machine, rival: Option<[f64; 2]>) -> Vec<&'static str> {
        let (own, others) = (self.met(machine, rival), other.met(machine, rival));
        if let Some(goal) = (0..GOALS.len()).find(|k| own[*k] != others[*k]) {
            return if own[goal] { vec![] } else { vec![GOALS[goal]] };
        }
        let rank = |z: Option<Zone>| z.map_or(usize::MAX, |z| z as usize);
        let worse_zone = |k: usize| rank(self.zones[k]) > rank(other.zones[k]);
        let softer = |k: usize| {
            let now = self.stiffness_n_per_m[k];
            now.is_nan() || now <= other.stiffness_n_per_m[k]
        };
        let list = [
            (self.mu.is_nan() || self.mu > other.mu.max(1.0), "µ of the whole machine is larger"),
            (self.proven_to_rpm < other.proven_to_rpm, "stability is proven to a lower speed"),
            (worse_zone(0) || worse_zone(1), "its zone of ISO 14839-3 is worse"),
            (softer(0) || softer(1), "its tool is not stiffer both at rest and at top speed"),
        ];
        list.into_iter().filter_map(|(holds, words)| holds.then_some(words)).collect()
    }
}

/// What a delivered controller has to meet, the most important first, as words for one that misses it.
const GOALS: [&str; 5] = [
    "stability is not proven to 1.2 times the top speed",
    "the controller itself is unstable",
    "µ of the whole machine exceeds one",
    "its sensitivity exceeds zone B of ISO 14839-3",
    "its tool is softer than that of the tuned PID",
];
