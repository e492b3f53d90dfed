//! Weights given as transfer functions and by points: their magnitude against the polynomials and points they come
//! from, in every plane, and against the levels of Table 2 that they can replace.

use muspin::augment::assembly::generalized_plane;
use muspin::augment::plane::{Route, design_plane};
use muspin::augment::root::Root;
use muspin::augment::shape::{Shape, WeightStage};
use muspin::augment::weight_plane::{WeightPlane, fit_errors};
use muspin::augment::weights::Weights;
use muspin::input::{load_machine, read_weights};
use muspin::linalg::c64;
use muspin::lti::Response;
use muspin::pipeline::widening::Widening;
use std::f64::consts::{PI, TAU};

fn table() -> String {
    let path = format!("{}/weights/benchmark.yaml", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap()
}

fn with(lines: &str) -> Weights {
    read_weights("own.yaml", &format!("{}\nover_frequency:\n{lines}", table())).unwrap()
}

/// |Σ cₖ sᵏ| at jω, falling powers.
fn size(coefficients: &[f64], omega: f64) -> f64 {
    let s = c64::new(0.0, omega);
    let sum = coefficients.iter().fold(c64::new(0.0, 0.0), |all, c| all * s + c64::new(*c, 0.0));
    sum.norm()
}

fn frequencies() -> impl Iterator<Item = f64> {
    (0..400).map(|k| 10f64.powf(-1.0 + 6.0 * f64::from(k) / 399.0))
}

#[test]
fn a_transfer_function_has_the_magnitude_of_its_polynomials() {
    // Real and complex roots, equal degrees and more poles than zeros; corners from 1 to 6000 rad/s.
    let cases: [(&[f64], &[f64]); 4] = [
        (&[3.0, 40.0], &[0.02, 1.0]),
        (&[5.0], &[1e-6, 3e-4, 1.0]),
        (&[1e-7, 4e-5, 1.0], &[3e-12, 5e-8, 3e-4, 1.0]),
        (&[2e-7, 1e-3, 2.0, 7.0], &[1e-7, 2e-4, 0.3, 1.0]),
    ];
    for (over, under) in cases {
        let lines = format!("  tool_load_n: {{numerator: {over:?}, denominator: {under:?}}}\n");
        let shape = with(&lines).load_weight(0).unwrap();
        let system = WeightPlane::Laplace.realise(&shape).unwrap().system;
        for hz in frequencies() {
            let expected = size(over, TAU * hz) / size(under, TAU * hz);
            let found = shape.magnitude(TAU * hz);
            assert!((found / expected - 1.0).abs() < 1e-9, "{over:?} {hz} {found} {expected}");
            let realised = system.at(TAU * hz)[(0, 0)].norm();
            assert!((realised / expected - 1.0).abs() < 1e-9, "{over:?} {hz}");
        }
        assert_eq!(shape.excess_over_points, 0.0);
    }
}

#[test]
fn levels_written_as_transfer_functions_are_the_same_problem() {
    // W(s) = (h s + d p)/(s + p), p = 2π f √(h/d); allowed displacements and current are one over it.
    let change = |low: f64, high: f64, hz: f64| {
        let pole = TAU * hz * (high / low).sqrt();
        (vec![high, low * pole], vec![1.0, pole])
    };
    let (load, over_load) = change(40.0, 5.0, 40.0);
    let (allowed, over_allowed) = change(10e-6, 30e-6, 100.0);
    let (near, far) = (TAU * 3000.0, TAU * 30_000.0);
    let square = |w: f64| vec![w.powi(-2), 2.0 / w, 1.0];
    let current: Vec<f64> = square(far).into_iter().map(|c| 2.5 * c).collect();
    let lines = format!(
        "  tool_load_n: {{numerator: {load:?}, denominator: {over_load:?}}}
  rear_displacement_m: {{numerator: {allowed:?}, denominator: {over_allowed:?}}}
  sensor_noise_m: {{numerator: [2.0e-7, 2.0e-4], denominator: [1, 1000]}}
  current_a: {{numerator: {current:?}, denominator: {:?}}}\n",
        square(near)
    );
    let levels = read_weights("benchmark", &table()).unwrap();
    let curves = with(&lines);
    let looser = Widening { tool: 1.5, front: 2.0, rear: 3.0, current: 4.0 };
    let machine = load_machine("reference", "paper-tool").unwrap();
    let plane = design_plane(&machine, 5, &[], Route::Emulation { pade_order: 3 }).unwrap();
    for widening in [Widening::NONE, looser] {
        let problem = |w: &Weights| generalized_plane(&plane, &[], &widening.apply(w), WeightPlane::Laplace).unwrap();
        let (one, other) = (problem(&levels), problem(&curves));
        for hz in [0.3, 20.0, 90.0, 800.0, 2900.0, 40_000.0] {
            let (a, b) = (one.system.at(TAU * hz), other.system.at(TAU * hz));
            for i in 0..a.nrows() {
                for j in 0..a.ncols() {
                    let size = a[(i, j)].norm();
                    let gap = (size - b[(i, j)].norm()).abs();
                    // Double poles of the roll-off come from a polynomial's roots: half the digits.
                    assert!(gap <= 1e-6 * size + 1e-300, "{hz} {i} {j}");
                }
            }
        }
    }
}

#[test]
fn second_order_weights_have_their_magnitude_over_true_frequency() {
    let mut largest = 0.0f64;
    for rate_hz in [8e3, 20e3, 40e3] {
        let period_s = 1.0 / rate_hz;
        for share in [0.001, 0.05, 0.3, 0.7] {
            for zeta in [0.05, 0.3, 0.95] {
                let corner = share * PI * rate_hz;
                let pair = |omega_rad_s: f64, damping: f64| Root { omega_rad_s, damping: Some(damping) };
                let peak = Shape::from_roots(3.0, &[pair(corner, 0.97)], &[pair(corner, zeta)]);
                let notch = Shape::from_roots(3.0, &[pair(corner, zeta)], &[pair(corner, 0.97)]);
                let falling = Shape::from_roots(3.0, &[], &[pair(corner, zeta)]);
                for shape in [peak.unwrap(), notch.unwrap(), falling.unwrap()] {
                    assert!(matches!(shape.stages[..], [WeightStage::Second(_)]));
                    let fit = WeightPlane::Analysis { period_s }.realise(&shape).unwrap();
                    largest = largest.max(fit.largest_excess);
                    let poles = muspin::linalg::eigenvalues(&fit.system.a).unwrap();
                    assert!(poles.iter().all(|p| p.re < 0.0));
                    for k in 1..4000 {
                        let share = f64::from(k) / 4000.0;
                        let v = 2.0 / period_s * (0.5 * PI * share).tan();
                        let ratio = fit.system.at(v)[(0, 0)].norm() / shape.magnitude(share * PI * rate_hz);
                        let allowed = 1.0 - 1e-9..=1.0 + fit.largest_excess + 1e-9;
                        assert!(
                            allowed.contains(&ratio),
                            "{rate_hz} {corner} {zeta} {share}: {ratio}, excess {}",
                            fit.largest_excess
                        );
                    }
                    // In synthesis a resonance stays at its frequency as well.
                    let read = WeightPlane::Synthesis { period_s }.realise(&shape).unwrap();
                    let v = 2.0 / period_s * (0.5 * corner * period_s).tan();
                    let at_corner = read.system.at(v)[(0, 0)].norm() / shape.magnitude(corner);
                    assert!((at_corner - 1.0).abs() < 1e-9);
                }
            }
        }
    }
    // The error of the approximant, 1.3e-3 in ω², over the half width of the sharpest resonance.
    assert!(largest < 0.05, "{largest}");
}

#[test]
fn a_weight_by_points_is_nowhere_below_them() {
    let tables: [&[[f64; 2]]; 4] = [
        &[[10.0, 40.0], [1000.0, 5.0]],
        &[[5.0, 40.0], [40.0, 14.0], [250.0, 5.0], [700.0, 7.0], [1200.0, 7.0], [3000.0, 5.0]],
        &[[100.0, 1e-6], [300.0, 1e-5]],
        &[[1.0, 2.0], [2.0, 2.0]],
    ];
    for points in tables {
        let lines = format!("  front_load_n: {{points: {points:?}}}\n  rear_displacement_m: {{points: {points:?}}}\n");
        let weights = with(&lines);
        let load = weights.load_weight(1).unwrap();
        let displacement = weights.displacement_weight(2).unwrap();
        let excess = load.excess_over_points.max(displacement.excess_over_points);
        // Half a decibel: order six rounds the corners of five straight lines.
        assert!(excess < 0.08, "{points:?}: {excess}");
        assert_eq!(fit_errors(&weights, 5e-5).unwrap().points, excess);
        // Straight on logarithmic axes, constant beyond the ends.
        let written = |hz: f64| {
            let after = points.iter().position(|p| p[0] >= hz);
            match after {
                Some(0) => points[0][1],
                None => points[points.len() - 1][1],
                Some(k) => {
                    let ([f, v], [g, w]) = (points[k - 1], points[k]);
                    v * (w / v).powf((hz / f).ln() / (g / f).ln())
                }
            }
        };
        let (first, last) = (points[0][0], points[points.len() - 1][0]);
        for k in 0..=1000 {
            let hz = first * (last / first).powf(f64::from(k) / 1000.0);
            // The fit is raised at four hundred lines a decade: what is between them is second order in their distance.
            let range = 1.0 - 1e-5..=1.0 + excess + 1e-5;
            let ratio = load.magnitude(TAU * hz) / written(hz);
            assert!(range.contains(&ratio), "{points:?} {hz} {ratio}");
            let ratio = displacement.magnitude(TAU * hz) * written(hz);
            assert!(range.contains(&ratio), "{points:?} {hz} {ratio}");
        }
    }
}

#[test]
fn curves_that_are_none_are_refused_with_their_key() {
    let read = |lines: &str| read_weights("own.yaml", &format!("{}\nover_frequency:\n{lines}", table()));
    for (lines, key, word) in [
        ("  tool_load_n: {}\n", "tool_load_n", "points"),
        ("  tool_load_n: {points: [[1, 2]]}\n", "tool_load_n", "2 to"),
        ("  tool_load_n: {points: [[10, 2], [5, 1]]}\n", "tool_load_n", "points[1]"),
        ("  current_a: {points: [[10, 2], [50, -1]]}\n", "current_a", "points[1]"),
        ("  current_a: {points: [[10, 2], [50, 1]], numerator: [1]}\n", "current_a", "either"),
        ("  tool_load_n: {numerator: [1, 1], denominator: [1]}\n", "tool_load_n", "more zeros"),
        ("  current_a: {numerator: [1], denominator: [1, 1]}\n", "current_a", "more poles"),
        ("  rear_load_n: {numerator: [1, -2], denominator: [1, 1]}\n", "rear_load_n", "left half plane"),
        ("  rear_load_n: {numerator: [1, 2], denominator: [1, 0]}\n", "rear_load_n", "denominator"),
        ("  rear_load_n: {numerator: [], denominator: [1, 1]}\n", "rear_load_n", "numerator"),
        ("  front_load_n: {points: [[100, 1], [101, 50], [102, 1]]}\n", "front_load_n", "misses"),
        ("  top_load_n: {points: [[1, 1], [2, 1]]}\n", "top_load_n", "unknown field"),
    ] {
        let told = read(lines).unwrap_err().to_string();
        assert!(told.contains(key) && told.contains(word), "{lines}: {told}");
    }
    let both = "uncertainty:\n  actuator: {low: 0.1, high: 0.5, crossover_hz: 900}\nover_frequency:\n  \
                actuator: {points: [[100, 0.1], [1000, 0.5]]}\n";
    let told = read_weights("own.yaml", &format!("{}\n{both}", table())).unwrap_err();
    assert!(told.to_string().contains("uncertainty.actuator"));
}

#[test]
fn errors_of_the_hardware_are_given_over_frequency_as_well() {
    let weights = with(
        "  actuator: {points: [[500, 0.02], [5000, 0.6]]}\n  sensor_m_per_a: {numerator: [1.0e-6], denominator: [0.001, 1]}\n",
    );
    let actuator = weights.uncertainty.actuator.unwrap();
    assert!((actuator.magnitude(TAU * 500.0) / 0.02 - 1.0).abs() < 0.05);
    let sensor = weights.uncertainty.sensor.unwrap();
    let corner = sensor.magnitude(1000.0);
    assert!((corner / (1e-6 * 0.5f64.sqrt()) - 1.0).abs() < 1e-12);
}
