//! The polish of a controller from start to end: rounds of descent, the lines renewed round the poles of the loop in between.

use super::descent::{Effort, descend};
use super::limits::LoopLimits;
use super::loss::{Group, Loss, Specification};
use super::modal_law::ModalLaw;
use super::responses::{Plants, Role, lines, shifts};
use super::structure::Line;
use crate::augment::Block;
use crate::augment::assembly::UncertainMode;
use crate::augment::plane::{LOADS, LOOPS, isotropic};
use crate::augment::split::gyroscopic_split;
use crate::augment::weights::Weights;
use crate::controller::verification_error::VerificationError;
use crate::controller::{ControllerError, in_step};
use crate::linalg::c64;
use crate::lti::connect::{append, lower_lft};
use crate::lti::{Discrete, StateSpace, TimeBase};
use crate::robust::structure::Structure as Blocks;
use crate::spindle::{Machine, Plant};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// What a polish is asked to do.
#[derive(Clone, Debug, PartialEq)]
pub struct PolishSettings {
    /// Limits.
    pub limits: LoopLimits,
    /// Rounds of descent.
    pub rounds: usize,
    /// Steps of one round at most.
    pub steps: usize,
    /// Multiple of the top speed up to which the loop has to be stable.
    pub overspeed: f64,
}

/// A round of the polish.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolishRound {
    /// Steps tried.
    pub steps: usize,
    /// Lines of the loss.
    pub lines: usize,
    /// Smallest stiffness of the tool at the end over rest, top speed and shifted rotors as weighted in the loss, N/m.
    pub stiffness_n_per_m: f64,
    /// Largest ratio of a quantity to its limit: sensitivity, high-frequency gain, noise current, specification.
    pub over_limit: [f64; super::loss::LIMITS],
}

/// A polished controller of one plane.
#[derive(Clone, Debug)]
pub struct Polish {
    /// The controller, A/m, own poles inside the circle.
    pub plane: StateSpace<Discrete>,
    /// What the loss said of the start.
    pub start: PolishRound,
    /// Rounds.
    pub rounds: Vec<PolishRound>,
}

/// Lines closer than these shares of their frequency are one, in the first rounds and in the last.
const COARSE: f64 = 2e-3;
const FINE: f64 = 5e-4;

/// Polishes the sampled controller `start` of one plane (signals m to currents A) of a machine.
///
/// `modes` are the uncertain modes of the specification `weights`; `mode_uncertainty` is widened by the gyroscopic split of the
/// top speed for the rotors with shifted modes.
///
/// # Errors
/// [`VerificationError`] from plants and eigenvalues, [`ControllerError::Infeasible`] when the start does not stabilise the
/// machine at rest.
pub fn polish(
    machine: &Machine,
    weights: &Weights,
    modes: &[UncertainMode],
    start: &StateSpace<Discrete>,
    settings: &PolishSettings,
) -> Result<Polish, VerificationError> {
    let numeric = in_step("polish");
    let top = machine.spindle.max_rpm * TAU / 60.0;
    let covered = machine.spindle.flexible_modes + 2;
    let relative: Vec<f64> = gyroscopic_split(&isotropic(machine), top, covered)?
        .iter()
        .enumerate()
        .map(|(k, s)| s.relative() + weights.mode_uncertainty.get(k).copied().unwrap_or(0.0))
        .collect();
    let plants = Plants::new(machine, settings.overspeed, &shifts(&relative))?;
    let sampled: Result<Vec<StateSpace<Discrete>>, _> =
        [Role::Rest, Role::TopSpeed, Role::Overspeed]
            .into_par_iter()
            .filter_map(|role| plants.of(role).next())
            .map(Plant::sampled)
            .collect();
    let sampled = sampled?;
    let (law, mut x) = ModalLaw::of(start)?;
    let mut limits = settings.limits;
    let mut best: Option<(f64, Vec<f64>)> = None;
    let mut report = Polish {
        plane: start.clone(),
        start: PolishRound {
            steps: 0,
            lines: 0,
            stiffness_n_per_m: f64::NAN,
            over_limit: [f64::NAN; 4],
        },
        rounds: vec![],
    };
    for round in 0..=settings.rounds {
        let (poles, rates) = loop_poles(&sampled, &law.system(&x).map_err(&numeric)?)?;
        if round == 0 && rates[0] >= 0.0 {
            return Err(infeasible("the start does not levitate the machine at rest").into());
        }
        // The last round sees the sharpest peaks.
        let apart = if round + 1 < settings.rounds {
            COARSE
        } else {
            FINE
        };
        let lines = lines(&plants, 1.0, &poles, apart);
        let specification = specification_of(&plants, &lines, (modes, weights))?;
        let rotors = plants.on(&lines);
        let mut loss = Loss::new(
            lines,
            rotors,
            Some(specification),
            limits,
            plants.period_s(),
        );
        let found = loss.evaluate(&law, &x);
        for r in 0..loss.active.len() {
            loss.active[r] = found.turns[r] == found.turns[0];
        }
        let mut found = loss.evaluate(&law, &x);
        loss.rescale(&mut found);
        let figures = figures(&loss, &found, 0);
        let merit = found.merit(super::descent::PENALTY);
        let stable = rates.iter().all(|r| *r < 0.0);
        if round == 0 {
            report.start = figures;
        } else if let Some(last) = report.rounds.last_mut() {
            // Judged on the lines round its own poles.
            let steps = last.steps;
            *last = PolishRound { steps, ..figures };
        }
        if best.as_ref().is_none_or(|(m, _)| stable && merit < *m) {
            best = Some((merit, x.clone()));
        }
        if round == settings.rounds {
            break;
        }
        if round > 0 {
            // A limit that the first round could not reach is kept where it is.
            for (limit, over) in [
                (&mut limits.sensitivity, figures.over_limit[0]),
                (
                    &mut limits.high_frequency_gain_a_per_m,
                    figures.over_limit[1],
                ),
                (&mut limits.noise_current_a, figures.over_limit[2]),
                (&mut limits.mu, figures.over_limit[3]),
            ] {
                if over > 1.01 {
                    *limit *= over;
                }
            }
            loss.limits = limits;
        }
        let effort = Effort {
            steps: settings.steps,
            tolerance: 1e-3,
        };
        let done = descend(&mut loss, &law, &mut x, &effort)?;
        report.rounds.push(PolishRound {
            steps: done,
            ..figures
        });
    }
    if let Some((_, x)) = best {
        report.plane = law.system(&x).map_err(&numeric)?;
    }
    Ok(report)
}

/// The specification on lines, modal channels not scaled yet.
pub(super) fn specification_of(
    plants: &Plants,
    lines: &[Line],
    (modes, weights): (&[UncertainMode], &Weights),
) -> Result<Specification, VerificationError> {
    let integral = if weights.integral_corner_hz.is_some() {
        LOOPS
    } else {
        0
    };
    let mut blocks = vec![Block::ComplexScalar { n: 1 }; modes.len()];
    blocks.push(Block::ComplexFull {
        rows: LOADS + LOOPS,
        cols: LOADS + LOOPS + integral,
    });
    let rows = plants
        .specification(lines, modes, weights)
        .map_err(in_step("weights of the polish"))?;
    Ok(Specification {
        scales: rows.iter().map(|_| vec![1.0; blocks.len()]).collect(),
        lines: rows,
        blocks: Blocks::new(&blocks)
            .map_err(|_| infeasible("the specification has no channels"))?,
    })
}

fn figures(loss: &Loss, found: &super::loss::Evaluation, steps: usize) -> PolishRound {
    let groups = [
        Group::Sensitivity,
        Group::HighGain,
        Group::NoiseCurrent,
        Group::Specification,
    ];
    PolishRound {
        steps,
        lines: loss.lines.len(),
        stiffness_n_per_m: 1e6 * (-found.largest(Group::Compliance)).exp(),
        over_limit: groups.map(|g| found.largest(g).exp()),
    }
}

/// Poles of the loops as continuous ones, rad/s, and the largest growth rate of each, 1/s.
fn loop_poles(
    sampled: &[StateSpace<Discrete>],
    plane: &StateSpace<Discrete>,
) -> Result<(Vec<c64>, Vec<f64>), ControllerError> {
    let both = append(plane, plane);
    // Signals front_x, rear_x, front_y, rear_y back in the order of the plant.
    let order = [0usize, 2, 1, 3];
    let law = both.select(&order, &order);
    let found: Result<Vec<Vec<c64>>, _> = sampled
        .par_iter()
        .map(|plant| {
            let axes = [0, 1, 2, 3];
            lower_lft(&plant.select(&axes, &axes), &law)?.poles()
        })
        .collect();
    let found = found.map_err(in_step("poles of the polished loop"))?;
    let period = plane.time.period_s;
    let rates = found
        .iter()
        .map(|poles| {
            poles
                .iter()
                .map(|z| plane.time.growth_rate(*z))
                .fold(f64::NEG_INFINITY, f64::max)
        })
        .collect();
    // Beyond the top speed only stability counts.
    let equivalent = found
        .iter()
        .take(2)
        .flatten()
        .filter(|z| z.norm() > 1e-6)
        .map(|z| z.ln() / period)
        .filter(|p| p.im > 0.0)
        .collect();
    Ok((equivalent, rates))
}

fn infeasible(reason: &str) -> ControllerError {
    ControllerError::Infeasible {
        step: "polish",
        reason: reason.to_owned(),
        advice: "the controller of the D-K iteration is delivered as it is",
    }
}
