//! Reference cases of tests/data/control, and `muspin solve` on them. References come from multi-precision arithmetic.

use assert_cmd::Command;
use muspin::linalg::{Mat, c64};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// One reference case.
pub struct Case {
    pub name: String,
    pub path: PathBuf,
    pub json: Value,
}

/// All cases of a class, sorted by name; at least `at_least` of them.
pub fn cases(class: &str, at_least: usize) -> Vec<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/control").join(class);
    let mut list: Vec<Case> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| {
            let path = entry.unwrap().path();
            Case {
                name: path.file_stem().unwrap().to_str().unwrap().to_string(),
                json: serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap(),
                path,
            }
        })
        .collect();
    list.sort_by(|a, b| a.name.cmp(&b.name));
    assert!(list.len() >= at_least, "{class}: {} cases", list.len());
    list
}

/// Standard output of `muspin solve` as JSON.
pub fn answer(kind: &str, path: &Path) -> Value {
    let output = Command::cargo_bin("muspin").unwrap().args(["solve", kind]).arg(path).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}: {error}", path.display());
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Message of `muspin solve` on a problem that must fail: exit 2, nothing on standard output, within a second.
pub fn refusal(kind: &str, problem: &str) -> String {
    let mut file = tempfile::Builder::new().suffix(".json").tempfile().unwrap();
    std::io::Write::write_all(&mut file, problem.as_bytes()).unwrap();
    let start = Instant::now();
    let output = Command::cargo_bin("muspin").unwrap().args(["solve", kind]).arg(file.path()).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(output.stdout.is_empty());
    assert!(start.elapsed() < Duration::from_secs(1), "{error}");
    assert!(error.starts_with("error: "), "{error}");
    error
}

/// A number of a JSON value.
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// A row-major matrix of a JSON value.
pub fn matrix(value: &Value) -> Mat<f64> {
    let rows = value.as_array().unwrap();
    let cols = rows.first().map_or(0, |r| r.as_array().unwrap().len());
    Mat::from_fn(rows.len(), cols, |i, j| number(&rows[i][j]))
}

/// A complex matrix `{re, im}` of a JSON value; the two parts are picked by the caller.
pub fn complex(re: &Value, im: &Value) -> Mat<c64> {
    let (re, im) = (matrix(re), matrix(im));
    Mat::from_fn(re.nrows(), re.ncols(), |i, j| c64::new(re[(i, j)], im[(i, j)]))
}
