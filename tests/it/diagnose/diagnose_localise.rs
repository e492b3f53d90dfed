//! Where something is missing, found without a hypothesis: the example folders and one drawn case per kind of place.

use crate::diagnose::diagnose_folder::read;
use crate::diagnose::generator::site::one_axis_pulls;
use crate::diagnose::generator::{Draw, Outside, simulate};
use muspin::diagnose::Evidence;
use muspin::diagnose::data::measurement::RecordSet;
use muspin::diagnose::fit::case::Case;
use muspin::diagnose::fit::model::Model;
use muspin::diagnose::locate::localisation::{Localisation, localise};
use muspin::diagnose::locate::recovered_law::LawShape;
use muspin::spindle::{Bearings, Effect, EffectKind, Location, Machine};
use std::f64::consts::TAU;

fn located(label: &str, machine: &Machine, measurement: &RecordSet) -> Localisation {
    let evidence = Evidence::new(measurement).expect("evidence");
    let model = Model::new(machine, &evidence.axis_gain_sd()).expect("model");
    let search = Case { model: &model, evidence: &evidence, catalogue: &[], seeks_strong: true, progress: &|_| {} };
    let started = std::time::Instant::now();
    let found = localise(&search).expect("localisation");
    println!("{label}: {:.2} s", started.elapsed().as_secs_f64());
    for p in found.ports.iter().take(5) {
        println!(
            "   {:<40} {:>9.3} -> {:>8.3} score +{:.0} ({} numbers)",
            p.port, p.chi2_before, p.chi2_after, p.score_above_best, p.numbers
        );
        for law in &p.laws {
            println!("        {} {} carried {:.3}", law.name, law.words(), law.carried);
        }
    }
    found
}

fn example(name: &str) -> Localisation {
    let folder = read(name);
    let measurement = folder.measurement();
    located(name, &folder.machine, &measurement)
}

fn drawn(label: &str, effects: &[Effect], outside: Option<Outside>, rpm: f64, seed: u64) -> Localisation {
    let folder = read("c03");
    let mut draw = Draw::new(seed);
    let grid: Vec<f64> = (0..300).map(|k| 50.0 * 80f64.powf(f64::from(k) / 299.0)).collect();
    let drawn = simulate(&folder.machine, &folder.controller, effects, outside, rpm * TAU / 60.0, &grid, &mut draw);
    let mut measurement = RecordSet::default();
    measurement.sweeps.push(drawn.sweep);
    located(label, &folder.machine, &measurement)
}

fn single(kind: EffectKind, location: Location, values: &[f64]) -> Vec<Effect> {
    vec![Effect::new(kind, location, values.to_vec()).expect("effect")]
}

#[test]
fn examples_are_located() {
    for (name, place) in [
        ("c01", "loop (all currents or all sensors)"),
        ("c02", "tool joint"),
        ("c03", "nowhere"),
        ("c04", "housing"),
        ("c05", "rear sensors"),
        ("c06", "front sensor axes, x to y"),
    ] {
        let found = example(name);
        let best = &found.ports[0];
        assert_eq!(best.port, place, "{name}");
        let law = best.laws.first().map(|l| l.shape);
        let right = match (name, law) {
            ("c01", Some(LawShape::Delay(t))) => (t - 30e-6).abs() < 0.5e-6,
            // 1.2e5 N m/rad.
            ("c02", Some(LawShape::Constant(s))) => (s * 1.2e5 - 1.0).abs() < 0.15,
            ("c03", None) => true,
            ("c04", Some(LawShape::Resonance(hz, zeta, _))) => (hz - 640.0).abs() < 2.0 && (zeta - 0.03).abs() < 0.003,
            ("c05", Some(LawShape::Resonance(hz, ..))) => (hz - 1400.0).abs() < 5.0,
            // tan 3°.
            ("c06", Some(LawShape::Constant(t))) => (t - 0.0524).abs() < 1e-3,
            _ => false,
        };
        assert!(right, "{name}: {law:?}");
    }
}

/// Tests of several seconds each: `cargo test --release --test it long:: -- --ignored`.
mod long {
    use super::*;

    #[test]
    #[ignore = "long: see the command of the module"]
    fn drawn_cases_are_located() {
        use EffectKind as K;
        let front = || Location::Bearing(Bearings::Front);
        let rear = || Location::Bearing(Bearings::Rear);
        let cases: Vec<(&str, Vec<Effect>, Option<Outside>, f64)> = vec![
            ("tool", single(K::ToolMass, Location::None, &[0.005]), None, 0.0),
            ("shaft at 370 mm", single(K::AddedMass, Location::Position(0.37), &[0.1]), None, 0.0),
            ("front bearing, negative stiffness", single(K::NegativeStiffness, front(), &[1.35]), None, 0.0),
            ("rear sensors", single(K::SensorLowpass, rear(), &[8e3]), None, 0.0),
            ("rear currents", single(K::AmplifierBandwidth, rear(), &[1500.0]), None, 0.0),
            ("front currents, x to y", single(K::BearingCoupling, front(), &[0.03]), None, 0.0),
            ("front sensor plane", single(K::SensorOffset, front(), &[3e-3]), None, 0.0),
            ("rear actuator plane", single(K::ActuatorOffset, rear(), &[3e-3]), None, 0.0),
            ("shaft at 200 mm, x to y", single(K::CrossCoupling, Location::Position(0.2), &[1e5]), None, 0.0),
            ("housing", single(K::HousingMode, Location::None, &[120.0, 400.0, 0.03]), None, 20_000.0),
            ("front bearing, x and y apart", vec![one_axis_pulls(&read("c03").machine, 1.3)], None, 0.0),
            ("front currents into the rear bearing", vec![], Some(Outside::CrossTalk(0.02)), 0.0),
            ("shaft at 200 mm", vec![], Some(Outside::Absorber(0.2, 0.3, 900.0, 0.03)), 0.0),
        ];
        let mut wrong = vec![];
        for (i, (place, effects, outside, rpm)) in cases.into_iter().enumerate() {
            let found = drawn(place, &effects, outside, rpm, 40 + i as u64);
            // A station is found to a few millimetres.
            let best = &found.ports[0];
            let near = |z: f64| {
                let named = place.strip_prefix("shaft at ").and_then(|r| r.split(' ').next());
                named.is_some_and(|mm| (1e3 * z - mm.parse::<f64>().expect("mm")).abs() < 12.0)
                    && place.ends_with("x to y") == best.port.ends_with("x to y")
            };
            if best.port != place && !best.place.position_m().is_some_and(near) {
                wrong.push((place, found.ports[0].port.clone()));
            }
        }
        assert!(wrong.is_empty(), "{wrong:?}");
    }
}
