//! Weights of true frequency in the w plane, and μ of the whole machine against a second road of its own: exact
//! frequency responses of the full model, hold and delay and weights in closed form, the loop closed by hand.

use muspin::augment::Block;
use muspin::augment::assembly::{UncertainMode, generalized_plane, unscale_controller};
use muspin::augment::plane::{Route, design_plane, modes_below_nyquist};
use muspin::augment::shape::Shape;
use muspin::augment::warp::inverse_hold;
use muspin::augment::weight_plane::{WeightPlane, fit_errors};
use muspin::augment::weighting::WeightSection;
use muspin::augment::weights::Weights;
use muspin::input::{load_machine, load_weights};
use muspin::linalg::{Mat, c64};
use muspin::lti::sample::tustin;
use muspin::lti::{Continuous, Discrete, Response, StateSpace};
use muspin::pipeline::certificates::peak;
use muspin::pipeline::problems::whole_machine;
use muspin::pipeline::speed_mu::mu_at_speed;
use muspin::predict::closed_loop::both_planes;
use muspin::robust::hinf::{HinfSettings, synthesise};
use muspin::robust::mu::upper_bound;
use muspin::robust::prescale::{ScaleStart, constant_scales, scale_signals};
use muspin::spindle::plant::CHANNELS;
use muspin::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::{PI, TAU};

/// True frequencies from a thousandth of Nyquist to Nyquist, as shares of it.
fn shares() -> impl Iterator<Item = f64> {
    (0..400).map(|k| 10f64.powf(-3.0 * f64::from(k) / 400.0) * (1.0 - 1e-9))
}

/// |W| in the w plane at a share of the Nyquist frequency.
fn at_share(system: &StateSpace<Continuous>, share: f64, period_s: f64) -> f64 {
    system.at(2.0 / period_s * (0.5 * PI * share).tan())[(0, 0)].norm()
}

#[test]
fn fitted_weights_have_their_magnitude_over_true_frequency() {
    for rate_hz in [8e3, 10e3, 20e3, 40e3] {
        let period_s = 1.0 / rate_hz;
        for section in [
            WeightSection::roll_on_stage(3000.0, 10.0).unwrap(),
            WeightSection::level_change(40.0, 5.0, 40.0).unwrap(),
            WeightSection::level_change(1e5, 1e4, 2500.0).unwrap(),
            WeightSection::leaky_integrator(1e8, 0.03).unwrap(),
        ] {
            let of = |plane: WeightPlane| plane.realise(&Shape::section(section)).unwrap();
            let fit = of(WeightPlane::Analysis { period_s });
            assert!(fit.largest_excess <= 0.005, "{section:?} {rate_hz}");
            // The synthesis reads the section at the frequencies of the w plane and says by how much that is more than
            // written.
            let read = of(WeightPlane::Synthesis { period_s });
            for share in shares() {
                let written = section.magnitude(share * PI * rate_hz);
                let ratio = at_share(&fit.system, share, period_s) / written;
                let most = 1.0 + fit.largest_excess;
                assert!((1.0..most).contains(&ratio), "{section:?} {rate_hz} {share} {ratio}");
                let v = 2.0 / period_s * (0.5 * PI * share).tan();
                let synthesis = at_share(&read.system, share, period_s);
                assert!((synthesis / section.magnitude(v) - 1.0).abs() < 1e-9);
            }
            let largest = (1..20_000).map(f64::from).fold(0.0f64, |largest, k| {
                let share = k / 20_000.0;
                let written = section.magnitude(share * PI * rate_hz);
                largest.max(at_share(&read.system, share, period_s) / written - 1.0)
            });
            // Ten times as many lines: a smooth maximum between two of the fewer is missed by 1e-5 of it.
            assert!((read.largest_excess - largest).abs() < 1e-4 * (1.0 + largest));
        }
        let hold = inverse_hold(period_s, 0.02).unwrap();
        assert!(hold.largest_excess <= 0.02);
        for share in shares() {
            let theta = 0.5 * PI * share;
            let ratio = at_share(&hold.system, share, period_s) * theta.sin() / theta;
            assert!((1.0..1.0 + hold.largest_excess).contains(&ratio), "{share} {ratio}");
        }
    }
    // Without the fit the control weight of 3 kHz is three times too large at 8 kHz of 20 kHz.
    let stage = WeightSection::roll_on_stage(3000.0, 10.0).unwrap();
    let plain = at_share(&stage.system().unwrap(), 0.8, 5e-5).powi(2);
    assert!(plain / stage.magnitude(TAU * 8e3).powi(2) > 3.0);
    let errors = fit_errors(&load_weights("benchmark").unwrap(), 5e-5).unwrap();
    assert!(errors.analysis < 0.011, "{errors:?}");
}

fn uncertain(machine: &Machine, weights: &Weights) -> Vec<UncertainMode> {
    let modes = modes_below_nyquist(machine).unwrap();
    let listed = modes.iter().zip(&weights.mode_uncertainty).enumerate();
    listed
        .map(|(number, (omega, relative))| UncertainMode { number, omega_rad_s: *omega, relative: *relative })
        .collect()
}

/// Plain H∞ controller with constant scales: of one plane in scaled signals of the w plane, and of four axes, sampled.
fn controller(
    machine: &Machine,
    weights: &Weights,
    modes: &[UncertainMode],
) -> (StateSpace<Continuous>, StateSpace<Discrete>) {
    let period_s = machine.spindle.electronics.sample_period_s();
    let numbers: Vec<usize> = modes.iter().map(|m| m.number).collect();
    let flexible = machine.spindle.flexible_modes + 1;
    let plane = design_plane(machine, flexible, &numbers, Route::Direct).unwrap();
    let posed = generalized_plane(&plane, modes, weights, WeightPlane::Synthesis { period_s }).unwrap();
    let start = vec![100.0; modes.len()];
    let scales = constant_scales(&posed, ScaleStart::Guess(&start)).unwrap().scale;
    let full = |b: &Block| Block::ComplexFull { rows: b.rows(), cols: b.cols() };
    let mut plant = scale_signals(&posed, &scales);
    plant.blocks = plant.blocks.iter().map(full).collect();
    let found = synthesise(&plant, &HinfSettings::default()).unwrap().controller;
    let law = tustin(&unscale_controller(&found), period_s).unwrap();
    (found, both_planes(&law))
}

/// |W(jω)| of a first-order weight by its definition.
fn level(omega: f64, dc: f64, hf: f64, crossover_hz: f64) -> f64 {
    let p = TAU * crossover_hz * (hf / dc).sqrt();
    (hf * omega).hypot(dc * p) / omega.hypot(p)
}

/// μ upper bound of Table 2 at one frequency on the full model at rest, closed by hand.
fn second_road(
    machine: &Machine,
    weights: &Weights,
    modes: &[UncertainMode],
    law: &StateSpace<Discrete>,
    frequency_hz: f64,
) -> f64 {
    let omega = TAU * frequency_hz;
    let period_s = machine.spindle.electronics.sample_period_s();
    let plant = Plant::new(machine, 0.0, ModelDetail::Full).unwrap();
    let h = plant.with_modal_ports(modes.len()).at(omega);
    let theta = 0.5 * omega * period_s;
    let hold = theta.sin() / theta;
    let k = law.at(omega);
    let m = modes.len();
    let place = |i: usize| {
        if i < m { CHANNELS + 2 * i } else { 4 + 2 * (i - m) }
    };
    let axis = [0, 2];
    // L = G_yu K; R = K (I − L)⁻¹ by Cramer.
    let g_yu = |i: usize, j: usize| h[(axis[i], axis[j])] * hold;
    let kk = |i: usize, j: usize| k[(axis[i], axis[j])];
    let product =
        |a: &dyn Fn(usize, usize) -> c64, b: &dyn Fn(usize, usize) -> c64, i, j| a(i, 0) * b(0, j) + a(i, 1) * b(1, j);
    let one = |i: usize, j: usize| c64::new(if i == j { 1.0 } else { 0.0 }, 0.0);
    let difference = |i: usize, j: usize| one(i, j) - product(&g_yu, &kk, i, j);
    let det = difference(0, 0) * difference(1, 1) - difference(0, 1) * difference(1, 0);
    let inverse = |i: usize, j: usize| match (i, j) {
        (0, 0) => difference(1, 1) / det,
        (1, 1) => difference(0, 0) / det,
        _ => -difference(i, j) / det,
    };
    let r = |i: usize, j: usize| product(&kk, &inverse, i, j);
    let n = m + 3;
    let y_from = |i: usize, j: usize| h[(axis[i], place(j))];
    let to_from_u = |i: usize, j: usize| h[(place(i), axis[j])] * hold;
    let closed = |i: usize, j: usize| -> c64 {
        let u_from = |a: usize| {
            if j < n { r(a, 0) * y_from(0, j) + r(a, 1) * y_from(1, j) } else { r(a, j - n) }
        };
        if i >= n {
            return u_from(i - n);
        }
        let open = if j < n { h[(place(i), place(j))] } else { c64::new(0.0, 0.0) };
        open + to_from_u(i, 0) * u_from(0) + to_from_u(i, 1) * u_from(1)
    };
    let limits = [&weights.tool, &weights.front, &weights.rear];
    let modal = |i: usize| (2.0 * modes[i].relative).sqrt() * modes[i].omega_rad_s;
    let input = |j: usize| match j {
        j if j < m => modal(j),
        j if j < n => {
            let l = limits[j - m];
            level(omega, l.max_dc_load_n, l.max_hf_load_n, weights.load_crossover_hz[j - m])
        }
        _ => weights.sensor_noise_m,
    };
    let (w1, ratio) = (TAU * weights.current_rolloff_hz, weights.current_rolloff_ratio);
    let output = |i: usize| match i {
        i if i < m => modal(i),
        i if i < n => {
            let l = limits[i - m];
            let (dc, hf) = (1.0 / l.max_dc_displacement_m, 1.0 / l.max_hf_displacement_m);
            level(omega, dc, hf, weights.displacement_crossover_hz[i - m])
        }
        _ => {
            let above = 1.0 + (omega / w1).powi(2);
            above / (1.0 + (omega / w1 / ratio).powi(2)) / weights.current_limit_a
        }
    };
    let loop_response = Mat::from_fn(n + 2, n + 2, |i, j| output(i) * closed(i, j) * input(j));
    let mut blocks = vec![Block::ComplexScalar { n: 1 }; m];
    blocks.push(Block::ComplexFull { rows: 5, cols: 5 });
    upper_bound(&loop_response, &blocks).unwrap().0
}

#[test]
fn the_certified_mu_is_not_below_that_of_the_exact_responses() {
    let weights = load_weights("benchmark").unwrap();
    let own = format!("{}/tests/data/spindles/s09-four-modes.yaml", env!("CARGO_MANIFEST_DIR"));
    for (spindle, tool) in [("reference", "paper-tool"), (own.as_str(), "endmill-16")] {
        let machine = load_machine(spindle, tool).unwrap();
        let modes = uncertain(&machine, &weights);
        let count = modes_below_nyquist(&machine).unwrap().len();
        assert!(count > machine.spindle.flexible_modes + 1);
        let (scaled_plane, law) = controller(&machine, &weights, &modes);
        let whole = whole_machine(&machine, &weights, count, &modes).unwrap();
        let certified = peak("test", &whole, &scaled_plane).unwrap();
        let exact = mu_at_speed(&machine, &weights, &modes, &law, 0.0).unwrap();
        let fits = fit_errors(&weights, whole_period(&machine)).unwrap();
        // What the fits add: weights at both ends of the loop, the inverse hold; a thousandth for the certificate.
        let most = (1.0 + fits.analysis).powi(2) * (1.0 + fits.hold) * (1.0 + 1e-3);
        let ratio = certified.upper / exact.mu;
        assert!((1.0..most).contains(&ratio), "{spindle}: {ratio} {most} {exact:?}");
        assert!(certified.bounds.lower <= certified.upper);
        let by_hand = second_road(&machine, &weights, &modes, &law, exact.frequency_hz.abs());
        assert!((by_hand / exact.mu - 1.0).abs() < 1e-6, "{by_hand} {exact:?}");
        // No line is above: not at the certified peak, nor on a grid of its own.
        let at_peak = (certified.omega_rad_s * 0.5 * whole_period(&machine)).atan() / PI / whole_period(&machine);
        let nyquist_hz = 0.5 / whole_period(&machine);
        let grid = (0..120).map(|k| nyquist_hz * 10f64.powf(-4.0 * (f64::from(k) + 0.5) / 120.0));
        for f in grid.chain([at_peak.min(0.999 * nyquist_hz)]) {
            let here = second_road(&machine, &weights, &modes, &law, f);
            assert!(here <= certified.upper, "{here} at {f} Hz, {}", certified.upper);
            // The peak lies between two lines of the grid that are dense round it. A bound ends within 1e-5 of its lower
            // bound, or where it gains no more: on single lines it has stood 2.1e-5 above one with its neighbour's scales.
            assert!(here <= exact.mu * (1.0 + 3e-5), "{here} at {f} Hz, {exact:?}");
        }
    }
}

fn whole_period(machine: &Machine) -> f64 {
    machine.spindle.electronics.sample_period_s()
}

#[test]
fn an_unstable_loop_has_no_mu() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let weights = load_weights("benchmark").unwrap();
    let modes = uncertain(&machine, &weights);
    // Without a controller the magnets' negative stiffness pulls the shaft into the backup bearings.
    let period_s = whole_period(&machine);
    let none = StateSpace::gain(Mat::zeros(4, 4), Discrete { period_s });
    let found = mu_at_speed(&machine, &weights, &modes, &none, 0.0).unwrap();
    assert!(found.mu.is_infinite() && found.frequency_hz.is_nan());
}

/// A sampled PD of four axes, 1.5 times as stiff as the magnets pull, with backward differences behind one pole at
/// 0.8 of the Nyquist frequency: its gain grows up to Nyquist.
fn sampled_pd(machine: &Machine, derivative_s: f64) -> StateSpace<Discrete> {
    let period_s = whole_period(machine);
    let bearings = [&machine.spindle.front, &machine.spindle.rear];
    let gain_a_per_m = bearings.map(|b| 1.5 * b.ks_n_per_m.abs() / b.ki_n_per_a);
    // (1 − a)(1 − 1/z)/(1 − a/z) = (1 − a)(1 − (1 − a)/(z − a)).
    let pole = (-0.8 * PI).exp();
    let derivative = derivative_s / period_s * (1.0 - pole);
    let diagonal = |of: &dyn Fn(usize) -> f64| Mat::from_fn(4, 4, |i, j| if i == j { of(i) } else { 0.0 });
    StateSpace::new(
        diagonal(&|_| pole),
        diagonal(&|_| 1.0),
        diagonal(&|i| gain_a_per_m[i / 2] * derivative * (1.0 - pole)),
        diagonal(&|i| -gain_a_per_m[i / 2] * (1.0 + derivative)),
        Discrete { period_s },
    )
    .unwrap()
}

#[test]
fn mu_is_sought_up_to_nyquist_and_not_beyond() {
    let table = load_weights("benchmark").unwrap();
    // The current caused by sensor noise outweighs everything else, and its weight grows up to Nyquist as the gain does.
    let weights = Weights {
        current_limit_a: 1e-6,
        current_rolloff_hz: 300.0,
        current_rolloff_ratio: 100.0,
        sensor_noise_m: 1e4 * table.sensor_noise_m,
        ..table
    };
    let own = |name: &str| {
        let root = env!("CARGO_MANIFEST_DIR");
        format!("{root}/tests/data/spindles/{name}.yaml")
    };
    for (spindle, tool, derivative_s) in [
        ("reference".to_owned(), "paper-tool", 1e-3),
        (own("s12-big-discs"), "endmill-16", 3e-4),
        (own("s04-noncollocated"), "paper-tool", 3e-4),
    ] {
        let machine = load_machine(&spindle, tool).unwrap();
        let law = sampled_pd(&machine, derivative_s);
        let found = mu_at_speed(&machine, &weights, &[], &law, 0.0).unwrap();
        assert!(found.mu.is_finite(), "{spindle}: the loop is unstable");
        let share = found.frequency_hz.abs() * 2.0 * whole_period(&machine);
        assert!((0.98..=1.0).contains(&share), "{spindle} {share}");
    }
}
