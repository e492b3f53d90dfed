//! `muspin batch`: variants, the plan for many machines, and the table from finished folders.

use assert_cmd::Command;
use muspin::input::{load_machine, load_spindle};
use muspin::pipeline::variation::{Quantity, Variation, variants};
use muspin::report::batch::{BatchRow, LoopFigures, ToolFigures};
use std::path::Path;

fn muspin() -> Command {
    Command::new(env!("CARGO_BIN_EXE_muspin"))
}

/// A row as a finished tool leaves it.
fn finished(tool: &str, minimum_n_per_m: f64) -> BatchRow {
    let loops = |scale: f64| LoopFigures {
        minimum_stiffness_n_per_m: Some(scale * minimum_n_per_m),
        worst_stiffness_n_per_m: Some(0.9 * scale * minimum_n_per_m),
        sensitivity_db: Some(9.0),
        zone: "A".to_owned(),
        frequency_hz: vec![1.0, 10.0, 100.0],
        stiffness_n_per_m: vec![3e6, 2e6, scale * minimum_n_per_m],
    };
    BatchRow {
        tool: tool.to_owned(),
        inputs_sha256: "0".repeat(64),
        failure: None,
        figures: Some(ToolFigures {
            missed: None,
            mu_as_specified: Some(0.95),
            mu_with_gyroscopic_cover: Some(0.99),
            largest_mu: Some(0.97),
            order: 36,
            stable_to_rpm: 60_000.0,
            meets_specification: true,
            largest_tool_tightening: None,
            mu: loops(1.0),
            pid: Some(loops(0.5)),
        }),
        instability: None,
    }
}

fn write_row(folder: &Path, row: &BatchRow) {
    let own = folder.join(&row.tool);
    std::fs::create_dir_all(&own).unwrap();
    std::fs::write(own.join("row.json"), serde_json::to_string(row).unwrap()).unwrap();
}

#[test]
fn a_variant_differs_from_the_drawing_in_its_quantity_alone() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    for quantity in Quantity::ALL {
        let name = quantity.name();
        let variation = Variation { quantity, relative: 0.1 };
        let all = variants(&machine, &[variation]);
        assert_eq!(all.len(), 3, "{name}");
        assert_eq!(all[0].1, machine);
        for ((_, varied), factor) in all[1..].iter().zip([0.9, 1.1]) {
            assert_ne!(*varied, machine, "{name}");
            let back = quantity.scale_quantity(varied, 1.0 / factor);
            let (ours, theirs) = (&back.spindle, &machine.spindle);
            // One rounding each way.
            let near = |a: f64, b: f64| (a - b).abs() <= 4.0 * f64::EPSILON * b.abs();
            assert!(near(ours.front.ki_n_per_a, theirs.front.ki_n_per_a));
            assert!(near(ours.rear.ks_n_per_m, theirs.rear.ks_n_per_m));
            assert!(near(ours.electronics.delay_s, theirs.electronics.delay_s));
            assert!(near(ours.damping_ratio[0], theirs.damping_ratio[0]));
        }
    }
    let stiffer = Quantity::Modulus.scale_quantity(&machine, 1.21);
    let hz = |m: &muspin::spindle::Machine| {
        let modes = muspin::rotor::modes::PlanarModes::new(&m.rotor().unwrap()).unwrap();
        modes.flexible_hz()[0]
    };
    // ω² ∝ E with every element scaled alike.
    assert!((hz(&stiffer) / hz(&machine) - 1.1).abs() < 1e-6);
}

#[test]
fn a_plan_holds_the_files_and_the_command_of_every_variant() {
    let place = tempfile::tempdir().unwrap();
    let out = place.path().join("plan");
    muspin()
        .args(["batch", "--tools", "paper-tool,endmill-16", "--vary", "ki=±3%,delay=10%", "--quick"])
        .arg("--plan")
        .arg(&out)
        .assert()
        .code(0);
    let commands = std::fs::read_to_string(out.join("commands.txt")).unwrap();
    let lines: Vec<&str> = commands.lines().collect();
    assert_eq!(lines.len(), 10);
    assert!(std::fs::read_to_string(out.join("slurm.sh")).unwrap().contains("--array=1-10\n"));
    let nominal = load_spindle("reference").unwrap();
    let varied = out.join("variants/endmill-16-ki-plus-3");
    let spindle = load_spindle(varied.join("spindle.yaml").to_str().unwrap()).unwrap();
    assert_eq!(spindle.front.ki_n_per_a, nominal.front.ki_n_per_a * 1.03);
    assert_eq!(spindle.electronics, nominal.electronics);
    // Each command reads files of the plan, and its tool has the name of the variant's folder.
    for line in lines {
        let tool = line.split('\'').find(|word| word.ends_with("tool.yaml")).unwrap();
        let text = std::fs::read_to_string(out.join(tool)).unwrap();
        let name = Path::new(tool).parent().unwrap().file_name().unwrap().to_str().unwrap();
        assert!(text.contains(&format!("name: {name}\n")), "{text}");
        assert!(line.contains("--no-table --quick"));
    }
}

#[test]
fn a_variation_that_makes_no_sense_is_refused() {
    for (given, part) in [("ki", "no '='"), ("kj=3%", "none of"), ("ki=-3%", "percentage"), ("ki=80%", "percentage")] {
        let place = tempfile::tempdir().unwrap();
        let failed = muspin()
            .args(["batch", "--tools", "paper-tool", "--vary", given, "--plan"])
            .arg(place.path().join("plan"))
            .assert()
            .code(2);
        let message = String::from_utf8_lossy(&failed.get_output().stderr).into_owned();
        assert!(message.contains(given) && message.contains(part), "{message}");
        assert!(!place.path().join("plan").exists());
    }
}

#[test]
fn the_table_of_finished_folders_names_those_that_are_missing() {
    let place = tempfile::tempdir().unwrap();
    let plan = place.path().join("plan");
    muspin().args(["batch", "--tools", "paper-tool,endmill-16", "--plan"]).arg(&plan).assert().code(0);
    let out = place.path().join("table");
    let collect = || {
        let mut command = muspin();
        command.arg("batch").arg("--collect").arg(&plan).arg("--out").arg(&out);
        command.assert()
    };
    let nothing = collect().code(2);
    let message = String::from_utf8_lossy(&nothing.get_output().stderr).into_owned();
    assert!(message.contains("no finished variant") && message.contains("endmill-16 not started"), "{message}");
    let results = plan.join("results");
    write_row(&results, &finished("paper-tool", 3.5e6));
    let partly = collect().code(1);
    let table = String::from_utf8_lossy(&partly.get_output().stdout).into_owned();
    assert!(table.contains("endmill-16") && table.contains("not started"), "{table}");
    std::fs::create_dir(results.join("endmill-16")).unwrap();
    let begun = collect().code(1);
    let table = String::from_utf8_lossy(&begun.get_output().stdout).into_owned();
    assert!(table.contains("not finished"), "{table}");
    write_row(&results, &finished("endmill-16", 2.5e6));
    collect().code(0);
    let mut table = csv::Reader::from_path(out.join("tools.csv")).unwrap();
    let header = table.headers().unwrap().clone();
    let place_of = |name: &str| header.iter().position(|h| h == name).unwrap();
    let minima: Vec<f64> =
        table.records().map(|r| r.unwrap()[place_of("minimum_stiffness_mu_n_per_m")].parse().unwrap()).collect();
    assert_eq!(minima, [3.5e6, 2.5e6]);
    assert!(out.join("plots/tools_stiffness.svg").is_file());
    // A batch folder without a plan is collected as well.
    let other = place.path().join("other");
    muspin().arg("batch").arg("--collect").arg(&results).arg("--out").arg(&other).assert().code(0);
}

#[test]
fn a_plan_from_elsewhere_leads_nowhere_else() {
    let place = tempfile::tempdir().unwrap();
    let plan = place.path().join("plan");
    std::fs::create_dir_all(plan.join("results")).unwrap();
    write_row(place.path(), &finished("outside", 3.5e6));
    for name in ["../../outside", "..", "/etc", "a/../../../outside", "nul", ""] {
        std::fs::write(plan.join("variants.json"), format!("{{\"variants\": [\"{name}\"]}}")).unwrap();
        let run = muspin().arg("batch").arg("--collect").arg(&plan).arg("--out").arg(place.path().join("t")).assert();
        let message = String::from_utf8_lossy(&run.code(2).get_output().stderr).into_owned();
        assert!(message.contains("variants.json: variants[0]"), "{message}");
    }
}

/// Each line of the plan is one command with the names as they are.
#[test]
#[cfg(unix)]
fn names_with_blanks_are_quoted_for_the_shell() {
    let place = tempfile::tempdir().unwrap();
    let (tool, plan) = (place.path().join("a.yaml"), place.path().join("the plan"));
    let text = include_str!("../../../spindles/tools/endmill-10.yaml");
    std::fs::write(&tool, text.replacen("name: endmill-10", "name: Fräser 10 lang", 1)).unwrap();
    let run = muspin().args(["batch", "--text", "--tools"]).arg(&tool).arg("--plan").arg(&plan).assert().code(0);
    let commands = std::fs::read_to_string(plan.join("commands.txt")).unwrap();
    let script = format!("muspin() {{ for word; do echo \"$word\"; done; }}\n{commands}");
    let words = std::process::Command::new("sh").arg("-c").arg(script).output().unwrap();
    let words = String::from_utf8(words.stdout).unwrap();
    assert!(words.lines().any(|word| word == "variants/Fräser 10 lang/tool.yaml"), "{words}");
    let shown = String::from_utf8_lossy(&run.get_output().stdout).into_owned();
    assert!(shown.contains("the plan' && sbatch"), "{shown}");
}
