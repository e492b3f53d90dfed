//! Reading of the control reference cases under tests/data/control.

use muspin::augment::Block;
use muspin::linalg::{Mat, c64};
use muspin::lti::{Continuous, StateSpace};
use serde_json::Value;

pub struct Case {
    pub id: String,
    pub data: Value,
    pub reference: Value,
    pub tolerance: Value,
}

impl Case {
    pub fn all(class: &str) -> Vec<Self> {
        let folder = format!("{}/tests/data/control/{class}", env!("CARGO_MANIFEST_DIR"));
        let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
        paths.sort();
        paths
            .iter()
            .map(|path| {
                let text = std::fs::read_to_string(path).unwrap();
                let json: Value = serde_json::from_str(&text).unwrap();
                Self {
                    id: json["id"].as_str().unwrap().to_owned(),
                    data: json["data"].clone(),
                    reference: json["reference"].clone(),
                    tolerance: json["tolerance"].clone(),
                }
            })
            .collect()
    }

    pub fn named(class: &str, id: &str) -> Self {
        let mut all = Self::all(class);
        let k = all.iter().position(|c| c.id.ends_with(id)).unwrap();
        all.swap_remove(k)
    }
}

pub fn number_list(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap();
    list.iter().map(|v| v.as_f64().unwrap()).collect()
}

pub fn real_matrix(value: &Value) -> Mat<f64> {
    let rows: Vec<Vec<f64>> = value.as_array().unwrap().iter().map(number_list).collect();
    let cols = rows.first().map_or(0, Vec::len);
    Mat::from_fn(rows.len(), cols, |i, j| rows[i][j])
}

pub fn complex_matrix(value: &Value) -> Mat<c64> {
    let (re, im) = (real_matrix(&value["re"]), real_matrix(&value["im"]));
    Mat::from_fn(re.nrows(), re.ncols(), |i, j| c64::new(re[(i, j)], im[(i, j)]))
}

pub fn block_list(value: &Value) -> Vec<Block> {
    let size = |b: &Value, key: &str| b[key].as_u64().unwrap() as usize;
    let list = value.as_array().unwrap().iter();
    list.map(|b| match b["type"].as_str().unwrap() {
        "complex_full" => Block::ComplexFull { rows: size(b, "rows"), cols: size(b, "cols") },
        "complex_scalar" => Block::ComplexScalar { n: size(b, "n") },
        _ => Block::RealScalar { n: size(b, "n") },
    })
    .collect()
}

pub fn system(data: &Value) -> StateSpace<Continuous> {
    let part = |key: &str| real_matrix(&data[key]);
    StateSpace::new(part("A"), part("B"), part("C"), part("D"), Continuous).unwrap()
}
