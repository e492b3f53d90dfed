//! Designs that start from an earlier one, and those of lower order: what they deliver is judged by the same figures.

use assert_cmd::Command;
use serde_json::Value;
use std::path::{Path, PathBuf};

fn reference(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("results/reference").join(file)
}

/// A design of the updated reference machine with more arguments: exit code and summary.
fn designed(arguments: &[&str], out: &Path) -> (Option<i32>, Value) {
    let output = Command::cargo_bin("muspin")
        .unwrap()
        .args(["design", "--json", "--spindle"])
        .arg(reference("spindle.yaml"))
        .args(arguments)
        .arg("--out")
        .arg(out)
        .output()
        .unwrap();
    let summary = serde_json::from_slice(&output.stdout).unwrap_or(Value::Null);
    (output.status.code(), summary)
}

#[test]
fn a_folder_without_a_design_is_no_start() {
    let temporary = tempfile::tempdir().unwrap();
    let empty = temporary.path().to_string_lossy().into_owned();
    let (code, _) = designed(&["--from", &empty], &temporary.path().join("out"));
    assert_eq!(code, Some(2));
    assert!(!temporary.path().join("out").exists());
}

#[test]
fn the_folder_of_a_tool_of_a_batch_holds_its_controller_itself() {
    let temporary = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = temporary.path().join("endmill-16");
    std::fs::create_dir(&folder).unwrap();
    let law = root.join("tests/data/designs/s09-four-modes/mu.json");
    std::fs::copy(law, folder.join("discrete.json")).unwrap();
    // It is read, and refused because the machine samples at half the rate.
    let output = Command::cargo_bin("muspin")
        .unwrap()
        .args(["design", "--spindle"])
        .arg(root.join("tests/data/spindles/s13-lab-rotor.yaml"))
        .arg("--from")
        .arg(&folder)
        .arg("--out")
        .arg(temporary.path().join("out"))
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2));
    let words = "sampled at 20000.000000 Hz, the machine at 10000.000000 Hz";
    assert!(message.contains(words), "{message}");
}

#[test]
fn an_earlier_design_that_meets_every_goal_is_polished_and_delivered_without_an_iteration() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = reference("").to_string_lossy().into_owned();
    let out = temporary.path().join("out");
    let (code, found) = designed(&["--from", &folder, "--problem"], &out);
    assert_eq!(code, Some(0));
    let design = &found["design"];
    let attempts = design["polish"]["attempts"].as_array().unwrap();
    assert_eq!(attempts.len(), 1);
    assert_eq!(attempts[0]["start"], "earlier design");
    let earlier: Value = serde_json::from_slice(&std::fs::read(reference("summary.json")).unwrap()).unwrap();
    let minimum = |s: &Value| s["stiffness"]["mu"]["minimum_n_per_m"].as_f64().unwrap();
    assert!(minimum(&found) > 0.99 * minimum(&earlier));
    // Nothing is said of what was not run, and all that is of the delivered controller is there.
    let of_the_iteration = ["gamma", "mu_peak", "mu_peak_reduced", "controller_order_full"];
    for key in of_the_iteration {
        assert!(design[key].is_null() && !earlier["design"][key].is_null(), "{key}");
    }
    assert!(design["polish"]["dk"].is_null() && found["stiffness"]["dk"].is_null());
    assert!(!out.join("plots/mu_iterations.svg").exists() && out.join("plots/mu.svg").exists());
    let proof = &design["speed_proof"];
    assert_eq!(proof["complete"], earlier["design"]["speed_proof"]["complete"]);
    assert!(design["largest_mu"].as_f64().unwrap() <= 1.0);
    // The problem files hold the constant scales as D, and the next design finds these in the summary.
    let scales = std::fs::read(out.join("problem/d_scales.json")).unwrap();
    let scales: Value = serde_json::from_slice(&scales).unwrap();
    let (left, constant) = (&scales["left"]["D"], &design["constant_scales"]);
    assert_eq!(left[0][0], constant[0]);
    assert!(scales["left"]["A"].as_array().unwrap().is_empty());
}

/// Tests of several seconds each: `cargo test --release --test it long:: -- --ignored`.
mod long {
    use super::*;

    #[test]
    #[ignore = "long: see the command of the module"]
    fn the_lowest_order_keeps_what_the_curve_says() {
        let temporary = tempfile::tempdir().unwrap();
        let (code, found) = designed(&["--lowest-order"], &temporary.path().join("out"));
        assert_eq!(code, Some(0));
        let design = &found["design"];
        let curve = &design["order_curve"];
        let points = curve["points"].as_array().unwrap();
        assert!(points.len() > 2);
        let order = |p: &Value| p["order"].as_u64().unwrap();
        assert!(points.windows(2).all(|w| order(&w[1]) < order(&w[0])));
        // What is delivered is the lowest order that keeps, and the figures of the closed loop agree with its row.
        assert_eq!(design["controller_order"], curve["lowest_order"]);
        let row = points.iter().find(|p| p["order"] == curve["lowest_order"]).unwrap();
        assert_eq!(row["keeps"], true);
        let [kept, full] = [row, &points[0]].map(|p| p["minimum_n_per_m_at_rest"].as_f64().unwrap());
        assert!(kept >= 0.95 * full, "{kept} of {full}");
        let delivered = found["stiffness"]["mu"]["minimum_n_per_m"].as_f64().unwrap();
        assert!((delivered / kept - 1.0).abs() < 1e-6, "{delivered} {kept}");
    }
}
