//! The table of effects against itself, the formats page and the sentences that are made from it.

use muspin::diagnose::NamedEffect;
use muspin::report::diagnosis_words::statement;
use muspin::spindle::effects::LocationKind;
use muspin::spindle::effects::table::TABLE;
use muspin::spindle::{Bearings, Effect, EffectKind, Location};

fn anywhere(kind: EffectKind) -> Location {
    match kind.location() {
        LocationKind::None => Location::None,
        LocationKind::Bearing => Location::Bearing(Bearings::Both),
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
        let start = format!("| {} |", entry.name);
        let row = page.lines().find(|line| line.starts_with(&start));
        let row = row.unwrap_or_else(|| panic!("no row for {}", entry.name));
        let place = entry.location.key().unwrap_or("–");
        assert!(row.contains(place), "{row}: no {place}");
        for parameter in entry.parameters {
            assert!(row.contains(parameter.name), "{row}: no {}", parameter.name);
        }
    }
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
            let text = statement(&NamedEffect {
                effect,
                standard_deviations: vec![],
                intervals: vec![],
                position_sd_m: None,
            });
            assert!(!text.contains('{') && !text.contains('}'), "{text}");
            assert!(text.chars().any(|c| c.is_ascii_digit()), "{text}");
        }
    }
}

#[test]
fn coordinates_and_slopes_agree_with_differences() {
    for entry in TABLE {
        for parameter in entry.parameters {
            // A nominal value of the size that bandwidths have; the others ignore it.
            let (t, step, nominal) = (0.7, 1e-6, 2000.0);
            let value = |t: f64| parameter.coordinate.value(t, nominal);
            let difference = (value(t + step) - value(t - step)) / (2.0 * step);
            let slope = parameter.coordinate.slope(t, nominal);
            // Central differences of smooth functions of order one: 1e-9 relative.
            assert!(
                (slope - difference).abs() <= 1e-8 * slope.abs(),
                "{}: {slope} against {difference}",
                entry.name
            );
            let (lo, hi) = (parameter.bounds)(nominal);
            assert!(lo < hi, "{}", entry.name);
        }
    }
}
