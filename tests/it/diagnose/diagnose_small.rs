//! Effects on either side of their least size, laws of the catalogue that look like others, and laws that are in none,
//! measured by the independent simulator.

use crate::diagnose::diagnose_folder::read;
use crate::diagnose::generator::{Draw, simulate};
use muspin::diagnose::data::measurement::{ControlAxis, HammerTest, RecordSet};
use muspin::diagnose::{Diagnosis, Verdict, diagnose};
use muspin::identify::SweepRecord;
use muspin::linalg::c64;
use muspin::spindle::{Bearings, Effect, EffectKind, Location};
use std::f64::consts::TAU;

const FRONT: Location = Location::Bearing(Bearings::Front);

fn of_hidden(hidden: &[(EffectKind, Location, f64)], seed: u64) -> Diagnosis {
    let effects = hidden
        .iter()
        .map(|(kind, at, value)| Effect::new(*kind, at.clone(), vec![*value]).unwrap())
        .collect::<Vec<_>>();
    measured(&effects, 0.0, seed, |_| {})
}

/// The diagnosis of a sweep at a speed and of a hammer test, the sweep spoiled.
fn measured(effects: &[Effect], speed_rpm: f64, seed: u64, spoil: impl Fn(&mut SweepRecord)) -> Diagnosis {
    let folder = read("c03");
    let speed_rad_s = speed_rpm * TAU / 60.0;
    let grid: Vec<f64> = (0..300).map(|k| 50.0 * 80f64.powf(f64::from(k) / 299.0)).collect();
    let mut draw = Draw::new(seed);
    let mut drawn = simulate(&folder.machine, &folder.controller, effects, None, speed_rad_s, &grid, &mut draw);
    spoil(&mut drawn.sweep);
    let hammer = HammerTest { frf: drawn.hammer, axis: ControlAxis::X, controller: &folder.controller };
    let measurement = RecordSet { sweeps: vec![drawn.sweep], taps: vec![hammer] };
    diagnose(&folder.machine, &measurement, &|_| {}).unwrap()
}

#[test]
fn a_ring_that_is_turned_by_half_of_its_least_angle_leaves_the_model_adequate() {
    for seed in [9101, 9102] {
        let found = of_hidden(&[(EffectKind::AxisMisalignment, FRONT, 0.05)], seed);
        assert_eq!(found.verdict, Verdict::Adequate, "{seed}: {:?}", found.nearest);
        assert!(found.effects.is_empty() && found.corrected.spindle.effects.is_empty());
        for small in &found.small_effects {
            let h = small.effect.kind;
            assert!(small.effect.values[0].abs() < 0.1, "{seed} {h:?} {:?}", small.effect.values);
        }
    }
}

#[test]
fn twice_its_least_angle_has_a_name() {
    let found = of_hidden(&[(EffectKind::AxisMisalignment, FRONT, 0.2)], 9103);
    assert_eq!(found.verdict, Verdict::Named, "{:?} {:?}", found.nearest, found.small_effects);
    let [only] = &found.effects[..] else { panic!("{:?}", found.effects) };
    assert_eq!((only.effect.kind, &only.effect.location), (EffectKind::AxisMisalignment, &FRONT));
    assert!((only.effect.values[0] - 0.2).abs() < 0.02, "{:?}", only.effect.values);
}

#[test]
fn laminated_iron_a_damper_and_a_leak_between_cables_are_named() {
    let cases = [
        (EffectKind::LaminatedCore, Location::Bearing(Bearings::Both), 3000.0, 0.03),
        (EffectKind::AddedDamper, Location::Position(0.24), 400.0, 0.1),
        (EffectKind::SensorCrosstalk, Location::Across { from: 0, to: 2 }, 0.01, 0.05),
    ];
    for (seed, (kind, place, value, share)) in (9110..).zip(cases) {
        let found = of_hidden(&[(kind, place.clone(), value)], seed);
        assert_eq!(found.verdict, Verdict::Named, "{kind:?}: {:?}", found.nearest);
        let [only] = &found.effects[..] else { panic!("{:?}", found.effects) };
        assert_eq!(only.effect.kind, kind);
        if kind == EffectKind::AddedDamper {
            assert!((only.effect.location.position_m().unwrap() - 0.24).abs() < 0.02, "{:?}", only.effect.location);
        } else {
            assert_eq!(only.effect.location, place);
        }
        assert!((only.effect.values[0] / value - 1.0).abs() < share, "{kind:?}: {:?}", only.effect.values);
    }
}

#[test]
fn lags_that_work_against_each_other_have_no_name() {
    let both = Location::Bearing(Bearings::Both);
    // A loop that is faster than its file and a filter that is slower: one law for all the records can tell.
    let hidden = [
        (EffectKind::LoopDelay, Location::None, -2.1e-5),
        (EffectKind::SensorLowpass, both.clone(), 6500.0),
        (EffectKind::AmplifierBandwidth, both, 1880.0),
    ];
    let found = of_hidden(&hidden, 9120);
    let lags = [EffectKind::LoopDelay, EffectKind::SensorLowpass, EffectKind::AmplifierBandwidth];
    let named = found.effects.iter().filter(|e| lags.contains(&e.effect.kind)).count();
    assert!(named < 2, "{:?}", found.effects);
}

#[test]
fn effects_of_several_numbers_and_of_one_axis_are_named() {
    let disc = vec![0.15, 3.75e-4, 1.9e-4];
    let cases = [
        (EffectKind::AmplifierSecondOrder, FRONT, vec![1700.0, 0.5], 0.0),
        (EffectKind::AmplifierBandwidth, Location::Axis(2), vec![1400.0], 0.0),
        (EffectKind::LoopDelay, Location::Axis(1), vec![2e-5], 0.0),
        (EffectKind::CurrentPickup, Location::Across { from: 0, to: 2 }, vec![3e-11], 0.0),
        (EffectKind::AddedDisc, Location::Position(0.2), disc, 20_000.0),
    ];
    for (seed, (kind, place, values, speed_rpm)) in (9130..).zip(cases) {
        let hidden = Effect::new(kind, place.clone(), values.clone()).unwrap();
        let found = measured(&[hidden], speed_rpm, seed, |_| {});
        assert_eq!(found.verdict, Verdict::Named, "{kind:?}: {:?}", found.nearest);
        let [only] = &found.effects[..] else { panic!("{:?}", found.effects) };
        assert_eq!(only.effect.kind, kind);
        match (&only.effect.location, &place) {
            (Location::Position(found_m), Location::Position(z)) => assert!((found_m - z).abs() < 0.01, "{found_m}"),
            (found, place) => assert_eq!(found, place),
        }
        for (found, value) in only.effect.values.iter().zip(&values) {
            assert!((found / value - 1.0).abs() < 0.1, "{kind:?}: {:?}", only.effect.values);
        }
    }
}

/// Run-out of a shaft at 200.06 Hz whose window leaks into every line, in one phase in all experiments of a repeat.
#[test]
fn what_all_experiments_share_is_no_finding() {
    let leak = |sweep: &mut SweepRecord| {
        let phases = [0.3, 2.1, 4.4];
        for (k, hz) in sweep.frequency_hz.iter().enumerate() {
            let size = 2e-8 / (1.0 + (hz - 200.06).abs() / 100.0);
            for (p, phase) in phases.iter().enumerate() {
                for e in 0..4 {
                    for axis in 0..4 {
                        let across = 0.5 * std::f64::consts::PI * (axis % 2) as f64;
                        sweep.signal[(k, e, p, axis)] += c64::from_polar(size, phase - across);
                    }
                }
            }
        }
    };
    let found = measured(&[], 12_003.7, 9140, leak);
    assert_eq!(found.verdict, Verdict::Adequate, "{:?}", found.nearest);
}
