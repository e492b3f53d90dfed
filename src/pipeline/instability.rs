//! Where a delivered loop is unstable, and the mode behind it.

use super::PipelineError;
use super::delivery::Delivery;
use super::loop_stability::{loop_poles, unstable_words};
use super::problems::Problems;
use crate::augment::assembly::UncertainMode;
use crate::augment::plane::isotropic;
use crate::augment::split::gyroscopic_split;
use crate::controller::Controller;
use crate::controller::speed_proof::SpeedProof;
use crate::controller::verification::{SpeedCheck, Verification};
use crate::spindle::{Machine, ModelDetail, Plant, SpindleError};
use std::f64::consts::TAU;

/// The speed at which a loop grows fastest, of those computed from rest to the overspeed.
#[derive(Clone, Debug, PartialEq)]
pub struct Instability {
    /// Largest growth rate there, 1/s.
    pub growth_rate_per_s: f64,
    /// The speed, rpm.
    pub speed_rpm: f64,
    /// Frequency of the mode that grows, Hz.
    pub frequency_hz: f64,
    /// The motion of the free rotor behind it.
    pub mode: GrowingMode,
}

/// The motion of the free rotor next to what grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GrowingMode {
    /// A flexible mode that whirls backward and forward.
    Flexible(SplitMode),
    /// The forward conical whirl of the rigid rotor, Ω·Ip/Id, which has no frequency at rest.
    Nutation {
        /// Of the free rotor at the speed where the loop is worst, Hz.
        free_hz: f64,
    },
    /// The rigid rotor on its magnets, slower than its nutation.
    RigidBody,
}

/// A flexible mode of the free rotor with its gyroscopic split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplitMode {
    /// Number from one.
    pub number: usize,
    /// At rest, Hz.
    pub at_rest_hz: f64,
    /// Backward and forward whirl at the speed where the loop is worst, Hz.
    pub at_speed_hz: [f64; 2],
    /// Shift of its frequency that the synthesis covered, relative.
    pub covered: f64,
}

impl Instability {
    /// Of a delivery; none where every speed computed is stable.
    pub(super) fn of(
        machine: &Machine,
        problems: &Problems,
        delivery: &Delivery,
    ) -> Result<Option<Self>, PipelineError> {
        let checks = delivery.verification.speeds.iter().chain(&delivery.overspeed.speeds).copied();
        let checks = checks.chain(centres(&delivery.speed_proof));
        let covered = (problems.split.len(), problems.covered_modes.as_slice());
        Self::worst(machine, &delivery.controller, checks, covered)
    }

    /// Of a verified controller that no synthesis made.
    pub(super) fn of_verified(
        machine: &Machine,
        controller: &Controller,
        verification: &Verification,
    ) -> Result<Option<Self>, PipelineError> {
        let checks = verification.speeds.iter().copied();
        let checks = checks.chain(verification.proof.iter().flat_map(centres));
        Self::worst(machine, controller, checks, (machine.spindle.flexible_modes, &[]))
    }

    /// The speed of fastest growth, next to so many flexible modes, some of them covered.
    fn worst(
        machine: &Machine,
        controller: &Controller,
        checks: impl Iterator<Item = SpeedCheck>,
        covered: (usize, &[UncertainMode]),
    ) -> Result<Option<Self>, PipelineError> {
        let growing = checks.filter(|at| at.growth_rate_per_s.is_nan() || at.growth_rate_per_s >= 0.0);
        let worst = growing.max_by(|a, b| a.growth_rate_per_s.total_cmp(&b.growth_rate_per_s));
        let Some(SpeedCheck { speed_rpm, growth_rate_per_s }) = worst else { return Ok(None) };
        let plant = Plant::new(machine, speed_rpm * TAU / 60.0, ModelDetail::Full)?;
        let poles = loop_poles(&plant, controller)?.poles_rad_s;
        let fastest = poles.iter().max_by(|a, b| a.re.total_cmp(&b.re));
        let frequency_hz = fastest.map_or(0.0, |pole| pole.im.abs() / TAU);
        let mode = GrowingMode::near(machine, covered, frequency_hz, speed_rpm)?;
        Ok(Some(Self { growth_rate_per_s, speed_rpm, frequency_hz, mode }))
    }

    /// That the loop is unstable, and where.
    pub(crate) fn first_words(&self) -> String {
        unstable_words(self.growth_rate_per_s, self.speed_rpm)
    }

    /// That the loop is unstable, where, which mode is behind it, and what the synthesis covered of that, in two
    /// sentences.
    pub(crate) fn words(&self) -> String {
        let covered = match &self.mode {
            GrowingMode::Flexible(mode) => {
                format!(", and the synthesis covered a shift of {:.1} % of it", 100.0 * mode.covered)
            }
            GrowingMode::Nutation { .. } => "; the synthesis at rest covered nothing of it".to_owned(),
            GrowingMode::RigidBody => "; the synthesis at rest covered no gyroscopics of it".to_owned(),
        };
        format!("{}{covered}.", self.mode_words())
    }

    /// That the loop is unstable, where, and which mode is behind it, in two sentences without the last stop.
    pub(crate) fn mode_words(&self) -> String {
        let (first, at) = (self.first_words(), format!("at {:.0} rpm", self.speed_rpm));
        let cause = match &self.mode {
            GrowingMode::Flexible(mode) => {
                let [backward, forward] = mode.at_speed_hz;
                let own = format!("; flexible mode {} next to it has {:.1} Hz at rest", mode.number, mode.at_rest_hz);
                if self.speed_rpm == 0.0 {
                    own
                } else {
                    format!("{own} and splits to {backward:.1} and {forward:.1} Hz {at}")
                }
            }
            GrowingMode::Nutation { free_hz } => format!(
                ": the nutation of the rigid rotor, which has no frequency at rest and that of {free_hz:.1} Hz {at} \
                 when free"
            ),
            GrowingMode::RigidBody => ": a motion of the rigid rotor on its magnets".to_owned(),
        };
        format!("{first}. What grows has {:.1} Hz{cause}", self.frequency_hz)
    }
}

/// The speeds of a proof.
fn centres(proof: &SpeedProof) -> impl Iterator<Item = SpeedCheck> {
    let each = proof.intervals.iter();
    each.map(|at| SpeedCheck { speed_rpm: at.centre_rpm, growth_rate_per_s: at.growth_rate_per_s })
}

impl GrowingMode {
    /// The motion of the free rotor next to a frequency in Hz at a speed in rpm.
    fn near(
        machine: &Machine,
        (modes, covered): (usize, &[UncertainMode]),
        frequency_hz: f64,
        speed_rpm: f64,
    ) -> Result<Self, SpindleError> {
        let machine = isotropic(machine);
        let speed_rad_s = speed_rpm * TAU / 60.0;
        let split = gyroscopic_split(&machine, speed_rad_s, modes)?;
        let modes = split.iter().enumerate().map(|(k, split)| SplitMode {
            number: k + 1,
            at_rest_hz: split.omega_rad_s / TAU,
            at_speed_hz: [split.backward_rad_s / TAU, split.forward_rad_s / TAU],
            covered: covered.iter().find(|own| own.number == k).map_or(0.0, |own| own.relative),
        });
        let nearest = modes.min_by(|a, b| a.apart_from(frequency_hz).total_cmp(&b.apart_from(frequency_hz)));
        let first_hz = split.first().map_or(f64::INFINITY, |own| own.backward_rad_s.min(own.omega_rad_s) / TAU);
        let below = machine.whirl(speed_rad_s, first_hz.min(machine.spindle.electronics.sample_rate_hz))?;
        let forward = below.modes.iter().filter(|mode| mode.whirl > 0.0 && mode.natural_rad_s < TAU * first_hz);
        let nutation_hz = forward.map(|mode| mode.natural_rad_s / TAU).fold(0.0, f64::max);
        Ok(match nearest {
            // Magnets move a frequency by less than half the way, in octaves, to its neighbour.
            Some(mode)
                if frequency_hz * frequency_hz >= first_hz * nutation_hz && mode.apart_from(frequency_hz) < 1.0 =>
            {
                Self::Flexible(mode)
            }
            _ if nutation_hz > 0.0 && frequency_hz > 0.5 * nutation_hz => Self::Nutation { free_hz: nutation_hz },
            _ => Self::RigidBody,
        })
    }
}

impl SplitMode {
    /// Distance of a frequency from the range between both whirls, in octaves.
    fn apart_from(&self, frequency_hz: f64) -> f64 {
        let [backward, forward] = self.at_speed_hz;
        let (low, high) = (backward.min(self.at_rest_hz), forward.max(self.at_rest_hz));
        let nearest = frequency_hz.clamp(low, high);
        (nearest / frequency_hz.max(f64::MIN_POSITIVE)).log2().abs()
    }
}
