//! Resonances and antiresonances of the free-free rotor from a measured open-loop plant.
//!
//! G = Y U⁻¹ removes the levitation loop. Amplifier, delay and sensor are scalar factors of a channel: they move
//! neither its poles nor its zeros of bending, and those known are divided out so that residues keep their sign. What
//! is left is the rotor on the negative stiffness of its magnets; the shift between that and the free-free rotor, f(ks
//! = 0) − f(ks), is taken from the finite-element model of the given machine and added: the ratio of the two
//! frequencies of a mode hardly depends on the moduli, so that a nominal model serves. A tenth of the shift is added to
//! the standard deviation.
//! The two control axes of a plane see the same rotor at rest: poles are fitted to both together, zeros averaged.

use super::IdentifyError;
use super::frf::{AXES, MeasuredFrf};
use super::line_noise::noise_of_lines;
use super::peaks::{Antiresonance, Channel, Resonance, antiresonances, poly_reference};
use crate::linalg::{Mat, c64, solve_complex};
use crate::rotor::chain::{Chain, ChainPort};
use crate::rotor::chain_assembly;
use crate::rotor::spectrum::{ModalSpectrum, Query, lowest_hz, spectrum};
use crate::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::TAU;

/// Entries are not believed beyond this relative standard deviation, however well the repeats agree.
const ENTRY_FLOOR: f64 = 5e-4;
/// Share of the model's shift that counts as uncertain: ks is known to some 5–10 %.
const SHIFT_UNCERTAINTY: f64 = 0.1;
/// Front and rear actuator.
const INPUTS: usize = 2;
/// A peak of the model belongs to a measured one when it lies within this factor: nominal models are 10–30 % off.
const SAME_PEAK: f64 = 1.35;

/// A frequency of the free-free rotor with its standard deviation, or the reason why there is none.
#[derive(Clone, Debug, PartialEq)]
pub enum Reading {
    /// Identified.
    Found {
        /// Frequency of the free-free rotor, Hz.
        frequency_hz: f64,
        /// Standard deviation, Hz.
        standard_deviation_hz: f64,
        /// What the magnets' stiffness had shifted it by, removed, Hz.
        magnet_shift_hz: f64,
    },
    /// Exists, but cannot be identified.
    NotIdentified {
        /// Why.
        reason: String,
    },
}

impl Reading {
    /// Frequency, Hz.
    pub fn frequency_hz(&self) -> Option<f64> {
        match self {
            Self::Found { frequency_hz, .. } => Some(*frequency_hz),
            Self::NotIdentified { .. } => None,
        }
    }

    /// Standard deviation, Hz.
    pub fn standard_deviation_hz(&self) -> Option<f64> {
        match self {
            Self::Found { standard_deviation_hz, .. } => Some(*standard_deviation_hz),
            Self::NotIdentified { .. } => None,
        }
    }
}

/// Peaks of the free-free rotor.
#[derive(Clone, Debug, PartialEq)]
pub struct Identification {
    /// Flexible resonances, ascending.
    pub resonances: Vec<Reading>,
    /// Damping ratio of each resonance, of the free-free rotor as the frequencies are.
    pub damping_ratio: Vec<f64>,
    /// What the magnets' stiffness had changed it by, removed.
    pub damping_shift: Vec<f64>,
    /// Standard deviation of each damping ratio.
    pub damping_standard_deviation: Vec<f64>,
    /// Antiresonances of front sensor over front actuator, ascending.
    pub front: Vec<Reading>,
    /// Antiresonances of rear sensor over rear actuator, ascending.
    pub rear: Vec<Reading>,
    /// Antiresonances of front sensor over rear actuator, ascending.
    pub front_over_rear: Vec<Reading>,
    /// Antiresonances of rear sensor over front actuator, ascending.
    pub rear_over_front: Vec<Reading>,
}

impl Identification {
    /// Poles of the measured rotor on its magnets, on the frequency axis, Hz.
    pub(super) fn measured_poles_hz(&self) -> Vec<c64> {
        let damping = self.damping_ratio.iter().zip(&self.damping_shift).map(|(free, shift)| free - shift);
        let each = self.resonances.iter().zip(damping);
        each.filter_map(|(reading, z)| match reading {
            Reading::Found { frequency_hz, magnet_shift_hz, .. } => {
                Some(c64::new((1.0 - z * z).sqrt(), z) * (frequency_hz - magnet_shift_hz))
            }
            Reading::NotIdentified { .. } => None,
        })
        .collect()
    }
}

/// Identifies resonances and antiresonances of a standstill sweep.
///
/// # Errors
/// [`IdentifyError::NotAtRest`] for a sweep at speed, where whirl splits every peak; [`IdentifyError::NoResonance`]
/// when no resonance stands out; [`IdentifyError::Machine`] when the machine has no model.
pub fn identify(frf: &MeasuredFrf, machine: &Machine) -> Result<Identification, IdentifyError> {
    if frf.speed_rpm != 0.0 {
        return Err(IdentifyError::NotAtRest { speed_rpm: frf.speed_rpm });
    }
    let channels = channels_of(frf, machine);
    let (poles, _) = poly_reference(&frf.frequency_hz, &channels, INPUTS);
    if poles.is_empty() {
        return Err(IdentifyError::NoResonance {
            from_hz: frf.frequency_hz.first().copied().unwrap_or(0.0),
            to_hz: frf.frequency_hz.last().copied().unwrap_or(0.0),
        });
    }
    let shift = Shift::of(machine, frf.frequency_hz.last().copied().unwrap_or(0.0))?;
    let zeros = |pair: [usize; 2], list: usize| {
        let each = pair.map(|k| antiresonances(&frf.frequency_hz, &channels[k], k, &poles, shift.from_hz));
        merge(&each)
            .into_iter()
            .map(|zero| match zero {
                Antiresonance::Found { frequency_hz, standard_deviation_hz } => {
                    shift.apply(Some(list), frequency_hz, standard_deviation_hz)
                }
                Antiresonance::NotIdentified { reason, .. } => Reading::NotIdentified { reason },
            })
            .collect()
    };
    let damping_shift: Vec<f64> = poles.iter().map(|p| shift.of_damping(p)).collect();
    let damping = |(p, shift): (&Resonance, &f64)| p.damping_ratio + shift;
    let damping_sd =
        |(p, shift): (&Resonance, &f64)| (p.standard_deviation_hz / p.frequency_hz).hypot(SHIFT_UNCERTAINTY * shift);
    Ok(Identification {
        resonances: poles.iter().map(|p| shift.apply(None, p.frequency_hz, p.standard_deviation_hz)).collect(),
        damping_ratio: poles.iter().zip(&damping_shift).map(damping).collect(),
        damping_standard_deviation: poles.iter().zip(&damping_shift).map(damping_sd).collect(),
        damping_shift,
        front: zeros([0, 4], 0),
        rear: zeros([3, 7], 1),
        front_over_rear: zeros([1, 5], 2),
        rear_over_front: zeros([2, 6], 3),
    })
}

/// The entries within each plane of motion, rows of [`INPUTS`]: both planes are rows of the same poles.
pub(super) fn channels_of(frf: &MeasuredFrf, machine: &Machine) -> Vec<Channel> {
    let entries = [(0, 0), (0, 2), (2, 0), (2, 2), (1, 1), (1, 3), (3, 1), (3, 3)];
    let mut channels: Vec<Channel> = entries.iter().map(|(i, j)| channel(frf, machine, *i, *j)).collect();
    for (row, pair) in entries.chunks_exact(INPUTS).enumerate() {
        let at = INPUTS * row;
        channels[at].with_next = correlation(frf, [pair[0], pair[1]], [&channels[at], &channels[at + 1]]);
    }
    channels
}

/// Correlation of the noise of two entries of a row, one a line: the noise v of one sensor makes δG = v U⁻¹ of all of
/// them. None where not every column is determined.
fn correlation(frf: &MeasuredFrf, entries: [(usize, usize); 2], channels: [&Channel; 2]) -> Vec<c64> {
    let one = c64::new(1.0, 0.0);
    if frf.determined.contains(&false) {
        return vec![];
    }
    let of_line = |l: usize| {
        let u = Mat::from_fn(AXES, AXES, |i, e| frf.current[(l, i, e)]);
        let inverse = solve_complex(&u, &Mat::from_fn(AXES, AXES, |i, j| if i == j { one } else { 0.0 * one }));
        let [(row, a), (_, b)] = entries;
        let product = |a: usize, b: usize| (0..AXES).map(|e| inverse[(e, a)] * inverse[(e, b)].conj()).sum::<c64>();
        let own = product(a, b) / (product(a, a).re * product(b, b).re).sqrt();
        // The electronics that were divided out, and what of σ is no noise of the sensor.
        let [of_a, of_b] = [(a, channels[0]), (b, channels[1])].map(|(column, channel)| {
            let measured = frf.response[(l, row, column)];
            let divided = channel.value[l] / measured;
            let floor = ENTRY_FLOOR * channel.value[l].norm();
            let noise = (1.0 - (floor / channel.sigma[l]).powi(2)).max(0.0).sqrt();
            divided / divided.norm() * noise
        });
        let found = own * of_a * of_b.conj();
        if found.is_finite() { found } else { 0.0 * one }
    };
    (0..frf.len()).map(of_line).collect()
}

/// One entry with the known electronics divided out.
fn channel(frf: &MeasuredFrf, machine: &Machine, output: usize, input: usize) -> Channel {
    let effective = machine.effective();
    let electronics = &machine.spindle.electronics;
    let (sensor, actuator) = (&effective.bearings[output / 2], &effective.bearings[input / 2]);
    let one = c64::new(1.0, 0.0);
    let known: Vec<c64> = frf
        .frequency_hz
        .iter()
        .map(|f| {
            let current = actuator.axes[input % 2].coil_current(c64::new(0.0, TAU * f));
            c64::from_polar(actuator.ki_n_per_a * sensor.sensor_gain, -TAU * f * effective.delay_s)
                * current
                * (one / c64::new(1.0, f / electronics.sensor_bandwidth_hz))
        })
        .collect();
    let value: Vec<c64> = (0..frf.len()).map(|l| frf.response[(l, output, input)] / known[l]).collect();
    let sigma = if frf.repeats > 1 {
        (0..frf.len()).map(|l| frf.sigma(l, output, input, ENTRY_FLOOR) / known[l].norm()).collect()
    } else {
        let noise = noise_of_lines(&frf.frequency_hz, &value);
        noise.iter().zip(&value).map(|(noise, g)| noise.hypot(ENTRY_FLOOR * g.norm())).collect()
    };
    Channel::new(format!("g_{}{}", output + 1, input + 1), value, sigma)
}

/// One list from those of the two control axes of a plane.
fn merge(lists: &[Vec<Antiresonance>; 2]) -> Vec<Antiresonance> {
    let mut all: Vec<Antiresonance> = vec![];
    for zero in lists.iter().flatten() {
        let Antiresonance::Found { frequency_hz: f, standard_deviation_hz: s } = zero else {
            continue;
        };
        let partner = all.iter_mut().find_map(|other| match other {
            Antiresonance::Found { frequency_hz, standard_deviation_hz }
                if (*frequency_hz - f).abs() < (5.0 * standard_deviation_hz.hypot(*s)).max(2e-3 * f) =>
            {
                Some((frequency_hz, standard_deviation_hz))
            }
            _ => None,
        });
        match partner {
            Some((frequency, sd)) => {
                // The share of the first by inverse variances; two exact ones count alike.
                let (a, b) = (sd.powi(2), s.powi(2));
                let share = if a + b > 0.0 { b / (a + b) } else { 0.5 };
                let mean = *frequency * share + f * (1.0 - share);
                // Two axes that disagree by more than their noise: half the gap is the honest figure.
                let apart = 0.5 * (*frequency - f).abs();
                *sd = (share * a).sqrt().max(apart);
                *frequency = mean;
            }
            None => all.push(zero.clone()),
        }
    }
    for zero in lists.iter().flatten() {
        let Antiresonance::NotIdentified { from_hz, to_hz, .. } = zero else {
            continue;
        };
        let settled = all.iter().any(|other| match other {
            Antiresonance::Found { frequency_hz, .. } => frequency_hz > from_hz && frequency_hz < to_hz,
            Antiresonance::NotIdentified { from_hz: a, to_hz: b, .. } => a == from_hz && b == to_hz,
        });
        if !settled {
            all.push(zero.clone());
        }
    }
    all.sort_by(|a, b| a.place_hz().total_cmp(&b.place_hz()));
    all
}

/// The nearest of these frequencies within the range of a nominal model, and its place in the list.
fn nearest(list: &[f64], f: f64) -> Option<(usize, f64)> {
    (list.iter().copied().enumerate())
        .min_by(|(_, a), (_, b)| (a / f).ln().abs().total_cmp(&(b / f).ln().abs()))
        .filter(|(_, g)| (g / f).ln().abs() < SAME_PEAK.ln())
}

/// Poles of the machine at rest without controller, rad/s, with so much of its magnets' stiffness.
fn poles_with_stiffness(machine: &Machine, share: f64, flexible: usize) -> Result<Vec<c64>, IdentifyError> {
    let mut machine = machine.clone();
    for bearing in [&mut machine.spindle.front, &mut machine.spindle.rear] {
        bearing.ks_n_per_m *= share;
    }
    let plant = Plant::new(&machine, 0.0, ModelDetail::Modes { flexible, static_residual: false })?;
    Ok(plant.state_space(0)?.poles()?)
}

/// Peaks of the model with and without the magnets' stiffness.
struct Shift {
    /// Where they begin, Hz.
    from_hz: f64,
    free: ModalSpectrum,
    held: ModalSpectrum,
    /// Poles of the machine without and with its magnets' stiffness, rad/s.
    free_poles: Vec<c64>,
    held_poles: Vec<c64>,
}

impl Shift {
    fn of(machine: &Machine, to_hz: f64) -> Result<Self, IdentifyError> {
        let rotor = machine.rotor()?;
        let chain = chain_assembly::chain(&rotor)?;
        let port = |what: &str, z: f64| chain_assembly::port(&rotor, what, z);
        let mut with_magnets: Chain = chain.clone();
        let mut ports: Vec<(ChainPort, ChainPort)> = vec![];
        for b in &machine.effective().bearings {
            let actuator = port("actuator", b.actuator_m)?;
            ports.push((port("sensor", b.sensor_m)?, actuator));
            with_magnets = with_magnets.with_spring(&actuator, -b.ks_n_per_m);
        }
        // Front, rear, front over rear, rear over front: sensor, actuator.
        let frfs: Vec<(ChainPort, ChainPort)> =
            [(0, 0), (1, 1), (0, 1), (1, 0)].iter().map(|(s, a)| (ports[*s].0, ports[*a].1)).collect();
        let from_hz = lowest_hz(&rotor)?;
        let query = Query { frfs, from_hz, to_hz: 1.5 * to_hz.max(2.0 * from_hz) };
        let ones = vec![1.0; chain.regions.len()];
        let (free, held) = (spectrum(&chain, &ones, &query), spectrum(&with_magnets, &ones, &query));
        let flexible = held.below + held.poles_hz.len();
        Ok(Self {
            from_hz,
            free,
            held,
            // A file may not say that there is none.
            free_poles: poles_with_stiffness(machine, f64::EPSILON, flexible)?,
            held_poles: poles_with_stiffness(machine, 1.0, flexible)?,
        })
    }

    /// Frequency of the mode that is measured at a frequency, with and without the magnets' stiffness.
    fn mode(&self, measured_hz: f64) -> Option<[f64; 2]> {
        let (k, held) = nearest(&self.held.poles_hz, measured_hz)?;
        // Springs move every natural frequency of a symmetric pencil without changing their order.
        let place = (k + self.held.below).checked_sub(self.free.below)?;
        Some([held, *self.free.poles_hz.get(place)?])
    }

    /// What a damping ratio changes by without the magnets' stiffness: the ratio of the two is that of the model.
    fn of_damping(&self, measured: &Resonance) -> f64 {
        let damping = |poles: &[c64], hz: f64| {
            let distance = |pole: &&c64| (**pole - c64::new(0.0, TAU * hz)).norm();
            let own = poles.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
            own.map(|pole| -pole.re / pole.norm()).filter(|ratio| *ratio > 0.0)
        };
        let ratio = self
            .mode(measured.frequency_hz)
            .and_then(|[held, free]| Some(damping(&self.free_poles, free)? / damping(&self.held_poles, held)?));
        ratio.map_or(0.0, |ratio| (ratio - 1.0) * measured.damping_ratio)
    }

    /// Reading of the free-free rotor from a measured peak; `list` is the FRF of a zero.
    fn apply(&self, list: Option<usize>, measured_hz: f64, sd_hz: f64) -> Reading {
        let ratio = match list {
            None => self.mode(measured_hz).map(|[held, free]| free / held),
            Some(list) => {
                let zeros = |s: &ModalSpectrum| s.zeros_hz.get(list).cloned().unwrap_or_default();
                nearest(&zeros(&self.held), measured_hz)
                    .and_then(|(_, held)| Some(nearest(&zeros(&self.free), held)?.1 / held))
            }
        };
        let shift = ratio.map_or(0.0, |ratio| (ratio - 1.0) * measured_hz);
        if !(measured_hz + shift > 0.0 && sd_hz.hypot(shift).is_finite()) {
            let reason = "the fit of the record gave no frequency that is a positive number".to_owned();
            return Reading::NotIdentified { reason };
        }
        Reading::Found {
            frequency_hz: measured_hz + shift,
            standard_deviation_hz: sd_hz.hypot(SHIFT_UNCERTAINTY * shift),
            magnet_shift_hz: shift,
        }
    }
}
