//! What an update says where moduli are not at fault: the sentence follows from χ², and names what is.

use muspin::rotor::{Damping, Disc, Material, PlanarModes, Rotor, Section, Support};
use muspin::update::{FrfTargets, Target, Targets, UpdateSettings, Updated, gauss_newton_rotor};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// A shaft of two regions, 0.6 m; `change` makes the measured one of it.
fn shaft(change: impl Fn(&mut Section), disc_factor: f64) -> Rotor {
    let steel = Material::isotropic("steel", 2.1e11, 7850.0, 0.3);
    let sections = (0..24).map(|k| {
        let mut section = Section::cylinder(0.025, 0.03, 0.0, steel.clone());
        section.region = Some(if k < 10 { "nose" } else { "tail" }.to_owned());
        change(&mut section);
        section
    });
    let disc = Disc {
        position_m: 0.15,
        mass_kg: 0.8 * disc_factor,
        polar_inertia_kg_m2: 1e-3 * disc_factor,
        diametral_inertia_kg_m2: 6e-4 * disc_factor,
    };
    Rotor::new(0.0, sections.collect(), &[disc]).unwrap()
}

/// Six resonances and the antiresonances of two places, known to a part in ten thousand.
fn measured(rotor: &Rotor) -> Targets {
    let target = |f: &f64| Some(Target::free(*f, Some(2e-4 * f)));
    let resonances = PlanarModes::new(rotor).unwrap().flexible_hz();
    let zeros = |z: f64| FrfTargets {
        name: format!("at {z}"),
        output_m: z,
        input_m: z,
        antiresonances: rotor.antiresonances_hz(z, z, 50.0, 4000.0).unwrap().iter().map(target).collect(),
        held_out: false,
    };
    Targets {
        resonances: resonances.iter().take(6).map(target).collect(),
        antiresonances: vec![zeros(0.05), zeros(0.55)],
        ..Targets::default()
    }
}

fn update(targets: &Targets) -> Updated {
    gauss_newton_rotor(&shaft(|_| (), 1.0), targets, &UpdateSettings::default()).unwrap()
}

/// The factor that the sentence gives.
fn factor(words: &str) -> f64 {
    let before = words.split(" times that of the file").next().unwrap();
    before.rsplit(' ').next().unwrap().parse().unwrap()
}

#[test]
fn the_parameter_that_was_changed_is_proposed() {
    let is = |section: &Section, region: &str| section.region.as_deref() == Some(region);
    let denser = shaft(
        |s| {
            if is(s, "tail") {
                s.material.density_kg_m3 *= 1.08
            }
        },
        1.0,
    );
    let thicker = shaft(
        |s| {
            if is(s, "nose") {
                s.outer_diameter_m = s.outer_diameter_m.map(|d| 1.05 * d);
                s.mass_outer_diameter_m = s.mass_outer_diameter_m.map(|d| 1.05 * d);
            }
        },
        1.0,
    );
    let heavier = shaft(|_| (), 1.15);
    let cases = [
        (denser, "free the density of region tail instead", 1.08),
        (thicker, "free the outer diameter of region nose instead", 1.05),
        (heavier, "free mass and inertia of the discs instead", 1.15),
    ];
    for (truth, words, expected) in cases {
        let found = update(&measured(&truth)).explanation;
        println!("{}", found.statement);
        assert!(!found.explained && found.statistic > found.limit, "{}", found.statement);
        assert!(found.statement.contains(words), "{}", found.statement);
        assert!((factor(&found.statement) / expected - 1.0).abs() < 0.02, "{}", found.statement);
    }
}

#[test]
fn soft_supports_are_told_from_moduli() {
    let springs = |factor: f64| vec![(0.05, 2e6 * factor), (0.5, 1e6 * factor)];
    let supports: Vec<Support> = springs(1.2)
        .into_iter()
        .map(|(position_m, k)| Support {
            position_m,
            stiffness_n_per_m: [[k, 0.0], [0.0, k]],
            damping_n_s_per_m: [[0.0; 2]; 2],
        })
        .collect();
    let found = shaft(|_| (), 1.0).whirl(0.0, &Damping::None, &supports, 3000.0).unwrap();
    // Every mode comes twice, once a plane.
    let hz = found.modes.iter().step_by(2).map(|mode| mode.natural_rad_s / TAU);
    let resonances = hz.map(|f| Some(Target::free(f, Some(2e-4 * f)))).collect();
    let targets = Targets { resonances, springs: springs(1.0), ..Targets::default() };
    let found = update(&targets).explanation;
    assert!(!found.explained && found.statement.contains("free the stiffness of the supports instead"), "{found:?}");
    assert!((factor(&found.statement) / 1.2 - 1.0).abs() < 0.02, "{}", found.statement);
    // With the right springs nothing is left.
    assert!(update(&Targets { springs: springs(1.2), ..targets }).explanation.explained);
}

#[test]
fn readings_without_deviations_are_refused_only_with_a_chi_squared_that_says_so() {
    let exact = measured(&shaft(|_| (), 1.0));
    let mut refused = 0;
    for seed in 0..12 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let worst: f64 = rng.random_range(0.002..0.05);
        let mut read = |target: &Option<Target>| {
            target.map(|t| Target::read_off(t.frequency_hz * (1.0 + worst * rng.random_range(-1.0..1.0))))
        };
        let targets = Targets { resonances: exact.resonances.iter().map(&mut read).collect(), ..Targets::default() };
        let found = update(&targets).explanation;
        if found.statement.contains("cannot explain") {
            assert!(found.statistic > found.limit, "{}", found.statement);
            assert!(!found.explained);
            refused += 1;
        }
    }
    assert!(refused > 2, "{refused}");
}

/// A peak of the rig among those of the shaft: its frequency is said, and how well the others are met.
#[test]
fn a_peak_without_counterpart_is_named() {
    let mut targets = measured(&shaft(|_| (), 1.0));
    let first = targets.resonances[0].unwrap().frequency_hz;
    let stray = 0.55 * first;
    targets.resonances.insert(0, Some(Target::free(stray, Some(2e-4 * stray))));
    let found = update(&targets).explanation;
    assert!(!found.explained, "{}", found.statement);
    assert!(found.statement.contains(&format!("the resonance at {stray:.1} Hz")), "{}", found.statement);
    assert!(found.statement.contains("within 0.0 %"), "{}", found.statement);
}

/// A mode of the rig shows as a pole with a zero beside it: the zero is no antiresonance of the shaft either, also where
/// one that could not be identified leaves its place free.
#[test]
fn the_zero_beside_a_foreign_pole_has_no_counterpart() {
    let mut targets = measured(&shaft(|_| (), 1.0));
    let zeros = &mut targets.antiresonances[0].antiresonances;
    let stray = 0.8 * zeros[0].take().unwrap().frequency_hz;
    zeros.insert(0, Some(Target::free(stray, Some(2e-4 * stray))));
    targets.resonances.push(Some(Target::free(1.01 * stray, Some(2e-4 * stray))));
    let found = update(&targets);
    let alone = found.errors.iter().filter(|e| e.after_hz.is_none()).map(|e| e.measured_hz);
    assert_eq!(alone.collect::<Vec<f64>>(), [1.01 * stray, stray]);
    assert!(found.explanation.statement.contains("within 0.0 %"), "{}", found.explanation.statement);
}
