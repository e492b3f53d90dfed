//! Bearings, electronics and what is attached to the shaft, after all effects: what the plant is built from besides the
//! rotor.

use super::effects::Plane;
use crate::linalg::c64;
use crate::rotor::Support;

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
    /// Corner of the laminated iron, Hz.
    pub lamination_corner_hz: Option<f64>,
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
    /// Factors on the forces of x and y, where the axes differ.
    pub force_factors: [f64; 2],
    /// Factors on the signals of x and y, where the axes differ.
    pub signal_factors: [f64; 2],
}

impl EffectiveBearing {
    /// Whether x and y do not act on each other and have the same gains.
    pub(crate) fn axes_are_alike(&self) -> bool {
        let [force_x, force_y] = self.force_factors;
        let [signal_x, signal_y] = self.signal_factors;
        force_x == force_y && signal_x == signal_y && self.coupling_ratio == 0.0 && self.sensor_angle_rad == 0.0
    }
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

/// The motion of the shaft that an attachment reads and acts against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Displacement; the answer is a force.
    Displacement,
    /// Slope; the answer is a moment.
    Slope,
}

/// A force per displacement, or a moment per slope, of one unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeedbackLaw {
    /// Against the displacement.
    Spring,
    /// Perpendicular to the displacement, q > 0 along forward whirl.
    Circulatory,
    /// Against the velocity.
    Dashpot,
    /// Against the acceleration.
    Mass,
}

impl FeedbackLaw {
    /// Force per displacement at a signed frequency, rad/s, in r = x + jy.
    pub fn gain(self, w: f64) -> c64 {
        match self {
            Self::Spring => c64::new(-1.0, 0.0),
            Self::Circulatory => c64::new(0.0, 1.0),
            Self::Dashpot => c64::new(0.0, -w),
            Self::Mass => c64::new(w * w, 0.0),
        }
    }
}

/// A law between ground and a position of the shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attachment {
    /// m from the nose face.
    pub position_m: f64,
    /// What it reads.
    pub motion: Motion,
    /// The law; in one plane a spring.
    pub law: FeedbackLaw,
    /// Units of it: N/m, N s/m, or N m/rad against a slope.
    pub value: f64,
    /// The plane in which it acts; none: in both.
    pub plane: Option<Plane>,
}

impl Attachment {
    /// The same as a support of a shaft; a mass is none.
    pub(crate) fn support(&self) -> Support {
        let of = |p: usize| if self.plane.is_none_or(|own| own as usize == p) { self.value } else { 0.0 };
        let (mut support, diagonal) = (Support::at(self.position_m), [[of(0), 0.0], [0.0, of(1)]]);
        match self.law {
            FeedbackLaw::Spring => support.stiffness_n_per_m = diagonal,
            // A force jq(x + jy) takes y to x and x to y.
            FeedbackLaw::Circulatory => support.stiffness_n_per_m = [[0.0, self.value], [-self.value, 0.0]],
            FeedbackLaw::Dashpot => support.damping_n_s_per_m = diagonal,
            FeedbackLaw::Mass => {}
        }
        support
    }
}

/// Everything the plant needs besides the shaft, after all effects.
#[derive(Clone, Debug, PartialEq)]
pub struct Effective {
    /// Front, rear.
    pub bearings: [EffectiveBearing; 2],
    /// Corner of the sensors, Hz.
    pub sensor_bandwidth_hz: f64,
    /// Total delay, s.
    pub delay_s: f64,
    /// Factor on the gyroscopic matrix.
    pub gyroscopic_factor: f64,
    /// Rotating damping β, s.
    pub loss_time_s: f64,
    /// Share of the signal of each axis (columns) in that of another (rows).
    pub crosstalk: [[f64; 4]; 4],
    /// Springs, dampers and circulatory laws on the shaft.
    pub attachments: Vec<Attachment>,
    /// Housing modes.
    pub housings: Vec<Housing>,
}

impl Effective {
    /// Whether a sensor signal has a share of another.
    pub(crate) fn has_crosstalk(&self) -> bool {
        self.crosstalk.as_flattened().iter().any(|share| *share != 0.0)
    }

    /// Positions of the actuators, front and rear, then of the sensors, m.
    pub(crate) fn planes_m(&self) -> [f64; 4] {
        let [front, rear] = &self.bearings;
        [front.actuator_m, rear.actuator_m, front.sensor_m, rear.sensor_m]
    }
}
