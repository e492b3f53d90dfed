//! Several exported controllers as one table for firmware: `controllers.h` and `controllers.c` beside one folder a
//! controller, with a change at run time that continues the currents.

use super::c::{comment, render};
use super::error::FirmwareError;
use super::firmware::Firmware;
use minijinja::{Value, context};

const HEADER: &str = include_str!("templates/controllers.h");
const SOURCE: &str = include_str!("templates/controllers.c");

/// `controllers.h` and `controllers.c` over controllers that [`crate::export::firmware::write_all`] writes into folders
/// with the names of their prefixes.
///
/// # Errors
/// [`FirmwareError::Table`] when prefixes repeat, or sample times, limits or channels differ.
pub fn controller_table(controllers: &[Firmware<'_>]) -> Result<Vec<(String, Vec<u8>)>, FirmwareError> {
    let Some(first) = controllers.first() else {
        return Ok(Vec::new());
    };
    let (rows, limits) = (&first.scaled.rows, first.scaled.limits);
    for (k, other) in controllers.iter().enumerate() {
        let same = &other.scaled.rows;
        let what = if controllers[..k].iter().any(|c| c.prefix == other.prefix) {
            "the same prefix as another controller; give each its own --prefix"
        } else if (same.sample_time_s - rows.sample_time_s).abs() > 1e-9 * rows.sample_time_s {
            "another sample time than the first; one table runs at one rate"
        } else if other.scaled.limits != limits {
            "other limits of displacement or current than the first; one table serves one spindle"
        } else if same.inputs != rows.inputs || same.outputs.len() != rows.outputs.len() {
            "other channels than the first"
        } else {
            continue;
        };
        return Err(FirmwareError::Table { prefix: other.prefix.to_owned(), what });
    }
    let list: Vec<Value> = controllers
        .iter()
        .map(|c| {
            context! {
                name => c.prefix,
                NAME => c.prefix.to_ascii_uppercase(),
                controller => comment(&c.discrete.name),
                machine => comment(c.machine),
            }
        })
        .collect();
    let values = context! {
        controllers => list,
        kinds => [
            context! { name => "f32", NAME => "F32", value => "float" },
            context! { name => "q31", NAME => "Q31", value => "int32_t" },
        ],
        inputs => rows.inputs.max(1),
        outputs => rows.outputs.len().max(1),
    };
    Ok(vec![
        ("controllers.c".to_owned(), render(SOURCE, values.clone())?.into_bytes()),
        ("controllers.h".to_owned(), render(HEADER, values)?.into_bytes()),
    ])
}
