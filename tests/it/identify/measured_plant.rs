//! Coherence of a measured plant against that of spectral analysis, and the pictures of its sixteen entries.

use muspin::identify::frf::{AXES, SweepRecord};
use muspin::identify::{open_loop, open_loop_columns};
use muspin::linalg::c64;
use muspin::report::plot::measured::measured_plant;
use ndarray::Array4;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const LINES: usize = 40;
const REPEATS: usize = 60;

/// One axis at a time is driven by 1 A in phases that repeats share; every entry is 1/(1 + output + input) m/A.
fn record(taken: &[usize], noise_m: f64) -> SweepRecord {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut gauss = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut current = Array4::from_elem((LINES, AXES, REPEATS, AXES), c64::new(0.0, 0.0));
    let mut signal = current.clone();
    for line in 0..LINES {
        for e in taken {
            for repeat in 0..REPEATS {
                current[(line, *e, repeat, *e)] = c64::new(1.0, 0.0);
                for i in 0..AXES {
                    let exact = c64::new(1.0 / (1 + i + e) as f64, 0.0);
                    signal[(line, *e, repeat, i)] = exact + c64::new(gauss(), gauss()) * (noise_m / 2f64.sqrt());
                }
            }
        }
    }
    SweepRecord {
        name: "s.csv".into(),
        speed_rpm: 0.0,
        frequency_hz: (0..LINES).map(|k| 10.0 + k as f64).collect(),
        current,
        signal,
        left_out: vec![],
        run_out: false,
    }
}

#[test]
fn coherence_is_that_of_averaged_spectra() {
    let record = record(&[0, 1, 2, 3], 0.3);
    let frf = open_loop(&record).unwrap();
    for (output, input) in [(0, 0), (2, 0), (3, 1), (0, 3)] {
        // |S_yu|²/(S_yy S_uu) from the averages over the repeats, in the mean over the lines.
        let spectral = |line: usize| {
            let pairs = (0..REPEATS)
                .map(|p| (record.signal[(line, input, p, output)], record.current[(line, input, p, input)]));
            let (mut yu, mut yy, mut uu) = (c64::new(0.0, 0.0), 0.0, 0.0);
            for (y, u) in pairs {
                yu += y * u.conj();
                yy += y.norm_sqr();
                uu += u.norm_sqr();
            }
            yu.norm_sqr() / (yy * uu)
        };
        let mean = |of: &dyn Fn(usize) -> f64| (0..LINES).map(of).sum::<f64>() / LINES as f64;
        let (own, classical) = (mean(&|line| frf.coherence(line, output, input)), mean(&spectral));
        assert!((own - classical).abs() < 0.015, "{output} {input}: {own} {classical}");
        assert!(classical < 0.95);
    }
}

#[test]
fn pictures_show_every_entry_once_and_leave_out_what_is_not_determined() {
    let frf = open_loop(&record(&[0, 1, 2, 3], 0.1)).unwrap();
    let drawn = measured_plant(&frf);
    assert_eq!(drawn.iter().map(|(detail, _)| detail.as_str()).collect::<Vec<_>>(), ["x", "y", "x-from-y", "y-from-x"]);
    let names: Vec<&str> =
        drawn.iter().flat_map(|(_, figure)| &figure.panels[0].series).map(|s| s.name.as_str()).collect();
    let mut apart = names.clone();
    apart.sort_unstable();
    apart.dedup();
    assert_eq!((names.len(), apart.len()), (16, 16));
    for (_, figure) in &drawn {
        assert_eq!(figure.panels.len(), 3);
        assert!(figure.panels[2].series.iter().flat_map(|s| &s.y).all(|g| (0.0..=1.0).contains(g)));
    }
    let front = open_loop_columns(&record(&[0], 0.1)).unwrap();
    let details: Vec<String> = measured_plant(&front.0).into_iter().map(|(detail, _)| detail).collect();
    assert_eq!(details, ["x", "y-from-x"]);
}
