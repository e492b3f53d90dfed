//! Effects on either side of their least size, laws of the catalogue that look like others, and laws that are in none,
//! measured by the independent simulator.

use crate::diagnose::diagnose_folder::read;
use crate::diagnose::generator::{Draw, simulate};
use muspin::diagnose::data::measurement::{ControlAxis, HammerTest, RecordSet};
use muspin::diagnose::{Diagnosis, Verdict, diagnose};
use muspin::spindle::{Bearings, Effect, EffectKind, Location};

const FRONT: Location = Location::Bearing(Bearings::Front);

fn of_hidden(hidden: &[(EffectKind, Location, f64)], seed: u64) -> Diagnosis {
    let folder = read("c03");
    let effects: Vec<Effect> =
        hidden.iter().map(|(kind, at, value)| Effect::new(*kind, at.clone(), vec![*value]).unwrap()).collect();
    let grid: Vec<f64> = (0..300).map(|k| 50.0 * 80f64.powf(f64::from(k) / 299.0)).collect();
    let drawn = simulate(&folder.machine, &folder.controller, &effects, None, 0.0, &grid, &mut Draw::new(seed));
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
