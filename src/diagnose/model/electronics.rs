//! Amplifiers, delay, eddy currents and sensors of a hypothesis, with the derivatives of F to the numbers of effects on them.
//!
//! F = A H M, with a 2×2 block of A for the sensors and one of M for the currents of each bearing:  dF = (dA A⁻¹) F + F (M⁻¹dM), and of these
//! factors all but those of crossed currents and turned axes are numbers.

use super::sensitivity::Number;
use super::{Line, Receptance, SIDE, Square, ZERO};
use crate::diagnose::chain::Chain;
use crate::linalg::c64;
use crate::spindle::Effective;
use crate::spindle::effects::entry::Domain;
use crate::spindle::plant::LOWPASS_DAMPING;
use crate::spindle::{Effect, EffectKind, Location, Machine};
use std::f64::consts::TAU;

/// What stands round the shaft.
#[derive(Clone, Debug)]
pub struct Electronics {
    pub(super) effective: Effective,
    sensor_bandwidth_hz: f64,
}

/// The first number of an effect on the electronics, times a factor: what is differentiated to.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    kind: EffectKind,
    value: f64,
    /// Bearings at which no later effect of the kind takes its place.
    bearings: [bool; 2],
    pub(super) factor: f64,
}

impl Change {
    /// Of the effect at `index` of all that are assembled; none when that works elsewhere.
    pub(super) fn new(effects: &[Effect], index: usize) -> Option<Self> {
        let effect = effects.get(index).filter(|e| Electronics::have(e.kind))?;
        let on = |e: &Effect, b: usize| match e.location {
            Location::Bearing(which) => which.includes(b),
            _ => true,
        };
        let replaces = effect.kind.entry().replaces;
        let later = |b: usize| {
            let mut others = effects[index + 1..].iter();
            replaces && others.any(|e| e.kind == effect.kind && on(e, b))
        };
        Some(Self {
            kind: effect.kind,
            value: effect.values.first().copied()?,
            bearings: [0, 1].map(|b| on(effect, b) && !later(b)),
            factor: 1.0,
        })
    }
}

impl Electronics {
    pub(super) fn new(machine: &Machine) -> Self {
        Self {
            effective: machine.effective(),
            sensor_bandwidth_hz: machine.spindle.electronics.sensor_bandwidth_hz,
        }
    }

    /// Whether effects of a kind are here, so that they leave the receptance of the shaft as it is.
    pub fn have(kind: EffectKind) -> bool {
        kind.entry().domain == Domain::Electronics
    }

    /// At a line.
    pub fn chain(&self, omega_rad_s: f64) -> Chain {
        Chain::new(&self.effective, self.sensor_bandwidth_hz, omega_rad_s)
    }

    /// A line of these electronics round a shaft that is known, with derivatives to `numbers` of theirs; those of the shaft's are zero.
    pub fn line(&self, receptance: &Receptance, omega_rad_s: f64, numbers: &[Number]) -> Line {
        let chain = self.chain(omega_rad_s);
        let response = chain.apply(&receptance.plus, receptance.minus.as_ref());
        let own = |number: &Number| match number {
            Number::Electronics(change) => self.slope(change, &response, omega_rad_s),
            Number::Shaft(_) => [ZERO; SIDE * SIDE],
        };
        Line {
            receptance: *receptance,
            derivatives: numbers.iter().map(own).collect(),
            response,
        }
    }

    /// ∂F of a response F at a line.
    pub(super) fn slope(&self, change: &Change, f: &Square, omega_rad_s: f64) -> Square {
        let s = c64::new(0.0, omega_rad_s);
        let mut all = [ZERO; SIDE * SIDE];
        for b in (0..2).filter(|b| change.bearings[*b]) {
            let value = change.value;
            let corner = s / (TAU * value);
            // On the currents, [own, cross], or on the signals.
            let (currents, own, cross) = match change.kind {
                EffectKind::LoopDelay => (true, -s, ZERO),
                EffectKind::AmplifierBandwidth => (true, corner / value / (corner + 1.0), ZERO),
                EffectKind::EddyCurrents => {
                    let root = corner.sqrt();
                    (true, root * 0.5 / value / (root + 1.0), ZERO)
                }
                EffectKind::ForceConstant => (true, c64::new(value.recip(), 0.0), ZERO),
                EffectKind::BearingCoupling => {
                    let ratio = self.effective.bearings[b].coupling_ratio;
                    let scale = (1.0 - ratio * ratio).recip();
                    (true, c64::new(-ratio * scale, 0.0), c64::new(scale, 0.0))
                }
                EffectKind::SensorGain => (false, c64::new(value.recip(), 0.0), ZERO),
                EffectKind::SensorLowpass => {
                    let damped = corner * (2.0 * LOWPASS_DAMPING);
                    let square = corner * corner;
                    let slope = (damped + square * 2.0) / value / (damped + square + 1.0);
                    (false, slope, ZERO)
                }
                EffectKind::AxisMisalignment => (false, ZERO, c64::new(1f64.to_radians(), 0.0)),
                _ => continue,
            };
            let (x, y) = (2 * b, 2 * b + 1);
            for n in 0..SIDE {
                if currents {
                    all[n * SIDE + x] += own * f[n * SIDE + x] + cross * f[n * SIDE + y];
                    all[n * SIDE + y] += own * f[n * SIDE + y] + cross * f[n * SIDE + x];
                } else {
                    all[x * SIDE + n] += own * f[x * SIDE + n] + cross * f[y * SIDE + n];
                    all[y * SIDE + n] += own * f[y * SIDE + n] - cross * f[x * SIDE + n];
                }
            }
        }
        all.map(|entry| entry * change.factor)
    }
}
