//! The reduced model against the plant, for every effect.

use super::diagnose_folder::read;
use muspin::diagnose::hypothesis::{Scope, catalogue};
use muspin::diagnose::model::Model;
use muspin::diagnose::skeleton::refined;
use muspin::lti::Response;
use muspin::spindle::{EffectKind, ModelDetail, Plant};
use std::f64::consts::TAU;

#[test]
fn reduced_model_answers_as_the_plant() {
    let folder = read("c03");
    let machine = &folder.machine;
    let model = Model::new(machine, &[[1e-3; 4]]).expect("model");
    let scope = Scope {
        turning: true,
        top_rad_s: TAU * 4000.0,
    };
    let all = catalogue(machine, model.span_m(), model.flexible_rad_s(), scope).expect("catalogue");
    let zero = vec![0.0; model.layout.len()];
    let mut seen = vec![];
    for speed in [0.0, 3000.0] {
        for hypothesis in &all {
            // Both joints are tried, one stiff and one soft.
            let twice = hypothesis.kind == EffectKind::ToolJoint;
            if !twice && seen.contains(&(hypothesis.kind, speed as i64)) {
                continue;
            }
            seen.push((hypothesis.kind, speed as i64));
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
            let plant = Plant::new(
                &refined(machine).with_effect(effect.clone()),
                speed,
                ModelDetail::Full,
            )
            .expect("plant");
            let assembled = model
                .assemble(&zero, std::slice::from_ref(&effect), speed, false)
                .expect("assembled");
            // Damping of a mode with an added mass is that of the nominal mode here: differs at the peaks only.
            let tolerance = match effect.kind {
                EffectKind::AddedMass | EffectKind::ToolMass => 2e-2,
                // Twice the true coupling: the moments of the discs' slopes are not among the ports of the reduction.
                EffectKind::Gyroscopic => 3e-3,
                _ => 2e-3,
            };
            for hz in [60.0, 300.0, 700.0, 1300.0, 2800.0, 3900.0] {
                let (want, got) = (plant.at(TAU * hz), assembled.line(TAU * hz, None).response);
                let mut scale = [0.0f64; 2];
                for i in 0..6 {
                    for j in 0..6 {
                        let part = usize::from(i % 2 == j % 2);
                        scale[part] =
                            scale[part].max(want[(i, j)].norm() / if j < 4 { 1.0 } else { 1e-3 });
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
