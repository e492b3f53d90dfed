//! Weights against closed forms, the w plane against the sampled plane.

use muspin::augment::weighting::{level_change, roll_on};
use muspin::lti::Response;
use std::f64::consts::TAU;

#[test]
fn level_change_meets_both_levels_and_the_crossing() {
    for (dc, hf) in [(40.0, 5.0), (1e5, 1e4 / 3.0), (2e4, 1e5)] {
        let w = level_change(dc, hf, 40.0).unwrap();
        assert!((w.at(1e-9)[(0, 0)].norm() / dc - 1.0).abs() < 1e-9);
        assert!((w.at(1e12)[(0, 0)].norm() / hf - 1.0).abs() < 1e-6);
        let crossing = w.at(TAU * 40.0)[(0, 0)].norm();
        assert!((crossing / (dc * hf).sqrt() - 1.0).abs() < 1e-12);
    }
    let w = roll_on(2.5, 3000.0, 10.0).unwrap();
    assert!((w.at(1e-6)[(0, 0)].norm() * 2.5 - 1.0).abs() < 1e-9);
    assert!((w.at(1e12)[(0, 0)].norm() * 2.5 / 100.0 - 1.0).abs() < 1e-6);
    assert!((w.at(TAU * 3000.0)[(0, 0)].norm() * 2.5 - 2.0 / 1.01).abs() < 1e-9);
}
