//! Worst case over uncertain natural frequencies: against plants that are really shifted, against a closed form, and
//! against random plants of the set.

use crate::support::controller::Law;
use crate::support::figures::Loop;
use crate::support::files::{below_root, read_yaml};
use crate::support::rotor::Rotor;
use muspin::controller::{ControlLaw, Controller};
use muspin::input::load_machine;
use muspin::linalg::Mat;
use muspin::lti::{Discrete, FrequencyGrid, StateSpace};
use muspin::predict::closed_loop::{compliance, sensitivity};
use muspin::predict::dips::dips;
use muspin::predict::modes::loop_modes;
use muspin::predict::worst_case::{ModeUncertainty, SETTLED, worst_case};
use muspin::spindle::{Machine, ModelDetail, Plant};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

fn machine() -> Machine {
    load_machine("reference", "paper-tool").unwrap()
}

/// A PID that levitates; nothing here depends on how good it is.
fn controller() -> Controller {
    let parameters = crate::pid::reference_pid::reference_pid(&machine());
    muspin::pid::parameters::pid_controller(&parameters, 5e-5, "pid").unwrap()
}

fn law(controller: &Controller) -> StateSpace<Discrete> {
    match &controller.law {
        ControlLaw::Discrete(law) => law.clone(),
        ControlLaw::Continuous(_) => panic!("sampled"),
    }
}

#[test]
fn both_bounds_hold_for_plants_that_are_really_shifted() {
    let machine = machine();
    let k = controller();
    let uncertainty = ModeUncertainty { relative: vec![0.03, 0.02, 0.04] };
    let grid = FrequencyGrid::from_hz([10.0, 321.0, 833.0, 1063.0, 1120.0, 1933.0, 3215.0]);
    for rpm in [0.0, 50_000.0] {
        let plant = Plant::new(&machine, rpm * TAU / 60.0, ModelDetail::Full).unwrap();
        let worst = worst_case(&plant, &k, &uncertainty, &grid);
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let drawn: Vec<Plant> = (0..40)
            .map(|_| {
                let factors: Vec<f64> =
                    uncertainty.relative.iter().map(|r| 1.0 + r * random.random_range(-1.0..=1.0)).collect();
                plant.with_scaled_modes(&factors)
            })
            .chain(uncertainty.corners().iter().map(|f| plant.with_scaled_modes(f)))
            .collect();
        for (line, omega) in grid.omega_rad_s().iter().enumerate() {
            let nominal = compliance(&plant, &k, *omega);
            let s = sensitivity(&plant, &k, *omega);
            for axis in 0..2 {
                let found = &worst.compliance[axis].lines[line];
                assert!((found.nominal / nominal[(axis, axis)].norm() - 1.0).abs() < 1e-9);
                assert!(found.upper / found.lower < 1.0 + 1.01 * SETTLED, "{found:?}");
                // What is said to be attained is attained by the plant that is named.
                let named = plant.with_scaled_modes(&found.factors);
                let attained = compliance(&named, &k, *omega)[(axis, axis)].norm();
                assert!((attained / found.lower - 1.0).abs() < 1e-7, "{rpm} rpm, line {line}");
                for plant in &drawn {
                    let value = compliance(plant, &k, *omega)[(axis, axis)].norm();
                    assert!(value <= found.upper * (1.0 + 1e-9), "{rpm} rpm, line {line}");
                }
            }
            for axis in 0..4 {
                let found = &worst.sensitivity[axis].lines[line];
                assert!((found.nominal / s[(axis, axis)].norm() - 1.0).abs() < 1e-9);
                for plant in drawn.iter().take(12) {
                    let value = sensitivity(plant, &k, *omega)[(axis, axis)].norm();
                    assert!(value <= found.upper * (1.0 + 1e-9), "{rpm} rpm, line {line}");
                }
            }
        }
    }
}

#[test]
fn both_bounds_hold_for_shifted_rotors_of_the_second_road() {
    let machine = machine();
    let k = controller();
    let own_rotor = Rotor::new(
        &read_yaml(&below_root("spindles/reference.yaml")),
        &read_yaml(&below_root("spindles/tools/paper-tool.yaml")),
    );
    let sampled = law(&k);
    let own_law = Law::of(&sampled);
    let uncertainty = ModeUncertainty { relative: vec![0.03, 0.02, 0.04] };
    let grid = FrequencyGrid::from_hz([10.0, 321.0, 833.0, 1063.0, 1120.0, 1933.0, 3215.0]);
    for rpm in [0.0, 50_000.0] {
        let plant = Plant::new(&machine, rpm * TAU / 60.0, ModelDetail::Full).unwrap();
        let worst = worst_case(&plant, &k, &uncertainty, &grid);
        let line = |factors: &[f64], hz: f64| {
            let rotor = own_rotor.with_scaled_modes(factors);
            Loop::lines_only(&rotor, &own_law, rpm).line(hz)
        };
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut drawn = uncertainty.corners();
        for _ in 0..12 {
            let within = |r: &f64| 1.0 + r * random.random_range(-1.0..=1.0);
            drawn.push(uncertainty.relative.iter().map(within).collect());
        }
        for (at, hz) in grid.hz().into_iter().enumerate() {
            let soft = &worst.compliance[0].lines[at];
            // Modes beyond 24 kHz are static in the program: 1e-4 of the open loop, more beside a resonance.
            let (_, named, _) = line(&soft.factors, hz);
            assert!((named * soft.lower - 1.0).abs() < 1e-3, "{rpm} rpm, {hz} Hz: {named} {soft:?}");
            for factors in &drawn {
                let (_, stiffness, sensitivity) = line(factors, hz);
                assert!(stiffness * soft.upper > 1.0 - 1e-3, "{rpm} rpm, {hz} Hz: {stiffness} {soft:?}");
                for bearing in 0..2 {
                    let bound = worst.sensitivity[2 * bearing].lines[at].upper;
                    assert!(sensitivity[bearing] < bound * (1.0 + 1e-3), "{rpm} rpm, {hz} Hz");
                }
            }
        }
    }
}

#[test]
fn one_uncertain_mode_gives_the_largest_point_of_an_arc() {
    let machine = machine();
    let k = controller();
    let plant = Plant::new(&machine, 0.0, ModelDetail::Full).unwrap();
    let grid = FrequencyGrid::from_hz([900.0, 1050.0, 1080.0, 1100.0, 1250.0]);
    let uncertainty = ModeUncertainty { relative: vec![0.05] };
    let worst = worst_case(&plant, &k, &uncertainty, &grid);
    for (line, omega) in grid.omega_rad_s().iter().enumerate() {
        // A real parameter moves the response along a circle: three points give it, a scan finds its largest modulus.
        let scanned = (0..=2000)
            .map(|i| {
                let kappa = 0.95f64.powi(2) + (1.05f64.powi(2) - 0.95f64.powi(2)) * f64::from(i) / 2000.0;
                let shifted = plant.with_scaled_modes(&[kappa.sqrt()]);
                compliance(&shifted, &k, *omega)[(0, 0)].norm()
            })
            .fold(0.0, f64::max);
        let found = &worst.compliance[0].lines[line];
        assert!(found.upper >= scanned * (1.0 - 1e-9));
        assert!(found.upper <= scanned * (1.0 + 2.0 * SETTLED), "{found:?} {scanned}");
    }
}

#[test]
fn without_uncertainty_the_worst_case_is_the_nominal_one() {
    let k = controller();
    let plant = Plant::new(&machine(), 0.0, ModelDetail::Full).unwrap();
    let grid = FrequencyGrid::from_hz([10.0, 1093.0]);
    for relative in [vec![], vec![0.0; 3]] {
        let worst = worst_case(&plant, &k, &ModeUncertainty { relative }, &grid);
        for line in &worst.compliance[0].lines {
            assert_eq!(line.nominal.to_bits(), line.upper.to_bits());
            assert_eq!(line.nominal.to_bits(), line.lower.to_bits());
        }
    }
}

#[test]
fn damping_of_a_mode_is_the_half_power_width_of_its_peak() {
    let machine = machine();
    let k = controller();
    let plant = Plant::new(&machine, 0.0, ModelDetail::Full).unwrap();
    let modes = loop_modes(&plant, &law(&k)).unwrap();
    let with_ports = plant.with_modal_ports(3);
    let mut compared = 0;
    for (k_mode, mode) in modes.flexible.iter().enumerate() {
        let mode = mode.unwrap();
        let natural = plant.flexible_rad_s()[k_mode] / TAU;
        assert!((mode.frequency_hz / natural).ln().abs() < 0.3, "{mode:?}");
        if mode.damping_ratio > 0.02 {
            continue;
        }
        // q per force on the mode, closed by hand.
        let q = |hz: f64| {
            let w = TAU * hz;
            let p = muspin::lti::Response::at(&with_ports, w);
            let c = muspin::lti::HeldResponse::held_at(&k, w);
            let column = 10 + 2 * k_mode;
            let part = |r: usize, s: usize, nr: usize, ns: usize| p.submatrix(r, s, nr, ns).to_owned();
            let difference = Mat::from_fn(4, 4, |i, j| {
                let own = muspin::linalg::c64::new(f64::from(u8::from(i == j)), 0.0);
                (0..4).fold(own, |sum, l| sum - p[(i, l)] * c[(l, j)])
            });
            let y = muspin::linalg::solve_complex(&difference, &part(0, column, 4, 1));
            let u = &c * &y;
            (p[(column, column)] + (part(column, 0, 1, 4) * u)[(0, 0)]).norm()
        };
        let (f, z) = (mode.frequency_hz, mode.damping_ratio);
        let peak = (-200..=200).map(|i| q(f * (1.0 + z * f64::from(i) / 100.0))).fold(0.0, f64::max);
        let width = (-6000..=6000).filter(|i| q(f * (1.0 + z * f64::from(*i) / 1000.0)) > peak / 2f64.sqrt()).count()
            as f64
            / 1000.0
            * z;
        assert!((width / (2.0 * z) - 1.0).abs() < 0.15, "{mode:?}: width {width}");
        compared += 1;
    }
    assert!(compared > 0, "{modes:?}");
}

#[test]
fn a_dip_is_as_deep_as_its_lower_side() {
    let f: Vec<f64> = (1..=9).map(f64::from).collect();
    let k = [5.0, 2.0, 4.0, 1.0, 8.0, 7.9, 8.1, 3.0, 6.0];
    let found = dips(&f, &k, 1.0, 9.0, 1.0);
    let expected = [(2.0, 2.0), (4.0, 5.0), (6.0, 8.0 / 7.9), (8.0, 2.0)];
    assert_eq!(found.len(), expected.len());
    for (dip, (hz, prominence)) in found.iter().zip(expected) {
        assert_eq!(dip.frequency_hz, hz);
        assert!((dip.prominence - prominence).abs() < 1e-12, "{dip:?}");
    }
    assert_eq!(dips(&f, &k, 1.0, 9.0, 1.122).len(), 3);
    assert!(dips(&[], &[], 1.0, 9.0, 1.0).is_empty());
}
