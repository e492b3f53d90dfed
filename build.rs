//! Tells release builds their commit, as `MUSPIN_COMMIT`: the variable of the environment where it is set, else what git
//! says of this folder. A debug build would be compiled anew after each commit and has none.

use std::path::Path;
use std::process::Command;

/// What a build is made of; a change in it is a change against the commit.
const SOURCES: [&str; 7] = ["src", "spindles", "weights", "build.rs", "Cargo.toml", "Cargo.lock", ".cargo"];

fn main() {
    println!("cargo::rerun-if-env-changed=MUSPIN_COMMIT");
    println!("cargo::rerun-if-changed=build.rs");
    let is_release = std::env::var("PROFILE").is_ok_and(|profile| profile == "release");
    if std::env::var_os("MUSPIN_COMMIT").is_some() || !is_release {
        return;
    }
    if let Some(commit) = find_commit() {
        println!("cargo::rustc-env=MUSPIN_COMMIT={commit}");
    }
}

/// Commit of this folder with a mark where its sources differ; none where it is not the root of a repository.
fn find_commit() -> Option<String> {
    let root = git(&["rev-parse", "--show-toplevel"])?;
    if Path::new(&root).canonicalize().ok()? != Path::new(env!("CARGO_MANIFEST_DIR")).canonicalize().ok()? {
        return None;
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?;
    // The log of HEAD grows with every commit and change of branch.
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"])?;
    for path in SOURCES.iter().copied().chain([log.as_str()]) {
        println!("cargo::rerun-if-changed={path}");
    }
    let changed = git(&[&["status", "--porcelain", "--"], &SOURCES[..]].concat())?;
    let mark = if changed.is_empty() { "" } else { " with changes" };
    Some(format!("{commit}{mark}"))
}

/// What a git command prints; none where it fails or there is no git.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
