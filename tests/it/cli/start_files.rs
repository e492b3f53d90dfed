//! What a new user starts from: `init`, `example`, the guides, the schemas, rehearsed measurements.

use crate::cli::program::muspin;
use muspin::identify::{Rehearsal, open_loop};
use muspin::input::load_machine;
use muspin::input::problem_schema::{ProblemKind, problem_schema};
use muspin::input::schema::{SchemaKind, page, schema};
use muspin::input::sweep::read_sweep;
use muspin::lti::Response;
use muspin::spindle::{ModelDetail, Plant};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// What a value breaks of a schema: the keywords that the schemas of muspin have, by the words of draft 2020-12.
fn broken(schema: &Value, value: &Value, at: &str, found: &mut Vec<String>) {
    let mut tell = |rule: &str| found.push(format!("{at}: {rule}"));
    let is = |kind: &str| match kind {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|x| x.fract() == 0.0),
        other => panic!("type {other}"),
    };
    match &schema["type"] {
        Value::String(kind) if !is(kind) => tell(&format!("is no {kind}")),
        Value::Array(kinds) if !kinds.iter().any(|k| is(k.as_str().unwrap())) => tell(&format!("is none of {kinds:?}")),
        _ => {}
    }
    if let (Some(low), Some(x)) = (schema["minimum"].as_f64(), value.as_f64())
        && x < low
    {
        tell("is too small");
    }
    if let (Some(high), Some(x)) = (schema["maximum"].as_f64(), value.as_f64())
        && x > high
    {
        tell("is too large");
    }
    if schema.get("const").is_some_and(|c| c != value) {
        tell("is another constant");
    }
    if schema["enum"].as_array().is_some_and(|e| !e.contains(value)) {
        tell("is not in the list");
    }
    for key in ["oneOf", "anyOf"] {
        let Some(list) = schema[key].as_array() else {
            continue;
        };
        let good = list.iter().filter(|one| valid(one, value)).count();
        if good == 0 || (key == "oneOf" && good > 1) {
            found.push(format!("{at}: {good} of {key} fit"));
        }
    }
    let length = value.as_array().map(Vec::len);
    for (key, short) in [("minItems", true), ("maxItems", false)] {
        if let (Some(limit), Some(length)) = (schema[key].as_u64(), length)
            && (length < limit as usize) == short
            && length != limit as usize
        {
            found.push(format!("{at}: has {length} entries"));
        }
    }
    if let (Some(items), Some(list)) = (schema.get("items"), value.as_array()) {
        for (k, item) in list.iter().enumerate() {
            broken(items, item, &format!("{at}[{k}]"), found);
        }
    }
    let Some(map) = value.as_object() else { return };
    for key in schema["required"].as_array().into_iter().flatten() {
        if !map.contains_key(key.as_str().unwrap()) {
            found.push(format!("{at}: without {key}"));
        }
    }
    for (key, item) in map {
        let path = format!("{at}.{key}");
        match (schema["properties"].get(key), &schema["additionalProperties"]) {
            (Some(known), _) => broken(known, item, &path, found),
            (None, Value::Bool(false)) => found.push(format!("{path}: is unknown")),
            (None, other @ Value::Object(_)) => broken(other, item, &path, found),
            _ => {}
        }
    }
}

fn valid(schema: &Value, value: &Value) -> bool {
    let mut found = vec![];
    broken(schema, value, "", &mut found);
    found.is_empty()
}

/// Keywords that [`broken`] knows, and those that only describe.
#[test]
fn the_schemas_have_no_keyword_that_these_tests_pass_over() {
    const KNOWN: [&str; 21] = [
        "type",
        "minimum",
        "maximum",
        "const",
        "enum",
        "oneOf",
        "anyOf",
        "items",
        "minItems",
        "maxItems",
        "required",
        "properties",
        "additionalProperties",
        "$schema",
        "title",
        "description",
        "default",
        "format",
        "x-unit",
        "x-plausible",
        "x-reason",
    ];
    fn walk(schema: &Value, found: &mut Vec<String>) {
        let Some(map) = schema.as_object() else {
            return;
        };
        found.extend(map.keys().filter(|k| !KNOWN.contains(&k.as_str())).cloned());
        for list in ["oneOf", "anyOf"] {
            schema[list].as_array().into_iter().flatten().for_each(|s| walk(s, found));
        }
        schema["properties"].as_object().into_iter().flatten().for_each(|(_, s)| walk(s, found));
        walk(&schema["items"], found);
        walk(&schema["additionalProperties"], found);
    }
    for kind in SchemaKind::ALL {
        let mut found = vec![];
        walk(&schema(kind), &mut found);
        assert!(found.is_empty(), "{kind:?}: {found:?}");
    }
    for kind in ProblemKind::ALL {
        let mut found = vec![];
        walk(&problem_schema(kind), &mut found);
        assert!(found.is_empty(), "{kind:?}: {found:?}");
    }
}

fn yaml(path: &Path) -> Value {
    serde_yaml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join(folder)).unwrap();
    let mut found: Vec<PathBuf> =
        entries.map(|e| e.unwrap().path()).filter(|p| p.extension().is_some_and(|e| e == extension)).collect();
    found.sort();
    found
}

#[test]
fn all_files_of_the_repository_agree_with_their_schemas() {
    let mut cases: Vec<(SchemaKind, PathBuf)> = vec![];
    let mut add = |kind: SchemaKind, found: Vec<PathBuf>| {
        assert!(!found.is_empty(), "{kind:?}: no files");
        cases.extend(found.into_iter().map(|path| (kind, path)));
    };
    let mut spindles = files("tests/data/spindles", "yaml");
    spindles.push(root().join("spindles/reference.yaml"));
    spindles.push(root().join("src/cli/start/spindle.yaml"));
    add(SchemaKind::Spindle, spindles);
    let mut tools = files("spindles/tools", "yaml");
    tools.push(root().join("src/cli/start/tool.yaml"));
    add(SchemaKind::Tool, tools);
    let mut weights = files("weights", "yaml");
    weights.push(root().join("src/cli/start/weights.yaml"));
    add(SchemaKind::Weights, weights);
    add(SchemaKind::Frequencies, vec![root().join("spindles/paper-frequencies.yaml")]);
    add(SchemaKind::Controller, files("tests/data/designs/reference-updated", "json"));
    add(
        SchemaKind::Measurement,
        vec![
            root().join("src/cli/start/measurement.yaml"),
            root().join("src/cli/examples/measurement-diagnose.yaml"),
            root().join("tests/data/diagnosis/c01/measurement.yaml"),
        ],
    );
    for (kind, path) in cases {
        let found = yaml(&path);
        let mut wrong = vec![];
        broken(&schema(kind), &found, "", &mut wrong);
        assert!(wrong.is_empty(), "{}: {wrong:?}", path.display());
    }
}

/// Problems of `muspin solve` in the repository, by kind: the shipped examples and the cases of the tests.
fn problems() -> Vec<(ProblemKind, PathBuf)> {
    let mut list = vec![];
    for kind in ProblemKind::ALL {
        let folder = match kind {
            ProblemKind::Dksyn => "dk",
            ProblemKind::Reduce => "modred",
            other => other.name(),
        };
        let folder = format!("tests/data/control/{folder}");
        if root().join(&folder).is_dir() {
            list.extend(files(&folder, "json").into_iter().map(|path| (kind, path)));
        }
        let example = root().join(format!("src/cli/examples/{}.json", kind.name()));
        list.extend(example.is_file().then_some((kind, example)));
    }
    list
}

/// An impossible shape of a field.
fn misshapen(value: &Value) -> Value {
    match value {
        Value::Number(_) => json!("seven"),
        Value::Array(_) => json!({ "re": 1 }),
        _ => json!([["one"]]),
    }
}

/// The reader and the schema agree on every problem, on it without each of its fields, and with each field in another
/// shape. The smallest case of each kind is solved; a kind has a case of its own or a shipped example.
#[test]
fn schemas_of_problems_say_what_the_solvers_take() {
    let folder = tempfile::tempdir().unwrap();
    let all = problems();
    for kind in ProblemKind::ALL {
        let own = all.iter().filter(|(k, _)| *k == kind).map(|(_, path)| path);
        let size = |p: &&PathBuf| std::fs::metadata(p).unwrap().len();
        let paths: Vec<&PathBuf> = own.collect();
        let schema = problem_schema(kind);
        for path in &paths {
            let mut wrong = vec![];
            broken(&schema, &yaml(path), "", &mut wrong);
            assert!(wrong.is_empty(), "{}: {wrong:?}", path.display());
        }
        let small = paths.into_iter().min_by_key(size).unwrap();
        let whole = yaml(small);
        let data = whole["data"].as_object().unwrap().clone();
        let (mut refused, mut taken) = (0, 0);
        let mut agree = |what: &str, data: &serde_json::Map<String, Value>| {
            for problem in [json!(data), json!({ "data": data })] {
                let path = folder.path().join("problem.json");
                std::fs::write(&path, problem.to_string()).unwrap();
                let (code, _, told) = muspin(&["solve", kind.name(), "problem.json"], folder.path());
                let good = valid(&schema, &problem);
                assert_eq!(code == 0, good, "{kind:?}: {what}, ended with {code}: {told}");
                *(if good { &mut taken } else { &mut refused }) += 1;
            }
        };
        agree("whole", &data);
        for key in data.keys() {
            let mut other = data.clone();
            // D-K iteration takes a second a problem: what is left out and still solved is tried for the quick kinds.
            if kind != ProblemKind::Dksyn || ["A", "m2"].contains(&key.as_str()) {
                other.remove(key);
                agree(&format!("without {key}"), &other);
            }
            other = data.clone();
            // A field that the kind does not have is not read.
            if schema["anyOf"][1]["properties"].get(key).is_some() {
                other.insert(key.clone(), misshapen(&data[key]));
                agree(&format!("{key} misshapen"), &other);
            }
        }
        assert!(refused >= 4 && taken >= 2, "{kind:?}: {refused} refused, {taken} taken");
    }
}

/// Where the schema says no the reader says no as well: keys that are missing, unknown or of an impossible size.
#[test]
fn schemas_refuse_what_the_reader_refuses() {
    let folder = tempfile::tempdir().unwrap();
    let mut tried = 0;
    for (kind, file) in [
        (SchemaKind::Spindle, "src/cli/start/spindle.yaml"),
        (SchemaKind::Weights, "src/cli/start/weights.yaml"),
        (SchemaKind::Tool, "src/cli/start/tool.yaml"),
    ] {
        let whole = yaml(&root().join(file));
        let schema = schema(kind);
        let mut wrong: Vec<(String, Value)> = vec![];
        for key in whole.as_object().unwrap().keys() {
            let mut without = whole.clone();
            without.as_object_mut().unwrap().remove(key);
            wrong.push((format!("without {key}"), without));
        }
        let mut unknown = whole.clone();
        unknown["colour"] = json!("red");
        wrong.push(("an unknown key".to_owned(), unknown));
        let places: &[&str] = match kind {
            SchemaKind::Spindle => {
                &["/electronics/delay_s", "/rotor/elements/0/length_m", "/bearings/front/ki_n_per_a"]
            }
            SchemaKind::Weights => &["/tool/max_dc_load_n", "/mode_uncertainty/0"],
            _ => &["/tool_plane_m", "/elements/1/outer_diameter_m"],
        };
        for place in places {
            for size in [json!(1e12), json!("thick")] {
                let mut other = whole.clone();
                *other.pointer_mut(place).unwrap() = size.clone();
                wrong.push((format!("{place} = {size}"), other));
            }
        }
        for (what, value) in wrong {
            let path = folder.path().join("changed.yaml");
            std::fs::write(&path, serde_yaml::to_string(&value).unwrap()).unwrap();
            let (code, _, _) = muspin(&["check", "changed.yaml"], folder.path());
            assert_eq!(code == 2, !valid(&schema, &value), "{file}: {what}, reader ended with {code}");
            tried += usize::from(code == 2);
        }
    }
    assert!(tried > 25, "{tried}");
}

#[test]
fn the_page_of_keys_is_what_the_readers_take() {
    let written = std::fs::read_to_string(root().join("src/guide/keys.md")).unwrap();
    assert!(written == page(), "src/guide/keys.md: write it with `muspin schema --page`");
    for key in
        ["ki_n_per_a", "current_rolloff_ratio", "tool_tightening", "eddy_currents", "mode_uncertainty[]", "`hold`"]
    {
        assert!(page().contains(key), "{key}");
    }
}

#[test]
fn every_key_of_the_table_has_its_place_in_the_schemas() {
    use muspin::input::keys;
    let of = [
        (SchemaKind::Spindle, keys::SPINDLE),
        (SchemaKind::Tool, keys::TOOL),
        (SchemaKind::Weights, keys::WEIGHTS),
        (SchemaKind::Measurement, keys::MEASUREMENT),
        (SchemaKind::Frequencies, keys::FREQUENCIES),
    ];
    for (kind, groups) in of {
        let schema = schema(kind);
        // A group of any name that the schema lists stands at each of its names.
        let places = |at: &str| {
            let above = at.strip_suffix(".*").unwrap_or("");
            let listed = &schema["properties"][above]["properties"];
            listed.as_object().map_or(1, |names| names.len())
        };
        let numbers: usize = groups.iter().filter(|g| g.at != "effects[]").map(|g| places(g.at) * g.keys.len()).sum();
        let marked = schema.to_string().matches("x-plausible").count();
        assert_eq!(numbers, marked, "{kind:?}");
    }
}

/// The commands of the blocks of a guide: `sh` blocks, with `slow` ones where asked for.
fn commands(guide: &str, slow: bool) -> Vec<String> {
    let mut found = vec![];
    let mut takes = false;
    for line in guide.lines() {
        match line.strip_prefix("```") {
            Some("sh") => takes = true,
            Some("sh slow") => takes = slow,
            Some(_) => takes = false,
            None if takes => found.push(line.to_owned()),
            None => {}
        }
    }
    found
}

fn run_guide(name: &str, slow: bool) {
    let text = std::fs::read_to_string(root().join(format!("src/guide/{name}.md"))).unwrap();
    let temporary = tempfile::tempdir().unwrap();
    let mut folder = temporary.path().to_owned();
    let list = commands(&text, slow);
    assert!(list.len() > 2, "{name}: {list:?}");
    for line in list {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["cd", to] => folder = folder.join(to),
            ["muspin", ref arguments @ ..] => {
                let (code, _, error) = muspin(arguments, &folder);
                assert_eq!(code, 0, "{name}: {line}\n{error}");
            }
            _ => panic!("{name}: {line}: neither muspin nor cd"),
        }
    }
}

#[test]
fn the_commands_of_the_guide_to_a_machine_of_your_own_run() {
    run_guide("start", false);
}

#[test]
fn the_commands_of_the_guide_to_updating_run() {
    run_guide("updating", false);
    run_guide("records", false);
}

#[test]
fn the_commands_of_the_guides_to_controllers_run() {
    run_guide("comparison", false);
    run_guide("firmware", false);
}

#[test]
fn the_commands_of_the_guide_to_diagnosis_run_and_find_the_eddy_currents() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    assert_eq!(muspin(&["example", "diagnose", "case"], folder).0, 0);
    let (code, out, error) = muspin(&["diagnose", "--measurement", "case/measurement", "--out", "found"], folder);
    assert_eq!(code, 0, "{error}");
    let found: Value = serde_json::from_str(&out).unwrap();
    let effect = &found["diagnosis"]["effects"][0];
    assert_eq!(effect["effect"], "eddy_currents", "{found}");
    assert_eq!(effect["where"]["bearing"], "rear", "{found}");
    let corner = effect["parameters"]["corner_hz"].as_f64().unwrap();
    // The record has 3 kHz; its noise leaves a tenth of a per cent.
    assert!((corner / 3000.0 - 1.0).abs() < 0.01, "{corner}");
    // The page rebuilt from summary and pictures is that of the run: what the page reads survives the file.
    let page = folder.join("found/report.html");
    let written = std::fs::read(&page).unwrap();
    std::fs::remove_file(&page).unwrap();
    assert_eq!(muspin(&["report", "found"], folder).0, 0);
    assert!(std::fs::read(&page).unwrap() == written);
}

#[test]
fn the_commands_of_the_guide_to_solvers_run() {
    run_guide("solvers", false);
}

#[test]
fn init_keeps_what_a_user_has_changed() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    assert_eq!(muspin(&["init", "my"], folder).0, 0);
    let tool = folder.join("my/tool.yaml");
    let changed = std::fs::read_to_string(&tool).unwrap().replace("my-tool", "their-tool");
    std::fs::write(&tool, &changed).unwrap();
    let (code, out, error) = muspin(&["init", "my"], folder);
    assert_eq!((code, out.as_str()), (2, ""), "{error}");
    assert!(error.contains("tool.yaml"), "{error}");
    assert_eq!(std::fs::read_to_string(&tool).unwrap(), changed);
    // Nor does it go over an example, whatever of that is as it was.
    assert_eq!(muspin(&["example", "solve", "case"], folder).0, 0);
    let (code, out, error) = muspin(&["init", "case"], folder);
    assert_eq!((code, out.as_str()), (2, ""), "{error}");
    assert!(error.contains("case") && error.contains("already"), "{error}");
    assert!(folder.join("case/mu.json").exists() && !folder.join("case/tool.yaml").exists());
}

/// G = Y U⁻¹ of a rehearsed sweep is the plant, within the noise that its own covariance states.
#[test]
fn a_rehearsed_sweep_is_the_plant_within_its_noise() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let text = std::fs::read_to_string(root().join("tests/data/anti_windup/pid.json")).unwrap();
    let controller = muspin::input::read_controller("pid.json", &text).unwrap();
    let lines: Vec<f64> = (0..40).map(|k| 30.0 * 100f64.powf(f64::from(k) / 39.0)).collect();
    let rehearsal = Rehearsal { frequency_hz: lines.clone(), repeats: 4, ..Rehearsal::usual(&machine).unwrap() };
    let record = rehearsal.sweep(&machine, &controller, 0.0, "sweep").unwrap();
    let found = open_loop(&record).unwrap();
    let plant = Plant::new(&machine, 0.0, ModelDetail::Full).unwrap();
    let (mut sum, mut count) = (0.0, 0);
    for (k, hz) in lines.iter().enumerate() {
        let exact = plant.at(std::f64::consts::TAU * hz);
        for i in 0..4 {
            for j in 0..4 {
                let deviation = (found.response[(k, i, j)] - exact[(i, j)]).norm();
                sum += (deviation / found.sigma(k, i, j, 0.0)).powi(2);
                count += 1;
            }
        }
    }
    let mean = sum / f64::from(count);
    // 640 squares with the mean one; the variance is estimated from 12 degrees of freedom a line, averaged over five
    // lines.
    assert!((0.8..1.25).contains(&mean), "{mean}");
    let same = rehearsal.sweep(&machine, &controller, 0.0, "sweep").unwrap();
    assert!(same == record, "one seed, one record");
    let other = Rehearsal { seed: 2, ..rehearsal.clone() }.sweep(&machine, &controller, 0.0, "sweep").unwrap();
    assert!(other != record, "another seed, other noise");
    let csv = muspin::report::records::sweep_csv(&record);
    let read = read_sweep("sweep", csv.as_bytes(), 0.0).unwrap();
    for (a, b) in read.signal.iter().zip(&record.signal) {
        // Seven digits are written.
        assert!((a - b).norm() <= 1e-6 * b.norm(), "{a} {b}");
    }
}

#[test]
fn no_measurement_is_rehearsed_with_a_controller_that_does_not_float_the_rotor() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let text = std::fs::read_to_string(root().join("tests/data/anti_windup/pid.json")).unwrap();
    let mut controller: Value = serde_json::from_str(&text).unwrap();
    for row in controller["C"].as_array_mut().unwrap() {
        for x in row.as_array_mut().unwrap() {
            *x = json!(-x.as_f64().unwrap());
        }
    }
    std::fs::write(folder.join("k.json"), controller.to_string()).unwrap();
    let (code, out, error) = muspin(&["rehearse", "--controller", "k.json", "--out", "o"], folder);
    assert_eq!((code, out.as_str()), (2, ""), "{error}");
    assert!(error.contains("unstable") && error.contains("--controller"), "{error}");
    assert!(!folder.join("o").exists());
}

/// A rehearsal has the lines that were asked for, ends included; else the first one lies below the first bending mode.
#[test]
fn the_lines_of_a_rehearsal_can_be_chosen() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let rehearse = |rest: &str| {
        let all: Vec<&str> = ["rehearse"].into_iter().chain(rest.split(' ')).collect();
        muspin(&all, folder)
    };
    let (code, _, error) = rehearse("--from 50 --to 800 --lines 5 --repeats 1 --out o");
    assert_eq!(code, 0, "{error}");
    for (file, rows) in [("o/sweep-0.csv", 4), ("o/hammer-0.csv", 1)] {
        let text = std::fs::read_to_string(folder.join(file)).unwrap();
        let data = text.lines().filter(|l| l.starts_with(|c: char| c.is_ascii_digit()));
        let hz = |line: &str| line.split(',').next().unwrap().parse::<f64>().unwrap();
        let mut found: Vec<f64> = data.map(hz).collect();
        assert_eq!(found.len(), 5 * rows, "{file}");
        found.dedup();
        for (found, exact) in found.iter().zip([50.0, 100.0, 200.0, 400.0, 800.0]) {
            assert!((found / exact - 1.0).abs() < 1e-12, "{found} {exact}");
        }
    }
    for (wrong, says) in
        [("--from 900 --to 800", "no frequency range"), ("--to 1e5", "half the sample rate"), ("--lines 1", "2 to")]
    {
        let (code, _, error) = rehearse(&format!("{wrong} --out p"));
        assert!(code == 2 && error.contains(says), "{wrong}: {error}");
    }
    assert!(!folder.join("p").exists());
    let slender = root().join("tests/data/spindles/s13-lab-rotor.yaml");
    let machine = load_machine(slender.to_str().unwrap(), "paper-tool").unwrap();
    let usual = Rehearsal::usual(&machine).unwrap();
    let (first, last) = usual.range_hz();
    // Its first mode is at 17.1 Hz.
    assert!((first / (17.099 / 50.0) - 1.0).abs() < 1e-3 && last >= 4000.0);
    let steps = usual.frequency_hz.windows(2).map(|w| w[1] / w[0]);
    assert!(steps.into_iter().all(|s| s < 1.009));
}

/// Tests of several seconds each: `cargo test --release --test it long:: -- --ignored`.
mod long {
    use super::*;

    #[test]
    #[ignore = "long: see the command of the module"]
    fn the_slow_commands_of_the_guides_run() {
        run_guide("start", true);
        run_guide("comparison", true);
        run_guide("design", true);
        run_guide("pid", true);
    }
}
