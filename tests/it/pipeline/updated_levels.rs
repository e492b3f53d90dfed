//! Levels that a specification leaves to the machine are those of the updated one.

use muspin::input::{load_machine, read_weights, shipped};
use muspin::pid::settings::TuneSettings;
use muspin::pipeline::run::{Extent, Task, run};
use muspin::pipeline::settings::DesignSettings;
use muspin::rotor::PlanarModes;
use muspin::spindle::Machine;
use muspin::update::{Target, Targets};

fn flexible_hz(machine: &Machine) -> Vec<f64> {
    PlanarModes::new(&machine.rotor().unwrap()).unwrap().flexible_hz()[..3].to_vec()
}

#[test]
fn a_run_fills_its_weights_from_the_machine_that_was_updated() {
    let mut nominal = load_machine("reference", "paper-tool").unwrap();
    // So slow that the corner of the current weight is 1.1 times the last mode without the tool, not 0.15 of the rate.
    nominal.spindle.electronics.sample_rate_hz = 8.0 * flexible_hz(&nominal)[2];
    let mut truth = nominal.clone();
    truth.spindle.sections.iter_mut().for_each(|s| s.modulus_scale *= 0.9);
    let resonances = flexible_hz(&truth).into_iter().map(|hz| Some(Target::read_off(hz))).collect();
    let targets = Targets { resonances, ..Targets::default() };
    let text = shipped::WEIGHTS.iter().find(|w| w.name == "machine").unwrap().text;
    let uncertain = text.replace("[0.01, 0.01]", "[0.01, 0.01, 0.01]");
    let weights = read_weights("w.yaml", &uncertain).unwrap();
    let found = run(
        &Task {
            nominal: &nominal,
            targets: Some(&targets),
            weights: &weights,
            settings: &DesignSettings::default(),
            pid: TuneSettings::quick(),
            extent: Extent::Controller,
        },
        &mut |_| (),
    )
    .unwrap();
    let used = found.design.problems.aim.current_rolloff_hz;
    // Moduli 10 % lower: modes √0.9 as high where the whole shaft follows.
    let share = used / weights.on(&nominal).unwrap().current_rolloff_hz;
    assert!((share / 0.9f64.sqrt() - 1.0).abs() < 0.01, "{share}");
    assert_eq!(used, weights.on(&found.machine).unwrap().current_rolloff_hz);
}
