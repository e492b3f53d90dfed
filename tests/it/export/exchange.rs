//! Controllers as MATLAB files in and out, pictures with the axes that the page reads values from, loop diagrams.

use crate::cli::program::muspin;
use muspin::controller::ControlLaw;
use muspin::input::mat::matrices;
use muspin::input::{load_controller, load_machine};
use muspin::linalg::{Mat, c64};
use muspin::lti::{FrequencyGrid, Response};
use muspin::predict::closed_loop::sensitivity;
use muspin::predict::disc_margins::DiscMargins;
use muspin::predict::loop_gain::LoopGain;
use muspin::predict::loop_shape::{LoopShape, unbalance_response};
use muspin::report::plot::figure::{Axis, Figure, Panel, Series};
use muspin::report::plot::{Color, Dash, Look, picture};
use muspin::spindle::{ModelDetail, Plant};
use serde_json::Value;
use std::f64::consts::TAU;
use std::path::PathBuf;

fn here() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

const PID: &str = "tests/data/anti_windup/pid.json";
const SPINDLE: &str = "tests/data/anti_windup/spindle.yaml";
const TOOL: &str = "tests/data/anti_windup/tool.yaml";

/// A level-5 file as MATLAB writes it: one matrix of doubles an element, compressed or not.
fn mat_file(matrices: &[(&str, usize, usize, &[f64])], compressed: bool) -> Vec<u8> {
    let element = |kind: u32, data: &[u8]| {
        let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        bytes.extend_from_slice(data);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    };
    let words = |list: &[u32]| list.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>();
    let mut file = vec![b' '; 124];
    file.extend_from_slice(&[0, 1, b'I', b'M']);
    for (name, rows, columns, values) in matrices {
        // Whole numbers are stored in bytes, as MATLAB does.
        let small = values.iter().all(|x| x.fract() == 0.0 && (0.0..256.0).contains(x));
        let numbers = if small {
            element(2, &values.iter().map(|x| *x as u8).collect::<Vec<u8>>())
        } else {
            element(9, &values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>())
        };
        let parts = [
            element(6, &words(&[6, 0])),
            element(5, &words(&[*rows as u32, *columns as u32])),
            element(1, name.as_bytes()),
            numbers,
        ];
        let whole = element(14, &parts.concat());
        if compressed {
            use std::io::Write;
            let mut encoder = flate2::write::ZlibEncoder::new(vec![], flate2::Compression::default());
            encoder.write_all(&whole).unwrap();
            let packed = encoder.finish().unwrap();
            file.extend([15u32.to_le_bytes(), (packed.len() as u32).to_le_bytes()].concat());
            file.extend(packed);
        } else {
            file.extend(whole);
        }
    }
    file
}

#[test]
fn a_controller_from_matlab_is_read_compressed_or_not() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("k.mat");
    let a = [-1.5, 0.25, 2.0, -3.0];
    let b = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
    let c = [0.5; 8];
    let d = [0.0; 16];
    for compressed in [false, true] {
        let all: [(&str, usize, usize, &[f64]); 5] =
            [("A", 2, 2, &a), ("B", 2, 4, &b), ("C", 4, 2, &c), ("D", 4, 4, &d), ("Ts", 1, 1, &[0.0])];
        std::fs::write(&file, mat_file(&all, compressed)).unwrap();
        let found = load_controller(file.to_str().unwrap()).unwrap();
        let ControlLaw::Continuous(k) = found.law else { panic!("Ts = 0 is continuous time") };
        // Columns of the file are columns of the matrix.
        assert_eq!([k.a[(0, 0)], k.a[(1, 0)], k.a[(0, 1)], k.a[(1, 1)]], a);
        assert_eq!((k.b[(0, 0)], k.b[(1, 1)], k.b[(1, 0)]), (1.0, 1.0, 0.0));
        assert_eq!(k.c[(3, 1)], 0.5);
        // A matrix that is missing is named.
        std::fs::write(&file, mat_file(&all[..3], compressed)).unwrap();
        let (code, out, error) = muspin(&["check", file.to_str().unwrap()], &here());
        assert_eq!((code, out.as_str()), (2, ""), "{error}");
    }
}

#[test]
fn what_export_writes_as_mat_is_the_controller_again() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("o");
    let out = out.to_str().unwrap();
    let arguments = ["export", "--controller", PID, "--spindle", SPINDLE, "--tool", TOOL, "--out", out];
    let (code, _, error) = muspin(&arguments, &here());
    assert_eq!(code, 0, "{error}");
    let mats = std::fs::read_dir(out).unwrap().map(|e| e.unwrap().path());
    let mat = mats.into_iter().find(|p| p.extension().is_some_and(|e| e == "mat")).unwrap();
    let json = format!("{out}/discrete.json");
    let (a, b) = (load_controller(mat.to_str().unwrap()).unwrap(), load_controller(&json).unwrap());
    let (ControlLaw::Discrete(a), ControlLaw::Discrete(b)) = (a.law, b.law) else { panic!("sampled") };
    assert_eq!(a.time, b.time);
    assert!((0..a.order()).all(|i| (0..a.order()).all(|j| a.a[(i, j)] == b.a[(i, j)])));
    assert!((0..4).all(|i| (0..a.order()).all(|j| a.c[(i, j)] == b.c[(i, j)] && a.b[(j, i)] == b.b[(j, i)])));
    let frf = |controller: &str| {
        let arguments = ["frf", "--controller", controller, "--spindle", SPINDLE, "--tool", TOOL, "--points", "4"];
        muspin(&arguments, &here())
    };
    let (one, two) = (frf(mat.to_str().unwrap()), frf(&json));
    assert_eq!((one.0, one.1), (two.0, two.1));
}

#[test]
fn damaged_mat_files_are_refused_without_a_panic() {
    let a = [1.0; 4];
    let whole = mat_file(&[("A", 2, 2, &a), ("Ts", 1, 1, &[0.0])], true);
    for length in 0..whole.len() {
        let _ = matrices("cut", &whole[..length]);
    }
    for k in 0..whole.len() {
        let mut other = whole.clone();
        other[k] ^= 0x5a;
        let _ = matrices("changed", &other);
    }
    assert_eq!(matrices("whole", &whole).unwrap()[0].values.as_deref(), Some(&a[..]));
}

/// The metadata of a picture give back the values of its curve from the points that are drawn.
#[test]
fn axes_in_a_picture_give_the_values_of_its_points() {
    let x: Vec<f64> = (0..40).map(|k| 10f64.powf(1.0 + f64::from(k) / 13.0)).collect();
    let y: Vec<f64> = x.iter().map(|x| 3.0 + x.ln()).collect();
    let mut panel = Panel::new("", Axis::log("Frequency", "Hz"), Axis::linear("Height", "µm"));
    panel.series.push(Series::curve("one", &x, &y, Look::line(Color::Blue, Dash::Solid)));
    let svg = picture(&Figure::new("t", "d", vec![panel])).unwrap().svg;
    let text = svg.split_once("<metadata>").unwrap().1.split_once("</metadata>").unwrap().0;
    let axes: Value = serde_json::from_str(&text.replace("&quot;", "\"").replace("&amp;", "&")).unwrap();
    let panel = &axes[0];
    let r: Vec<f64> = panel["r"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    let number = |axis: &str, k: usize| panel[axis][k].as_f64().unwrap();
    assert_eq!(panel["x"][3], "Frequency");
    assert_eq!(panel["y"][4], "µm");
    let points = svg
        .split("points=\"")
        .skip(1)
        .map(|p| p.split('"').next().unwrap())
        .find(|p| p.split_whitespace().count() == x.len())
        .expect("the curve");
    for (k, point) in points.split_whitespace().enumerate() {
        let (px, py) = point.split_once(',').unwrap();
        let (px, py): (f64, f64) = (px.parse().unwrap(), py.parse().unwrap());
        let across = (px - r[0]) / (r[2] - r[0]);
        let up = (r[3] - py) / (r[3] - r[1]);
        let vx = number("x", 1) * (number("x", 2) / number("x", 1)).powf(across);
        let vy = number("y", 1) + up * (number("y", 2) - number("y", 1));
        // Points are rounded to a third of a pixel of some 800.
        assert!((vx / x[k] - 1.0).abs() < 0.01, "{vx} {}", x[k]);
        assert!((vy - y[k]).abs() < 0.03, "{vy} {}", y[k]);
    }
}

/// det(I − G K) is the product of 1 + λ over the characteristic loci, and the disc margin the inverse of the largest
/// gain of S.
#[test]
fn characteristic_loci_and_disc_margin_belong_to_the_loop() {
    let machine = load_machine(SPINDLE, TOOL).unwrap();
    let controller = load_controller(PID).unwrap();
    let plant = Plant::new(&machine, 0.0, ModelDetail::Full).unwrap();
    let lines: Vec<f64> = (0..60).map(|k| 10.0 * 300f64.powf(f64::from(k) / 59.0)).collect();
    let shape = LoopShape::new(&plant, &controller, &lines).unwrap();
    let mut least = f64::INFINITY;
    for (k, hz) in lines.iter().enumerate() {
        let loci: Vec<c64> = shape.loci.iter().map(|l| l[k]).collect();
        let g = plant.at(TAU * hz).submatrix(0, 0, 4, 4).to_owned();
        let held = muspin::lti::HeldResponse::held_at(&controller, TAU * hz);
        let trace: c64 = (0..4).map(|i| (0..4).map(|j| g[(i, j)] * held[(j, i)]).sum::<c64>()).sum();
        let sum: c64 = loci.iter().sum();
        assert!((sum + trace).norm() < 1e-9 * (1.0 + trace.norm()), "{hz} Hz: {sum} {trace}");
        // |1 + λ| is never below the smallest singular value of I + L.
        least = least.min(loci.iter().map(|l| (l + 1.0).norm()).fold(f64::INFINITY, f64::min));
    }
    assert!(least > 0.0);
}

/// One channel: α = 2 min |1 + L|/|1 − L| with L opened there. All at once: less than any channel alone, and at least
/// what the unscaled singular value grants.
#[test]
fn disc_margins_are_those_of_the_loop_gain_and_lie_between_their_bounds() {
    let machine = load_machine(SPINDLE, TOOL).unwrap();
    let controller = load_controller(PID).unwrap();
    let plant = Plant::new(&machine, 0.0, ModelDetail::Full).unwrap();
    let grid = FrequencyGrid::log_hz(10.0, 3000.0, 200);
    let found = DiscMargins::new(&plant, &controller, &grid).unwrap();
    let gain = LoopGain::new(&plant, &controller, &grid);
    for (channel, own) in found.channels.iter().enumerate() {
        let ratio = |l: &c64| 2.0 * (l + 1.0).norm() / (l - 1.0).norm();
        let alpha = gain.channels[channel].iter().map(ratio).fold(f64::INFINITY, f64::min);
        assert!((own.alpha / alpha - 1.0).abs() < 1e-9, "{own:?} {alpha}");
        let (least, most) = own.gain_margin();
        assert!((least * most - 1.0).abs() < 1e-12 && most > 1.0, "{own:?}");
        for together in [&found.together, &found.together_by_sensitivity] {
            assert!(together.alpha <= 2.0 * own.alpha && together.alpha > 0.0);
        }
        assert!(found.together.alpha <= own.alpha * (1.0 + 1e-9), "{found:?}");
    }
    let unscaled = grid.omega_rad_s().iter().map(|w| {
        let s = sensitivity(&plant, &controller, *w);
        let half = Mat::from_fn(4, 4, |i, j| s[(i, j)] - if i == j { 0.5 } else { 0.0 });
        half.singular_values().unwrap()[0].recip()
    });
    let unscaled = unscaled.fold(f64::INFINITY, f64::min);
    assert!(found.together.alpha >= unscaled * (1.0 - 1e-9), "{found:?} {unscaled}");
}

/// At low speed the unbalance moves the tool by U Ω² times the static compliance at the tool.
#[test]
fn the_unbalance_response_is_the_compliance_at_the_speed() {
    let machine = load_machine(SPINDLE, TOOL).unwrap();
    let controller = load_controller(PID).unwrap();
    let rpm = 3000.0;
    let found = unbalance_response(&machine, &controller, &[rpm]).unwrap()[0];
    let arguments = [
        "frf",
        "--controller",
        PID,
        "--spindle",
        SPINDLE,
        "--tool",
        TOOL,
        "--speed",
        "3000",
        "--from",
        "50",
        "--to",
        "50",
        "--points",
        "1",
        "--json",
    ];
    let (code, out, error) = muspin(&arguments, &here());
    assert_eq!(code, 0, "{error}");
    let columns: Value = serde_json::from_str(&out).unwrap();
    let entry = |name: &str| {
        c64::new(columns[format!("{name}_re")][0].as_f64().unwrap(), columns[format!("{name}_im")][0].as_f64().unwrap())
    };
    let h = entry("t_xx") - c64::new(0.0, 1.0) * entry("t_xy");
    let expected = h.norm() * (rpm * TAU / 60.0).powi(2);
    assert!((found[0] / expected - 1.0).abs() < 1e-9, "{} {expected}", found[0]);
}
