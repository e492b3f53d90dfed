//! Regularisation of a problem whose D12 or D21 lacks rank: what is added, what it costs, that units do not matter.

use muspin::augment::{Block, GeneralizedPlant};
use muspin::linalg::Mat;
use muspin::lti::connect::lower_lft;
use muspin::lti::norm::hinf_norm;
use muspin::lti::{Continuous, StateSpace};
use muspin::robust::hinf::regularise::{DEFAULT_SHARE, regularise_plant};
use muspin::robust::{HinfSettings, SynthesisError, synthesise};

/// ẋ = x + w + s u, z = x and (with cost) u, y = x + n/10: inputs w, n, u.
fn plant(cost: f64, control_unit: f64, blocks: Vec<Block>) -> GeneralizedPlant {
    let rows = |list: &[&[f64]]| Mat::from_fn(list.len(), list[0].len(), |i, j| list[i][j]);
    GeneralizedPlant {
        system: StateSpace::new(
            rows(&[&[1.0]]),
            rows(&[&[1.0, 0.0, control_unit]]),
            rows(&[&[1.0], &[0.0], &[1.0]]),
            rows(&[&[0.0, 0.0, 0.0], &[0.0, 0.0, cost], &[0.0, 0.1, 0.0]]),
            Continuous,
        )
        .unwrap(),
        controls: 1,
        measurements: 1,
        blocks,
    }
}

#[test]
fn a_control_without_cost_gets_one_and_the_level_comes_close_to_the_infimum() {
    let given = plant(0.0, 1.0, vec![]);
    let error = synthesise(&given, &HinfSettings::default()).unwrap_err();
    assert!(matches!(error, SynthesisError::ControlCost { .. }), "{error}");
    // No controller brings the gain from n to z below 1/10: a high gain makes x = -n/10.
    let mut last = 0.1;
    for share in [1e-6, DEFAULT_SHARE, 1e-2] {
        let (posed, added) = regularise_plant(&given, share).unwrap();
        assert!(added.d12.len() == 1 && added.d12[0] > 0.0 && added.d21.is_empty(), "{added:?}");
        assert_eq!((posed.errors(), posed.disturbances()), (3, 2));
        let found = synthesise(&posed, &HinfSettings::default()).unwrap();
        let own = lower_lft(&given.system, &found.controller).unwrap();
        let norm = hinf_norm(&own, 1e-9).unwrap().norm;
        // The level grows with what is added; the loop as given is a part of the enlarged one.
        assert!(found.gamma > last && norm <= found.closed_loop_norm * (1.0 + 1e-9), "{share}: {}", found.gamma);
        assert!((0.1..0.1 * 1.02).contains(&norm), "{share}: {norm}");
        last = found.gamma;
    }
}

#[test]
fn what_is_added_does_not_depend_on_the_unit_of_the_control() {
    let level = |unit: f64| {
        let (posed, added) = regularise_plant(&plant(0.0, unit, vec![]), DEFAULT_SHARE).unwrap();
        let found = synthesise(&posed, &HinfSettings::default()).unwrap();
        (found.gamma_opt, added.d12[0])
    };
    let ((gamma, size), (scaled_gamma, scaled_size)) = (level(1.0), level(1e-3));
    assert!((scaled_gamma / gamma - 1.0).abs() < 1e-6, "{gamma} {scaled_gamma}");
    assert!((scaled_size / (1e-3 * size) - 1.0).abs() < 1e-9, "{size} {scaled_size}");
}

#[test]
fn a_regular_plant_stays_and_a_block_grows_with_the_channels() {
    let block = vec![Block::ComplexFull { rows: 2, cols: 2 }];
    let (posed, added) = regularise_plant(&plant(0.5, 1.0, block.clone()), DEFAULT_SHARE).unwrap();
    assert!(added.d12.is_empty() && added.d21.is_empty());
    assert_eq!(posed.blocks, block);
    let (posed, _) = regularise_plant(&plant(0.0, 1.0, block), DEFAULT_SHARE).unwrap();
    assert_eq!(posed.blocks, vec![Block::ComplexFull { rows: 2, cols: 3 }]);
    assert_eq!((posed.disturbances(), posed.errors()), (2, 3));
    // A control that reaches nothing cannot be helped.
    assert!(regularise_plant(&plant(0.0, 0.0, vec![]), DEFAULT_SHARE).is_none());
}
