//! Tool YAML (formats.md, section 2) to [`Tool`]. Materials are those of the spindle, or the tool's own.

use super::error::InputError;
use super::keys;
use super::name::check_name;
use super::shipped::{self, TOOLS};
use super::spindle::{DiscFile, ElementFile, MaterialFile, discs, materials, sections};
use super::yaml;
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
    let read: ToolFile = yaml::read(file, text, keys::TOOL)?;
    check_name(&read.name).map_err(|rule| {
        InputError::new(file, format!("name: {:?} {rule}", read.name))
            .with_hint("folders, files and C symbols carry the name of the tool, for example endmill-10")
    })?;
    // The tool's own materials come first: they win over the spindle's of the same name.
    let mut known = materials(file, "materials", read.materials)?;
    known.extend(spindle.sections.iter().map(|s| s.material.clone()));
    let tool = Tool {
        name: read.name,
        sections: sections(file, "elements", read.elements, &known)?,
        discs: discs(read.discs),
        tool_plane_m: read.tool_plane_m,
    };
    tool.validate().map_err(|e| InputError::rule(file, &e))?;
    Ok(tool)
}
