//! The reduced model against the plant, for every effect.

use crate::diagnose::diagnose_folder::read;
use muspin::diagnose::fit::hypothesis::{Hypothesis, Scope, catalogue};
use muspin::diagnose::fit::model::Model;
use muspin::lti::Response;
use muspin::rotor::element;
use muspin::rotor::section::{Material, Section};
use muspin::spindle::halved::refine_mesh;
use muspin::spindle::response::term::Number;
use muspin::spindle::response::{Assembled, Assembly, Square};
use muspin::spindle::{Bearings, Effect, EffectKind, Location, Machine, ModelDetail, Plane, Plant};
use std::f64::consts::TAU;

/// The reference spindle with its tool, and its reduction.
fn reduced() -> (Machine, Model) {
    let machine = read("c03").machine;
    let model = Model::new(&machine, &[[1e-3; 4]]).expect("model");
    (machine, model)
}

/// Every hypothesis of a turning spindle.
fn every(machine: &Machine, model: &Model) -> Vec<Hypothesis> {
    let scope = Scope { turning: true, first_rad_s: TAU * 40.0, top_rad_s: TAU * 4000.0 };
    catalogue(machine, model.reduced.span_m(), model.reduced.flexible_rad_s(), scope).expect("catalogue")
}

/// Square of a derivative's distance from the central difference of two models a step on either side, and of its size: six lines, relative
/// to the response there.
fn off_and_size(
    derivative: impl Fn(f64) -> (Square, Square),
    (ahead, behind): (&Assembled, &Assembled),
    step: f64,
) -> (f64, f64) {
    let (mut off, mut size) = (0.0, 0.0);
    for hz in [90.0, 400.0, 1100.0, 1900.0, 2900.0, 3700.0] {
        let (response, own) = derivative(TAU * hz);
        let (a, b) = (ahead.line(TAU * hz, None), behind.line(TAU * hz, None));
        for n in 0..36 {
            let want = (a.response[n] - b.response[n]) / (2.0 * step);
            let scale = response[n].norm_sqr().max(f64::MIN_POSITIVE);
            off += (own[n] - want).norm_sqr() / scale;
            size += want.norm_sqr() / scale;
        }
    }
    (off, size)
}

#[test]
fn reduced_model_answers_as_the_plant() {
    let (machine, model) = reduced();
    let machine = &machine;
    let all = every(machine, &model);
    let zero = vec![0.0; model.layout.len()];
    let mut seen = vec![];
    for speed in [0.0, 3000.0] {
        for hypothesis in &all {
            // Both joints are tried, one stiff and one soft.
            let twice = hypothesis.kind == EffectKind::ToolJoint;
            let place = std::mem::discriminant(&hypothesis.place);
            let key = (hypothesis.kind, place, speed as i64);
            if !twice && seen.contains(&key) {
                continue;
            }
            seen.push(key);
            let mut theta = hypothesis.start.clone();
            if twice {
                theta[2] *= 5.0;
            }
            // One fit unit; a modulus by a third, the largest change that drawings and joints leave open.
            theta[0] += match hypothesis.kind {
                EffectKind::RegionStiffness => 0.3,
                _ => 1.0,
            };
            let effect = hypothesis.effect(&theta);
            let of = |machine: &Machine| Plant::new(machine, speed, ModelDetail::Full).expect("plant");
            let fine = refine_mesh(machine);
            let with_effect = of(&fine.with_effect(effect.clone()));
            // The slope of a tilting stiffness is read on thirds of the elements of the file: what it changes there.
            let on_file = (effect.kind == EffectKind::TiltingStiffness).then(|| {
                let with = of(&machine.with_effect(effect.clone()));
                (with, of(machine), of(&fine))
            });
            let exact = |w: f64| match &on_file {
                None => with_effect.at(w),
                Some((with, without, fine)) => fine.at(w) + (with.at(w) - without.at(w)),
            };
            let assembled = model.assemble(&zero, std::slice::from_ref(&effect), speed, false).expect("assembled");
            let tolerance = match effect.kind {
                // Twice the true coupling: the moments of the discs' slopes are not among the ports of the reduction.
                EffectKind::Gyroscopic => 3e-3,
                // What the mesh of the file changes of the change.
                EffectKind::TiltingStiffness => 5e-3,
                _ => 2e-3,
            };
            for hz in [60.0, 300.0, 700.0, 1300.0, 2800.0, 3900.0] {
                let (want, got) = (exact(TAU * hz), assembled.line(TAU * hz, None).response);
                let mut scale = [0.0f64; 2];
                for i in 0..6 {
                    for j in 0..6 {
                        let part = usize::from(i % 2 == j % 2);
                        scale[part] = scale[part].max(want[(i, j)].norm() / if j < 4 { 1.0 } else { 1e-3 });
                    }
                }
                for i in 0..6 {
                    for j in 0..6 {
                        let unit = if j < 4 { 1.0 } else { 1e-3 };
                        let error = (want[(i, j)] - got[6 * i + j]).norm();
                        let size = want[(i, j)].norm().max(0.01 * unit * scale[1]);
                        assert!(
                            error < tolerance * size,
                            "{:?} at {hz} Hz, {speed} rad/s, entry {i},{j}: {} against {}",
                            effect,
                            got[6 * i + j],
                            want[(i, j)]
                        );
                    }
                }
            }
        }
    }
}

/// Peak difference of a model from a plant over lines round the resonances, relative to the largest entry of a line.
fn difference(plant: &Plant, model: &Model, p: &[f64], effects: &[Effect]) -> f64 {
    let assembled = model.assemble(p, effects, 0.0, false);
    let assembled = assembled.expect("assembled");
    let mut worst = 0.0f64;
    for k in 0..400 {
        let omega = TAU * 40.0 * 100f64.powf(k as f64 / 399.0);
        let (want, got) = (plant.at(omega), assembled.line(omega, None).response);
        let entries = || (0..36).filter(|n| n / 6 % 2 == 0 && n % 6 % 2 == 0);
        for block in [true, false] {
            let own = |n: &usize| (n / 6 < 4) == block;
            let size = entries().filter(own).map(|n| want[(n / 6, n % 6)].norm()).fold(0.0, f64::max);
            for n in entries().filter(own) {
                worst = worst.max((want[(n / 6, n % 6)] - got[n]).norm() / size);
            }
        }
    }
    worst
}

/// The mesh as a nuisance parameter is the mesh: 1 is a mesh twice as fine, −4 is the file's own and too far for a first order.
#[test]
fn mesh_parameter_is_a_finer_mesh() {
    let (machine, model) = reduced();
    let machine = &machine;
    let plant = Plant::new(&refine_mesh(&refine_mesh(machine)), 0.0, ModelDetail::Full).expect("plant");
    let mut p = vec![0.0; model.layout.len()];
    let coarse = difference(&plant, &model, &p, &[]);
    p[model.layout.machine.mesh()] = 1.0;
    let fine = difference(&plant, &model, &p, &[]);
    assert!(coarse > 5e-3, "the mesh shows at resonances: {coarse}");
    // First order: the square of a relative change of 10⁻³ at the end of the band, and the reduction.
    assert!(fine < 0.02 * coarse, "{fine} of {coarse}");
}

/// Planes between nodes of the file, moved by −2.7 mm at the front actuators and by 3 mm at the rear sensors.
fn moved_planes() -> Vec<Effect> {
    [(EffectKind::ActuatorOffset, Bearings::Front, -2.7e-3), (EffectKind::SensorOffset, Bearings::Rear, 3e-3)]
        .map(|(kind, side, by)| Effect::new(kind, Location::Bearing(side), vec![by]).expect("effect"))
        .to_vec()
}

/// Between nodes another mesh reads differently, by what two numbers within their range describe.
#[test]
fn readings_follow_another_mesh() {
    let (machine, model) = reduced();
    let effects = moved_planes();
    let mut fine = refine_mesh(&refine_mesh(&machine));
    for effect in &effects {
        fine = fine.with_effect(effect.clone());
    }
    let plant = Plant::new(&fine, 0.0, ModelDetail::Full).expect("plant");
    let mut p = vec![0.0; model.layout.len()];
    p[model.layout.machine.mesh()] = 1.0;
    let before = difference(&plant, &model, &p, &effects);
    for plane in [0, 3, 0, 3] {
        let k = model.layout.machine.reading(plane);
        let (mut best, mut share) = (f64::INFINITY, 0.0);
        for step in -20..=20 {
            p[k] = 0.05 * f64::from(step);
            let off = difference(&plant, &model, &p, &effects);
            if off < best {
                (best, share) = (off, p[k]);
            }
        }
        p[k] = share;
    }
    let after = difference(&plant, &model, &p, &effects);
    // A grid of 0.05 leaves a twentieth of a unit.
    assert!(after < 0.2 * before, "{after} of {before}");
}

/// Derivatives to the readings against central differences; planes on nodes have none.
#[test]
fn derivatives_of_readings() {
    let (_, model) = reduced();
    let effects = moved_planes();
    let mut p = vec![0.0; model.layout.len()];
    assert_eq!(model.reduced.readings(&[], &mut vec![]).expect("planes"), vec![]);
    for plane in [0, 3] {
        p[model.layout.machine.reading(plane)] = 0.3;
    }
    for speed in [0.0, 3000.0] {
        let mut probes = vec![];
        let readings = model.reduced.readings(&effects, &mut probes).expect("planes");
        let (planes, numbers): (Vec<usize>, Vec<Number>) = readings.into_iter().unzip();
        assert_eq!(planes, [0, 3]);
        let here = model
            .reduced
            .assemble(&p, Assembly { effects: &effects, speed_rad_s: speed, probes: &probes, ..Assembly::default() });
        let here = here.expect("assembled");
        let first = here.ports() - probes.len();
        for (i, plane) in planes.into_iter().enumerate() {
            let step = 1e-3;
            let moved = |by: f64| {
                let mut p = p.clone();
                p[model.layout.machine.reading(plane)] += by;
                model.assemble(&p, &effects, speed, false).expect("moved")
            };
            let own = |w: f64| {
                let line = here.line_with(w, None, first, &numbers);
                (line.response, line.derivatives[i])
            };
            let (off, size) = off_and_size(own, (&moved(step), &moved(-step)), step);
            // Linear but for the loop of the magnets.
            assert!(off < 1e-8 * size, "{plane} at {speed}: {off} of {size}");
        }
    }
}

/// Derivatives to every nuisance parameter against central differences.
#[test]
fn derivatives_of_small_parameters() {
    let (_, model) = reduced();
    let layout = &model.layout;
    let mut p = vec![0.0; layout.len()];
    p[layout.machine.mesh()] = 0.4;
    for speed in [0.0, 3000.0] {
        let here = model.assemble(&p, &[], speed, true).expect("assembled");
        for (analytic, k) in (0..layout.machine.groups)
            .map(|g| (g, g))
            .chain([0, 1].map(|b| (layout.machine.groups + b, layout.machine.ks(b))))
            .chain([0, 3, 5].map(|m| (layout.machine.groups + 2 + m, layout.machine.damping(m))))
            .chain([(layout.machine.analytic() - 1, layout.machine.mesh())])
        {
            let step = 1e-4;
            let moved = |by: f64| {
                let mut p = p.clone();
                p[k] += by;
                model.assemble(&p, &[], speed, false).expect("assembled")
            };
            let (ahead, behind) = (moved(step), moved(-step));
            let own = |w: f64| {
                let line = here.line(w, Some(&layout.machine));
                (line.response, line.derivatives[analytic])
            };
            let (off, size) = off_and_size(own, (&ahead, &behind), step);
            // 5 % for left-out strains and coordinates that follow as springs: enough for steps and covariances.
            assert!(off < 2.5e-3 * size, "parameter {k} at {speed}: {off} of {size}");
        }
    }
}

/// What cubic functions with ψ as slope leave out of the deflection is the shear angle times L s(1−s)(1−2s): of a clamped beam under a
/// force and a moment at its end, for which elements of any length are exact, read between two nodes and on the node of a finer mesh.
#[test]
fn cubic_functions_leave_out_the_shear_angle() {
    let steel = Material::isotropic("steel", 210e9, 7850.0, 0.3);
    let beam = |length: f64| Section::cylinder(length, 0.04, 0.01, steel.clone());
    let (length, force, moment) = (0.03, 900.0, -11.0);
    // The end of a clamped element: its lower right block against (force, moment).
    let end = |section: &Section, force: f64, moment: f64| {
        let k = element::matrices(section).stiffness;
        let (a, b, d) = (k[(2, 2)], k[(2, 3)], k[(3, 3)]);
        let det = a * d - b * b;
        [(d * force - b * moment) / det, (a * moment - b * force) / det]
    };
    let whole = beam(length);
    let [w, psi] = end(&whole, force, moment);
    for s in [0.1, 0.35, 0.5, 0.8] {
        // To the cut, the rest of the beam is its force and its moment.
        let [exact, _] = end(&beam(s * length), force, moment + force * (1.0 - s) * length);
        let read = element::hermite(s, length);
        let shear = element::shear(&whole);
        let angle = shear[2] * w + shear[3] * psi;
        let got = read[2] * w + read[3] * psi + angle * length * s * (1.0 - s) * (1.0 - 2.0 * s);
        assert!((got - exact).abs() < 1e-12 * w.abs(), "{s}: {got} {exact}");
        if s != 0.5 {
            assert!((got - read[2] * w - read[3] * psi).abs() > 1e-4 * w.abs());
        }
    }
}

/// The derivative of every number to its coordinate against central differences.
#[test]
fn coordinates_have_slopes() {
    let (machine, model) = reduced();
    for hypothesis in every(&machine, &model) {
        let mut theta = hypothesis.start.clone();
        theta[0] += 0.3;
        for i in 0..theta.len() {
            let number = |by: f64| {
                let mut theta = theta.clone();
                theta[i] += by;
                let effect = hypothesis.effect(&theta);
                match (effect.values.get(i), effect.location) {
                    (Some(value), _) => *value,
                    (None, place) => place.position_m().expect("a position"),
                }
            };
            let step = 1e-5;
            let want = (number(step) - number(-step)) / (2.0 * step);
            let got = hypothesis.slope(i, &theta);
            assert!((got - want).abs() < 1e-6 * want.abs(), "{:?} {i}: {got} {want}", hypothesis.kind);
        }
    }
}

/// Derivatives to every number of an effect against central differences, alone and beside another effect.
#[test]
fn derivatives_of_effects() {
    let (machine, model) = reduced();
    let all = every(&machine, &model);
    let p = vec![0.0; model.layout.len()];
    let beside = Effect::new(EffectKind::AddedStiffness, Location::Position(0.3), vec![4e5]);
    let beside = beside.expect("effect");
    let mut known = vec![];
    let in_plane = Effect::new(EffectKind::AddedStiffness, Location::InPlane(0.2, Plane::X), vec![6e5]);
    let in_plane = in_plane.expect("effect");
    // Alone and beside others, at rest and at speed, from the start of a fit and further on.
    let cases = [(0.0, vec![]), (3000.0, vec![beside.clone()]), (3000.0, vec![in_plane, beside])];
    for (hypothesis, ((speed, others), further)) in all
        .iter()
        .flat_map(|h| cases.iter().map(move |case| (h, case)))
        .flat_map(|(h, case)| [0.0, 0.3].map(|further| (h, (case, further))))
    {
        let (kind, mut theta, speed) = (hypothesis.kind, hypothesis.start.clone(), *speed);
        theta[0] += further;
        let at = |theta: &[f64]| [&others[..], &[hypothesis.effect(theta)]].concat();
        let (effects, mut probes) = (at(&theta), vec![]);
        let numbers = model.reduced.sensitivity(&effects, others.len(), &mut probes);
        known.push(kind);
        assert_eq!(numbers.len(), theta.len(), "{kind:?}");
        let here = model.reduced.assemble(
            &p,
            Assembly {
                effects: &effects,
                speed_rad_s: speed,
                derivatives: true,
                probes: &probes,
                ..Assembly::default()
            },
        );
        let here = here.expect("assembled");
        let first = here.ports() - probes.len();
        for i in 0..theta.len() {
            let step = match kind {
                // 50 µm: within one a position is a node.
                EffectKind::SensorOffset | EffectKind::ActuatorOffset => 0.05,
                // Of its position 10 µm: the curvature of cubic functions jumps at a node, and one of the places is 39 µm beside one.
                EffectKind::TiltingStiffness => 2e-4,
                _ => 1e-3,
            };
            let moved = |by: f64| {
                let mut theta = theta.clone();
                theta[i] += by;
                let own = model.assemble(&p, &at(&theta), speed, false);
                own.expect("assembled")
            };
            let (ahead, behind) = (moved(step), moved(-step));
            let slope = hypothesis.slope(i, &theta);
            let own = |w: f64| {
                let line = here.line_with(w, Some(&model.layout.machine), first, &numbers);
                let own = line.derivatives[model.layout.machine.analytic() + i];
                (line.response, own.map(|d| d * slope))
            };
            let (off, size) = off_and_size(own, (&ahead, &behind), step);
            // 3 %: damping ratios stay with their modes, which are not differentiated.
            assert!(
                off <= 1e-3 * size,
                "{kind:?} {:?} {i} at {theta:?}, {speed} rad/s: {off} of {size}",
                hypothesis.place
            );
        }
    }
    known.sort_unstable();
    known.dedup();
    assert_eq!(known, EffectKind::all().collect::<Vec<_>>());
}

/// Largest relative difference of the diagonal planes from the plant over 50 to 4000 Hz, sensors from currents and from the tool.
fn apart(machine: &Machine, model: &Model, effect: &Effect) -> f64 {
    let fine = refine_mesh(machine).with_effect(effect.clone());
    let plant = Plant::new(&fine, 0.0, ModelDetail::Full).expect("plant");
    let p = vec![0.0; model.layout.len()];
    let own = model.assemble(&p, std::slice::from_ref(effect), 0.0, false).expect("assembled");
    let mut worst = 0.0f64;
    for k in 0..200 {
        let w = TAU * 50.0 * 80f64.powf(k as f64 / 199.0);
        let (want, got) = (plant.at(w), own.line(w, None).response);
        for (i, j) in [(0, 0), (0, 2), (2, 0), (2, 2), (4, 4)] {
            let error = (want[(i, j)] - got[6 * i + j]).norm();
            worst = worst.max(error / want[(i, j)].norm());
        }
    }
    worst
}

/// Shafts that were assembled before are kept: one that is asked for again answers as one that is made anew, between
/// others that differ in one number only.
#[test]
fn a_shaft_that_was_kept_answers_as_a_new_one() {
    let (machine, model) = reduced();
    let mass = |z: f64, kg: f64| Effect::new(EffectKind::AddedMass, Location::Position(z), vec![kg]).expect("effect");
    let joint = Effect::new(EffectKind::ToolJoint, Location::None, vec![2.5e8, 1.2e5, 1.0]);
    let sets = [
        vec![],
        vec![mass(0.1, 0.05)],
        vec![mass(0.05, 0.1)],
        vec![mass(0.1, 0.05), mass(0.05, 0.1)],
        vec![joint.expect("effect")],
    ];
    let response = |model: &Model, modulus: f64, effects: &[Effect]| {
        let mut p = vec![0.0; model.layout.len()];
        p[0] = modulus;
        let assembled = model.assemble(&p, effects, 0.0, false).expect("assembled");
        assembled.line(TAU * 900.0, None).response
    };
    for _ in 0..2 {
        for modulus in [0.0, 0.02, -0.02, 0.04] {
            for effects in &sets {
                let anew = Model::new(&machine, &[[1e-3; 4]]).expect("model");
                let want = response(&anew, modulus, effects);
                for _ in 0..2 {
                    assert_eq!(response(&model, modulus, effects), want);
                }
            }
        }
    }
}

/// Effects that move a place or work at one, all along the shaft: the floor of a final fit is 5e-4.
#[test]
fn places_are_followed_closely() {
    let (machine, model) = reduced();
    let machine = &machine;
    let make = |kind, at, value: &[f64]| Effect::new(kind, at, value.to_vec()).expect("effect");
    let mut effects = vec![];
    for side in [Bearings::Front, Bearings::Rear] {
        for value in [-6e-3, -3e-3, 3e-3, 6e-3] {
            for kind in [EffectKind::ActuatorOffset, EffectKind::SensorOffset] {
                effects.push(make(kind, Location::Bearing(side), &[value]));
            }
        }
    }
    for k in 0..8 {
        let z = Location::Position(0.051 + 0.0417 * k as f64);
        effects.push(make(EffectKind::AddedMass, z.clone(), &[0.1]));
        effects.push(make(EffectKind::AddedStiffness, z, &[1e6]));
    }
    for region in machine.regions() {
        effects.push(make(EffectKind::RegionStiffness, Location::Region(region), &[0.8]));
    }
    effects.push(make(EffectKind::ToolMass, Location::None, &[0.015]));
    effects.push(make(EffectKind::ToolJoint, Location::None, &[2.5e8, 1.2e5, 1.0]));
    effects.push(make(EffectKind::ToolJoint, Location::None, &[8e8, 5e5, 1.0]));
    for effect in &effects {
        let error = apart(machine, &model, effect);
        // A modulus changes what the whole shaft can do; a place is among the coordinates or between two that are.
        let tolerance = match effect.kind {
            EffectKind::RegionStiffness => 1e-3,
            _ => 3e-4,
        };
        assert!(error < tolerance, "{effect:?}: {error:.1e}");
    }
}

/// A mass of nothing has no place, and a small one acts in proportion: steps from nothing rely on both.
#[test]
fn a_small_mass_acts_in_proportion() {
    let (_, model) = reduced();
    let p = vec![0.0; model.layout.len()];
    let at = |position_m: f64, mass_kg: f64| {
        let effect =
            Effect { kind: EffectKind::AddedMass, location: Location::Position(position_m), values: vec![mass_kg] };
        let own = model.assemble(&p, &[effect], 0.0, false).expect("assembled");
        own.line(TAU * 1069.0, None).response
    };
    let none = at(0.25, 0.0);
    assert_eq!(none, at(0.1, 0.0));
    let change = |m: f64| (at(0.25, m)[0] - none[0]).norm() / none[0].norm() / m;
    let (small, large) = (change(5e-6), change(5e-4));
    assert!((small / large - 1.0).abs() < 1e-2, "{small} {large}");
}

/// The most that a fit takes away from a place, at any mesh, leaves a shaft with inertia everywhere.
#[test]
fn a_place_keeps_some_inertia() {
    let (_, model) = reduced();
    let (from, to) = model.reduced.span_m();
    for k in 0..=30 {
        let z = from + (to - from) * k as f64 / 30.0;
        let taken = -0.45 * model.reduced.inertia_kg(z, false).expect("inertia");
        let effect = Effect { kind: EffectKind::AddedMass, location: Location::Position(z), values: vec![taken] };
        for mesh in [-0.5, 0.0, 1.5] {
            let mut p = vec![0.0; model.layout.len()];
            p[model.layout.machine.mesh()] = mesh;
            let own = model.assemble(&p, std::slice::from_ref(&effect), 0.0, true);
            assert!(own.is_ok(), "{taken} kg at {z} m, mesh {mesh}");
        }
    }
}
