//! Results folders of others, and folders that are mounted or written by several runs at once.

use crate::cli::program::muspin;
use muspin::report::manifest::{MANIFEST, Manifest};
use muspin::report::results::{ResultsError, ResultsFolder, claim};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::process::Command;

fn here() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

const OWN: &str = "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" width=\"9\" height=\"9\">\n<title>Mine &amp; \
    yours</title>\n<polyline fill=\"none\" points=\"1,2 3,4\"/>\n<text x=\"1\" y=\"2\">\nwords\n</text>\n</svg>\n";

/// A results folder with a picture of muspin's kind.
fn results(folder: &Path) -> PathBuf {
    let target = folder.join("run");
    let mut staged = ResultsFolder::new();
    staged.add("summary.json", "{\"spindle\": \"a\\u202eb\"}").unwrap();
    staged.add("plots/mu.svg", OWN).unwrap();
    staged.write(&target).unwrap();
    target
}

/// The page of the folder, and what was said.
fn page(target: &Path) -> (String, String) {
    let (code, _, said) = muspin(&["report", target.to_str().unwrap()], &here());
    assert_eq!(code, 0, "{said}");
    (std::fs::read_to_string(target.join("report.html")).unwrap(), said)
}

/// Lists a file in the manifest with its hash, as whoever hands over the folder can.
fn list(target: &Path, path: &str) {
    let mut manifest = Manifest::read(target).unwrap();
    let hash = Sha256::digest(std::fs::read(target.join(path)).unwrap());
    manifest.files.insert(path.to_owned(), hash.iter().map(|byte| format!("{byte:02x}")).collect());
    std::fs::write(target.join(MANIFEST), manifest.to_json()).unwrap();
}

#[test]
fn a_page_shows_the_pictures_that_muspin_wrote_and_no_others() {
    let folder = tempfile::tempdir().unwrap();
    let target = results(folder.path());
    let (shown, said) = page(&target);
    assert!(shown.contains("Mine &amp; yours") && said.is_empty(), "{said}");
    assert!(!shown.contains('\u{202e}') && shown.contains("a\\u{202e}b"));

    std::fs::write(target.join("plots/unlisted.svg"), OWN.replace("Mine", "Unlisted")).unwrap();
    let foreign = [
        ("script", "<script>alert(1)</script>"),
        ("handler", "<rect onload=\"alert(1)\"/>"),
        ("link", "<a href=\"https://example.org\"><text>x</text></a>"),
        ("refresh", "<meta http-equiv=\"refresh\" content=\"0\"/>"),
        ("style", "<style>body { display: none }</style>"),
        ("html", "<foreignObject><p>x</p></foreignObject>"),
        ("image", "<image href=\"data:x\"/>"),
        ("animated", "<rect><animate attributeName=\"href\" values=\"x\"/></rect>"),
        ("closed", "</svg><p>x</p><svg>"),
        ("comment", "<!-- <p> -->"),
        ("unquoted", "<rect x=1 onload=alert(1)>x</rect>"),
    ];
    for (name, inside) in foreign {
        let svg = OWN.replace("<title>Mine &amp; yours</title>", &format!("<title>Foreign</title>{inside}"));
        let path = format!("plots/{name}.svg");
        std::fs::write(target.join(&path), svg).unwrap();
        list(&target, &path);
    }
    let (shown, said) = page(&target);
    assert!(shown.contains("Mine &amp; yours") && !shown.contains("Unlisted") && !shown.contains("Foreign"));
    for name in ["unlisted.svg", "script.svg", "handler.svg", "animated.svg"] {
        assert_eq!(said.matches(name).count(), 1, "{said}");
    }
    // A picture that was changed since, though it is harmless.
    std::fs::write(target.join("plots/mu.svg"), OWN.replace("Mine", "Changed")).unwrap();
    let (shown, said) = page(&target);
    assert!(!shown.contains("Changed") && !said.is_empty());
}

#[test]
#[cfg(unix)]
fn a_page_follows_no_link_and_waits_for_no_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let target = results(folder.path());
    let outside = folder.path().join("outside.svg");
    std::fs::write(&outside, OWN.replace("Mine", "Outside")).unwrap();
    std::os::unix::fs::symlink(&outside, target.join("plots/link.svg")).unwrap();
    list(&target, "plots/link.svg");
    assert!(Command::new("mkfifo").arg(target.join("plots/pipe.svg")).status().unwrap().success());
    let (shown, said) = page(&target);
    assert!(!shown.contains("Outside") && shown.contains("Mine"));
    assert!(said.contains("link.svg") && said.contains("pipe.svg"), "{said}");
    std::fs::rename(target.join("plots"), folder.path().join("elsewhere")).unwrap();
    std::os::unix::fs::symlink(folder.path().join("elsewhere"), target.join("plots")).unwrap();
    assert!(!page(&target).0.contains("<svg"));
}

#[test]
fn the_policy_of_a_page_names_its_own_script_and_styles() {
    let folder = tempfile::tempdir().unwrap();
    let (shown, _) = page(&results(folder.path()));
    let between = |begin: &str, end: &str| shown.split(begin).nth(1).unwrap().split(end).next().unwrap();
    let policy = between("http-equiv=\"Content-Security-Policy\" content=\"", "\">");
    assert!(policy.starts_with("default-src 'none';") && !policy.contains("unsafe"), "{policy}");
    let digits = |text: &str| {
        let bits = Sha256::digest(text).iter().map(|byte| format!("{byte:08b}")).collect::<String>() + "00";
        let letters: Vec<char> = ('A'..='Z').chain('a'..='z').chain('0'..='9').chain(['+', '/']).collect();
        let six = bits.as_bytes().chunks(6).map(|six| str::from_utf8(six).unwrap());
        six.map(|six| letters[usize::from_str_radix(six, 2).unwrap()]).collect::<String>()
    };
    for (directive, text) in
        [("script-src", between("<script>", "</script>")), ("style-src", between("<style>", "</style>"))]
    {
        let part = policy.split(';').find(|part| part.trim().starts_with(directive)).unwrap();
        assert!(part.contains(&format!("'sha256-{}='", digits(text))), "{part}");
    }
    // The policy stands before what it governs, and nothing on the page needs an attribute that it forbids.
    assert!(shown.find("Content-Security-Policy").unwrap() < shown.find("<style>").unwrap());
    assert!(!shown.contains(" style=\"") && !shown.contains(" onclick"));
}

#[test]
fn several_runs_write_one_new_folder_one_after_the_other() {
    let folder = tempfile::tempdir().unwrap();
    for round in 0..10 {
        let target = folder.path().join(format!("new-{round}/run"));
        let write = |run: usize| {
            let mut staged = ResultsFolder::new();
            for name in ["a", "b/c", "d"] {
                staged.add(name, format!("{run}")).unwrap();
            }
            staged.write(&target)
        };
        std::thread::scope(|scope| {
            let runs: Vec<_> = (0..5).map(|run| scope.spawn(move || write(run))).collect();
            runs.into_iter().for_each(|run| run.join().unwrap().unwrap());
        });
        // The folder is that of one run.
        let text = |name: &str| std::fs::read_to_string(target.join(name)).unwrap();
        assert!(text("a") == text("b/c") && text("a") == text("d"));
        let beside = std::fs::read_dir(target.parent().unwrap()).unwrap();
        assert_eq!(beside.count(), 1, "no temporary folder is left");
    }
}

#[test]
fn a_folder_is_meant_where_its_dots_lead() {
    let folder = tempfile::tempdir().unwrap();
    let measured = folder.path().join("m");
    std::fs::create_dir(&measured).unwrap();
    std::fs::write(measured.join("measurement.yaml"), "records: []").unwrap();
    for path in ["m/absent/..", "m/./absent/deep/../..", "other/../m"] {
        let refused = claim(&folder.path().join(path), &[], &[]);
        assert!(matches!(refused, Err(ResultsError::Measurement { .. })), "{path}: {refused:?}");
    }
    let mut staged = ResultsFolder::new();
    staged.add("a", "1").unwrap();
    staged.write(&folder.path().join("m/absent/../../new/./x/../y")).unwrap();
    assert!(folder.path().join("new/y/a").is_file() && !folder.path().join("m/absent").exists());
    let refused = claim(&folder.path().join("new/y/a/b"), &[], &[]);
    assert!(matches!(refused, Err(ResultsError::NotAFolder { .. })), "{refused:?}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "a claim leaves nothing");
}

/// A file system of its own at the folder or in it, as containers and network shares are; only where a test may mount.
#[test]
#[cfg(target_os = "linux")]
fn a_folder_that_is_a_mount_point_is_written() {
    for place in ["run", "run/variants"] {
        let folder = tempfile::tempdir().unwrap();
        let (mounted, run) = (folder.path().join(place), folder.path().join("run"));
        std::fs::create_dir_all(&mounted).unwrap();
        let script = "mount -t tmpfs none \"$1\" || exit 99\nfor tool in paper-tool endmill-16; do\n\"$0\" batch --tools \
            $tool --plan \"$2\" --quiet || exit 1\ngrep -q $tool \"$2/commands.txt\" && test -s \
            \"$2/variants/$tool/tool.yaml\" || exit 2\ndone\ntest -z \"$(ls -A \"$2\" | grep '^\\.')\"";
        let mut command = Command::new("unshare");
        command.args(["--user", "--map-root-user", "--mount", "sh", "-c", script, env!("CARGO_BIN_EXE_muspin")]);
        let Ok(run) = command.arg(&mounted).arg(&run).output() else {
            return;
        };
        let said = String::from_utf8_lossy(&run.stderr).into_owned();
        let may_not_mount = run.status.code() == Some(99) || said.starts_with("unshare:");
        assert!(may_not_mount || run.status.success(), "{place}: {said}");
    }
}
