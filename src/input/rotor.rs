//! Rotor YAML (formats.md, section 1): a spindle file without planes, bearings, electronics and speed, with supports in
//! their place, to [`RotorOnSupports`].

use super::by_plane::ByPlane;
use super::disc::{DiscFile, discs};
use super::error::InputError;
use super::error_list::ErrorList;
use super::keys;
use super::shipped::{self, TOOLS};
use super::spindle::{ElementFile, MaterialFile, materials, sections};
use super::tool::read_tool_of;
use super::yaml;
use crate::rotor::{Material, Section, Support};
use crate::spindle::RotorOnSupports;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A rotor without magnets: `muspin modes`, `frf`, `identify`, `update` and `diagnose` take it.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RotorModelFile {
    /// Name of the rotor.
    name: String,
    /// The shaft, from one end (z = 0) to the other.
    rotor: ShaftFile,
    /// False for a model that was built for standstill.
    #[serde(default = "yes")]
    gyroscopics: bool,
    /// Springs and dampers that it stands on or hangs from; none for a free-free rotor.
    #[serde(default)]
    supports: Vec<SupportFile>,
}

fn yes() -> bool {
    true
}

/// The shaft.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ShaftFile {
    /// Materials by name.
    materials: BTreeMap<String, MaterialFile>,
    /// Cylindrical beam elements in the order of the shaft.
    elements: Vec<ElementFile>,
    /// Rigid discs: mass and inertia without stiffness.
    #[serde(default)]
    discs: Option<Vec<DiscFile>>,
    /// Damping ratios of the free-free flexible modes 1, 2, …; the last one serves all higher modes.
    damping_ratio: Vec<f64>,
}

/// A spring with a damper to ground; no stiffness and no damping where they are not given.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct SupportFile {
    /// Place, from the end at z = 0.
    position_m: f64,
    /// Stiffness, in both planes or by plane.
    #[serde(default)]
    stiffness_n_per_m: ByPlane,
    /// Damping, in both planes or by plane.
    #[serde(default)]
    damping_n_s_per_m: ByPlane,
}

/// A rotor from a path, with a tool of a path or shipped name in it, or none.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn load_rotor(source: &str, tool: Option<&str>) -> Result<RotorOnSupports, InputError> {
    let mut rotor = read_rotor(source, &shipped::text(source, "rotor", &[])?)?;
    if let Some(tool) = tool {
        let lent: Vec<Material> = rotor.sections.iter().map(|s: &Section| s.material.clone()).collect();
        rotor.tool = Some(read_tool_of(tool, &shipped::text(tool, "tool", TOOLS)?, lent)?);
    }
    Ok(rotor)
}

/// A rotor without a tool from the text of its file; `file` names it in messages.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn read_rotor(file: &str, text: &str) -> Result<RotorOnSupports, InputError> {
    let mut errors = ErrorList::new(file, text);
    let rotor = yaml::read(&mut errors, keys::ROTOR).map(|read| rotor(&mut errors, read));
    errors.finish(rotor)
}

fn diagonal(values: ByPlane) -> [[f64; 2]; 2] {
    let [x, y] = values.pair();
    [[x, 0.0], [0.0, y]]
}

fn rotor(errors: &mut ErrorList<'_>, read: RotorModelFile) -> RotorOnSupports {
    let file = errors.file;
    let materials = materials(errors, "rotor.materials", read.rotor.materials);
    let supports = read.supports.iter().map(|s| Support {
        position_m: s.position_m,
        stiffness_n_per_m: diagonal(s.stiffness_n_per_m),
        damping_n_s_per_m: diagonal(s.damping_n_s_per_m),
    });
    let rotor = RotorOnSupports {
        name: read.name,
        sections: sections(errors, "rotor.elements", read.rotor.elements, &materials),
        discs: discs(errors, "rotor.discs", read.rotor.discs, &materials),
        damping_ratio: read.rotor.damping_ratio,
        gyroscopics: read.gyroscopics,
        supports: supports.collect(),
        tool: None,
    };
    rotor.broken_rules().iter().for_each(|e| errors.add_rule(InputError::rule(file, e)));
    rotor
}
