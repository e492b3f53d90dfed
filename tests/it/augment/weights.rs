//! Weights against closed forms, the w plane against the sampled plane.

use muspin::augment::weighting::WeightSection;
use muspin::augment::weights::{Limits, Weights};
use muspin::input::load_weights;
use muspin::lti::Response;
use std::f64::consts::TAU;

#[test]
fn level_change_meets_both_levels_and_the_crossing() {
    for (dc, hf) in [(40.0, 5.0), (1e5, 1e4 / 3.0), (2e4, 1e5)] {
        let w = WeightSection::level_change(dc, hf, 40.0).unwrap();
        let w = w.system().unwrap();
        assert!((w.at(1e-9)[(0, 0)].norm() / dc - 1.0).abs() < 1e-9);
        assert!((w.at(1e12)[(0, 0)].norm() / hf - 1.0).abs() < 1e-6);
        let crossing = w.at(TAU * 40.0)[(0, 0)].norm();
        assert!((crossing / (dc * hf).sqrt() - 1.0).abs() < 1e-12);
    }
    let mut weights = Weights {
        current_limit_a: 2.5,
        current_rolloff_hz: 3000.0,
        current_rolloff_ratio: 10.0,
        tool_tightening: 1.25,
        ..load_weights("benchmark").unwrap()
    };
    let w = weights.current_weight().unwrap();
    assert!((w.magnitude(1e-6) * 2.5 - 1.0).abs() < 1e-9);
    assert!((w.magnitude(1e12) * 2.5 / 100.0 - 1.0).abs() < 1e-6);
    assert!((w.magnitude(TAU * 3000.0) * 2.5 - 2.0 / 1.01).abs() < 1e-9);
    // Loads in N, displacements by their reciprocal, those of the tool tightened.
    weights.tool =
        Limits { max_dc_load_n: 40.0, max_hf_load_n: 5.0, max_dc_displacement_m: 1e-5, max_hf_displacement_m: 4e-6 };
    let (load, displacement) = (weights.load_weight(0), weights.displacement_weight(0));
    let ends = |w: &muspin::augment::shape::Shape| [w.magnitude(1e-9), w.magnitude(1e12)];
    for (found, expected) in
        [(ends(&load.unwrap()), [40.0, 5.0]), (ends(&displacement.unwrap()), [1.25e5, 1.25 / 4e-6])]
    {
        for (f, e) in found.into_iter().zip(expected) {
            assert!((f / e - 1.0).abs() < 1e-6, "{f} {e}");
        }
    }
}
