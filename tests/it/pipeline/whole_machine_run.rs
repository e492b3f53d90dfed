//! Every figure of a finished run, read from its `summary.json`, against the second road of [`crate::support`].
//!
//! The committed reference run is held in every test run. The polished design of the reference spindle is made anew and
//! held, and the spindles of `tests/data/spindles` are run and held, by
//!
//! ```text
//! cargo test --release --test it whole_machine_run -- --ignored --nocapture
//! ```
//!
//! which takes a minute of a core for each; `MUSPIN_SPINDLES=s04,s09` restricts it to names that begin so.

use crate::support::controller::Law;
use crate::support::figures::{Loop, zone};
use crate::support::files::{SpindleFile, ToolFile, WeightsFile, below_root, read_yaml};
use crate::support::robustness::Specification;
use crate::support::rotor::Rotor;
use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;

/// Spindle and the tool it carries.
const PAIRS: [(&str, &str); 6] = [
    ("s01-short-fast", "endmill-6"),
    ("s04-noncollocated", "endmill-12-long"),
    ("s06-strong-ks", "endmill-16"),
    ("s09-four-modes", "endmill-16"),
    ("s12-big-discs", "test-arbor"),
    ("s13-lab-rotor", "endmill-6"),
];
/// Band of stiffness and sensitivity, Hz, and its end in shares of the sample rate.
const BAND_HZ: (f64, f64) = (1.0, 4000.0);
const BAND_END: f64 = 0.49;
/// Speeds at which the proven range is looked at.
const PROOF_SPEEDS: usize = 41;

/// A run with what the second road says of it.
struct Run {
    summary: Value,
    weights: WeightsFile,
    flexible_modes: usize,
    wrong: Vec<String>,
    held: usize,
}

impl Run {
    fn figure(&self, pointer: &str) -> Option<f64> {
        self.summary.pointer(pointer).and_then(Value::as_f64)
    }

    /// Notes a figure that is further from the truth than `tolerance`. One that is not stated is noted as well.
    fn hold(&mut self, pointer: &str, truth: f64, tolerance: f64) {
        self.held += 1;
        match self.figure(pointer) {
            Some(stated) if (stated - truth).abs() <= tolerance => (),
            Some(stated) => self.wrong.push(format!("{pointer}: {stated} stated, {truth} true")),
            None => self.wrong.push(format!("{pointer}: not stated, {truth} true")),
        }
    }

    /// Notes a certified bound that is below the truth by more than `below` of it or above it by more than `above`.
    fn hold_bound(&mut self, pointer: &str, truth: f64, below: f64, above: f64) {
        self.held += 1;
        match self.figure(pointer) {
            Some(stated) if stated >= truth * (1.0 - below) && stated <= truth * (1.0 + above) => {}
            stated => self.wrong.push(format!("{pointer}: {stated:?} stated, {truth} true")),
        }
    }

    fn stability(&mut self, rotor: &Rotor, law: &Law) {
        let speeds = "/design/certificates/verification/speeds";
        let count = self.summary.pointer(speeds).and_then(Value::as_array).map_or(0, Vec::len);
        for k in (0..count).step_by(3) {
            let rpm = self.figure(&format!("{speeds}/{k}/speed_rpm")).unwrap();
            let growth = Loop::new(rotor, law, rpm).growth_rate_per_s();
            // Modes beyond 24 kHz move a pole by about 1e-3 of its decay.
            let tolerance = 5e-3 * growth.abs() + 0.05;
            self.hold(&format!("{speeds}/{k}/growth_rate_per_s"), growth, tolerance);
        }
        let proven = self.figure("/design/speed_proof/proven_to_rpm").unwrap_or(f64::NAN);
        for k in 0..PROOF_SPEEDS {
            let rpm = proven * k as f64 / (PROOF_SPEEDS - 1) as f64;
            let growth = Loop::new(rotor, law, rpm).growth_rate_per_s();
            // Nothing is proven when the range is empty.
            if proven > 0.0 && growth >= 0.0 {
                self.wrong.push(format!("grows by {growth} 1/s at {rpm} rpm, proven to {proven} rpm"));
            }
        }
    }

    /// Stiffness, sensitivity and zone at rest and at the top speed.
    fn predictions(&mut self, who: &str, rotor: &Rotor, law: &Law) {
        let top = rotor.max_rpm;
        for (rpm, place) in [(0.0, ""), (top, "/at_top_speed")] {
            let (stiffness, sensitivity) = (format!("/stiffness/{who}{place}"), format!("/sensitivity/{who}{place}"));
            let own = Loop::new(rotor, law, rpm);
            if own.growth_rate_per_s() >= 0.0 {
                for stated in [format!("{stiffness}/minimum_n_per_m"), format!("{sensitivity}/front_db")] {
                    if self.figure(&stated).is_some() {
                        self.wrong.push(format!("{stated} of an unstable loop"));
                    }
                }
            } else {
                let band = (BAND_HZ.0, BAND_HZ.1.min(BAND_END / rotor.period_s));
                let found = own.figures(band);
                let (minimum, hz) = found.minimum;
                // Lines round a peak: a per mille of its height. Near a flat minimum its frequency is known less well.
                self.hold(&format!("{stiffness}/minimum_n_per_m"), minimum, 3e-3 * minimum);
                let stated_hz = self.figure(&format!("{stiffness}/minimum_frequency_hz")).unwrap_or(hz);
                let there = own.stiffness_n_per_m(stated_hz);
                if there > 1.003 * minimum {
                    self.wrong.push(format!("{stiffness}: smallest at {stated_hz} Hz stated, at {hz} Hz true"));
                }
                let low = own.stiffness_n_per_m(10.0);
                self.hold(&format!("{stiffness}/at_10_hz_n_per_m"), low, 2e-3 * low);
                let fast = own.stiffness_n_per_m(top / 60.0);
                self.hold(&format!("{stiffness}/at_max_speed_n_per_m"), fast, 2e-3 * fast);
                let whole = own.figures((BAND_HZ.0, BAND_END / rotor.period_s));
                let [front, rear] = whole.sensitivity_db.map(|p| p.0);
                self.hold(&format!("{sensitivity}/front_db"), front, 0.03);
                self.hold(&format!("{sensitivity}/rear_db"), rear, 0.03);
                let letter = self.summary.pointer(&format!("{sensitivity}/zone")).and_then(Value::as_str);
                // Within the tolerance of a limit both letters are right.
                let worst = front.max(rear);
                if ![worst - 0.03, worst, worst + 0.03].iter().any(|db| letter == Some(zone(*db))) {
                    self.wrong.push(format!("{sensitivity}: zone {letter:?} stated, {worst} dB true"));
                }
            }
        }
    }

    /// μ of the specification as written and with the gyroscopic split covered, at rest; as written, over speed.
    fn robustness(&mut self, rotor: &Rotor, law: &Law) {
        let written = Specification::as_written(self.weights.clone(), self.flexible_modes);
        let mu = |specification: &Specification, rpm: f64| {
            let own = Loop::new(rotor, law, rpm);
            (own.growth_rate_per_s() < 0.0).then(|| specification.peak(&own).mu)
        };
        let cover = self.summary.pointer("/design/gyroscopic_cover").and_then(Value::as_array);
        let covered = Specification {
            weights: self.weights.clone(),
            uncertainty: cover
                .map(|rows| rows.iter().filter_map(|r| r["uncertainty_covered"].as_f64()).collect())
                .unwrap_or_default(),
        };
        // The bound is certified a per mille above what is attained, and the weights are fitted from above.
        if let Some(truth) = mu(&written, 0.0) {
            self.hold_bound("/design/table_as_written/mu_peak_discrete", truth, 2e-3, 0.1);
        }
        if let Some(truth) = mu(&covered, 0.0) {
            self.hold_bound("/design/mu_peak_discrete", truth, 2e-3, 0.1);
        }
        let rows = self.summary.pointer("/design/mu_over_speed").and_then(Value::as_array);
        for k in 0..rows.map_or(0, Vec::len) {
            let row = format!("/design/mu_over_speed/{k}");
            let rpm = self.figure(&format!("{row}/speed_rpm")).unwrap();
            match mu(&written, rpm) {
                // Lines round a peak: half a per cent of its height at most.
                Some(truth) => self.hold_bound(&format!("{row}/mu"), truth, 5e-3, 1e-2),
                None if self.figure(&format!("{row}/mu")).is_some() => {
                    self.wrong.push(format!("{row}/mu of an unstable loop"));
                }
                None => (),
            }
        }
    }
}

/// Figures of a results folder that are not true of the machine in it, and how many were held.
pub fn untrue(folder: &Path) -> (Vec<String>, usize) {
    let spindle: SpindleFile = read_yaml(&folder.join("spindle.yaml"));
    let tool: ToolFile = read_yaml(&folder.join("tool.yaml"));
    let text = std::fs::read_to_string(folder.join("summary.json")).unwrap();
    let law = |name: &str| folder.join(format!("controller/{name}.json"));
    let rotor = Rotor::new(&spindle, &tool);
    let mut run = Run {
        summary: serde_json::from_str(&text).unwrap(),
        weights: read_yaml(&below_root("weights/benchmark.yaml")),
        flexible_modes: spindle.rotor.flexible_modes,
        wrong: vec![],
        held: 0,
    };
    let mu = Law::read(&law("discrete"));
    run.stability(&rotor, &mu);
    run.predictions("mu", &rotor, &mu);
    if law("pid").exists() {
        run.predictions("pid", &rotor, &Law::read(&law("pid")));
    }
    run.robustness(&rotor, &mu);
    (run.wrong, run.held)
}

#[test]
fn the_figures_of_the_committed_reference_run_are_true_of_the_whole_machine() {
    let (wrong, held) = untrue(&below_root("results/reference"));
    // Growth rates, eight figures of two controllers at two speeds, μ twice at rest and at six speeds.
    assert!(held > 30, "only {held} figures found");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
#[ignore = "minutes; the command stands at the head of the file"]
fn the_polished_reference_design_is_stiff_on_the_whole_machine() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("design");
    Command::cargo_bin("muspin")
        .unwrap()
        .args(["design", "--spindle", "reference", "--tool", "paper-tool"])
        .arg("--out")
        .arg(&out)
        .assert()
        .code(0);
    let (wrong, held) = untrue(&out);
    assert!(held > 20, "only {held} figures found");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let text = std::fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: Value = serde_json::from_str(&text).unwrap();
    let figure = |pointer: &str| summary.pointer(pointer).and_then(Value::as_f64).unwrap();
    // Every figure above is held against the second road: these are what the polish is for.
    assert!(figure("/stiffness/mu/minimum_n_per_m") >= 3.7e6);
    assert!(figure("/stiffness/mu/at_top_speed/minimum_n_per_m") >= 3.55e6);
    assert!(figure("/stiffness/dk/minimum_n_per_m") < 3.0e6);
    assert!(figure("/design/largest_mu") <= 1.0);
    for zone in ["/sensitivity/mu/zone", "/sensitivity/mu/at_top_speed/zone"] {
        assert_eq!(summary.pointer(zone).and_then(Value::as_str), Some("A"));
    }
}

/// The D-K iteration knows nothing of floors: what its loop reaches of one is said, and is a missed target.
#[test]
fn a_floor_of_the_tool_stiffness_is_a_target() {
    let folder = tempfile::tempdir().unwrap();
    let (out, weights) = (folder.path().join("design"), folder.path().join("weights.yaml"));
    let text = std::fs::read_to_string(below_root("weights/benchmark.yaml")).unwrap();
    let floor = "tool_stiffness: [{from_hz: 300, to_hz: 900, at_least_n_per_m: 2.0e+7}]\n";
    std::fs::write(&weights, format!("{text}{floor}")).unwrap();
    let output = Command::cargo_bin("muspin")
        .unwrap()
        .args(["design", "--no-polish", "--text", "--weights"])
        .arg(&weights)
        .arg("--out")
        .arg(&out)
        .output()
        .unwrap();
    let shown = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(1), "{shown}");
    let spindle: SpindleFile = read_yaml(&out.join("spindle.yaml"));
    let rotor = Rotor::new(&spindle, &read_yaml(&out.join("tool.yaml")));
    let law = Law::read(&out.join("controller/discrete.json"));
    let least = |rpm: f64| {
        let own = Loop::new(&rotor, &law, rpm);
        (0..=600).map(|k| own.stiffness_n_per_m(300.0 + f64::from(k))).fold(f64::INFINITY, f64::min)
    };
    let truth = least(0.0).min(least(spindle.speed.max_rpm)) / 2e7;
    let summary: Value = serde_json::from_str(&std::fs::read_to_string(out.join("summary.json")).unwrap()).unwrap();
    let stated = summary.pointer("/design/tool_stiffness/least_share_of_asked").and_then(Value::as_f64).unwrap();
    assert!(truth < 0.9 && (stated / truth - 1.0).abs() < 0.01, "{stated} stated, {truth} true");
    assert!(shown.contains(&format!("{stated:.2} of the stiffness")), "{shown}");
}

/// Without the polish for it they decay at 0.3 and 0.8 1/s.
#[test]
#[ignore = "minutes; the command stands at the head of the file"]
fn loops_come_to_rest_within_a_second_of_a_load() {
    for name in ["s04-noncollocated", "s09-four-modes"] {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("design");
        let spindle = below_root(&format!("tests/data/spindles/{name}.yaml"));
        let mut command = Command::cargo_bin("muspin").unwrap();
        command.args(["design", "--tool", "endmill-10", "--spindle"]).arg(spindle).arg("--out").arg(&out);
        command.output().unwrap();
        let spindle: SpindleFile = read_yaml(&out.join("spindle.yaml"));
        let rotor = Rotor::new(&spindle, &read_yaml(&out.join("tool.yaml")));
        let law = Law::read(&out.join("controller/discrete.json"));
        for rpm in [0.0, spindle.speed.max_rpm] {
            let growth = Loop::new(&rotor, &law, rpm).growth_rate_per_s();
            assert!(growth < -4.0, "{name} at {rpm} rpm: {growth} 1/s");
        }
    }
}

#[test]
#[ignore = "minutes; the command stands at the head of the file"]
fn every_figure_of_a_run_on_six_other_spindles_is_true() {
    let only = std::env::var("MUSPIN_SPINDLES").unwrap_or_default();
    let asked = |name: &str| only.is_empty() || only.split(',').any(|o| name.starts_with(o));
    let mut all = vec![];
    for (name, tool) in PAIRS.into_iter().filter(|p| asked(p.0)) {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("run");
        let output = Command::cargo_bin("muspin")
            .unwrap()
            .arg("run")
            .args(["--tool", tool, "--spindle"])
            .arg(below_root(&format!("tests/data/spindles/{name}.yaml")))
            .arg("--out")
            .arg(&out)
            .output()
            .unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        // Refused with a reason, or done, with or without a target missed.
        match output.status.code() {
            Some(2) if !errors.trim().is_empty() => eprintln!("{name}: refused: {errors}"),
            Some(0 | 1) => {
                let (wrong, held) = untrue(&out);
                eprintln!("{name}: {held} figures held, {} wrong", wrong.len());
                all.extend(wrong.into_iter().map(|w| format!("{name} {w}")));
            }
            code => all.push(format!("{name}: exit {code:?} {errors}")),
        }
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}
