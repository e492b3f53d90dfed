//! Stability at every speed of a range, not at samples of it: intervals that overlap, each proven by a small gain.
//!
//! The poles of the sampled loop are computed at the centre of an interval; [`super::speed_lift`] bounds how far the
//! speed may deviate from it. Gaps are divided again until the range is covered up to the lowest unstable centre, or
//! intervals get shorter than `SHORTEST_RPM`.
//!
//! What is proven: the loop of the full plant (modes to six times the end of a sweep and pseudo-modes for the rest,
//! exact delay and hold, magnets linear) with the coefficients as rounded is stable at every constant speed of the
//! covered range, and also while the speed wanders inside one interval, as far as the gyroscopic moment Ω G ẋ is
//! concerned. Not covered: nonlinearity, and deviations of the plant, for which there is μ.

use super::ControllerError;
use super::speed_lift::AffinePlant;
use super::verification_error::VerificationError;
use crate::lti::{Discrete, StateSpace};
use crate::spindle::{Machine, ModelDetail, Plant};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Intervals shorter than this are not divided further: the loop is on the edge of stability there.
const SHORTEST_RPM: f64 = 5.0;
/// Pieces with an unstable centre are divided down to this share of the range only: the edge is all there is to find.
const UNSTABLE_SHARE: f64 = 4e-3;
/// Evenly spaced centres to begin with.
const FIRST: usize = 8;
/// Distance proven from a centre over half the width of its piece.
const OVERLAP: f64 = 1.01;
/// Share of the advised distance that is asked for: the gain met is a lower bound of the largest.
const ADVISED: f64 = 0.9;
/// A piece is divided into at most so many at once.
const PARTS: f64 = 8.0;
/// Centres in all: ten times what lightly damped loops take.
const CENTRES: usize = 400;

/// A speed at which the loop was computed, with the interval proven from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedInterval {
    /// Speed at which the loop was computed, rpm.
    pub centre_rpm: f64,
    /// Stable for |speed − centre| up to this, rpm; zero when nothing was proven from here.
    pub radius_rpm: f64,
    /// Growth rate at the centre, 1/s.
    pub growth_rate_per_s: f64,
}

/// A range of speeds with its proof.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedProof {
    /// The range is zero to this, rpm.
    pub to_rpm: f64,
    /// Every centre at which the loop was computed, by speed, with what it proves.
    pub intervals: Vec<SpeedInterval>,
    /// Pieces of the range that no interval covers, rpm; above the lowest unstable speed some were not asked.
    pub open_rpm: Vec<[f64; 2]>,
}

impl SpeedProof {
    /// True when every speed of the range is covered.
    pub fn is_complete(&self) -> bool {
        self.open_rpm.is_empty() && !self.intervals.is_empty()
    }

    /// The largest speed up to which everything is covered, rpm; zero when rest itself is not.
    pub fn proven_to_rpm(&self) -> f64 {
        self.open_rpm.iter().map(|piece| piece[0]).fold(self.to_rpm, f64::min)
    }

    /// True when every speed from rest to `rpm` is covered.
    pub(crate) fn covers(&self, rpm: f64) -> bool {
        // The ends of the pieces are sums of decimals: only their rounding is forgiven.
        !self.intervals.is_empty() && self.proven_to_rpm() * (1.0 + 1e-12) >= rpm
    }

    /// The intervals that are proven.
    pub fn proven_intervals(&self) -> impl Iterator<Item = &SpeedInterval> {
        self.intervals.iter().filter(|i| i.radius_rpm > 0.0)
    }

    pub(crate) fn narrowest(&self) -> Option<&SpeedInterval> {
        self.proven_intervals().min_by(|a, b| a.radius_rpm.total_cmp(&b.radius_rpm))
    }

    /// The least damped centre.
    pub(crate) fn slowest(&self) -> Option<&SpeedInterval> {
        self.intervals.iter().max_by(|a, b| a.growth_rate_per_s.total_cmp(&b.growth_rate_per_s))
    }
}

/// Proves stability of the sampled loop of the full plant from rest to `to_rpm`.
///
/// # Errors
/// [`VerificationError`] when the plant cannot be built or a computation fails; an unstable loop is an open piece, no
/// error.
pub fn prove(
    machine: &Machine,
    controller: &StateSpace<Discrete>,
    to_rpm: f64,
) -> Result<SpeedProof, VerificationError> {
    let top = to_rpm * TAU / 60.0;
    let build = |speed: f64| Plant::new(machine, speed, ModelDetail::Full);
    let rest = build(0.0)?;
    let period_s = rest.sample_period_s();
    // The hold is part of the total delay.
    let delay_s = (rest.delay_s() - 0.5 * period_s).max(0.0);
    let plant = AffinePlant::new(
        &rest,
        [rest.state_space(0)?, build(0.5 * top)?.state_space(0)?, build(top)?.state_space(0)?],
        top,
        delay_s,
        period_s,
    )?;
    let mut intervals: Vec<SpeedInterval> = vec![];
    let mut pieces = divide_interval([0.0, to_rpm], to_rpm / (2.0 * FIRST as f64));
    let mut open = vec![];
    while !pieces.is_empty() {
        let found: Result<Vec<_>, ControllerError> = pieces
            .par_iter()
            .map(|[low, high]| {
                let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
                let scale = TAU / 60.0;
                plant.neighbourhood(controller, centre * scale, OVERLAP * half * scale)
            })
            .collect();
        let mut next = vec![];
        for (at, piece) in found?.into_iter().zip(&pieces) {
            let half = 0.5 * (piece[1] - piece[0]);
            intervals.push(SpeedInterval {
                centre_rpm: piece[0] + half,
                radius_rpm: if at.proven { OVERLAP * half } else { 0.0 },
                growth_rate_per_s: at.growth_rate_per_s,
            });
            if at.proven {
                continue;
            }
            // A loop that is stable at the centre is asked again from more centres, at a distance it may grant.
            let granted = ADVISED * at.advised_rad_s * 60.0 / TAU;
            let spent = intervals.len() + next.len() >= CENTRES;
            let shortest = if at.growth_rate_per_s < 0.0 { SHORTEST_RPM } else { UNSTABLE_SHARE * to_rpm };
            if spent || 2.0 * half < shortest {
                open.push(*piece);
            } else {
                // An unstable centre is no place to ask from: the piece is halved.
                let radius = if granted > 0.0 { granted } else { 0.5 * half };
                next.extend(divide_interval(*piece, radius.clamp(half / PARTS, 0.5 * half)));
            }
        }
        // What is proven ends at the lowest unstable speed: nothing above it is asked.
        let lost =
            intervals.iter().filter(|i| i.growth_rate_per_s >= 0.0).map(|i| i.centre_rpm).fold(f64::INFINITY, f64::min);
        let (below, above): (Vec<_>, Vec<_>) = next.into_iter().partition(|piece| piece[0] < lost);
        pieces = below;
        open.extend(above);
    }
    intervals.sort_by(|a, b| a.centre_rpm.total_cmp(&b.centre_rpm));
    Ok(SpeedProof { to_rpm, open_rpm: join_intervals(open), intervals })
}

/// Equal parts of a piece, none longer than twice `radius`.
fn divide_interval(piece: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    let width = piece[1] - piece[0];
    let count = (width / (2.0 * radius)).ceil().clamp(1.0, CENTRES as f64) as usize;
    let edge = |k: usize| piece[0] + width * k as f64 / count as f64;
    (0..count).map(|k| [edge(k), edge(k + 1)]).collect()
}

/// Open pieces in order, those that touch made one.
fn join_intervals(mut open: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    open.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut all: Vec<[f64; 2]> = vec![];
    for piece in open {
        match all.last_mut() {
            Some(last) if piece[0] - last[1] < SHORTEST_RPM => last[1] = piece[1].max(last[1]),
            _ => all.push(piece),
        }
    }
    all
}
