//! Problems and answers of a design as JSON in the formats of `muspin solve`, and as one `.mat` file.

use super::error::FirmwareError;
use super::mat::mat_file;
use crate::augment::{Block, GeneralizedPlant};
use crate::linalg::Mat;
use crate::lti::{StateSpace, TimeBase};
use crate::pipeline::problem_set::ProblemSet;
use serde_json::{Value, json};

/// Files by name: `synthesis.json` and `specification.json` (`muspin solve hinfsyn` and `dksyn`), `closed_loop.json`
/// (`muspin solve musys`), `controller.json`, `weights.json`, `d_scales.json`, and all of them in `problem.mat`.
pub(crate) fn problem_files(set: &ProblemSet) -> Result<Vec<(String, Vec<u8>)>, FirmwareError> {
    let loops = &set.closed_loop;
    let mut closed = system(loops);
    closed["n"] = loops.order().into();
    closed["m"] = loops.inputs().into();
    closed["p"] = loops.outputs().into();
    closed["blocks"] = blocks(&set.specification.blocks);
    let files = [
        ("synthesis.json", problem(&set.synthesis)),
        ("specification.json", problem(&set.specification)),
        ("closed_loop.json", closed),
        ("controller.json", system(&set.controller)),
        ("weights.json", json!({ "input": system(&set.input_weights), "output": system(&set.output_weights) })),
        ("d_scales.json", json!({ "left": system(&set.d_left), "right_inverse": system(&set.d_right_inverse) })),
    ];
    let mut all: Vec<(String, Vec<u8>)> =
        files.into_iter().map(|(name, value)| (name.to_owned(), format!("{value}\n").into_bytes())).collect();
    let named = [
        ("P", &set.synthesis.system),
        ("S", &set.specification.system),
        ("N", &set.closed_loop),
        ("K", &set.controller),
        ("Wi", &set.input_weights),
        ("Wo", &set.output_weights),
        ("DL", &set.d_left),
        ("DRi", &set.d_right_inverse),
    ];
    let names: Vec<[String; 4]> =
        named.iter().map(|(name, _)| ["A", "B", "C", "D"].map(|part| format!("{name}_{part}"))).collect();
    let matrices: Vec<(&str, &Mat<f64>)> = names
        .iter()
        .zip(&named)
        .flat_map(|(names, (_, s))| {
            let parts = [&s.a, &s.b, &s.c, &s.d];
            names.iter().map(String::as_str).zip(parts)
        })
        .collect();
    all.push(("problem.mat".to_owned(), mat_file(&matrices)?));
    Ok(all)
}

/// A generalized plant in the format of `muspin solve dksyn`.
fn problem(plant: &GeneralizedPlant) -> Value {
    let mut value = system(&plant.system);
    value["n"] = plant.system.order().into();
    value["m1"] = plant.disturbances().into();
    value["m2"] = plant.controls.into();
    value["p1"] = plant.errors().into();
    value["p2"] = plant.measurements.into();
    value["blocks"] = blocks(&plant.blocks);
    value
}

fn system<T: TimeBase>(s: &StateSpace<T>) -> Value {
    json!({ "A": rows(&s.a), "B": rows(&s.b), "C": rows(&s.c), "D": rows(&s.d) })
}

fn rows(m: &Mat<f64>) -> Value {
    let row = |i: usize| (0..m.ncols()).map(|j| m[(i, j)]).collect::<Vec<f64>>();
    json!((0..m.nrows()).map(row).collect::<Vec<_>>())
}

fn blocks(list: &[Block]) -> Value {
    let one = |block: &Block| match block {
        Block::ComplexFull { rows, cols } => {
            json!({ "type": "complex_full", "rows": rows, "cols": cols })
        }
        Block::ComplexScalar { n } => json!({ "type": "complex_scalar", "n": n }),
        Block::RealScalar { n } => json!({ "type": "real_scalar", "n": n }),
    };
    Value::Array(list.iter().map(one).collect())
}
