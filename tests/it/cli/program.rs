//! The program as a user runs it: exit code, standard output and standard error.

use std::path::Path;

/// Runs `muspin` with `arguments` in `folder`.
pub fn muspin(arguments: &[&str], folder: &Path) -> (i32, String, String) {
    let output =
        assert_cmd::Command::cargo_bin("muspin").unwrap().args(arguments).current_dir(folder).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}
