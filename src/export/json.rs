//! Controller JSON: `{name, inputs, outputs, sample_time_s, machine, A, B, C, D}`, row-major, sample time 0 for
//! continuous time, `machine` only where it is known.
//! Numbers by shortest round trip: reading the file back gives the same bits.

use crate::controller::{ControlLaw, Controller, MachineTag};
use crate::linalg::Mat;
use serde_json::{Map, Value, json};

/// Names of the four axes, in channel order.
pub(crate) const AXIS_NAMES: [&str; 4] = ["front_x", "front_y", "rear_x", "rear_y"];

/// The controller file as bytes, one line, ending in a newline; `machine` is what it was designed for.
pub fn controller_json(controller: &Controller, machine: Option<&MachineTag>) -> Vec<u8> {
    let (a, b, c, d, sample_time_s) = match &controller.law {
        ControlLaw::Continuous(k) => (&k.a, &k.b, &k.c, &k.d, 0.0),
        ControlLaw::Discrete(k) => (&k.a, &k.b, &k.c, &k.d, k.time.period_s),
    };
    let mut object = Map::new();
    object.insert("name".to_owned(), json!(controller.name));
    object.insert("inputs".to_owned(), names(d.ncols()));
    object.insert("outputs".to_owned(), names(d.nrows()));
    object.insert("sample_time_s".to_owned(), json!(sample_time_s));
    if let Some(tag) = machine {
        object.insert("machine".to_owned(), json!({ "spindle": tag.spindle, "tool": tag.tool, "hash": tag.hash }));
    }
    for (key, matrix) in [("A", a), ("B", b), ("C", c), ("D", d)] {
        object.insert(key.to_owned(), rows(matrix));
    }
    let mut bytes = Value::Object(object).to_string().into_bytes();
    bytes.push(b'\n');
    bytes
}

/// Name of one of `channels` channels: a single one is the thrust axis, those beyond the four radial axes are numbered.
pub(crate) fn channel_name(channel: usize, channels: usize) -> String {
    let known: &[&str] = if channels == 1 { &["axial"] } else { &AXIS_NAMES };
    known.get(channel).map_or_else(|| format!("channel_{}", channel + 1), |n| (*n).to_owned())
}

fn names(count: usize) -> Value {
    (0..count).map(|k| channel_name(k, count)).collect::<Vec<_>>().into()
}

/// A matrix as a list of rows.
fn rows(matrix: &Mat<f64>) -> Value {
    (0..matrix.nrows())
        .map(|i| (0..matrix.ncols()).map(|j| matrix[(i, j)]).collect::<Vec<_>>())
        .collect::<Vec<_>>()
        .into()
}
