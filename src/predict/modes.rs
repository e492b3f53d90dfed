//! Modes of the sampled closed loop: frequency and damping of the flexible modes and of the rigid-body modes.
//!
//! A loop of fifty states has many poles; the pole of a mode is the one with the highest resonance in its response. A
//! pole λ with residue R in a response adds a resonance of height |R|/|Re λ|; the residue is read off the response
//! beside the pole, R ≈ δ·T(λ + δ). Flexible mode k: modal coordinate k per force on it. Rigid modes: displacements per
//! forces at the two actuators.

use super::closed_loop::AXES;
use crate::linalg::{Mat, NumericError, c64};
use crate::lti::connect::lower_lft;
use crate::lti::{Discrete, FrequencyResponder, StateSpace};
use crate::spindle::plant::CHANNELS;
use crate::spindle::{Plant, SpindleError};

/// A mode of the closed loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopMode {
    /// |λ|/2π, Hz.
    pub frequency_hz: f64,
    /// −Re λ/|λ|.
    pub damping_ratio: f64,
}

/// Modes of a closed loop at one speed.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopModes {
    /// The first flexible modes; `None` where no pole within the window shows in the mode.
    pub flexible: Vec<Option<LoopMode>>,
    /// Oscillating poles below half the first flexible mode that show at the actuators, the most visible first. Where
    /// the magnets are stiff against the shaft and a flexible mode has no pole near its free frequency, also those that
    /// are near none of these.
    pub rigid: Vec<LoopMode>,
    /// Every pole that shows in one of these modes, forward and backward whirl apart, by frequency.
    pub visible: Vec<LoopMode>,
}

impl LoopMode {
    /// ln of the ratio of two amplitudes one period apart, 2πζ/√(1 − ζ²).
    pub fn logarithmic_decrement(&self) -> f64 {
        std::f64::consts::TAU * self.damping_ratio / (1.0 - self.damping_ratio.powi(2)).max(0.0).sqrt()
    }
}

/// Flexible modes looked at: the three that the paper names.
pub(crate) const FLEXIBLE: usize = 3;
/// A closed-loop pole of a flexible mode lies within this factor of the natural frequency of the free rotor.
const WINDOW: f64 = 1.25;
/// Poles whose height is above this part of the highest (−20 dB) all belong to the mode; the least damped is reported.
const SHARE: f64 = 0.1;
/// Rigid-body modes are told by poles below this damping ratio: beyond it a pole is as good as real and no oscillation.
const OSCILLATES: f64 = 0.95;
/// Heights of rigid-body modes below this part of the highest one are filters of the controller.
const RIGID_SHARE: f64 = 0.1;
/// Rigid-body modes of a plane.
const RIGID: usize = 2;

/// Modes of the loop of a plant with a sampled controller.
///
/// # Errors
/// [`SpindleError`] when the loop is not well posed or its eigenvalues fail.
pub fn loop_modes(plant: &Plant, controller: &StateSpace<Discrete>) -> Result<LoopModes, SpindleError> {
    let sampled = plant.sample_plant()?;
    let poles = plant.loop_poles(&sampled, controller)?;
    modes_of_poles(plant, controller, &sampled.time.continuous_poles(poles))
}

/// [`loop_modes`] where the poles of the loop are known, as continuous ones, rad/s.
pub(crate) fn modes_of_poles(
    plant: &Plant,
    controller: &StateSpace<Discrete>,
    poles_rad_s: &[c64],
) -> Result<LoopModes, SpindleError> {
    let natural: Vec<f64> = plant.flexible_rad_s().iter().take(FLEXIBLE).copied().collect();
    let count = natural.len();
    let sampled = plant.sampled_with_modal_ports(count)?;
    // x only: modal forces, forces at the actuators; then the loop.
    let ports: Vec<usize> = (0..count).map(|k| CHANNELS + 2 * k).chain([6, 8]).chain(0..AXES).collect();
    let numeric = |e: NumericError| SpindleError::Numeric(e);
    let closed = lower_lft(&sampled.select(&ports, &ports), controller).map_err(numeric)?;
    let period = closed.time.period_s;
    let responder = FrequencyResponder::new(&closed);
    let mut poles: Vec<(c64, c64)> = poles_rad_s
        .iter()
        .filter(|s| s.im > 0.0)
        .map(|s| ((s * period).exp(), *s))
        .filter(|(z, _)| z.im > 0.0)
        .collect();
    poles.sort_by(|a, b| a.1.norm().total_cmp(&b.1.norm()));
    let first = natural.first().copied().unwrap_or(f64::INFINITY);
    let top = natural.last().map_or(0.0, |w| w * WINDOW);
    // Beside the pole by a part of its damping that is small against the distance to any other pole that matters.
    let beside = |z: c64, s: c64| z * (1.0 + 1e-4 * s.re.abs() * period);
    let heights: Vec<(c64, Mat<f64>)> = poles
        .iter()
        .filter(|(_, s)| s.norm() < top)
        .map(|(z, s)| {
            let at = beside(*z, *s);
            let response = responder.transfer(at);
            let scale = (at - z).norm() / (z.norm() * period * s.re.abs());
            let height = Mat::from_fn(count + 2, count + 2, |i, j| response[(i, j)].norm() * scale);
            (*s, height)
        })
        .collect();
    let mut visible = vec![];
    let flexible: Vec<Option<LoopMode>> = (0..count)
        .map(|k| {
            let ratio = |s: &c64| s.norm() / natural[k];
            let near: Vec<(LoopMode, f64)> = heights
                .iter()
                .filter(|(s, _)| ratio(s) < WINDOW && ratio(s) > 1.0 / WINDOW)
                .map(|(s, h)| (mode(*s), h[(k, k)]))
                .collect();
            let highest = near.iter().map(|n| n.1).fold(0.0, f64::max);
            let shown: Vec<LoopMode> = near.into_iter().filter(|n| n.1 >= SHARE * highest).map(|n| n.0).collect();
            visible.extend_from_slice(&shown);
            shown.into_iter().min_by(|a, b| a.damping_ratio.total_cmp(&b.damping_ratio))
        })
        .collect();
    let lost = flexible.iter().filter(|mode| mode.is_none()).count();
    let is_apart = |s: &c64| natural.iter().all(|w| !(1.0 / WINDOW..WINDOW).contains(&(s.norm() / w)));
    let mut low: Vec<(LoopMode, f64)> = heights
        .iter()
        .filter(|(s, _)| s.norm() < 0.5 * first || lost > 0 && is_apart(s))
        .filter(|(s, _)| -s.re < OSCILLATES * s.norm())
        .map(|(s, h)| (mode(*s), h[(count, count)].max(h[(count + 1, count + 1)])))
        .collect();
    low.sort_by(|a, b| b.1.total_cmp(&a.1));
    let highest = low.first().map_or(0.0, |l| l.1);
    // At speed every mode comes twice, forwards and backwards; the more visible one of a pair stands for both.
    let mut rigid: Vec<LoopMode> = vec![];
    for (found, height) in low {
        if height >= RIGID_SHARE * highest {
            visible.push(found);
        }
        let twin = |r: &LoopMode| (r.frequency_hz / found.frequency_hz - 1.0).abs() < 0.02;
        if height >= RIGID_SHARE * highest && !rigid.iter().any(twin) && rigid.len() < RIGID + lost {
            rigid.push(found);
        }
    }
    visible.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    visible.dedup();
    Ok(LoopModes { flexible, rigid, visible })
}

fn mode(s: c64) -> LoopMode {
    LoopMode { frequency_hz: s.norm() / std::f64::consts::TAU, damping_ratio: -s.re / s.norm() }
}
