//! A correction without a name: the law recovered at the best place, line by line, used for predictions.
//!
//! F_new = F + Σ X_a D_a at the lines of the sweeps; elsewhere Δ is interpolated linearly over frequency (X is not
//! smooth, Δ is) and X follows from Δ and the shaft there. Limits: nothing is said outside the measured band (the end
//! values are held); a law of another speed is taken as the same.

use super::super::DiagnoseError;
use super::super::data::evidence::Subset;
use super::super::fit::case::Case;
use super::localisation::{MODEL_ERROR, PortScore};
use super::place::Place;
use super::projection::{LawFit, lines, settle};
use crate::linalg::c64;
use crate::spindle::response::Square;

/// Steps in which the nuisance parameters follow when channels are left out.
const STEPS: usize = 2;

/// The corrected response at every line of every record.
#[derive(Clone, Debug)]
pub struct Correction {
    /// The place in words.
    pub port: String,
    /// The place.
    pub place: Place,
    /// Corrected F at the lines of every sweep.
    pub sweeps: Vec<Vec<Square>>,
    /// Corrected F at the lines of every hammer test.
    pub taps: Vec<Vec<Square>>,
    /// Nuisance parameters that go with it.
    pub p: Vec<f64>,
}

/// The correction at a place, from what `usage` lets it see.
pub(crate) fn correct(case: &Case, port: &PortScore, usage: Subset) -> Result<Correction, DiagnoseError> {
    let place = &port.place;
    let p = if usage.off_diagonal {
        port.p.clone()
    } else {
        let stages = [(MODEL_ERROR, STEPS)];
        settle(case, place, &port.p, &stages, usage)?.p
    };
    let count = case.evidence.sweeps.len();
    let mut sweeps: Vec<Vec<Square>> = vec![vec![]; count];
    let mut free: Vec<Vec<(f64, Vec<c64>)>> = vec![vec![]; count];
    let fit = LawFit { place, p: &p, model_error: MODEL_ERROR, usage, derivatives: false };
    lines(case, &fit, |line| {
        let mut f = line.view.response;
        for (d, x) in line.view.directions.iter().zip(&line.x) {
            for (f, d) in f.iter_mut().zip(d) {
                *f += d * x;
            }
        }
        sweeps[line.sweep].push(f);
        free[line.sweep].push((line.omega_rad_s, line.view.free(&line.x)));
    })?;
    let mut taps = vec![];
    for tap in &case.evidence.taps {
        // The sweep at the speed of the hammer test, or the nearest.
        let away = |s: &usize| (case.evidence.sweeps[*s].speed_rad_s - tap.speed_rad_s).abs();
        let nearest = (0..count).min_by(|a, b| away(a).total_cmp(&away(b)));
        let known = nearest.map_or(&[][..], |s| &free[s]);
        let scene = place.scene(case.model, &p, &[], tap.speed_rad_s, false)?;
        let mut all = vec![];
        for omega in &tap.omega_rad_s {
            let view = scene.view(*omega);
            let x = view.bind_law(&interpolate_law(known, *omega));
            let mut f = view.response;
            for (d, x) in view.directions.iter().zip(&x) {
                for (f, d) in f.iter_mut().zip(d) {
                    *f += d * x;
                }
            }
            all.push(f);
        }
        taps.push(all);
    }
    Ok(Correction { port: port.port.clone(), place: place.clone(), sweeps, taps, p })
}

fn interpolate_law(known: &[(f64, Vec<c64>)], omega: f64) -> Vec<c64> {
    let above = known.partition_point(|(w, _)| *w < omega);
    match (above.checked_sub(1).and_then(|k| known.get(k)), known.get(above)) {
        (Some((a, x)), Some((b, y))) => {
            let share = if b > a { (omega - a) / (b - a) } else { 0.0 };
            x.iter().zip(y).map(|(x, y)| x + (y - x) * share).collect()
        }
        (Some((_, x)), None) | (None, Some((_, x))) => x.clone(),
        (None, None) => vec![],
    }
}
