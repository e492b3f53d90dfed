//! The problem files of a design: `muspin solve` reads them and finds what the design printed; frequency responses between
//! magnets and tool.

use assert_cmd::Command;
use muspin::controller::ControlLaw;
use muspin::input::load_controller;
use muspin::linalg::{Mat, c64, solve_complex};
use muspin::lti::HeldResponse;
use serde_json::Value;
use std::f64::consts::TAU;
use std::path::Path;

fn muspin() -> Command {
    Command::new(env!("CARGO_BIN_EXE_muspin"))
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

fn solved(kind: &str, file: &Path) -> Value {
    let output = muspin().args(["solve", kind]).arg(file).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{kind}: {text}");
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn the_solvers_find_in_the_problem_files_what_the_design_printed() {
    let place = tempfile::tempdir().unwrap();
    let out = place.path().join("design");
    muspin().args(["design", "--no-polish", "--problem", "--out"]).arg(&out).assert().code(0);
    let problem = out.join("problem");
    let printed = &json(&out.join("summary.json"))["design"];
    // The certificate of the specification closed with the delivered controller: the design takes the larger of it and
    // of the exact responses at rest.
    let found = solved("musys", &problem.join("closed_loop.json"));
    let (upper, own) =
        (found["peak_upper"].as_f64().unwrap(), printed["table_as_written"]["mu_peak_discrete"].as_f64().unwrap());
    assert!(upper <= own * (1.0 + 1e-6) && upper > 0.98 * own, "{upper} {own}");
    // γ of the scaled plant is that of the last synthesis: D_L P D_R⁻¹ with the scales of the files.
    let p = json(&problem.join("synthesis.json"));
    let scales = json(&problem.join("d_scales.json"));
    let order = |system: &Value| system["A"].as_array().unwrap().len();
    assert_eq!(order(&scales["left"]), 0, "the reference ends with constant scales");
    let entry = |m: &Value, i: usize, j: usize| m[i][j].as_f64().unwrap();
    let (left, right) = (&scales["left"]["D"], &scales["right_inverse"]["D"]);
    let (p1, m1) = (p["p1"].as_u64().unwrap() as usize, p["m1"].as_u64().unwrap() as usize);
    let mut scaled = p.clone();
    for (name, width) in [("C", order(&p)), ("D", m1 + p["m2"].as_u64().unwrap() as usize)] {
        for i in 0..p1 {
            for j in 0..width {
                scaled[name][i][j] = (entry(left, i, i) * entry(&p[name], i, j)).into();
            }
        }
    }
    for (name, height) in [("B", order(&p)), ("D", p1 + p["p2"].as_u64().unwrap() as usize)] {
        for i in 0..height {
            for j in 0..m1 {
                scaled[name][i][j] = (entry(&scaled[name], i, j) * entry(right, j, j)).into();
            }
        }
    }
    scaled.as_object_mut().unwrap().remove("blocks");
    let file = place.path().join("scaled.json");
    std::fs::write(&file, scaled.to_string()).unwrap();
    let gamma = solved("hinfsyn", &file)["gamma"].as_f64().unwrap();
    let own = printed["gamma"].as_f64().unwrap();
    // Both searches stop within 1e-3 of the optimum.
    assert!((gamma / own - 1.0).abs() < 2e-3, "{gamma} {own}");
    assert!(problem.join("problem.mat").is_file() && problem.join("weights.json").is_file());
}

#[test]
fn the_closed_loop_compliance_follows_from_the_open_paths() {
    let start = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/cli/start");
    let controller = start.join("pid.json");
    let law = load_controller(controller.to_str().unwrap()).unwrap().law;
    let table = |extra: &[&str]| {
        let mut command = muspin();
        command.args(["frf", "--points", "7", "--from", "5", "--to", "2000", "--speeds", "3000"]);
        command.arg("--spindle").arg(start.join("spindle.yaml"));
        command.arg("--tool").arg(start.join("tool.yaml")).args(extra);
        let output = command.output().unwrap();
        let mut table = csv::Reader::from_reader(output.stdout.as_slice());
        let header = table.headers().unwrap().clone();
        let rows = table.records().map(|r| r.unwrap()).collect::<Vec<_>>();
        move |k: usize, name: &str| {
            let part = |end: &str| {
                let entry = format!("{name}_{end}");
                let place = header.iter().position(|h| *h == entry).unwrap();
                rows[k][place].parse::<f64>().unwrap()
            };
            (rows[k][0].parse::<f64>().unwrap(), c64::new(part("re"), part("im")))
        }
    };
    let open = table(&["--tool-paths"]);
    let closed = table(&["--controller", controller.to_str().unwrap()]);
    const TOOL: [&str; 2] = ["x", "y"];
    for line in 0..7 {
        let (hz, _) = open(line, "t_xx");
        let k = match &law {
            ControlLaw::Discrete(law) => law.held_at(TAU * hz),
            ControlLaw::Continuous(law) => law.held_at(TAU * hz),
        };
        let matrix = |rows: usize, columns: usize, name: &dyn Fn(usize, usize) -> String| {
            Mat::from_fn(rows, columns, |i, j| open(line, &name(i, j)).1)
        };
        let g = matrix(4, 4, &|i, j| format!("g_{}{}", i + 1, j + 1));
        let t = matrix(2, 2, &|i, j| format!("t_{}{}", TOOL[i], TOOL[j]));
        let tu = matrix(2, 4, &|i, j| format!("tu_{}{}", TOOL[i], j + 1));
        let yf = matrix(4, 2, &|i, j| format!("yf_{}{}", i + 1, TOOL[j]));
        // x = T f + P_tu u, y = P_yf f + G u, u = K y: x = (T + P_tu K (I − G K)⁻¹ P_yf) f.
        let loops = Mat::<c64>::identity(4, 4) - &g * &k;
        let expected = &t + &tu * &k * solve_complex(&loops, &yf);
        for i in 0..2 {
            for j in 0..2 {
                let (_, found) = closed(line, &format!("t_{}{}", TOOL[i], TOOL[j]));
                let size = expected[(0, 0)].norm();
                assert!((found - expected[(i, j)]).norm() < 1e-9 * size, "{hz} {i} {j}");
            }
        }
    }
}
