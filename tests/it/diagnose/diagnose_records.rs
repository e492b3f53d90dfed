//! Mistakes of a rig in records of the example without effects: each is named with its number, the records are corrected,
//! and no effect takes the blame.

use crate::diagnose::diagnose_folder::{Folder, read};
use crate::diagnose::generator::{Draw, simulate};
use muspin::diagnose::data::measurement::{ControlAxis, HammerTest, RecordId, RecordSet};
use muspin::diagnose::{Alternatives, Diagnosis, FoundFault, Verdict, diagnose, diagnose_with};
use muspin::identify::plausibility::{RecordFault, Signal};
use muspin::identify::{HammerFrf, SweepRecord};
use muspin::linalg::c64;
use muspin::spindle::{EffectKind, Location};
use ndarray::Axis as Dimension;
use std::f64::consts::TAU;

/// Every second line of the example's sweep: enough to tell, in half the time.
fn thinned(folder: &Folder) -> SweepRecord {
    let lines: Vec<usize> = (0..folder.sweep.frequency_hz.len()).step_by(2).collect();
    SweepRecord {
        frequency_hz: lines.iter().map(|k| folder.sweep.frequency_hz[*k]).collect(),
        current: folder.sweep.current.select(Dimension(0), &lines),
        signal: folder.sweep.signal.select(Dimension(0), &lines),
        ..folder.sweep.clone()
    }
}

fn measured<'a>(folder: &'a Folder, sweep: SweepRecord, frf: HammerFrf) -> RecordSet<'a> {
    RecordSet {
        sweeps: vec![sweep],
        taps: vec![HammerTest { frf, axis: ControlAxis::X, controller: &folder.controller }],
    }
}

fn hammer(folder: &Folder) -> HammerFrf {
    folder.hammer.clone().expect("hammer test")
}

/// The single fault of a diagnosis without effects.
fn only_fault(d: &Diagnosis, record: RecordId) -> RecordFault {
    fault_beside(d, record, &[])
}

/// The single fault of a diagnosis with effects of these kinds.
fn fault_beside(d: &Diagnosis, record: RecordId, kinds: &[EffectKind]) -> RecordFault {
    assert_eq!(d.verdict, Verdict::Named, "{:?}", d.nearest);
    let named: Vec<EffectKind> = d.effects.iter().map(|e| e.effect.kind).collect();
    assert_eq!(named, kinds, "{:?}", d.effects);
    assert!(d.gap_after < 1.0 && d.gap_after_held_out < 1.5);
    match &d.record_faults[..] {
        [one] if one.record == record => one.fault,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_hammer_with_a_wrong_calibration_is_named() {
    let folder = read("c03");
    let mut frf = hammer(&folder);
    frf.compliance.iter_mut().for_each(|h| *h *= 0.88);
    let d = diagnose(&folder.machine, &measured(&folder, thinned(&folder), frf), &|_| {});
    let d = d.expect("diagnosis");
    match only_fault(&d, RecordId::Hammer(0)) {
        RecordFault::HammerCalibration { factor } => {
            assert!((factor / 0.88 - 1.0).abs() < 0.01, "{factor}");
        }
        other => panic!("{other:?}"),
    }
    // The corrected record is the one before the mistake.
    let (right, found) = (hammer(&folder), &d.hammers[0]);
    for (a, b) in right.compliance.iter().zip(&found.compliance) {
        assert!((a - b).norm() < 0.01 * a.norm());
    }
}

/// An accelerometer of 6 g on the tool, and an analyser whose channels are 25 µs apart.
#[test]
fn a_hammer_test_with_a_mass_or_a_delay_is_named() {
    let folder = read("c03");
    let named = |spoil: fn(f64, c64) -> c64| {
        let mut frf = hammer(&folder);
        let hz = frf.frequency_hz.clone();
        frf.compliance.iter_mut().zip(hz).for_each(|(h, hz)| *h = spoil(TAU * hz, *h));
        let d = diagnose(&folder.machine, &measured(&folder, thinned(&folder), frf), &|_| {}).expect("diagnosis");
        only_fault(&d, RecordId::Hammer(0))
    };
    match named(|w, h| h / (c64::new(1.0, 0.0) - h * (6e-3 * w * w))) {
        RecordFault::HammerMass { mass_kg } => assert!((mass_kg / 6e-3 - 1.0).abs() < 0.03, "{mass_kg}"),
        other => panic!("{other:?}"),
    }
    match named(|w, h| h * c64::from_polar(1.0, -25e-6 * w)) {
        RecordFault::HammerDelay { delay_s } => assert!((delay_s / 25e-6 - 1.0).abs() < 0.03, "{delay_s}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn sensors_that_drift_are_named() {
    let folder = read("c03");
    let mut sweep = thinned(&folder);
    let last = sweep.frequency_hz.len() - 1;
    for (k, mut line) in sweep.signal.outer_iter_mut().enumerate() {
        line.mapv_inplace(|y| y * (1.0 - 0.03 * k as f64 / last as f64));
    }
    let d = diagnose(&folder.machine, &measured(&folder, sweep, hammer(&folder)), &|_| {});
    match only_fault(&d.expect("diagnosis"), RecordId::Sweep(0)) {
        RecordFault::Drift { signal: Signal::Displacement, relative_change } => {
            assert!((relative_change + 0.03).abs() < 0.004, "{relative_change}")
        }
        other => panic!("{other:?}"),
    }
}

/// Sensor signals cut off at a limit that every sixth line reaches.
#[test]
fn signals_that_are_cut_off_are_named_and_left_out() {
    let folder = read("c03");
    let mut sweep = thinned(&folder);
    let lines = sweep.signal.outer_iter();
    let mut sizes: Vec<f64> = lines.map(|l| l.iter().map(|y| y.norm()).fold(0.0, f64::max)).collect();
    sizes.sort_by(f64::total_cmp);
    let (count, limit) = (sizes.len(), sizes[sizes.len() * 5 / 6]);
    sweep.signal.mapv_inplace(|y| y * (limit / y.norm()).min(1.0));
    let d = diagnose(&folder.machine, &measured(&folder, sweep, hammer(&folder)), &|_| {});
    let d = d.expect("diagnosis");
    match only_fault(&d, RecordId::Sweep(0)) {
        RecordFault::Clipping { limit: found, signal: Signal::Displacement } => {
            assert!((found / limit - 1.0).abs() < 0.01, "{found} {limit}")
        }
        other => panic!("{other:?}"),
    }
    // The lines below the limit remain.
    let left = d.sweeps[0].frequency_hz.len();
    assert!(left <= count * 5 / 6 && left >= count * 4 / 5, "{left}");
}

/// Lines above half of 5.2 kHz as a logger without a filter records them.
#[test]
fn folded_lines_are_named_with_the_sample_rate() {
    let folder = read("c03");
    let rate = 5200.0;
    let label: Vec<f64> = (0..160).map(|k| 50.0 * 80f64.powf(f64::from(k) / 159.0)).collect();
    let fold = |f: f64| if f > 0.5 * rate { rate - f } else { f };
    let true_hz: Vec<f64> = label.iter().map(|f| fold(*f)).collect();
    let mut sweep = simulate(&folder.machine, &folder.controller, &[], None, 0.0, &true_hz, &mut Draw::new(79)).sweep;
    for (k, f) in label.iter().enumerate() {
        if *f > 0.5 * rate {
            for values in [&mut sweep.current, &mut sweep.signal] {
                let mut line = values.index_axis_mut(Dimension(0), k);
                line.mapv_inplace(|v| v.conj());
            }
        }
    }
    sweep.frequency_hz = label;
    let measurement = RecordSet { sweeps: vec![sweep], taps: vec![] };
    let d = diagnose(&folder.machine, &measurement, &|_| {}).expect("diagnosis");
    match only_fault(&d, RecordId::Sweep(0)) {
        RecordFault::Alias { sample_rate_hz } => {
            assert!((sample_rate_hz / rate - 1.0).abs() < 1e-3, "{sample_rate_hz}");
        }
        other => panic!("{other:?}"),
    }
    let right = &d.sweeps[0].frequency_hz;
    assert!(right.windows(2).all(|w| w[0] < w[1]) && right[right.len() - 1] <= 0.5 * rate);
}

/// A record without a mistake keeps its lines: its largest signals do not pile up, and folding brings it nowhere.
#[test]
fn a_right_record_is_neither_cut_off_nor_folded() {
    let folder = read("c03");
    let measurement = measured(&folder, thinned(&folder), hammer(&folder));
    let d = diagnose(&folder.machine, &measurement, &|_| {}).expect("diagnosis");
    assert_eq!(d.verdict, Verdict::Adequate);
    assert!(d.record_faults.is_empty(), "{:?}", d.record_faults);
    assert!(d.strained.is_empty());
}

#[test]
fn swapped_channels_are_put_right_before_the_diagnosis() {
    let folder = read("c03");
    let right = thinned(&folder);
    let fault = RecordFault::ChannelsSwapped { a: 2, b: 3, signal: Signal::Displacement };
    // The exchange is its own inverse.
    let measurement = measured(&folder, fault.corrected_sweep(&right), hammer(&folder));
    let d = diagnose(&folder.machine, &measurement, &|_| {}).expect("diagnosis");
    assert_eq!(only_fault(&d, RecordId::Sweep(0)), fault);
    assert_eq!(d.sweeps[0].signal, right.signal);
}

#[test]
fn another_tool_is_named() {
    let folder = read("c03");
    let mut longer = folder.machine.clone();
    longer.tool.name = "longer".into();
    let tip = longer.tool.sections.last_mut().expect("section");
    tip.length_m *= 1.3;
    let measurement = measured(&folder, thinned(&folder), hammer(&folder));
    // The records are those of the tool of the folder; the machine says the longer one.
    let alternatives = Alternatives { tools: vec![("own".into(), folder.machine.clone())], controllers: vec![] };
    let d = diagnose_with(&longer, &measurement, &alternatives, &|_| {}).expect("diagnosis");
    assert_eq!(d.verdict, Verdict::Named);
    let tool = |f: &FoundFault| f.fault == RecordFault::Tool && f.name.as_deref() == Some("own");
    assert!(d.record_faults.len() == 2 && d.record_faults.iter().all(tool));
    assert_eq!(d.corrected.tool.name, folder.machine.tool.name);
}

#[test]
fn a_wrong_speed_is_a_speed_label_and_no_gyroscopic_effect() {
    let folder = read("c03");
    let lines: Vec<f64> = (0..244).map(|k| 50.0 * 80f64.powf(k as f64 / 243.0)).collect();
    let mut drawn =
        simulate(&folder.machine, &folder.controller, &[], None, 24_000.0 * TAU / 60.0, &lines, &mut Draw::new(77));
    drawn.sweep.speed_rpm = 16_000.0;
    let measurement = RecordSet { sweeps: vec![drawn.sweep], taps: vec![] };
    let d = diagnose(&folder.machine, &measurement, &|_| {}).expect("diagnosis");
    assert!(d.effects.is_empty(), "{:?}", d.effects);
    match &d.record_faults[..] {
        [FoundFault { fault: RecordFault::SpeedLabel { speed_rpm }, .. }] => {
            assert!((speed_rpm / 24_000.0 - 1.0).abs() < 0.01, "{speed_rpm}")
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_gain_of_one_axis_is_named_as_such() {
    let folder = read("c03");
    let mut sweep = thinned(&folder);
    let mut axis = sweep.signal.index_axis_mut(Dimension(3), 3);
    axis.mapv_inplace(|y| y * 1.05);
    let d = diagnose(&folder.machine, &measured(&folder, sweep, hammer(&folder)), &|_| {});
    let d = d.expect("diagnosis");
    // The gain of the bearing is not known so well that the other axis could not be off the other way.
    let right = matches!(d.verdict, Verdict::Named | Verdict::Tie);
    assert!(right, "{:?}", d.verdict);
    let [named] = &d.effects[..] else {
        panic!("{:?}", d.effects);
    };
    assert_eq!(named.effect.kind, EffectKind::SensorGain);
    assert_eq!(named.effect.location, Location::Axis(3));
    assert!((named.effect.values[0] / 1.05 - 1.0).abs() < 0.01);
    assert!(d.record_faults.is_empty());
}

/// Tests of several seconds each: `cargo test --release --test it long:: -- --ignored`.
mod long {
    use super::*;

    /// Neither the slower loop nor the calibration explains the records alone; the loop explains the sweep.
    #[test]
    #[ignore = "long: see the command of the module"]
    fn a_hammer_with_a_wrong_calibration_beside_an_effect_is_named() {
        let folder = read("c01");
        let mut frf = hammer(&folder);
        frf.compliance.iter_mut().for_each(|h| *h *= 1.15);
        let measured = measured(&folder, thinned(&folder), frf);
        let d = diagnose(&folder.machine, &measured, &|_| {}).expect("diagnosis");
        match fault_beside(&d, RecordId::Hammer(0), &[EffectKind::LoopDelay]) {
            RecordFault::HammerCalibration { factor } => {
                assert!((factor / 1.15 - 1.0).abs() < 0.01, "{factor}");
            }
            other => panic!("{other:?}"),
        }
        let delay_s = d.effects[0].effect.values[0];
        assert!((delay_s / 30e-6 - 1.0).abs() < 0.01, "{delay_s}");
    }

    /// Relative errors of 0.3 % rms that are smooth over frequency, other ones in every channel, are no effect: no name, no
    /// alarm.
    #[test]
    #[ignore = "long: see the command of the module"]
    fn a_smooth_error_of_every_channel_is_no_effect() {
        let folder = read("c03");
        let mut sweep = thinned(&folder);
        let top = sweep.frequency_hz.last().copied().expect("lines");
        for (k, hz) in sweep.frequency_hz.clone().into_iter().enumerate() {
            let x = (hz / 50.0).ln() / (top / 50.0).ln();
            let error = |n: usize| {
                let wave = |cycles: f64, phase: f64| (TAU * (cycles * x + phase)).cos();
                let n = n as f64;
                c64::new(wave(0.5 + 0.11 * n, 0.37 * n), wave(1.7 - 0.07 * n, 0.23 * n)) * 3e-3
            };
            for e in 0..4 {
                for p in 0..sweep.signal.dim().2 {
                    // y = G u with another error in every channel.
                    let u: [c64; 4] = std::array::from_fn(|j| sweep.current[(k, e, p, j)]);
                    let total: f64 = u.iter().map(|u| u.norm()).sum();
                    for i in 0..4 {
                        let mean: c64 = (0..4).map(|j| error(4 * i + j) * (u[j].norm() / total)).sum();
                        sweep.signal[(k, e, p, i)] *= c64::new(1.0, 0.0) + mean;
                    }
                }
            }
        }
        let d = diagnose(&folder.machine, &measured(&folder, sweep, hammer(&folder)), &|_| {});
        let d = d.expect("diagnosis");
        assert_eq!(d.verdict, Verdict::Adequate, "{:?}", d.nearest);
        assert!(d.gap_after < 1.0);
    }
}
