//! Bearings, electronics and what is attached to the shaft, after all effects: what the plant is built from besides the
//! rotor.

use super::correction::{LawSite, PlacedLaw};
use super::effects::Plane;
use crate::linalg::c64;
use crate::rotor::Support;
use std::f64::consts::TAU;

/// The current loop of an amplifier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amplifier {
    /// 1/(1 + s/ω_a).
    FirstOrder {
        /// ω_a/2π, Hz.
        bandwidth_hz: f64,
    },
    /// ω²/(s² + 2ζωs + ω²).
    SecondOrder {
        /// ω/2π, Hz.
        frequency_hz: f64,
        /// ζ.
        damping_ratio: f64,
    },
}

impl Amplifier {
    /// Bandwidth of the first-order loop with the same lag at low frequencies, Hz.
    pub(crate) fn lag_bandwidth_hz(self) -> f64 {
        match self {
            Self::FirstOrder { bandwidth_hz } => bandwidth_hz,
            Self::SecondOrder { frequency_hz, damping_ratio } => 0.5 * frequency_hz / damping_ratio,
        }
    }

    /// Current per command at s, rad/s.
    pub(crate) fn gain(self, s: c64) -> c64 {
        let lag = s / (TAU * self.lag_bandwidth_hz()) + 1.0;
        match self {
            Self::FirstOrder { .. } => lag.inv(),
            Self::SecondOrder { frequency_hz, .. } => (lag + (s / (TAU * frequency_hz)).powi(2)).inv(),
        }
    }
}

/// What is electronic at one axis of a bearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisElectronics {
    /// The amplifier.
    pub amplifier: Amplifier,
    /// Delay beyond that of the loop, s.
    pub further_delay_s: f64,
    /// Eddy-current corner, Hz.
    pub eddy_corner_hz: Option<f64>,
    /// Corner of the laminated iron, Hz.
    pub lamination_corner_hz: Option<f64>,
    /// Second-order sensor low-pass, Hz.
    pub sensor_lowpass_hz: Option<f64>,
    /// Factor on the force.
    pub force_factor: f64,
    /// Factor on the signal.
    pub signal_factor: f64,
}

impl AxisElectronics {
    /// Coil current per command at s, rad/s, without the delay of the loop.
    pub(crate) fn coil_current(&self, s: c64) -> c64 {
        self.amplifier.gain(s) * (-s * self.further_delay_s).exp()
    }
}

/// A bearing with its chain after all effects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectiveBearing {
    /// N/A.
    pub ki_n_per_a: f64,
    /// N/m, positive.
    pub ks_n_per_m: f64,
    /// x, y.
    pub axes: [AxisElectronics; 2],
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

impl EffectiveBearing {
    /// Whether x and y do not act on each other and have the same electronics.
    pub(crate) fn axes_are_alike(&self) -> bool {
        let [x, y] = self.axes;
        x == y && self.coupling_ratio == 0.0 && self.sensor_angle_rad == 0.0
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
    /// A moment of the rate of the slope across the plane, times the speed of the rotor.
    Gyroscopic,
}

impl FeedbackLaw {
    /// Force per displacement at a signed frequency, rad/s, in r = x + jy, of a rotor at a speed, rad/s.
    pub fn gain(self, w: f64, speed_rad_s: f64) -> c64 {
        match self {
            Self::Spring => c64::new(-1.0, 0.0),
            Self::Circulatory => c64::new(0.0, 1.0),
            Self::Dashpot => c64::new(0.0, -w),
            Self::Mass => c64::new(w * w, 0.0),
            Self::Gyroscopic => c64::new(-w * speed_rad_s, 0.0),
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
            FeedbackLaw::Mass | FeedbackLaw::Gyroscopic => {}
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
    /// Signal of each axis (rows) per rate of the coil current of each (columns), m s/A.
    pub current_pickup: [[f64; 4]; 4],
    /// Springs, dampers and circulatory laws on the shaft.
    pub attachments: Vec<Attachment>,
    /// Housing modes.
    pub housings: Vec<Housing>,
    /// Laws without a name.
    pub(crate) laws: Vec<PlacedLaw>,
}

impl Effective {
    /// Whether a sensor signal has a share of another.
    pub(crate) fn has_crosstalk(&self) -> bool {
        self.crosstalk.as_flattened().iter().any(|share| *share != 0.0)
    }

    /// Whether a sensor signal has a share of another, or of the rate of a current.
    pub(crate) fn signals_mix(&self) -> bool {
        self.has_crosstalk() || self.has_pickup()
    }

    /// Whether a sensor picks up the rate of a current.
    pub(crate) fn has_pickup(&self) -> bool {
        self.current_pickup.as_flattened().iter().any(|share| *share != 0.0)
    }

    /// The factor 1 + X(jω) of the laws at a site.
    pub(crate) fn law_gain(&self, site: LawSite, omega_rad_s: f64) -> c64 {
        let here = self.laws.iter().filter(|own| own.site == site);
        here.fold(c64::new(1.0, 0.0), |gain, own| gain * (own.law.at(omega_rad_s) + 1.0))
    }

    /// The delay that all axes share, s: the least of theirs.
    pub(crate) fn common_delay_s(&self) -> f64 {
        let further = self.bearings.iter().flat_map(|b| b.axes).map(|axis| axis.further_delay_s);
        self.delay_s + further.fold(f64::INFINITY, f64::min)
    }

    /// Positions of the actuators, front and rear, then of the sensors, m.
    pub(crate) fn planes_m(&self) -> [f64; 4] {
        let [front, rear] = &self.bearings;
        [front.actuator_m, rear.actuator_m, front.sensor_m, rear.sensor_m]
    }
}
