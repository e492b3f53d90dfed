//! Connections against closed forms.

use muspin::linalg::{Mat, c64};
use muspin::lti::connect::{lower_lft, series};
use muspin::lti::{Continuous, StateSpace};

fn first_order(pole: f64, gain: f64, direct: f64) -> StateSpace<Continuous> {
    let m = |x: f64| Mat::from_fn(1, 1, |_, _| x);
    StateSpace::new(m(-pole), m(1.0), m(gain), m(direct), Continuous).unwrap()
}

#[test]
fn series_multiplies_transfers() {
    let (g, h) = (first_order(2.0, 3.0, 0.5), first_order(5.0, -1.0, 0.25));
    let s = c64::new(0.3, 4.0);
    let expected = g.transfer(s)[(0, 0)] * h.transfer(s)[(0, 0)];
    let found = series(&g, &h).unwrap().transfer(s)[(0, 0)];
    assert!((found - expected).norm() < 1e-14);
}

#[test]
fn positive_feedback_round_a_biproper_plant_is_g_over_one_minus_gk() {
    let (g, k) = (first_order(2.0, 3.0, 0.5), first_order(5.0, -1.0, 0.25));
    let p = StateSpace::new(
        g.a.clone(),
        Mat::from_fn(1, 2, |_, _| 1.0),
        Mat::from_fn(2, 1, |_, _| 3.0),
        Mat::from_fn(2, 2, |_, _| 0.5),
        Continuous,
    )
    .unwrap();
    let s = c64::new(0.0, 1.7);
    let (gs, ks) = (g.transfer(s)[(0, 0)], k.transfer(s)[(0, 0)]);
    let found = lower_lft(&p, &k).unwrap().transfer(s)[(0, 0)];
    assert!((found - gs / (c64::new(1.0, 0.0) - gs * ks)).norm() < 1e-13);
}
