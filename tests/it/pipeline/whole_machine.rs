//! Every figure that is printed about a design, against the second road of [`crate::support`]: stability, stiffness,
//! sensitivity and μ of given controllers on the reference spindle and on three others, at rest, half and full speed.
//!
//! The controllers of `tests/data/designs` are earlier designs of the program: a figure is one of a machine and a
//! controller, and what a newer design would be does not matter here.

use crate::support::beam::Shaft;
use crate::support::controller::Law;
use crate::support::figures::{Figures, Loop, decibel, zone};
use crate::support::files::{SpindleFile, ToolFile, WeightsFile, below_root, read_yaml};
use crate::support::robustness::{Specification, scaled_bound};
use crate::support::rotor::{Command, Rotor};
use faer::{Mat, c64};
use muspin::augment::assembly::{UncertainMode, scale_controller};
use muspin::augment::plane::{connected_part, modes_below_nyquist};
use muspin::controller::Controller;
use muspin::controller::verification::verify_at;
use muspin::input::controller::CHANNELS;
use muspin::input::{load_controller, load_machine, load_weights, read_controller};
use muspin::lti::Response;
use muspin::lti::sample::inverse_tustin;
use muspin::pipeline::certificates::peak;
use muspin::pipeline::comparison::{discrete, predict};
use muspin::pipeline::problems::whole_machine;
use muspin::pipeline::speed_mu::mu_at_speed;
use muspin::predict::closed_loop::sensitivity;
use muspin::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::TAU;
use std::path::PathBuf;

/// Spindle, tool, folder of controllers.
const MACHINES: [(&str, &str); 4] = [
    ("reference-updated", "paper-tool"),
    ("s04-noncollocated", "endmill-12-long"),
    ("s09-four-modes", "endmill-16"),
    ("s12-big-discs", "test-arbor"),
];
const CONTROLLERS: [&str; 2] = ["mu", "pid"];

/// A machine on both roads.
struct Case {
    name: &'static str,
    machine: Machine,
    rotor: Rotor,
}

impl Case {
    fn new((name, tool): (&'static str, &str)) -> Self {
        let spindle = below_root(&format!("tests/data/spindles/{name}.yaml"));
        let tool_path = below_root(&format!("spindles/tools/{tool}.yaml"));
        let own_spindle: SpindleFile = read_yaml(&spindle);
        let own_tool: ToolFile = read_yaml(&tool_path);
        Self {
            name,
            machine: load_machine(&spindle.display().to_string(), tool).unwrap(),
            rotor: Rotor::new(&own_spindle, &own_tool),
        }
    }

    fn controller(&self, which: &str) -> (Controller, Law) {
        let path = self.controller_path(which);
        let theirs = load_controller(&path.display().to_string()).unwrap();
        (theirs, Law::read(&path))
    }

    fn controller_path(&self, which: &str) -> PathBuf {
        below_root(&format!("tests/data/designs/{}/{which}.json", self.name))
    }
}

#[test]
fn a_slender_beam_has_the_frequencies_of_the_closed_form() {
    let text = "
rotor:
  materials: {steel: {youngs_modulus_pa: 2.0e+11, density_kg_m3: 8000, poisson_ratio: 0.3}}
  elements: [ELEMENTS]
  damping_ratio: [0.0]
  flexible_modes: 3
planes: {front_sensor_m: 0.5, front_actuator_m: 0.6, rear_actuator_m: 1.4, rear_sensor_m: 1.5}
bearings: {front: {ki_n_per_a: 1, ks_n_per_m: 1}, rear: {ki_n_per_a: 1, ks_n_per_m: 1}}
electronics: {amplifier_bandwidth_hz: 1, sensor_bandwidth_hz: 1, delay_s: 1, sample_rate_hz: 1}
speed: {max_rpm: 1}";
    let element = "{length_m: 0.05, outer_diameter_m: 0.002, material: steel}";
    let text = text.replace("ELEMENTS", &[element; 40].join(", "));
    let spindle: SpindleFile = serde_yaml::from_str(&text).unwrap();
    let tool: ToolFile = serde_yaml::from_str("tool_plane_m: 0.0").unwrap();
    let rotor = Rotor::new(&spindle, &tool);
    // Free Euler beam: ω = (βl)²/l² √(EI/ρA), cosh βl cos βl = 1; √(I/A) = d/4.
    for (k, beta) in [4.730_040_744_862_7, 7.853_204_624_095_8, 10.995_607_838_001_7].iter().enumerate() {
        let closed = beta * beta / 4.0 * (2.0e11f64 / 8000.0).sqrt() * 0.002 / 4.0;
        let found = rotor.omega_rad_s[2 + k];
        // Shear and rotary inertia take (βd/4l)²·(1 + E/κG)/2 ≈ 1e-5; the mesh adds 1e-6.
        assert!((found / closed - 1.0).abs() < 3e-5, "mode {k}: {found} {closed}");
    }
    let shaft = Shaft::new(&spindle, &tool);
    let mass: f64 = 8000.0 * std::f64::consts::PI / 4.0 * 0.002f64.powi(2) * 2.0;
    let row = shaft.row(0.333);
    // A rigid displacement and a rigid rotation are read exactly.
    let read = |v: &dyn Fn(usize) -> f64| (0..row.len()).map(|i| row[i] * v(i)).sum::<f64>();
    assert!((read(&|i| f64::from(u8::from(i % 2 == 0))) - 1.0).abs() < 1e-12);
    let turned = |i: usize| {
        if i.is_multiple_of(2) { shaft.position_m[i / 2] } else { 1.0 }
    };
    assert!((read(&turned) - 0.333).abs() < 1e-12);
    let total: f64 = (0..row.len())
        .step_by(2)
        .flat_map(|i| (0..row.len()).step_by(2).map(move |j| (i, j)))
        .map(|at| shaft.mass[at])
        .sum();
    assert!((total / mass - 1.0).abs() < 1e-12);
}

#[test]
fn the_scaled_bound_of_a_product_of_vectors_is_its_closed_form() {
    // M = a bᴴ: μ = Σ |aᵢ bᵢ| over the scalars + ‖a‖ ‖b‖ of the full block, and the bound is attained.
    for scalars in [0, 1, 2, 4] {
        let a: Vec<f64> = (0..6).map(|k| 0.3 + 7.0 * f64::from(k * k % 5)).collect();
        let b: Vec<f64> = (0..6).map(|k| 2.0 / (1.0 + f64::from(3 * k % 7))).collect();
        let m = Mat::from_fn(6, 6, |i, j| c64::from_polar(a[i] * b[j], 0.7 * i as f64 - 1.1 * (j * j) as f64));
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let alone: f64 = (0..scalars).map(|k| a[k] * b[k]).sum();
        let closed = alone + norm(&a[scalars..]) * norm(&b[scalars..]);
        let found = scaled_bound(&m, scalars, None);
        // The method stops at a gap of 1e-5.
        assert!((found / closed - 1.0).abs() < 1.1e-5, "{scalars}: {found} {closed}");
    }
}

#[test]
fn the_open_loop_is_that_of_the_whole_mesh() {
    for case in MACHINES.map(Case::new) {
        for share in [0.0, 1.0] {
            let rpm = share * case.rotor.max_rpm;
            let plant = Plant::new(&case.machine, rpm * TAU / 60.0, ModelDetail::Full).unwrap();
            for hz in [3.0, 240.0, 1500.0, 3900.0, 8800.0] {
                let theirs = plant.at(TAU * hz);
                let tolerance = if hz < 4000.0 { 1e-4 } else { 5e-3 };
                let (forward, backward) = (
                    case.rotor.response(hz, rpm, 0, Command::Continuous),
                    case.rotor.response(-hz, rpm, 0, Command::Continuous),
                );
                // Channels: currents and tool force in, signals and tool displacement out.
                for (out, own_out) in [(0, 3), (2, 4), (4, 0)] {
                    for (input, own_in) in [(0, 3), (2, 4), (4, 0)] {
                        let own = 0.5 * (forward[(own_out, own_in)] + backward[(own_out, own_in)].conj());
                        let found = theirs[(out, input)];
                        let scale = (own.norm_sqr() + forward[(own_out, own_in)].norm_sqr()).sqrt();
                        // Modes beyond 24 kHz are there as Ritz vectors only; beside a resonance a hundred-thousandth
                        // of its frequency is 0.3 %.
                        assert!(
                            (found - own).norm() < tolerance * scale,
                            "{} {rpm} rpm {hz} Hz {out}{input}: {found} {own}",
                            case.name
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn stiffness_sensitivity_and_growth_rate_are_those_of_the_whole_machine() {
    let mut wrong = vec![];
    for case in MACHINES.map(Case::new) {
        for which in CONTROLLERS {
            let (controller, law) = case.controller(which);
            for share in [0.0, 0.5, 1.0] {
                let rpm = share * case.rotor.max_rpm;
                let own = Loop::new(&case.rotor, &law, rpm);
                let at = format!("{} {which} {rpm} rpm", case.name);
                let mut hold = |what: &str, claimed: f64, true_value: f64, tolerance: f64| {
                    if (claimed - true_value).abs() > tolerance || !claimed.is_finite() {
                        wrong.push(format!("{at}: {what} {claimed} stated, {true_value} true"));
                    }
                };
                let period = case.rotor.period_s;
                let sampled = discrete(&controller, period).unwrap();
                let check = verify_at(&case.machine, &sampled, &[rpm], "test").unwrap();
                let growth = own.growth_rate_per_s();
                // Modes beyond those of the full plant; a pole moves by its residue times 1e-5 of the plant.
                hold("growth rate", check.speeds[0].growth_rate_per_s, growth, 2e-3 * growth.abs() + 0.02);
                // A file may say that another band counts for the stiffness; the sensitivity is read to Nyquist.
                let mut machine = case.machine.clone();
                if share == 0.5 {
                    machine.spindle.stiffness_band_hz = (30.0, 2500.0);
                }
                let stated = predict(&machine, &controller, rpm).unwrap();
                if growth >= 0.0 {
                    // An unstable loop has no stiffness.
                    if stated.minimum.0.is_finite() || stated.at_10_hz_n_per_m.is_finite() {
                        wrong.push(format!("{at}: a stiffness of an unstable loop"));
                    }
                    continue;
                }
                let found: Figures = own.figures(machine.spindle.stiffness_band_hz);
                // Lines round a peak: a per mille of its height; and 1e-4 of the plant.
                let (minimum, hz) = found.minimum;
                hold("smallest stiffness", stated.minimum.0, minimum, 2e-3 * minimum);
                let there = own.stiffness_n_per_m(stated.minimum.1);
                hold("stiffness at the frequency stated", there, minimum, 2e-3 * minimum);
                hold("frequency of it", stated.minimum.1, hz, 0.02 * hz);
                let low = own.stiffness_n_per_m(10.0);
                hold("at 10 Hz", stated.at_10_hz_n_per_m, low, 1e-3 * low);
                let top = own.stiffness_n_per_m(case.rotor.max_rpm / 60.0);
                hold("at the top speed's frequency", stated.at_max_speed_n_per_m, top, 1e-3 * top);
                let found = own.figures((1.0, 0.49 / period));
                for (bearing, (db, _)) in found.sensitivity_db.iter().enumerate() {
                    for axis in [2 * bearing, 2 * bearing + 1] {
                        let peak = decibel(stated.sensitivity.peak(axis).0);
                        hold(&format!("sensitivity of axis {axis}"), peak, *db, 0.02);
                    }
                }
                let worst = found.sensitivity_db[0].0.max(found.sensitivity_db[1].0);
                if stated.sensitivity.zone().letter() != zone(worst) {
                    hold("zone of a sensitivity", f64::NAN, worst, 0.0);
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_controller_in_continuous_time_acts_without_a_hold() {
    let case = Case::new(MACHINES[0]);
    // A gain alone: any loop has lines, stable or not.
    let diagonal = |value: [f64; 4]| -> Vec<Vec<f64>> {
        let row = |i: usize| (0..4).map(|j| if i == j { value[i] } else { 0.0 }).collect();
        (0..4).map(row).collect()
    };
    let gains = diagonal([-9e4, -9e4, -7e4, -7e4]);
    let empty = || vec![vec![]; 4];
    let period_s = case.rotor.period_s;
    let own_law = |sample_time_s: f64| Law::new([vec![], vec![], empty(), gains.clone()], sample_time_s);
    let (held, whole) = (own_law(period_s), own_law(0.0));
    let mut largest_difference = 0.0f64;
    for rpm in [0.0, case.rotor.max_rpm] {
        let plant = Plant::new(&case.machine, rpm * TAU / 60.0, ModelDetail::Full).unwrap();
        for hz in [7.0, 300.0, 1072.0, 1960.0, 3215.0] {
            let own = [&whole, &held].map(|law| Loop::lines_only(&case.rotor, law, rpm).line(hz).2[0]);
            largest_difference = largest_difference.max((own[1] / own[0] - 1.0).abs());
            for (law, expected) in [&whole, &held].into_iter().zip(own) {
                let text = serde_json::json!({
                    "name": "gain", "inputs": CHANNELS, "outputs": CHANNELS, "sample_time_s": law.sample_time_s,
                    "A": [], "B": [], "C": empty(), "D": gains,
                });
                let theirs = read_controller("gain.json", &text.to_string()).unwrap();
                let stated = sensitivity(&plant, &theirs, TAU * hz)[(0, 0)].norm();
                // The open loop agrees to 1e-4; beside a resonance the closed one does less well.
                assert!((stated / expected - 1.0).abs() < 2e-3, "{rpm} rpm, {hz} Hz: {stated} {expected}");
            }
        }
    }
    // At 3.2 kHz the hold takes 4 % of the gain: more than twice what the comparison forgives must be left of it.
    assert!(largest_difference > 5e-3, "{largest_difference}: the lines chosen do not show the hold");
}

#[test]
fn mu_of_the_specification_is_that_of_the_whole_machine() {
    let mut wrong = vec![];
    let written: WeightsFile = read_yaml(&below_root("weights/benchmark.yaml"));
    let weights = load_weights("benchmark").unwrap();
    for case in MACHINES.map(Case::new) {
        let specification = Specification::as_written(written.clone(), case.machine.spindle.flexible_modes);
        let uncertain = specification.uncertainty.iter().enumerate();
        let modes: Vec<UncertainMode> = uncertain
            .map(|(number, relative)| UncertainMode {
                number,
                omega_rad_s: case.rotor.omega_rad_s[2 + number],
                relative: *relative,
            })
            .collect();
        for (which, share) in [("mu", 0.0), ("mu", 0.5), ("mu", 1.0), ("pid", 0.0)] {
            let rpm = share * case.rotor.max_rpm;
            let (controller, law) = case.controller(which);
            let sampled = discrete(&controller, case.rotor.period_s).unwrap();
            let own = specification.peak(&Loop::new(&case.rotor, &law, rpm));
            let stated = mu_at_speed(&case.machine, &weights, &modes, &sampled, rpm).unwrap();
            // Lines round a peak on both roads: half a per cent of its height.
            if (stated.mu / own.mu - 1.0).abs() > 5e-3 {
                wrong.push(format!("{} {which} {rpm} rpm: {stated:?}, {own:?}", case.name));
            }
            if rpm != 0.0 {
                continue;
            }
            let below_nyquist = modes_below_nyquist(&case.machine).unwrap().len();
            let plant = whole_machine(&case.machine, &weights, below_nyquist, &modes).unwrap();
            let plane = connected_part(&sampled.select(&[0, 2], &[0, 2]));
            let plane = scale_controller(&inverse_tustin(&plane).unwrap());
            let certified = peak("test", &plant, &plane).unwrap();
            // Weights are fitted from above, and the uncertainty acts through the inverse hold: never below, at most 10
            // % above.
            if !(certified.upper > own.mu * 0.998 && certified.upper < own.mu * 1.1) {
                wrong.push(format!("{} {which}: {} certified, {own:?}", case.name, certified.upper));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
