//! Which further measurement would separate the members of a tie, and by how much.
//!
//! Every experiment of a menu is predicted by the two best members; expected separation χ² = 2 Σ |F_a − F_b|²/σ² at σ = 0.5 % of the
//! magnitude. Limits: small parameters are not refitted to the new data, so the figure is an upper bound.

use super::DiagnoseError;
use super::evidence::GAP_FLOOR;
use super::model::{Assembled, SIDE};
use super::search::{Candidate, Search};
use crate::spindle::{Effect, EffectKind, Location};
use std::f64::consts::TAU;

/// A proposed measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposal {
    /// What to do.
    pub text: String,
    /// Expected χ² between the two best members.
    pub separation: f64,
}

/// The menu, most separating first.
///
/// # Errors
/// [`DiagnoseError`] when a model cannot be assembled.
pub fn proposals(
    search: &Search,
    a: &Candidate,
    b: &Candidate,
) -> Result<Vec<Proposal>, DiagnoseError> {
    let machine = &search.model.machine;
    let full = machine.spindle.max_rpm * TAU / 60.0;
    let tip = Effect {
        kind: EffectKind::ToolMass,
        location: Location::None,
        values: vec![0.01],
    };
    let sweep = (0..4, 0..4);
    let menu = [
        (
            "hammer at the tool, read at the tool and by the bearing sensors, with the coil currents measured: the delay of the command path drops out, a sensor filter stays"
                .to_owned(),
            0.0,
            None,
            (0..6, 4..5),
        ),
        (format!("repeat the sweep at {:.0} rpm", 0.5 * machine.spindle.max_rpm), 0.5 * full, None, sweep.clone()),
        ("repeat the sweep with a known mass of 10 g at the tip of the tool".to_owned(), 0.0, Some(tip), sweep),
    ];
    let lines: Vec<f64> = search
        .evidence
        .sweeps
        .first()
        .map_or(vec![], |s| s.omega_rad_s.clone());
    let mut all = vec![];
    for (text, speed, extra, (outputs, inputs)) in menu {
        let assemble = |c: &Candidate| -> Result<Assembled, DiagnoseError> {
            let mut effects: Vec<Effect> = c
                .effects
                .iter()
                .zip(&c.fit.at.theta)
                .map(|(h, t)| h.effect(t))
                .collect();
            effects.extend(extra.clone());
            search.model.assemble(&c.fit.at.p, &effects, speed, false)
        };
        let (first, second) = (assemble(a)?, assemble(b)?);
        let mut separation = 0.0;
        for omega in &lines {
            let (f, g) = (
                first.line(*omega, None).response,
                second.line(*omega, None).response,
            );
            for i in outputs.clone() {
                let largest = inputs
                    .clone()
                    .map(|j| f[SIDE * i + j].norm())
                    .fold(f64::MIN_POSITIVE, f64::max);
                for j in inputs.clone() {
                    let sigma = GAP_FLOOR * f[SIDE * i + j].norm().max(0.1 * largest);
                    separation +=
                        2.0 * (f[SIDE * i + j] - g[SIDE * i + j]).norm_sqr() / (sigma * sigma);
                }
            }
        }
        all.push(Proposal { text, separation });
    }
    all.sort_by(|a, b| b.separation.total_cmp(&a.separation));
    Ok(all)
}
