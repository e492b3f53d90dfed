//! Every effect of the catalogue changes the plant as its closed form says.

use crate::spindle::spindle_plant::{block_error, catalogue, krpm, reference};
use crate::support::inputs::cut;
use muspin::input::load_machine;
use muspin::linalg::{Mat, c64, solve};
use muspin::lti::Response;

use muspin::rotor::PlanarModes;
use muspin::spindle::{Bearings, Effect, EffectKind, Location, Machine, ModelDetail, Plant};
use std::f64::consts::TAU;

fn plant(machine: &Machine, speed: f64) -> Plant {
    Plant::new(machine, speed, ModelDetail::Full).unwrap()
}

fn with(kind: EffectKind, location: Location, values: &[f64]) -> Machine {
    reference().with_effect(Effect::new(kind, location, values.to_vec()).unwrap())
}

/// The response with `machine` must be left·G·right of the reference, diagonal left and right.
fn scales(machine: &Machine, left: impl Fn(usize, f64) -> c64, right: impl Fn(usize, f64) -> c64) {
    let (nominal, changed) = (plant(&reference(), krpm(20.0)), plant(machine, krpm(20.0)));
    for hz in [30.0, 700.0, 2500.0] {
        let w = TAU * hz;
        let g = nominal.at(w);
        let expected = Mat::from_fn(10, 10, |i, j| left(i, w) * g[(i, j)] * right(j, w));
        let error = block_error(&changed.at(w), &expected);
        assert!(error < 1e-12, "{hz} Hz: {error:.1e}");
    }
}

#[test]
fn a_signal_that_leaks_into_another_adds_its_row() {
    let machine = with(EffectKind::SensorCrosstalk, Location::Across { from: 0, to: 3 }, &[0.02]);
    let (nominal, changed) = (plant(&reference(), krpm(20.0)), plant(&machine, krpm(20.0)));
    for w in [30.0, 700.0, 2500.0].map(|hz| TAU * hz) {
        let g = nominal.at(w);
        let seen = |i: usize, j: usize| if i == 3 { g[(0, j)] * 0.02 } else { c64::new(0.0, 0.0) };
        let expected = Mat::from_fn(10, 10, |i, j| g[(i, j)] + seen(i, j));
        assert!(block_error(&changed.at(w), &expected) < 1e-12);
    }
}

#[test]
fn a_current_that_is_picked_up_adds_its_rate() {
    let machine = with(EffectKind::CurrentPickup, Location::Across { from: 1, to: 2 }, &[3e-11]);
    let (nominal, changed) = (plant(&reference(), krpm(20.0)), plant(&machine, krpm(20.0)));
    let delay_s = reference().spindle.electronics.delay_s;
    for w in [30.0, 700.0, 2500.0].map(|hz| TAU * hz) {
        let mut expected = nominal.at(w);
        let current = c64::from_polar(1.0, -w * delay_s) / c64::new(1.0, w / (TAU * 2000.0));
        expected[(2, 1)] += c64::new(0.0, 3e-11 * w) * current;
        assert!(block_error(&changed.at(w), &expected) < 1e-12);
    }
}

fn same(a: &Machine, b: &Machine, tolerance: f64) {
    for speed in [0.0, krpm(40.0)] {
        let (a, b) = (plant(a, speed), plant(b, speed));
        for hz in [30.0, 700.0, 2500.0] {
            let error = block_error(&a.at(TAU * hz), &b.at(TAU * hz));
            assert!(error < tolerance, "{hz} Hz: {error:.1e}");
        }
    }
}

const ONE: c64 = c64::new(1.0, 0.0);
const FRONT: Location = Location::Bearing(Bearings::Front);
const REAR: Location = Location::Bearing(Bearings::Rear);

fn column(at: std::ops::Range<usize>, f: impl Fn(f64) -> c64) -> impl Fn(usize, f64) -> c64 {
    move |j, w| if at.contains(&j) { f(w) } else { ONE }
}

#[test]
fn chain_effects_are_factors_on_columns_and_rows() {
    let none = |_, _| ONE;
    let delay = with(EffectKind::LoopDelay, Location::None, &[2.5e-5]);
    scales(&delay, none, column(0..4, |w| c64::from_polar(1.0, -w * 2.5e-5)));
    let lag = |f: f64, w: f64| c64::new(1.0, w / (TAU * f)).inv();
    let amplifier = with(EffectKind::AmplifierBandwidth, REAR, &[1100.0]);
    scales(&amplifier, none, column(2..4, |w| lag(1100.0, w) / lag(2000.0, w)));
    let second_order = with(EffectKind::AmplifierSecondOrder, FRONT, &[1800.0, 0.4]);
    let resonant = |w: f64| {
        let r = w / (TAU * 1800.0);
        c64::new(1.0 - r * r, 0.8 * r).inv()
    };
    scales(&second_order, none, column(0..2, |w| resonant(w) / lag(2000.0, w)));
    let one = with(EffectKind::AmplifierBandwidth, Location::Axis(3), &[1100.0]);
    scales(&one, none, column(3..4, |w| lag(1100.0, w) / lag(2000.0, w)));
    let one = with(EffectKind::LoopDelay, Location::Axis(0), &[7e-6]);
    scales(&one, none, column(0..1, |w| c64::from_polar(1.0, -w * 7e-6)));
    let eddy = with(EffectKind::EddyCurrents, FRONT, &[8000.0]);
    let half = |w: f64| {
        let root = (w / (TAU * 8000.0)).sqrt() * c64::from_polar(1.0, TAU / 8.0);
        (ONE + root).inv()
    };
    scales(&eddy, none, column(0..2, half));
    let sheets = with(EffectKind::LaminatedCore, FRONT, &[3000.0]);
    // tanh(a + ja) = (sinh 2a + j sin 2a)/(cosh 2a + cos 2a).
    let flux = |w: f64| {
        let a = (0.5 * w / (TAU * 3000.0)).sqrt();
        c64::new((2.0 * a).sinh(), (2.0 * a).sin()) / ((2.0 * a).cosh() + (2.0 * a).cos()) / c64::new(a, a)
    };
    scales(&sheets, none, column(0..2, flux));
    let ki = with(EffectKind::ForceConstant, FRONT, &[1.07]);
    scales(&ki, none, column(0..2, |_| c64::new(1.07, 0.0)));
    let gain = with(EffectKind::SensorGain, REAR, &[0.96]);
    scales(&gain, column(2..4, |_| c64::new(0.96, 0.0)), none);
    let one = with(EffectKind::ForceConstant, Location::Axis(1), &[1.1]);
    scales(&one, none, column(1..2, |_| c64::new(1.1, 0.0)));
    let one = with(EffectKind::SensorGain, Location::Axis(2), &[0.9]);
    scales(&one, column(2..3, |_| c64::new(0.9, 0.0)), none);
    let lowpass = with(EffectKind::SensorLowpass, FRONT, &[5000.0]);
    let second = |w: f64| {
        let r = w / (TAU * 5000.0);
        c64::new(1.0 - r * r, 2.0 * 0.707 * r).inv()
    };
    scales(&lowpass, column(0..2, second), none);
}

#[test]
fn cross_axis_effects_mix_the_axes_of_one_bearing() {
    let g = plant(&reference(), krpm(20.0)).at(TAU * 400.0);
    let mix = |i: usize, j: usize, m: [[f64; 2]; 2], first: usize| {
        let inside = |k: usize| (first..first + 2).contains(&k);
        match (inside(i), inside(j)) {
            (true, true) => m[i - first][j - first],
            _ => f64::from(u8::from(i == j)),
        }
    };
    let matrix = |m, first| Mat::from_fn(10, 10, |i, j| c64::new(mix(i, j, m, first), 0.0));
    let coupling = with(EffectKind::BearingCoupling, REAR, &[0.05]);
    let expected = &g * matrix([[1.0, 0.05], [0.05, 1.0]], 2);
    let found = plant(&coupling, krpm(20.0)).at(TAU * 400.0);
    assert!(block_error(&found, &expected) < 1e-12);
    // Where the axes differ besides, the factor is on the current of an axis, whichever force it goes to.
    let gain = Effect::new(EffectKind::ForceConstant, Location::Axis(3), vec![1.2]);
    let both = coupling.with_effect(gain.unwrap());
    let expected = &g * matrix([[1.0, 0.05 * 1.2], [0.05, 1.2]], 2);
    let found = plant(&both, krpm(20.0)).at(TAU * 400.0);
    assert!(block_error(&found, &expected) < 1e-12);
    let turned = with(EffectKind::AxisMisalignment, FRONT, &[3.0]);
    let (s, c) = 3f64.to_radians().sin_cos();
    let expected = matrix([[c, s], [-s, c]], 0) * &g;
    let found = plant(&turned, krpm(20.0)).at(TAU * 400.0);
    assert!(block_error(&found, &expected) < 1e-12);
}

#[test]
fn geometry_and_stiffness_effects_equal_a_changed_file() {
    let mut moved = reference();
    moved.spindle.planes.front_sensor_m += 0.005;
    same(&with(EffectKind::SensorOffset, FRONT, &[0.005]), &moved, 1e-9);
    let mut moved = reference();
    moved.spindle.planes.rear_actuator_m -= 0.002;
    same(&with(EffectKind::ActuatorOffset, REAR, &[-0.002]), &moved, 1e-9);
    let mut softer = reference();
    softer.spindle.front.ks_n_per_m *= 1.4;
    same(&with(EffectKind::NegativeStiffness, FRONT, &[1.4]), &softer, 1e-9);
    let mut weaker = reference();
    for section in &mut weaker.spindle.sections {
        if section.region.as_deref() == Some("e5") {
            section.modulus_scale *= 0.8;
        }
    }
    let region = Location::Region("e5".into());
    same(&with(EffectKind::RegionStiffness, region, &[0.8]), &weaker, 1e-9);
    // A pull at the actuator plane is more negative stiffness.
    let z = reference().spindle.planes.front_actuator_m;
    let pull = with(EffectKind::AddedStiffness, Location::Position(z), &[-6e5]);
    same(&pull, &softer, 1e-6);
}

#[test]
fn a_tilting_stiffness_acts_against_the_slope_that_a_mesh_three_times_as_fine_reads() {
    let own = |name: &str, tool: &str| {
        let root = env!("CARGO_MANIFEST_DIR");
        let path = format!("{root}/tests/data/spindles/{name}.yaml");
        load_machine(&path, tool).unwrap()
    };
    let machines = [
        (reference(), 0.23, 4e4),
        (reference(), 0.2312, -6e4),
        (own("s12-big-discs", "test-arbor"), 0.11, -5e4),
        (own("s09-four-modes", "endmill-16"), 0.3, 3e5),
    ];
    for (mut machine, z, k) in machines {
        machine.spindle.damping_ratio = vec![0.0];
        let effect = Effect::new(EffectKind::TiltingStiffness, Location::Position(z), vec![k]);
        let tilting = machine.with_effect(effect.unwrap());
        // The element of the place alone is cut, so that nothing else is finer than in the plant.
        let mut finer = machine.clone();
        let mut left = 0.0;
        let place = finer.spindle.sections.iter().position(|s| {
            left += s.length_m;
            z < left
        });
        let place = place.unwrap();
        let parts = cut(&finer.spindle.sections[place], 3);
        finer.spindle.sections.splice(place..=place, parts);
        let rotor = finer.rotor().unwrap();
        let matrices = PlanarModes::new(&rotor).unwrap().matrices;
        let n = rotor.dofs();
        let row = |z: f64| {
            let mut row = Mat::<f64>::zeros(n, 1);
            for (dof, a) in rotor.shape_at("test", z).unwrap() {
                row[(dof, 0)] += a;
            }
            row
        };
        let slope = (row(z + 1e-6) - row(z - 1e-6)) * 0.5e6;
        let planes = &machine.spindle.planes;
        let magnets = [
            (row(planes.front_actuator_m), machine.spindle.front.ks_n_per_m),
            (row(planes.rear_actuator_m), machine.spindle.rear.ks_n_per_m),
        ];
        let tool = row(machine.tool_plane_m());
        for hz in [30.0, 150.0, 310.0, 560.0] {
            let w = TAU * hz;
            let tool_compliance = |k: f64| {
                let mut z = &matrices.stiffness - &matrices.mass * (w * w);
                for (row, ks) in &magnets {
                    z -= row * row.transpose() * *ks;
                }
                z += &slope * slope.transpose() * k;
                (tool.transpose() * solve(&z, &tool).unwrap())[(0, 0)]
            };
            let (with, without) = (tool_compliance(k), tool_compliance(0.0));
            let expected = with - without;
            let [one, other] = [&tilting, &machine].map(|m| plant(m, 0.0).at(w)[(4, 4)]);
            let found = one - other;
            // The inertia of the nodes between, which counts near resonances, and the plant's modes above 24 kHz, which
            // are static.
            assert!(
                (found - c64::new(expected, 0.0)).norm() < 1e-2 * expected.abs() + 1e-6 * with.abs(),
                "{} {hz} Hz: {found} against {expected}",
                machine.spindle.name
            );
        }
    }
}

#[test]
fn the_gyroscopic_effect_replaces_a_missing_term() {
    let mut without = reference();
    without.spindle.gyroscopics = false;
    let full = Effect::new(EffectKind::Gyroscopic, Location::None, vec![1.0]).unwrap();
    same(&without.with_effect(full), &reference(), 1e-12);
    let at = |m: &Machine| plant(m, krpm(50.0)).at(TAU * 900.0);
    let cross = |h: Mat<c64>| h[(0, 1)].norm() / h[(0, 0)].norm();
    assert!(cross(at(&without)) == 0.0);
    assert!(cross(at(&reference())) > 1e-3);
}

/// Poles of the machine on its magnets nearest to a frequency, forward and backward: the two with Im λ > 0.
fn pair_near(machine: &Machine, speed: f64, hz: f64) -> Vec<c64> {
    let mut poles = plant(machine, speed).state_space(0).unwrap().poles().unwrap();
    poles.retain(|p| p.im > 0.0 && -p.re < 0.2 * p.norm());
    poles.sort_by(|a, b| {
        let distance = |p: &c64| (p.im / TAU - hz).abs();
        distance(a).total_cmp(&distance(b))
    });
    poles.truncate(2);
    poles.sort_by(|a, b| a.im.total_cmp(&b.im));
    poles
}

#[test]
fn internal_damping_feeds_forward_whirl_above_the_mode() {
    let beta = 2e-6;
    let machine = with(EffectKind::InternalDamping, Location::None, &[beta]);
    let (plain, rest) = (pair_near(&reference(), 0.0, 1165.0), pair_near(&machine, 0.0, 1165.0));
    let expected = plain[0].re - 0.5 * beta * plain[0].im.powi(2);
    assert!((rest[0].re / expected - 1.0).abs() < 0.02, "{} {expected}", rest[0].re);
    // Forward whirl: damping β ω(ω − Ω)/2, backward β ω(ω + Ω)/2, over the plain rotor at that speed.
    let speed = krpm(50.0);
    let (plain, found) = (pair_near(&reference(), speed, 1165.0), pair_near(&machine, speed, 1165.0));
    for (k, sign) in [(0, 1.0), (1, -1.0)] {
        let w = plain[k].im;
        let expected = plain[k].re - 0.5 * beta * w * (w + sign * speed);
        assert!((found[k].re / expected - 1.0).abs() < 0.03, "{} {expected}", found[k].re);
    }
}

#[test]
fn cross_coupling_drives_forward_and_calms_backward_whirl() {
    let (q, z) = (3e5, 0.1);
    let machine = with(EffectKind::CrossCoupling, Location::Position(z), &[q]);
    let rotor = reference().rotor().unwrap();
    let modes = PlanarModes::new(&rotor).unwrap();
    let phi = modes.amplitudes(&rotor.shape_at("seal", z).unwrap())[2];
    let speed = krpm(30.0);
    let (plain, found) = (pair_near(&reference(), speed, 1165.0), pair_near(&machine, speed, 1165.0));
    for (k, sign) in [(0, -1.0), (1, 1.0)] {
        let expected = sign * q * phi * phi / (2.0 * plain[k].im);
        let shift = found[k].re - plain[k].re;
        assert!((shift / expected - 1.0).abs() < 0.05, "{shift} {expected}");
    }
}

#[test]
fn modal_damping_touches_its_mode_only() {
    let machine = with(EffectKind::ModalDamping, Location::Mode(2), &[2.5]);
    for (hz, factor) in [(1165.0, 1.0), (2304.0, 2.5), (3425.0, 1.0)] {
        let (plain, found) = (pair_near(&reference(), 0.0, hz), pair_near(&machine, 0.0, hz));
        assert!((found[0].re / plain[0].re / factor - 1.0).abs() < 0.01, "{hz} Hz");
    }
}

#[test]
fn masses_lower_every_mode_by_their_share_of_its_energy() {
    let rotor = reference().rotor().unwrap();
    let modes = PlanarModes::new(&rotor).unwrap();
    let cases = [
        (with(EffectKind::ToolMass, Location::None, &[0.001]), rotor.from_m()),
        (with(EffectKind::AddedMass, Location::Position(0.3), &[0.001]), 0.3),
    ];
    for (machine, z) in cases {
        let phi = modes.amplitudes(&rotor.shape_at("mass", z).unwrap());
        let changed = machine.rotor().unwrap();
        let found = PlanarModes::new(&changed).unwrap();
        for (k, phi) in phi.iter().enumerate().take(6).skip(2) {
            // First order: Δω/ω = −m φ²/2.
            let shift = found.omega_rad_s[k] / modes.omega_rad_s[k] - 1.0;
            let expected = -0.5 * 0.001 * phi * phi;
            assert!((shift - expected).abs() < 0.03 * expected.abs() + 1e-9, "mode {k}");
            assert!(shift <= 0.0);
        }
        let more = changed.mass_properties().mass_kg - rotor.mass_properties().mass_kg;
        assert!((more - 0.001).abs() < 1e-12);
    }
}

#[test]
fn a_stiff_joint_is_no_joint_and_a_soft_one_lowers_the_modes() {
    let stiff = with(EffectKind::ToolJoint, Location::None, &[1e14, 1e11, 0.0]);
    same(&stiff, &reference(), 1e-4);
    let soft = with(EffectKind::ToolJoint, Location::None, &[2.5e8, 1.2e5, 1.0]);
    let hz = |m: &Machine| PlanarModes::new(&m.rotor().unwrap()).unwrap().flexible_hz();
    let (a, b) = (hz(&reference()), hz(&soft));
    for k in 0..6 {
        assert!(b[k] < a[k], "mode {k}");
    }
    // Rotational dashpot across the joint: ζ rises by c (Δψ)²/(2ω).
    let damped = with(EffectKind::ToolJoint, Location::None, &[2.5e8, 1.2e5, 0.5]);
    let undamped = with(EffectKind::ToolJoint, Location::None, &[2.5e8, 1.2e5, 0.0]);
    let rotor = undamped.rotor().unwrap();
    let modes = PlanarModes::new(&rotor).unwrap();
    let ([left, right], _) = rotor.joints()[0];
    let slip = modes.amplitudes(&[(2 * left + 1, 1.0), (2 * right + 1, -1.0)]);
    let (plain, found) = (pair_near(&undamped, 0.0, b[0]), pair_near(&damped, 0.0, b[0]));
    let expected = -0.5 * 0.5 * slip[2].powi(2);
    let shift = found[0].re - plain[0].re;
    assert!((shift / expected - 1.0).abs() < 0.05, "{shift} {expected}");
}

#[test]
fn a_housing_mode_adds_the_stator_compliance_to_every_sensor() {
    let (mass, hz, zeta) = (120.0, 640.0, 0.03);
    let mut free = reference();
    free.spindle.front.ks_n_per_m = 0.0;
    free.spindle.rear.ks_n_per_m = 0.0;
    let housing = Effect::new(EffectKind::HousingMode, Location::None, vec![mass, hz, zeta]);
    let housed = free.with_effect(housing.unwrap());
    let (a, b) = (plant(&free, 0.0), plant(&housed, 0.0));
    let e = &free.spindle.electronics;
    let ki = [free.spindle.front.ki_n_per_a, free.spindle.rear.ki_n_per_a];
    for f in [100.0, 600.0, 640.0, 2000.0] {
        let (w, wh) = (TAU * f, TAU * hz);
        let lag = |b: f64| c64::new(1.0, w / (TAU * b)).inv();
        let chain = c64::from_polar(1.0, -w * e.delay_s) * lag(e.amplifier_bandwidth_hz) * lag(e.sensor_bandwidth_hz);
        // Without negative stiffness rotor and stator meet only through the control force.
        let stator = (mass * c64::new(wh * wh - w * w, 2.0 * zeta * wh * w)).inv();
        let (g, h) = (a.at(w), b.at(w));
        let expected = Mat::from_fn(10, 10, |i, j| {
            let reached = i < 4 && j < 4 && i % 2 == j % 2;
            let extra = if reached { chain * ki[j / 2] * stator } else { c64::new(0.0, 0.0) };
            g[(i, j)] + extra
        });
        assert!(block_error(&h, &expected) < 1e-9, "{f} Hz");
    }
    // On its magnets too: one more lightly damped pair per plane near the foundation's frequency.
    let housed = with(EffectKind::HousingMode, Location::None, &[mass, hz, zeta]);
    let near = pair_near(&housed, 0.0, hz);
    assert!((near[0].im / TAU / hz - 1.0).abs() < 0.02);
}

#[test]
fn every_effect_changes_the_plant() {
    for effect in catalogue() {
        let changed = plant(&reference().with_effect(effect.clone()), krpm(40.0));
        let nominal = plant(&reference(), krpm(40.0));
        let gaps = [150.0, 560.0, 1165.0, 2300.0].map(|hz| block_error(&changed.at(TAU * hz), &nominal.at(TAU * hz)));
        let largest = gaps.into_iter().fold(0.0, f64::max);
        assert!(largest > 1e-3, "{}: {largest:.1e}", effect.kind.name());
    }
}
