//! μ bounds of random matrices, D-scale fits, and whole D-K iterations.

use criterion::{Criterion, criterion_group, criterion_main};
use muspin::augment::{Block, GeneralizedPlant};
use muspin::linalg::{Mat, c64};
use muspin::lti::{Continuous, StateSpace};
use muspin::robust::dfit::{Magnitudes, fit_quick};
use muspin::robust::dk::{DkSettings, iterate};
use muspin::robust::mu;
use rand::{Rng, SeedableRng};
use serde_json::Value;
use std::hint::black_box;

/// The allocator of the program.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn random(n: usize) -> Mat<c64> {
    let mut source = rand_chacha::ChaCha8Rng::seed_from_u64(n as u64);
    let mut draw = || 2.0 * source.random::<f64>() - 1.0;
    Mat::from_fn(n, n, |_, _| c64::new(draw(), draw()))
}

fn case(path: &str) -> Value {
    let file = format!("{}/tests/data/control/{path}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(file).expect("the case is in the repository");
    serde_json::from_str(&text).expect("the case is JSON")
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().into_iter().flatten();
    list.filter_map(Value::as_f64).collect()
}

fn matrix(value: &Value) -> Mat<f64> {
    let rows: Vec<Vec<f64>> = value.as_array().into_iter().flatten().map(numbers).collect();
    Mat::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

fn plant(path: &str) -> GeneralizedPlant {
    let data = &case(path)["data"];
    let part = |key: &str| matrix(&data[key]);
    let size = |b: &Value, key: &str| b[key].as_u64().expect("block size") as usize;
    let blocks = data["blocks"].as_array().expect("blocks").iter();
    GeneralizedPlant {
        system: StateSpace::new(part("A"), part("B"), part("C"), part("D"), Continuous).expect("shapes fit"),
        controls: size(data, "m2"),
        measurements: size(data, "p2"),
        blocks: blocks.map(|b| Block::ComplexFull { rows: size(b, "rows"), cols: size(b, "cols") }).collect(),
    }
}

fn bounds(c: &mut Criterion) {
    for n in [4, 8, 16] {
        let (m, blocks) = (random(n), vec![Block::ComplexScalar { n: 1 }; n]);
        c.bench_function(&format!("mu upper {n}x{n}"), |b| {
            b.iter(|| mu::upper_bound(black_box(&m), &blocks).map(|u| u.0))
        });
        c.bench_function(&format!("mu both {n}x{n}"), |b| {
            b.iter(|| mu::bounds(black_box(&m), &blocks).map(|u| u.upper))
        });
    }
}

fn fits(c: &mut Criterion) {
    let data = &case("dfit/skogestad_iter0")["data"];
    let omega = numbers(&data["omega"]);
    let ones = vec![1.0; omega.len()];
    let data = Magnitudes::new(omega, numbers(&data["magnitude"]), ones).expect("good data");
    c.bench_function("D fit order 4", |b| b.iter(|| fit_quick(black_box(&data), 4)));
}

fn iterations(c: &mut Criterion) {
    let mut group = c.benchmark_group("D-K");
    group.sample_size(10);
    for name in ["skogestad_column", "amb_1plane"] {
        let plant = plant(&format!("dk/{name}"));
        let settings = DkSettings { fit_range_rad_s: Some((1e-3, 1e5)), descent_steps: 0, ..DkSettings::default() };
        group
            .bench_function(name, |b| b.iter(|| iterate(black_box(&plant), &settings, &mut |_| {}).map(|o| o.mu_peak)));
    }
    group.finish();
}

criterion_group!(benches, bounds, fits, iterations);
criterion_main!(benches);
