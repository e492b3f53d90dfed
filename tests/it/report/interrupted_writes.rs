//! What is left when a command is killed while it writes, and when the disk is full: the results of the run before or
//! the new ones, every file whole.

use crate::cli::program::muspin;
use crate::support::folder::tree;
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

const RECORD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/identify/c03");
const MANIFEST: &str = "muspin-manifest.json";

fn hash(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().map(|b| format!("{b:02x}")).collect()
}

/// Results that differ from those of [`RECORD`]: the same record without the first line of the hammer test.
fn other_record(folder: &Path) -> String {
    let copy = folder.join("record");
    std::fs::create_dir(&copy).unwrap();
    for (name, bytes) in tree(Path::new(RECORD)) {
        let mut bytes = bytes;
        if name.starts_with("hammer") {
            let end_of = |bytes: &[u8]| bytes.iter().position(|b| *b == b'\n').unwrap() + 1;
            let header = end_of(&bytes);
            let line = end_of(&bytes[header..]);
            bytes.drain(header..header + line);
        }
        std::fs::write(copy.join(name), bytes).unwrap();
    }
    copy.display().to_string()
}

fn identify(record: &str, folder: &Path) {
    let arguments = ["identify", "--measurement", record, "--out", "out"];
    let (code, _, err) = muspin(&arguments, folder);
    assert_eq!(code, 0, "{err}");
}

/// Starts the command and kills it `delay` after it has begun to fill its working folder; true when it was still running then.
fn killed(record: &str, folder: &Path, delay: Duration) -> bool {
    let mut child = Command::new(env!("CARGO_BIN_EXE_muspin"))
        .args(["identify", "--measurement", record, "--out", "out"])
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let writes = || {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut working =
            entries.map(Result::unwrap).filter(|e| e.file_name().to_string_lossy().starts_with(".muspin-"));
        // Before the run starts, a working folder is made and removed to see that it can be.
        working.any(|e| e.path().join("new").exists())
    };
    let start = Instant::now();
    while !writes() && child.try_wait().unwrap().is_none() {
        assert!(start.elapsed() < Duration::from_secs(60), "never writes");
    }
    std::thread::sleep(delay);
    let running = child.try_wait().unwrap().is_none();
    // On Unix this is SIGKILL: the process has no chance to tidy up.
    child.kill().unwrap();
    child.wait().unwrap();
    for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
        if entry.file_name().to_string_lossy().starts_with(".muspin-") {
            std::fs::remove_dir_all(entry.path()).unwrap();
        }
    }
    running
}

/// Every file is one that the manifest lists, whole; nothing else stands there but `kept`.
fn is_whole(folder: &Path, kept: &[&str], case: &str) {
    let found = tree(folder);
    let manifest: Value = serde_json::from_slice(&found[MANIFEST]).unwrap();
    for (name, bytes) in &found {
        if name == MANIFEST || kept.contains(&name.as_str()) {
            continue;
        }
        let listed = |key: &str| manifest[key][name] == hash(bytes);
        assert!(listed("files") || listed("replacing"), "{case}: {name}");
    }
}

#[test]
fn a_command_that_is_killed_while_it_writes_leaves_whole_files() {
    let scratch = TempDir::new().unwrap();
    let folder = scratch.path();
    let (old, new) = (RECORD.to_owned(), other_record(folder));
    let out = folder.join("out");
    identify(&new, folder);
    let new_files = tree(&out);
    identify(&old, folder);
    let old_files = tree(&out);
    assert!(old_files != new_files);
    // With a file of the user the results are replaced one by one, without it the folder is exchanged as a whole.
    for kept in [None, Some("notes.txt")] {
        if let Some(name) = kept {
            std::fs::write(out.join(name), "mine").unwrap();
        }
        let with = |files: &BTreeMap<String, Vec<u8>>| {
            let mut files = files.clone();
            files.extend(kept.map(|name| (name.to_owned(), b"mine".to_vec())));
            files
        };
        let mut hit = 0;
        // Writing takes some milliseconds; the later delays are for a slow disk.
        for delay_us in [0, 200, 500, 1000, 2000, 3000, 5000, 8000, 12_000, 20_000] {
            let case = format!("{kept:?}, killed {delay_us} µs after the start of writing");
            hit += usize::from(killed(&new, folder, Duration::from_micros(delay_us)));
            let found = tree(&out);
            match kept {
                None => assert!(found == old_files || found == new_files, "{case}"),
                Some(name) => is_whole(&out, &[name], &case),
            }
            // The next run takes up from whatever is there.
            identify(&old, folder);
            assert!(tree(&out) == with(&old_files), "{case}");
        }
        assert!(hit > 0, "never killed in time");
    }
}

#[test]
fn a_first_run_that_is_killed_leaves_no_folder_or_a_whole_one() {
    let scratch = TempDir::new().unwrap();
    let out = scratch.path().join("out");
    for delay_us in [0, 1000, 3000] {
        killed(RECORD, scratch.path(), Duration::from_micros(delay_us));
        if out.exists() {
            is_whole(&out, &[], &format!("{delay_us} µs"));
            std::fs::remove_dir_all(&out).unwrap();
        }
    }
}

/// Runs the command in a shell that limits the size of a file to `blocks` of 512 bytes, without a signal at the limit.
#[cfg(unix)]
fn limited(blocks: u32, folder: &Path) -> (i32, String) {
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" identify --measurement \"$1\" --out out");
    let done = Command::new("sh")
        .args(["-c", &script])
        .arg(env!("CARGO_BIN_EXE_muspin"))
        .arg(RECORD)
        .current_dir(folder)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&done.stderr).into_owned();
    (done.status.code().unwrap(), text)
}

#[cfg(unix)]
#[test]
fn a_disk_without_room_leaves_the_results_before_and_names_the_file() {
    let scratch = TempDir::new().unwrap();
    let folder = scratch.path();
    let left = || std::fs::read_dir(folder).unwrap().count();
    // The table of the sweep has two megabytes.
    let (code, message) = limited(64, folder);
    assert_eq!((code, left()), (2, 0), "{message}");
    let first = message.lines().next().unwrap();
    assert!(first.starts_with("error: ") && first.contains("out/frf-0.csv'"), "{message}");
    identify(RECORD, folder);
    let before = tree(&folder.join("out"));
    let (code, message) = limited(64, folder);
    assert_eq!((code, left()), (2, 1), "{message}");
    assert!(tree(&folder.join("out")) == before, "{message}");
    assert!(message.contains("out/frf-0.csv'"), "{message}");
}

#[cfg(target_os = "linux")]
#[test]
fn standard_output_without_room_is_an_error() {
    for command in [&["modes"][..], &["frf", "--points", "3"]] {
        let full = std::fs::File::options().write(true).open("/dev/full");
        let done = Command::new(env!("CARGO_BIN_EXE_muspin")).args(command).stdout(full.unwrap()).output().unwrap();
        let message = String::from_utf8_lossy(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{message}");
        assert!(message.contains("standard output"), "{message}");
    }
}
