//! Whitened residuals of a set of effects, and their derivatives to nuisance parameters and effects in closed form.
//!
//! Lines do not depend on each other: they are computed in parallel and joined in order.

use super::super::DiagnoseError;
use super::super::data::covariance::{reciprocals, whiten_vector, whiten_with};
use super::columns::{PredictedLine, order};
use super::hypothesis::{self, Hypothesis};
use super::jacobian::Jacobian;
use super::problem::{Point, Problem};
use crate::linalg::{Mat, c64};
use crate::spindle::response::probe::Probe;
use crate::spindle::response::term::Number;
use crate::spindle::response::{Assembled, Assembly, LineSlopes, Receptance, SIDE, Square, ZERO};
use crate::spindle::{Effect, EffectKind};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Lines computed in one piece.
const PIECE: usize = 16;
/// Real residuals of a line of a sweep and of a hammer test.
const HEIGHT: (usize, usize) = (32, 2);

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Record {
    Sweep(usize),
    HammerTest(usize),
}

impl Record {
    fn height(self) -> usize {
        match self {
            Self::Sweep(_) => HEIGHT.0,
            Self::HammerTest(_) => HEIGHT.1,
        }
    }
}

/// A frequency at a speed, and the lines of the records that were measured there.
struct LineTask {
    speed: usize,
    omega: f64,
    lines: Vec<(Record, usize)>,
}

#[derive(Clone, Copy)]
enum Wanted<'a> {
    /// None.
    Residual,
    /// Those to the last effect.
    Newest,
    /// Those to everything.
    All,
    /// Those to effects that have no size yet.
    Beside(&'a [Hypothesis]),
}

pub(crate) struct Linearised {
    /// Whitened residuals.
    pub residual: Vec<f64>,
    /// Derivatives of the prediction.
    pub jacobian: Jacobian,
    /// Receptance of the shaft at every line.
    pub shaft: Vec<Receptance>,
}

impl Problem<'_> {
    fn speeds(&self) -> Vec<f64> {
        let sweeps = self.evidence.sweeps.iter();
        let taps = self.evidence.taps.iter().filter(|_| self.usage.taps);
        let sweeps = sweeps.map(|s| (s.speed_rad_s, s.omega_rad_s.len()));
        let all = sweeps.chain(taps.map(|t| (t.speed_rad_s, t.omega_rad_s.len())));
        let all = all.filter(|(_, lines)| *lines > 0).map(|(speed, _)| speed);
        let mut speeds: Vec<f64> = all.collect();
        speeds.sort_by(f64::total_cmp);
        speeds.dedup();
        speeds
    }

    /// Every line of every record with the first of its rows among the residuals.
    pub(crate) fn rows(&self) -> Vec<(Record, usize, usize)> {
        let mut next = 0;
        let tasks = self.tasks(&self.speeds()).into_iter();
        let lines = tasks.flat_map(|task| task.lines);
        lines
            .map(|(record, line)| {
                let first = next;
                next += record.height();
                (record, line, first)
            })
            .collect()
    }

    fn tasks(&self, speeds: &[f64]) -> Vec<LineTask> {
        let index = |speed: f64| speeds.iter().position(|s| *s == speed).unwrap_or_default();
        // Positive numbers have the order of their bits.
        let mut tasks: BTreeMap<(usize, u64), Vec<(Record, usize)>> = BTreeMap::new();
        let mut add = |record: Record, speed: f64, lines: &[f64]| {
            for line in (0..lines.len()).step_by(self.usage.stride) {
                let key = (index(speed), lines[line].to_bits());
                tasks.entry(key).or_default().push((record, line));
            }
        };
        for (s, sweep) in self.evidence.sweeps.iter().enumerate() {
            add(Record::Sweep(s), sweep.speed_rad_s, &sweep.omega_rad_s);
        }
        for (t, tap) in self.evidence.taps.iter().enumerate() {
            if self.usage.taps {
                add(Record::HammerTest(t), tap.speed_rad_s, &tap.omega_rad_s);
            }
        }
        tasks
            .into_iter()
            .map(|((speed, omega), lines)| LineTask { speed, omega: f64::from_bits(omega), lines })
            .collect()
    }

    /// Whitened residuals (real and imaginary parts, times √2) at a point.
    ///
    /// # Errors
    /// [`DiagnoseError`] when the model cannot be assembled.
    pub fn residual(&self, at: &Point, model_error: f64) -> Result<Vec<f64>, DiagnoseError> {
        let all = self.evaluate_records(at, model_error, Wanted::Residual, None)?;
        Ok(all.residual)
    }

    /// Residuals, Jacobian of the model (∂prediction, whitened) and receptances of the shaft at a point.
    pub(super) fn linearise_records(&self, at: &Point, model_error: f64) -> Result<Linearised, DiagnoseError> {
        self.evaluate_records(at, model_error, Wanted::All, None)
    }

    /// The same with derivatives to the coordinates of the last effect only. Where that changes the electronics alone,
    /// the receptances of the shaft without it may be given.
    pub(crate) fn newest(
        &self,
        at: &Point,
        model_error: f64,
        shaft: Option<&[Receptance]>,
    ) -> Result<Linearised, DiagnoseError> {
        self.evaluate_records(at, model_error, Wanted::Newest, shaft)
    }

    /// Residuals at a point, and derivatives to further effects that have no size yet and are not assembled: one column
    /// per coordinate, the effects one behind the other. Not for joints and housings ([`assembled_with_size`]).
    pub(crate) fn beside(
        &self,
        at: &Point,
        model_error: f64,
        further: &[Hypothesis],
    ) -> Result<Linearised, DiagnoseError> {
        self.evaluate_records(at, model_error, Wanted::Beside(further), None)
    }

    /// Numbers of the effects that derivatives are wanted to, in fit coordinates.
    fn numbers(&self, effects: &[Effect], theta: &[Vec<f64>], wanted: Wanted, probes: &mut Vec<Probe>) -> Vec<Number> {
        let reduced = &self.model.reduced;
        let mut numbers = vec![];
        let mut add = |h: &Hypothesis, theta: &[f64], own: Vec<Number>| {
            let scaled = own.into_iter().enumerate();
            numbers.extend(scaled.map(|(i, number)| number.scale_number(h.slope(i, theta))));
        };
        let from = match wanted {
            Wanted::Residual | Wanted::Beside(_) => effects.len(),
            Wanted::Newest => effects.len().saturating_sub(1),
            Wanted::All => 0,
        };
        for e in from..effects.len() {
            let own = reduced.sensitivity(effects, e, probes);
            add(&self.effects[e], &theta[e], own);
        }
        if let Wanted::Beside(further) = wanted {
            for h in further {
                let theta = h.nothing();
                let mut with = effects.to_vec();
                with.push(h.effect(&theta));
                let own = reduced.sensitivity(&with, effects.len(), probes);
                add(h, &theta, own);
            }
        }
        numbers
    }

    fn evaluate_records(
        &self,
        at: &Point,
        model_error: f64,
        wanted: Wanted,
        shaft: Option<&[Receptance]>,
    ) -> Result<Linearised, DiagnoseError> {
        let (model, speeds) = (self.model, self.speeds());
        let all = matches!(wanted, Wanted::All);
        let layout = all.then_some(&model.layout);
        let effects = hypothesis::effects(self.effects, &at.theta);
        let mut probes = vec![];
        let mut numbers = self.numbers(&effects, &at.theta, wanted, &mut probes);
        // The readings of planes between nodes, nuisance parameters that an effect may switch on.
        let coordinates = numbers.len();
        let mut readings = [None; 4];
        if all {
            for (plane, number) in model.reduced.readings(&effects, &mut probes)? {
                readings[plane] = Some(numbers.len());
                numbers.push(number);
            }
        }
        let known = shaft.map(|shaft| (shaft, model.reduced.effective(&at.p, &effects)));
        let strained = layout.is_some() || numbers.iter().any(Number::bends);
        let assemble = |speed: &f64| {
            model.reduced.assemble(
                &at.p,
                Assembly {
                    effects: &effects,
                    speed_rad_s: *speed,
                    derivatives: strained,
                    masses_at_ports: model.masses_at_ports,
                    further: &[],
                    probes: &probes,
                },
            )
        };
        let models: Vec<Assembled> = match known {
            Some(_) => vec![],
            None => speeds.iter().map(assemble).collect::<Result<_, _>>()?,
        };
        let line = |t: usize, task: &LineTask| match &known {
            Some((shaft, electronics)) => LineSlopes::around_frequency(&shaft[t], electronics, task.omega, &numbers),
            None => {
                let own = &models[task.speed];
                let first = own.ports() - probes.len();
                own.line_slopes(task.omega, layout.map(|l| &l.machine), first, &numbers)
            }
        };
        let tasks = self.tasks(&speeds);
        let order = order(layout, coordinates, &readings);
        let width = order.len();
        let pieces: Vec<(Vec<f64>, Mat<f64>, Vec<Receptance>)> = tasks
            .par_chunks(PIECE)
            .enumerate()
            .map(|(first, piece)| {
                let records = piece.iter().flat_map(|t| &t.lines);
                let height = records.map(|(record, _)| record.height()).sum();
                let mut r = Vec::with_capacity(height);
                let mut block = Mat::zeros(height, width);
                let mut shaft = Vec::with_capacity(piece.len());
                for (t, task) in piece.iter().enumerate() {
                    let line = line(first * PIECE + t, task);
                    let predicted = PredictedLine { line: &line, order: &order, p: &at.p, model_error };
                    let mut rows = ResidualRows { residual: &mut r, block: &mut block };
                    for (record, line) in &task.lines {
                        self.compare(*record, *line, &predicted, &mut rows);
                    }
                    shaft.push(line.receptance);
                }
                (r, block, shaft)
            })
            .collect();
        let (mut residual, mut blocks, mut shaft) = (vec![], vec![], vec![]);
        for (r, block, receptances) in pieces {
            residual.extend(r);
            blocks.push(block);
            shaft.extend(receptances);
        }
        let smooth = self.smooth(model_error)?;
        if let Some(smooth) = &smooth {
            smooth.apply(&mut residual, 0.0, at.smooth);
        }
        let smooth = smooth.map(|smooth| (smooth, at.smooth));
        Ok(Linearised { residual, jacobian: Jacobian::new(blocks, width, smooth.filter(|_| width > 0)), shaft })
    }

    /// Appends the whitened residual of a line, and its derivatives in `order`.
    fn compare(&self, record: Record, line: usize, predicted: &PredictedLine, rows: &mut ResidualRows) {
        let (f, p) = (&predicted.line.response, predicted.p);
        let first = rows.residual.len();
        match record {
            Record::Sweep(s) => {
                if let Some(levitation) = self.find_levitation(predicted.model_error) {
                    return self.compare_levitated(s, line, levitation, predicted, rows);
                }
                let sweep = &self.evidence.sweeps[s];
                let triangles = sweep.whitening(line, predicted.model_error, self.usage.off_diagonal);
                let g = &sweep.response[line];
                let gain: [f64; 4] = std::array::from_fn(|i| 1.0 + p[self.model.layout.axis(s, i)]);
                for i in 0..4 {
                    let mut d: [c64; 4] = std::array::from_fn(|j| g[4 * i + j] - f[SIDE * i + j] * gain[i]);
                    whiten_vector(&triangles[i], &mut d);
                    push(rows.residual, &d);
                }
                let pivots = triangles.each_ref().map(reciprocals);
                let seen = |change: &Square, gain: &[f64; 4]| {
                    let mut all = [ZERO; 16];
                    for (i, all) in all.chunks_exact_mut(4).enumerate() {
                        let mut d: [c64; 4] = std::array::from_fn(|j| change[SIDE * i + j] * gain[i]);
                        whiten_with(&triangles[i], &pivots[i], &mut d);
                        all.copy_from_slice(&d);
                    }
                    all
                };
                predicted.write(Some(s), &gain, seen, rows.block, first);
            }
            Record::HammerTest(t) => {
                let tap = &self.evidence.taps[t];
                let sd = tap.sd(line, predicted.model_error);
                let (h, left, right) = tap.close(line, f);
                push(rows.residual, &[(tap.compliance[line] - h) / sd]);
                let seen = |change: &Square, _: &[f64; 4]| {
                    let mut sum = ZERO;
                    for (left, row) in left.iter().zip(change.chunks_exact(SIDE)) {
                        let along = row.iter().zip(&right);
                        sum += left * along.fold(ZERO, |sum, (d, right)| sum + d * right);
                    }
                    [sum / sd]
                };
                predicted.write(None, &[1.0; 4], seen, rows.block, first);
            }
        }
    }
}

/// Whether effects of a kind have to be assembled before responses can be differentiated to them: a joint makes another
/// shaft, a housing has a frequency, an amplifier takes the place of another one.
pub(crate) fn assembled_with_size(kind: EffectKind) -> bool {
    matches!(kind, EffectKind::ToolJoint | EffectKind::HousingMode | EffectKind::AmplifierSecondOrder)
}

/// Residuals, and their derivatives in the rows that begin with them.
pub(super) struct ResidualRows<'a> {
    pub(super) residual: &'a mut Vec<f64>,
    pub(super) block: &'a mut Mat<f64>,
}

pub(super) fn push(all: &mut Vec<f64>, values: &[c64]) {
    for v in values {
        all.push(std::f64::consts::SQRT_2 * v.re);
        all.push(std::f64::consts::SQRT_2 * v.im);
    }
}
