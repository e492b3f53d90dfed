//! The results folder, its summary and its page: whole or not at all, the same bytes every time, readable by any part.

use assert_cmd::Command;
use muspin::report::html;
use muspin::report::manifest::{MANIFEST, Manifest};
use muspin::report::pictures::{Picture, PictureName};
use muspin::report::plot::{Axis, Color, Dash, Figure, Look, Panel, Series};
use muspin::report::results::{ResultsError, ResultsFolder, claim};
use muspin::report::summary::Summary;
use muspin::report::tables::Table;
use serde_json::json;
use std::path::Path;

fn figure() -> Figure {
    let mut panel = Panel::new("", Axis::log("Frequency", "Hz"), Axis::log("Dynamic stiffness", "N/µm"));
    let look = Look::line(Color::Blue, Dash::Solid);
    panel.series.push(Series::curve("µ", &[1.0, 10.0, 4000.0], &[2.0, 2.5, 9.0], look));
    Figure::new("Stiffness <tool> & more", "Described.", vec![panel])
}

fn summary() -> Summary {
    let mut s = Summary::new();
    s.set("spindle", "reference");
    s.set("tool", "paper-tool");
    s.set("design.mu_peak", 0.8125);
    s.set("design.mu_peak_discrete", 0.91);
    s.set("design.controller_order", 24);
    s.set("design.certificates.riccati_residual", 3.2e-15);
    s.set("stiffness.mu.minimum_n_per_m", 2.31e6);
    s.set("stiffness.pid.minimum_n_per_m", 0.68e6);
    s.set("sensitivity.mu.zone", "A");
    s.set("sensitivity.pid.zone", "B");
    s.set("updating.errors_percent", json!({"resonances": [0.01, null], "antiresonances": {}}));
    s
}

fn folder() -> ResultsFolder {
    let mut folder = ResultsFolder::new();
    let summary = summary();
    folder.add_plot(Picture::Stiffness, &figure()).unwrap();
    folder.add("summary.json", summary.to_json()).unwrap();
    let page = html::report(&summary.value(), &folder.pictures()).unwrap();
    folder.add("report.html", page).unwrap();
    folder
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

/// A folder with the given files.
fn staged(files: &[(&str, &str)]) -> ResultsFolder {
    let mut folder = ResultsFolder::new();
    for (path, text) in files {
        folder.add(path, *text).unwrap();
    }
    folder
}

#[test]
fn a_later_run_replaces_its_files_removes_stale_ones_and_leaves_the_rest() {
    let place = tempfile::tempdir().unwrap();
    let target = place.path().join("results/reference");
    let first = staged(&[("a.txt", "1"), ("plots/old.svg", "o"), ("deep/er/x", "x")]);
    first.write(&target).unwrap();
    // Twice without and twice with a file of the user beside ours: the whole folder and file by file.
    for (run, own) in [("2", false), ("3", false), ("4", true), ("5", true)] {
        if own {
            std::fs::create_dir_all(target.join("src")).unwrap();
            std::fs::write(target.join("src/main.c"), "code").unwrap();
            staged(&[("a.txt", "1"), ("plots/old.svg", "o")]).write(&target).unwrap();
        }
        staged(&[("a.txt", run), ("b.txt", run)]).write(&target).unwrap();
        assert_eq!(text(&target.join("a.txt")), run);
        assert_eq!(text(&target.join("b.txt")), run);
        assert!(!target.join("plots").exists() && !target.join("deep").exists());
        assert_eq!(target.join("src/main.c").exists(), own);
    }
    assert_eq!(text(&target.join("src/main.c")), "code");
    let listed = Manifest::read(&target).unwrap();
    assert_eq!(listed.paths().collect::<Vec<_>>(), ["a.txt", "b.txt"]);
    assert!(listed.replacing.is_empty());
    let beside = std::fs::read_dir(place.path().join("results")).unwrap();
    assert_eq!(beside.count(), 1, "no temporary folder is left");
    assert_eq!(std::fs::read_dir(&target).unwrap().count(), 4);
}

#[test]
fn the_same_run_writes_the_same_bytes_manifest_included() {
    let place = tempfile::tempdir().unwrap();
    let targets = ["a", "b"].map(|name| place.path().join(name));
    targets.iter().for_each(|t| folder().write(t).unwrap());
    for file in [MANIFEST, "report.html", "summary.json"] {
        let [a, b] = targets.each_ref().map(|t| text(&t.join(file)));
        assert_eq!(a, b, "{file}");
    }
    let listed = Manifest::read(&targets[0]).unwrap();
    let report = std::fs::read(targets[0].join("report.html")).unwrap();
    assert!(listed.wrote("report.html", &report) && !listed.wrote("report.html", b"x"));
}

#[test]
fn a_file_that_muspin_did_not_write_is_never_replaced() {
    let place = tempfile::tempdir().unwrap();
    std::fs::create_dir(place.path().join("src")).unwrap();
    std::fs::write(place.path().join("src/main.c"), "years of work").unwrap();
    std::fs::write(place.path().join("summary.json"), "{}").unwrap();
    let refused = folder().write(place.path()).unwrap_err();
    assert!(matches!(refused, ResultsError::Foreign { .. }), "{refused}");
    assert!(refused.to_string().contains("summary.json"), "{refused}");
    let early = claim(place.path(), &["summary.json"], &[]);
    assert!(matches!(early, Err(ResultsError::Foreign { .. })));
    assert_eq!(text(&place.path().join("summary.json")), "{}");
    assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 2);
    // A folder where a file would stand, a file where a folder would, and a file as the target.
    for path in ["src", "summary.json/x"] {
        let refused = staged(&[(path, "x")]).write(place.path());
        assert!(matches!(refused, Err(ResultsError::Foreign { .. })), "{path}");
    }
    let refused = folder().write(&place.path().join("src/main.c"));
    assert!(matches!(refused, Err(ResultsError::NotAFolder { .. })));
    // The same bytes are no loss.
    staged(&[("summary.json", "{}")]).write(place.path()).unwrap();
    assert_eq!(text(&place.path().join("src/main.c")), "years of work");
}

#[test]
fn a_file_that_was_edited_since_is_never_replaced_or_removed() {
    let place = tempfile::tempdir().unwrap();
    let target = place.path().join("run");
    let run = || staged(&[("spindle.yaml", "k: 1"), ("b", "b")]).write(&target);
    run().unwrap();
    std::fs::write(target.join("spindle.yaml"), "k: 2 # tuned by hand").unwrap();
    let other = staged(&[("c", "c")]).write(&target);
    for refused in [run(), other, claim(&target, &[], &[])] {
        let message = refused.unwrap_err().to_string();
        assert!(message.contains("spindle.yaml' was changed"), "{message}");
    }
    assert_eq!(text(&target.join("spindle.yaml")), "k: 2 # tuned by hand");
    assert!(target.join("b").exists() && !target.join("c").exists());
    std::fs::remove_file(target.join("spindle.yaml")).unwrap();
    run().unwrap();
    assert_eq!(text(&target.join("spindle.yaml")), "k: 1");
}

#[test]
fn an_interrupted_replacement_is_completed_by_the_next_run() {
    let place = tempfile::tempdir().unwrap();
    let run = |text: &'static str| staged(&[("a", text), ("b", text), ("c", text)]);
    run("old").write(place.path()).unwrap();
    let old = Manifest::read(place.path()).unwrap();
    // As a kill between two renames leaves it: one file new, one old, one lost with the power, both hashes in the list.
    let mut both = Manifest::of(run("new").files());
    both.replacing = old.files;
    std::fs::write(place.path().join(MANIFEST), both.to_json()).unwrap();
    std::fs::write(place.path().join("a"), "new").unwrap();
    std::fs::remove_file(place.path().join("c")).unwrap();
    run("third").write(place.path()).unwrap();
    for name in ["a", "b", "c"] {
        assert_eq!(text(&place.path().join(name)), "third");
    }
    assert!(Manifest::read(place.path()).unwrap().replacing.is_empty());
}

#[test]
#[cfg(unix)]
fn a_link_is_followed_and_one_that_leads_nowhere_is_said() {
    let place = tempfile::tempdir().unwrap();
    let (real, link) = (place.path().join("real"), place.path().join("link"));
    std::fs::create_dir(&real).unwrap();
    std::os::unix::fs::symlink(&real, &link).unwrap();
    for run in ["1", "2"] {
        staged(&[("a", run)]).write(&link).unwrap();
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(text(&real.join("a")), run);
    }
    std::fs::remove_dir_all(&real).unwrap();
    let refused = staged(&[("a", "3")]).write(&link);
    assert!(matches!(refused, Err(ResultsError::BrokenLink { .. })));
}

#[test]
fn measurements_and_inputs_are_never_written_over() {
    let place = tempfile::tempdir().unwrap();
    let target = place.path().join("run");
    staged(&[("spindle.yaml", "s"), ("measurement/sweep-0.csv", "m")]).write(&target).unwrap();
    let input = |path: &str| claim(&target, &[], &["reference", target.join(path).to_str().unwrap()]);
    for path in ["spindle.yaml", "measurement", "./measurement/../spindle.yaml"] {
        let refused = input(path);
        assert!(matches!(refused, Err(ResultsError::Input { .. })), "{path}");
    }
    input("absent").unwrap();
    std::fs::write(target.join("measurement.yaml"), "records: []").unwrap();
    for refused in [claim(&target, &[], &[]), staged(&[("a", "a")]).write(&target)] {
        assert!(matches!(refused, Err(ResultsError::Measurement { .. })));
    }
}

#[test]
fn a_manifest_cannot_lead_out_of_its_folder() {
    let place = tempfile::tempdir().unwrap();
    let target = place.path().join("run");
    std::fs::create_dir(&target).unwrap();
    for text in ["{\"files\": {\"../thesis.tex\": \"00\"}}", "[]", "{"] {
        std::fs::write(target.join(MANIFEST), text).unwrap();
        let refused = staged(&[("a", "a")]).write(&target);
        assert!(matches!(refused, Err(ResultsError::Manifest { .. })), "{text}");
    }
}

#[test]
fn commands_refuse_before_they_compute() {
    let place = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/diagnosis/c01");
    let copy = place.path().join("m");
    std::fs::create_dir(&copy).unwrap();
    for entry in std::fs::read_dir(&data).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, copy.join(path.file_name().unwrap())).unwrap();
    }
    let listed = || std::fs::read_dir(&copy).unwrap().count();
    let before = (text(&copy.join("hammer-0.csv")), listed());
    for command in ["identify", "update", "diagnose"] {
        let mut run = Command::new(env!("CARGO_BIN_EXE_muspin"));
        let run = run.arg(command).arg("--measurement").arg(&copy);
        let failed = run.arg("--out").arg(&copy).assert().code(2).stdout("");
        let message = String::from_utf8_lossy(&failed.get_output().stderr).into_owned();
        assert!(message.contains("measurement folder"), "{command}: {message}");
    }
    assert_eq!(before, (text(&copy.join("hammer-0.csv")), listed()));
    let tool = include_str!("../../../spindles/tools/endmill-10.yaml");
    let (a, b) = (place.path().join("a.yaml"), place.path().join("b.yaml"));
    std::fs::write(&a, tool).unwrap();
    for (other, part) in [("endmill-10", "already"), ("Plots", "batch itself"), ("x/y", "has '/' in it")] {
        std::fs::write(&b, tool.replace("name: endmill-10", &format!("name: {other}"))).unwrap();
        let both = format!("{},{}", a.display(), b.display());
        let mut run = Command::new(env!("CARGO_BIN_EXE_muspin"));
        let out = place.path().join("batch");
        let run = run.args(["batch", "--tools", &both, "--out"]).arg(&out);
        let failed = run.assert().code(2).stdout("");
        let message = String::from_utf8_lossy(&failed.get_output().stderr).into_owned();
        assert!(message.contains("b.yaml") && message.contains("name") && message.contains(part), "{message}");
        assert!(!out.exists());
    }
}

#[test]
fn paths_out_of_the_folder_are_refused() {
    for path in ["", "/etc/x", "../x", "plots/../../x", "plots//x", "a\\b"] {
        let refused = ResultsFolder::new().add(path, "x");
        assert!(matches!(refused, Err(ResultsError::Path { .. })), "{path:?}");
    }
}

#[test]
fn the_summary_keeps_order_digits_and_says_null_for_what_is_no_number() {
    let mut s = Summary::new();
    s.set("z.last_hz", 0.1 + 0.2);
    s.set("a.first", f64::INFINITY);
    s.set("z.list", [1.0, f64::NAN, 1e-300]);
    s.set("z.count", 3);
    let expected = "{\n  \"z\": {\n    \"last_hz\": 0.30000000000000004,\n    \"list\": [1.0, null, 1e-300],\n    \
        \"count\": 3\n  },\n  \"a\": {\n    \"first\": null\n  }\n}\n";
    assert_eq!(s.to_json(), expected);
    let back: serde_json::Value = serde_json::from_str(&s.to_json()).unwrap();
    assert_eq!(back, s.value());
    assert_eq!(s.get("z.last_hz").and_then(|v| v.as_f64()), Some(0.1 + 0.2));
}

#[test]
fn tables_read_back_the_same_numbers() {
    let mut table = Table::with_columns(&["frequency_hz", "note, with comma"]);
    table.push_numbers(&[0.1 + 0.2, f64::NAN]);
    table.push(vec!["1".to_owned(), "say \"so\"".to_owned()]);
    assert_eq!(table.to_csv(), "frequency_hz,\"note, with comma\"\n0.30000000000000004,\n1,\"say \"\"so\"\"\"\n");
    for x in [1e-300, -7.25e22, 123_456.789, 1e-4, 9.999e-5] {
        assert_eq!(Table::number(x).parse::<f64>().unwrap(), x);
    }
}

#[test]
fn the_page_is_self_contained_and_states_the_verdict_first() {
    let page = html::report(&summary().value(), &folder().pictures()).unwrap();
    for needle in [
        "Targets met",
        "µ = 0.910 ≤ 1",
        "2.31 N/µm",
        "zone A with the µ controller, zone B with the PID",
        "riccati residual",
        "<svg ",
        "reference with paper-tool",
        "Stiffness &lt;tool&gt; &amp; more",
    ] {
        assert!(page.contains(needle), "{needle} missing");
    }
    let outside = page.replace("http://www.w3.org/2000/svg", "").replacen("<meta http-equiv=", "", 1);
    let foreign = [
        "http",
        "<script ",
        "<link",
        "src=",
        "@import",
        "import(",
        "url(",
        "fetch(",
        "XMLHttpRequest",
        "WebSocket",
        "eval(",
    ];
    for needle in foreign {
        assert!(!outside.contains(needle), "{needle} in a self-contained page");
    }
    // The one script is that of the figures, word for word: values at the pointer and zoom.
    let scripts: Vec<&str> = page.split("<script>").skip(1).collect();
    assert_eq!(scripts.len(), 1);
    let script = scripts[0].split("</script>").next().unwrap();
    let own = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let own = std::fs::read_to_string(own.join("src/report/templates/figures.js")).unwrap();
    assert_eq!(script.trim(), own.trim());
}

#[test]
fn the_page_works_with_any_part_absent_and_says_what_is_missed() {
    for value in [
        json!({}),
        json!({"diagnosis": {"verdict": "tie", "effects": [], "tie": [
            {"effect": "loop_delay", "score_above_best": 0.0},
            {"effects": [{"effect": "tool_mass", "where": {}}], "score_above_best": null},
        ]}}),
        json!({"further": [{"a_hz": 1.5}]}),
    ] {
        let page = html::report(&value, &[]).unwrap();
        assert!(page.contains("</html>") && !page.contains("Target missed"));
    }
    let missed = json!({"design": {"mu_peak_discrete": 1.21}, "spindle": "<b>"});
    let page = html::report(&missed, &[]).unwrap();
    assert!(page.contains("Target missed") && page.contains("1.210 &gt; 1"));
    assert!(page.contains("&lt;b&gt;") && !page.contains("<h1><b>"));
    let foreign = json!({"design": {"mu_peak": "small"}});
    let refused = html::report(&foreign, &[]).unwrap_err().to_string();
    assert!(refused.contains("summary.json: design: invalid type"), "{refused}");
}

#[test]
fn report_rebuilds_the_page_and_refuses_what_is_no_results_folder() {
    let place = tempfile::tempdir().unwrap();
    let target = place.path().join("run");
    folder().write(&target).unwrap();
    let page = target.join("report.html");
    let written = std::fs::read(&page).unwrap();
    std::fs::remove_file(&page).unwrap();
    assert!(Manifest::read(&target).unwrap().lists("report.html"));
    let report = |folder: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_muspin"));
        command.arg("report").arg(folder).assert()
    };
    report(&target).success().stdout("");
    assert_eq!(std::fs::read(&page).unwrap(), written);
    std::fs::write(&page, "notes of mine").unwrap();
    report(&target).code(2).stdout("");
    assert_eq!(text(&page), "notes of mine");

    let failed = report(&place.path().join("nowhere")).code(2);
    let message = String::from_utf8_lossy(&failed.get_output().stderr).into_owned();
    assert!(message.contains("summary.json") && message.contains("hint:"), "{message}");
    std::fs::write(target.join("summary.json"), "{\"a\": }").unwrap();
    let failed = report(&target).code(2);
    let message = String::from_utf8_lossy(&failed.get_output().stderr).into_owned();
    assert!(message.contains("line 1, column 7"), "{message}");
}

#[test]
fn frequencies_stand_side_by_side_and_names_share_a_line() {
    let summary = json!({"updating": {
        "measured_hz": {"resonances": [1069.0], "antiresonances": {"front": [1109.0], "rear": [null]}},
        "model_before_hz": {"resonances": [1165.15], "antiresonances": {"front": [1198.1], "rear": [1006.8]}},
        "model_hz": {"resonances": [1069.02], "antiresonances": {"front": [1109.0], "rear": [952.0]}},
        "errors_hz": {"resonances": [0.02], "antiresonances": {"front": [0.0], "rear": [null]}},
        "modulus_factors": {"e1": 1.0332684, "e2": 0.93, "e3": 1.0},
        "fit_hz": {"front": [1.5, 2.5], "rear": [3.0]},
    }});
    let page = html::report(&summary, &[]).unwrap();
    for needle in [
        "<td>resonance 1</td><td>1069.0</td><td>1165.2</td><td>1069.0</td><td>0.02</td><td>–</td>",
        "<td>antiresonance, rear 1</td><td>–</td>",
        "e1 1.033, e2 0.93, e3 1",
        "1.5 Hz, 2.5 Hz",
    ] {
        assert!(page.contains(needle), "{needle} missing in {page}");
    }
    assert!(!page.contains("model before"), "what the table shows is not listed again");
}

#[test]
fn a_picture_keeps_its_section_and_place_in_a_page_rebuilt_from_files() {
    let mut stems = std::collections::BTreeSet::new();
    for kind in Picture::ALL {
        for name in [kind.into(), kind.with_number(3), kind.with_detail("rear_x-from-front_y-2")] {
            let stem = name.stem();
            assert_eq!(PictureName::of_stem(&stem), Some(name), "{stem}");
            assert!(stems.insert(stem.clone()), "{stem} twice");
        }
    }
    assert_eq!(PictureName::of_stem("muster"), None);
    // Files come by stem, the page by section and order of the picture; what muspin does not know comes last.
    let given = ["channel-a", "mu_speed", "mu", "impedance-2", "own", "impedance", "campbell"];
    let pictures = given.map(|stem| (stem.to_owned(), format!("<svg>{stem}</svg>")));
    let page = html::report(&json!({}), &pictures).unwrap();
    let wanted = ["campbell", "mu", "mu_speed", "impedance", "impedance-2", "channel-a", "own"];
    let places = wanted.map(|stem| page.find(&format!("<svg>{stem}</svg>")).unwrap());
    assert!(places.is_sorted(), "{places:?}");
    let further = page.find("id=\"further\"").unwrap();
    assert!(places[5] < further && further < places[6]);
}
