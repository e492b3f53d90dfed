//! Tool YAML (formats.md, section 2) to [`Tool`]. Materials are those of the spindle, or the tool's own.

use super::disc::{DiscFile, discs};
use super::error::InputError;
use super::error_list::ErrorList;
use super::keys;
use super::name::check_name;
use super::shipped::{self, TOOLS};
use super::spindle::{ElementFile, MaterialFile, materials, sections};
use super::yaml;
use crate::rotor::Material;
use crate::spindle::{Spindle, Tool};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A tool with its holder, from the nose face outwards.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ToolFile {
    /// Name of the tool; folders and C symbols carry it: letters, digits, spaces and . _ + -.
    name: String,
    /// The tool's own materials; those of the spindle serve as well.
    #[serde(default)]
    materials: BTreeMap<String, MaterialFile>,
    /// Cylindrical beam elements from the nose face to the tip.
    elements: Vec<ElementFile>,
    /// Rigid discs; positions count outwards from the nose face.
    #[serde(default)]
    discs: Option<Vec<DiscFile>>,
    /// Distance of the tool plane, where the cutting force acts, from the nose face.
    tool_plane_m: f64,
    /// Teeth of a cutter: a run then says how deep it may cut.
    #[serde(default)]
    teeth: Option<usize>,
}

/// A tool from a path or a shipped name; `spindle` lends its materials.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn load_tool(source: &str, spindle: &Spindle) -> Result<Tool, InputError> {
    read_tool(source, &shipped::text(source, "tool", TOOLS)?, spindle)
}

/// A tool from the text of a file; `file` names it in messages.
///
/// # Errors
/// [`InputError`] that says what is wrong and where.
pub fn read_tool(file: &str, text: &str, spindle: &Spindle) -> Result<Tool, InputError> {
    read_tool_of(file, text, spindle.sections.iter().map(|s| s.material.clone()).collect())
}

/// As [`read_tool`]; `lent` are the materials of the shaft.
pub(super) fn read_tool_of(file: &str, text: &str, lent: Vec<Material>) -> Result<Tool, InputError> {
    let mut errors = ErrorList::new(file, text);
    let tool = yaml::read(&mut errors, keys::TOOL).map(|read| tool(&mut errors, read, lent));
    errors.finish(tool)
}

/// The tool of a file; what its values break is added to the errors.
fn tool(errors: &mut ErrorList<'_>, read: ToolFile, lent: Vec<Material>) -> Tool {
    let file = errors.file;
    if let Err(rule) = check_name(&read.name) {
        let error = InputError::new(file, format!("name: {:?} {rule}", read.name));
        errors.add(error.with_hint("folders, files and C symbols carry the name of the tool, for example endmill-10"));
    }
    // The tool's own materials come first: they win over the spindle's of the same name.
    let mut known = materials(errors, "materials", read.materials);
    known.extend(lent);
    let tool = Tool {
        name: read.name,
        sections: sections(errors, "elements", read.elements, &known),
        discs: discs(errors, "discs", read.discs, &known),
        tool_plane_m: read.tool_plane_m,
        teeth: read.teeth,
    };
    tool.broken_rules().iter().for_each(|e| errors.add_rule(InputError::rule(file, e)));
    tool
}
