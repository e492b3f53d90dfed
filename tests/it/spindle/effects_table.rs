//! The table of effects against itself, the formats page and the sentences that are made from it.

use crate::spindle::alike::power;
use muspin::diagnose::NamedEffect;
use muspin::report::diagnosis_words::statement;
use muspin::spindle::effects::LocationKind;
use muspin::spindle::effects::coordinate::Coordinate;
use muspin::spindle::effects::scale::MachineScale;
use muspin::spindle::effects::table::TABLE;
use muspin::spindle::{Bearings, Effect, EffectKind, Location};

/// A spindle of 8 kg.
const SPINDLE: MachineScale = MachineScale {
    sample_period_s: 5e-5,
    spare_delay_s: 5e-5,
    amplifier_bandwidth_hz: 2000.0,
    gyroscopic_factor: 1.0,
    rotor_mass_kg: 8.0,
    bending_time_s: 1.44e-4,
    bearing_span_m: 0.194,
    ki_n_per_a: 150.0,
    negative_stiffness_n_per_m: 2.14e6,
    force_per_gap_n_per_m: 4e6,
    nose_n_per_m: 9.9e9,
    nose_n_m_per_rad: 2.3e7,
};

/// The machine `s` times as long in every length and in time, of the same materials and stresses.
fn alike(s: f64) -> MachineScale {
    MachineScale {
        sample_period_s: s * SPINDLE.sample_period_s,
        spare_delay_s: s * SPINDLE.spare_delay_s,
        amplifier_bandwidth_hz: SPINDLE.amplifier_bandwidth_hz / s,
        gyroscopic_factor: SPINDLE.gyroscopic_factor,
        rotor_mass_kg: s.powi(3) * SPINDLE.rotor_mass_kg,
        bending_time_s: s * SPINDLE.bending_time_s,
        bearing_span_m: s * SPINDLE.bearing_span_m,
        ki_n_per_a: s.powi(2) * SPINDLE.ki_n_per_a,
        negative_stiffness_n_per_m: s * SPINDLE.negative_stiffness_n_per_m,
        force_per_gap_n_per_m: s * SPINDLE.force_per_gap_n_per_m,
        nose_n_per_m: s * SPINDLE.nose_n_per_m,
        nose_n_m_per_rad: s.powi(3) * SPINDLE.nose_n_m_per_rad,
    }
}

#[test]
fn machines_that_are_alike_have_the_same_coordinates_bounds_and_least_sizes() {
    for s in [0.3, 4.0] {
        let other = alike(s);
        for entry in TABLE {
            for p in entry.parameters {
                let (of_own, of_other) = ((p.bounds)(&SPINDLE), (p.bounds)(&other));
                // Coordinates of frequencies and ratios are logarithms: there the unit is in the bounds.
                let own_unit = match p.coordinate {
                    Coordinate::Logarithm => (f64::from(power(p.name)) * s.ln(), 1.0),
                    _ => (0.0, s.powi(power(p.name))),
                };
                for (a, b) in [(of_own.0, of_other.0), (of_own.1, of_other.1)] {
                    let away = (b - own_unit.0 - a).abs();
                    assert!(away <= 1e-12 * a.abs().max(1.0), "{}: {a} {b}", entry.name);
                }
                let t = 0.37;
                let ratio = p.coordinate.value(t, &other) / p.coordinate.value(t, &SPINDLE);
                let away = (ratio / own_unit.1 - 1.0).abs();
                assert!(away < 1e-12, "{}: {ratio}", entry.name);
            }
            // Sizes on both sides of the least one.
            for k in -40..40 {
                let theta = [1.17f64.powi(k), 0.0, 0.0];
                let matters = |machine| (entry.matters)(theta[0], &theta, machine);
                assert_eq!(matters(&SPINDLE), matters(&other), "{}", entry.name);
            }
        }
    }
}

fn anywhere(kind: EffectKind) -> Location {
    match kind.location() {
        LocationKind::None => Location::None,
        LocationKind::Bearing => Location::Bearing(Bearings::Both),
        LocationKind::Across => Location::Across { from: 0, to: 2 },
        LocationKind::Position => Location::Position(0.1),
        LocationKind::Mode => Location::Mode(1),
        LocationKind::Region => Location::Region("nose".into()),
    }
}

#[test]
fn the_table_is_in_the_order_of_the_kinds_and_has_every_name_once() {
    for (k, entry) in TABLE.iter().enumerate() {
        assert_eq!(entry.kind as usize, k);
        assert_eq!(entry.kind.entry().name, entry.name);
        assert_eq!(EffectKind::from_name(entry.name), Some(entry.kind));
        assert!(!entry.parameters.is_empty() && !entry.advice.is_empty());
    }
    let mut names: Vec<&str> = TABLE.iter().map(|e| e.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), TABLE.len());
}

#[test]
fn the_formats_page_has_a_row_for_every_effect_with_its_place_and_its_numbers() {
    let page = include_str!("../../../src/guide/formats.md");
    for entry in TABLE {
        let starts = [" |", ", "].map(|end| format!("| {}{end}", entry.name));
        let row = page.lines().find(|line| starts.iter().any(|start| line.starts_with(start)));
        let row = row.unwrap_or_else(|| panic!("no row for {}", entry.name));
        for key in entry.location.keys() {
            assert!(row.contains(key), "{row}: no {key}");
        }
        for parameter in entry.parameters {
            assert!(row.contains(parameter.name), "{row}: no {}", parameter.name);
        }
    }
}

#[test]
fn a_delay_of_one_axis_is_no_delay_of_the_loop() {
    let said = |location| {
        let effect = Effect::new(EffectKind::LoopDelay, location, vec![2e-5]).unwrap();
        statement(&NamedEffect::from(effect))
    };
    assert!(said(Location::None).starts_with("the loop is 20 µs slower"), "{}", said(Location::None));
    assert!(said(Location::Axis(3)).starts_with("rear_y is 20 µs slower"), "{}", said(Location::Axis(3)));
}

#[test]
fn a_sentence_shows_every_number_and_leaves_no_placeholder() {
    for kind in EffectKind::all() {
        for sign in [1.0, -1.0] {
            let values = kind.parameters().iter().map(|p| {
                let sign = if p.positive { 1.0 } else { sign };
                sign * 0.5
            });
            let effect = Effect::new(kind, anywhere(kind), values.collect()).unwrap();
            let text =
                statement(&NamedEffect { effect, standard_deviations: vec![], intervals: vec![], position_sd_m: None });
            assert!(!text.contains('{') && !text.contains('}'), "{text}");
            assert!(text.chars().any(|c| c.is_ascii_digit()), "{text}");
        }
    }
}

#[test]
fn coordinates_and_slopes_agree_with_differences() {
    for entry in TABLE {
        for parameter in entry.parameters {
            let (t, step) = (0.7, 1e-6);
            let value = |t: f64| parameter.coordinate.value(t, &SPINDLE);
            let difference = (value(t + step) - value(t - step)) / (2.0 * step);
            let slope = parameter.coordinate.slope(t, &SPINDLE);
            // Central differences of smooth functions of order one: 1e-9 relative.
            assert!((slope - difference).abs() <= 1e-8 * slope.abs(), "{}: {slope} against {difference}", entry.name);
            let (lo, hi) = (parameter.bounds)(&SPINDLE);
            assert!(lo < hi, "{}", entry.name);
        }
    }
}
