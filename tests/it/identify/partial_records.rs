//! Records that hold less than four injections with repeats: what they determine is found, what they do not is said.

use crate::cli::program::muspin;
use crate::rotor::own_spectrum::own_spectrum;
use crate::support::files::below_root;
use muspin::identify::frf::{AXES, SweepRecord};
use muspin::identify::{HammerFrf, IdentifyError, identify, open_loop, open_loop_columns};
use muspin::input::hammer::{HammerKeys, read_tap};
use muspin::input::load_machine;
use muspin::input::sweep::{header, read_sweep};
use muspin::linalg::c64;
use muspin::lti::Response;
use muspin::spindle::{Machine, ModelDetail, Plant};
use ndarray::Array4;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// One repeat of the injections `taken` into the plant at rest; `answer` is the current of each other axis per current.
fn record(machine: &Machine, taken: &[usize], answer: impl Fn(usize, usize) -> f64, noise_m: f64) -> SweepRecord {
    let frequency_hz = (0..480).map(|k| 50.0 * 80f64.powf(k as f64 / 479.0)).collect();
    record_on(machine, frequency_hz, taken, answer, noise_m)
}

fn record_on(
    machine: &Machine,
    frequency_hz: Vec<f64>,
    taken: &[usize],
    answer: impl Fn(usize, usize) -> f64,
    noise_m: f64,
) -> SweepRecord {
    let plant = Plant::new(machine, 0.0, ModelDetail::Full).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut gauss = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut current = Array4::from_elem((frequency_hz.len(), AXES, 1, AXES), c64::new(0.0, 0.0));
    let mut signal = current.clone();
    for (l, f) in frequency_hz.iter().enumerate() {
        let g = plant.at(TAU * f);
        for e in taken {
            for j in 0..AXES {
                current[(l, *e, 0, j)] = c64::new(if j == *e { 0.06 } else { 0.06 * answer(*e, j) }, 0.0);
            }
            for i in 0..AXES {
                let exact: c64 = (0..AXES).map(|j| g[(i, j)] * current[(l, *e, 0, j)]).sum();
                signal[(l, *e, 0, i)] = exact + c64::new(gauss(), gauss()) * (noise_m / 2f64.sqrt());
            }
        }
    }
    SweepRecord {
        name: "s.csv".into(),
        speed_rpm: 0.0,
        frequency_hz,
        current,
        signal,
        left_out: vec![],
        run_out: false,
    }
}

#[test]
fn columns_that_the_injections_determine_are_those_of_the_plant() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let plant = Plant::new(&machine, 0.0, ModelDetail::Full).unwrap();
    // One injection while no other coil has a current; both of a plane, each of which answers the other.
    let cases: [(&[usize], f64, [bool; AXES], &str); 3] = [
        (&[0], 0.0, [true, false, false, false], "no injection into rear_x"),
        (&[1, 3], 0.4, [false, true, false, true], "nothing of that plane is determined"),
        (&[0, 1, 2], 1e-3, [true, true, true, false], "no injection into rear_y"),
    ];
    for (taken, answer, determined, words) in cases {
        let answers = |e: usize, j: usize| if (e + j).is_multiple_of(2) { answer } else { 0.0 };
        let record = record(&machine, taken, answers, 0.0);
        assert!(matches!(open_loop(&record), Err(IdentifyError::Experiments { .. })));
        let (frf, said) = open_loop_columns(&record).unwrap();
        assert_eq!(frf.determined, determined);
        assert!(said.join("; ").contains(words), "{said:?}");
        // A current that is left out of account moves a column by its share: a thousandth, and more where the column
        // has a zero and the other one has none.
        for l in (0..frf.len()).step_by(7) {
            let g = plant.at(TAU * frf.frequency_hz[l]);
            for j in (0..AXES).filter(|j| determined[*j]) {
                let size = |own: &dyn Fn(usize) -> c64| (0..AXES).map(|i| own(i).norm_sqr()).sum::<f64>().sqrt();
                let other = size(&|i| g[(i, (j + 2) % AXES)]);
                let error = size(&|i| frf.response[(l, i, j)] - g[(i, j)]);
                let allowed = if taken.contains(&((j + 2) % AXES)) { 1e-9 } else { 1.01 * answer * other };
                assert!(error <= allowed + 1e-9 * size(&|i| g[(i, j)]), "{j} {error:e} {allowed:e}");
            }
        }
    }
}

#[test]
fn a_current_that_answers_the_only_injection_determines_nothing() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let record = record(&machine, &[0], |_, j| if j == 2 { 0.3 } else { 0.0 }, 0.0);
    assert!(matches!(open_loop_columns(&record), Err(IdentifyError::Undetermined { .. })));
    let turning = SweepRecord { speed_rpm: 1000.0, ..record };
    assert!(open_loop_columns(&turning).is_err());
}

#[test]
fn one_injection_once_shows_the_resonances_of_the_free_rotor() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let truth = own_spectrum(&machine, 100.0, 3950.0);
    let (frf, _) = open_loop_columns(&record(&machine, &[0], |_, _| 0.0, 1e-10)).unwrap();
    let found = identify(&frf, &machine).unwrap();
    assert_eq!(found.resonances.len(), truth.poles_hz.len(), "{found:?}");
    for (reading, truth) in found.resonances.iter().zip(&truth.poles_hz) {
        assert!((reading.frequency_hz().unwrap() / truth - 1.0).abs() < 2e-3, "{reading:?} {truth}");
    }
    let front: Vec<f64> = found.front.iter().filter_map(|r| r.frequency_hz()).collect();
    for zero in &front {
        assert!(truth.zeros_hz[0].iter().any(|f| (f / zero - 1.0).abs() < 5e-3), "{zero} {:?}", truth.zeros_hz[0]);
    }
    assert!(front.len() >= 2, "{front:?}");
    // No column of the rear actuator: none of its antiresonances, and why.
    assert!(found.rear.iter().all(|r| r.frequency_hz().is_none()), "{:?}", found.rear);
}

#[test]
fn a_sweep_file_may_have_one_experiment_and_a_mean_value() {
    let row = |f: f64, u: f64| {
        let numbers: Vec<String> = (0..16).map(|k| format!("{}", u * f64::from(k + 1))).collect();
        format!("{f},2,1,{}\n", numbers.join(","))
    };
    let text = format!("{}\n{}{}{}", header().join(","), row(0.0, 1.0), row(10.0, 1.0), row(20.0, 2.0));
    let read = read_sweep("s.csv", text.as_bytes(), 0.0).unwrap();
    assert_eq!(read.frequency_hz, [10.0, 20.0]);
    assert!(read.left_out.join("").contains("0 Hz"), "{:?}", read.left_out);
    assert_eq!(read.current[(1, 1, 0, 0)], c64::new(2.0, 4.0));
    assert!(read.current.index_axis(ndarray::Axis(1), 0).iter().all(|u| u.norm() == 0.0));
}

/// Compliance of modes (Hz, damping ratio) on lines of 0.25 Hz from 0 on, with relative noise.
fn taps(modes: &[(f64, f64)], noise: f64) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut text = "frequency_hz,h_re,h_im\n".to_owned();
    for k in 0..3200 {
        let f = 0.25 * f64::from(k);
        let each = modes.iter().map(|(fk, z)| c64::new(1e-3, 0.0) / c64::new(fk * fk - f * f, 2.0 * z * fk * f));
        let h: c64 = each.sum();
        let (re, im): (f64, f64) = (StandardNormal.sample(&mut rng), StandardNormal.sample(&mut rng));
        let h = h * (c64::new(1.0, 0.0) + c64::new(re, im) * noise);
        let _ = writeln!(text, "{f},{:e},{:e}", h.re, h.im);
    }
    text
}

#[test]
fn identify_gives_the_resonances_of_a_hammer_test_alone() {
    let modes = [(112.0, 2e-3), (307.0, 5e-3), (596.0, 1e-2)];
    let text = taps(&modes, 1e-2);
    let tap = read_tap("tap.csv", text.as_bytes(), &HammerKeys::default()).unwrap();
    assert!(tap.frf.coherence.is_none() && tap.frf.frequency_hz[0] == 0.25);
    assert!(tap.notes.iter().any(|n| n.contains("0 Hz")) && tap.notes.iter().any(|n| n.contains("coherence")));
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tap.csv"), text).unwrap();
    let list = "spindle: reference\ntool: paper-tool\nrecords:\n  - {kind: hammer, file: tap.csv, speed_rpm: 0}\n";
    std::fs::write(folder.path().join("measurement.yaml"), list).unwrap();
    let (code, out, err) = muspin(&["identify", "--measurement", ".", "--json"], folder.path());
    assert_eq!(code, 0, "{err}");
    assert!(err.contains("0 Hz") && err.contains("without coherence"), "{err}");
    let answer: Value = serde_json::from_str(&out).unwrap();
    let hammer = &answer["hammers"][0];
    let list =
        |key: &str| -> Vec<f64> { hammer[key].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect() };
    let (hz, sd) = (list("resonances_hz"), list("resonances_standard_deviation_hz"));
    assert_eq!(hz.len(), 3, "{hz:?}");
    for (k, (f, z)) in modes.iter().enumerate() {
        assert!((hz[k] - f).abs() < 4.0 * sd[k] && sd[k] < 1e-3 * f, "{hz:?} {sd:?}");
        let zeta = list("damping_ratio")[k];
        assert!((zeta - z).abs() < 4.0 * list("damping_ratio_standard_deviation")[k], "{zeta} {z}");
    }
    assert!(hammer["refers_to"].as_str().unwrap().contains("as it was held") && hammer["remedy"].is_null());
}

/// Recorders that turn the other way write the conjugate.
#[test]
fn a_hammer_test_whose_conjugate_has_resonances_says_so() {
    let turned: String = taps(&[(112.0, 2e-3), (307.0, 5e-3)], 1e-2)
        .lines()
        .map(|line| match line.rsplit_once(',') {
            Some((head, imaginary)) if !imaginary.contains('h') => match imaginary.strip_prefix('-') {
                Some(positive) => format!("{head},{positive}\n"),
                None => format!("{head},-{imaginary}\n"),
            },
            _ => format!("{line}\n"),
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tap.csv"), turned).unwrap();
    let list = "spindle: reference\ntool: paper-tool\nrecords:\n  - {kind: hammer, file: tap.csv, speed_rpm: 0}\n";
    std::fs::write(folder.path().join("measurement.yaml"), list).unwrap();
    let (_, out, err) = muspin(&["identify", "--measurement", ".", "--json"], folder.path());
    let answer: Value = serde_json::from_str(&out).expect(&err);
    assert!(answer["hammers"][0]["resonances_hz"].as_array().unwrap().is_empty(), "{out}");
    assert!(answer["hammers"][0]["remedy"].as_str().unwrap().contains("h_im"), "{out}");
}

#[test]
fn lines_that_drift_or_are_incoherent_are_no_part_of_a_hammer_test() {
    let lines: Vec<f64> = (1..=3000).map(f64::from).collect();
    // A held tool, and an acceleration that was integrated twice with its drift.
    let compliance: Vec<c64> = lines
        .iter()
        .map(|f| {
            let mode = 0.1 / c64::new(1000.0 * 1000.0 - f * f, 2.0 * 0.03 * 1000.0 * f);
            mode - 1e-3 / (f * f)
        })
        .collect();
    let smallest = |frf: &HammerFrf| {
        let valid = frf.valid_lines();
        let kept = (0..valid.len()).filter(|k| valid[*k]);
        frf.frequency_hz[kept.max_by(|a, b| compliance[*a].norm().total_cmp(&compliance[*b].norm())).unwrap()]
    };
    let drifting = HammerFrf {
        speed_rpm: 0.0,
        frequency_hz: lines.clone(),
        compliance: compliance.clone(),
        coherence: None,
        averages: None,
    };
    // Spring and drift are alike at 100 Hz: the compliance is level from there on.
    let first = drifting.valid_lines().iter().position(|valid| *valid).unwrap();
    assert!((50..150).contains(&first), "{first}");
    assert!((990.0..1010.0).contains(&smallest(&drifting)));
    // A record of the resonance alone keeps its flank.
    let part =
        HammerFrf { frequency_hz: lines[899..].to_vec(), compliance: compliance[899..].to_vec(), ..drifting.clone() };
    assert!(part.valid_lines().iter().all(|valid| *valid));
    // A coherence of a half from one tap is a deviation of 100 %; from a hundred of 10 %.
    let coherence: Vec<f64> = lines.iter().map(|f| if *f < 1200.0 { 0.5 } else { 1.0 }).collect();
    let averages = |n: f64| Some(vec![n; lines.len()]);
    let once = HammerFrf { coherence: Some(coherence), averages: averages(1.0), ..drifting };
    assert!(!once.valid_lines()[999] && once.valid_lines()[1300]);
    assert!(HammerFrf { averages: averages(100.0), ..once }.valid_lines()[999]);
}

/// Three repeats of one record with their own noise.
fn three_repeats(machine: &Machine) -> SweepRecord {
    let one = record(machine, &[0, 1, 2, 3], |_, _| 0.0, 0.0);
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    let three = |data: &Array4<c64>| ndarray::concatenate(ndarray::Axis(2), &[data.view(); 3]).unwrap();
    let signal = three(&one.signal).mapv(|y| y + c64::new(noise(), noise()) * 1e-9);
    SweepRecord { current: three(&one.current), signal, ..one }
}

#[test]
fn repeats_that_are_none_are_left_out_and_said() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let healthy = three_repeats(&machine);
    assert_eq!(healthy.clone().without_odd_repeats(), healthy);
    let changed = |change: fn(&mut SweepRecord)| {
        let mut record = healthy.clone();
        change(&mut record);
        record.without_odd_repeats()
    };
    let third = |data: &mut Array4<c64>, factor: f64, axes: std::ops::Range<usize>| {
        data.slice_mut(ndarray::s![.., .., 2, axes]).mapv_inplace(|value| value * factor);
    };
    // A gain that levitation anew makes stays.
    let mut anew = healthy.clone();
    third(&mut anew.signal, 1.02, 1..2);
    assert_eq!(anew.clone().without_odd_repeats(), anew);
    let mut halved = healthy.clone();
    third(&mut halved.signal, 0.5, 0..1);
    let halved = halved.without_odd_repeats();
    assert_eq!((halved.repeats(), halved.left_out.len()), (2, 1));
    assert!(halved.left_out[0].contains("repeat 3") && halved.left_out[0].contains("0.50"), "{:?}", halved.left_out);
    assert!(halved.left_out[0].contains("front_x"), "{:?}", halved.left_out);
    let mut empty = healthy.clone();
    third(&mut empty.signal, 0.0, 0..4);
    assert_eq!(empty.without_odd_repeats().repeats(), 2);
    let copies = changed(|record| {
        for data in [&mut record.current, &mut record.signal] {
            let first = data.slice(ndarray::s![.., .., 0..1, ..]).to_owned();
            data.slice_mut(ndarray::s![.., .., 1.., ..]).assign(&first);
        }
    });
    assert_eq!(copies.repeats(), 1);
    assert!(copies.left_out.iter().any(|words| words.contains("repeat 3")), "{:?}", copies.left_out);
}

/// On its magnets the first bending of the laboratory rotor moves the undamped rigid body as well: 11 % less damping.
#[test]
fn damping_is_that_of_the_free_rotor() {
    for (spindle, from_hz, to_hz) in [("s13-lab-rotor", 10.0, 60.0), ("s06-strong-ks", 400.0, 2500.0)] {
        let path = below_root(&format!("tests/data/spindles/{spindle}.yaml"));
        let machine = load_machine(&path.display().to_string(), "none").unwrap();
        let step = (to_hz - from_hz) / 4000.0;
        let lines = (0..4000).map(|k| from_hz + step * f64::from(k)).collect();
        let frf = open_loop(&record_on(&machine, lines, &[0, 1, 2, 3], |_, _| 0.0, 1e-11)).unwrap();
        let found = identify(&frf, &machine).unwrap();
        assert!(!found.damping_ratio.is_empty());
        for (k, ratio) in found.damping_ratio.iter().enumerate() {
            let own = &machine.spindle.damping_ratio;
            let stated = own.get(k).or(own.last()).copied().unwrap();
            assert!(
                (ratio / stated - 1.0).abs() < 5e-3,
                "{spindle} {k}: {ratio} of {stated}, {:?}",
                found.damping_shift
            );
        }
    }
}
