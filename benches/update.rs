//! One objective evaluation of model updating (poles, antiresonances, matching, Eq. 7) on the reference spindle, and
//! whole fits. Reference on one core: scipy's dense eigenvalues 3.1 ms, ROSS 300 ms. Aim: 0.3 ms.

use criterion::{Criterion, criterion_group, criterion_main};
use muspin::input::{load_machine, load_measurement};
use muspin::rotor::chain_assembly;
use muspin::rotor::spectrum::{Query, spectrum};
use muspin::update::{Target, UpdateSettings, front_and_rear, gauss_newton, nelder_mead};
use std::hint::black_box;

fn update(c: &mut Criterion) {
    let machine = load_machine("reference", "paper-tool").expect("shipped files");
    let rotor = machine.rotor().expect("shipped files");
    let chain = chain_assembly::chain(&rotor).expect("a rotor is a chain");
    let frfs = machine
        .effective()
        .bearings
        .map(|b| {
            let port = |z| chain_assembly::port(&rotor, "plane", z).expect("on the rotor");
            (port(b.sensor_m), port(b.actuator_m))
        })
        .to_vec();
    let query = Query { frfs, from_hz: 100.0, to_hz: 5500.0 };
    let factors = vec![0.9; chain.regions.len()];
    c.bench_function("objective: poles and antiresonances, full FE", |b| {
        b.iter(|| spectrum(&chain, black_box(&factors), &query));
    });
    let read = load_measurement("paper-frequencies").expect("shipped files");
    let list = |l: &[Option<f64>]| l.iter().map(|f| f.map(Target::read_off)).collect();
    let f = &read.frequencies[0];
    let targets = front_and_rear(&machine, list(&f.resonances_hz), list(&f.front_hz), list(&f.rear_hz));
    let settings = UpdateSettings::default();
    c.bench_function("Gauss-Newton, eight published frequencies", |b| {
        b.iter(|| gauss_newton(&machine, black_box(&targets), &settings));
    });
    let mut group = c.benchmark_group("slow");
    group.sample_size(10);
    group.bench_function("Nelder-Mead, 500 iterations", |b| {
        b.iter(|| nelder_mead(&machine, black_box(&targets), &settings));
    });
    group.finish();
}

criterion_group!(benches, update);
criterion_main!(benches);
