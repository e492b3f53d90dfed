//! A spindle, a tool, and the two together: domain values that keep every rule of the file format.
//! Channel order everywhere: front_x, front_y, rear_x, rear_y. z in m from the nose face, the tool at z < 0.

use super::SpindleError;
use super::backup::{BackupBearings, BackupContact};
use super::correction::ModelCorrection;
use super::effective::{Amplifier, AxisElectronics, Effective, EffectiveBearing};
use super::effects::{Effect, EffectKind, Location, action};
use super::rule::{BrokenRules, MOST_DELAY_SAMPLES, rule};
use super::thrust_bearing::ThrustBearing;
use crate::rotor::whirl::{Support, WhirlSpectrum};
use crate::rotor::{Damping, Disc, Rotor, RotorError, Section};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

named! {
    /// A bearing of the spindle.
    pub enum Side {
        /// Next to the tool.
        Front = "front",
        /// Next to the tail.
        Rear = "rear",
    }
}

/// A radial magnetic bearing: f = ki·i + ks·x on the rotor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bearing {
    /// Force per current, N/A.
    pub ki_n_per_a: f64,
    /// Negative stiffness as a positive number, N/m.
    pub ks_n_per_m: f64,
    /// Static capacity, N.
    pub max_force_n: f64,
    /// Bias current, A.
    pub bias_current_a: f64,
    /// Largest coil current, A.
    pub max_current_a: f64,
    /// Air gap, m.
    pub gap_m: f64,
    /// Factor on the sensor signal.
    pub sensor_gain: f64,
}

/// Axial positions, m from the nose face; `planes` of a spindle file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Planes {
    /// Front sensors.
    pub front_sensor_m: f64,
    /// Centre of the front bearing.
    pub front_actuator_m: f64,
    /// Centre of the rear bearing.
    pub rear_actuator_m: f64,
    /// Rear sensors.
    pub rear_sensor_m: f64,
}

impl Planes {
    /// Distance between the magnets, m; the rear one lies behind the front one.
    pub(crate) fn bearing_span_m(&self) -> f64 {
        self.rear_actuator_m - self.front_actuator_m
    }
}

/// Amplifiers, sensors, processor; `electronics` of a spindle file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Electronics {
    /// Bandwidth of the current loop, first order.
    pub amplifier_bandwidth_hz: f64,
    /// Bandwidth of the sensors, first order.
    pub sensor_bandwidth_hz: f64,
    /// Noise of a sensor, rms per axis.
    pub sensor_noise_m: f64,
    /// From sampling to the commanded current, with the hold's half sample.
    pub delay_s: f64,
    /// Sample rate of the controller.
    pub sample_rate_hz: f64,
}

impl Electronics {
    /// Sample period, s.
    pub fn sample_period_s(&self) -> f64 {
        self.sample_rate_hz.recip()
    }
}

/// Band in which the stiffness of the tool counts unless a file says otherwise, Hz: to where tooth passing and its
/// harmonics reach at 50 000 rpm, as the benchmark has it.
pub(crate) const STIFFNESS_BAND_HZ: (f64, f64) = (1.0, 4000.0);

/// A spindle without its tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Spindle {
    /// Name.
    pub name: String,
    /// Elements from the nose face to the tail.
    pub sections: Vec<Section>,
    /// Discs, positions from the nose face.
    pub discs: Vec<Disc>,
    /// Damping ratios of the free-free flexible modes; the last serves all higher modes.
    pub damping_ratio: Vec<f64>,
    /// Flexible modes kept in the design model, per plane.
    pub flexible_modes: usize,
    /// False for a model that was built for standstill.
    pub gyroscopics: bool,
    /// Sensor and actuator planes.
    pub planes: Planes,
    /// Front bearing.
    pub front: Bearing,
    /// Rear bearing.
    pub rear: Bearing,
    /// Electronics.
    pub electronics: Electronics,
    /// Largest speed, rpm.
    pub max_rpm: f64,
    /// Radial clearance of the backup bearings, m.
    pub backup_clearance_m: f64,
    /// What the file says of the contact with them.
    pub backup_bearings: BackupBearings,
    /// The magnet that holds the shaft along its axis, where the file has one.
    pub thrust: Option<ThrustBearing>,
    /// Band in which the dynamic stiffness of the tool counts, Hz.
    pub stiffness_band_hz: (f64, f64),
    /// Where stiffness counts on a shaft without a tool, m from the nose face.
    pub output_m: Option<f64>,
    /// Effects added to the nominal model.
    pub effects: Vec<Effect>,
}

impl Spindle {
    /// Front or rear bearing.
    pub fn bearing(&self, side: Side) -> &Bearing {
        match side {
            Side::Front => &self.front,
            Side::Rear => &self.rear,
        }
    }

    /// The contact with the backup bearings, from the file and from the rotor without its tool.
    ///
    /// # Errors
    /// [`SpindleError`] when the rotor cannot be assembled.
    pub fn backup_contact(&self) -> Result<BackupContact, SpindleError> {
        let rotor = Rotor::new(0.0, self.sections.clone(), &self.discs).map_err(SpindleError::Rotor)?;
        let planes = &self.planes;
        let actuators_m = [planes.front_actuator_m, planes.rear_actuator_m];
        self.backup_bearings.contact(&rotor, actuators_m)
    }

    /// Stiffness of a tool joint, N/m and N m/rad, from its shares of E·d and E·d³, with Young's modulus and the outer
    /// diameter at the nose face.
    pub(crate) fn joint_at_nose(&self, [translation, turning]: [f64; 2]) -> [f64; 2] {
        self.sections.first().map_or([0.0; 2], |section| {
            let diameter_m = section.outer_diameter_m[0];
            let n_per_m = section.material.youngs_modulus_pa * diameter_m;
            [translation * n_per_m, turning * n_per_m * diameter_m * diameter_m]
        })
    }

    /// The same spindle with one more effect.
    pub fn with_effect(&self, effect: Effect) -> Self {
        let mut spindle = self.clone();
        spindle.effects.push(effect);
        spindle
    }
}

/// A tool, holder included.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Name.
    pub name: String,
    /// Elements from the nose face outwards to the tip.
    pub sections: Vec<Section>,
    /// Discs, positions counted outwards from the nose face.
    pub discs: Vec<Disc>,
    /// Distance of the tool plane from the nose face, outwards, m.
    pub tool_plane_m: f64,
    /// Teeth of a cutter; none for a tool without.
    pub teeth: Option<usize>,
}

impl Tool {
    /// What stands in the place of a tool where there is none: no shaft of its own, and on that of the spindle the
    /// place where stiffness counts.
    pub fn absent(output_m: f64) -> Self {
        Self { name: "no tool".into(), sections: vec![], discs: vec![], tool_plane_m: -output_m, teeth: None }
    }

    /// Whether there is none.
    pub fn is_absent(&self) -> bool {
        self.sections.is_empty()
    }

    /// Overhang from the nose face, m.
    pub fn length_m(&self) -> f64 {
        self.sections.iter().map(|s| s.length_m).sum()
    }

    /// Checks every rule of the tool.
    pub(crate) fn validate(&self) -> Result<(), SpindleError> {
        self.broken_rules().into_iter().next().map_or(Ok(()), Err)
    }

    /// Every rule that the tool breaks.
    pub(crate) fn broken_rules(&self) -> Vec<SpindleError> {
        let mut broken = BrokenRules::default();
        // In list order first, so that an error names the element of the file.
        broken.rotor(&self.sections, &self.discs, SpindleError::Tool);
        let length = self.length_m();
        broken.note(rule(
            self.tool_plane_m >= 0.0 && self.tool_plane_m <= length + 1e-6,
            "tool_plane_m".into(),
            self.tool_plane_m,
            &format!("must lie on the tool, between 0 and {length:.6}"),
        ));
        broken.list()
    }

    /// The tool as a shaft at z ≤ 0, tip first.
    pub(super) fn rotor(&self) -> Result<Rotor, SpindleError> {
        let sections = self.sections.iter().rev().map(Section::reverse_ends).collect();
        let discs: Vec<Disc> = self.discs.iter().map(Disc::mirror_ends).collect();
        Rotor::new(-self.length_m(), sections, &discs).map_err(SpindleError::Tool)
    }
}

/// One spindle with one tool: what a model is built from.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// The spindle, effects included.
    pub spindle: Spindle,
    /// The tool in it.
    pub tool: Tool,
    /// A law without a name that acts beside the effects.
    pub(crate) correction: Option<ModelCorrection>,
}

impl Machine {
    /// A spindle with a tool, both validated, effects checked against the two.
    ///
    /// # Errors
    /// [`SpindleError`] with the key path of the first rule that is broken.
    pub fn new(spindle: Spindle, tool: Tool) -> Result<Self, SpindleError> {
        spindle.validate()?;
        if !tool.is_absent() {
            tool.validate()?;
        }
        let machine = Self { spindle, tool, correction: None };
        match machine.broken_effect_rules().into_iter().next() {
            Some(error) => Err(error),
            None => Ok(machine),
        }
    }

    /// The machine of a spindle without a tool. Stiffness counts at its `output_m`, or at the nose face.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn without_tool(mut spindle: Spindle) -> Result<Self, SpindleError> {
        let output_m = *spindle.output_m.get_or_insert(0.0);
        Self::new(spindle, Tool::absent(output_m))
    }

    /// Every rule that the effects break on this machine.
    fn broken_effect_rules(&self) -> Vec<SpindleError> {
        let mut broken = BrokenRules::default();
        for i in 0..self.spindle.effects.len() {
            broken.note(self.check_place(i));
        }
        let places = broken.list();
        if places.is_empty() { self.check_sum_of_effects().err().into_iter().collect() } else { places }
    }

    /// Every rule that a spindle and a tool break together; each keeps its own.
    pub(crate) fn broken_rules(spindle: &Spindle, tool: &Tool) -> Vec<SpindleError> {
        Self { spindle: spindle.clone(), tool: tool.clone(), correction: None }.broken_effect_rules()
    }

    /// The same machine with one more effect. The effect's numbers are checked when a plant is built from it.
    pub fn with_effect(&self, effect: Effect) -> Self {
        Self { spindle: self.spindle.with_effect(effect), ..self.clone() }
    }

    /// Name of files and symbols: that of the tool, or of a spindle without one.
    pub(crate) fn short_name(&self) -> &str {
        if self.tool.is_absent() { &self.spindle.name } else { &self.tool.name }
    }

    /// Position of the tool plane, m (negative), or of the output of a shaft without a tool.
    pub fn tool_plane_m(&self) -> f64 {
        -self.tool.tool_plane_m
    }

    /// The assembled shaft, tool included, with every effect that changes the free-free rotor.
    ///
    /// # Errors
    /// [`SpindleError`] when a part breaks a rule.
    pub fn rotor(&self) -> Result<Rotor, SpindleError> {
        let mut rotor =
            Rotor::new(0.0, self.spindle.sections.clone(), &self.spindle.discs).map_err(SpindleError::Rotor)?;
        if !self.tool.is_absent() {
            let joint = action::joint(&self.spindle.effects);
            rotor = Rotor::join(&self.tool.rotor()?, &rotor, joint).map_err(SpindleError::Shaft)?;
        }
        for effect in self.all_effects() {
            rotor = action::on_rotor(effect, rotor).map_err(SpindleError::Shaft)?;
        }
        Ok(rotor)
    }

    /// Whirl modes of the free-free rotor turning at a speed, up to a frequency: modal damping and gyroscopic factor
    /// after all effects.
    ///
    /// # Errors
    /// [`SpindleError`] when a part breaks a rule or the eigenvalues fail.
    pub fn whirl(&self, speed_rad_s: f64, to_hz: f64) -> Result<WhirlSpectrum, SpindleError> {
        self.whirl_on(&[], speed_rad_s, to_hz)
    }

    /// As [`Machine::whirl`], on supports.
    ///
    /// # Errors
    /// As [`Machine::whirl`].
    pub fn whirl_on(&self, supports: &[Support], speed_rad_s: f64, to_hz: f64) -> Result<WhirlSpectrum, SpindleError> {
        let rotor = self.rotor()?;
        let ratios = (0..rotor.dofs()).map(|k| self.damping_ratio(k)).collect();
        let seen_rad_s = speed_rad_s * self.effective().gyroscopic_factor;
        Ok(rotor.whirl(seen_rad_s, &Damping::Modal(ratios), supports, to_hz)?)
    }

    /// Damping ratio of flexible mode `k`, counted from 0, after all effects.
    pub fn damping_ratio(&self, k: usize) -> f64 {
        let list = &self.spindle.damping_ratio;
        let nominal = list.get(k).or(list.last()).copied().unwrap_or_default();
        action::on_damping_ratio(&self.spindle.effects, k, nominal)
    }

    /// Bearings, chain and additions after all effects.
    pub fn effective(&self) -> Effective {
        let (s, p, e) = (&self.spindle, &self.spindle.planes, &self.spindle.electronics);
        let axis = AxisElectronics {
            amplifier: Amplifier::FirstOrder { bandwidth_hz: e.amplifier_bandwidth_hz },
            further_delay_s: 0.0,
            eddy_corner_hz: None,
            lamination_corner_hz: None,
            sensor_lowpass_hz: None,
            force_factor: 1.0,
            signal_factor: 1.0,
        };
        let nominal = |b: &Bearing, sensor_m, actuator_m| EffectiveBearing {
            ki_n_per_a: b.ki_n_per_a,
            ks_n_per_m: b.ks_n_per_m,
            axes: [axis; 2],
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
            sensor_bandwidth_hz: e.sensor_bandwidth_hz,
            delay_s: e.delay_s,
            gyroscopic_factor: if s.gyroscopics { 1.0 } else { 0.0 },
            loss_time_s: 0.0,
            crosstalk: [[0.0; 4]; 4],
            current_pickup: [[0.0; 4]; 4],
            attachments: vec![],
            housings: vec![],
            laws: vec![],
        };
        for effect in self.all_effects() {
            action::on_machine(effect, &mut all);
        }
        all.laws.extend(self.correction.iter().flat_map(|c| c.laws.clone()));
        all
    }

    /// The effects of the file, then those of a correction.
    fn all_effects(&self) -> impl Iterator<Item = &Effect> {
        self.spindle.effects.iter().chain(self.correction.iter().flat_map(|c| &c.effects))
    }

    /// Effects of one kind, in file order.
    pub(crate) fn of_kind(&self, kind: EffectKind) -> impl Iterator<Item = &Effect> {
        self.spindle.effects.iter().filter(move |e| e.kind == kind)
    }

    /// Regions of spindle and tool, in order of their first element, tool first.
    pub fn regions(&self) -> Vec<String> {
        let mut regions: Vec<String> = vec![];
        let sections = self.tool.sections.iter().chain(&self.spindle.sections);
        for region in sections.filter_map(|s| s.region.as_ref()) {
            if !regions.contains(region) {
                regions.push(region.clone());
            }
        }
        regions
    }

    /// First and last position of the shaft, m.
    fn ends_m(&self) -> [f64; 2] {
        [-self.tool.length_m(), self.spindle.sections.iter().map(|s| s.length_m).sum::<f64>()]
    }

    /// Place of an effect against regions and length of the shaft.
    fn check_place(&self, i: usize) -> Result<(), SpindleError> {
        let effect = &self.spindle.effects[i];
        if self.tool.is_absent() && effect.kind.needs_tool() {
            return Err(SpindleError::Name {
                path: format!("effects[{i}].effect"),
                name: effect.kind.name().into(),
                rule: "needs a tool; there is none in this machine".into(),
            });
        }
        let [start, end] = self.ends_m();
        match &effect.location {
            Location::Region(region) if !self.regions().contains(region) => Err(SpindleError::Name {
                path: format!("effects[{i}].region"),
                name: region.clone(),
                rule: format!("is a region that no element has; there are: {}", self.regions().join(", ")),
            }),
            Location::Position(z) | Location::InPlane(z, _) => rule(
                *z >= start - 1e-6 && *z <= end + 1e-6,
                format!("effects[{i}].position_m"),
                *z,
                &format!("must lie on the rotor, between {start:.6} and {end:.6}"),
            ),
            _ => Ok(()),
        }
    }

    /// The same machine with a correction, whose place must lie on its rotor.
    ///
    /// # Errors
    /// [`SpindleError::Value`] for a place beyond an end.
    pub(crate) fn with_correction(self, correction: ModelCorrection) -> Result<Self, SpindleError> {
        let [start, end] = self.ends_m();
        for z in correction.positions_m() {
            let text = format!("must lie on the rotor, between {start:.6} and {end:.6}");
            rule(z >= start - 1e-6 && z <= end + 1e-6, "place".into(), z, &text)?;
        }
        Ok(Self { correction: Some(correction), ..self })
    }

    /// What all effects together make of planes and delay.
    fn check_sum_of_effects(&self) -> Result<(), SpindleError> {
        if self.spindle.effects.is_empty() {
            return Ok(());
        }
        let [start, end] = self.ends_m();
        let effective = self.effective();
        for bearing in &effective.bearings {
            for z in [bearing.sensor_m, bearing.actuator_m] {
                let ok = z >= start && z <= end + 1e-6;
                let rule_text = "moves a plane off the rotor";
                rule(ok, "effects[0]".into(), z, rule_text)?;
            }
        }
        let total = effective.common_delay_s();
        let least = 0.5 * self.spindle.electronics.sample_period_s();
        rule(
            total >= least * (1.0 - 1e-9) && total <= 2.0 * MOST_DELAY_SAMPLES * least,
            "effects[0]".into(),
            total,
            &format!(
                "is the total delay in s, which must be at least half a sample period and at most {MOST_DELAY_SAMPLES}"
            ),
        )
    }
}

impl From<RotorError> for SpindleError {
    fn from(error: RotorError) -> Self {
        Self::Shaft(error)
    }
}
