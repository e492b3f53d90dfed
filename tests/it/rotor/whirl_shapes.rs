//! Whirl shapes against the bending line of a uniform slender beam and the two planes of a shaft on unequal springs.

use muspin::linalg::c64;
use muspin::rotor::whirl::RotorState;
use muspin::rotor::{Damping, Material, Rotor, Section, Support};
use std::f64::consts::TAU;

const LENGTH: f64 = 1.0;

/// 1 m of steel, 10 mm thick: shear and rotary inertia change the first shape by 1e-4.
fn beam() -> Rotor {
    let steel = Material::isotropic("steel", 2.1e11, 7850.0, 0.3);
    let sections = (0..24).map(|_| Section::cylinder(LENGTH / 24.0, 0.01, 0.0, steel.clone()));
    Rotor::new(0.0, sections.collect(), &[]).unwrap()
}

fn places() -> Vec<f64> {
    (0..=8).map(|k| LENGTH * f64::from(k) / 8.0).collect()
}

/// First bending line of a free uniform beam, cosh βz + cos βz − σ (sinh βz + sin βz).
fn free_beam(z: f64) -> f64 {
    let (beta, sigma) = (4.730_040_744_862_704 / LENGTH, 0.982_502_214_576_238);
    let x = beta * z;
    x.cosh() + x.cos() - sigma * (x.sinh() + x.sin())
}

#[test]
fn orbits_of_a_free_beam_are_circles_along_its_bending_line_each_whirl_in_its_direction() {
    let rotor = beam();
    let speed_rad_s = 20_000.0 * TAU / 60.0;
    let state = RotorState { speed_rad_s, damping: &Damping::None, supports: &[] };
    let shapes = rotor.whirl_shapes(&state, &places(), 200.0).unwrap();
    let listed = rotor.whirl(speed_rad_s, &Damping::None, &[], 200.0).unwrap();
    let bending: Vec<_> = shapes.iter().filter(|s| s.mode.damped_rad_s > TAU * 30.0).take(2).collect();
    assert_eq!(bending.iter().map(|s| s.mode.whirl.round()).collect::<Vec<_>>(), [-1.0, 1.0]);
    for shape in bending {
        let same = |m: &&muspin::rotor::WhirlMode| (m.damped_rad_s / shape.mode.damped_rad_s - 1.0).abs() < 1e-8;
        assert!(listed.modes.iter().find(same).is_some_and(|m| m.whirl == shape.mode.whirl.round()));
        // The largest orbit is at the ends, where the line is 2; circles have |X| = |Y| and Y a quarter turn apart.
        for (z, [x, y]) in places().iter().zip(&shape.orbits) {
            let expected = free_beam(*z) / 2.0 / 2f64.sqrt();
            assert!((x.norm() - expected.abs()).abs() < 2e-3, "{z}: {x} {expected}");
            let turned = c64::new(0.0, -shape.mode.whirl) * x;
            assert!((y - turned).norm() < 1e-6, "{z}: {x} {y}");
        }
        let sign = |k: usize| shape.orbits[k][0].re.signum();
        assert_eq!([sign(0), sign(4), sign(8)].map(|s| s * sign(0)), [1.0, -1.0, 1.0]);
    }
}

#[test]
fn unequal_springs_keep_a_shaft_at_rest_in_their_planes() {
    let rotor = beam();
    let spring = |position_m: f64| Support {
        position_m,
        stiffness_n_per_m: [[20.0, 0.0], [0.0, 80.0]],
        damping_n_s_per_m: [[0.0; 2]; 2],
    };
    let supports = [spring(0.0), spring(LENGTH)];
    let state = RotorState { speed_rad_s: 0.0, damping: &Damping::None, supports: &supports };
    let shapes = rotor.whirl_shapes(&state, &places(), 200.0).unwrap();
    // Both springs and the mass give the lowest mode, which the softer plane has; twice the frequency in the stiffer.
    let mass = rotor.mass_properties().mass_kg;
    let [softer, stiffer] = [40.0, 160.0].map(|k: f64| (k / mass).sqrt());
    let of = |plane: usize, omega: f64| {
        let is_near = |s: &&muspin::rotor::WhirlShape| (s.mode.damped_rad_s / omega - 1.0).abs() < 0.05;
        let found = shapes.iter().find(is_near).unwrap();
        assert!(found.orbits.iter().all(|orbit| orbit[1 - plane].norm() < 1e-6), "{:?}", found.orbits);
        assert_eq!(found.mode.whirl, 0.0);
    };
    of(0, softer);
    of(1, stiffer);
}
