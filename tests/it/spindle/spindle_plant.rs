//! The open-loop plant against the plain FE matrices, its realisations against its response.

use crate::rotor::rotor_reference::receptance;
use muspin::input::load_machine;
use muspin::linalg::{Mat, c64};
use muspin::lti::delay::sample_with_delay;
use muspin::lti::{Continuous, Response, StateSpace};
use muspin::rotor::{Damping, PlanarModes, Support};
use muspin::spindle::response::{SIDE, Square};
use muspin::spindle::{Effect, EffectKind, Location, Machine, ModelDetail, Plane, Plant, PlantLoop};
use std::f64::consts::TAU;

pub fn reference() -> Machine {
    load_machine("reference", "paper-tool").unwrap()
}

pub fn krpm(x: f64) -> f64 {
    x * 1000.0 * TAU / 60.0
}

/// Largest difference of two matrices, relative to the largest entry of each 2×2 block of `expected`: channels differ
/// by orders of magnitude, and the x–y entries of a block vanish at rest.
pub fn block_error(found: &Mat<c64>, expected: &Mat<c64>) -> f64 {
    let mut worst = 0.0f64;
    for i in (0..expected.nrows()).step_by(2) {
        for j in (0..expected.ncols()).step_by(2) {
            let (f, e) = (found.submatrix(i, j, 2, 2), expected.submatrix(i, j, 2, 2));
            worst = worst.max((f - e).norm_max() / e.norm_max());
        }
    }
    worst
}

fn magnets(machine: &Machine) -> Vec<Support> {
    let p = &machine.spindle.planes;
    let s = &machine.spindle;
    let planes = [(p.front_actuator_m, s.front.ks_n_per_m), (p.rear_actuator_m, s.rear.ks_n_per_m)];
    planes
        .map(|(position_m, ks)| Support {
            position_m,
            stiffness_n_per_m: [[-ks, 0.0], [0.0, -ks]],
            damping_n_s_per_m: [[0.0; 2]; 2],
        })
        .to_vec()
}

#[test]
fn the_full_plant_is_the_finite_element_model_at_every_speed() {
    let machine = reference();
    let rotor = machine.rotor().unwrap();
    let n = rotor.dofs();
    let damping = Damping::Modal((0..n - 2).map(|k| machine.damping_ratio(k)).collect());
    let p = &machine.spindle.planes;
    let z = [machine.tool_plane_m(), p.front_actuator_m, p.rear_actuator_m, p.front_sensor_m, p.rear_sensor_m];
    let node = z.map(|z| rotor.shape_at("plane", z).unwrap()[0].0);
    for speed in [0.0, 25.0, 50.0].map(krpm) {
        let plant = Plant::new(&machine, speed, ModelDetail::Full).unwrap();
        for hz in [1.0, 97.0, 833.0, 1165.0, 2063.0, 3425.0, 4000.0] {
            let omega = TAU * hz;
            let fe = receptance(&rotor, &damping, &magnets(&machine), speed, omega);
            let dof = |k: usize, axis: usize| node[k] + axis * n;
            let expected = Mat::from_fn(6, 6, |i, j| fe[(dof(i / 2, i % 2), dof(j / 2, j % 2))]);
            let found = plant.at(omega);
            let loads = found.submatrix(4, 4, 6, 6).to_owned();
            let error = block_error(&loads, &expected);
            // What the pseudo-modes do not hold of the modes beyond 24 kHz: 1.2e-5 at 4 kHz and 50 000 rpm.
            assert!(error < 3e-5, "loads, {speed} rad/s, {hz} Hz: {error:.1e}");
            // Current to signal: the chain round the same receptance.
            let e = &machine.spindle.electronics;
            let lag = |b: f64| (c64::new(1.0, omega / (TAU * b))).inv();
            let chain =
                c64::from_polar(1.0, -omega * e.delay_s) * lag(e.amplifier_bandwidth_hz) * lag(e.sensor_bandwidth_hz);
            let ki = [machine.spindle.front.ki_n_per_a, machine.spindle.rear.ki_n_per_a];
            let expected =
                Mat::from_fn(4, 4, |i, j| chain * ki[j / 2] * fe[(dof(3 + i / 2, i % 2), dof(1 + j / 2, j % 2))]);
            let error = block_error(&found.submatrix(0, 0, 4, 4).to_owned(), &expected);
            assert!(error < 3e-5, "signals, {speed} rad/s, {hz} Hz: {error:.1e}");
        }
    }
}

#[test]
fn the_static_residual_makes_the_truncated_model_exact_at_low_frequency() {
    let machine = reference();
    let full = Plant::new(&machine, 0.0, ModelDetail::Full).unwrap();
    let with = |static_residual| {
        let detail = ModelDetail::Modes { flexible: 3, static_residual };
        Plant::new(&machine, 0.0, detail).unwrap()
    };
    let gap = |plant: &Plant, hz: f64| block_error(&plant.at(TAU * hz), &full.at(TAU * hz));
    // The cut modes, 5 kHz and up, add 3e-3; at 10 Hz they are static to (10/5000)² of that.
    assert!(gap(&with(true), 10.0) < 1e-7);
    assert!(gap(&with(false), 10.0) > 1e-4);
    // Near an antiresonance the residual is what places the zero.
    assert!(gap(&with(true), 2063.0) < 0.25 * gap(&with(false), 2063.0));
}

#[test]
fn poles_and_zeros_of_a_collocated_pair_interlace() {
    let machine = reference();
    let rotor = machine.rotor().unwrap();
    let z = machine.spindle.planes.front_actuator_m;
    let poles = PlanarModes::new(&rotor).unwrap().flexible_hz();
    let zeros = rotor.antiresonances_hz(z, z, 1.0, 12_000.0).unwrap();
    // A zero lies below the first flexible mode (above the rigid ones) and one between any two neighbours.
    for (k, zero) in zeros.iter().enumerate() {
        let below = if k == 0 { 0.0 } else { poles[k - 1] };
        assert!(below < *zero && *zero < poles[k], "{below} {zero} {}", poles[k]);
    }
    assert!(zeros.len() >= 5);
}

#[test]
fn nominal_frequencies_of_the_reference_spindle_are_those_of_its_documentation() {
    let machine = reference();
    let rotor = machine.rotor().unwrap();
    let p = &machine.spindle.planes;
    let within = |found: &[f64], expected: &[f64]| {
        assert!(found.len() >= expected.len(), "{found:?}");
        for (f, e) in found.iter().zip(expected) {
            // Printed to 1 mHz.
            assert!((f - e).abs() < 6e-4, "{f} {e}");
        }
    };
    let poles = PlanarModes::new(&rotor).unwrap().flexible_hz();
    within(&poles, &[1165.151, 2304.000, 3425.590]);
    let zeros = |a, s| rotor.antiresonances_hz(a, s, 100.0, 4000.0).unwrap();
    let front = zeros(p.front_actuator_m, p.front_sensor_m);
    within(&front, &[1198.144, 2062.909, 3821.103]);
    let rear = zeros(p.rear_actuator_m, p.rear_sensor_m);
    within(&rear, &[1006.816, 2218.880]);
}

#[test]
fn rigid_modes_are_exact() {
    let rotor = reference().rotor().unwrap();
    let modes = PlanarModes::new(&rotor).unwrap();
    assert_eq!(&modes.omega_rad_s[..2], &[0.0, 0.0]);
    let m = &modes.matrices;
    let identity = modes.shapes.transpose() * &m.mass * &modes.shapes;
    let n = modes.len();
    assert!((identity - Mat::<f64>::identity(n, n)).norm_max() < 1e-10);
    let symmetric = |a: &Mat<f64>| (a - a.transpose()).norm_max() <= 1e-12 * a.norm_max();
    assert!(symmetric(&m.mass) && symmetric(&m.stiffness) && symmetric(&m.gyroscopic));
}

#[test]
fn each_plane_has_two_unstable_real_poles_and_no_other() {
    let machine = reference();
    for detail in [ModelDetail::Full, ModelDetail::Modes { flexible: 3, static_residual: true }] {
        let plant = Plant::new(&machine, 0.0, detail).unwrap();
        let poles = plant.state_space(0).unwrap().poles().unwrap();
        let unstable: Vec<_> = poles.iter().filter(|p| p.re > 0.0).collect();
        assert_eq!(unstable.len(), 4);
        for pole in unstable {
            let hz = pole.re / TAU;
            assert!(pole.im.abs() < 1e-6 && (60.0..160.0).contains(&hz), "{hz}");
        }
    }
}

/// One of every kind, of moderate size.
pub fn catalogue() -> Vec<Effect> {
    use muspin::spindle::Bearings::{Both, Front, Rear};
    let effect = |kind, location, values: &[f64]| Effect::new(kind, location, values.to_vec()).unwrap();
    let at = Location::Bearing;
    vec![
        effect(EffectKind::LoopDelay, Location::None, &[37e-6]),
        effect(EffectKind::AmplifierBandwidth, at(Front), &[1400.0]),
        effect(EffectKind::AmplifierSecondOrder, at(Front), &[2200.0, 0.5]),
        effect(EffectKind::EddyCurrents, at(Rear), &[9000.0]),
        effect(EffectKind::LaminatedCore, at(Rear), &[3000.0]),
        effect(EffectKind::SensorLowpass, at(Both), &[6000.0]),
        effect(EffectKind::SensorOffset, at(Front), &[0.004]),
        effect(EffectKind::ActuatorOffset, at(Rear), &[-0.003]),
        effect(EffectKind::NegativeStiffness, at(Front), &[1.3]),
        effect(EffectKind::ForceConstant, at(Rear), &[0.9]),
        effect(EffectKind::SensorGain, at(Front), &[1.05]),
        effect(EffectKind::BearingCoupling, at(Front), &[0.06]),
        effect(EffectKind::AxisMisalignment, at(Rear), &[4.0]),
        effect(EffectKind::SensorCrosstalk, Location::Across { from: 0, to: 3 }, &[0.03]),
        effect(EffectKind::CurrentPickup, Location::Across { from: 2, to: 1 }, &[2e-11]),
        effect(EffectKind::Gyroscopic, Location::None, &[0.8]),
        effect(EffectKind::InternalDamping, Location::None, &[3e-7]),
        effect(EffectKind::CrossCoupling, Location::Position(0.25), &[2e5]),
        effect(EffectKind::ModalDamping, Location::Mode(2), &[1.8]),
        effect(EffectKind::ToolJoint, Location::None, &[3e8, 1.5e5, 1.5]),
        effect(EffectKind::ToolMass, Location::None, &[0.006]),
        effect(EffectKind::AddedMass, Location::Position(0.37), &[0.05]),
        effect(EffectKind::AddedDisc, Location::Position(0.2), &[0.15, 3.75e-4, 1.9e-4]),
        effect(EffectKind::HousingMode, Location::None, &[90.0, 550.0, 0.04]),
        effect(EffectKind::RegionStiffness, Location::Region("e7".into()), &[0.85]),
        effect(EffectKind::AddedStiffness, Location::Position(0.23), &[-4e5]),
        effect(EffectKind::AddedDamper, Location::Position(0.23), &[400.0]),
        effect(EffectKind::TiltingStiffness, Location::Position(0.23), &[-3e4]),
    ]
}

#[test]
fn the_catalogue_of_this_test_is_complete() {
    let kinds: Vec<_> = catalogue().iter().map(|e| e.kind).collect();
    assert_eq!(kinds, EffectKind::all().collect::<Vec<_>>());
}

#[test]
fn the_loop_of_a_plant_is_the_plant_at_its_ports() {
    let others = ["s04-noncollocated", "s09-four-modes", "s12-big-discs"].map(|name| {
        let root = env!("CARGO_MANIFEST_DIR");
        load_machine(&format!("{root}/tests/data/spindles/{name}.yaml"), "paper-tool").unwrap()
    });
    let nominal: Vec<Machine> = others.into_iter().chain([reference()]).collect();
    let changed = catalogue().into_iter().map(|e| nominal[3].with_effect(e));
    for machine in changed.chain(nominal.iter().cloned()) {
        for speed in [0.0, krpm(30.0)] {
            let plant = Plant::design_model(&machine, speed).unwrap();
            let loops = PlantLoop::new(&plant);
            for hz in [2.0, 180.0, 1150.0, 3900.0] {
                // Signals and tool stand before the actuators, as currents and force at the tool do.
                let whole = plant.at(TAU * hz);
                let expected = whole.submatrix(0, 0, SIDE, SIDE);
                let of = |found: Square| Mat::from_fn(SIDE, SIDE, |i, j| found[i * SIDE + j]);
                // Sums in another order.
                let error = block_error(&of(loops.at(TAU * hz)), &expected.to_owned());
                assert!(error < 1e-10, "{speed} rad/s, {hz} Hz: {error:.1e}");
                let axes = of(loops.axes_at(TAU * hz)).submatrix(0, 0, 4, 4).to_owned();
                let error = block_error(&axes, &expected.submatrix(0, 0, 4, 4).to_owned());
                assert!(error < 1e-10, "axes, {speed} rad/s, {hz} Hz: {error:.1e}");
            }
        }
    }
}

#[test]
fn the_state_space_answers_like_the_plant_for_every_effect() {
    let nominal = reference();
    let spring = Location::InPlane(0.23, Plane::Y);
    let one = |kind, location, value| Effect::new(kind, location, vec![value]).unwrap();
    let of_one_axis = [
        one(EffectKind::AddedStiffness, spring.clone(), 7e5),
        one(EffectKind::AddedDamper, spring, 300.0),
        one(EffectKind::LoopDelay, Location::Axis(2), 12e-6),
        one(EffectKind::LoopDelay, Location::Axis(1), -8e-6),
        one(EffectKind::AmplifierBandwidth, Location::Axis(3), 1400.0),
        one(EffectKind::SensorLowpass, Location::Axis(0), 6000.0),
    ];
    for effect in catalogue().into_iter().chain(of_one_axis) {
        let machine = nominal.with_effect(effect.clone());
        let machine = Machine::new(machine.spindle, machine.tool).unwrap();
        // The rational eddy currents are an approximation; all else is exact but for the Padé delay.
        let tolerance = match effect.kind {
            EffectKind::EddyCurrents => 0.01,
            // What the lags beyond the last leave of their curvature.
            EffectKind::LaminatedCore => 1e-5,
            _ => 1e-6,
        };
        for detail in [ModelDetail::Full, ModelDetail::Modes { flexible: 4, static_residual: true }] {
            for speed in [0.0, krpm(30.0)] {
                let plant = Plant::new(&machine, speed, detail).unwrap();
                let system = plant.state_space(8).unwrap();
                for hz in [2.0, 180.0, 1150.0, 3900.0] {
                    let (found, expected) = (system.at(TAU * hz), plant.at(TAU * hz));
                    let error = block_error(&found, &expected);
                    let name = effect.kind.name();
                    assert!(error < tolerance, "{name} {detail:?} {speed} {hz} Hz: {error:.1e}");
                }
            }
        }
    }
}

#[test]
fn the_sampled_plant_answers_like_the_plant_at_low_frequency() {
    for (effect, delay) in [(None, 0.0), (Some(17e-6), 17e-6), (Some(60e-6), 60e-6)] {
        let mut machine = reference();
        if let Some(value) = effect {
            let late = Effect::new(EffectKind::LoopDelay, Location::None, vec![value]).unwrap();
            machine = machine.with_effect(late);
        }
        let plant = Plant::design_model(&machine, krpm(20.0)).unwrap();
        let sampled = plant.sample_plant().unwrap();
        for hz in [20.0, 100.0, 300.0] {
            let omega = TAU * hz;
            let (found, expected) = (sampled.at(omega), plant.at(omega));
            let g = |m: &Mat<c64>| m.submatrix(0, 0, 10, 4).to_owned();
            // The hold's droop, (ωT)²/24, and aliasing of what a light mode does beyond the Nyquist frequency.
            let limit = (omega * 5e-5).powi(2) / 12.0 + 2e-4;
            let error = block_error(&g(&found), &g(&expected));
            assert!(error < limit, "delay +{delay} s, {hz} Hz: {error:.1e} > {limit:.1e}");
        }
    }
}

#[test]
fn a_sampled_lag_with_a_fractional_delay_follows_its_closed_form() {
    let (pole, period, delay) = (3000.0, 5e-5, 1.3 * 5e-5);
    let m = |x: f64| Mat::from_fn(1, 1, |_, _| x);
    let lag = StateSpace::new(m(-pole), m(pole), m(1.0), m(0.0), Continuous).unwrap();
    let sampled = sample_with_delay(&lag, 1, delay, period).unwrap();
    // Step response at the samples: 1 − e^{−p(t − τ)} after τ.
    let mut x = Mat::<f64>::zeros(sampled.order(), 1);
    for k in 0..40 {
        let y = (&sampled.c * &x)[(0, 0)] + sampled.d[(0, 0)];
        let t = k as f64 * period - delay;
        let expected = if t > 0.0 { 1.0 - (-pole * t).exp() } else { 0.0 };
        assert!((y - expected).abs() < 1e-12, "sample {k}: {y} {expected}");
        x = &sampled.a * &x + &sampled.b;
    }
}

#[test]
fn modal_ports_inject_and_read_modal_coordinates() {
    let machine = reference();
    let plant = Plant::design_model(&machine, 0.0).unwrap();
    let system = plant.state_space_with_modal_ports(2, 3).unwrap();
    assert_eq!((system.inputs(), system.outputs()), (16, 16));
    // Feeding q back as −Δ q raises ω² of that mode by Δ: compare with a shaft whose first mode moved.
    let delta = 0.02 * plant.flexible_rad_s()[0].powi(2);
    let a = Mat::from_fn(system.order(), system.order(), |i, j| {
        system.a[(i, j)] - delta * (system.b[(i, 10)] * system.c[(10, j)] + system.b[(i, 11)] * system.c[(11, j)])
    });
    let moved = muspin::linalg::eigenvalues(&a).unwrap();
    let nominal = system.poles().unwrap();
    let near = |poles: &[c64], hz: f64| {
        poles
            .iter()
            .filter(|p| p.re > -500.0 && p.im > 0.0)
            .map(|p| p.im / TAU)
            .min_by(|a, b| (a - hz).abs().total_cmp(&(b - hz).abs()))
            .unwrap()
    };
    let (before, after) = (near(&nominal, 1165.0), near(&moved, 1177.0));
    assert!((after / before - 1.01).abs() < 2e-4, "{before} {after}");
}
