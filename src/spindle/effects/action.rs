//! What an effect does to the machine: factors multiply, shifts and delays add, replacements replace, in file order.
//!
//! Every effect acts at one of three places: on bearings, electronics and attachments ([`on_machine`]), on the rotor
//! ([`on_rotor`]), or on the damping ratio of a mode ([`on_damping_ratio`]).

use super::{Bearings, Effect, EffectKind, Location};
use crate::rotor::{Joint, PointMass, Rotor, RotorError, Section};
use crate::spindle::effective::{Attachment, Effective, EffectiveBearing, FeedbackLaw, Housing, Motion};
use std::f64::consts::TAU;

/// Applies an effect to bearings, electronics and attachments; one that acts elsewhere changes nothing here.
pub(crate) fn on_machine(effect: &Effect, machine: &mut Effective) {
    let value = effect.values.first().copied().unwrap_or_default();
    match (effect.kind, &effect.location) {
        (EffectKind::LoopDelay, _) => machine.delay_s += value,
        (EffectKind::Gyroscopic, _) => machine.gyroscopic_factor = value,
        (EffectKind::InternalDamping, _) => machine.loss_time_s += value,
        (EffectKind::CrossCoupling, Location::Position(z)) => {
            attach(machine, *z, Motion::Displacement, FeedbackLaw::Circulatory, value);
        }
        (EffectKind::AddedStiffness, Location::Position(z)) => {
            attach(machine, *z, Motion::Displacement, FeedbackLaw::Spring, value);
        }
        (EffectKind::AddedDamper, Location::Position(z)) => {
            attach(machine, *z, Motion::Displacement, FeedbackLaw::Dashpot, value);
        }
        (EffectKind::AddedStiffness, Location::InPlane(z, plane)) => {
            machine.attachments.push(Attachment {
                position_m: *z,
                motion: Motion::Displacement,
                law: FeedbackLaw::Spring,
                value,
                plane: Some(*plane),
            });
        }
        (EffectKind::TiltingStiffness, Location::Position(z)) => {
            attach(machine, *z, Motion::Slope, FeedbackLaw::Spring, value);
        }
        (EffectKind::HousingMode, _) => {
            if let [mass_kg, frequency_hz, damping_ratio] = effect.values[..] {
                machine.housings.push(Housing { mass_kg, omega_rad_s: TAU * frequency_hz, damping_ratio });
            }
        }
        (EffectKind::SensorCrosstalk, Location::Across { from: from @ 0..4, to: to @ 0..4 }) => {
            machine.crosstalk[*to][*from] += value;
        }
        (kind, Location::Bearing(which)) => on_bearings(kind, *which, value, &mut machine.bearings),
        (EffectKind::SensorGain, Location::Axis(axis @ 0..4)) => {
            machine.bearings[axis / 2].signal_factors[axis % 2] *= value;
        }
        (EffectKind::ForceConstant, Location::Axis(axis @ 0..4)) => {
            machine.bearings[axis / 2].force_factors[axis % 2] *= value;
        }
        _ => {}
    }
}

fn attach(machine: &mut Effective, position_m: f64, motion: Motion, law: FeedbackLaw, value: f64) {
    machine.attachments.push(Attachment { position_m, motion, law, value, plane: None });
}

fn on_bearings(kind: EffectKind, which: Bearings, value: f64, bearings: &mut [EffectiveBearing; 2]) {
    let meant = bearings.iter_mut().enumerate();
    for (_, bearing) in meant.filter(|(i, _)| which.includes(*i)) {
        match kind {
            EffectKind::AmplifierBandwidth => bearing.amplifier_bandwidth_hz = value,
            EffectKind::EddyCurrents => bearing.eddy_corner_hz = Some(value),
            EffectKind::LaminatedCore => bearing.lamination_corner_hz = Some(value),
            EffectKind::SensorLowpass => bearing.sensor_lowpass_hz = Some(value),
            EffectKind::SensorOffset => bearing.sensor_m += value,
            EffectKind::ActuatorOffset => bearing.actuator_m += value,
            EffectKind::NegativeStiffness => bearing.ks_n_per_m *= value,
            EffectKind::ForceConstant => bearing.ki_n_per_a *= value,
            EffectKind::SensorGain => bearing.sensor_gain *= value,
            EffectKind::BearingCoupling => bearing.coupling_ratio += value,
            EffectKind::AxisMisalignment => bearing.sensor_angle_rad += value.to_radians(),
            _ => {}
        }
    }
}

/// Applies an effect to the free-free rotor; one that acts elsewhere returns the rotor as it is.
pub(crate) fn on_rotor(effect: &Effect, rotor: Rotor) -> Result<Rotor, RotorError> {
    let value = effect.values.first().copied().unwrap_or_default();
    let mass = |position_m| PointMass { position_m, mass_kg: value };
    match (effect.kind, &effect.location) {
        (EffectKind::ToolMass, _) => {
            let tip = rotor.from_m();
            rotor.with_point_mass(mass(tip))
        }
        (EffectKind::AddedMass, Location::Position(z)) => rotor.with_point_mass(mass(*z)),
        (EffectKind::RegionStiffness, Location::Region(region)) => {
            let inside = |s: &Section| s.region.as_ref() == Some(region);
            rotor.with_modulus_factors(|_, s| if inside(s) { value } else { 1.0 })
        }
        _ => Ok(rotor),
    }
}

/// The joint between tool and nose face that the effects of a file make together; none without such an effect.
pub(crate) fn joint(effects: &[Effect]) -> Option<Joint> {
    let joints = effects.iter().filter(|e| e.kind == EffectKind::ToolJoint);
    let one = |e: &Effect| {
        let at = |i: usize| e.values.get(i).copied().unwrap_or_default();
        Joint { translational_n_per_m: at(0), rotational_n_m_per_rad: at(1), damping_n_m_s_per_rad: at(2) }
    };
    joints.map(one).reduce(in_series)
}

/// Two joints listed for one place: their flexibilities add; the smaller damping is kept, an underestimate.
fn in_series(a: Joint, b: Joint) -> Joint {
    let series = |x: f64, y: f64| x * y / (x + y);
    Joint {
        translational_n_per_m: series(a.translational_n_per_m, b.translational_n_per_m),
        rotational_n_m_per_rad: series(a.rotational_n_m_per_rad, b.rotational_n_m_per_rad),
        damping_n_m_s_per_rad: a.damping_n_m_s_per_rad.min(b.damping_n_m_s_per_rad),
    }
}

/// The damping ratio of flexible mode `k`, counted from 0, after the effects of a file.
pub(crate) fn on_damping_ratio(effects: &[Effect], k: usize, nominal: f64) -> f64 {
    effects
        .iter()
        .filter(|e| e.kind == EffectKind::ModalDamping && e.location == Location::Mode(k + 1))
        .filter_map(|e| e.value("factor"))
        .fold(nominal, |zeta, factor| zeta * factor)
}
