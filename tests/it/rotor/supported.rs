//! A shaft on two supports against the closed form of a beam with an overhang.

use muspin::rotor::supported::supported_compliance;
use muspin::rotor::{Material, Rotor, Section, Shear};
use std::f64::consts::PI;

/// Tip of an overhang a beside a span L: a²(L + a)/(3EI) by bending, (a + a²/L)/(κGA) by shear (force F in the overhang,
/// F a/L in the span).
#[test]
fn the_tip_of_an_overhang_gives_as_the_closed_form_says() {
    let (diameter, overhang, span, rest) = (0.03, 0.12, 0.2, 0.05);
    let material = Material::isotropic("steel", 2.1e11, 7850.0, 0.3);
    let (e, g, nu) = (material.youngs_modulus_pa, material.shear_modulus_pa, material.poisson_ratio);
    for shear in [Shear::Rigid, Shear::Cowper] {
        let section = |length: f64| Section { shear, ..Section::cylinder(length, diameter, 0.0, material.clone()) };
        let lengths = [0.07, 0.05, 0.09, 0.11, rest];
        let rotor = Rotor::new(0.0, lengths.map(section).to_vec(), &[]).unwrap();
        let found = supported_compliance(&rotor, 0.0, [overhang, overhang + span]).unwrap();
        let (area, second_moment) = (PI * diameter.powi(2) / 4.0, PI * diameter.powi(4) / 64.0);
        let bending = overhang.powi(2) * (span + overhang) / (3.0 * e * second_moment);
        // Cowper's coefficient of a full circle.
        let kappa = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu);
        let sheared = (overhang + overhang.powi(2) / span) / (kappa * g * area);
        let expected = if shear == Shear::Rigid { bending } else { bending + sheared };
        assert!((found / expected - 1.0).abs() < 1e-8, "{shear:?}: {found} {expected}");
    }
}

#[test]
fn supports_at_one_place_are_refused() {
    let material = Material::isotropic("steel", 2.1e11, 7850.0, 0.3);
    let rotor = Rotor::new(0.0, vec![Section::cylinder(0.1, 0.02, 0.0, material); 3], &[]).unwrap();
    assert!(supported_compliance(&rotor, 0.0, [0.15, 0.15]).is_err());
    assert!(supported_compliance(&rotor, 0.5, [0.1, 0.2]).is_err());
}
