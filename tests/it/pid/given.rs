//! A PID with given numbers: the sampled controller against the formula that its file states.

use muspin::controller::ControlLaw;
use muspin::input::load_machine;
use muspin::input::pid::read_pid;
use muspin::linalg::{Mat, c64};
use muspin::lti::Response;
use muspin::spindle::Machine;
use std::f64::consts::TAU;

const CHANNEL: &str = "integral_a_per_m_s: 3.0e5, damping_a_s_per_m: 40, derivative_rolloff_hz: 4000";

fn machine() -> Machine {
    load_machine("reference", "paper-tool").unwrap()
}

/// −K(jω) of a file.
fn response(machine: &Machine, text: &str, omega: f64) -> Mat<c64> {
    let pid = read_pid("pid.yaml", text, machine.spindle.electronics.sample_rate_hz).unwrap();
    let ControlLaw::Discrete(law) = pid.sample(machine).unwrap().law else { panic!("not sampled") };
    let k = law.at(omega);
    Mat::from_fn(4, 4, |i, j| -k[(i, j)])
}

/// The place in the s plane that Tustin's rule maps to ω, rad/s.
fn warp(machine: &Machine, omega: f64) -> c64 {
    let period_s = machine.spindle.electronics.sample_period_s();
    c64::new(0.0, 2.0 / period_s * (0.5 * omega * period_s).tan())
}

fn first_order(s: c64, hz: f64) -> c64 {
    s / (TAU * hz) + 1.0
}

#[test]
fn channels_of_bearings_follow_the_stated_formula() {
    let machine = machine();
    let front = format!("{{gain_a_per_m: 5.0e4, {CHANNEL}, lead: {{zero_hz: 300, pole_hz: 2500}}, rolloff_hz: 3000}}");
    let rear = format!("{{stiffness_n_per_m: 2.0e6, {CHANNEL}}}");
    let text = format!("name: own\nfront: {front}\nrear: {rear}\n");
    let bearing = &machine.spindle.rear;
    let rear_gain = (2.0e6 + bearing.ks_n_per_m) / bearing.ki_n_per_a;
    for hz in [0.3, 40.0, 700.0, 3500.0] {
        let k = response(&machine, &text, TAU * hz);
        let s = warp(&machine, TAU * hz);
        let pid = |gain: f64| c64::new(gain, 0.0) + 3.0e5 / s + 40.0 * s / first_order(s, 4000.0);
        let p = s / (TAU * 3000.0);
        let front = pid(5.0e4) * first_order(s, 300.0) / first_order(s, 2500.0) / (p * p + p * 1.4 + 1.0);
        for (channel, stated) in [front, front, pid(rear_gain), pid(rear_gain)].into_iter().enumerate() {
            let found = k[(channel, channel)];
            assert!((found - stated).norm() < 1e-9 * stated.norm(), "{hz} Hz, {channel}: {found} for {stated}");
        }
        assert_eq!(k[(0, 1)].norm() + k[(0, 2)].norm() + k[(2, 0)].norm(), 0.0);
    }
}

#[test]
fn a_notch_has_its_frequency_depth_and_width_in_the_sampled_controller() {
    let machine = machine();
    let rate_hz = machine.spindle.electronics.sample_rate_hz;
    // The last one is near Nyquist, where Tustin's rule alone would move it by half.
    for (hz, depth, width) in [(0.02 * rate_hz, 1.0, 0.2), (0.2 * rate_hz, 0.9, 0.1), (0.4 * rate_hz, 0.5, 0.05)] {
        let channel = |notches: &str| format!("{{gain_a_per_m: 5.0e4, {CHANNEL}, notches: [{notches}]}}");
        let rear = channel("");
        let with = |notches: &str| format!("name: own\nfront: {}\nrear: {rear}\n", channel(notches));
        let text = with(&format!("{{frequency_hz: {hz}, depth: {depth}, width: {width}}}"));
        let plain = with("");
        let share = |at_hz: f64| {
            let [own, bare] = [&text, &plain].map(|file| response(&machine, file, TAU * at_hz)[(0, 0)].norm());
            own / bare
        };
        assert!((share(hz) - (1.0 - depth)).abs() < 1e-9, "{hz} Hz: {}", share(hz));
        // Where the squared gain is halfway between one and that of the centre: the edges of the band.
        let halfway = (0.5 * (1.0 + (1.0f64 - depth).powi(2))).sqrt();
        let edge = |from: f64, to: f64| {
            let (mut low, mut high) = (from, to);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                *(if share(middle) < halfway { &mut low } else { &mut high }) = middle;
            }
            low
        };
        let found = (edge(hz, hz * 1.2) - edge(hz, hz * 0.8)) / hz;
        assert!((found / width - 1.0).abs() < 0.02, "{hz} Hz: width {found} for {width}");
    }
}

#[test]
fn translation_makes_no_moment_and_tilt_no_force() {
    let machine = machine();
    let mass = machine.rotor().unwrap().mass_properties();
    let centre = mass.centre_of_gravity_m;
    let planes = &machine.spindle.planes;
    let channel = |gain: f64| format!("{{gain_a_per_m: {gain}, damping_a_s_per_m: 0, derivative_rolloff_hz: 1000}}");
    let (translation, tilt) = (3.0e4, 2.0e4);
    let text = format!(
        "name: own\ncoordinates: tilt_translation\ntranslation: {}\ntilt: {}\n",
        channel(translation),
        channel(tilt)
    );
    let k = response(&machine, &text, TAU * 10.0);
    let [ki_front, ki_rear] = [machine.spindle.front.ki_n_per_a, machine.spindle.rear.ki_n_per_a];
    let mean = 0.5 * (ki_front + ki_rear);
    let forces = |front_m: f64, rear_m: f64| {
        let current = |row: usize| (k[(row, 0)] * front_m + k[(row, 2)] * rear_m).re;
        [ki_front * current(0), ki_rear * current(2)]
    };
    let moment =
        |[front, rear]: [f64; 2]| front * (planes.front_actuator_m - centre) + rear * (planes.rear_actuator_m - centre);
    let span = planes.rear_actuator_m - planes.front_actuator_m;
    let shifted = forces(1e-6, 1e-6);
    let force = shifted[0] + shifted[1];
    assert!(moment(shifted).abs() < 1e-9 * force.abs() * span, "{shifted:?}");
    assert!((force / (2.0 * mean * translation * 1e-6) - 1.0).abs() < 1e-9, "{force}");
    // Turned by a microradian round the centre of gravity; the tilt channel sees half the distance of the magnets times
    // that, and acts with a moment over the whole.
    let turned = forces(1e-6 * (centre - planes.front_sensor_m), 1e-6 * (centre - planes.rear_sensor_m));
    let stated = mean * tilt * 0.5e-6 * span * span;
    assert!((turned[0] + turned[1]).abs() < 1e-9 * stated / span, "{turned:?}");
    assert!((-moment(turned) / stated - 1.0).abs() < 1e-9, "{} for {stated}", moment(turned));
}

#[test]
fn what_a_file_of_numbers_breaks_is_said_with_line_and_key() {
    let refused = |channel: &str| {
        let text = format!("name: own\nfront: {channel}\nrear: {{gain_a_per_m: 5.0e4, {CHANNEL}}}\n");
        read_pid("pid.yaml", &text, 20_000.0).unwrap_err().to_string()
    };
    let cases = [
        (format!("{{{CHANNEL}}}"), "one of gain_a_per_m and stiffness_n_per_m"),
        (format!("{{gain_a_per_m: 5.0e4, stiffness_n_per_m: 1.0e6, {CHANNEL}}}"), "and only one"),
        (format!("{{gain_a_per_m: 5.0e4, {CHANNEL}, rolloff_hz: 10000}}"), "rolloff_hz: 10000 Hz is not below half"),
        (
            format!("{{gain_a_per_m: 5.0e4, {CHANNEL}, notches: [{{frequency_hz: 12000, depth: 0.9, width: 0.1}}]}}"),
            "notches[0].frequency_hz: 12000 Hz is not below half",
        ),
        (
            format!("{{gain_a_per_m: 5.0e4, {CHANNEL}, lead: {{zero_hz: 200, pole_hz: 10001}}}}"),
            "lead.pole_hz: 10001 Hz is not below half",
        ),
        (format!("{{gain_a_per_m: 5.0e4, {CHANNEL}, notch: []}}"), "notches"),
    ];
    for (channel, expected) in cases {
        let said = refused(&channel);
        assert!(said.contains(expected) && said.contains("pid.yaml"), "{channel}\n{said}");
        assert!(!expected.contains("half") || said.contains("pid.yaml:2"), "{said}");
    }
    let mixed = format!("name: own\nfront: {{gain_a_per_m: 1.0, {CHANNEL}}}\ntilt: {{gain_a_per_m: 1.0, {CHANNEL}}}\n");
    let said = read_pid("pid.yaml", &mixed, 20_000.0).unwrap_err().to_string();
    assert!(said.contains("tilt: is no channel") && said.contains("pid.yaml:3"), "{said}");
}
