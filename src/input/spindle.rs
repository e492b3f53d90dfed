//! Spindle YAML (formats.md, section 1) to [`Spindle`]; the file's shapes of materials, elements, discs and effects.

use super::by_plane::ByPlane;
use super::disc::{DiscFile, discs};
use super::effect::EffectFile;
use super::error::{InputError, nearest};
use super::error_list::ErrorList;
use super::keys;
use super::rotor_kind::is_rotor_tree;
use super::shipped::{self, SPINDLES};
use super::yaml;
use crate::rotor::{Material, Section};
use crate::spindle::machine::STIFFNESS_BAND_HZ;
use crate::spindle::{
    BackupBearings, Bearing, Effect, EffectKind, Electronics, Location, Plane, Planes, Spindle, ThrustBearing,
};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A spindle: rotor, magnetic bearings, electronics.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SpindleFile {
    /// Name of the spindle in reports and measurement folders.
    name: String,
    /// The shaft, from the nose face (z = 0) to the tail; z grows to the rear.
    rotor: RotorFile,
    /// False for a model that was built for standstill.
    #[serde(default = "yes")]
    gyroscopics: bool,
    /// Axial positions of sensors and actuators, from the nose face.
    planes: Planes,
    /// The two radial magnetic bearings; the force on the rotor is ki·i + ks·x.
    bearings: BearingsFile,
    /// Amplifiers, sensors, sampling.
    electronics: Electronics,
    /// Speed range.
    speed: SpeedFile,
    /// Radial clearance of the backup bearings.
    backup_clearance_m: f64,
    /// Contact of the rotor with the backup bearings, for time responses.
    backup_bearings: Option<BackupBearings>,
    /// The magnet that holds the shaft along its axis; `design` makes a controller for it beside the radial one.
    #[serde(default)]
    thrust: Option<ThrustBearing>,
    /// Band in which the dynamic stiffness of the tool counts, in designs and predictions.
    #[serde(default)]
    stiffness_band: Option<StiffnessBandFile>,
    /// Where stiffness counts on a shaft without a tool, from the nose face: the place of an impeller or a wheel.
    #[serde(default)]
    output_m: Option<f64>,
    /// Effects that a diagnosis has added to the model; a list of `{effect: name, its place, its parameters}`.
    #[serde(default)]
    effects: Option<Vec<EffectFile>>,
}

/// Most effects of a file: there are some twenty kinds and some ten places.
const MOST_EFFECTS: usize = 500;

fn yes() -> bool {
    true
}

fn one() -> f64 {
    1.0
}

fn one_in_both() -> ByPlane {
    ByPlane::Both(1.0)
}

/// The shaft.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RotorFile {
    /// Materials by name.
    materials: BTreeMap<String, MaterialFile>,
    /// Cylindrical beam elements in the order of the shaft.
    elements: Vec<ElementFile>,
    /// Rigid discs: mass and inertia without stiffness.
    #[serde(default)]
    discs: Option<Vec<DiscFile>>,
    /// Damping ratios of the free-free flexible modes 1, 2, …; the last one serves all higher modes.
    damping_ratio: Vec<f64>,
    /// Flexible modes that the design model keeps in each plane, besides two rigid-body modes.
    flexible_modes: usize,
}

/// A material as files write it.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialFile {
    /// Young's modulus.
    youngs_modulus_pa: f64,
    /// Density.
    density_kg_m3: f64,
    /// Poisson's ratio.
    poisson_ratio: f64,
}

/// An element as files write it.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ElementFile {
    /// Length.
    length_m: f64,
    /// Outer diameter that counts for stiffness.
    outer_diameter_m: f64,
    /// Bore.
    #[serde(default)]
    inner_diameter_m: f64,
    /// Name of a material.
    material: String,
    /// Outer diameter that counts for mass, for laminations; `outer_diameter_m` unless given.
    mass_outer_diameter_m: Option<f64>,
    /// Inner diameter that counts for mass; `inner_diameter_m` unless given.
    mass_inner_diameter_m: Option<f64>,
    /// Factor on Young's modulus, and on the shear modulus with it.
    #[serde(default = "one")]
    modulus_scale: f64,
    /// Update region: elements of one name share one factor on the modulus.
    region: Option<String>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BearingsFile {
    /// The bearing at the nose.
    front: BearingFile,
    /// The bearing at the tail.
    rear: BearingFile,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BearingFile {
    /// Force per control current, on both axes or by axis.
    ki_n_per_a: ByPlane,
    /// Negative stiffness, as a positive number, on both axes or by axis.
    ks_n_per_m: ByPlane,
    /// Largest force per axis.
    max_force_n: f64,
    /// Bias current.
    bias_current_a: f64,
    /// Largest coil current.
    max_current_a: f64,
    /// Air gap.
    gap_m: f64,
    /// Factor on the signals of its sensors, on both axes or by axis.
    #[serde(default = "one_in_both")]
    #[schemars(extend("default" = 1.0))]
    sensor_gain: ByPlane,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SpeedFile {
    /// Top speed.
    max_rpm: f64,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct StiffnessBandFile {
    /// First frequency; 1 Hz unless given.
    from_hz: Option<f64>,
    /// Last frequency; 4000 Hz unless given.
    to_hz: Option<f64>,
}

/// A spindle from a path or a shipped name.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn load_spindle(source: &str) -> Result<Spindle, InputError> {
    read_spindle(source, &shipped::text(source, "spindle", SPINDLES)?)
}

/// A spindle from the text of a file; `file` names it in messages.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn read_spindle(file: &str, text: &str) -> Result<Spindle, InputError> {
    if yaml::value(file, text).is_ok_and(|tree| is_rotor_tree(&tree)) {
        let rule = "has no planes, bearings, electronics and speed: it is a rotor without magnets";
        return Err(InputError::new(file, rule).with_hint(
            "`muspin modes`, `frf`, `identify` and `update` take such a rotor; all else needs the magnets",
        ));
    }
    let mut errors = ErrorList::new(file, text);
    let spindle = yaml::read(&mut errors, keys::SPINDLE).map(|read| spindle(&mut errors, read));
    errors.finish(spindle)
}

/// The spindle of a file; what its values break is added to the errors.
fn spindle(errors: &mut ErrorList<'_>, read: SpindleFile) -> Spindle {
    let file = errors.file;
    let materials = materials(errors, "rotor.materials", read.rotor.materials);
    let bearing = |b: &BearingFile| Bearing {
        ki_n_per_a: b.ki_n_per_a.mean(),
        ks_n_per_m: b.ks_n_per_m.mean(),
        max_force_n: b.max_force_n,
        bias_current_a: b.bias_current_a,
        max_current_a: b.max_current_a,
        gap_m: b.gap_m,
        sensor_gain: b.sensor_gain.mean(),
    };
    let effects = read.effects.unwrap_or_default();
    if effects.len() > MOST_EFFECTS {
        let rule = format!("effects: has {} entries, at most {MOST_EFFECTS} are read", effects.len());
        errors.add(InputError::new(file, rule).with_hint("keep the effects that the records need"));
    }
    let effects = effects.into_iter().enumerate().take(MOST_EFFECTS);
    let mut effects: Vec<Effect> = effects.filter_map(|(i, e)| errors.take_rule(e.effect(file, i))).collect();
    for (name, bearing) in [("front", &read.bearings.front), ("rear", &read.bearings.rear)] {
        for (key, values) in [("ki_n_per_a", bearing.ki_n_per_a), ("sensor_gain", bearing.sensor_gain)] {
            if values.is_by_plane() && values.pair().into_iter().any(|value| value <= 0.0) {
                let rule = format!("bearings.{name}.{key}: x and y must both be given, as positive numbers");
                errors.add_rule(InputError::new(file, rule).with_hint("one number serves both"));
            }
        }
    }
    effects.extend(differences_of_axes(&read.bearings, &read.planes));
    let spindle = Spindle {
        sections: sections(errors, "rotor.elements", read.rotor.elements, &materials),
        discs: discs(errors, "rotor.discs", read.rotor.discs, &materials),
        damping_ratio: read.rotor.damping_ratio,
        flexible_modes: read.rotor.flexible_modes,
        gyroscopics: read.gyroscopics,
        planes: read.planes,
        front: bearing(&read.bearings.front),
        rear: bearing(&read.bearings.rear),
        electronics: read.electronics,
        max_rpm: read.speed.max_rpm,
        backup_clearance_m: read.backup_clearance_m,
        backup_bearings: read.backup_bearings.unwrap_or_default(),
        thrust: read.thrust,
        stiffness_band_hz: read.stiffness_band.map_or(STIFFNESS_BAND_HZ, |b| {
            let (from, to) = STIFFNESS_BAND_HZ;
            (b.from_hz.unwrap_or(from), b.to_hz.unwrap_or(to))
        }),
        output_m: read.output_m,
        effects,
        name: read.name,
    };
    spindle.broken_rules().iter().for_each(|e| errors.add_rule(InputError::rule(file, e)));
    spindle
}

/// What the axes of the bearings have beside their mean, as the effects that say the same of a machine.
fn differences_of_axes(bearings: &BearingsFile, planes: &Planes) -> Vec<Effect> {
    let mut found = vec![];
    let places = [(&bearings.front, planes.front_actuator_m), (&bearings.rear, planes.rear_actuator_m)];
    for (b, (bearing, actuator_m)) in places.into_iter().enumerate() {
        for plane in Plane::ALL {
            let axis = plane as usize;
            for (kind, values) in
                [(EffectKind::ForceConstant, bearing.ki_n_per_a), (EffectKind::SensorGain, bearing.sensor_gain)]
            {
                let factor = values.pair()[axis] / values.mean();
                found.push((kind, Location::Axis(2 * b + axis), factor, factor != 1.0));
            }
            let spring_n_per_m = bearing.ks_n_per_m.mean() - bearing.ks_n_per_m.pair()[axis];
            let place = Location::InPlane(actuator_m, plane);
            found.push((EffectKind::AddedStiffness, place, spring_n_per_m, spring_n_per_m != 0.0));
        }
    }
    let differing = found.into_iter().filter(|(.., differs)| *differs);
    // A number that breaks a rule of the bearing is said there.
    differing.filter_map(|(kind, place, value, _)| Effect::new(kind, place, vec![value]).ok()).collect()
}

/// Materials by name, checked; steel in the place of one that is wrong.
pub(super) fn materials(errors: &mut ErrorList<'_>, path: &str, read: BTreeMap<String, MaterialFile>) -> Vec<Material> {
    let positive = |x: f64| x.is_finite() && x > 0.0;
    let mut materials = vec![];
    for (name, m) in read {
        let rules = [
            ("youngs_modulus_pa", m.youngs_modulus_pa, positive(m.youngs_modulus_pa), "must be a positive number"),
            ("density_kg_m3", m.density_kg_m3, positive(m.density_kg_m3), "must be a positive number"),
            (
                "poisson_ratio",
                m.poisson_ratio,
                m.poisson_ratio > -1.0 && m.poisson_ratio <= 0.5,
                "must lie between -1 and 0.5",
            ),
        ];
        for (key, value, _, rule) in rules.iter().filter(|(_, _, holds, _)| !holds) {
            let error = InputError::new(errors.file, format!("{path}.{name}.{key}: {value} {rule}"));
            errors.add_rule(error.with_hint("correct the value; the file format gives units in the key"));
        }
        materials.push(if rules.iter().all(|(_, _, holds, _)| *holds) {
            Material::isotropic(&name, m.youngs_modulus_pa, m.density_kg_m3, m.poisson_ratio)
        } else {
            substitute(&name)
        });
    }
    materials
}

/// Steel under the name of a material that is wrong, so that the elements of it can be judged.
fn substitute(name: &str) -> Material {
    Material::isotropic(name, 2.1e11, 7850.0, 0.3)
}

/// Elements with their materials resolved.
pub(super) fn sections(
    errors: &mut ErrorList<'_>,
    path: &str,
    read: Vec<ElementFile>,
    materials: &[Material],
) -> Vec<Section> {
    let mut sections = Vec::with_capacity(read.len());
    for (i, e) in read.into_iter().enumerate() {
        let known = materials.iter().find(|m| m.name == e.material);
        if known.is_none() {
            let near = nearest(&e.material, materials.iter().map(|m| m.name.as_str()));
            let rule = format!("{path}[{i}].material: there is no material {:?}", e.material);
            errors.add(InputError::new(errors.file, rule).with_hint(match near {
                Some(name) => format!("did you mean `{name}`? Materials stand under `materials:`"),
                None => "add it under `materials:`".to_owned(),
            }));
        }
        let material = known.cloned().unwrap_or_else(|| substitute(&e.material));
        let mut section = Section::cylinder(e.length_m, e.outer_diameter_m, e.inner_diameter_m, material);
        section.mass_outer_diameter_m = [e.mass_outer_diameter_m.unwrap_or(e.outer_diameter_m); 2];
        section.mass_inner_diameter_m = [e.mass_inner_diameter_m.unwrap_or(e.inner_diameter_m); 2];
        section.modulus_scale = e.modulus_scale;
        section.region = e.region;
        sections.push(section);
    }
    sections
}
