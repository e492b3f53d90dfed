//! The results folder, its summary and its page: whole or not at all, the same bytes every time, readable by any part.

use assert_cmd::Command;
use muspin::report::html;
use muspin::report::plot::{Axis, Color, Dash, Figure, Look, Panel, Series};
use muspin::report::results::{ResultsError, ResultsFolder};
use muspin::report::summary::Summary;
use muspin::report::tables::Table;
use serde_json::json;

fn figure() -> Figure {
    let mut panel = Panel::new(
        "",
        Axis::log("Frequency", "Hz"),
        Axis::log("Dynamic stiffness", "N/µm"),
    );
    let look = Look::line(Color::Blue, Dash::Solid);
    panel.series.push(Series::curve(
        "µ",
        &[1.0, 10.0, 4000.0],
        &[2.0, 2.5, 9.0],
        look,
    ));
    Figure::new("Stiffness <tool> & more", "Described.", vec![panel])
}

fn summary() -> Summary {
    let mut s = Summary::new();
    s.set("spindle", "reference");
    s.set("tool", "paper-tool");
    s.number("design.mu_peak", 0.8125);
    s.number("design.mu_peak_discrete", 0.91);
    s.set("design.controller_order", 24);
    s.number("design.certificates.riccati_residual", 3.2e-15);
    s.number("stiffness.mu.minimum_n_per_m", 2.31e6);
    s.number("stiffness.pid.minimum_n_per_m", 0.68e6);
    s.set("sensitivity.mu.zone", "A");
    s.set("sensitivity.pid.zone", "B");
    s.set("updating.errors_percent", json!([0.01, null]));
    s
}

fn folder() -> ResultsFolder {
    let mut folder = ResultsFolder::new();
    let summary = summary();
    folder.add_plot("stiffness", &figure()).unwrap();
    folder.add("summary.json", summary.to_json()).unwrap();
    let page = html::report(&summary.value(), &folder.pictures()).unwrap();
    folder.add("report.html", page).unwrap();
    folder
}

#[test]
fn a_folder_is_written_whole_and_replaced_only_at_the_end() {
    let place = tempfile::tempdir().unwrap();
    let target = place.path().join("results/reference");
    folder().write(&target).unwrap();
    let first = std::fs::read(target.join("report.html")).unwrap();
    assert!(target.join("plots/stiffness.csv").is_file());
    std::fs::write(target.join("stale.txt"), "left over").unwrap();
    folder().write(&target).unwrap();
    assert!(
        !target.join("stale.txt").exists(),
        "the earlier folder is replaced, not mixed"
    );
    assert_eq!(first, std::fs::read(target.join("report.html")).unwrap());
    let beside: Vec<_> = std::fs::read_dir(place.path().join("results"))
        .unwrap()
        .collect();
    assert_eq!(beside.len(), 1, "no temporary folder is left");
}

#[test]
fn a_folder_that_is_not_ours_is_never_replaced() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("thesis.tex"), "years of work").unwrap();
    let error = folder().write(place.path()).unwrap_err();
    assert!(matches!(error, ResultsError::NotResults { .. }), "{error}");
    assert!(place.path().join("thesis.tex").is_file());
    let file = place.path().join("thesis.tex");
    assert!(matches!(
        folder().write(&file),
        Err(ResultsError::NotResults { .. })
    ));
}

#[test]
fn paths_out_of_the_folder_are_refused() {
    for path in ["", "/etc/x", "../x", "plots/../../x", "plots//x", "a\\b"] {
        let refused = ResultsFolder::new().add(path, "x");
        assert!(
            matches!(refused, Err(ResultsError::Path { .. })),
            "{path:?}"
        );
    }
}

#[test]
fn the_summary_keeps_order_digits_and_says_null_for_what_is_no_number() {
    let mut s = Summary::new();
    s.number("z.last_hz", 0.1 + 0.2);
    s.number("a.first", f64::INFINITY);
    s.numbers("z.list", &[1.0, f64::NAN, 1e-300]);
    s.set("z.count", 3);
    let expected = "{\n  \"z\": {\n    \"last_hz\": 0.30000000000000004,\n    \"list\": [1.0, null, 1e-300],\n    \"count\": 3\n  },\n  \"a\": {\n    \"first\": null\n  }\n}\n";
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
    assert_eq!(
        table.to_csv(),
        "frequency_hz,\"note, with comma\"\n0.30000000000000004,\n1,\"say \"\"so\"\"\"\n"
    );
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
    let outside = page.replace("http://www.w3.org/2000/svg", "");
    for needle in ["http", "<script", "<link", "src=", "@import", "url("] {
        assert!(
            !outside.contains(needle),
            "{needle} in a self-contained page"
        );
    }
}

#[test]
fn the_page_works_with_any_part_absent_and_says_what_is_missed() {
    for value in [
        json!({}),
        json!({"diagnosis": {"verdict": "tie", "tie": ["a", "b"], "effects": []}}),
        json!({"further": [{"a_hz": 1.5}]}),
    ] {
        let page = html::report(&value, &[]).unwrap();
        assert!(page.contains("</html>") && !page.contains("Target missed"));
    }
    let missed = json!({"design": {"mu_peak_discrete": 1.21}, "spindle": "<b>"});
    let page = html::report(&missed, &[]).unwrap();
    assert!(page.contains("Target missed") && page.contains("1.210 &gt; 1"));
    assert!(page.contains("&lt;b&gt;") && !page.contains("<h1><b>"));
}

#[test]
fn report_rebuilds_the_page_and_refuses_what_is_no_results_folder() {
    let place = tempfile::tempdir().unwrap();
    let target = place.path().join("run");
    folder().write(&target).unwrap();
    let page = target.join("report.html");
    let written = std::fs::read(&page).unwrap();
    std::fs::remove_file(&page).unwrap();
    let report = |folder: &std::path::Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_muspin"));
        command.arg("report").arg(folder).assert()
    };
    report(&target).success().stdout("");
    assert_eq!(std::fs::read(&page).unwrap(), written);

    let failed = report(&place.path().join("nowhere")).code(2);
    let message = String::from_utf8_lossy(&failed.get_output().stderr).into_owned();
    assert!(
        message.contains("summary.json") && message.contains("hint:"),
        "{message}"
    );
    std::fs::write(target.join("summary.json"), "{\"a\": }").unwrap();
    let failed = report(&target).code(2);
    let message = String::from_utf8_lossy(&failed.get_output().stderr).into_owned();
    assert!(message.contains("line 1, column 7"), "{message}");
}
