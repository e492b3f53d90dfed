//! Uncertainty besides that of the natural frequencies: channels of the generalized plant for deviations of actuators,
//! sensors and the loop's delay from the model, one for each bearing.
//!
//! | key | block | reads | acts on |
//! |---|---|---|---|
//! | `actuator` | complex, multiplicative, rising over frequency | commanded current | current |
//! | `sensor` | complex, additive, over frequency | commanded current | signal |
//! | `force_constant` | k_i (1 + r δ) | commanded current | current |
//! | `negative_stiffness` | k_s (1 + r δ) | displacement at the actuator | force there |
//! | `delay_s` | complex, covers e^{−sτδ} − 1, \|δ\| ≤ 1 | commanded current | current |
//!
//! The cover of a delay: \|e^{−jx} − 1\| = 2 \|sin(x/2)\| ≤ x/√(1 + x²/12) for x = ωτ up to π, since
//! sin² y ≤ y²/(1 + y²/3) there.
//!
//! Each block is one by one and complex in synthesis and certificates, which covers a real parameter. For the
//! delivered controller μ is computed with k_i and k_s at the ends of their ranges as well, every one of them real.
//! A block's size is measured in the units of the specification (current limit, DC load and displacement), so that
//! constant scales start near one. The current that the specification limits is the commanded one.

use super::plane::{LOADS, LOOPS};
use super::shape::Shape;
use super::uncertainty::Block;
use super::weighting::WeightSection;
use super::weights::Weights;
use crate::linalg::{Mat, NumericError};

named! {
    /// What a channel stands for.
    pub(crate) enum ChannelKind {
        /// Relative error of an actuator.
        Actuator = "actuator",
        /// Additive error of a signal.
        Sensor = "sensor",
        /// Error of k_i.
        ForceConstant = "force constant",
        /// Error of k_s.
        NegativeStiffness = "negative stiffness",
        /// Error of the delay.
        Delay = "delay",
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ChannelWeight {
    Constant(f64),
    OverFrequency(Shape),
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Channel {
    pub kind: ChannelKind,
    /// 0 front, 1 rear.
    pub bearing: usize,
    /// On what the channel reads.
    pub output: ChannelWeight,
    /// On what it gives.
    pub input: f64,
}

/// The delay's cover at zero frequency, as a share of its value at high frequency: the numerator of a section has to be
/// positive there.
const DELAY_AT_REST: f64 = 1e-4;

/// The channels of a specification in the order of its problem: actuators, sensors, k_i, k_s, delay, each front and
/// rear.
pub(crate) fn channels(weights: &Weights) -> Result<Vec<Channel>, NumericError> {
    let uncertainty = &weights.uncertainty;
    let current = weights.current_limit_a;
    let places = [&weights.front, &weights.rear];
    let mut found = vec![];
    let mut both = |kind, output: [ChannelWeight; LOOPS], input: [f64; LOOPS]| {
        found.extend((0..LOOPS).map(|bearing| Channel {
            kind,
            bearing,
            output: output[bearing].clone(),
            input: input[bearing],
        }));
    };
    let over_frequency = |size: &Shape, unit: f64| ChannelWeight::OverFrequency(size.times(unit));
    if let Some(size) = &uncertainty.actuator {
        let weight = [0; LOOPS].map(|_| over_frequency(size, 1.0 / current));
        both(ChannelKind::Actuator, weight, [current; LOOPS]);
    }
    if let Some(size) = &uncertainty.sensor {
        let allowed = places.map(|p| p.max_dc_displacement_m);
        let weight = allowed.map(|a| over_frequency(size, 1.0 / a));
        both(ChannelKind::Sensor, weight, allowed);
    }
    if uncertainty.force_constant > 0.0 {
        let weight = [0; LOOPS].map(|_| ChannelWeight::Constant(uncertainty.force_constant / current));
        both(ChannelKind::ForceConstant, weight, [current; LOOPS]);
    }
    if uncertainty.negative_stiffness > 0.0 {
        let load = places.map(|p| p.max_dc_load_n);
        let ks_n_per_m = uncertainty.ks_n_per_m.ok_or(NumericError::NotFinite {
            what: "negative stiffness of the uncertainty (the weights have to be those on a machine)",
        })?;
        let weight = [0, 1].map(|k: usize| {
            let stiffness = uncertainty.negative_stiffness * ks_n_per_m[k];
            ChannelWeight::Constant(stiffness / load[k])
        });
        both(ChannelKind::NegativeStiffness, weight, load);
    }
    if uncertainty.delay_s > 0.0 {
        let (tau, high) = (uncertainty.delay_s, 12f64.sqrt());
        // τ s/(1 + τ s/√12), not quite zero at zero frequency.
        let cover = WeightSection { b0: DELAY_AT_REST * high, b1: tau, a0: 1.0, a1: tau / high };
        let cover = Shape::section(cover);
        let weight = [0; LOOPS].map(|_| over_frequency(&cover, 1.0 / current));
        both(ChannelKind::Delay, weight, [current; LOOPS]);
    }
    Ok(found)
}

/// Names of the channels of a specification, in their order; none for one whose levels are not positive.
pub(crate) fn channel_names(weights: &Weights) -> Vec<String> {
    let places = ["front", "rear"];
    let all = channels(weights).unwrap_or_default().into_iter();
    all.map(|c| format!("{}, {}", c.kind.name(), places[c.bearing])).collect()
}

/// The blocks of a problem: modes, channels, performance of `rows` × `cols`. Real parameters stand there as complex
/// ones, whose μ is not below theirs.
pub(crate) fn problem_blocks(modes: usize, channels: &[Channel], rows: usize, cols: usize) -> Vec<Block> {
    let mut blocks = vec![Block::ComplexScalar { n: 1 }; modes + channels.len()];
    blocks.push(Block::ComplexFull { rows, cols });
    blocks
}

/// Numbers of the channels of k_i and k_s, the real parameters, in a problem of so many uncertain modes.
pub(crate) fn real_channels(modes: usize, weights: &Weights) -> Result<Vec<usize>, NumericError> {
    let real = |c: &Channel| matches!(c.kind, ChannelKind::ForceConstant | ChannelKind::NegativeStiffness);
    let all = channels(weights)?.into_iter().enumerate();
    Ok(all.filter(|(_, c)| real(c)).map(|(k, _)| modes + k).collect())
}

/// How channels are wired into a plane that shows its errors: rows (q of the modes, displacements at tool, front, rear,
/// currents front, rear, others), columns (v of the modes, loads at tool, front, rear, noise front, rear, currents
/// front, rear). Rows and columns of channels come after those of the modes.
pub(crate) struct Wiring {
    /// Row and column of the plane that each row and column of the wired one copies.
    pub rows: Vec<usize>,
    pub columns: Vec<usize>,
    /// Columns of the channels.
    injected: std::ops::Range<usize>,
    /// Rows of the plane with commanded currents.
    currents: std::ops::Range<usize>,
}

impl Wiring {
    /// For a plane of so many modal ports and rows.
    pub(crate) fn new(modes: usize, rows: usize, channels: &[Channel]) -> Self {
        let (displacement, current) = (modes + 1, modes + LOADS);
        let reads = |c: &Channel| match c.kind {
            ChannelKind::NegativeStiffness => displacement + c.bearing,
            _ => current + c.bearing,
        };
        let (force, noise, drive) = (modes + 1, modes + LOADS, modes + LOADS + LOOPS);
        let acts_on = |c: &Channel| match c.kind {
            ChannelKind::NegativeStiffness => force + c.bearing,
            ChannelKind::Sensor => noise + c.bearing,
            _ => drive + c.bearing,
        };
        let wired = |own: &dyn Fn(&Channel) -> usize, count: usize| {
            (0..modes).chain(channels.iter().map(own)).chain(modes..count).collect()
        };
        Self {
            rows: wired(&reads, rows),
            columns: wired(&acts_on, drive + LOOPS),
            injected: modes..modes + channels.len(),
            currents: current..current + LOOPS,
        }
    }

    /// The wired matrix of the entries of the plane; the commanded current does not see what a channel adds to it.
    pub(crate) fn matrix<T: Clone>(&self, zero: &T, at: impl Fn(usize, usize) -> T) -> Mat<T> {
        Mat::from_fn(self.rows.len(), self.columns.len(), |i, j| {
            let (row, column) = (self.rows[i], self.columns[j]);
            if self.injected.contains(&j) && self.currents.contains(&row) { zero.clone() } else { at(row, column) }
        })
    }
}
