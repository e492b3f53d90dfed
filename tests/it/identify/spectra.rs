//! Samples to frequency responses against SciPy; readers of time records; modes of a free decay; `muspin spectra`.

use crate::cli::program::muspin;
use muspin::identify::decay::decay_modes;
use muspin::identify::spectra::{
    Averaging, Estimator, Excitation, Leakage, SpectralWindow, averaged_frf, clipped_samples,
};
use muspin::input::hammer::{HammerKeys, read_tap};
use muspin::input::time_record::{load_time_record, read_time_record};
use muspin::input::wav::read_wav;
use muspin::linalg::c64;
use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

fn fixture(name: &str) -> String {
    format!("{}/tests/data/identify/spectra/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

#[test]
fn spectra_are_those_of_scipy() {
    let record = load_time_record(&fixture("record.csv")).unwrap();
    let excitation = [Excitation {
        force: &record.signal("force_n").unwrap().samples,
        response: &record.signal("response_m").unwrap().samples,
    }];
    let text = std::fs::read_to_string(fixture("scipy.json")).unwrap();
    let reference: Value = serde_json::from_str(&text).unwrap();
    let windows =
        [("hann", SpectralWindow::Hann), ("rectangular", SpectralWindow::Rectangular), ("short", SpectralWindow::Hann)];
    for (name, window) in windows {
        let own = &reference[name];
        let segment = Some(own["segment"].as_u64().unwrap() as usize);
        for (key, estimator) in [("h1", Estimator::H1), ("h2", Estimator::H2), ("hv", Estimator::Hv)] {
            let averaging = Averaging { window, estimator, segment, overlap: 0.5 };
            let found = averaged_frf(&excitation, record.sample_rate_hz.unwrap(), &averaging).unwrap();
            let frequency_hz = numbers(&own["frequency_hz"]);
            assert_eq!(found.frequency_hz.len(), frequency_hz.len());
            for (k, f) in frequency_hz.iter().enumerate() {
                assert!((found.frequency_hz[k] / f - 1.0).abs() < 1e-12);
                let parts = numbers(&own[key][k]);
                let off = (found.response[k] - c64::new(parts[0], parts[1])).norm();
                assert!(off < 1e-9 * found.response[k].norm(), "{name} {key} {f}: {off:e}");
                assert!((found.coherence[k] - own["coherence"][k].as_f64().unwrap()).abs() < 1e-9, "{name} {f}");
            }
        }
    }
}

#[test]
fn a_record_is_the_same_in_every_format() {
    let names = [
        ("record.csv", ["force_n", "response_m"]),
        ("record.wav", ["1", "2"]),
        ("record.mat", ["force", "response"]),
        ("record.uff", ["1:1", "2:1"]),
    ];
    let reference = load_time_record(&fixture("record.csv")).unwrap();
    for (file, names) in names {
        let record = load_time_record(&fixture(file)).unwrap();
        assert!((record.sample_rate_hz.unwrap() / 1000.0 - 1.0).abs() < 1e-9, "{file}");
        for (name, own) in names.iter().zip(&reference.signals) {
            let samples = &record.signal(name).unwrap().samples;
            assert_eq!(samples.len(), own.samples.len(), "{file}");
            assert!(samples.iter().zip(&own.samples).all(|(a, b)| (a - b).abs() < 1e-12), "{file} {name}");
        }
        assert!(record.signal("other").unwrap_err().to_string().contains("other"));
    }
}

/// Text in a universal file in the place of other text of the same length.
fn replaced(bytes: &[u8], from: &str, to: &str, which: usize) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let found: Vec<usize> = (0..bytes.len()).filter(|k| bytes[*k..].starts_with(from.as_bytes())).collect();
    let mut bytes = bytes.to_vec();
    bytes[found[which]..found[which] + to.len()].copy_from_slice(to.as_bytes());
    bytes
}

#[test]
fn a_universal_file_of_samples_is_read_as_it_says() {
    let bytes = std::fs::read(fixture("record.uff")).unwrap();
    let read = |bytes: &[u8]| read_time_record("record.uff", bytes).unwrap();
    let plain = read(&bytes);
    let axis = "        17    0    0    0 NONE                 s ";
    // Milliseconds.
    let slower =
        read(&replaced(&replaced(&bytes, axis, &axis.replace("s ", "ms"), 0), axis, &axis.replace("s ", "ms"), 0));
    assert!((slower.sample_rate_hz.unwrap() / (1e3 * plain.sample_rate_hz.unwrap()) - 1.0).abs() < 1e-9);
    // Both signals at one point: numbered.
    let same = read(&replaced(&bytes, "NONE         2   1", "NONE         1   1", 0));
    assert!(same.signal("1:1").is_err());
    assert_eq!(same.signal("1:1#2").unwrap().samples, plain.signal("2:1").unwrap().samples);
    // The other way round.
    let turned = read(&replaced(&bytes, "NONE         2   1", "NONE         2  -1", 0));
    let pairs = turned.signal("2:-1").unwrap().samples.iter().zip(&plain.signal("2:1").unwrap().samples);
    assert!(pairs.into_iter().all(|(a, b)| *a == -b));
    assert_eq!(plain.signal("1:1").unwrap().dimensions, Some([0, 0, 1]));
}

#[test]
fn times_that_are_printed_with_few_digits_are_even() {
    let record = |times: &dyn Fn(usize) -> String| {
        let rows: String =
            (0..4096).map(|k| format!("{},{},{}\n", times(k), (k as f64).sin(), (k as f64).cos())).collect();
        read_time_record("r.csv", format!("time_s,force_n,response_m\n{rows}").as_bytes())
    };
    for digits in [4, 5, 9] {
        let rate = record(&|k| format!("{:.digits$}", k as f64 / 8192.0)).unwrap().sample_rate_hz.unwrap();
        assert!((rate / 8192.0 - 1.0).abs() < 1e-3, "{digits} {rate}");
    }
    let single = |k: usize| format!("{:e}", f64::from((k as f64 / 51_200.0 + 20.0) as f32));
    assert!((record(&single).unwrap().sample_rate_hz.unwrap() / 51_200.0 - 1.0).abs() < 1e-3);
    // A sample is missing in the middle.
    let missing = |k: usize| format!("{:.4}", (k + usize::from(k > 2000)) as f64 / 8192.0);
    assert!(record(&missing).is_err());
}

#[test]
fn samples_at_a_limit_are_counted() {
    let sine = |limit: f64, step: f64| -> Vec<f64> {
        let one = |k: usize| (TAU * k as f64 / 50.3).sin().clamp(-limit, limit);
        (0..1000).map(|k| if step > 0.0 { (one(k) / step).round() * step } else { one(k) }).collect()
    };
    assert_eq!(clipped_samples(&sine(1.0, 0.0)), 0);
    // Coarse steps rest at the peaks.
    assert_eq!(clipped_samples(&sine(1.0, 0.02)), 0);
    // Of a sine that is cut off at a half two thirds are flat; rows that a small step leads into do not count.
    let share = clipped_samples(&sine(0.5, 0.0)) as f64 / 1000.0;
    assert!((0.5..0.68).contains(&share), "{share}");
    assert!(clipped_samples(&sine(0.5, 1e-3)) > 500);
    // A force that rests at zero between taps.
    let taps: Vec<f64> = (0..1000).map(|k| if k % 100 == 7 { -3.0 } else { 0.0 }).collect();
    assert_eq!(clipped_samples(&taps), 0);
    assert_eq!(clipped_samples(&[]), 0);
}

/// A file of two channels of one format.
fn wav(code: u16, bits: u16, samples: &[u8]) -> Vec<u8> {
    let block = bits / 4;
    let mut format = [code.to_le_bytes(), 2u16.to_le_bytes()].concat();
    format.extend([48_000u32, 48_000 * u32::from(block)].map(u32::to_le_bytes).concat());
    format.extend([block, bits].map(u16::to_le_bytes).concat());
    let chunk = |name: &[u8], body: &[u8]| [name, &(body.len() as u32).to_le_bytes(), body].concat();
    // A chunk of odd length stands between.
    let body = [&b"WAVE"[..], &chunk(b"fmt ", &format), &chunk(b"note", b"abc"), b"\0", &chunk(b"data", samples)];
    chunk(b"RIFF", &body.concat())
}

#[test]
fn samples_of_every_size_are_shares_of_full_scale() {
    let exact = [0.5, -0.25, -1.0, 0.125];
    let whole = |bytes: usize| {
        let one = |x: &f64| ((x * 2f64.powi(31)) as i32).to_le_bytes()[4 - bytes..].to_vec();
        exact.iter().flat_map(one).collect::<Vec<u8>>()
    };
    let single: Vec<u8> = exact.iter().flat_map(|x| (*x as f32).to_le_bytes()).collect();
    let double: Vec<u8> = exact.iter().flat_map(|x| x.to_le_bytes()).collect();
    for file in
        [wav(1, 16, &whole(2)), wav(1, 24, &whole(3)), wav(1, 32, &whole(4)), wav(3, 32, &single), wav(3, 64, &double)]
    {
        let (rate, channels) = read_wav("tap.wav", &file).unwrap();
        assert_eq!((rate, channels), (48_000.0, vec![vec![0.5, -1.0], vec![-0.25, 0.125]]));
        for end in 0..file.len() {
            let _ = read_wav("tap.wav", &file[..end]);
        }
    }
    for broken in [wav(1, 8, &whole(2)), wav(7, 16, &whole(2)), b"RIFF".to_vec()] {
        assert!(read_wav("tap.wav", &broken).unwrap_err().to_string().contains("tap.wav"));
    }
    assert!(read_time_record("tap.wav", &wav(3, 64, &f64::NAN.to_le_bytes().repeat(2))).is_err());
}

/// Response of a mode (Hz, damping ratio, m/N at 0 Hz) to a half sine of force, by exact steps of the mode.
fn tap(mode: (f64, f64, f64), rate: f64, samples: usize, strength: f64) -> (Vec<f64>, Vec<f64>) {
    let (f, z, compliance) = mode;
    let force: Vec<f64> =
        (0..samples).map(|k| if k < 8 { strength * (TAU * k as f64 / 16.0).sin() } else { 0.0 }).collect();
    let w = TAU * f;
    let pole = c64::new(-z * w, w * (1.0 - z * z).sqrt());
    let gain = c64::new(0.0, -compliance * w * w / pole.im);
    let growth = (pole / rate).exp();
    let mut state = c64::new(0.0, 0.0);
    let step = |x: &f64| {
        state = state * growth + gain * (x / rate);
        state.re
    };
    let response = force.iter().map(step).collect();
    (force, response)
}

#[test]
fn a_response_that_is_cut_off_leaks_and_a_window_says_what_it_adds() {
    let rate = 4096.0;
    let take = |samples: usize, window: SpectralWindow| {
        let taps: Vec<_> = (1..=4).map(|k| tap((200.0, 0.01, 1e-6), rate, samples, f64::from(k))).collect();
        let excitations: Vec<_> = taps.iter().map(|(force, response)| Excitation { force, response }).collect();
        let averaging = Averaging { window, estimator: Estimator::H1, segment: Some(samples), overlap: 0.0 };
        averaged_frf(&excitations, rate, &averaging).unwrap()
    };
    let left = |found: &Leakage| match found {
        Leakage::LeftAtEnd(part) => *part,
        Leakage::OfPeak { .. } => panic!("{found:?}"),
    };
    // exp(−2π·2 Hz·T) at the end: nothing after two seconds but the mean that was removed, 0.2 after an eighth of one.
    let (long, short) = (take(8192, SpectralWindow::Rectangular), take(512, SpectralWindow::Rectangular));
    assert!(left(&long.leakage) < 1e-2 && left(&short.leakage) > 0.1, "{:?} {:?}", long.leakage, short.leakage);
    assert_eq!((long.segments, long.averages), (4, 4.0));
    let peak = |found: &muspin::identify::spectra::AveragedFrf| {
        let lines = found.frequency_hz.iter().zip(&found.response).filter(|(f, _)| **f < 400.0);
        lines.map(|(_, h)| h.norm()).fold(0.0, f64::max)
    };
    // 1/(2ζ) of the compliance at 0 Hz.
    assert!((peak(&long) / 50e-6 - 1.0).abs() < 0.02, "{}", peak(&long));
    // The window raises ζf, 2 Hz, to 2 Hz + ln(100)/(2πT): the peak falls in the same proportion.
    let damped = take(8192, SpectralWindow::Exponential);
    assert!((damped.added_damping_hz - 100f64.ln() / (TAU * 2.0)).abs() < 1e-9);
    assert!((peak(&damped) * (2.0 + damped.added_damping_hz) / 100e-6 - 1.0).abs() < 0.02, "{}", peak(&damped));
    assert!(take(512, SpectralWindow::Exponential).segments == 4);
    let averaging =
        Averaging { window: SpectralWindow::Hann, estimator: Estimator::H1, segment: Some(9), overlap: 0.5 };
    assert!(averaged_frf(&[Excitation { force: &[1.0; 99], response: &[1.0; 99] }], rate, &averaging).is_err());
}

#[test]
fn a_free_decay_gives_its_modes_however_early_it_is_cut() {
    let rate = 5000.0;
    let modes = [(83.0, 0.004, 1.0), (211.0, 0.012, 0.7), (790.0, 0.02, 0.5)];
    let decay = |samples: usize| -> Vec<f64> {
        let one = |t: f64| {
            let each = modes.iter().map(|(f, z, a)| {
                let damped = TAU * f * f64::sqrt(1.0 - z * z);
                a * (-z * TAU * f * t).exp() * (damped * t + 0.3).cos()
            });
            each.sum::<f64>()
        };
        // Rounding to a ten-thousandth, as a recorder of 14 bit does.
        (0..samples).map(|k| (one(k as f64 / rate) * 1e4).round() / 1e4).collect()
    };
    // The first mode has fallen to 1e-4 and to a third of its size.
    for samples in [22_000, 2600] {
        let signal = decay(samples);
        let found = decay_modes(&[&signal], rate, 0);
        assert_eq!(found.len(), 3, "{samples}: {found:?}");
        for (mode, (f, z, _)) in found.iter().zip(modes) {
            assert!((mode.frequency_hz / f - 1.0).abs() < 1e-3, "{samples} {f}: {mode:?}");
            assert!((mode.damping_ratio / z - 1.0).abs() < 0.1, "{samples} {z}: {mode:?}");
        }
    }
}

#[test]
fn the_command_writes_a_hammer_record_and_lists_the_modes_of_a_decay() {
    let folder = tempfile::tempdir().unwrap();
    let path: &Path = folder.path();
    for k in 1..=3 {
        let (force, response) = tap((200.0, 0.01, 1e-6), 4096.0, 4096, f64::from(k));
        let mut text = "force,sensor\n".to_owned();
        for (x, y) in force.iter().zip(&response) {
            let _ = writeln!(text, "{x},{y:e}");
        }
        std::fs::write(path.join(format!("tap-{k}.csv")), text).unwrap();
    }
    let files = ["--time", "tap-1.csv", "--time", "tap-2.csv", "--time", "tap-3.csv"];
    let rest = ["--force", "force", "--response", "sensor", "--sample-rate-hz", "4096", "--window", "rectangular"];
    let (code, out, err) = muspin(&[&["spectra"][..], &files[..], &rest[..]].concat(), path);
    assert_eq!(code, 0, "{err}");
    assert!(err.contains("3 segments") && err.contains("leakage"), "{err}");
    let read = read_tap("h.csv", out.as_bytes(), &HammerKeys::default()).unwrap().frf;
    assert_eq!(read.averages.as_ref().unwrap()[0], 3.0);
    let found = read.resonances();
    assert_eq!(found.len(), 1, "{found:?}");
    assert!((found[0].frequency_hz / 200.0 - 1.0).abs() < 1e-3 && (found[0].damping_ratio / 0.01 - 1.0).abs() < 0.05);
    let accelerated = [&["spectra"][..], &files[..], &rest[..], &["--motion", "acceleration"]].concat();
    let (_, other, _) = muspin(&accelerated, path);
    let other = read_tap("h.csv", other.as_bytes(), &HammerKeys::default()).unwrap().frf;
    let s = c64::new(0.0, TAU * read.frequency_hz[9]);
    assert!((other.compliance[9] * s * s / read.compliance[9] - 1.0).norm() < 1e-9);

    let decay =
        ["spectra", "--time", "tap-1.csv", "--decay", "--response", "sensor", "--sample-rate-hz", "4096", "--json"];
    let (code, out, err) = muspin(&decay, path);
    assert_eq!(code, 0, "{err}");
    let answer: Value = serde_json::from_str(&out).unwrap();
    let modes = answer["modes"].as_array().unwrap();
    assert_eq!(modes.len(), 1, "{answer}");
    assert!((modes[0]["damping_ratio"].as_f64().unwrap() / 0.01 - 1.0).abs() < 0.02, "{answer}");
    for (options, words) in [
        (["--force-scale", "nan"], "--force-scale: NaN must be a number other than zero"),
        (["--response-scale", "0"], "--response-scale: 0 must be a number other than zero"),
        (["--from-s", "3"], "--from-s: 3 must be left out without --decay"),
    ] {
        let (code, out, err) = muspin(&[&["spectra"][..], &files[..], &rest[..], &options[..]].concat(), path);
        assert!(code == 2 && out.is_empty() && err.contains(words), "{err}");
    }
    std::fs::write(path.join("semicolons.csv"), "t;acc\n0.0;1.9e-4\n").unwrap();
    let semicolons =
        ["spectra", "--time", "semicolons.csv", "--decay", "--response", "acc", "--sample-rate-hz", "1000"];
    let (code, _, err) = muspin(&semicolons, path);
    assert!(code == 2 && err.contains("separated by commas"), "{err}");
    let (code, _, err) = muspin(&[&decay[..], &["--overlap", "0.3"]].concat(), path);
    assert!(code == 2 && err.contains("--overlap"), "{err}");
    let (code, _, err) = muspin(&["spectra", "--time", "tap-1.csv", "--force", "x", "--response", "sensor"], path);
    assert!(code == 2 && err.contains("sample rate"), "{err}");
}
