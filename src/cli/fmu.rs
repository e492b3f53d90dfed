//! `muspin export --fmu`: the binaries of co-simulation units, compiled with the C compiler of this machine.

use super::Failure;
use crate::export::fmu::{FmiVersion, FmuUnit};
use std::path::Path;
use std::process::Command;

/// The archives of a unit in both versions; the note says why there is no binary in them.
pub(super) fn archives(unit: &FmuUnit) -> Result<(Vec<(String, Vec<u8>)>, Option<String>), Failure> {
    let (mut files, mut note) = (vec![], None);
    let platform = platform();
    for version in FmiVersion::ALL {
        let library = match platform {
            Some(_) => library(unit, version)?,
            None => Err("no name of this platform is known".to_owned()),
        };
        let binary = match (library, platform) {
            (Ok(bytes), Some((name, ending))) => Some((name, ending, bytes)),
            (Err(reason), _) => {
                note = Some(format!("{}: sources only, no binary: {reason}", unit.name));
                None
            }
            _ => None,
        };
        let Some(bytes) = unit.archive(version, binary) else {
            return Err(Failure::new(format!("{}: the unit is larger than an archive can be", unit.name)));
        };
        files.push((format!("{}-{}.fmu", unit.name, version.name()), bytes));
    }
    Ok((files, note))
}

/// This platform in the words of FMI 3.0, and the ending of its libraries.
fn platform() -> Option<(&'static str, &'static str)> {
    match (std::env::consts::ARCH, std::env::consts::OS) {
        ("x86_64", "linux") => Some(("x86_64-linux", ".so")),
        ("aarch64", "linux") => Some(("aarch64-linux", ".so")),
        ("x86_64", "macos") => Some(("x86_64-darwin", ".dylib")),
        ("aarch64", "macos") => Some(("aarch64-darwin", ".dylib")),
        _ => None,
    }
}

/// The compiled unit, or the reason why there is none.
fn library(unit: &FmuUnit, version: FmiVersion) -> Result<Result<Vec<u8>, String>, Failure> {
    let failed = |what: std::io::Error| Failure::new(format!("temporary folder for the compiler: {what}"));
    let folder = tempfile::tempdir().map_err(failed)?;
    for (name, bytes) in &unit.sources {
        std::fs::write(folder.path().join(name), bytes).map_err(failed)?;
    }
    let mut compiler = Command::new("cc");
    compiler.current_dir(folder.path()).args(["-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden"]);
    if version == FmiVersion::Two {
        compiler.arg("-DUNIT_FMI2");
    }
    let done = compiler.args(unit.compiled()).args(["-o", "unit", "-lm"]).output();
    Ok(match done {
        Err(error) => Err(format!("the compiler cc cannot be started ({error})")),
        Ok(done) if !done.status.success() => {
            let said = String::from_utf8_lossy(&done.stderr);
            Err(format!("cc failed: {}", said.lines().next().unwrap_or("without a word")))
        }
        Ok(_) => {
            let made: &Path = &folder.path().join("unit");
            crate::input::file::read(made, crate::input::file::WRITTEN).map_err(|error| error.of("unit").to_string())
        }
    })
}
