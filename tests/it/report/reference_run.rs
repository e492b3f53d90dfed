//! The committed reference run: a new run gives the same numbers, two runs give the same bytes at any thread count, and
//! `--timings` lists every part of one.

use crate::support::folder::tree;
use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;

/// Standard output and standard error.
fn run(out: &Path, threads: &str, options: &[&str]) -> [String; 2] {
    let output = Command::cargo_bin("muspin")
        .unwrap()
        .env("RAYON_NUM_THREADS", threads)
        .args(["run", "--out"])
        .arg(out)
        .args(options)
        .output()
        .unwrap();
    let [words, errors] = [output.stdout, output.stderr].map(|t| String::from_utf8(t).unwrap());
    assert_eq!(output.status.code(), Some(0), "{errors}");
    [words, errors]
}

fn figure(summary: &Value, key: &str) -> f64 {
    let value = summary.pointer(&format!("/{}", key.replace('.', "/")));
    value.and_then(Value::as_f64).unwrap_or_else(|| panic!("{key} is missing"))
}

#[test]
fn the_reference_run_reproduces_its_committed_numbers_and_its_own_bytes_and_lists_its_timings() {
    let temporary = tempfile::tempdir().unwrap();
    let (first, second) = (temporary.path().join("first"), temporary.path().join("second"));
    let [words, errors] = run(&first, "1", &[]);
    assert!(errors.is_empty(), "a pipe gets no progress: {errors}");
    let start = std::time::Instant::now();
    let [_, timings] = run(&second, "2", &["--timings"]);
    assert_timings_of_a_run(&timings, start.elapsed().as_secs_f64());
    assert!(words.contains("stable at every speed"), "{words}");
    let (a, b) = (tree(&first), tree(&second));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (name, bytes) in &a {
        assert!(bytes == &b[name], "{name} differs between one and two threads");
    }
    // The page rebuilt from summary and pictures is that of the run: what the page reads survives the file.
    std::fs::remove_file(first.join("report.html")).unwrap();
    let mut rebuild = Command::cargo_bin("muspin").unwrap();
    rebuild.arg("report").arg(&first).assert().success();
    let page = std::fs::read(first.join("report.html")).unwrap();
    assert!(page == a["report.html"], "the rebuilt page differs");
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("results/reference");
    let read =
        |root: &Path| -> Value { serde_json::from_slice(&std::fs::read(root.join("summary.json")).unwrap()).unwrap() };
    let (old, new) = (read(&committed), read(&first));
    // Other processors sum in another order; iterations stop at relative tolerances of 1e-3 in γ.
    for (key, tolerance) in [
        ("updating.modulus_factors.e13", 1e-3),
        ("design.gamma", 2e-3),
        ("design.mu_peak_discrete", 5e-3),
        ("design.table_as_written.mu_peak_discrete", 5e-3),
        ("stiffness.mu.minimum_n_per_m", 1e-2),
        ("stiffness.mu.at_10_hz_n_per_m", 1e-2),
        // A random search that ends near, not at, the optimum.
        ("stiffness.pid.minimum_n_per_m", 5e-2),
    ] {
        let (o, n) = (figure(&old, key), figure(&new, key));
        assert!((n / o - 1.0).abs() < tolerance, "{key}: {n} against {o}");
    }
    assert!(figure(&new, "design.table_as_written.mu_peak_discrete") <= 1.0);
    assert_eq!(new.pointer("/design/speed_proof/complete"), Some(&Value::Bool(true)));
    assert_eq!(figure(&new, "design.speed_proof.proven_to_rpm"), 60e3);
    for row in new.pointer("/design/mu_over_speed").and_then(Value::as_array).unwrap() {
        assert!(figure(row, "mu") <= 1.0, "{row}");
    }
    // The three arithmetics agree: what the coefficients lose is far below what the specification leaves.
    let rows = new.pointer("/design/arithmetic").and_then(Value::as_array).unwrap();
    assert_eq!(rows.len(), 3);
    for row in rows {
        for key in ["mu_peak", "mu_table_as_written", "minimum_stiffness_n_per_m"] {
            assert!((figure(row, key) / figure(&rows[0], key) - 1.0).abs() < 2e-3, "{row}");
        }
    }
    let list = new.pointer("/design/stable_speeds_rpm").unwrap().as_array().unwrap().clone();
    for rpm in [0.0, 10e3, 20e3, 30e3, 40e3, 50e3] {
        assert!(list.iter().any(|v| v.as_f64() == Some(rpm)), "not stable at {rpm} rpm");
    }
    // Published frequencies, each within 0.1 % by both methods; nominal model as the independent one.
    for method in ["", ".nelder_mead"] {
        for key in ["resonances", "antiresonances/front", "antiresonances/rear"] {
            let pointer = format!("/updating{}/errors_percent/{key}", method.replace('.', "/"));
            let errors = new.pointer(&pointer).and_then(Value::as_array).unwrap();
            for e in errors.iter().filter_map(Value::as_f64) {
                assert!(e.abs() < 0.1, "{pointer}: {e} %");
            }
        }
    }
    let nominal = new.pointer("/model/nominal/flexible_frequencies_hz").unwrap();
    for (k, f) in [1165.151, 2304.000, 3425.590].iter().enumerate() {
        let found = nominal[k].as_f64().unwrap();
        // The published digits end at a thousandth of a hertz.
        assert!((found - f).abs() < 6e-4, "{found} against {f}");
    }
}

/// Standard error of `--timings` names every part, and the parts together are nearly all of the time.
fn assert_timings_of_a_run(errors: &str, elapsed_s: f64) {
    let lines: Vec<&str> = errors.lines().collect();
    let named = |part: &&str| lines.iter().any(|line| line.starts_with(*part));
    let parts = ["records", "model updating", "D-K iteration", "PID", "predictions", "report"];
    assert!(parts.iter().all(named), "{errors}");
    assert!(lines[0].starts_with("stage") && lines[lines.len() - 1].starts_with("in all"), "{errors}");
    assert!(lines.iter().skip(1).all(|line| line.ends_with(" s")), "{errors}");
    // The stages together are nearly all of the time; starting the process and printing are the rest.
    let last = lines[lines.len() - 1].trim_start_matches("in all");
    let in_all_s: f64 = last.split_whitespace().next().unwrap().parse().unwrap();
    assert!(in_all_s > 0.9 * elapsed_s && in_all_s < elapsed_s, "{in_all_s} of {elapsed_s}: {errors}");
}
