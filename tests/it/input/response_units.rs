//! Accelerometers in tables: a record in another unit is the same record in m.

use muspin::input::load_measurement;
use muspin::input::sweep::header;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

const LINES_HZ: [f64; 4] = [20.0, 55.0, 140.0, 900.0];

/// A response in m, and times (jω)^order over the size of a unit, as real and imaginary part.
fn in_unit(line: usize, channel: usize, order: i32, unit: f64) -> [f64; 2] {
    let hz = LINES_HZ[line];
    let (re, im) = (1e-6 * (line + 1) as f64, -3e-7 * (channel + 1) as f64);
    let factor = (TAU * hz).powi(order) / unit;
    // Times j, order by order.
    match order {
        0 => [re * factor, im * factor],
        1 => [-im * factor, re * factor],
        _ => [-re * factor, -im * factor],
    }
}

fn write(folder: &Path, order: i32, unit: f64, key: &str) -> String {
    let mut sweep = header().join(",") + "\n";
    let mut hammer = "frequency_hz,h_re,h_im\n".to_owned();
    for (l, hz) in LINES_HZ.iter().enumerate() {
        for e in 0..4 {
            let currents = (0..4).map(|j| if j == e { "0.1,0" } else { "0,0" });
            let signals = (0..4).map(|i| in_unit(l, 4 * e + i, order, unit).map(|x| format!("{x:e}")).join(","));
            let row: Vec<String> = currents.map(str::to_owned).chain(signals).collect();
            let _ = writeln!(sweep, "{hz},{},1,{}", e + 1, row.join(","));
        }
        let [re, im] = in_unit(l, 0, order, unit);
        let _ = writeln!(hammer, "{hz},{re:e},{im:e}");
    }
    std::fs::write(folder.join("sweep.csv"), sweep).unwrap();
    std::fs::write(folder.join("hammer.csv"), hammer).unwrap();
    let list = format!(
        "spindle: reference\ntool: paper-tool\nrecords:\n  - {{kind: sweep, file: sweep.csv, speed_rpm: 0{key}}}\n  \
         - {{kind: hammer, file: hammer.csv, speed_rpm: 0{key}}}\n"
    );
    std::fs::write(folder.join("measurement.yaml"), list).unwrap();
    folder.to_str().unwrap().to_owned()
}

#[test]
fn a_record_in_another_unit_is_the_same_record() {
    let folder = tempfile::tempdir().unwrap();
    let exact = load_measurement(&write(folder.path(), 0, 1.0, "")).unwrap();
    // Standard gravity as in CODATA.
    let units = [(0, 1e-6, "µm"), (1, 1e-3, "mm/s"), (2, 1.0, "m/s²"), (2, 1e-3, "mm/s^2"), (2, 9.80665, "g")];
    for (order, unit, label) in units {
        let read = load_measurement(&write(folder.path(), order, unit, &format!(", unit: {label}"))).unwrap();
        for (a, b) in read.sweeps[0].record.signal.iter().zip(&exact.sweeps[0].record.signal) {
            assert!((a - b).norm() < 1e-12 * b.norm(), "{label} {a} {b}");
        }
        assert_eq!(read.sweeps[0].record.current, exact.sweeps[0].record.current);
        for (a, b) in read.hammers[0].frf.compliance.iter().zip(&exact.hammers[0].frf.compliance) {
            assert!((a - b).norm() < 1e-12 * b.norm(), "{label} {a} {b}");
        }
    }
}

#[test]
fn a_unit_that_is_none_of_a_response_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for label in ["N", "furlong", "m/s^3", "m/N"] {
        let error = load_measurement(&write(folder.path(), 0, 1.0, &format!(", unit: {label}"))).unwrap_err();
        let words = error.to_string();
        assert!(words.contains("measurement.yaml") && words.contains("records[0].unit"), "{words}");
    }
    // A hammer test may say what its response is over.
    let path = write(folder.path(), 0, 1.0, "");
    let list = std::fs::read_to_string(folder.path().join("measurement.yaml")).unwrap();
    let over = list.replacen("hammer.csv, speed_rpm: 0", "hammer.csv, speed_rpm: 0, unit: m/N", 1);
    std::fs::write(folder.path().join("measurement.yaml"), over).unwrap();
    assert!(load_measurement(&path).is_ok());
    std::fs::write(folder.path().join("shapes.csv"), "mode,position_m,amplitude\n1,0,1\n").unwrap();
    let other = list + "  - {kind: mode_shapes, file: shapes.csv, unit: mm}\n";
    std::fs::write(folder.path().join("measurement.yaml"), other).unwrap();
    assert!(load_measurement(&path).unwrap_err().to_string().contains("records[2].unit"));
}
