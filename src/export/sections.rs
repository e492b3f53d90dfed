//! Second-order sections of a decentralised controller as tables for the filters of CMSIS-DSP and of TI's Digital
//! Control Library, in the sign conventions of each.

use super::c::{comment, render};
use super::error::FirmwareError;
use super::json::channel_name;
use super::rows::{hex_double, hex_float};
use crate::controller::ControllerError;
use crate::controller::sections::{AxisTable, Precision, SectionBiquad, axis_tables};
use crate::lti::{Discrete, StateSpace};
use minijinja::{Value, context};

const HEADER: &str = include_str!("templates/sections.h");

/// The header of the tables, and what a reader should know about axes without a table in single precision.
pub(super) struct SectionTables {
    /// `sections.h`; nothing for a controller that mixes axes, or where no axis has a table.
    pub header: Option<String>,
    /// A sentence an axis whose table is in double precision, or missing.
    pub notes: Vec<String>,
}

/// The tables of a controller, each compared with its axis as it is held.
pub(super) fn section_tables(
    law: &StateSpace<Discrete>,
    prefix: &str,
    controller: &str,
) -> Result<SectionTables, FirmwareError> {
    let tables = match axis_tables(law) {
        Err(ControllerError::NotDecentralised { .. }) => return Ok(SectionTables { header: None, notes: vec![] }),
        other => other?,
    };
    let count = tables.len();
    let notes: Vec<String> =
        tables.iter().enumerate().filter_map(|(k, table)| note(&channel_name(k, count), table)).collect();
    if tables.iter().all(Result::is_err) {
        return Ok(SectionTables { header: None, notes });
    }
    let axes = |precision: Precision| -> Vec<Value> {
        let all =
            tables.iter().enumerate().filter_map(|(k, table)| Some((channel_name(k, count), table.as_ref().ok()?)));
        let period_s = law.time.period_s;
        all.filter(|(_, table)| table.precision == precision)
            .map(|(name, table)| axis(&name, table, period_s))
            .collect()
    };
    let header = render(
        HEADER,
        context! {
            name => prefix,
            NAME => prefix.to_ascii_uppercase(),
            controller => comment(controller),
            single => axes(Precision::Single),
            double => axes(Precision::Double),
            notes => notes.iter().map(|n| comment(n)).collect::<Vec<_>>(),
        },
    )?;
    Ok(SectionTables { header: Some(header), notes })
}

fn axis(name: &str, table: &AxisTable, period_s: f64) -> Value {
    let lines = |sign: f64| table.sections.iter().map(|s| numbers(s, sign, table.precision)).collect::<Vec<_>>();
    context! {
        NAME => name.to_uppercase(),
        name,
        count => table.sections.len(),
        cmsis => lines(-1.0),
        dcl => lines(1.0),
        change => format!("{:.1e}", table.change.relative),
        frequency => format!("{:.3}", table.change.frequency_hz(period_s)),
    }
}

/// What is to be said about the sections of an axis.
fn note(name: &str, table: &Result<AxisTable, String>) -> Option<String> {
    match table {
        Ok(AxisTable { remark: Some(remark), .. }) => Some(format!(
            "sections.h, axis {name}: {remark}; the table of the second-order sections is in double precision \
             (arm_biquad_cascade_df2T_f64). controller.c holds the controller in float32"
        )),
        Ok(_) => None,
        Err(reason) => Some(format!(
            "sections.h, axis {name}: no table of second-order sections: {reason}; use controller.c, or split the \
             axis at its slow poles"
        )),
    }
}

/// b₀, b₁, b₂, ±a₁, ±a₂ as C literals.
fn numbers(section: &SectionBiquad, sign: f64, precision: Precision) -> String {
    let literal = |c: f64| match precision {
        Precision::Single => hex_float(c as f32),
        Precision::Double => hex_double(c),
    };
    let [a1, a2] = section.a;
    section.b.into_iter().chain([sign * a1, sign * a2]).map(literal).collect::<Vec<_>>().join(", ")
}
