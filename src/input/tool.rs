//! Tool YAML (formats.md, section 2) to [`Tool`]. Materials are those of the spindle, or the tool's own.

use super::error::InputError;
use super::keys;
use super::shipped::{self, TOOLS};
use super::spindle::{DiscFile, ElementFile, MaterialFile, discs, materials, sections};
use super::yaml;
use crate::spindle::{Spindle, Tool};
use serde::Deserialize;
use std::collections::BTreeMap;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ToolFile {
    name: String,
    #[serde(default)]
    materials: BTreeMap<String, MaterialFile>,
    elements: Vec<ElementFile>,
    #[serde(default)]
    discs: Option<Vec<DiscFile>>,
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
