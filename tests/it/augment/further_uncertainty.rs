//! Uncertainty of actuators, sensors, magnets and delay: the problem closed with an error is the problem of the machine
//! that has it, and μ of two errors alone against the largest spectral radius over their phases.

use crate::support::inputs::short_search;
use muspin::augment::assembly::{UncertainMode, generalized_plane};
use muspin::augment::hardware::Uncertainty;
use muspin::augment::plane::{Route, design_plane};
use muspin::augment::shape::Shape;
use muspin::augment::weight_plane::WeightPlane;
use muspin::augment::weights::{Limits, Weights};
use muspin::input::{load_machine, load_weights, read_weights};
use muspin::linalg::{Mat, c64, solve_complex};
use muspin::lti::Response;
use muspin::pid::tune::textbook;
use muspin::pipeline::comparison::discrete;
use muspin::pipeline::speed_mu::mu_at_speed;
use muspin::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::{PI, TAU};

fn machines() -> Vec<Machine> {
    let own = |name: &str| {
        let root = env!("CARGO_MANIFEST_DIR");
        load_machine(&format!("{root}/tests/data/spindles/{name}.yaml"), "paper-tool").unwrap()
    };
    vec![load_machine("reference", "paper-tool").unwrap(), own("s06-strong-ks"), own("s12-big-discs")]
}

fn benchmark(uncertainty: Uncertainty) -> Weights {
    Weights { uncertainty, ..load_weights("benchmark").unwrap() }
}

fn part(m: &Mat<c64>, r: usize, c: usize, h: usize, w: usize) -> Mat<c64> {
    m.submatrix(r, c, h, w).to_owned()
}

/// The responses with Δ closed round the first channels.
fn closed_above(m: &Mat<c64>, delta: &[c64]) -> Mat<c64> {
    let n = delta.len();
    let (rows, columns) = (m.nrows() - n, m.ncols() - n);
    let errors = Mat::from_fn(n, n, |i, j| if i == j { delta[i] } else { c64::new(0.0, 0.0) });
    let difference = Mat::<c64>::identity(n, n) - part(m, 0, 0, n, n) * &errors;
    let inner = solve_complex(&difference, &part(m, 0, n, n, columns));
    part(m, n, n, rows, columns) + part(m, n, 0, rows, n) * (errors * inner)
}

#[test]
fn the_problem_closed_with_an_error_is_that_of_the_machine_that_has_it() {
    let certain = benchmark(Uncertainty::default());
    let (ki, ks) = (0.07, 0.12);
    let (force, stiffness) = ([0.6, -0.9], [-0.4, 0.8]);
    let (levels, additive) = ([0.03, 0.8, 1500.0], [2e-6, 4e-7, 700.0]);
    let shape = |[low, high, crossover_hz]: [f64; 3]| Shape::level_change(low, high, crossover_hz).unwrap();
    let (actuator, sensor) = (c64::new(0.3, -0.5), c64::new(-0.2, 0.7));
    for machine in machines() {
        let uncertain = benchmark(Uncertainty {
            actuator: Some(shape(levels)),
            sensor: Some(shape(additive)),
            force_constant: ki,
            negative_stiffness: ks,
            ..Uncertainty::default()
        })
        .on(&machine)
        .unwrap();
        let mut other = machine.clone();
        let bearings = [&mut other.spindle.front, &mut other.spindle.rear];
        for (k, bearing) in bearings.into_iter().enumerate() {
            bearing.ki_n_per_a *= 1.0 + ki * force[k];
            bearing.ks_n_per_m *= 1.0 + ks * stiffness[k];
        }
        let problem = |machine: &Machine, weights: &Weights| {
            let modes: [UncertainMode; 0] = [];
            let plane = design_plane(machine, 5, &[], Route::Emulation { pade_order: 3 }).unwrap();
            generalized_plane(&plane, &modes, weights, WeightPlane::Laplace).unwrap()
        };
        let (with, without) = (problem(&machine, &uncertain), problem(&other, &certain));
        assert_eq!(with.blocks.len(), without.blocks.len() + 8);
        for hz in [3.0, 40.0, 230.0, 900.0, 1700.0, 3100.0] {
            let omega = TAU * hz;
            let weight = |[low, high, crossover_hz]: &[f64; 3]| {
                let p = TAU * crossover_hz * (high / low).sqrt();
                let s = c64::new(0.0, omega);
                (s * *high + p * *low) / (s + p)
            };
            let delta: Vec<c64> = [actuator, actuator, sensor, sensor]
                .into_iter()
                .chain(force.into_iter().chain(stiffness).map(|v| c64::new(v, 0.0)))
                .collect();
            let found = closed_above(&with.system.at(omega), &delta);
            let mut expected = without.system.at(omega);
            let (nz, nw) = (expected.nrows() - 2, expected.ncols() - 2);
            // What is left to do by hand: the actuator's error on top of k_i, the sensor's beside the signals.
            let ports = expected.clone();
            for k in 0..2 {
                let gain = 1.0 + ki * force[k];
                let factor = (c64::new(gain, 0.0) + weight(&levels) * actuator) / gain;
                for i in 0..expected.nrows() {
                    // The commanded current is not changed by what the actuator makes of it.
                    if !(3..5).contains(&i) {
                        expected[(i, nw + k)] = ports[(i, nw + k)] * factor;
                    }
                }
                let signal = weight(&additive) * sensor * 1e5;
                expected[(nz + k, nw + k)] += signal;
            }
            for i in 0..expected.nrows() {
                for j in 0..expected.ncols() {
                    let (a, b) = (found[(i, j)], expected[(i, j)]);
                    let size = b.norm().max(1e-9 * expected.norm_max());
                    assert!((a - b).norm() < 1e-6 * size, "{hz} Hz ({i}, {j}): {a} {b}");
                }
            }
        }
    }
}

/// Largest spectral radius of M diag(1, e^{jφ}) over φ: μ of two complex numbers.
///
/// The eigenvalues are h ± r with h half the trace; |h + r|² + |h − r|² = 2 (|h|² + |r|²), and |h + r| |h − r| is the
/// determinant, whose size no φ changes. So the larger one is largest where s = |h|² + |r|² is.
fn of_two(m: &Mat<c64>, turns: &[c64]) -> f64 {
    let across = m[(0, 1)] * m[(1, 0)];
    let largest = |turn: &c64| {
        let (a, d) = (m[(0, 0)], m[(1, 1)] * turn);
        let gap = 0.5 * (a - d);
        let square = gap * gap + across * turn;
        (0.5 * (a + d)).norm_sqr() + square.norm_sqr().sqrt()
    };
    let s = turns.iter().map(largest).fold(0.0, f64::max);
    let determinant = (m[(0, 0)] * m[(1, 1)] - across).norm_sqr();
    (s + (s * s - determinant).max(0.0).sqrt()).sqrt()
}

#[test]
fn mu_of_two_errors_alone_is_the_largest_spectral_radius_over_their_phases() {
    let turns: Vec<c64> = (0..180).map(|k| c64::from_polar(1.0, TAU * f64::from(k) / 180.0)).collect();
    let wider = |l: &Limits| Limits {
        max_dc_displacement_m: 1e4 * l.max_dc_displacement_m,
        max_hf_displacement_m: 1e4 * l.max_hf_displacement_m,
        ..*l
    };
    for machine in machines() {
        let period_s = machine.spindle.electronics.sample_period_s();
        let pid = textbook(&machine, &short_search()).unwrap();
        let law = discrete(&pid.controller, period_s).unwrap();
        let plant = Plant::new(&machine, 0.0, ModelDetail::Full).unwrap();
        let ks = [&machine.spindle.front, &machine.spindle.rear].map(|b| b.ks_n_per_m);
        let kinds = [
            Uncertainty { force_constant: 0.2, ..Uncertainty::default() },
            Uncertainty { negative_stiffness: 0.3, ..Uncertainty::default() },
            Uncertainty { delay_s: 0.5 * period_s, ..Uncertainty::default() },
        ];
        let last = 0.49 / period_s;
        // A peak of 0.4 % damping has a half-width of 0.4 % of its frequency: lines 0.04 % apart show it to 0.2 %.
        let lines: Vec<(f64, Mat<c64>, Mat<c64>)> = (0..24_000)
            .map(|k| last.powf(f64::from(k) / 23_999.0))
            .map(|hz| (hz, plant.at(TAU * hz), law.at(TAU * hz)))
            .collect();
        for (kind, uncertainty) in kinds.into_iter().enumerate() {
            let table = benchmark(uncertainty.clone());
            let weights = Weights {
                tool: wider(&table.tool),
                front: wider(&table.front),
                rear: wider(&table.rear),
                current_limit_a: 1e4 * table.current_limit_a,
                ..table
            }
            .on(&machine)
            .unwrap();
            let found = mu_at_speed(&machine, &weights, &[], &law, 0.0).unwrap();
            let at = |(hz, h, k): &(f64, Mat<c64>, Mat<c64>)| {
                let omega = TAU * hz;
                let theta = 0.5 * omega * period_s;
                let hold = theta.sin() / theta;
                let pick = |m: &Mat<c64>, rows: [usize; 2], columns: [usize; 2]| {
                    Mat::from_fn(2, 2, |i, j| m[(rows[i], columns[j])])
                };
                let (signals, forces, places) = ([0, 2], [6, 8], [6, 8]);
                let g = pick(h, signals, signals) * faer::Scale(c64::new(hold, 0.0));
                let k = pick(k, signals, signals);
                let one = Mat::<c64>::identity(2, 2);
                let r = &k * solve_complex(&(&one - &g * &k), &one);
                match kind {
                    0 | 2 => {
                        let x = omega * uncertainty.delay_s;
                        let size = match kind {
                            0 => uncertainty.force_constant,
                            _ => x / (1.0 + x * x / 12.0).sqrt(),
                        };
                        // What the loop gives back of a current.
                        (&r * &g) * faer::Scale(c64::new(size, 0.0))
                    }
                    _ => {
                        let drive = pick(h, places, signals) * faer::Scale(c64::new(hold, 0.0));
                        let closed = pick(h, places, forces) + drive * (&r * pick(h, signals, forces));
                        Mat::from_fn(2, 2, |i, j| closed[(i, j)] * ks[j] * uncertainty.negative_stiffness)
                    }
                }
            };
            let own = lines
                .iter()
                .map(|line| (of_two(&at(line), &turns), line.0))
                .fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
            // The lines of both roads differ; performance ten thousand times as wide adds a thousandth.
            assert!(
                (found.mu / own.0 - 1.0).abs() < 0.01,
                "{} rpm, kind {kind}: {} at {} Hz, {} at {} Hz",
                machine.spindle.max_rpm,
                found.mu,
                found.frequency_hz,
                own.0,
                own.1
            );
        }
    }
}

#[test]
fn the_cover_of_a_delay_is_above_its_error_and_touches_it_at_low_frequency() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let delay_s = 3e-5;
    let weights = benchmark(Uncertainty { delay_s, ..Uncertainty::default() });
    let plane = design_plane(&machine, 4, &[], Route::Emulation { pade_order: 3 }).unwrap();
    let problem = generalized_plane(&plane, &[], &weights, WeightPlane::Laplace).unwrap();
    let first_current = problem.disturbances();
    for k in 1..=200 {
        let x = PI * f64::from(k) / 200.0;
        // The first error reads the front current.
        let read = problem.system.at(x / delay_s)[(0, first_current)].norm();
        let cover = read * weights.current_limit_a;
        let error = 2.0 * (0.5 * x).sin();
        assert!(cover >= error, "{x}: {cover} {error}");
        assert!(x > 0.3 || cover < error * 1.001, "{x}: {cover} {error}");
    }
}

#[test]
fn negative_stiffness_of_no_machine_is_an_error() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let weights = benchmark(Uncertainty { negative_stiffness: 0.1, ..Uncertainty::default() });
    let plane = design_plane(&machine, 4, &[], Route::Emulation { pade_order: 3 }).unwrap();
    let problem = |weights: &Weights| generalized_plane(&plane, &[], weights, WeightPlane::Laplace);
    assert!(problem(&weights).is_err());
    assert!(problem(&weights.on(&machine).unwrap()).is_ok());
}

#[test]
fn a_file_says_what_is_uncertain_and_is_refused_with_its_key() {
    let table = std::fs::read_to_string(format!("{}/weights/benchmark.yaml", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let with = |lines: &str| read_weights("own.yaml", &format!("{table}\nuncertainty:\n{lines}"));
    let read = with("  actuator: {low: 0.02, high: 0.5, crossover_hz: 2000}\n  delay_s: 1.0e-5\n");
    let uncertainty = read.unwrap().uncertainty;
    assert_eq!(uncertainty.delay_s, 1e-5);
    let level = Shape::level_change(0.02, 0.5, 2000.0).unwrap();
    assert_eq!(uncertainty.actuator, Some(level));
    assert!(uncertainty.sensor.is_none());
    for (lines, key) in [
        ("  force_constant: 1.5\n", "uncertainty.force_constant"),
        ("  negative_stiffness: -0.1\n", "uncertainty.negative_stiffness"),
        ("  delay_s: 0\n", "uncertainty.delay_s"),
        ("  sensor: {low_m_per_a: 0, high_m_per_a: 1.0e-7, crossover_hz: 100}\n", "uncertainty.sensor.low_m_per_a"),
    ] {
        let message = with(lines).unwrap_err().to_string();
        assert!(message.contains(key), "{message}");
    }
}
