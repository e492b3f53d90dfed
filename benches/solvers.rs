//! Riccati, norm and synthesis times on one thread, and synthesis on two: `cargo bench --bench solvers`.
//! Plants: lightly damped rotors on magnetic bearings, built from formulas, so that nothing is read.

use criterion::{Criterion, criterion_group, criterion_main};
use muspin::augment::GeneralizedPlant;
use muspin::linalg::Mat;
use muspin::linalg::riccati::{RiccatiEffort, care_with};
use muspin::lti::norm::hinf_norm;
use muspin::lti::{Continuous, StateSpace};
use muspin::robust::{HinfSettings, synthesise};
use std::hint::black_box;

/// Modes from 30 to 9000 rad/s of damping 1e-3; the first pair is made unstable by the magnets.
fn rotor(n: usize, unstable: bool) -> Mat<f64> {
    let modes = n / 2;
    Mat::from_fn(n, n, |i, j| {
        if i / 2 != j / 2 {
            return 0.0;
        }
        let ratio = (i / 2) as f64 / (modes.max(2) - 1) as f64;
        let w = 30.0 * 300f64.powf(ratio);
        let sign = if unstable && i / 2 == 0 { 1.0 } else { -1.0 };
        match (i % 2, j % 2) {
            (0, 1) => w,
            (1, 0) => sign * w,
            (1, 1) => -2e-3 * w,
            _ => 0.0,
        }
    })
}

fn spread(rows: usize, cols: usize, seed: f64) -> Mat<f64> {
    Mat::from_fn(rows, cols, |i, j| ((3 * i + 7 * j) as f64 + seed).sin())
}

fn plant(n: usize, channels: usize) -> GeneralizedPlant {
    let c = channels;
    let b = Mat::from_fn(n, 3 * c, |i, j| {
        if i % 2 == 1 && !(c..2 * c).contains(&j) { 100.0 * ((i * (j % c + 1)) as f64).cos() } else { 0.0 }
    });
    let read = Mat::from_fn(3 * c, n, |i, j| {
        if j % 2 == 0 && !(c..2 * c).contains(&i) { ((j * (i % c + 1)) as f64).cos() } else { 0.0 }
    });
    let d = Mat::from_fn(3 * c, 3 * c, |i, j| match (i, j) {
        (i, j) if (c..2 * c).contains(&i) && j >= 2 * c && i - c == j - 2 * c => 0.1,
        (i, j) if i >= 2 * c && (c..2 * c).contains(&j) && i - 2 * c == j - c => 0.1,
        _ => 0.0,
    });
    GeneralizedPlant {
        system: StateSpace::new(rotor(n, true), b, read, d, Continuous).expect("shapes fit"),
        controls: c,
        measurements: c,
        blocks: vec![],
    }
}

/// The allocator of the program.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn solvers(c: &mut Criterion) {
    let this = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    this.build_global().expect("nothing ran in parallel before");
    for n in [14, 28, 60] {
        let (b, q) = (spread(n, 3, 0.3), spread(3, n, 0.7));
        let (a, g, q) = (rotor(n, true), &b * b.transpose(), q.transpose() * &q);
        c.bench_function(&format!("care exact n={n}"), |bench| {
            bench.iter(|| black_box(care_with(&a, &g, &q, RiccatiEffort::Full)));
        });
        c.bench_function(&format!("care fast n={n}"), |bench| {
            bench.iter(|| black_box(care_with(&a, &g, &q, RiccatiEffort::Fast)));
        });
    }
    for n in [20, 60] {
        let s = StateSpace::new(rotor(n, false), spread(n, 2, 0.1), spread(2, n, 0.2), Mat::zeros(2, 2), Continuous)
            .expect("shapes fit");
        c.bench_function(&format!("hinfnorm n={n}"), |bench| {
            bench.iter(|| black_box(hinf_norm(&s, 1e-9)));
        });
    }
    let two = rayon::ThreadPoolBuilder::new().num_threads(2).build();
    let two = two.expect("two threads start");
    for (n, channels) in [(6, 1), (14, 2), (28, 4), (36, 4)] {
        let p = plant(n, channels);
        synthesise(&p, &HinfSettings::default()).expect("the plant has a controller");
        c.bench_function(&format!("hinfsyn n={n}"), |bench| {
            bench.iter(|| black_box(synthesise(&p, &HinfSettings::default())));
        });
        c.bench_function(&format!("hinfsyn n={n}, two threads"), |bench| {
            two.install(|| bench.iter(|| black_box(synthesise(&p, &HinfSettings::default()))));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = solvers
}
criterion_main!(benches);
