//! Derivatives of a response to the numbers of effects on amplifiers, delay, eddy currents and sensors.
//!
//! F = A H M, with a 2×2 block of A for the sensors and one of M for the currents of each bearing:  dF = (dA A⁻¹) F + F
//! (M⁻¹dM), and of these factors all but those of crossed currents and turned axes are numbers.

use super::channels::{SIDE, Square, ZERO};
use super::electronics::{LOWPASS_DAMPING, actuator, add_pickup, lowpass, mix, pickup};
use crate::linalg::c64;
use crate::linalg::small::eliminate;
use crate::spindle::effects::entry::Domain;
use crate::spindle::{Effect, EffectKind, Effective, Location};
use std::f64::consts::TAU;

/// A number of an effect on the electronics, times a factor: what is differentiated to.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    kind: EffectKind,
    /// The numbers of the effect, and which of them is meant.
    values: Vec<f64>,
    number: usize,
    /// Axes at which no later effect of the kind takes its place.
    axes: [bool; 4],
    /// The axis that is seen and the one that sees it, of a signal in another or a current in a signal.
    across: Option<[usize; 2]>,
    /// Factor on the derivative.
    pub factor: f64,
}

impl Change {
    /// That of a number of the effect at `index` of all that are assembled; none when that works elsewhere.
    pub fn new(effects: &[Effect], index: usize, number: usize) -> Option<Self> {
        let effect = effects.get(index).filter(|e| on_electronics(e.kind))?;
        let on = |e: &Effect, axis: usize| match e.location {
            Location::Bearing(which) => which.includes(axis / 2),
            Location::Axis(one) => one == axis,
            _ => true,
        };
        let replaces = effect.kind.entry().replaces;
        let later = |axis: usize| {
            let mut others = effects[index + 1..].iter();
            replaces && others.any(|e| takes_the_place(e.kind, effect.kind) && on(e, axis))
        };
        Some(Self {
            kind: effect.kind,
            values: effect.values.clone(),
            number,
            axes: [0, 1, 2, 3].map(|axis| on(effect, axis) && !later(axis)),
            across: match effect.location {
                Location::Across { from, to } => Some([from, to]),
                _ => None,
            },
            factor: 1.0,
        })
    }

    /// ∂F of a response F of a machine at a line.
    pub(crate) fn slope(&self, machine: &Effective, f: &Square, omega_rad_s: f64) -> Square {
        let (shares, is_mixed) = (&machine.crosstalk, machine.has_crosstalk());
        let s = c64::new(0.0, omega_rad_s);
        let mut before = *f;
        let picked_up = machine.has_pickup().then(|| pickup(machine, s));
        if let Some(picked_up) = &picked_up {
            add_pickup(&mut before, picked_up, SIDE, -1.0);
        }
        if is_mixed {
            before = unmix(&before, shares);
        }
        let mut all = [ZERO; SIDE * SIDE];
        match (self.kind, self.across) {
            (EffectKind::CurrentPickup, Some([from, to])) => {
                let mut one = machine.clone();
                one.current_pickup = [[0.0; 4]; 4];
                one.current_pickup[to][from] = self.factor;
                add_pickup(&mut all, &pickup(&one, s), SIDE, 1.0);
                return all;
            }
            (_, Some([from, to])) => {
                let seen = &before[from * SIDE..(from + 1) * SIDE];
                all[to * SIDE..(to + 1) * SIDE].iter_mut().zip(seen).for_each(|(d, seen)| *d = seen * self.factor);
                return all;
            }
            _ => {}
        }
        all = self.slope_before_crosstalk(machine, &before, s);
        if is_mixed {
            mix(&mut all, shares, SIDE);
        }
        if let (Some(mut picked_up), Some(lag)) = (picked_up, self.lag_slope(s)) {
            let own = |k: usize| if self.axes[k % 4] { lag * self.factor } else { ZERO };
            picked_up.iter_mut().enumerate().for_each(|(k, entry)| *entry *= own(k));
            add_pickup(&mut all, &picked_up, SIDE, 1.0);
        }
        all
    }

    /// Derivative of the logarithm of the coil current; none of numbers behind it.
    fn lag_slope(&self, s: c64) -> Option<c64> {
        let value = self.values[self.number];
        Some(match self.kind {
            EffectKind::LoopDelay => -s,
            EffectKind::AmplifierBandwidth => {
                let corner = s / (TAU * value);
                corner / value / (corner + 1.0)
            }
            EffectKind::AmplifierSecondOrder => {
                let (frequency_hz, damping_ratio) = (self.values[0], self.values[1]);
                let q = s / (TAU * frequency_hz);
                let (damped, square) = (q * (2.0 * damping_ratio), q * q);
                let own =
                    if self.number == 0 { (damped + square * 2.0) / frequency_hz } else { damped / -damping_ratio };
                own / (damped + square + 1.0)
            }
            _ => return None,
        })
    }

    /// The same of a response before the signals mix.
    fn slope_before_crosstalk(&self, machine: &Effective, f: &Square, s: c64) -> Square {
        let mut all = [ZERO; SIDE * SIDE];
        let value = self.values[self.number];
        for b in (0..2).filter(|b| self.axes[2 * b] || self.axes[2 * b + 1]) {
            let corner = s / (TAU * value);
            // On the currents, [own, cross], or on the signals.
            let (currents, own, cross) = match self.kind {
                EffectKind::LoopDelay | EffectKind::AmplifierBandwidth | EffectKind::AmplifierSecondOrder => {
                    (true, self.lag_slope(s).unwrap_or(ZERO), ZERO)
                }
                EffectKind::EddyCurrents => {
                    let root = corner.sqrt();
                    (true, root * 0.5 / value / (root + 1.0), ZERO)
                }
                EffectKind::LaminatedCore => {
                    // d ln(tanh x/x) = (2/sinh 2x − 1/x) dx with x² = s/ω_l; by parts of e⁻²ˣ, which do not overflow.
                    let x = corner.sqrt();
                    let decayed = (x * -2.0).exp();
                    let ratio = x * 4.0 * decayed / (c64::new(1.0, 0.0) - decayed * decayed);
                    let by_corner = if x.norm() < 1e-3 { corner * (2.0 / 3.0) } else { c64::new(1.0, 0.0) - ratio };
                    (true, by_corner * 0.5 / value, ZERO)
                }
                EffectKind::ForceConstant => (true, c64::new(value.recip(), 0.0), ZERO),
                EffectKind::BearingCoupling => {
                    let ratio = machine.bearings[b].coupling_ratio;
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
            // What the axes have of their own stands outside of what couples them.
            let [axis_x, axis_y] = &machine.bearings[b].axes;
            let [to_x, to_y] = if currents {
                [axis_x, axis_y].map(|axis| actuator(axis, s) * axis.force_factor)
            } else {
                [axis_y, axis_x].map(|axis| lowpass(axis, s) * axis.signal_factor)
            };
            let (cross_x, cross_y) = (cross * (to_x / to_y), cross * (to_y / to_x));
            for n in 0..SIDE {
                if currents {
                    let (at_x, at_y) = (n * SIDE + x, n * SIDE + y);
                    if self.axes[x] {
                        all[at_x] += own * f[at_x] + cross_x * f[at_y];
                    }
                    if self.axes[y] {
                        all[at_y] += own * f[at_y] + cross_y * f[at_x];
                    }
                } else {
                    let (at_x, at_y) = (x * SIDE + n, y * SIDE + n);
                    if self.axes[x] {
                        all[at_x] += own * f[at_x] + cross_y * f[at_y];
                    }
                    if self.axes[y] {
                        all[at_y] += own * f[at_y] - cross_x * f[at_x];
                    }
                }
            }
        }
        all.map(|entry| entry * self.factor)
    }
}

/// Whether an effect of a kind takes the place of an earlier one of another.
fn takes_the_place(later: EffectKind, earlier: EffectKind) -> bool {
    let amplifier = |kind| matches!(kind, EffectKind::AmplifierBandwidth | EffectKind::AmplifierSecondOrder);
    later == earlier || amplifier(later) && amplifier(earlier)
}

/// The response before its signals, the first four rows, had these shares of each other.
fn unmix(f: &Square, shares: &[[f64; 4]; 4]) -> Square {
    let own = |i: usize, j: usize| shares[i][j] + f64::from(u8::from(i == j));
    let mut unit: Vec<c64> = (0..16).map(|k| c64::new(own(k / 4, k % 4), 0.0)).collect();
    let mut before = *f;
    eliminate(&mut unit, &mut before[..4 * SIDE], 4, SIDE);
    before
}

/// Whether effects of a kind leave the receptance of the shaft as it is.
pub(crate) fn on_electronics(kind: EffectKind) -> bool {
    kind.entry().domain == Domain::Electronics
}
