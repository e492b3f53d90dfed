//! Second-order sections of a decentralised controller as tables for the filters of CMSIS-DSP and of TI's Digital
//! Control Library, in the sign conventions of each.

use super::c::{comment, render};
use super::error::FirmwareError;
use super::json::channel_name;
use super::rows::hex_float;
use crate::controller::ControllerError;
use crate::controller::sections::{Section, cascades};
use crate::lti::{Discrete, StateSpace};
use minijinja::{Value, context};

const HEADER: &str = include_str!("templates/sections.h");

/// `sections.h`; nothing for a controller that mixes axes.
///
/// # Errors
/// From the eigenvalue iterations.
pub(crate) fn section_tables(
    law: &StateSpace<Discrete>,
    prefix: &str,
    controller: &str,
) -> Result<Option<String>, FirmwareError> {
    let cascades = match cascades(law) {
        Err(ControllerError::NotDecentralised { .. }) => return Ok(None),
        other => other?,
    };
    let axes: Vec<Value> = cascades
        .iter()
        .enumerate()
        .map(|(k, sections)| {
            let name = channel_name(k);
            context! {
                NAME => name.to_uppercase(),
                name,
                count => sections.len(),
                cmsis => sections.iter().map(|s| numbers(s, -1.0)).collect::<Vec<_>>(),
                dcl => sections.iter().map(|s| numbers(s, 1.0)).collect::<Vec<_>>(),
            }
        })
        .collect();
    Ok(Some(render(
        HEADER,
        context! {
            name => prefix,
            NAME => prefix.to_ascii_uppercase(),
            controller => comment(controller),
            axes,
        },
    )?))
}

/// b₀, b₁, b₂, ±a₁, ±a₂ as C literals.
fn numbers(section: &Section, sign: f64) -> String {
    let [a1, a2] = section.a;
    section.b.into_iter().chain([sign * a1, sign * a2]).map(|c| hex_float(c as f32)).collect::<Vec<_>>().join(", ")
}
