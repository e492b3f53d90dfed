//! Stability over the whole speed range: the proof against poles at speeds it did not look at.

use muspin::controller::ControlLaw;
use muspin::controller::speed_proof::prove;
use muspin::controller::verification::{growth_rate, verify_at};
use muspin::input::{load_controller, load_machine};
use muspin::lti::{Discrete, StateSpace};
use muspin::spindle::{Effect, EffectKind, Location, Machine, ModelDetail, Plant};
use std::f64::consts::TAU;

fn reference() -> (Machine, StateSpace<Discrete>) {
    let root = env!("CARGO_MANIFEST_DIR");
    let file = |name: &str| format!("{root}/results/reference/{name}");
    let machine = load_machine(&file("spindle.yaml"), &file("tool.yaml")).unwrap();
    let loaded = load_controller(&file("controller/discrete.json")).unwrap();
    let ControlLaw::Discrete(law) = loaded.law else { panic!("the committed controller is sampled") };
    (machine, law)
}

fn growth(machine: &Machine, law: &StateSpace<Discrete>, rpm: f64) -> f64 {
    let plant = Plant::new(machine, rpm * TAU / 60.0, ModelDetail::Full).unwrap();
    growth_rate(&plant.sample_plant().unwrap(), law).unwrap()
}

#[test]
fn the_reference_controller_is_proven_at_every_speed() {
    let (machine, law) = reference();
    let began = std::time::Instant::now();
    let proof = prove(&machine, &law, 60e3).unwrap();
    eprintln!("{:?} {}", began.elapsed(), proof.intervals.len());
    for i in &proof.intervals {
        eprintln!("{:.0} {:.0} {:.2}", i.centre_rpm, i.radius_rpm, i.growth_rate_per_s);
    }
    assert!(proof.is_complete(), "{:?}", proof.open_rpm);
    assert!(proof.proven_to_rpm() == 60e3);
    // Intervals touch or overlap, from end to end.
    let mut reached = 0.0f64;
    for interval in proof.proven_intervals() {
        assert!(interval.centre_rpm - interval.radius_rpm <= reached);
        reached = reached.max(interval.centre_rpm + interval.radius_rpm);
    }
    assert!(reached >= 60e3);
    // Poles at speeds between the centres, and their growth rate beside the centres.
    for rpm in [1234.5, 17_777.0, 33_333.3, 49_999.0, 59_000.0] {
        assert!(growth(&machine, &law, rpm) < 0.0, "{rpm}");
    }
    let centre = proof.intervals[0];
    let direct = growth(&machine, &law, centre.centre_rpm);
    assert!((direct / centre.growth_rate_per_s - 1.0).abs() < 1e-6);
}

#[test]
fn a_loop_that_loses_stability_is_open_from_there_on() {
    let (mut machine, law) = reference();
    // Gyroscopics beyond any rotor's, so that the loop does go unstable.
    machine.spindle.max_rpm = 400e3;
    let (mut stable, mut unstable) = (0.0, 400e3);
    assert!(growth(&machine, &law, unstable) > 0.0);
    // First crossing on a scan, then bisected.
    for k in 1..=80 {
        let rpm = 5e3 * f64::from(k);
        if growth(&machine, &law, rpm) >= 0.0 {
            unstable = rpm;
            break;
        }
        stable = rpm;
    }
    while unstable - stable > 1.0 {
        let middle = 0.5 * (stable + unstable);
        if growth(&machine, &law, middle) < 0.0 { stable = middle } else { unstable = middle }
    }
    let began = std::time::Instant::now();
    let proof = prove(&machine, &law, stable + 2e3).unwrap();
    eprintln!("{stable} {:?} {} {:?}", began.elapsed(), proof.intervals.len(), proof.open_rpm);
    assert!(!proof.is_complete());
    assert!(proof.proven_to_rpm() <= unstable, "{:?}", proof.open_rpm);
    // Nothing above the lowest unstable speed was divided: the open piece reaches to the end.
    let centres = proof.intervals.iter();
    let lowest = centres.filter(|i| i.growth_rate_per_s >= 0.0).map(|i| i.centre_rpm).fold(f64::INFINITY, f64::min);
    let last = proof.open_rpm.last().unwrap();
    assert!(last[0] <= lowest && last[1] == proof.to_rpm, "{last:?} {lowest}");
    // The proof comes within the resolution of its search to the edge: the small gain is not what limits it.
    assert!(proof.proven_to_rpm() > 0.99 * stable, "{:?}", proof.open_rpm);
}

/// Machines with controllers of two kinds, and what makes the planes of a machine differ or couples them.
#[test]
fn poles_of_two_equal_planes_are_those_of_the_whole_loop() {
    let one_axis =
        |kind: EffectKind, location: Location, value: f64| vec![Effect { kind, values: vec![value], location }];
    let effects = [
        vec![],
        one_axis(EffectKind::SensorGain, Location::Axis(1), 1.02),
        one_axis(EffectKind::CrossCoupling, Location::Position(0.1), 2e4),
    ];
    for (name, tool) in [
        ("reference-updated", "paper-tool"),
        ("s04-noncollocated", "endmill-12-long"),
        ("s09-four-modes", "endmill-16"),
        ("s12-big-discs", "test-arbor"),
    ] {
        let root = env!("CARGO_MANIFEST_DIR");
        let spindle = format!("{root}/tests/data/spindles/{name}.yaml");
        let mut machine = load_machine(&spindle, tool).unwrap();
        for which in ["mu", "pid"] {
            let path = format!("{root}/tests/data/designs/{name}/{which}.json");
            let ControlLaw::Discrete(law) = load_controller(&path).unwrap().law else { panic!("{path} is sampled") };
            for effects in &effects {
                machine.spindle.effects.clone_from(effects);
                let speeds = [0.0, 0.4, 1.0].map(|share| share * machine.spindle.max_rpm);
                let checked = verify_at(&machine, &law, &speeds, "").unwrap();
                for check in checked.speeds {
                    let whole = growth(&machine, &law, check.speed_rpm);
                    // Eigenvalues of a loop with 150 states, relative to the fastest decay they resolve at all.
                    assert!(
                        (check.growth_rate_per_s - whole).abs() < 1e-6 * whole.abs() + 1e-6,
                        "{name} {which} {effects:?} at {} rpm: {} {whole}",
                        check.speed_rpm,
                        check.growth_rate_per_s
                    );
                }
            }
        }
    }
}
