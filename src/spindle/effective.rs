//! What the effects of a spindle file make of its bearings, chain and additions: factors multiply, shifts and delays add,
//! replacements replace, in file order.

use super::effect::{Effect, EffectKind, Location};
use super::machine::{Bearing, Machine};

/// A bearing with its chain after all effects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectiveBearing {
    /// N/A.
    pub ki_n_per_a: f64,
    /// N/m, positive.
    pub ks_n_per_m: f64,
    /// Amplifier, Hz.
    pub amplifier_bandwidth_hz: f64,
    /// Eddy-current corner, Hz.
    pub eddy_corner_hz: Option<f64>,
    /// Second-order sensor low-pass, Hz.
    pub sensor_lowpass_hz: Option<f64>,
    /// Sensor plane, m.
    pub sensor_m: f64,
    /// Actuator plane, m.
    pub actuator_m: f64,
    /// Factor on the sensor signal.
    pub sensor_gain: f64,
    /// Symmetric x–y cross term of ki.
    pub coupling_ratio: f64,
    /// Rotation of the sensor axes, rad.
    pub sensor_angle_rad: f64,
}

/// Stator mass on its foundation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Housing {
    /// kg.
    pub mass_kg: f64,
    /// rad/s.
    pub omega_rad_s: f64,
    /// −.
    pub damping_ratio: f64,
}

/// Everything the plant needs besides the shaft, after all effects.
#[derive(Clone, Debug, PartialEq)]
pub struct Effective {
    /// Front, rear.
    pub bearings: [EffectiveBearing; 2],
    /// Total delay, s.
    pub delay_s: f64,
    /// Factor on the gyroscopic matrix.
    pub gyroscopic_factor: f64,
    /// Rotating damping β, s.
    pub loss_time_s: f64,
    /// Circulatory stiffness at positions, (m, N/m).
    pub cross_coupling: Vec<(f64, f64)>,
    /// Springs to ground at positions, (m, N/m).
    pub added_stiffness: Vec<(f64, f64)>,
    /// Housing modes.
    pub housings: Vec<Housing>,
    /// Factors on modal damping, (mode from 1, factor).
    pub modal_damping: Vec<(usize, f64)>,
}

impl Machine {
    /// Bearings, chain and additions after all effects.
    pub fn effective(&self) -> Effective {
        let (s, p, e) = (
            &self.spindle,
            &self.spindle.planes,
            &self.spindle.electronics,
        );
        let nominal = |b: &Bearing, sensor_m, actuator_m| EffectiveBearing {
            ki_n_per_a: b.ki_n_per_a,
            ks_n_per_m: b.ks_n_per_m,
            amplifier_bandwidth_hz: e.amplifier_bandwidth_hz,
            eddy_corner_hz: None,
            sensor_lowpass_hz: None,
            sensor_m,
            actuator_m,
            sensor_gain: b.sensor_gain,
            coupling_ratio: 0.0,
            sensor_angle_rad: 0.0,
        };
        let mut all = Effective {
            bearings: [
                nominal(&s.front, p.front_sensor_m, p.front_actuator_m),
                nominal(&s.rear, p.rear_sensor_m, p.rear_actuator_m),
            ],
            delay_s: e.delay_s,
            gyroscopic_factor: if s.gyroscopics { 1.0 } else { 0.0 },
            loss_time_s: 0.0,
            cross_coupling: vec![],
            added_stiffness: vec![],
            housings: vec![],
            modal_damping: vec![],
        };
        for effect in &s.effects {
            all.apply(effect);
        }
        all
    }
}

impl Effective {
    /// Positions of the actuators, front and rear, then of the sensors, m.
    pub fn planes_m(&self) -> [f64; 4] {
        let [front, rear] = &self.bearings;
        [
            front.actuator_m,
            rear.actuator_m,
            front.sensor_m,
            rear.sensor_m,
        ]
    }

    fn apply(&mut self, effect: &Effect) {
        let value = effect.values.first().copied().unwrap_or_default();
        if let Location::Bearing(which) = effect.location {
            for (i, bearing) in self.bearings.iter_mut().enumerate() {
                if which.includes(i) {
                    bearing.apply(effect.kind, value);
                }
            }
        }
        match (effect.kind, &effect.location) {
            (EffectKind::LoopDelay, _) => self.delay_s += value,
            (EffectKind::Gyroscopic, _) => self.gyroscopic_factor = value,
            (EffectKind::InternalDamping, _) => self.loss_time_s += value,
            (EffectKind::CrossCoupling, Location::Position(z)) => {
                self.cross_coupling.push((*z, value));
            }
            (EffectKind::AddedStiffness, Location::Position(z)) => {
                self.added_stiffness.push((*z, value));
            }
            (EffectKind::ModalDamping, Location::Mode(mode)) => {
                self.modal_damping.push((*mode, value));
            }
            (EffectKind::HousingMode, _) => {
                if let [mass_kg, frequency_hz, damping_ratio] = effect.values[..] {
                    self.housings.push(Housing {
                        mass_kg,
                        omega_rad_s: std::f64::consts::TAU * frequency_hz,
                        damping_ratio,
                    });
                }
            }
            _ => {}
        }
    }
}

impl EffectiveBearing {
    fn apply(&mut self, kind: EffectKind, value: f64) {
        match kind {
            EffectKind::AmplifierBandwidth => self.amplifier_bandwidth_hz = value,
            EffectKind::EddyCurrents => self.eddy_corner_hz = Some(value),
            EffectKind::SensorLowpass => self.sensor_lowpass_hz = Some(value),
            EffectKind::SensorOffset => self.sensor_m += value,
            EffectKind::ActuatorOffset => self.actuator_m += value,
            EffectKind::NegativeStiffness => self.ks_n_per_m *= value,
            EffectKind::ForceConstant => self.ki_n_per_a *= value,
            EffectKind::SensorGain => self.sensor_gain *= value,
            EffectKind::BearingCoupling => self.coupling_ratio += value,
            EffectKind::AxisMisalignment => self.sensor_angle_rad += value.to_radians(),
            _ => {}
        }
    }
}
