//! The six example folders: the hidden effect is named, nothing is named where nothing is missing, and what is in no
//! catalogue stays unexplained.

use crate::diagnose::diagnose_folder::read;
use muspin::diagnose::locate::recovered_law::LawShape;
use muspin::diagnose::{Diagnosis, Verdict, diagnose};
use muspin::input::with_correction;
use muspin::lti::Response;
use muspin::report::diagnosis::stage;
use muspin::report::results::ResultsFolder;
use muspin::spindle::{Bearings, EffectKind, Location, Machine, ModelDetail, Plant};
use std::f64::consts::TAU;

fn run(name: &str) -> Diagnosis {
    let folder = read(name);
    let measurement = folder.measurement();
    let started = std::time::Instant::now();
    let d = diagnose(&folder.machine, &measurement, &|_| {}).expect("diagnosis");
    println!(
        "{name} {:.1} s: {:?} misfit {:.2?} gap {:.2} -> {:.3}, held out {:.2} -> {:.3}",
        started.elapsed().as_secs_f64(),
        d.verdict,
        d.misfit,
        d.gap_before,
        d.gap_after,
        d.gap_before_held_out,
        d.gap_after_held_out
    );
    for e in &d.effects {
        println!("   {:?} {:?} {:?} sd {:?}", e.effect.kind, e.effect.location, e.effect.values, e.standard_deviations);
    }
    for (effect, score) in d.ranking.iter().take(5) {
        println!("      {score:.1} {:?} {:?} {:?}", effect.kind, effect.location, effect.values);
    }
    for p in d.localisation.ports.iter().take(3) {
        println!("      port {} {:.2} -> {:.2} {}", p.port, p.chi2_before, p.chi2_after, p.shape());
    }
    println!("      next {:?}", d.next_measurement);
    d
}

/// The best explanation has the kind, and, where given, the place and the value within `tolerance`.
fn names(d: &Diagnosis, kind: EffectKind, place: Option<Location>, values: &[f64], tolerance: f64) {
    assert!(matches!(d.verdict, Verdict::Named | Verdict::Tie), "{:?}", d.verdict);
    assert_eq!(d.effects.len(), 1, "{:?}", d.effects);
    let found = &d.effects[0];
    assert_eq!(found.effect.kind, kind);
    if let Some(place) = place {
        assert_eq!(found.effect.location, place);
    }
    for (i, value) in values.iter().enumerate() {
        let error = (found.effect.values[i] / value - 1.0).abs();
        assert!(error < tolerance, "{:?} against {values:?}", found.effect.values);
    }
    assert!(d.gap_after < 0.3 * d.gap_before, "{} -> {}", d.gap_before, d.gap_after);
    assert!(d.gap_after_held_out < 0.3 * d.gap_before_held_out);
}

#[test]
fn loop_delay_is_named() {
    names(&run("c01"), EffectKind::LoopDelay, None, &[30e-6], 0.05);
}

#[test]
fn tool_joint_is_named() {
    names(&run("c02"), EffectKind::ToolJoint, None, &[2.5e8, 1.2e5], 0.2);
}

#[test]
fn nothing_is_named_where_nothing_is_missing() {
    let d = run("c03");
    assert_eq!(d.verdict, Verdict::Adequate);
    assert!(d.effects.is_empty());
    assert!(d.gap_after < 1.0);
}

#[test]
fn housing_mode_is_named() {
    names(&run("c04"), EffectKind::HousingMode, None, &[120.0, 640.0, 0.03], 0.1);
}

#[test]
fn turned_sensor_axes_are_named() {
    let place = Location::Bearing(Bearings::Front);
    names(&run("c06"), EffectKind::AxisMisalignment, Some(place), &[3.0], 0.1);
}

/// Tests of several seconds each: `cargo test --release --test it long:: -- --ignored`.
mod long {
    use super::*;

    #[test]
    #[ignore = "long: see the command of the module"]
    fn a_notch_in_the_rear_sensor_stays_unexplained() {
        let d = run("c05");
        assert_eq!(d.verdict, Verdict::Unexplained);
        assert!(d.effects.is_empty());
        let best = &d.localisation.ports[0];
        assert_eq!(best.port, "rear sensors");
        // A second-order notch at 1400 Hz, found without a hypothesis.
        assert!(
            matches!(best.laws[0].shape, LawShape::Resonance(hz, zeta, _) if (hz - 1400.0).abs() < 5.0 && (zeta - 0.3).abs() < 0.01),
            "{:?}",
            best.laws[0].shape
        );
        // The law recovered from the sweeps predicts the hammer test.
        let ((used_before, used), (held_before, held)) = (d.gaps(false), d.gaps(true));
        assert!(used < 1.0 && used < 0.05 * used_before, "{used_before} -> {used}");
        assert!(held < 1.0 && held < 0.05 * held_before, "{held_before} -> {held}");
        let mut folder = ResultsFolder::new();
        stage(&mut folder, &d).expect("report");
        let names: Vec<&str> = folder.files().map(|(path, _)| path).collect();
        for stem in [
            "localisation",
            "localisation_places",
            "impedance",
            "ranking",
            "residual",
            "hammer-x",
            "channel-rear_x-from-rear_x",
        ] {
            for end in ["svg", "csv"] {
                let path = format!("plots/{stem}.{end}");
                assert!(names.contains(&path.as_str()), "{path} of {names:?}");
            }
        }
        for file in ["gap.csv", "correction.csv", "corrected-frf.csv"] {
            assert!(names.contains(&file), "{file}");
        }
        // The table as a model takes it: the notch, beside what the sensors' gains may be off.
        let table = folder.files().find(|(path, _)| *path == "correction.csv").expect("table").1.to_vec();
        let place = tempfile::tempdir().expect("folder");
        let file = place.path().join("correction.csv");
        std::fs::write(&file, table).expect("file");
        let machine = read("c05").machine;
        let corrected = with_correction(machine.clone(), &file.display().to_string()).expect("a stable law");
        let plant = |machine: &Machine| Plant::new(machine, 0.0, ModelDetail::Full).expect("plant");
        let (without, with) = (plant(&machine), plant(&corrected));
        let ratio = |hz: f64| (with.at(TAU * hz)[(2, 2)] / without.at(TAU * hz)[(2, 2)]).norm();
        let (deep, wide) = (ratio(1400.0), [ratio(100.0), ratio(3900.0)]);
        assert!(deep < 0.2 && wide.iter().all(|r| (r - 1.0).abs() < 0.1), "{deep} {wide:?}");
    }
}
