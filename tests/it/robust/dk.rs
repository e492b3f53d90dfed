//! D-K iteration against the best peak that other programmes reached.

use crate::robust::control_cases::{Case, block_list, number_list, system};
use muspin::augment::{Block, GeneralizedPlant};
use muspin::linalg::Mat;
use muspin::lti::connect::lower_lft;
use muspin::lti::norm::hinf_norm;
use muspin::lti::{Continuous, StateSpace};
use muspin::robust::dk::posed::iterate_mixed;
use muspin::robust::dk::{DkSettings, iterate};
use muspin::robust::mu::system::MuSystem;

fn plant(case: &Case) -> GeneralizedPlant {
    let count = |key: &str| case.data[key].as_u64().unwrap() as usize;
    GeneralizedPlant {
        system: system(&case.data),
        controls: count("m2"),
        measurements: count("p2"),
        blocks: block_list(&case.data["blocks"]),
    }
}

fn run(id: &str, limit: f64, order_limit: usize) {
    let case = Case::named("dk", id);
    let plant = plant(&case);
    let omega = number_list(&case.data["omega"]);
    let settings = DkSettings { fit_range_rad_s: Some((omega[0], omega[omega.len() - 1])), ..DkSettings::default() };
    let mut seen = 0;
    let outcome = iterate(&plant, &settings, &mut |_| seen += 1).unwrap();
    assert_eq!(seen, outcome.steps.len());
    // The best step is returned, not the last.
    for step in outcome.steps.iter().filter(|s| s.failure.is_none()) {
        assert!(outcome.mu_peak <= step.mu_peak * (1.0 + 1e-3));
    }
    assert!(outcome.mu_peak <= limit, "{} > {limit}", outcome.mu_peak);
    assert!(outcome.controller.order() <= order_limit);
    // An independent dense look at the loop.
    let closed = lower_lft(&plant.system, &outcome.controller).unwrap();
    let dense = MuSystem::new(&closed, &plant.blocks).unwrap();
    let grid: Vec<f64> = (0..400).map(|k| 10f64.powf(-4.0 + 0.025 * f64::from(k))).collect();
    let largest = dense.sweep(&grid).unwrap().iter().map(|p| p.upper).fold(0.0, f64::max);
    assert!(largest <= outcome.mu_peak * (1.0 + 1e-6), "{largest}");
    assert!(outcome.mu_lower_peak <= outcome.mu_peak);
}

#[test]
fn distillation_column() {
    run("skogestad_column", 0.945, 22);
}

#[test]
fn magnetic_bearing_plane() {
    run("amb_1plane", 1.14, 32);
}

#[test]
fn two_mass_spring() {
    run("two_mass_real", 0.907, 14);
}

/// x'' + 2ζx' + (1 + 0.5 δ) x = u + d, −1 ≤ δ ≤ 1: errors 0.3 x and u, y = x + 0.3 n.
fn uncertain_spring(block: Block) -> GeneralizedPlant {
    let (damping, reach) = (0.05, 0.5);
    let row = |values: &[f64]| values.to_vec();
    let matrix = |rows: &[Vec<f64>]| Mat::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
    let system = StateSpace {
        a: matrix(&[row(&[0.0, 1.0]), row(&[-1.0, -2.0 * damping])]),
        b: matrix(&[row(&[0.0; 4]), row(&[1.0, 1.0, 0.0, 1.0])]),
        c: matrix(&[row(&[-reach, 0.0]), row(&[0.3, 0.0]), row(&[0.0, 0.0]), row(&[1.0, 0.0])]),
        d: matrix(&[row(&[0.0; 4]), row(&[0.0; 4]), row(&[0.0, 0.0, 0.0, 1.0]), row(&[0.0, 0.0, 0.3, 0.0])]),
        time: Continuous,
    };
    GeneralizedPlant {
        system,
        controls: 1,
        measurements: 1,
        blocks: vec![block, Block::ComplexFull { rows: 2, cols: 2 }],
    }
}

/// Closes w₁ = δ z₁ and leaves the channels of the performance.
fn closed_with_spring(closed: &StateSpace<Continuous>, delta: f64) -> StateSpace<Continuous> {
    let (n, k) = (closed.order(), delta / (1.0 - delta * closed.d[(0, 0)]));
    let part = |m: &Mat<f64>, rows: usize, cols: usize, left: &dyn Fn(usize) -> f64, right: &dyn Fn(usize) -> f64| {
        let (i0, j0) = (m.nrows() - rows, m.ncols() - cols);
        Mat::from_fn(rows, cols, |i, j| m[(i + i0, j + j0)] + k * left(i) * right(j))
    };
    let (b1, c1) = (|i: usize| closed.b[(i, 0)], |j: usize| closed.c[(0, j)]);
    let (d21, d12) = (|i: usize| closed.d[(i + 1, 0)], |j: usize| closed.d[(0, j + 1)]);
    StateSpace {
        a: part(&closed.a, n, n, &b1, &c1),
        b: part(&closed.b, n, 2, &b1, &d12),
        c: part(&closed.c, 2, n, &d21, &c1),
        d: part(&closed.d, 2, 2, &d21, &d12),
        time: Continuous,
    }
}

#[test]
fn a_real_spring_is_held_where_a_complex_one_is_not() {
    let complex = uncertain_spring(Block::ComplexScalar { n: 1 });
    let cautious = iterate_mixed(&complex, &DkSettings::default(), &mut |_| {}).unwrap();
    let real = uncertain_spring(Block::RealScalar { n: 1 });
    let mut seen = 0;
    let found = iterate_mixed(&real, &DkSettings::default(), &mut |_| seen += 1).unwrap();
    assert_eq!(seen, found.steps.len());
    assert!(cautious.mu_lower_peak > 1.2 && found.mu_peak < 1.0, "{} {}", cautious.mu_lower_peak, found.mu_peak);
    // Main loop theorem: with μ below 1 every spring of the range has a stable loop whose norm is below 1. The controller
    // for a complex block has a larger norm at its worst spring.
    let worst = |controller: &StateSpace<Continuous>| {
        let closed = lower_lft(&real.system, controller).unwrap();
        let norms = (0..=80).map(|k| {
            let own = closed_with_spring(&closed, f64::from(k) / 40.0 - 1.0);
            hinf_norm(&own, 1e-6).map_or(f64::INFINITY, |norm| norm.norm)
        });
        norms.fold(0.0, f64::max)
    };
    let (mixed, cautious) = (worst(&found.controller), worst(&cautious.controller));
    assert!(mixed <= 1.0, "{mixed}");
    assert!(mixed < cautious, "{mixed} {cautious}");
}
