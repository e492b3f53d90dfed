//! Effects that a spindle file may add to the nominal model: the catalogue, its parameters, and where each acts.
//! Every effect is one kind with a location and numbers; [`EffectKind::parameters`] names the numbers and their units, so
//! files, fits and reports go through one table.

use super::SpindleError;

/// Which bearing an effect sits at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bearings {
    /// The front bearing.
    Front,
    /// The rear bearing.
    Rear,
    /// Both.
    Both,
}

impl Bearings {
    /// Whether bearing 0 (front) or 1 (rear) is meant.
    pub fn includes(self, bearing: usize) -> bool {
        match self {
            Self::Front => bearing == 0,
            Self::Rear => bearing == 1,
            Self::Both => true,
        }
    }

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Rear => "rear",
            Self::Both => "both",
        }
    }

    /// The bearing of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Front, Self::Rear, Self::Both]
            .into_iter()
            .find(|b| b.name() == name)
    }
}

/// Where an effect acts.
#[derive(Clone, Debug, PartialEq)]
pub enum Location {
    /// The machine as a whole, or a place that the kind implies.
    None,
    /// At a bearing (`bearing:` in files).
    Bearing(Bearings),
    /// At an axial position, m from the nose face (`position_m:`).
    Position(f64),
    /// On a flexible mode, counted from 1 (`mode:`).
    Mode(usize),
    /// In an update region (`region:`).
    Region(String),
}

/// What kind of location an effect needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LocationKind {
    /// None.
    None,
    /// `bearing: front | rear | both`.
    Bearing,
    /// `position_m:`.
    Position,
    /// `mode:`.
    Mode,
    /// `region:`.
    Region,
}

/// The catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum EffectKind {
    /// Delay added to the loop.
    LoopDelay,
    /// First-order amplifier bandwidth that replaces the nominal one.
    AmplifierBandwidth,
    /// ki → ki/(1 + √(jω/ω_e)).
    EddyCurrents,
    /// Second-order low-pass in the sensor, ζ = 0.707.
    SensorLowpass,
    /// Axial shift of the sensor plane, + to the rear.
    SensorOffset,
    /// Axial shift of the actuator plane, + to the rear.
    ActuatorOffset,
    /// Factor on ks.
    NegativeStiffness,
    /// Factor on ki.
    ForceConstant,
    /// Factor on the sensor gain.
    SensorGain,
    /// f_x += ε ki i_y and f_y += ε ki i_x.
    BearingCoupling,
    /// Sensor axes turned by an angle: x' = x cos θ + y sin θ, y' = −x sin θ + y cos θ.
    AxisMisalignment,
    /// Factor on the gyroscopic matrix; replaces `gyroscopics: false`.
    Gyroscopic,
    /// Rotating stiffness-proportional damping: βK(ṙ − jΩr).
    InternalDamping,
    /// Circulatory force at a position, f = jq r: q > 0 drives forward whirl.
    CrossCoupling,
    /// Factor on the damping ratio of one flexible mode.
    ModalDamping,
    /// Springs between tool and nose face.
    ToolJoint,
    /// Mass at the tip of the tool.
    ToolMass,
    /// Mass at a position.
    AddedMass,
    /// Stator mass on its foundation, in series with both bearings; sensors ride on it.
    HousingMode,
    /// Factor on the modulus of a region.
    RegionStiffness,
    /// Spring to ground at a position; negative is a pull.
    AddedStiffness,
}

impl EffectKind {
    /// Every kind, in the order of the file format's table.
    pub const ALL: [Self; 21] = [
        Self::LoopDelay,
        Self::AmplifierBandwidth,
        Self::EddyCurrents,
        Self::SensorLowpass,
        Self::SensorOffset,
        Self::ActuatorOffset,
        Self::NegativeStiffness,
        Self::ForceConstant,
        Self::SensorGain,
        Self::BearingCoupling,
        Self::AxisMisalignment,
        Self::Gyroscopic,
        Self::InternalDamping,
        Self::CrossCoupling,
        Self::ModalDamping,
        Self::ToolJoint,
        Self::ToolMass,
        Self::AddedMass,
        Self::HousingMode,
        Self::RegionStiffness,
        Self::AddedStiffness,
    ];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::LoopDelay => "loop_delay",
            Self::AmplifierBandwidth => "amplifier_bandwidth",
            Self::EddyCurrents => "eddy_currents",
            Self::SensorLowpass => "sensor_lowpass",
            Self::SensorOffset => "sensor_offset",
            Self::ActuatorOffset => "actuator_offset",
            Self::NegativeStiffness => "negative_stiffness",
            Self::ForceConstant => "force_constant",
            Self::SensorGain => "sensor_gain",
            Self::BearingCoupling => "bearing_coupling",
            Self::AxisMisalignment => "axis_misalignment",
            Self::Gyroscopic => "gyroscopic",
            Self::InternalDamping => "internal_damping",
            Self::CrossCoupling => "cross_coupling",
            Self::ModalDamping => "modal_damping",
            Self::ToolJoint => "tool_joint",
            Self::ToolMass => "tool_mass",
            Self::AddedMass => "added_mass",
            Self::HousingMode => "housing_mode",
            Self::RegionStiffness => "region_stiffness",
            Self::AddedStiffness => "added_stiffness",
        }
    }

    /// The kind of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|k| k.name() == name)
    }

    /// What location it needs.
    pub fn location(self) -> LocationKind {
        match self {
            Self::AmplifierBandwidth
            | Self::EddyCurrents
            | Self::SensorLowpass
            | Self::SensorOffset
            | Self::ActuatorOffset
            | Self::NegativeStiffness
            | Self::ForceConstant
            | Self::SensorGain
            | Self::BearingCoupling
            | Self::AxisMisalignment => LocationKind::Bearing,
            Self::CrossCoupling | Self::AddedMass | Self::AddedStiffness => LocationKind::Position,
            Self::ModalDamping => LocationKind::Mode,
            Self::RegionStiffness => LocationKind::Region,
            Self::LoopDelay
            | Self::Gyroscopic
            | Self::InternalDamping
            | Self::ToolJoint
            | Self::ToolMass
            | Self::HousingMode => LocationKind::None,
        }
    }

    /// Names of its numbers, units included, in the order of [`Effect::values`].
    pub fn parameters(self) -> &'static [&'static str] {
        match self {
            Self::LoopDelay => &["delay_s"],
            Self::AmplifierBandwidth | Self::SensorLowpass => &["bandwidth_hz"],
            Self::EddyCurrents => &["corner_hz"],
            Self::SensorOffset | Self::ActuatorOffset => &["offset_m"],
            Self::NegativeStiffness
            | Self::ForceConstant
            | Self::SensorGain
            | Self::Gyroscopic
            | Self::ModalDamping
            | Self::RegionStiffness => &["factor"],
            Self::BearingCoupling => &["ratio"],
            Self::AxisMisalignment => &["angle_deg"],
            Self::InternalDamping => &["loss_time_s"],
            Self::CrossCoupling | Self::AddedStiffness => &["stiffness_n_per_m"],
            Self::ToolJoint => &[
                "translational_n_per_m",
                "rotational_n_m_per_rad",
                "damping_n_m_s_per_rad",
            ],
            Self::ToolMass | Self::AddedMass => &["mass_kg"],
            Self::HousingMode => &["mass_kg", "frequency_hz", "damping_ratio"],
        }
    }

    /// Whether parameter `i` must be positive for the model to make sense.
    fn must_be_positive(self, i: usize) -> bool {
        match self {
            Self::AmplifierBandwidth
            | Self::EddyCurrents
            | Self::SensorLowpass
            | Self::ForceConstant
            | Self::SensorGain
            | Self::ModalDamping
            | Self::RegionStiffness => true,
            Self::ToolJoint => i < 2,
            Self::HousingMode => i < 2,
            _ => false,
        }
    }
}

/// One effect of a spindle file.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// What it is.
    pub kind: EffectKind,
    /// Where it acts.
    pub location: Location,
    /// Its numbers, in the order and units of [`EffectKind::parameters`].
    pub values: Vec<f64>,
}

impl Effect {
    /// An effect that keeps the rules of its kind.
    ///
    /// # Errors
    /// [`SpindleError::Value`] or [`SpindleError::Name`] with a path relative to the effect.
    pub fn new(
        kind: EffectKind,
        location: Location,
        values: Vec<f64>,
    ) -> Result<Self, SpindleError> {
        let effect = Self {
            kind,
            location,
            values,
        };
        effect.validate()?;
        Ok(effect)
    }

    /// The value of the parameter of that name; `None` when the kind has none.
    pub fn value(&self, parameter: &str) -> Option<f64> {
        let names = self.kind.parameters();
        let i = names.iter().position(|name| *name == parameter)?;
        self.values.get(i).copied()
    }

    /// The same effect with other numbers.
    pub fn with_values(&self, values: &[f64]) -> Self {
        Self {
            values: values.to_vec(),
            ..self.clone()
        }
    }

    /// Checks location and numbers against the kind.
    ///
    /// # Errors
    /// As [`Effect::new`].
    pub fn validate(&self) -> Result<(), SpindleError> {
        let matches = matches!(
            (self.kind.location(), &self.location),
            (LocationKind::None, Location::None)
                | (LocationKind::Bearing, Location::Bearing(_))
                | (LocationKind::Position, Location::Position(_))
                | (LocationKind::Mode, Location::Mode(_))
                | (LocationKind::Region, Location::Region(_))
        );
        if !matches {
            return Err(SpindleError::Name {
                path: "effect".into(),
                name: self.kind.name().into(),
                rule: match self.kind.location() {
                    LocationKind::None => "takes no location".into(),
                    LocationKind::Bearing => "needs bearing: front, rear or both".into(),
                    LocationKind::Position => "needs position_m".into(),
                    LocationKind::Mode => "needs mode, counted from 1".into(),
                    LocationKind::Region => "needs region".into(),
                },
            });
        }
        if let Location::Mode(0) = self.location {
            return Err(SpindleError::Value {
                path: "mode".into(),
                value: 0.0,
                rule: "must be 1 or more: flexible modes are counted from 1".into(),
            });
        }
        let names = self.kind.parameters();
        if names.len() != self.values.len() {
            return Err(SpindleError::Name {
                path: "effect".into(),
                name: self.kind.name().into(),
                rule: format!("needs the parameters {}", names.join(", ")),
            });
        }
        for (i, (name, value)) in names.iter().zip(&self.values).enumerate() {
            let rule = if !value.is_finite() {
                "must be a number"
            } else if self.kind.must_be_positive(i) && *value <= 0.0 {
                "must be positive"
            } else {
                continue;
            };
            return Err(SpindleError::Value {
                path: (*name).into(),
                value: *value,
                rule: rule.into(),
            });
        }
        Ok(())
    }
}
