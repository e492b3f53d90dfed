//! What files leave to the machine: levels of a specification, contact with the backup bearings.

use muspin::augment::weights::Weights;
use muspin::input::{load_machine, load_spindle, load_weights, read_spindle, read_weights, shipped, spindle_yaml};
use muspin::spindle::Machine;

fn reference() -> Machine {
    load_machine("reference", "paper-tool").unwrap()
}

fn near(value: f64, expected: f64, share: f64) {
    assert!((value / expected - 1.0).abs() < share, "{value} is not {expected}");
}

#[test]
fn on_the_machine_of_the_paper_the_levels_are_those_of_the_benchmark() {
    let machine = reference();
    let open = load_weights("machine").unwrap();
    assert_eq!(open.open.len(), 9);
    let filled = open.on(&machine).unwrap();
    assert!(filled.open.is_empty());
    let table = load_weights("benchmark").unwrap();
    near(filled.current_limit_a, table.current_limit_a, 1e-9);
    near(filled.current_rolloff_hz, table.current_rolloff_hz, 1e-9);
    near(filled.sensor_noise_m, table.sensor_noise_m, 1e-9);
    // √(Σks/m)/2π of the rotor without its tool is 85 Hz: halves and 1.2 of it are within 7 % of 40 and 100 Hz.
    for place in 0..3 {
        near(filled.load_crossover_hz[place], 40.0, 0.07);
        near(filled.displacement_crossover_hz[place], [40.0, 100.0, 100.0][place], 0.07);
    }
    // A specification that leaves nothing open is the same on every machine.
    assert_eq!(table.on(&machine).unwrap(), table);
}

#[test]
fn the_levels_follow_the_machine_and_stated_ones_stay() {
    let mut machine = reference();
    let s = &mut machine.spindle;
    for bearing in [&mut s.front, &mut s.rear] {
        bearing.bias_current_a *= 0.5;
        bearing.ks_n_per_m *= 4.0;
    }
    s.electronics.sample_rate_hz *= 2.0;
    s.electronics.sensor_noise_m *= 3.0;
    let before = load_weights("machine").unwrap().on(&reference()).unwrap();
    let after = load_weights("machine").unwrap().on(&machine).unwrap();
    near(after.current_limit_a, 0.5 * before.current_limit_a, 1e-9);
    near(after.sensor_noise_m, 3.0 * before.sensor_noise_m, 1e-9);
    near(after.current_rolloff_hz, 2.0 * before.current_rolloff_hz, 1e-9);
    near(after.displacement_crossover_hz[1], 2.0 * before.displacement_crossover_hz[1], 1e-9);
    let text = shipped::WEIGHTS.iter().find(|w| w.name == "machine").unwrap().text;
    let stated = read_weights("w.yaml", &format!("{text}\ncurrent_limit_a: 1.25\n")).unwrap();
    assert_eq!(stated.on(&machine).unwrap().current_limit_a, 1.25);
    // A sensor without noise: a thousandth of the clearance.
    machine.spindle.electronics.sensor_noise_m = 0.0;
    let silent: Weights = stated.on(&machine).unwrap();
    near(silent.sensor_noise_m, 1e-3 * machine.spindle.backup_clearance_m, 1e-9);
    let error = read_weights("w.yaml", &text.replace("defaults: machine", "defaults: rotor"));
    assert!(error.unwrap_err().to_string().contains("defaults"));
}

#[test]
fn contact_follows_the_rotor_unless_the_file_says_it() {
    let spindle = load_spindle("reference").unwrap();
    let contact = spindle.backup_contact().unwrap();
    assert_eq!(contact.stiffness_n_per_m, 3e7);
    assert_eq!(contact.friction, 0.1);
    // 15 % of critical: c = 2ζ√(k m/2), with the mass of the rotor from its elements and discs.
    let mass: f64 = spindle
        .sections
        .iter()
        .map(|s| {
            let [outer, inner] = [s.mass_outer_diameter_m[0], s.mass_inner_diameter_m[0]];
            let area = std::f64::consts::FRAC_PI_4 * (outer * outer - inner * inner);
            area * s.length_m * s.material.density_kg_m3
        })
        .chain(spindle.discs.iter().map(|d| d.mass_kg))
        .sum();
    near(contact.damping_n_s_per_m, 0.3 * (3e7 * 0.5 * mass).sqrt(), 1e-9);
    // The reference rotor is a cylinder at each actuator.
    let radius_at = |position: f64| {
        let mut from = 0.0;
        for s in &spindle.sections {
            from += s.length_m;
            if position < from {
                return 0.5 * s.outer_diameter_m[0];
            }
        }
        f64::NAN
    };
    let planes = spindle.planes;
    let radius = 0.5 * (radius_at(planes.front_actuator_m) + radius_at(planes.rear_actuator_m));
    near(contact.radius_m, radius, 1e-9);

    let text = shipped::SPINDLES[0].text;
    let given = format!(
        "{text}\nbackup_bearings: {{contact_stiffness_n_per_m: 5.0e7, friction: 0.25, contact_radius_m: 0.013}}\n"
    );
    let read = read_spindle("s.yaml", &given).unwrap();
    let contact = read.backup_contact().unwrap();
    assert_eq!((contact.stiffness_n_per_m, contact.friction, contact.radius_m), (5e7, 0.25, 0.013));
    near(contact.damping_n_s_per_m, 0.3 * (5e7 * 0.5 * mass).sqrt(), 1e-9);
    // What is written is what is read.
    let again = read_spindle("s.yaml", &spindle_yaml(&read)).unwrap();
    assert_eq!(again.backup_bearings, read.backup_bearings);
    assert!(!spindle_yaml(&spindle).contains("backup_bearings"));
    let bad = given.replace("contact_radius_m: 0.013", "contact_radius_m: -0.013");
    let said = read_spindle("s.yaml", &bad).unwrap_err().to_string();
    assert!(said.contains("backup_bearings.contact_radius_m"), "{said}");
}

/// The band in which stiffness counts is that of the benchmark unless a file gives it, and is written where it is another.
#[test]
fn the_stiffness_band_is_read_and_written() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    assert_eq!(machine.spindle.stiffness_band_hz, (1.0, 4000.0));
    let text = spindle_yaml(&machine.spindle);
    assert!(!text.contains("stiffness_band"));
    let given = format!("{text}stiffness_band: {{to_hz: 900}}\n");
    let read = read_spindle("s.yaml", &given).unwrap();
    assert_eq!(read.stiffness_band_hz, (1.0, 900.0));
    let again = read_spindle("s.yaml", &spindle_yaml(&read)).unwrap();
    assert_eq!(again, read);
}
