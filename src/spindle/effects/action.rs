//! What an effect does to the machine: factors multiply, shifts and delays add, replacements replace, in file order.
//!
//! Every effect acts at one of three places: on bearings, electronics and attachments ([`on_machine`]), on the rotor
//! ([`on_rotor`]), or on the damping ratio of a mode ([`on_damping_ratio`]).

use super::{Effect, EffectKind, Location};
use crate::rotor::{Disc, Joint, Rotor, RotorError, Section};
use crate::spindle::effective::{
    Amplifier, Attachment, AxisElectronics, Effective, EffectiveBearing, FeedbackLaw, Housing, Motion,
};
use std::f64::consts::TAU;

/// Applies an effect to bearings, electronics and attachments; one that acts elsewhere changes nothing here.
pub(crate) fn on_machine(effect: &Effect, machine: &mut Effective) {
    let value = effect.values.first().copied().unwrap_or_default();
    match (effect.kind, &effect.location) {
        (EffectKind::LoopDelay, Location::None) => machine.delay_s += value,
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
        (kind, Location::InPlane(z, plane)) => {
            let law = if kind == EffectKind::AddedDamper { FeedbackLaw::Dashpot } else { FeedbackLaw::Spring };
            let (position_m, motion, plane) = (*z, Motion::Displacement, Some(*plane));
            machine.attachments.push(Attachment { position_m, motion, law, value, plane });
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
        (EffectKind::CurrentPickup, Location::Across { from: from @ 0..4, to: to @ 0..4 }) => {
            machine.current_pickup[*to][*from] += value;
        }
        (_, Location::Bearing(which)) => {
            for b in (0..2).filter(|b| which.includes(*b)) {
                let bearing = &mut machine.bearings[b];
                bearing.axes.iter_mut().for_each(|axis| on_axis(effect, axis));
                on_bearing(effect.kind, value, bearing);
            }
        }
        (kind, Location::Axis(axis @ 0..4)) => {
            let own = &mut machine.bearings[axis / 2].axes[axis % 2];
            match kind {
                EffectKind::SensorGain => own.signal_factor *= value,
                EffectKind::ForceConstant => own.force_factor *= value,
                _ => on_axis(effect, own),
            }
        }
        _ => {}
    }
}

fn attach(machine: &mut Effective, position_m: f64, motion: Motion, law: FeedbackLaw, value: f64) {
    machine.attachments.push(Attachment { position_m, motion, law, value, plane: None });
}

fn on_axis(effect: &Effect, axis: &mut AxisElectronics) {
    match (effect.kind, &effect.values[..]) {
        (EffectKind::LoopDelay, [delay_s]) => axis.further_delay_s += delay_s,
        (EffectKind::AmplifierBandwidth, [hz]) => axis.amplifier = Amplifier::FirstOrder { bandwidth_hz: *hz },
        (EffectKind::AmplifierSecondOrder, [frequency_hz, damping_ratio]) => {
            let (frequency_hz, damping_ratio) = (*frequency_hz, *damping_ratio);
            axis.amplifier = Amplifier::SecondOrder { frequency_hz, damping_ratio };
        }
        (EffectKind::EddyCurrents, [hz]) => axis.eddy_corner_hz = Some(*hz),
        (EffectKind::LaminatedCore, [hz]) => axis.lamination_corner_hz = Some(*hz),
        (EffectKind::SensorLowpass, [hz]) => axis.sensor_lowpass_hz = Some(*hz),
        _ => {}
    }
}

fn on_bearing(kind: EffectKind, value: f64, bearing: &mut EffectiveBearing) {
    match kind {
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

/// Applies an effect to the free-free rotor; one that acts elsewhere returns the rotor as it is.
pub(crate) fn on_rotor(effect: &Effect, rotor: Rotor) -> Result<Rotor, RotorError> {
    let at = |i: usize| effect.values.get(i).copied().unwrap_or_default();
    let value = at(0);
    let mass =
        Disc { position_m: rotor.from_m(), mass_kg: value, polar_inertia_kg_m2: 0.0, diametral_inertia_kg_m2: 0.0 };
    match (effect.kind, &effect.location) {
        (EffectKind::ToolMass, _) => rotor.with_added_disc(mass),
        (EffectKind::AddedMass, Location::Position(z)) => rotor.with_added_disc(Disc { position_m: *z, ..mass }),
        (EffectKind::AddedDisc, Location::Position(z)) => rotor.with_added_disc(Disc {
            position_m: *z,
            mass_kg: value,
            polar_inertia_kg_m2: at(1),
            diametral_inertia_kg_m2: at(2),
        }),
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
