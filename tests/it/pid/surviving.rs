//! Rotors whose gyroscopics decide: a law that is searched over speed is stable at speeds that the search did not see,
//! by the eigenvalues of the full sampled plant.

use crate::support::files::below_root;
use muspin::controller::verification::growth_rate;
use muspin::input::load_machine;
use muspin::lti::connect::append;
use muspin::pid::surviving::{SurvivingLaw, find_surviving_law};
use muspin::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::TAU;

fn rotor(name: &str, tool: &str) -> Machine {
    let path = |file: String| below_root(&format!("tests/data/rotors/{file}")).to_str().unwrap().to_owned();
    load_machine(&path(format!("{name}.yaml")), &path(format!("{tool}.tool.yaml"))).unwrap()
}

/// Largest growth rate over seventeen speeds to 1.2 times the top speed, none of which the search has, 1/s.
fn worst_growth(machine: &Machine, law: &SurvivingLaw) -> f64 {
    let order = [0usize, 2, 1, 3];
    let controller = append(&law.plane, &law.plane).select(&order, &order);
    let to_rpm = 1.2 * machine.spindle.max_rpm;
    let at = |k: usize| {
        let speed_rpm = to_rpm * (k as f64 + 0.37) / 17.0;
        let plant = Plant::new(machine, speed_rpm * TAU / 60.0, ModelDetail::Full).unwrap();
        growth_rate(&plant.sample_plant().unwrap(), &controller).unwrap()
    };
    (0..17).map(at).fold(f64::NEG_INFINITY, f64::max)
}

fn floats(name: &str, tool: &str) {
    let machine = rotor(name, tool);
    let found = find_surviving_law(&machine, 1.2 * machine.spindle.max_rpm).unwrap();
    assert!(found.worst.rate_per_s < 0.0, "{name}: {:?}", found.worst);
    let growth = worst_growth(&machine, &found);
    assert!(growth < 0.0, "{name}: grows with {growth} 1/s between the speeds judged");
}

#[test]
fn a_flywheel_floats_from_rest_to_its_overspeed() {
    floats("n3-flywheel", "n3-flywheel");
}

/// The other rotors, half a minute:
/// `cargo test --release --test it pid::surviving::long -- --ignored`
mod long {
    use super::floats;

    #[test]
    #[ignore = "half a minute in a release build"]
    fn a_pump_and_a_rotor_with_two_discs_float() {
        floats("g2-pump", "g2-pump");
        floats("friswell", "friswell");
        floats("friswell-small", "friswell");
    }
}
