//! Files that are not what they should be: pipes, devices, sizes beyond every use, text that acts on a terminal.

use crate::cli::program::muspin;
use muspin::input::file::{self, KEYS, RECORD, ReadShare};
use muspin::input::hammer::read_hammer;
use muspin::input::mat::{matrices, read_controller};
use muspin::input::name::check_name;
use muspin::input::{
    InputError, load_controller, load_measurement, load_measurement_watched, load_spindle, read_spindle, read_tool,
    read_weights,
};
use std::cell::Cell;
use std::fmt::Write;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Command;

fn here() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// A measurement folder that lists one hammer record.
fn measurement(folder: &Path, record: &str) -> String {
    let list = format!(
        "spindle: reference\ntool: paper-tool\nrecords:\n  - kind: hammer\n    file: {record}\n    speed_rpm: 0\n"
    );
    std::fs::write(folder.join("measurement.yaml"), list).unwrap();
    folder.to_str().unwrap().to_owned()
}

#[test]
#[cfg(unix)]
fn pipes_and_devices_are_told_and_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = |name: &str| {
        let path = folder.path().join(name);
        assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
        path.to_str().unwrap().to_owned()
    };
    let told = |error: InputError| {
        let message = error.to_string();
        assert!(message.contains("is a pipe, not a file") && error.hint.is_some(), "{message}");
    };
    told(load_spindle(&pipe("s.yaml")).unwrap_err());
    told(load_controller(&pipe("k.json")).unwrap_err());
    told(load_controller(&pipe("k.mat")).unwrap_err());
    for record in ["a.csv", "a.uff"] {
        pipe(record);
        told(load_measurement(&measurement(folder.path(), record)).unwrap_err());
    }
    for (name, arguments) in [("p.json", &["solve", "care"][..]), ("c.csv", &["check"]), ("u.unv", &["check"])] {
        let path = pipe(name);
        let (code, _, error) = muspin(&[arguments, &[&path]].concat(), &here());
        assert_eq!(code, 2);
        assert!(error.contains("is a pipe, not a file"), "{error}");
    }
    std::os::unix::fs::symlink("/dev/zero", folder.path().join("endless.csv")).unwrap();
    let error = load_measurement(&measurement(folder.path(), "endless.csv")).unwrap_err();
    assert!(error.to_string().contains("endless.csv: is a device, not a file"), "{error}");
    let error = load_spindle("/dev/zero").unwrap_err();
    assert!(error.to_string().contains("is a device"), "{error}");
}

#[test]
fn a_file_is_read_to_its_limit_and_no_further() {
    let folder = tempfile::tempdir().unwrap();
    // Files without blocks on the disk.
    let sparse = |name: &str, bytes: u64| {
        let path = folder.path().join(name);
        std::fs::File::create(&path).unwrap().set_len(bytes).unwrap();
        path
    };
    for (name, bytes, words) in [
        ("s.yaml", (1 << 20) + 1, "more than 1048576 bytes"),
        ("k.json", (32 << 20) + 1, "more than 33554432 bytes"),
        ("k.mat", (256 << 20) + 1, "more than 268435456 bytes"),
        ("r.csv", (4 << 30) + 1, "more than 4294967296 bytes"),
        ("r.uff", (128 << 20) + 1, "more than 134217728 bytes"),
    ] {
        let path = sparse(name, bytes);
        let (code, _, error) = muspin(&["check", path.to_str().unwrap()], &here());
        assert_eq!(code, 2, "{name}");
        assert!(error.contains(words) && error.contains("hint:"), "{name}: {error}");
    }
    let long = sparse("long.yaml", 1 << 20);
    assert_eq!(file::read(&long, KEYS).unwrap().len(), 1 << 20);
    // A record of one endless line is no table, and no line is longer than a table's.
    let path = sparse("zeros.csv", 1 << 30);
    let (code, _, error) = muspin(&["check", path.to_str().unwrap()], &here());
    assert_eq!(code, 2);
    assert!(error.contains("zeros.csv:1: has more than 4096 bytes in one line"), "{error}");
}

/// The system states no size for files of `/proc`.
#[test]
#[cfg(target_os = "linux")]
fn a_size_that_is_not_stated_is_no_reason_to_read_nothing() {
    let status = file::read(Path::new("/proc/self/status"), KEYS).unwrap();
    assert!(String::from_utf8(status).unwrap().contains("VmPeak"));
    let mut text = String::new();
    file::open(Path::new("/proc/self/status"), RECORD).unwrap().read_to_string(&mut text).unwrap();
    assert!(text.contains("VmPeak"));
}

/// A long record takes the memory of its numbers, not of its text: 64 MB of text within 48 MiB more than a short one.
#[test]
#[cfg(target_os = "linux")]
fn a_record_is_read_line_by_line() {
    let folder = tempfile::tempdir().unwrap();
    let record = |name: &str, rows: usize| {
        let mut text = "frequency_hz,h_re,h_im,coherence,averages\n".to_owned();
        let blanks = " ".repeat(4000);
        for k in 0..rows {
            writeln!(text, "{}.5,1e-8,-2e-8,0.99,{blanks}10", k + 10).unwrap();
        }
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let (short, long) = (record("short.csv", 10), record("long.csv", 16_000));
    let within = |path: &Path, kib: usize| {
        let script = format!("ulimit -v {kib}; exec \"$0\" check --threads 1 \"$1\"");
        let mut command = Command::new("sh");
        let run = command.arg("-c").arg(script).arg(env!("CARGO_BIN_EXE_muspin")).arg(path).output().unwrap();
        run.status.code() == Some(0)
    };
    // Whoever watches hears of every part.
    let list = measurement(folder.path(), "long.csv");
    let (heard, last) = (Cell::new(0), Cell::new(0));
    let watch = |share: ReadShare<'_>| {
        assert!(share.done_bytes <= share.all_bytes && share.file == long);
        heard.set(heard.get() + 1);
        last.set(share.done_bytes);
    };
    load_measurement_watched(&list, &watch).unwrap();
    assert!(heard.get() > 10 && last.get() == std::fs::metadata(&long).unwrap().len());
    // How much the program itself takes depends on the system.
    let steps = (0..200).map(|k| (32 + 8 * k) << 10);
    let enough = steps.into_iter().find(|kib| within(&short, *kib)).unwrap();
    assert!(within(&long, enough + (48 << 10)), "{enough} KiB for a short record");
}

#[test]
fn rows_end_as_any_editor_ends_them() {
    let lines = ["frequency_hz,h_re,h_im,coherence,averages", "10,1e-8,2e-8,0.9,4", "", "20,1e-8,2e-8,0.9,4"];
    let read = |text: &str| read_hammer("h.csv", text.as_bytes(), 0.0);
    let wanted = read(&lines.join("\n")).unwrap();
    assert_eq!(wanted.frequency_hz, [10.0, 20.0]);
    for end in ["\r\n", "\r"] {
        assert_eq!(read(&lines.join(end)).unwrap(), wanted);
        assert_eq!(read(&(lines.join(end) + end)).unwrap(), wanted);
        let error = read(&(lines.join(end) + end + "x,0,0,1,1")).unwrap_err();
        assert_eq!(error.line, Some(5), "{error}");
    }
    let quoted = lines.map(|line| line.replace("frequency_hz", "\"frequency_hz\"").replace("0.9", " \"0.9\" "));
    assert_eq!(read(&format!("\u{feff}{}", quoted.join("\n"))).unwrap(), wanted);
}

/// A level-5 element.
fn element(kind: u32, stated: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = [kind.to_le_bytes(), stated.to_le_bytes()].concat();
    bytes.extend_from_slice(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

/// A matrix of doubles whose sizes need not fit its numbers.
fn matrix(name: &str, rows: u32, columns: u32, numbers: &[f64]) -> Vec<u8> {
    let words = |list: [u32; 2]| list.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>();
    let numbers: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    let parts = [
        element(6, 8, &words([6, 0])),
        element(5, 8, &words([rows, columns])),
        element(1, name.len() as u32, name.as_bytes()),
        element(9, numbers.len() as u32, &numbers),
    ];
    let all = parts.concat();
    element(14, all.len() as u32, &all)
}

fn packed(matrix: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut encoder = flate2::write::ZlibEncoder::new(vec![], flate2::Compression::fast());
    encoder.write_all(matrix).unwrap();
    let data = encoder.finish().unwrap();
    [15u32.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat().into_iter().chain(data).collect()
}

fn level_5(variables: &[Vec<u8>]) -> Vec<u8> {
    let mut file = vec![b' '; 124];
    file.extend_from_slice(&[0, 1, b'I', b'M']);
    file.extend(variables.concat());
    file
}

#[test]
fn sizes_of_a_matlab_file_are_checked_before_anything_is_made() {
    let rest = |a: Vec<u8>| {
        level_5(&[
            a,
            matrix("B", 0, 4, &[]),
            matrix("C", 4, 0, &[]),
            matrix("D", 4, 4, &[0.0; 16]),
            matrix("Ts", 1, 1, &[0.0]),
        ])
    };
    read_controller("k.mat", &rest(matrix("A", 0, 0, &[]))).unwrap();
    // Four thousand million rows of nothing, and sizes whose product overflows.
    for (rows, columns, part) in
        [(u32::MAX, 0, "is 4294967295 × 0"), (u32::MAX, u32::MAX, "do not fit its numbers"), (3, 3, "do not fit")]
    {
        let error = read_controller("k.mat", &rest(matrix("A", rows, columns, &[]))).unwrap_err();
        assert!(error.to_string().contains(part), "{error}");
    }
    let error = read_controller("k.mat", &rest(matrix("B", 0, 4, &[]))).unwrap_err();
    assert!(error.to_string().contains("has two matrices B") || error.to_string().contains("no matrix A"), "{error}");
}

#[test]
fn the_matrices_of_a_matlab_file_share_one_budget() {
    // 40 MiB of zeros each: two of a controller's names are too much, those of other names are passed over.
    let zeros = vec![0.0; 5 << 20];
    let big = |name: &str| packed(&matrix(name, 5 << 20, 1, &zeros));
    let error = read_controller("k.mat", &level_5(&[big("A"), big("B")])).unwrap_err();
    assert!(error.to_string().contains("more than 64 MiB"), "{error}");
    let others: Vec<Vec<u8>> = (0..8).map(|_| big("workspace")).chain([matrix("Ts", 1, 1, &[0.0])]).collect();
    let error = read_controller("k.mat", &level_5(&others)).unwrap_err();
    assert!(error.to_string().contains("has no matrix A"), "{error}");
    // A checksum that is wrong is found.
    let mut damaged = level_5(&[packed(&matrix("A", 1, 1, &[2.0]))]);
    assert_eq!(matrices("k.mat", &damaged).unwrap()[0].values.as_deref(), Some(&[2.0][..]));
    *damaged.last_mut().unwrap() ^= 1;
    assert!(matrices("k.mat", &damaged).is_err());
}

#[test]
fn a_matlab_file_of_version_7_3_is_told_as_such() {
    let mut text = vec![0; 600];
    text[..19].copy_from_slice(b"MATLAB 7.3 MAT-file");
    text[124..128].copy_from_slice(&[0, 2, b'I', b'M']);
    text[512..520].copy_from_slice(b"\x89HDF\r\n\x1a\n");
    for bytes in [&text[..], &text[512..]] {
        let error = read_controller("k.mat", bytes).unwrap_err();
        assert!(error.to_string().contains("7.3") && error.hint.unwrap().contains("'-v7'"));
    }
}

#[test]
fn names_are_words_of_any_script_and_nothing_else() {
    let letters = ["endmill-10", "Fräser 12 lang", "刀具_3", "фреза+1", "a.b", "com10", "nula", "e\u{301}bauche", "µ"];
    for name in letters {
        check_name(name).unwrap();
    }
    let long = "x".repeat(129);
    for name in [
        "",
        " a",
        "a ",
        ".a",
        "a.",
        "-rf",
        "a/b",
        "a\\b",
        "..",
        "a\nb",
        "a\tb",
        "a'b",
        "a\"b",
        "a`b",
        "$(a)",
        "a;b",
        "a|b",
        "a*",
        "a?",
        "a:b",
        "a\u{202e}b",
        "a\u{200b}b",
        "a\0",
        "NUL",
        "con",
        "Com1",
        "lpt9.yaml",
        "aux.tar.gz",
        "com¹",
        &long,
    ] {
        assert!(check_name(name).is_err(), "{name:?}");
    }
    let spindle = load_spindle("reference").unwrap();
    let text = include_str!("../../../spindles/tools/endmill-10.yaml");
    for name in ["\"a'; touch x; '\"", "\"a\\ntouch x #\"", "../../x", "\"\\u202ea\"", "nul"] {
        let text = text.replacen("name: endmill-10", &format!("name: {name}"), 1);
        let error = read_tool("t.yaml", &text, &spindle).unwrap_err();
        assert!(error.to_string().starts_with("t.yaml:3: name: "), "{error}");
    }
}

#[test]
fn lists_have_a_length() {
    let list = |count: usize| vec!["0.01"; count].join(", ");
    let spindle = include_str!("../../../spindles/reference.yaml");
    let begin = spindle.find("damping_ratio: [").unwrap();
    let end = begin + spindle[begin..].find(']').unwrap();
    let text = format!("{}damping_ratio: [{}{}", &spindle[..begin], list(101), &spindle[end..]);
    let error = read_spindle("s.yaml", &text).unwrap_err();
    assert!(error.to_string().contains("rotor.damping_ratio: has 101 entries; at most 100"), "{error}");
    let weights = include_str!("../../../weights/benchmark.yaml");
    let begin = weights.find("mode_uncertainty: [").unwrap();
    let end = begin + weights[begin..].find(']').unwrap();
    let text = format!("{}mode_uncertainty: [{}{}", &weights[..begin], list(100_001), &weights[end..]);
    let error = read_weights("w.yaml", &text).unwrap_err();
    assert!(error.to_string().contains("mode_uncertainty: has 100001 entries; at most 100"), "{error}");
    let elements = "  - {length_m: 0.01, outer_diameter_m: 0.01, material: steel}\n".repeat(1001);
    let tool = format!("name: t\nelements:\n{elements}tool_plane_m: 0.01\n");
    let error = read_tool("t.yaml", &tool, &load_spindle("reference").unwrap()).unwrap_err();
    assert!(error.to_string().contains("elements: has 1001 entries"), "{error}");
}

#[test]
fn a_problem_has_a_size() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.json");
    let rows = format!("[{}]", vec!["[1]"; 1001].join(","));
    let list = format!("[{}]", vec!["1"; 10_001].join(","));
    for (kind, text, part) in [
        ("care", format!("{{\"A\": {rows}}}"), "A: is 1001 x 1; at most 1000"),
        ("dfit", format!("{{\"orders\": {list}}}"), "orders: has 10001 entries; at most 10000"),
        ("dfit", "{\"orders\": [1e15]}".to_owned(), "orders[0]: expected a whole number"),
    ] {
        std::fs::write(&path, text).unwrap();
        let (code, _, error) = muspin(&["solve", kind, path.to_str().unwrap()], &here());
        assert!(code == 2 && error.contains(part), "{error}");
    }
}

#[test]
fn foreign_text_is_quoted_short_and_acts_on_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let secret = folder.path().join("secret");
    std::fs::write(&secret, "root:x:0:0:root\n".repeat(500)).unwrap();
    let error = load_spindle(secret.to_str().unwrap()).unwrap_err().to_string();
    assert!(error.len() < 400 && error.matches("root").count() < 12, "{error}");
    std::fs::write(folder.path().join("x.csv"), "y".repeat(4000)).unwrap();
    let error = load_measurement(&measurement(folder.path(), "x.csv")).unwrap_err().to_string();
    assert!(error.contains(&format!("{}…", "y".repeat(59))) && !error.contains(&"y".repeat(60)), "{error}");
    // Escape sequences, bells and marks of direction in names of files, keys and values.
    let list = measurement(folder.path(), "\"\\e]0;pwn\\a\\u202e\\e[2Jx.csv\"");
    let (_, out, error) = muspin(&["check", &list], &here());
    for part in ['\u{1b}', '\u{7}', '\u{202e}'] {
        assert!(!(out.clone() + &error).contains(part), "{error}");
    }
    assert!(error.contains("\\u{1b}]0;pwn\\u{7}\\u{202e}\\u{1b}[2Jx.csv"), "{error}");
    let named = folder.path().join("a\u{1b}[31m\nb.yaml");
    std::fs::copy(here().join("weights/benchmark.yaml"), &named).unwrap();
    for form in ["--text", "--json"] {
        let (code, out, error) = muspin(&["check", form, named.to_str().unwrap()], &here());
        assert_eq!(code, 0, "{error}");
        assert!(!out.contains('\u{1b}') && !error.contains('\u{1b}') && out.contains("[31m"), "{out}");
    }
}

/// What a text makes of a byte is bounded as well: braces of YAML, brackets of JSON.
#[test]
#[cfg(target_os = "linux")]
fn files_of_the_largest_size_are_refused_within_a_gibibyte() {
    let folder = tempfile::tempdir().unwrap();
    let texts = [
        ("maps.yaml", format!("rotor: [{}]", "{},".repeat(340_000))),
        ("zeros.yaml", format!("rotor: [{}]", "0,".repeat(520_000))),
        ("rows.json", format!("{{\"name\": \"a\", \"A\": [{}[]]}}", "[],".repeat(11_000_000))),
        ("key.json", format!("{{\"{}\": 1}}", "a".repeat(33_000_000))),
    ];
    for (name, text) in texts {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let begun = std::time::Instant::now();
        let mut command = Command::new("sh");
        let script = "ulimit -v 1048576; exec \"$0\" check \"$1\"";
        let run = command.arg("-c").arg(script).arg(env!("CARGO_BIN_EXE_muspin")).arg(&path).output().unwrap();
        let said = String::from_utf8_lossy(&run.stderr).into_owned();
        assert!(run.status.code() == Some(2) && said.contains(name) && said.len() < 1000, "{said}");
        // The nearest key to a name of a megabyte took minutes.
        assert!(begun.elapsed().as_secs() < 20, "{name}");
    }
}
