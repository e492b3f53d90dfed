//! Which further measurement would separate the members of a tie, and by how much.
//!
//! For each experiment of a menu and each pair a, b of members:  D = min_δ ‖d − J_b δ‖² + δᵀ N_b δ,  d = (F_a − F_b)/σ
//! the difference of their predictions, J_b the derivatives of b's prediction to its own numbers, to the nuisance
//! parameters and to the axis gains of the new record, N_b the information that the present data and the priors hold
//! about them. So the rival may use all its freedom, but must go on fitting what was measured. The experiment's figure
//! is the least D over the pairs. Linear round the fits.

use super::super::DiagnoseError;
use super::super::data::evidence::GAP_FLOOR;
use super::super::fit::case::Case;
use super::super::fit::hypothesis;
use super::candidate::Candidate;
use crate::linalg::dense::{dot, solve_normal};
use crate::linalg::{Mat, c64};
use crate::spindle::response::ported::factor;
use crate::spindle::response::{SIDE, Square, ZERO};
use crate::spindle::{AxisElectronics, Bearings, Effect, EffectKind, Housing, Location};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Every so many lines of the present sweep are predicted.
const STRIDE: usize = 4;
/// Standard deviation of an axis gain of a new record: levitated anew.
const AXIS_GAIN_SD: f64 = 1e-3;
/// Separation below which two members stay tied (odds of 1 to 20).
pub(crate) const SEPARATED: f64 = 6.0;
/// Mass that is put on the tip of the tool, as a share of the rotor: 5 g on one of 8 kg.
const TIP_SHARE: f64 = 6e-4;
/// Mass that is put on the nose, as a share of the rotor: 200 g on one of 8 kg.
const COLLAR_SHARE: f64 = 0.025;

/// The mass, in g, of the series 1, 2, 5, 10, … that is nearest in ratio to a share of the rotor.
fn mass_g(share: f64, rotor_kg: f64) -> f64 {
    let asked = 1e3 * share * rotor_kg;
    let decade = 10f64.powf(asked.log10().floor());
    let series = [1.0, 2.0, 5.0, 10.0].map(|m| m * decade);
    let off = |m: &f64| (m / asked).ln().abs();
    let nearest = series.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)));
    nearest.unwrap_or(asked)
}

/// A proposed measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposal {
    /// What to do.
    pub text: String,
    /// Expected χ² between the two members that it separates least.
    pub separation: f64,
}

impl Proposal {
    /// The proposal with its figure.
    pub fn words(&self) -> String {
        if self.separation < SEPARATED {
            format!(
                "none of the menu separates them (the best: {}, expected χ² {:.1}, 6 is needed)",
                self.text, self.separation
            )
        } else {
            format!("{} (expected separation χ² ≈ {:.0})", self.text, self.separation)
        }
    }
}

/// What is read, and from what.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Sweep,
    /// Sensors from measured coil currents.
    CoilCurrent,
    /// Sensors and tool from a hammer at the tool.
    Hammer,
    /// Acceleration of the stator from commanded currents.
    Housing,
}

struct Experiment {
    text: String,
    speed_rad_s: f64,
    extra: Vec<Effect>,
    kind: Kind,
}

fn effect(kind: EffectKind, location: Location, value: f64) -> Effect {
    Effect { kind, location, values: vec![value] }
}

fn menu(case: &Case, members: &[&Candidate]) -> Result<Vec<Experiment>, DiagnoseError> {
    let machine = &case.model.reduced.machine;
    let rotor_kg = machine.rotor()?.mass_properties().mass_kg;
    let [tip_g, collar_g] = [TIP_SHARE, COLLAR_SHARE].map(|share| mass_g(share, rotor_kg));
    let sweep =
        |text: String, speed_rad_s: f64, extra: Vec<Effect>| Experiment { text, speed_rad_s, extra, kind: Kind::Sweep };
    let tip = effect(EffectKind::ToolMass, Location::None, 1e-3 * tip_g);
    let both = || Location::Bearing(Bearings::Both);
    let mut all = vec![
        Experiment {
            text: "sweep with the coil currents measured: delay and amplifier of the command path drop out".into(),
            kind: Kind::CoilCurrent,
            ..sweep(String::new(), 0.0, vec![])
        },
        Experiment {
            text: "hammer at the tool, read at the tool and by the bearing sensors: the command path drops out, the \
                sensors stay"
                .into(),
            kind: Kind::Hammer,
            ..sweep(String::new(), 0.0, vec![])
        },
        sweep(format!("sweep with a known mass of {tip_g} g on the tip of the tool"), 0.0, vec![tip]),
        sweep(
            // Stands for a second, heavier tool whose rest is the same: what sits in the shaft or in the loop stays,
            // what sits in the tool changes its share.
            format!("sweep with a known collar of {collar_g} g on the nose"),
            0.0,
            vec![effect(EffectKind::AddedMass, Location::Position(0.0), 1e-3 * collar_g)],
        ),
        sweep(
            // ki grows with the bias, ks with its square.
            "sweep at half the bias current".into(),
            0.0,
            vec![effect(EffectKind::ForceConstant, both(), 0.5), effect(EffectKind::NegativeStiffness, both(), 0.25)],
        ),
    ];
    for share in [0.25, 0.5, 1.0] {
        let rpm = share * machine.spindle.max_rpm;
        let speed = rpm * TAU / 60.0;
        let known = case.evidence.sweeps.iter();
        // A speed that was measured adds nothing new.
        if known.into_iter().all(|s| (s.speed_rad_s - speed).abs() > 1.0) {
            all.push(sweep(format!("sweep at {rpm:.0} rpm"), speed, vec![]));
        }
    }
    let housings = members.iter().filter(|m| m.effects.iter().any(|h| h.kind == EffectKind::HousingMode));
    if (1..members.len()).contains(&housings.count()) {
        all.push(Experiment {
            text: "sweep with an accelerometer on the housing".into(),
            kind: Kind::Housing,
            ..sweep(String::new(), 0.0, vec![])
        });
    }
    Ok(all)
}

/// Predictions of a member, whitened by the σ of the first of the pair, and their derivatives.
struct Predicted {
    values: Vec<c64>,
    /// Nuisance parameters, effects, axis gains.
    columns: Vec<Vec<c64>>,
}

/// The menu, most separating first.
///
/// # Errors
/// [`DiagnoseError`] when a model cannot be assembled.
pub fn proposals(case: &Case, members: &[&Candidate]) -> Result<Vec<Proposal>, DiagnoseError> {
    let menu = menu(case, members)?;
    let found: Result<Vec<Proposal>, DiagnoseError> = menu
        .into_par_iter()
        .map(|experiment| {
            let all: Result<Vec<Predicted>, DiagnoseError> =
                members.iter().map(|m| predict_separation(case, m, &experiment)).collect();
            let all = all?;
            let mut least = f64::INFINITY;
            for (i, a) in all.iter().enumerate() {
                for (j, b) in all.iter().enumerate() {
                    if i != j {
                        let separation = separation(a, b, members[j])?;
                        least = least.min(separation);
                    }
                }
            }
            Ok(Proposal { text: experiment.text, separation: if least.is_finite() { least } else { 0.0 } })
        })
        .collect();
    let mut found = found?;
    found.sort_by(|a, b| b.separation.total_cmp(&a.separation));
    Ok(found)
}

/// Entries of F that an experiment reads.
fn read(kind: Kind) -> Vec<usize> {
    let (rows, columns) = match kind {
        Kind::Sweep | Kind::CoilCurrent | Kind::Housing => (0..4, 0..4),
        Kind::Hammer => (0..6, 4..6),
    };
    rows.flat_map(|i| columns.clone().map(move |j| SIDE * i + j)).collect()
}

fn effects_of(candidate: &Candidate, theta: &[Vec<f64>], experiment: &Experiment) -> Vec<Effect> {
    let mut all = hypothesis::effects(&candidate.effects, theta);
    all.extend(experiment.extra.iter().cloned());
    all
}

fn predict_separation(case: &Case, candidate: &Candidate, experiment: &Experiment) -> Result<Predicted, DiagnoseError> {
    let (model, layout) = (case.model, &case.model.layout);
    let at = &candidate.fit.at;
    let entries = read(experiment.kind);
    let lines: Vec<f64> =
        case.evidence.sweeps.first().map_or(vec![], |s| s.omega_rad_s.iter().step_by(STRIDE).copied().collect());
    let speed = experiment.speed_rad_s;
    let here = effects_of(candidate, &at.theta, experiment);
    let assembled = model.assemble(&at.p, &here, speed, true)?;
    let transfer = |effects: &[Effect]| Transfer::new(case, effects, experiment.kind);
    let own = transfer(&here);
    let mut values = vec![];
    let mut columns: Vec<Vec<c64>> = vec![];
    for (line, omega) in lines.iter().enumerate() {
        let found = assembled.line(*omega, Some(&layout.machine));
        let f = &found.response;
        let pick = |f: &Square| -> Vec<c64> {
            let f = own.apply(f, *omega);
            entries.iter().map(|n| f[*n]).collect()
        };
        values.extend(pick(f));
        if line == 0 {
            columns = vec![vec![]; layout.len()];
        }
        let first = layout.machine.reading(0);
        let (moduli, others) = found.derivatives.split_at(layout.machine.groups);
        let (ks, others) = others.split_at(2);
        let gains = |rows: bool| [factor(f, rows, 0), factor(f, rows, 1)];
        let (ki, sensors) = (gains(false), gains(true));
        let slopes = moduli.iter().chain(&ki).chain(ks).chain(&sensors).chain(others);
        for (column, slope) in columns.iter_mut().zip(slopes) {
            column.extend(pick(slope));
        }
        for column in columns.iter_mut().skip(first) {
            // Readings are as they are, and axis gains of the old records do not act on the new one.
            column.extend(entries.iter().map(|_| ZERO));
        }
    }
    for (e, hypothesis) in candidate.effects.iter().enumerate() {
        for i in 0..at.theta[e].len() {
            let mut theta = at.theta.clone();
            let step = difference(hypothesis.kind);
            theta[e][i] += step;
            hypothesis.clamp(&mut theta[e]);
            let mut taken = theta[e][i] - at.theta[e][i];
            if taken.abs() < 0.5 * step {
                theta[e][i] = at.theta[e][i] - step;
                taken = -step;
            }
            let there = effects_of(candidate, &theta, experiment);
            let assembled = model.assemble(&at.p, &there, speed, false)?;
            let moved = transfer(&there);
            let mut column = Vec::with_capacity(values.len());
            for omega in &lines {
                let f = moved.apply(&assembled.line(*omega, None).response, *omega);
                column.extend(entries.iter().map(|n| f[*n]));
            }
            for (c, v) in column.iter_mut().zip(&values) {
                *c = (*c - v) / taken;
            }
            columns.push(column);
        }
    }
    for axis in 0..4 {
        let of = |k: usize| entries[k % entries.len()] / SIDE;
        let column = values.iter().enumerate();
        columns.push(column.map(|(k, v)| if of(k) == axis { *v } else { ZERO }).collect());
    }
    Ok(Predicted { values, columns })
}

/// Step of a difference in a fit coordinate, all of which are of order one.
fn difference(kind: EffectKind) -> f64 {
    match kind {
        // 0.05 mm: the shaft reads positions within 1 µm of a node as the node itself.
        EffectKind::SensorOffset | EffectKind::ActuatorOffset => 0.05,
        _ => 1e-4,
    }
}

/// What an experiment reads from F: of measured coil currents, without delay and amplifiers.
struct Transfer {
    kind: Kind,
    delay_s: f64,
    axes: [AxisElectronics; 4],
    housing: Vec<Housing>,
}

impl Transfer {
    fn new(case: &Case, effects: &[Effect], kind: Kind) -> Self {
        let mut machine = case.model.reduced.machine.clone();
        machine.spindle.effects.extend_from_slice(effects);
        let effective = machine.effective();
        Self {
            kind,
            delay_s: effective.delay_s,
            axes: std::array::from_fn(|k| effective.bearings[k / 2].axes[k % 2]),
            housing: effective.housings.clone(),
        }
    }

    fn apply(&self, f: &Square, omega: f64) -> Square {
        let s = c64::new(0.0, omega);
        match self.kind {
            Kind::Sweep | Kind::Hammer => *f,
            Kind::CoilCurrent => std::array::from_fn(|n| {
                if n % SIDE < 4 { f[n] * (s * self.delay_s).exp() / self.axes[n % SIDE].coil_current(s) } else { f[n] }
            }),
            // The stator moves by its flexibility times the force, which is near 1 N/A times ki: its size against the
            // shaft's response tells it from nothing; without a housing there is no motion at all.
            Kind::Housing => {
                let flexible = self.housing.iter().fold(ZERO, |sum, h| {
                    let own = h.omega_rad_s;
                    let z = c64::new(own * own - omega * omega, 2.0 * h.damping_ratio * own * omega);
                    sum + (z * h.mass_kg).inv()
                });
                std::array::from_fn(|n| if n / SIDE == n % SIDE { flexible } else { ZERO })
            }
        }
    }
}

/// D of a pair: data of `a`, refitted by `b`.
fn separation(a: &Predicted, b: &Predicted, member: &Candidate) -> Result<f64, DiagnoseError> {
    // Of the magnitude, with a model error of a tenth of the largest of the channel set, as repeats and drifts leave.
    let largest = a.values.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let sigma: Vec<f64> =
        a.values.iter().map(|v| (GAP_FLOOR * v.norm().max(1e-3 * largest)).max(f64::MIN_POSITIVE)).collect();
    // √2 and both parts: χ² = 2 Σ |w|²; thinned lines count for their neighbours.
    let weight = (2.0 * STRIDE as f64).sqrt();
    let real = |column: &[c64]| -> Vec<f64> {
        column.iter().zip(&sigma).flat_map(|(v, s)| [weight * v.re / s, weight * v.im / s]).collect()
    };
    let difference: Vec<c64> = a.values.iter().zip(&b.values).map(|(a, b)| a - b).collect();
    let d = real(&difference);
    let columns: Vec<Vec<f64>> = b.columns.iter().map(|c| real(c)).collect();
    let n = columns.len();
    let known = member.fit.information.nrows();
    let mut matrix = Mat::zeros(n, n);
    for i in 0..n {
        for j in 0..=i {
            let value = dot(&columns[i], &columns[j]);
            matrix[(i, j)] = value;
            matrix[(j, i)] = value;
        }
    }
    for i in 0..n {
        for j in 0..n {
            if i < known && j < known {
                matrix[(i, j)] += member.fit.information[(i, j)];
            }
        }
        if i >= known {
            matrix[(i, i)] += AXIS_GAIN_SD.powi(-2);
        }
        // On a number of which no record knows nothing depends.
        matrix[(i, i)] = if matrix[(i, i)] == 0.0 { 1.0 } else { matrix[(i, i)] * (1.0 + 1e-12) };
    }
    let right = Mat::from_fn(n, 1, |i, _| dot(&columns[i], &d));
    let step = solve_normal(&matrix, &right)?;
    let gain: f64 = (0..n).map(|i| step[(i, 0)] * right[(i, 0)]).sum();
    Ok((dot(&d, &d) - gain).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masses_are_of_the_series_and_grow_with_the_rotor() {
        let of = |rotor_kg| [TIP_SHARE, COLLAR_SHARE].map(|share| mass_g(share, rotor_kg));
        assert_eq!(of(8.0), [5.0, 200.0]);
        assert_eq!(of(0.06), [0.05, 2.0]);
        assert_eq!(of(1700.0), [1000.0, 50_000.0]);
    }
}
