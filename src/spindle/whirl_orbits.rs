//! Orbits along a shaft in its whirl modes at a speed, magnets off.

use super::{Machine, RotorOnSupports, SpindleError};
use crate::rotor::whirl::{RotorState, WhirlShape};
use crate::rotor::{Damping, Rotor, Support};
use std::f64::consts::TAU;

/// Places along the shaft.
const PLACES: usize = 41;

/// Whirl modes of a rotor at a speed with the orbits of evenly spaced places.
#[derive(Clone, Debug)]
pub struct WhirlOrbits {
    /// rpm.
    pub speed_rpm: f64,
    /// Places from end to end, m from the nose face.
    pub position_m: Vec<f64>,
    /// Modes, ascending in frequency.
    pub shapes: Vec<WhirlShape>,
}

impl WhirlOrbits {
    /// Of a machine without its magnets, on supports.
    ///
    /// # Errors
    /// [`SpindleError`] when a part breaks a rule or the eigenvalues fail.
    pub fn of(machine: &Machine, supports: &[Support], speed_rpm: f64, to_hz: f64) -> Result<Self, SpindleError> {
        let rotor = machine.rotor()?;
        let damping = Damping::Modal((0..rotor.dofs()).map(|k| machine.damping_ratio(k)).collect());
        let speed_rad_s = speed_rpm * TAU / 60.0 * machine.effective().gyroscopic_factor;
        Self::in_state(&rotor, &RotorState { speed_rad_s, damping: &damping, supports }, speed_rpm, to_hz)
    }

    /// Of a rotor on its supports.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn of_rotor(rotor: &RotorOnSupports, speed_rpm: f64, to_hz: f64) -> Result<Self, SpindleError> {
        let shaft = rotor.rotor()?;
        let (speed_rad_s, damping) = (rotor.seen_speed(speed_rpm * TAU / 60.0), rotor.damping(&shaft));
        let state = RotorState { speed_rad_s, damping: &damping, supports: &rotor.supports };
        Self::in_state(&shaft, &state, speed_rpm, to_hz)
    }

    fn in_state(rotor: &Rotor, state: &RotorState<'_>, speed_rpm: f64, to_hz: f64) -> Result<Self, SpindleError> {
        let ends = rotor.node_positions_m();
        let (first, last) = (ends.first().copied().unwrap_or(0.0), ends.last().copied().unwrap_or(0.0));
        let place = |k: usize| first + (last - first) * k as f64 / (PLACES - 1) as f64;
        let position_m: Vec<f64> = (0..PLACES).map(place).collect();
        let shapes = rotor.whirl_shapes(state, &position_m, to_hz)?;
        Ok(Self { speed_rpm, position_m, shapes })
    }
}
