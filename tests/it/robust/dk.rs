//! D-K iteration against the best peak that other programmes reached.

use crate::robust::control_cases::{Case, block_list, number_list, system};
use muspin::augment::GeneralizedPlant;
use muspin::lti::connect::lower_lft;
use muspin::robust::dk::{DkSettings, iterate};
use muspin::robust::mu::system::MuSystem;

fn plant(case: &Case) -> GeneralizedPlant {
    let count = |key: &str| case.data[key].as_u64().unwrap() as usize;
    GeneralizedPlant {
        system: system(&case.data),
        controls: count("m2"),
        measurements: count("p2"),
        blocks: block_list(&case.data["blocks"]),
    }
}

fn run(id: &str, limit: f64, order_limit: usize) {
    let case = Case::named("dk", id);
    let plant = plant(&case);
    let omega = number_list(&case.data["omega"]);
    let settings = DkSettings { fit_range_rad_s: Some((omega[0], omega[omega.len() - 1])), ..DkSettings::default() };
    let mut seen = 0;
    let outcome = iterate(&plant, &settings, &mut |_| seen += 1).unwrap();
    assert_eq!(seen, outcome.steps.len());
    // The best step is returned, not the last.
    for step in outcome.steps.iter().filter(|s| s.failure.is_none()) {
        assert!(outcome.mu_peak <= step.mu_peak * (1.0 + 1e-3));
    }
    assert!(outcome.mu_peak <= limit, "{} > {limit}", outcome.mu_peak);
    assert!(outcome.controller.order() <= order_limit);
    // An independent dense look at the loop.
    let closed = lower_lft(&plant.system, &outcome.controller).unwrap();
    let dense = MuSystem::new(&closed, &plant.blocks).unwrap();
    let grid: Vec<f64> = (0..400).map(|k| 10f64.powf(-4.0 + 0.025 * f64::from(k))).collect();
    let largest = dense.sweep(&grid).unwrap().iter().map(|p| p.upper).fold(0.0, f64::max);
    assert!(largest <= outcome.mu_peak * (1.0 + 1e-6), "{largest}");
    assert!(outcome.mu_lower_peak <= outcome.mu_peak);
}

#[test]
fn distillation_column() {
    run("skogestad_column", 0.945, 22);
}

#[test]
fn magnetic_bearing_plane() {
    run("amb_1plane", 1.14, 32);
}

#[test]
fn two_mass_spring() {
    run("two_mass_real", 0.907, 14);
}
