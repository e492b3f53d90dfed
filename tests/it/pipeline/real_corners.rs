//! μ at the corners of real parameters against a problem in closed form.

use muspin::augment::{Block, GeneralizedPlant};
use muspin::linalg::Mat;
use muspin::lti::{Continuous, StateSpace};
use muspin::pipeline::real_corners::largest_at_corners;

/// Two real parameters round M = (a 0 1; 0 b 1; 1 1 0) without a controller: the performance is the sum of
/// δ₁/(1 − a δ₁) and δ₂/(1 − b δ₂).
fn problem(a: f64, b: f64) -> (GeneralizedPlant, StateSpace<Continuous>) {
    let rows = [[a, 0.0, 1.0, 0.0], [0.0, b, 1.0, 0.0], [1.0, 1.0, 0.0, 0.0], [0.0; 4]];
    let plant = GeneralizedPlant {
        system: StateSpace::gain(Mat::from_fn(4, 4, |i, j| rows[i][j]), Continuous),
        controls: 1,
        measurements: 1,
        blocks: vec![
            Block::ComplexScalar { n: 1 },
            Block::ComplexScalar { n: 1 },
            Block::ComplexFull { rows: 1, cols: 1 },
        ],
    };
    (plant, StateSpace::gain(Mat::zeros(1, 1), Continuous))
}

#[test]
fn the_worst_corner_of_a_problem_in_closed_form_is_found() {
    for (a, b) in [(0.5, 0.2), (-0.5, 0.2), (0.0, 0.0), (-0.7, -0.6)] {
        let (plant, law) = problem(a, b);
        let found =
            largest_at_corners(&plant, &law, &[0, 1]).expect("loops of two states").expect("two unknown corners");
        let of = |d: f64, m: f64| d / (1.0 - m * d);
        let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        let own = corners.map(|(d, e)| (of(d, a) + of(e, b)).abs());
        let expected = own.into_iter().fold(0.0, f64::max);
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }
    let (plant, law) = problem(0.5, 0.2);
    assert_eq!(largest_at_corners(&plant, &law, &[]).expect("no corner to search"), None);
}
