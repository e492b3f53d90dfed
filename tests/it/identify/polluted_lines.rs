//! Lines of a sweep that hum or run-out disturb: found in quiet records that get them, and in none as they are.

use crate::support::files::below_root;
use muspin::identify::polluted::{PollutedLines, PollutionSource, without_polluted_lines, without_steady_hum};
use muspin::identify::{SweepRecord, open_loop};
use muspin::input::load_measurement;
use muspin::linalg::c64;
use std::f64::consts::TAU;

/// Quiet records of two simulators, at rest and at speed.
const QUIET: [&str; 8] = ["c01", "c02", "c03", "c04", "c05", "c06", "c15", "c19"];

fn sweeps(case: &str) -> Vec<SweepRecord> {
    let folder = below_root(&format!("tests/data/diagnosis/{case}"));
    let loaded = load_measurement(folder.to_str().unwrap()).unwrap();
    loaded.sweeps.into_iter().map(|sweep| sweep.record).collect()
}

fn polluted(record: &SweepRecord) -> (Vec<PollutedLines>, SweepRecord) {
    without_polluted_lines(0, record, &open_loop(record).unwrap())
}

/// The line nearest to a frequency.
fn nearest(record: &SweepRecord, hz: f64) -> usize {
    let apart = |k: &usize| (record.frequency_hz[*k] - hz).abs();
    (0..record.frequency_hz.len()).min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap()
}

/// Something outside the loop on all sensors at a line, with another phase in each experiment and repeat, as large as a
/// fifth of the signals.
fn disturbed(record: &SweepRecord, line: usize) -> SweepRecord {
    let mut disturbed = record.clone();
    let (_, experiments, repeats, _) = record.signal.dim();
    let mean = record.signal.index_axis(ndarray::Axis(0), line).iter().map(|y| y.norm()).sum::<f64>()
        / (4 * experiments * repeats) as f64;
    for e in 0..experiments {
        for p in 0..repeats {
            // Phases of an irrational step repeat nowhere.
            let phase = TAU * (0.618_034 * (repeats * e + p) as f64).fract();
            for i in 0..4 {
                disturbed.signal[(line, e, p, i)] += c64::from_polar(0.2 * mean, phase);
            }
        }
    }
    disturbed
}

#[test]
fn quiet_records_have_no_polluted_line() {
    for case in QUIET {
        for record in sweeps(case) {
            let (found, same) = polluted(&record);
            assert_eq!(found, [], "{case}");
            assert_eq!(same, record, "{case}");
        }
    }
}

#[test]
fn a_disturbed_line_is_found_and_left_out_alone() {
    for case in ["c01", "c03", "c06"] {
        let record = sweeps(case).swap_remove(0);
        let line = nearest(&record, 1480.0);
        let (found, rest) = polluted(&disturbed(&record, line));
        let [own] = &found[..] else { panic!("{case}: {found:?}") };
        assert_eq!(own.hz, [record.frequency_hz[line]], "{case}");
        assert_eq!(own.source, PollutionSource::Unknown, "{case}");
        assert!(own.factor > 3.0, "{case}: {own:?}");
        let others: Vec<f64> = record.frequency_hz.iter().copied().filter(|hz| *hz != own.hz[0]).collect();
        assert_eq!(rest.frequency_hz, others, "{case}");
    }
}

#[test]
fn a_single_repeat_does_not_tell() {
    let whole = sweeps("c01").swap_remove(0);
    let first = ndarray::s![.., .., 0..1, ..];
    let (current, signal) = (whole.current.slice(first).to_owned(), whole.signal.slice(first).to_owned());
    let record = SweepRecord { current, signal, ..whole };
    let disturbed = disturbed(&record, nearest(&record, 1480.0));
    for own in [record, disturbed] {
        assert_eq!(polluted(&own), (vec![], own));
    }
}

#[test]
fn hum_and_run_out_are_told_by_their_frequencies() {
    let source_at = |record: &SweepRecord, line: usize| {
        let (found, _) = polluted(&disturbed(record, line));
        found.iter().map(|own| own.source).collect::<Vec<_>>()
    };
    let mut record = sweeps("c01").swap_remove(0);
    let line = nearest(&record, 300.0);
    record.frequency_hz[line] = 300.02;
    assert_eq!(source_at(&record, line), [PollutionSource::Mains]);
    // A multiple of the speed between two lines.
    let line = nearest(&record, 820.0);
    let between_hz = 0.5 * (record.frequency_hz[line] + record.frequency_hz[line + 1]);
    let turning = SweepRecord { speed_rpm: 60.0 * between_hz / 3.0, ..record };
    assert_eq!(source_at(&turning, line), [PollutionSource::Speed]);
    assert_eq!(source_at(&turning, line + 1), [PollutionSource::Speed]);
}

#[test]
fn noise_that_grows_with_the_signals_is_no_pollution() {
    let mut record = sweeps("c03").swap_remove(0);
    let line = nearest(&record, 1480.0);
    record.signal.index_axis_mut(ndarray::Axis(0), line).mapv_inplace(|y| y * 10.0);
    record.current.index_axis_mut(ndarray::Axis(0), line).mapv_inplace(|u| u * 10.0);
    assert_eq!(polluted(&record).0, []);
}

/// Hum that is alike in every repeat shows only in the distance from the model: beside a multiple of the mains it is
/// left out with the skirt beside it, elsewhere the same distance may be an effect.
#[test]
fn steady_hum_is_left_out_at_multiples_of_the_mains_only() {
    let record = sweeps("c01").swap_remove(0);
    let lines = record.frequency_hz.len();
    let flat: Vec<f64> = (0..lines).map(|k| 0.5 + 0.1 * (k % 3) as f64).collect();
    assert_eq!(without_steady_hum(0, &record, &flat), None);
    let hum = record.frequency_hz.partition_point(|hz| *hz < 100.0);
    let mut misfit = flat.clone();
    misfit[hum] = 9.0;
    misfit[hum + 1] = 2.5;
    let (found, rest) = without_steady_hum(0, &record, &misfit).unwrap();
    assert_eq!(found.hz, record.frequency_hz[hum..hum + 2]);
    assert_eq!(found.source, PollutionSource::Mains);
    assert!(found.words().contains("leave the model"), "{}", found.words());
    assert_eq!(rest.frequency_hz.len(), lines - 2);
    let mut elsewhere = flat;
    elsewhere[record.frequency_hz.partition_point(|hz| *hz < 730.0)] = 9.0;
    assert_eq!(without_steady_hum(0, &record, &elsewhere), None);
}
