//! Exact frequencies of rotors with random modulus factors, eight for fifteen unknowns, and the tool's FRF that no fit has
//! seen: what is left is what eight frequencies do not say, at any strength of the prior.

use muspin::input::load_machine;
use muspin::rotor::{PlanarModes, Rotor};
use muspin::spindle::Machine;
use muspin::update::{Target, UpdateSettings, front_and_rear, gauss_newton};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

fn receptance(rotor: &Rotor) -> Vec<f64> {
    let modes = PlanarModes::new(rotor).unwrap();
    let tool = modes.amplitudes(&rotor.shape_at("tool", rotor.from_m()).unwrap());
    (40..=800)
        .map(|k| {
            let w = TAU * 5.0 * k as f64;
            let (mut hr, mut hi) = (0.0, 0.0);
            for (wn, phi) in modes.omega_rad_s.iter().zip(&tool) {
                let (a, b) = (wn * wn - w * w, 0.01 * wn * w);
                hr += phi * phi * a / (a * a + b * b);
                hi -= phi * phi * b / (a * a + b * b);
            }
            20.0 * f64::hypot(hr, hi).log10()
        })
        .collect()
}

fn apart_db(a: &Rotor, b: &Rotor) -> f64 {
    let (a, b) = (receptance(a), receptance(b));
    let sum: f64 = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum();
    (sum / a.len() as f64).sqrt()
}

fn truth(nominal: &Machine, seed: u64, sd: f64) -> Machine {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || {
        let (a, b): (f64, f64) = (rng.random(), rng.random());
        (-2.0 * (1.0 - a).ln()).sqrt() * (TAU * b).cos()
    };
    let mut machine = nominal.clone();
    for s in &mut machine.spindle.sections {
        if s.region.is_some() {
            s.modulus_scale *= (sd * normal()).exp();
        }
    }
    machine
}

/// Root mean square errors of the tool's FRF, dB: of the nominal rotor, and after updating with prior standard deviations
/// of ln θ, the noise known to be next to nothing or estimated.
fn errors_db(nominal: &Machine, truth: &Machine) -> (f64, Vec<f64>, f64) {
    let once = UpdateSettings { max_evaluations: 1, ..Default::default() };
    // The spectrum reaches as far as the targets do.
    let some = [1165.0, 2304.0, 3425.0].map(|f| Some(Target::read_off(f)));
    let targets = front_and_rear(truth, some.to_vec(), vec![], vec![]);
    let spectrum = gauss_newton(truth, &targets, &once).unwrap().fit.before;
    // Below 100 Hz lie no antiresonances of a free rotor that a fit counts.
    let pick = |all: &[f64], n: usize| -> Vec<f64> {
        let flexible = all.iter().copied().filter(|f| *f > 100.0);
        flexible.take(n).collect()
    };
    let lists = [pick(&spectrum.poles_hz, 3), pick(&spectrum.zeros_hz[0], 3), pick(&spectrum.zeros_hz[1], 2)];
    let given = |relative: Option<f64>| {
        let target = |f: &f64| Target::free(*f, relative.map(|r| r * f));
        let one = |l: &Vec<f64>| l.iter().map(|f| Some(target(f))).collect::<Vec<_>>();
        front_and_rear(nominal, one(&lists[0]), one(&lists[1]), one(&lists[2]))
    };
    let shown = truth.rotor().unwrap();
    let after = |relative: Option<f64>, prior_sd_ln: f64| {
        let settings = UpdateSettings { prior_sd_ln, ..Default::default() };
        let updated = gauss_newton(nominal, &given(relative), &settings).unwrap();
        assert!(updated.fit.explanation.explained);
        apart_db(&updated.fit.rotor, &shown)
    };
    let known = [0.5, 1.1, 4.0].map(|sd| after(Some(1e-4), sd));
    let estimated = after(None, UpdateSettings::default().prior_sd_ln);
    (apart_db(&nominal.rotor().unwrap(), &shown), known.to_vec(), estimated)
}

#[test]
fn the_strength_of_the_prior_does_not_matter_for_exact_data() {
    let nominal = load_machine("reference", "paper-tool").unwrap();
    for spread in [0.1, 0.2] {
        let (mut before, mut known, mut estimated) = (0.0, [0.0; 3], 0.0);
        for seed in 0..8 {
            let (nominal_db, known_db, estimated_db) = errors_db(&nominal, &truth(&nominal, 100 + seed, spread));
            before += nominal_db / 8.0;
            estimated += estimated_db / 8.0;
            known.iter_mut().zip(&known_db).for_each(|(sum, db)| *sum += db / 8.0);
            // A strength that is told from the data would choose among these.
            for db in &known_db {
                assert!((db - known_db[1]).abs() < 0.03 + 0.1 * known_db[1], "{known_db:?}");
            }
        }
        println!("spread {spread}: {before:.3} dB, {known:.3?}, noise estimated {estimated:.3}");
        assert!(known[1] < 0.1 * before, "{} of {before} dB", known[1]);
        assert!(estimated < 0.1 * before, "{estimated} of {before} dB");
    }
}
