//! The cascade of a run-up against the variance of an oscillator in white noise and the unbalance response.

use muspin::controller::Controller;
use muspin::input::{load_controller, load_machine};
use muspin::predict::cascade::{Cascade, UNBALANCE_KG_M, line_rms};
use muspin::predict::loop_shape::unbalance_response;
use std::f64::consts::TAU;

#[test]
fn lines_of_an_oscillator_add_up_to_its_variance() {
    // m, c, k with 2 % damping at 500 Hz; a force of one-sided density S² per Hz gives x² = S²/(4 c k).
    let (m, zeta, omega) = (0.8, 0.02, TAU * 500.0);
    let (c, k) = (2.0 * zeta * omega * m, omega * omega * m);
    let force = 0.3;
    let density = |hz: f64| {
        let w = TAU * hz;
        force / (k - m * w * w).hypot(c * w)
    };
    let edges: Vec<f64> = (0..=200).map(|k| 20.0 * f64::from(k)).collect();
    let lines = line_rms(&edges, &density);
    assert_eq!(lines.len(), 200);
    let variance: f64 = lines.iter().map(|line| line * line).sum();
    let exact = force * force / (4.0 * c * k);
    assert!((variance / exact - 1.0).abs() < 5e-3, "{variance} {exact}");
    let largest = (0..200).max_by(|a, b| lines[*a].total_cmp(&lines[*b])).unwrap();
    assert!((24..=25).contains(&largest), "{largest}");
}

#[test]
fn the_line_of_the_speed_has_the_unbalance_and_the_others_do_not() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let controller: Controller = load_controller("results/reference/controller/discrete.json").unwrap();
    let cascade = Cascade::new(&machine, &controller, 48_000.0, [1.0, 2001.0]).unwrap();
    assert_eq!(cascade.speed_rpm.last(), Some(&48_000.0));
    let exact = unbalance_response(&machine, &controller, &cascade.speed_rpm).unwrap();
    for (k, rpm) in cascade.speed_rpm.iter().enumerate() {
        let line = ((rpm / 60.0 - 1.0) / 10.0) as usize;
        let lines = &cascade.rms_m[k];
        let rms = exact[k][0] * UNBALANCE_KG_M / 2f64.sqrt();
        assert!((cascade.unbalance_rms_m[k] / rms - 1.0).abs() < 1e-12);
        // What is left of the line is the noise, about that of its neighbours.
        let noise = (lines[line].powi(2) - rms * rms).max(0.0).sqrt();
        let beside = 0.5 * (lines[line - 1] + lines[line + 1]);
        assert!((noise / beside - 1.0).abs() < 0.1, "{rpm}: {noise} {beside}");
    }
}
