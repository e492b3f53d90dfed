//! Every format that muspin reads, with the function that reads it.

use muspin::input::problem::ProblemFields;
use muspin::input::{hammer, load_spindle, mat, measurement, sweep, time_record};
use muspin::input::{read_controller, read_spindle, read_tool, read_weights};
use muspin::spindle::Spindle;
use std::path::Path;
use std::sync::OnceLock;

/// Formats by name.
pub const FORMATS: [&str; 13] = [
    "spindle",
    "tool",
    "weights",
    "frequencies",
    "measurement",
    "sweep",
    "hammer",
    "mode_shapes",
    "controller",
    "uff",
    "mat",
    "wav",
    "solve",
];

/// Reads bytes as a format; the error message if they are refused.
pub fn read(format: &str, bytes: &[u8]) -> Result<(), String> {
    let text = || muspin::input::shipped::utf8("file", bytes.to_vec()).map_err(|e| e.to_string());
    let told = |e: muspin::input::InputError| e.to_string();
    match format {
        "spindle" => read_spindle("file", &text()?).map(drop).map_err(told),
        "tool" => read_tool("file", &text()?, reference()).map(drop).map_err(told),
        "weights" => read_weights("file", &text()?).map(drop).map_err(told),
        "frequencies" => measurement::read_frequencies("file", &text()?).map(drop).map_err(told),
        "measurement" => measurement::read_list("file", &text()?).map_err(told),
        "sweep" => sweep::read_sweep("file", bytes, 0.0).map(drop).map_err(told),
        "hammer" => hammer::read_hammer("file", bytes, 0.0).map(drop).map_err(told),
        "mode_shapes" => hammer::read_mode_shapes("file", bytes).map(drop).map_err(told),
        "controller" => read_controller("file", &text()?).map(drop).map_err(told),
        "uff" => hammer::read_hammer("file.uff", bytes, 0.0).map(drop).map_err(told),
        "mat" => mat::read_controller("file", bytes).map(drop).map_err(told),
        "wav" => time_record::read_time_record("file.wav", bytes).map(drop).map_err(told),
        "solve" => ProblemFields::parse(Path::new("file"), &text()?).map_err(told).and_then(|p| solve(&p)),
        other => Err(format!("file: no format {other}")),
    }
}

fn solve(problem: &ProblemFields) -> Result<(), String> {
    problem.system().map(drop).map_err(|e| e.to_string())?;
    if problem.has("m1") {
        problem.generalized_plant().map(drop).map_err(|e| e.to_string())?;
    }
    Ok(())
}

fn reference() -> &'static Spindle {
    static REFERENCE: OnceLock<Spindle> = OnceLock::new();
    REFERENCE.get_or_init(|| load_spindle("reference").expect("the shipped spindle"))
}
