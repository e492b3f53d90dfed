//! Mistakes in records: each is put into a simulated record and has to be named with its fields; records without one
//! stay silent. Records come from the independent simulator with its own errors in ki, ks, gains, moduli and damping.

use crate::diagnose::generator::{Draw, Drawn, simulate};
use muspin::controller::Controller;
use muspin::identify::plausibility::{HammerQuantity, RecordFault, Signal};
use muspin::identify::{HammerFrf, Plausibility, SweepRecord, hammer_plausibility, open_loop, sweep_plausibility};
use muspin::input::{load_controller, load_machine};
use muspin::linalg::c64;
use muspin::spindle::Machine;
use std::f64::consts::TAU;
use std::sync::OnceLock;

fn data(path: &str) -> String {
    format!("{}/tests/data/{path}", env!("CARGO_MANIFEST_DIR"))
}

struct Rig {
    machine: Machine,
    controller: Controller,
    record: Drawn,
}

/// The reference spindle and one with sensors far from its actuators. Both records are the formal response of the
/// loop with the same PID, which need not levitate the second.
fn rigs() -> &'static [Rig; 2] {
    static RIGS: OnceLock<[Rig; 2]> = OnceLock::new();
    RIGS.get_or_init(|| {
        ["reference", "s04-noncollocated"].map(|name| {
            let file = data(&format!("spindles/{name}.yaml"));
            let spindle = if name == "reference" { name } else { &file };
            let machine = load_machine(spindle, "paper-tool").unwrap();
            let controller = load_controller(&data("identify/c03/pid.json")).unwrap();
            let record = drawn(&machine, &controller, 7);
            Rig { machine, controller, record }
        })
    })
}

fn drawn(machine: &Machine, controller: &Controller, seed: u64) -> Drawn {
    let lines: Vec<f64> = (0..60).map(|k| 40.0 * 100f64.powf(f64::from(k) / 59.0)).collect();
    let mut draw = Draw::new(seed);
    simulate(machine, controller, &[], None, 0.0, &lines, &mut draw)
}

fn of_sweep(rig: &Rig, record: &SweepRecord) -> Plausibility {
    let frf = open_loop(record).unwrap();
    sweep_plausibility("sweep-0.csv", &frf, &rig.machine, Some(&rig.controller)).unwrap()
}

fn of_hammer(rig: &Rig, record: &HammerFrf) -> Plausibility {
    hammer_plausibility("hammer-0.csv", record, 0, &rig.machine, &rig.controller).unwrap()
}

/// The sweep as somebody would have written it who made the mistake.
fn mistaken(record: &SweepRecord, fault: RecordFault) -> SweepRecord {
    let mut wrong = record.clone();
    if let RecordFault::Clock { factor } = fault {
        wrong.frequency_hz.iter_mut().for_each(|f| *f *= factor);
    }
    for (is_current, values, source) in
        [(true, &mut wrong.current, &record.current), (false, &mut wrong.signal, &record.signal)]
    {
        let concerns = |s: Signal| (s == Signal::Current) == is_current;
        for (at, value) in values.indexed_iter_mut() {
            let channel = at.3;
            let from = |k: usize| source[(at.0, at.1, at.2, k)];
            match fault {
                RecordFault::ChannelsSwapped { a, b, signal } if concerns(signal) => {
                    if channel == a {
                        *value = from(b);
                    } else if channel == b {
                        *value = from(a);
                    }
                }
                RecordFault::PlanesSwapped { signal } if concerns(signal) => {
                    *value = from((channel + 2) % 4);
                }
                RecordFault::Sign { channel: c, signal } if concerns(signal) && c.is_none_or(|c| c == channel) => {
                    *value = -*value;
                }
                RecordFault::Unit { signal, decades, channel: c }
                    if concerns(signal) && c.is_none_or(|c| c == channel) =>
                {
                    *value *= 10f64.powi(decades);
                }
                RecordFault::Conjugate => *value = value.conj(),
                _ => {}
            }
        }
    }
    wrong
}

const U: Signal = Signal::Current;
const Y: Signal = Signal::Displacement;
const H: Signal = Signal::Compliance;

fn unit(signal: Signal, decades: i32, channel: Option<usize>) -> RecordFault {
    RecordFault::Unit { signal, decades, channel }
}

#[test]
fn every_mistake_in_a_sweep_is_named_with_its_fields() {
    let sign = |signal, channel| RecordFault::Sign { channel, signal };
    let swapped = |signal, a, b| RecordFault::ChannelsSwapped { a, b, signal };
    let cases = [
        unit(Y, 6, None),
        unit(Y, 3, None),
        unit(U, 3, None),
        unit(Y, 3, Some(0)),
        unit(Y, 1, Some(2)),
        unit(U, 3, Some(3)),
        unit(U, -1, Some(1)),
        sign(Y, None),
        sign(Y, Some(0)),
        sign(U, Some(3)),
        swapped(Y, 0, 1),
        swapped(U, 2, 3),
        swapped(Y, 1, 3),
        RecordFault::PlanesSwapped { signal: Y },
        RecordFault::PlanesSwapped { signal: U },
        RecordFault::Conjugate,
        RecordFault::Clock { factor: 1e-3 },
        RecordFault::Clock { factor: TAU },
    ];
    let mut wrong = vec![];
    for rig in rigs() {
        let name = &rig.machine.spindle.name;
        for fault in cases {
            let found = of_sweep(rig, &mistaken(&rig.record.sweep, fault));
            if found.faults != [fault] || found.plausible() {
                wrong.push(format!("{name}: {fault:?} became {:?}", found.faults));
            }
            let statement = found.statement().unwrap_or_default();
            assert!(statement.starts_with("sweep-0.csv: the record is implausible: "));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn two_mistakes_in_one_sweep_are_both_named() {
    let swap = RecordFault::ChannelsSwapped { a: 0, b: 1, signal: Y };
    let rear = RecordFault::ChannelsSwapped { a: 2, b: 3, signal: Y };
    let cases = [
        [unit(Y, 6, None), swap],
        [unit(U, 3, None), RecordFault::Conjugate],
        [unit(Y, 3, Some(0)), unit(Y, 3, Some(1))],
        [swap, rear],
    ];
    for rig in rigs() {
        for [a, b] in cases {
            let record = mistaken(&mistaken(&rig.record.sweep, b), a);
            let found = of_sweep(rig, &record);
            assert_eq!(found.faults, [a, b], "{}", rig.machine.spindle.name);
        }
    }
}

#[test]
fn a_machine_off_by_its_tolerances_is_plausible() {
    for (r, rig) in rigs().iter().enumerate() {
        for seed in 0..12 {
            let mut draw = Draw::new(100 * r as u64 + seed);
            let mut other = Rig {
                machine: rig.machine.clone(),
                controller: rig.controller.clone(),
                record: drawn(&rig.machine, &rig.controller, seed),
            };
            let spindle = &mut other.machine.spindle;
            for bearing in [&mut spindle.front, &mut spindle.rear] {
                bearing.ki_n_per_a *= 1.0 + 0.04 * draw.normal();
                bearing.ks_n_per_m *= 1.0 + 0.08 * draw.normal();
                bearing.sensor_gain *= 1.0 + 0.03 * draw.normal();
            }
            for section in &mut spindle.sections {
                section.modulus_scale *= draw.uniform(0.75, 1.25);
            }
            let sweep = of_sweep(&other, &other.record.sweep);
            assert!(sweep.plausible(), "{seed}: {:?}", sweep.statement());
            let hammer = of_hammer(&other, &other.record.hammer);
            assert!(hammer.plausible(), "{seed}: {:?}", hammer.statement());
        }
    }
}

#[test]
fn every_mistake_in_a_hammer_test_is_named() {
    let rig = &rigs()[0];
    let right = &rig.record.hammer;
    let changed = |each: &dyn Fn(f64, c64) -> c64, clock: f64| {
        let mut record = right.clone();
        for (f, h) in record.frequency_hz.iter_mut().zip(&mut record.compliance) {
            *h = each(*f, *h);
            *f *= clock;
        }
        record
    };
    let sign = RecordFault::Sign { channel: None, signal: H };
    let j_omega = |f: f64| c64::new(0.0, TAU * f);
    let cases: [(RecordFault, HammerFrf); 8] = [
        (unit(H, 6, None), changed(&|_, h| 1e6 * h, 1.0)),
        (unit(H, -3, None), changed(&|_, h| 1e-3 * h, 1.0)),
        (sign, changed(&|_, h| -h, 1.0)),
        (RecordFault::Conjugate, changed(&|_, h| h.conj(), 1.0)),
        (RecordFault::Clock { factor: 1e-3 }, changed(&|_, h| h, 1e-3)),
        (RecordFault::Clock { factor: TAU }, changed(&|_, h| h, TAU)),
        (RecordFault::Quantity(HammerQuantity::Mobility), changed(&|f, h| h * j_omega(f), 1.0)),
        (RecordFault::Quantity(HammerQuantity::Accelerance), changed(&|f, h| h * j_omega(f) * j_omega(f), 1.0)),
    ];
    for (fault, record) in cases {
        let found = of_hammer(rig, &record);
        assert_eq!(found.faults, [fault]);
        assert!(!found.plausible());
    }
    let calibrated = of_hammer(rig, &changed(&|_, h| 1.15 * h, 1.0));
    assert!(calibrated.plausible(), "{:?}", calibrated.statement());
}

#[test]
fn a_record_of_another_kind_is_implausible_without_a_name() {
    let rig = &rigs()[0];
    let mut record = rig.record.sweep.clone();
    // Every line shows another frequency of the same machine: no unit, sign or order of channels makes that right.
    let lines = record.frequency_hz.len();
    let (current, signal) = (record.current.clone(), record.signal.clone());
    for (at, value) in record.current.indexed_iter_mut() {
        *value = current[(lines - 1 - at.0, at.1, at.2, at.3)];
    }
    for (at, value) in record.signal.indexed_iter_mut() {
        *value = signal[(lines - 1 - at.0, at.1, at.2, at.3)];
    }
    let found = of_sweep(rig, &record);
    assert!(found.faults.is_empty(), "{:?}", found.faults);
    let statement = found.statement().unwrap();
    assert!(statement.contains("no known mistake explains it"), "{statement}");
}
