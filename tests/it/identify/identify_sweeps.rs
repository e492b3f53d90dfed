//! Sweeps to FRFs and peaks: against a known plant, against the simulated folder c03, and what is refused.

use crate::rotor::own_spectrum::own_spectrum;
use muspin::identify::frf::{AXES, SweepRecord};
use muspin::identify::peaks::{Antiresonance, Channel, antiresonances, resonances};
use muspin::identify::{HammerFrf, Reading, identify, open_loop};
use muspin::input::sweep::{header, read_sweep};
use muspin::input::{load_machine, load_measurement};
use muspin::linalg::c64;
use muspin::lti::Response;
use muspin::spindle::{Machine, ModelDetail, Plant};
use ndarray::Array4;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

fn folder() -> String {
    format!("{}/tests/data/identify/c03", env!("CARGO_MANIFEST_DIR"))
}

fn gauss(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random::<f64>().max(1e-300), rng.random());
    (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
}

fn complex(rng: &mut ChaCha8Rng, sd: f64) -> c64 {
    c64::new(gauss(rng), gauss(rng)) * (sd / 2f64.sqrt())
}

/// A sweep of the plant at rest with sensor noise `noise_m` on every coefficient.
fn sweep(machine: &Machine, noise_m: f64, seed: u64) -> (SweepRecord, Vec<muspin::linalg::Mat<c64>>) {
    let plant = Plant::new(machine, 0.0, ModelDetail::Full).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let frequency_hz: Vec<f64> = (0..480).map(|k| 50.0 * 80f64.powf(k as f64 / 479.0)).collect();
    let truth: Vec<_> = frequency_hz.iter().map(|f| plant.at(TAU * f).submatrix(0, 0, AXES, AXES).to_owned()).collect();
    let repeats = 3;
    let mut current = Array4::from_elem((480, AXES, repeats, AXES), c64::new(0.0, 0.0));
    let mut signal = current.clone();
    for l in 0..480 {
        for e in 0..AXES {
            let u: Vec<c64> = (0..AXES)
                .map(|a| {
                    let main = if a == e { 0.06 } else { 0.0 };
                    c64::new(main, 0.0) + complex(&mut rng, 0.02)
                })
                .collect();
            for p in 0..repeats {
                for i in 0..AXES {
                    current[(l, e, p, i)] = u[i];
                    signal[(l, e, p, i)] =
                        (0..AXES).map(|j| truth[l][(i, j)] * u[j]).sum::<c64>() + complex(&mut rng, noise_m);
                }
            }
        }
    }
    let record = SweepRecord {
        name: "synthetic".into(),
        speed_rpm: 0.0,
        frequency_hz,
        current,
        signal,
        left_out: vec![],
        run_out: false,
    };
    (record, truth)
}

#[test]
fn covariance_covers_the_error_of_the_open_loop_estimate() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let (record, truth) = sweep(&machine, 1e-10, 1);
    let frf = open_loop(&record).unwrap();
    let mut sum = 0.0;
    for l in 0..frf.len() {
        for i in 0..AXES {
            for j in 0..AXES {
                let error = (frf.response[(l, i, j)] - truth[l][(i, j)]).norm_sqr();
                sum += error / frf.sigma(l, i, j, 0.0).powi(2);
            }
        }
    }
    let mean = sum / (frf.len() * 16) as f64;
    // 7680 entries, noise from 40 degrees of freedom each: 1/(1 − 1/40) and its scatter.
    assert!((0.93..1.15).contains(&mean), "{mean}");
}

#[test]
fn peaks_of_the_free_free_rotor_come_back_within_their_standard_deviations() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let truth = own_spectrum(&machine, 100.0, 3950.0);
    let mut chi = vec![];
    for seed in 0..6 {
        let (record, _) = sweep(&machine, 1e-10, 100 + seed);
        let found = identify(&open_loop(&record).unwrap(), &machine).unwrap();
        let lists = [
            (&found.resonances, &truth.poles_hz),
            (&found.front, &truth.zeros_hz[0]),
            (&found.rear, &truth.zeros_hz[1]),
        ];
        for (readings, expected) in lists {
            assert_eq!(readings.len(), expected.len(), "{readings:?} {expected:?}");
            for (reading, truth) in readings.iter().zip(expected) {
                let f = reading.frequency_hz().unwrap();
                let sd = reading.standard_deviation_hz().unwrap();
                assert!((f / truth - 1.0).abs() < 2e-3, "{f} {truth}");
                chi.push(((f - truth) / sd).powi(2));
            }
        }
    }
    let mean = chi.iter().sum::<f64>() / chi.len() as f64;
    println!("mean chi2 {mean:.2}, worst {:.1} sd", chi.iter().copied().fold(0.0, f64::max).sqrt());
    // The share for the magnets' stiffness is generous here, where ks is exact: below one is right, above two would be
    // bias.
    assert!(mean < 2.0, "{mean}");
}

#[test]
fn null_case_of_the_simulator_shows_the_updated_model() {
    let measurement = load_measurement(&folder()).unwrap();
    let machine = measurement.machine(None, None).unwrap();
    let frf = open_loop(&measurement.sweeps[0].record).unwrap();
    let found = identify(&frf, &machine).unwrap();
    let check = |readings: &[Reading], expected: &[f64]| {
        assert_eq!(readings.len(), expected.len(), "{readings:?}");
        for (r, e) in readings.iter().zip(expected) {
            // Moduli of the simulator scatter by 1 %, frequencies by half of that and less.
            let f = r.frequency_hz().unwrap();
            assert!((f / e - 1.0).abs() < 5e-3, "{f} {e}");
        }
    };
    check(&found.resonances, &[1069.0, 1955.0, 3210.0]);
    check(&found.front, &[1109.0, 1767.0, 3429.0]);
    check(&found.rear, &[952.0, 1716.0, 2828.6]);
    assert!(found.damping_ratio.iter().all(|z| (0.002..0.008).contains(z)));
}

/// Σ r/(f_k² − f² + 2jζ f_k f) with white noise.
fn channel(lines: &[f64], modes: &[(f64, f64)], noise: f64, seed: u64) -> Channel {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let value = lines
        .iter()
        .map(|f| {
            let sum: c64 =
                modes.iter().map(|(fk, r)| c64::new(*r, 0.0) / c64::new(fk * fk - f * f, 0.008 * fk * f)).sum();
            sum - 3.0 / (f * f) + complex(&mut rng, noise)
        })
        .collect();
    Channel::new("synthetic", value, vec![noise; lines.len()])
}

#[test]
fn two_close_resonances_are_told_apart() {
    let lines: Vec<f64> = (0..500).map(|k| 500.0 * 4f64.powf(k as f64 / 499.0)).collect();
    let channels = [
        channel(&lines, &[(1000.0, 1.0), (1016.0, 0.7)], 2e-9, 1),
        channel(&lines, &[(1000.0, 0.6), (1016.0, -0.9)], 2e-9, 2),
    ];
    let found = resonances(&lines, &channels);
    assert_eq!(found.len(), 2, "{found:?}");
    for (r, e) in found.iter().zip([1000.0, 1016.0]) {
        let off = (r.frequency_hz - e).abs();
        assert!(off < 5.0 * r.standard_deviation_hz && off < 1.0, "{r:?}");
    }
}

#[test]
fn a_shallow_resonance_is_found_and_noise_is_not() {
    let lines: Vec<f64> = (0..500).map(|k| 500.0 * 4f64.powf(k as f64 / 499.0)).collect();
    // The second mode stands out of the first one's flank by a few per cent.
    let found = resonances(&lines, &[channel(&lines, &[(900.0, 1.0), (1300.0, 0.002)], 2e-10, 3)]);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!((found[1].frequency_hz - 1300.0).abs() < 5.0 * found[1].standard_deviation_hz);
    for seed in 0..20 {
        let found = resonances(&lines, &[channel(&lines, &[(900.0, 1.0)], 1e-8, seed)]);
        assert_eq!(found.len(), 1, "seed {seed}: {found:?}");
    }
}

#[test]
fn an_antiresonance_that_noise_hides_is_null_with_the_reason() {
    let lines: Vec<f64> = (0..500).map(|k| 500.0 * 4f64.powf(k as f64 / 499.0)).collect();
    let modes = [(800.0, 1.0), (1400.0, 1.0)];
    let clear = channel(&lines, &modes, 1e-9, 4);
    let poles = resonances(&lines, std::slice::from_ref(&clear));
    let found = antiresonances(&lines, &clear, 0, &poles, 100.0);
    let between: Vec<_> = found.iter().filter(|z| (800.0..1400.0).contains(&z.place_hz())).collect();
    assert!(matches!(between[..], [Antiresonance::Found { .. }]), "{found:?}");
    // The same rotor; noise hides the flat bottom between the two peaks, but not the peaks.
    let hidden = channel(&lines, &modes, 2e-6, 4);
    let poles = resonances(&lines, std::slice::from_ref(&hidden));
    assert_eq!(poles.len(), 2);
    let found = antiresonances(&lines, &hidden, 0, &poles, 100.0);
    let between: Vec<_> = found.iter().filter(|z| (800.0..1400.0).contains(&z.place_hz())).collect();
    let [Antiresonance::NotIdentified { reason, .. }] = between[..] else {
        panic!("{found:?}");
    };
    assert!(reason.contains("standard deviation") || reason.contains("minimum"), "{reason}");
    // Above the last peak nothing crosses zero: roots of the noise are not antiresonances.
    assert!(found.iter().all(|z| z.place_hz() < 1400.0), "{found:?}");
}

#[test]
fn a_channel_of_zeros_has_no_antiresonance_and_says_why() {
    let lines: Vec<f64> = (0..500).map(|k| 500.0 * 4f64.powf(k as f64 / 499.0)).collect();
    let clear = channel(&lines, &[(800.0, 1.0), (1400.0, 1.0)], 1e-9, 4);
    let zero = Channel::new("g_13", vec![c64::new(0.0, 0.0); 500], vec![0.0; 500]);
    let poles = resonances(&lines, &[clear, zero.clone()]);
    assert_eq!(poles.len(), 2, "{poles:?}");
    let found = antiresonances(&lines, &zero, 1, &poles, 100.0);
    let [Antiresonance::NotIdentified { reason, .. }] = &found[..] else {
        panic!("{found:?}");
    };
    assert!(reason.contains("g_13 is zero at every line"), "{reason}");
}

/// A small sweep file, changed by `edit`.
fn csv(edit: impl Fn(usize, usize, usize, Vec<String>) -> Option<Vec<String>>) -> Vec<u8> {
    let mut text = header().join(",") + "\n";
    for l in 0..3 {
        for e in 1..=4 {
            for p in 1..=2 {
                let mut row = vec![format!("{}", 50 + l), e.to_string(), p.to_string()];
                for k in 0..16 {
                    let u = k == 2 * (e - 1);
                    let v = if u { 0.1 } else { 1e-6 * (k + p) as f64 };
                    row.push(format!("{v:e}"));
                }
                if let Some(row) = edit(l, e, p, row) {
                    text += &(row.join(",") + "\n");
                }
            }
        }
    }
    text.into_bytes()
}

#[test]
fn bad_sweep_files_are_refused_by_name_and_line() {
    let good = csv(|_, _, _, row| Some(row));
    assert_eq!(read_sweep("s.csv", &good, 0.0).unwrap().repeats(), 2);
    type Edit = fn(usize, usize, usize, Vec<String>) -> Option<Vec<String>>;
    let cases: [(&str, usize, Edit); 6] = [
        ("experiment 3 (injection into rear_x) is missing", 2, |l, e, _, r| {
            (e != if l == 0 { 3 } else { 2 }).then_some(r)
        }),
        ("y2_re: \"nan\" is not a number", 5, |l, e, p, mut r| {
            if (l, e, p) == (0, 2, 2) {
                r[13] = "nan".into();
            }
            Some(r)
        }),
        ("experiment: 5 must be a whole number from 1 to 4", 9, |l, e, p, mut r| {
            if (l, e, p) == (0, 4, 2) {
                r[1] = "5".into();
            }
            Some(r)
        }),
        ("18 columns, the header has 19", 3, |l, e, p, mut r| {
            if (l, e, p) == (0, 1, 2) {
                r.pop();
            }
            Some(r)
        }),
        ("frequency_hz: -50 must be positive", 2, |l, e, p, mut r| {
            if (l, e, p) == (0, 1, 1) {
                r[0] = "-50".into();
            }
            Some(r)
        }),
        ("stands in line 2 already", 3, |l, e, p, mut r| {
            if (l, e, p) == (0, 1, 2) {
                r[2] = "1".into();
            }
            Some(r)
        }),
    ];
    for (words, line, edit) in cases {
        let error = read_sweep("s.csv", &csv(edit), 0.0).unwrap_err();
        assert!(error.message.contains(words), "{}", error.message);
        assert_eq!(error.line, Some(line), "{}", error.message);
    }
    let text = String::from_utf8(good.clone()).unwrap();
    let error = read_sweep("s.csv", text.replace("u3_im", "u3_mi").as_bytes(), 0.0).unwrap_err();
    assert!(error.message.contains("column 9 is \"u3_mi\", expected \"u3_im\""));
    assert!(read_sweep("s.csv", b"", 0.0).is_err());
    assert!(read_sweep("s.csv", &[0xff, 0xfe, 0x00], 0.0).is_err());
}

#[test]
fn what_is_missing_of_a_sweep_is_left_out_and_said() {
    let whole = read_sweep("s.csv", &csv(|_, _, _, row| Some(row)), 0.0).unwrap();
    assert!(whole.left_out.is_empty());
    type Keep = fn(usize, usize, usize) -> bool;
    let read = |keep: Keep| {
        let bytes = csv(|l, e, p, row| keep(l, e, p).then_some(row));
        let record = read_sweep("s.csv", &bytes, 0.0).unwrap();
        (record.frequency_hz.clone(), record.repeats(), record.left_out.join("; "), record)
    };
    // An experiment is missing at one frequency.
    let (hz, repeats, said, record) = read(|l, e, _| l != 1 || e != 3);
    assert_eq!((hz, repeats), (vec![50.0, 52.0], 2));
    assert!(said.contains("1 of 3 frequencies") && said.contains("51 Hz"), "{said}");
    assert_eq!(record.current.index_axis(ndarray::Axis(0), 1), whole.current.index_axis(ndarray::Axis(0), 2));
    // A repeat is missing at one frequency: two of three lines with two repeats are more than three with one.
    let (hz, repeats, said, _) = read(|l, e, p| l != 1 || e != 2 || p != 2);
    assert_eq!((hz, repeats), (vec![50.0, 52.0], 2));
    assert!(said.contains("51 Hz"), "{said}");
    // One experiment has fewer repeats everywhere.
    let (hz, repeats, said, record) = read(|_, e, p| e != 2 || p != 2);
    assert_eq!((hz.len(), repeats), (3, 1));
    assert!(said.contains("9 rows are not used"), "{said}");
    let first = ndarray::s![.., .., 0..1, ..];
    assert_eq!(record.signal, whole.signal.slice(first));
}

#[test]
fn rows_in_any_order_give_the_same_sweep() {
    let good = String::from_utf8(csv(|_, _, _, row| Some(row))).unwrap();
    let mut lines: Vec<&str> = good.lines().collect();
    lines[1..].reverse();
    let turned = lines.join("\r\n");
    assert_eq!(read_sweep("s", good.as_bytes(), 0.0).unwrap(), read_sweep("s", turned.as_bytes(), 0.0).unwrap());
}

#[test]
fn experiments_that_do_not_differ_are_a_named_error() {
    let same = csv(|_, e, _, mut row| {
        if e == 2 {
            for k in 0..8 {
                row[3 + k] = if k == 0 { "0.1".into() } else { "0".into() };
            }
        } else if e == 1 {
            for k in 0..8 {
                row[3 + k] = if k == 0 { "0.2".into() } else { "0".into() };
            }
        }
        Some(row)
    });
    let error = open_loop(&read_sweep("s.csv", &same, 0.0).unwrap()).unwrap_err();
    assert!(error.to_string().contains("linearly dependent"), "{error}");
}

/// A universal file has a coherence function and no number of averages: the noise shows from line to line.
#[test]
fn the_noise_of_a_hammer_record_without_averages_is_that_of_its_lines() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut frf = |coherence| HammerFrf {
        speed_rpm: 0.0,
        frequency_hz: (1..=1000).map(f64::from).collect(),
        compliance: (0..1000).map(|k| c64::new(1.0 / (1.0 + f64::from(k)), 0.0) + complex(&mut rng, 0.01)).collect(),
        coherence,
        averages: None,
    };
    for record in [frf(Some(vec![0.99; 1000])), frf(None)] {
        let mean = record.sigmas(0.0).iter().sum::<f64>() / 1000.0;
        assert!((mean / 0.01 - 1.0).abs() < 0.1, "{mean}");
    }
}

/// Where noise dominates, some line measures next to nothing by chance; it is no better known than the lines beside it.
#[test]
fn a_hammer_line_that_happens_to_be_small_is_not_believed() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    // Noise of one blow in units of one, against a compliance of 0.3; five blows.
    let (exact, blows, lines) = (c64::new(0.3, 0.0), 5, 2000);
    let mut frf = HammerFrf {
        speed_rpm: 0.0,
        frequency_hz: (1..=lines).map(f64::from).collect(),
        compliance: vec![],
        coherence: Some(vec![]),
        averages: Some(vec![f64::from(blows); lines as usize]),
    };
    let power = exact.norm_sqr();
    // The coherence of the model, and that of the blows among each other.
    for estimated in [false, true] {
        let mut coherence = vec![];
        frf.compliance.clear();
        for _ in 0..lines {
            let each: Vec<c64> = (0..blows).map(|_| exact + complex(&mut rng, 1.0)).collect();
            let mean = each.iter().sum::<c64>() / f64::from(blows);
            let all: f64 = each.iter().map(|h| h.norm_sqr()).sum();
            frf.compliance.push(mean);
            coherence.push(if estimated { f64::from(blows) * mean.norm_sqr() / all } else { power / (power + 1.0) });
        }
        frf.coherence = Some(coherence);
        let sigma = frf.sigmas(0.0);
        let square = |k: usize| ((frf.compliance[k] - exact).norm() / sigma[k]).powi(2);
        let squares: Vec<f64> = (0..lines as usize).map(square).collect();
        let largest = squares.iter().copied().fold(0.0, f64::max);
        // A mean of five variances: (1 + x/5)⁻⁵ is 3e-6 at 60. A variance of its own leaves hundreds.
        assert!(largest < 60.0, "{largest}");
        let mean = squares.iter().sum::<f64>() / f64::from(lines);
        // The coherence of the model knows nothing of the noise that the measured size has: thrice the variance.
        let least = if estimated { 0.6 } else { 0.2 };
        assert!((least..1.2).contains(&mean), "{estimated} {mean}");
    }
}
