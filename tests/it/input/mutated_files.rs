//! Damaged files of every format: a reader returns, soon, and an error names the file.

use crate::input::damage::formats::{FORMATS, read};
use crate::input::damage::mutate::damaged;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::path::Path;
use std::time::{Duration, Instant};

/// Longest reading of a file of some kilobytes; the limit is for a slow and busy machine.
const LONGEST: Duration = Duration::from_secs(5);

fn corpus(format: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus").join(format);
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|p| std::fs::read(p).unwrap()).collect()
}

/// Reads `count` damaged files of a format; how many were refused, and the longest time.
fn attack(format: &str, count: usize, seed: u64) -> (usize, Duration) {
    let files = corpus(format);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut refused, mut longest) = (0, Duration::ZERO);
    for k in 0..count {
        let bytes = damaged(&files[k % files.len()], &mut random);
        let start = Instant::now();
        let answer = read(format, &bytes);
        let took = start.elapsed();
        assert!(took < LONGEST, "{format} {k}: {took:?}");
        longest = longest.max(took);
        if let Err(message) = answer {
            refused += 1;
            assert!(message.starts_with("file"), "{format} {k}: {message}");
        }
    }
    (refused, longest)
}

#[test]
fn undamaged_files_are_read() {
    for format in FORMATS {
        let files = corpus(format);
        assert!(!files.is_empty());
        for (k, bytes) in files.iter().enumerate() {
            let answer = read(format, bytes);
            // Universal files without a frequency response belong to the corpus as well; they are refused as such.
            let other = answer.as_ref().err().filter(|_| format == "uff");
            let is_read = other.is_some_and(|m| m.contains("no frequency response")) || answer.is_ok();
            assert!(is_read, "{format} {k}: {answer:?}");
        }
        assert!(files.iter().any(|bytes| read(format, bytes).is_ok()), "{format}");
    }
}

#[test]
fn damaged_files_are_read_or_refused_with_the_name_of_the_file() {
    for format in FORMATS {
        let (refused, _) = attack(format, 1000, 1);
        // Damage in a comment or in a digit may pass; most does not.
        assert!(refused > 100, "{format}: {refused}");
    }
}

#[test]
#[ignore = "runs MUTANTS (default 100 000) damaged files of each format, or of FORMAT, with the seed SEED; see \
    tests/fuzz/README.md"]
fn many() {
    let number = |name: &str, default: u64| {
        let given = std::env::var(name).ok();
        given.map_or(default, |text| text.parse().unwrap())
    };
    let (count, seed) = (number("MUTANTS", 100_000), number("SEED", 2));
    let only = std::env::var("FORMAT").ok();
    for format in FORMATS {
        if only.as_ref().is_some_and(|name| name != format) {
            continue;
        }
        let start = Instant::now();
        let (refused, longest) = attack(format, count as usize, seed);
        let memory = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let peak = memory.lines().find(|l| l.starts_with("VmHWM"));
        println!(
            "{format}: {count} files, {refused} refused, longest {longest:?}, {:.0} s in all, {}",
            start.elapsed().as_secs_f64(),
            peak.unwrap_or("peak memory unknown")
        );
    }
}
