//! Below which μ no controller comes, and how far the modes of a loop may shift.

use muspin::augment::assembly::UncertainMode;
use muspin::augment::weights::Weights;
use muspin::controller::ControlLaw;
use muspin::input::{load_controller, load_machine, load_weights};
use muspin::pid::shifted_loops::find_shift_range;
use muspin::pipeline::comparison::predict;
use muspin::pipeline::least_mu::least_mu_of;
use muspin::pipeline::problems::whole_machine;
use muspin::pipeline::shank_limit::ShankLimit;
use muspin::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::PI;

/// The bounds of loads and noise alone, and with the natural frequencies of the specification uncertain.
fn bounds(machine: &Machine, weights: &Weights) -> [f64; 2] {
    let plant = Plant::new(machine, 0.0, ModelDetail::Full).unwrap();
    let period_s = machine.spindle.electronics.sample_period_s();
    // Those that a design counts: below half the sample rate.
    let flexible: Vec<f64> = plant.flexible_rad_s().iter().copied().filter(|omega| *omega < PI / period_s).collect();
    let relative = weights.mode_uncertainty.iter().enumerate();
    let modes: Vec<UncertainMode> = relative
        .map(|(number, relative)| UncertainMode { number, omega_rad_s: flexible[number], relative: *relative })
        .collect();
    let in_plane: Vec<f64> =
        modes.iter().map(|mode| 2.0 / period_s * (0.5 * mode.omega_rad_s * period_s).tan()).collect();
    [&modes[..0], &modes[..]].map(|modes| {
        let posed = whole_machine(machine, weights, flexible.len(), modes).unwrap();
        least_mu_of(&posed, &in_plane[..modes.len()]).expect("a bound")
    })
}

/// A committed design meets Table 2 of the paper, so that the bounds are below one, and what is uncertain only adds to
/// them. Where the bend of the shaft alone breaks the specification, which is shown without any synthesis, they are
/// above.
#[test]
fn no_bound_forbids_what_exists_and_the_bend_of_the_shaft_is_seen() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let mut weights = load_weights("benchmark").unwrap();
    let [nominal, uncertain] = bounds(&machine, &weights);
    assert!(nominal > 0.1 && nominal <= uncertain * 1.001 && uncertain < 1.0, "{nominal} {uncertain}");
    // The bend grows with the load, what the bearings allow does not.
    while ShankLimit::of(&machine, &weights).unwrap().is_none() {
        weights.tool.max_dc_load_n *= 1.1;
    }
    let beyond = bounds(&machine, &weights);
    assert!(beyond.into_iter().all(|bound| bound > 1.0), "{beyond:?} with {} N", weights.tool.max_dc_load_n);
}

/// The moduli moved in the machine itself, by a little less than the shift that is said, leave the loop stable.
#[test]
fn a_loop_bears_the_shift_that_is_said_of_it() {
    const FOLDER: &str = "tests/data/anti_windup";
    let file = |name: &str| format!("{FOLDER}/{name}");
    let machine = load_machine(&file("spindle.yaml"), &file("tool.yaml")).unwrap();
    let controller = load_controller(&file("pid.json")).unwrap();
    let ControlLaw::Discrete(law) = &controller.law else { panic!("not sampled") };
    let range = find_shift_range(&machine, law).unwrap().largest;
    assert!(range > 0.0 && range <= 0.1, "{range}");
    for factor in [1.0 - 0.97 * range, 1.0 + 0.97 * range] {
        let mut shifted = machine.clone();
        for section in shifted.spindle.sections.iter_mut().chain(&mut shifted.tool.sections) {
            section.modulus_scale *= factor * factor;
        }
        for rpm in [0.0, machine.spindle.max_rpm] {
            let growth = predict(&shifted, &controller, rpm).unwrap().growth_rate_per_s;
            assert!(growth < 0.0, "{factor} {rpm}: {growth}");
        }
    }
}
