//! What separates two explanations, and what a data set can show at all.

use crate::diagnose::diagnose_folder::read;
use crate::diagnose::generator::Draw;
use muspin::diagnose::Evidence;
use muspin::diagnose::data::evidence::Subset;
use muspin::diagnose::data::measurement::RecordSet;
use muspin::diagnose::decide::candidate::Candidate;
use muspin::diagnose::decide::detectability::{Detectable, detectable};
use muspin::diagnose::decide::next_measurement::proposals;
use muspin::diagnose::fit::case::Case;
use muspin::diagnose::fit::hypothesis::{Hypothesis, Scope, catalogue};
use muspin::diagnose::fit::model::Model;
use muspin::diagnose::fit::problem::Point;
use muspin::linalg::c64;
use muspin::spindle::{Bearings, Effect, EffectKind, Location};
use std::f64::consts::TAU;

/// The same place.
fn same_place(a: &Effect, b: &Effect) -> bool {
    a.location == b.location && (a.kind != EffectKind::HousingMode || a.values[1] == b.values[1])
}

/// How far an effect is from nothing.
fn size(effect: &Effect, kind: EffectKind) -> f64 {
    let value = effect.values[0];
    match kind {
        // Bandwidths, corners, stiffness of a joint and mass of a housing: the larger, the less.
        EffectKind::AmplifierBandwidth => (1.0 / value - 1.0 / 2000.0).abs(),
        EffectKind::EddyCurrents
        | EffectKind::LaminatedCore
        | EffectKind::SensorLowpass
        | EffectKind::ToolJoint
        | EffectKind::HousingMode => 1.0 / value,
        EffectKind::NegativeStiffness
        | EffectKind::ForceConstant
        | EffectKind::SensorGain
        | EffectKind::ModalDamping
        | EffectKind::RegionStiffness => (value - 1.0).abs(),
        _ => value.abs(),
    }
}

#[test]
fn a_tie_names_the_measurement_that_separates_and_coverage_gives_sizes() {
    let folder = read("c03");
    let mut measurement = RecordSet::default();
    measurement.sweeps.push(folder.sweep);
    let evidence = Evidence::new(&measurement).expect("evidence");
    let model = Model::new(&folder.machine, &evidence.axis_gain_sd()).expect("model");
    let scope = Scope { turning: false, first_rad_s: TAU * 40.0, top_rad_s: TAU * 4000.0 };
    let all =
        catalogue(&folder.machine, model.reduced.span_m(), model.reduced.flexible_rad_s(), scope).expect("catalogue");
    let search = Case { model: &model, evidence: &evidence, catalogue: &all, seeks_strong: true, progress: &|_| {} };
    let null = search.finish(&[], &search.origin(), 0.03, Subset::ALL).expect("null");
    // Two explanations of the same size, as a fit to a tie would leave them: 2 µs of delay in the loop, or of lag in all sensors.
    let member = |kind: EffectKind, place: Location, theta: f64| -> Candidate {
        let h: Hypothesis = all.iter().find(|h| h.kind == kind && h.place == place).expect("hypothesis").clone();
        let start = Point { p: null.fit.at.p.clone(), theta: vec![vec![theta]], smooth: null.fit.at.smooth };
        let mut candidate = search.finish(&[h], &start, 1e-3, Subset::ALL).expect("candidate");
        candidate.fit.at = start;
        candidate
    };
    let delay = member(EffectKind::LoopDelay, Location::None, 0.2);
    // A second-order low-pass at f delays by 1.414/(2π f): 2 µs at 112 kHz.
    let lag = member(EffectKind::SensorLowpass, Location::Bearing(Bearings::Both), 1e4 / 112_500.0);
    let same = proposals(&search, &[&delay, &delay]).expect("menu");
    assert!(same.iter().all(|p| p.separation < 1e-6), "{same:?}");
    let menu = proposals(&search, &[&delay, &lag]).expect("menu");
    for p in &menu {
        println!("{:12.1} {}", p.separation, p.text);
    }
    let of = |words: &str| menu.iter().find(|p| p.text.contains(words)).expect("in the menu").separation;
    // Another sweep of the same kind tells little, whatever the speed; without the command path they differ.
    assert!(of("coil currents measured") > 100.0);
    assert!(of("hammer") > 100.0);
    assert!(of("half the bias") < 0.1 * of("coil currents measured"));
    assert!(menu[0].separation >= menu[1].separation);

    let sizes = detectable(&search, &[], &null.fit.at).expect("sizes");
    for s in &sizes {
        println!("{:?} {:?} {:?}", s.effect.kind, s.effect.location, s.effect.values);
    }
    let delay = sizes.iter().find(|s| s.effect.kind == EffectKind::LoopDelay).expect("delay");
    assert!((1e-9..2e-6).contains(&delay.effect.values[0]), "{delay:?}");
    // A negative stiffness is a nuisance parameter, too, that these data know far better than its prior of 4 %: what
    // remains of ln f is (ln f/0.04)², and it has a name where that is beyond four prior deviations nine times in ten.
    for side in [Bearings::Front, Bearings::Rear] {
        let place = Location::Bearing(side);
        let is = |s: &&Detectable| s.effect.kind == EffectKind::NegativeStiffness && s.effect.location == place;
        let deviations = sizes.iter().find(is).expect("stiffness").named_from.values[0].ln() / 0.04;
        assert!((4.0 + 1.28 - 0.01..6.0).contains(&deviations), "{side:?}: {deviations}");
    }
    // Sixteen times the noise, in sweeps that are otherwise the same: no limit is smaller.
    let mut draw = Draw::new(16);
    for y in measurement.sweeps[0].signal.iter_mut() {
        let sd = 16.0 * 0.7e-9 / 2f64.sqrt();
        *y += c64::new(draw.normal(), draw.normal()) * sd;
    }
    let noisy = Evidence::new(&measurement).expect("evidence");
    let noisy = Case { evidence: &noisy, ..search };
    let larger = detectable(&noisy, &[], &null.fit.at).expect("sizes");
    for s in &sizes {
        let twin = |l: &&Detectable| l.effect.kind == s.effect.kind && same_place(&l.effect, &s.effect);
        let own = larger.iter().find(twin);
        let ratio = own.map(|l| size(&l.effect, s.effect.kind) / size(&s.effect, s.effect.kind));
        // What is beyond all bounds with the noise has no limit; what is a nuisance parameter, too, is limited by its
        // prior.
        let free = matches!(
            s.effect.kind,
            EffectKind::LoopDelay
                | EffectKind::ToolMass
                | EffectKind::AddedMass
                | EffectKind::AxisMisalignment
                | EffectKind::BearingCoupling
                | EffectKind::CrossCoupling
        );
        let least = if free { 1.05 } else { 1.0 - 1e-9 };
        assert!(ratio.is_none_or(|r| r > least), "{s:?} {ratio:?}");
    }
    let mass = sizes.iter().find(|s| s.effect.kind == EffectKind::ToolMass).expect("mass");
    assert!((1e-5..5e-3).contains(&mass.effect.values[0]), "{mass:?}");
}
