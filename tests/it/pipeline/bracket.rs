//! The bracket of a factor at which γ crosses its target, on known functions.

use muspin::pipeline::bracket::Bracket;

/// Evaluations until the bracket is narrower than 5 %, and its factor.
fn narrowed(gamma: impl Fn(f64) -> f64, start: (f64, Option<f64>)) -> (usize, f64) {
    let mut bracket = Bracket::new(start.0, start.1, 4000.0, gamma(4000.0), 1.0);
    let mut evaluations = 0;
    while bracket.ratio() > 1.05 && evaluations < 100 {
        let factor = bracket.next(0.05);
        bracket.add(factor, gamma(factor));
        evaluations += 1;
    }
    (evaluations, bracket.factor())
}

#[test]
fn the_crossing_of_a_power_is_found_in_two_evaluations() {
    let gamma = |factor: f64| (factor / 37.0).powf(-0.7);
    let (evaluations, factor) = narrowed(gamma, (1.0, Some(gamma(1.0))));
    assert!((37.0..37.0 * 1.05).contains(&factor), "{factor}");
    assert_eq!(evaluations, 2);
}

#[test]
fn a_step_and_a_floor_are_found_about_as_fast_as_by_bisection() {
    // ln 4000 / ln 1.05 = 170 widths: bisection takes eight.
    let step = |factor: f64| if factor < 37.0 { 1000.0 } else { 0.99 };
    let floor = |factor: f64| 0.98 + 100.0 / factor.powi(2);
    for gamma in [&step as &dyn Fn(f64) -> f64, &floor] {
        for known in [None, Some(gamma(1.0))] {
            let (evaluations, factor) = narrowed(gamma, (1.0, known));
            assert!(evaluations <= 2 * 8 + 2, "{evaluations}");
            assert!(gamma(factor) <= 1.0 && gamma(factor / 1.05) > 1.0, "{factor}");
        }
    }
}
